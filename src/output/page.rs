//! Template of every page: one file that asks nothing of a network and says so in its content security policy. All text that a user
//! wrote is escaped.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use sha2::{Digest, Sha256};

use super::maps;
use super::plot::{Axis, Figure, SIZE};

const STYLE: &str = include_str!("page.css");

/// A page. `script`: allowed by its hash; empty for none.
pub(crate) fn page(title: &str, script: &str, body: &Markup) -> String {
    let hash = BASE64_STANDARD.encode(Sha256::digest(script));
    let policy = format!(
        "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{hash}'; base-uri 'none'; form-action 'none'"
    );
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(PreEscaped(policy));
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                link rel="icon" href="data:,";
                title { (title) " – ripstop" }
                style { (PreEscaped(STYLE.replace("GRADIENT", &maps::gradient()))) }
            }
            body {
                main { (body) }
                @if !script.is_empty() { script { (PreEscaped(script)) } }
            }
        }
    };
    page.into_string() + "\n"
}

/// A table under these heads; the first cell of a row is its head.
pub(crate) fn table(class: &str, heads: &[&str], rows: impl IntoIterator<Item = Vec<Markup>>) -> Markup {
    html! {
        div class="scroll" tabindex="0" {
            table class=(class) {
                @if !heads.is_empty() { thead { tr { @for head in heads { th scope="col" { (head) } } } } }
                tbody {
                    @for cells in rows {
                        tr { @for (n, cell) in cells.iter().enumerate() {
                            @if n == 0 { th scope="row" { (cell) } } @else { td { (cell) } }
                        } }
                    }
                }
            }
        }
    }
}

/// A figure with its words for those who do not see it, the axes from which the script reads values, and its legend.
pub(crate) fn figure(figure: &Figure) -> Markup {
    let Figure { id, title, caption, plot } = figure;
    let Some(plot) = plot else {
        return html! { p class="plot nothing" id=(id) { b { (title) ":" } " " (caption) } };
    };
    let data = |axis: &Axis| {
        let [[from, to], [start, end]] = [axis.range(), axis.paper];
        format!("{from} {to} {start} {end}")
    };
    let [width, height] = SIZE;
    html! {
        figure class="plot" id=(id) {
            figcaption { h3 { (title) } p { (caption) } }
            svg viewBox={ "0 0 " (width) " " (height) } role="img" aria-labelledby={ (id) "-t " (id) "-d" }
                data-time=[plot.over_time.then(|| data(&plot.x))] data-x=(data(&plot.x)) data-y=(data(&plot.y)) {
                title id={ (id) "-t" } { (title) }
                desc id={ (id) "-d" } { (caption) }
                (PreEscaped(plot.drawing()))
            }
            @if !plot.legend.is_empty() {
                ul class="legend" { @for (class, words) in &plot.legend { li { i class=(class) {} (words) } } }
            }
        }
    }
}
