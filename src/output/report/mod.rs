//! `report.html`: verdict of a run, checks, figures and playback. But for machine and timing, the same run gives the
//! same bytes.
//!
//! Every page is one file that asks nothing of a network and says so in its content security policy. All text that a user wrote is
//! escaped.

mod playback;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use serde_json::Value;
use sha2::{Digest, Sha256};

use super::animation::Animation;
use super::checks::{self, Check, Level, checks};
use super::expect::{Judgement, expected, got, judgement, note, quantity};
use super::figures::{self, behind, drawing, held};
use super::number::short;
use super::plot::{Axis, Figure, SIZE};
use super::summary::{Energies, costs, margins, residual_velocity, verdict};
use super::warnings::assumed_fields;
use crate::case::{self, Case};
use crate::run::Run;
use crate::run::outcome::Outcome;

const STYLE: &str = include_str!("page.css");
/// A folder has the other files of the run beside the page; a browser keeps none.
const HAS_FILES: bool = cfg!(not(target_family = "wasm"));
const SCRIPT: &str = concat!(include_str!("playback.js"), include_str!("values.js"));

/// The page. With less than two keyframes it has no playback.
pub fn report(case: &Case, run: &Run, summary: &Value, animation: &Animation) -> String {
    let animation = Some(animation).filter(|animation| animation.keyframes.len() > 1);
    let checks = checks(case, run);
    let strikes = case.projectile.is_some();
    let figures: [Option<Figure>; 7] = [
        strikes.then(|| figures::velocity(run)),
        strikes.then(|| figures::force(run)),
        animation.and_then(figures::deflection),
        Some(figures::energy(run)),
        Some(figures::failures(case, run)),
        figures::profiles(case, run),
        Some(figures::unit_cell(case)),
    ];
    let text = |key: &str| summary[key].as_str().unwrap_or_default();
    let version = format!("{}, case hash {}", text("version"), text("case_hash"));
    let costs = std::iter::once(("ripstop", version)).chain(costs(case, run, summary));
    let body = html! {
        (header(case, run, &checks))
        @if let Some(animation) = animation { (playback::player(case, animation)) }
        section id="plots" {
            h2 { "The shot in figures" }
            div class="plots" { @for one in figures.iter().flatten() { (figure(one)) } }
        }
        (trust(&checks, summary))
        (energy(run))
        (fields(case))
        section id="machine" {
            h2 { "Machine and timing" }
            (table("checks", &[], costs.map(|(name, value)| vec![cell(name), cell(value)])))
        }
        @if HAS_FILES { p class="note" { "Files beside this page: summary.json, history.csv, events.csv, case.json." } }
    };
    page(&case.title, SCRIPT, &body)
}

/// Verdict, its numbers, and whether to trust it.
fn header(case: &Case, run: &Run, checks: &[Check]) -> Markup {
    let verdict = verdict(case, run);
    let class = if verdict.complete { run.outcome.word() } else { "broken-off" };
    let (level, why) = checks::advice(checks);
    let (assumed, fields) = (assumed_fields(case).count(), case.fields.len());
    html! {
        header {
            p class="over" { (case.title) }
            h1 class={ "verdict " (class) } { (verdict.word) }
            p class="story" { (capital(&verdict.detail)) "." }
            dl class="figures" {
                @for (name, number, more) in numbers(case, run) { div { dt { (name) } dd { (number) " " small { (more) } } } }
            }
            p class={ "answer " (level.word()) } {
                // A mark for those who do not see colours.
                b { span aria-hidden="true" { (["✓", "▲", "✕"][level as usize]) } " " (capital(level.advice())) ":" } " "
                @if level == Level::Fine { "all " (checks.len()) " checks are fine." }
                @else { (why.iter().map(|check| check.name).collect::<Vec<_>>().join(", ")) "." }
                br;
                span {
                    @if assumed == 0 { "Every parameter has a published or measured source." }
                    @else { (assumed) " of " (fields) " parameters are assumed, not published: the answer is as good as they are." }
                }
                " " a href="#trust" { "Why" }
            }
        }
    }
}

fn capital(word: &str) -> String {
    let (first, rest) = word.split_at(1);
    first.to_uppercase() + rest
}

/// Name and number, and more on it.
fn numbers(case: &Case, run: &Run) -> Vec<(&'static str, String, String)> {
    let mut all = Vec::new();
    if let (Some(projectile), Some(left)) = (&case.projectile, residual_velocity(case, run)) {
        let name = if run.outcome == Outcome::Perforated { "leaves at" } else { "velocity left" };
        let struck = format!("of {} m/s", short(projectile.velocity, 4));
        let speed = |name, v| (name, format!("{} m/s", short(v, 3)), struck.clone());
        all.push(speed(name, left));
        all.extend(run.rebound_velocity.map(|v| speed("rebound velocity", v)));
        all.extend(run.carried_velocity.map(|v| speed("carried along at", v)));
    }
    all.extend(margins(case, run));
    all.push(("largest deflection", format!("{} mm", short(run.deflection() * 1e3, 3)), String::new()));
    if run.plies > 1 {
        let through = run.history.last().map_or(0, |row| row.perforated_plies);
        all.push(("plies perforated", format!("{through} of {}", run.plies), String::new()));
    }
    all
}

/// A word with the colour of a level.
fn level(class: &str, word: &str) -> Markup {
    html! { span class={ "level " (class) } { (word) } }
}

fn cell(text: impl AsRef<str>) -> Markup {
    html! { (text.as_ref()) }
}

/// Checks with their reasons, and expectations of the case.
fn trust(checks: &[Check], summary: &Value) -> Markup {
    let row = |check: &Check| {
        let level = level(check.level.word(), check.level.advice());
        vec![cell(check.name), cell(&check.value), level, cell(&check.reason)]
    };
    let expect: Vec<&Value> = summary["expect"].as_array().into_iter().flatten().collect();
    let expected_row = |check: &&Value| {
        let (class, word) = match judgement(check) {
            Judgement::Holds => ("fine", "holds"),
            Judgement::Known => ("bad", "known difference"),
            Judgement::Fails => ("bad", "fails"),
        };
        let found = format!("{}, expected {}", got(check), expected(check));
        let why = format!("{} {}", check["source"].as_str().unwrap_or_default(), note(check));
        vec![cell(quantity(check)), cell(found), level(class, word), cell(why.trim())]
    };
    html! {
        section id="trust" {
            h2 { "Is this run to be trusted?" }
            (table("checks", &["check", "found", "level", "why"], checks.iter().map(row)))
            @if !expect.is_empty() {
                h3 { "What the case expects" }
                (table("checks", &[], expect.iter().map(expected_row)))
            }
        }
    }
}

/// Energies at the end.
fn energy(run: &Run) -> Markup {
    let Some(energies) = Energies::of(run) else { return Markup::default() };
    let row =
        |(name, energy): &(&str, f64)| vec![cell(name), cell(energies.text(*energy)), cell(energies.percent(*energy))];
    let from = energies.sources.iter().map(|(name, energy)| format!("{name} {}", energies.text(*energy)));
    html! {
        section id="spent" {
            h2 { "Where the energy went" }
            p { "Given to the fabric: " (from.collect::<Vec<_>>().join(", ")) "." }
            (table("checks", &["given to the fabric", &energies.text(energies.given), ""], energies.shares.iter().map(row)))
        }
    }
}

/// Fields of the case, as `ripstop check` lists them, those that are assumed marked.
fn fields(case: &Case) -> Markup {
    let mesh = case::mesh(case);
    let row = |field: &case::Field| {
        let name = html! { @if field.assumed { "* " } code { (field.pointer) } };
        let source = html! { @if field.assumed { b { (field.source) } } @else { (field.source) } };
        vec![name, cell(field.with_unit()), cell(field.origin.word()), source]
    };
    html! {
        section id="case" {
            h2 { "The case as read" }
            p { @for (n, line) in mesh.lines().enumerate() { @if n > 0 { br; } (line) } }
            figure class="plot plan" id="plan" {
                figcaption { h3 { "Fixture" } p { "Held: " (held(case)) ". Behind the pack: " (behind(case)) ". Lines across the middle: warps; circle: aim." } }
                (PreEscaped(drawing(case)))
            }
            p class="printed" {
                b { "Assumed, not published: " }
                @for (n, field) in assumed_fields(case).enumerate() { @if n > 0 { ", " } (field.pointer) " " (field.with_unit()) }
            }
            details {
                summary { "All " (case.fields.len()) " fields" }
                p class="note" {
                    "Fields marked * are assumed."
                    @if HAS_FILES { " " code { "case.json" } " beside this page computes the same again." }
                }
                (table("fields", &["field", "value", "origin", "source"], case.fields.iter().map(row)))
            }
        }
    }
}

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
                style { (PreEscaped(STYLE.replace("GRADIENT", &playback::gradient()))) }
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
        let [[from, to], [start, end]] = [axis.range, axis.paper];
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
