//! Pages of shots: the tables and figures that they share.

use maud::{Markup, html};

use super::arithmetic_v50::{Arithmetic, Refusal, Rule};
use super::fit::{Quantile, refusal, rule, too_few};
use super::residual_fit::{ResidualFit, ResidualModel, TooFew};
use crate::output::number::short;
use crate::output::page::{self, figure, page};
use crate::output::plot::Figure;

/// A page of shots. `numbers`: the file that holds every number.
pub(super) fn document(title: &str, body: &Markup, numbers: &str) -> String {
    let body = html! {
        h1 { (title) }
        (body)
        p class="note" { "ripstop " (env!("CARGO_PKG_VERSION")) ". All numbers are in " (numbers) "." }
    };
    page(title, "", &body)
}

/// Sentences that a reader should know.
pub(super) fn remarks(sentences: &[String]) -> Markup {
    html! { @for sentence in sentences { p class="note" { (sentence) "." } } }
}

/// Figures beside each other.
pub(super) fn figures(figures: &[Figure]) -> Markup {
    html! { div class="plots" { @for one in figures { (figure(one)) } } }
}

/// A table under a heading; nothing where there is no row.
pub(super) fn table(title: &str, heads: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Markup {
    let rows: Vec<Vec<String>> = rows.into_iter().collect();
    // Signs of numbers, not what joins words.
    let minus = |text: String| if text.parse::<f64>().is_ok() { text.replace('-', "−") } else { text };
    let cells = |row: Vec<String>| row.into_iter().map(|text| html! { (minus(text)) }).collect();
    html! {
        @if !rows.is_empty() {
            h2 { (title) }
            (page::table("numbers", heads, rows.into_iter().map(cells)))
        }
    }
}

/// The velocity of a chance and its interval, under a name.
pub(super) fn quantile_row(name: String, quantile: &Quantile) -> Vec<String> {
    let [low, high] = quantile.bounds.words();
    vec![name, quantile.value.map_or_else(String::new, |value| short(value, 5)), low, high]
}

/// The arithmetic V50 of each rule.
pub(super) fn arithmetic_table(title: &str, rules: &[(Rule, Result<Arithmetic, Refusal>)]) -> Markup {
    let row = |(of, found): &(Rule, Result<Arithmetic, Refusal>)| {
        let (value, why) = match found {
            Ok(found) => (short(found.mean, 5), format!("spread {} m/s", short(found.spread, 3))),
            Err(why) => ("none".to_owned(), refusal(why)),
        };
        vec![rule(of), of.standard.to_owned(), value, why]
    };
    table(title, &["rule", "standard", "V50 [m/s]", ""], rules.iter().map(row))
}

/// The curves through residual velocities. `limit`: name of their limit.
pub(super) fn residual_table(
    title: &str,
    limit: &str,
    curves: &[(ResidualModel, Result<ResidualFit, TooFew>)],
) -> Markup {
    let row = |(curve, found): &(ResidualModel, Result<ResidualFit, TooFew>)| {
        let name = curve.words().to_owned();
        match found {
            Ok(found) => {
                let [factor, exponent, scatter] = [found.factor, found.exponent, found.scatter].map(|x| short(x, 4));
                let [low, high] = found.bounds.words();
                vec![name, short(found.limit, 5), low, high, factor, exponent, scatter]
            }
            Err(few) => vec![name, too_few(few)],
        }
    };
    let heads = ["curve", limit, "low [m/s]", "high [m/s]", "a", "p", "scatter [m/s]"];
    table(title, &heads, curves.iter().map(row))
}
