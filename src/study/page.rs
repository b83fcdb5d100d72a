//! Pages in one file that ask nothing of a network: the frame, tables, drawings beside each other.

use super::arithmetic_v50::{Arithmetic, Refusal, Rule};
use super::fit::draw::PANEL;
use super::fit::{Quantile, refusal, rule, too_few};
use super::residual_fit::{ResidualFit, ResidualModel, TooFew};
use crate::output::chart::{self, escape};
use crate::output::number::short;

/// A page of shots. `numbers`: the file that holds every number.
pub(super) fn document(title: &str, body: &str, numbers: &str) -> String {
    framed(title, PAGE, body, &format!("All numbers are in {numbers}."))
}

/// A page. `last`: what stands in its last line.
pub(super) fn framed(title: &str, style: &str, body: &str, last: &str) -> String {
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; \
         base-uri 'none'; form-action 'none'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n\
         <title>{title} – ripstop</title>\n<style>{style}{}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{body}\
         <p class=\"note\">ripstop {}. {last}</p>\n</body>\n</html>\n",
        chart::STYLE,
        env!("CARGO_PKG_VERSION"),
    )
}

/// Sentences that a reader should know.
pub(super) fn remarks(sentences: &[String]) -> String {
    sentences.iter().map(|sentence| format!("<p class=\"note\">{}.</p>\n", escape(sentence))).collect()
}

/// Drawings beside each other, each with its name.
pub(super) fn figures<'a>(panels: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let [width, height] = PANEL;
    let figure = |(name, drawing): (&str, String)| {
        let name = escape(name);
        format!(
            "<figure><svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{name}\">\n{drawing}</svg></figure>\n"
        )
    };
    format!("<div class=\"plots\">\n{}</div>\n", panels.into_iter().map(figure).collect::<String>())
}

/// A table under a heading of second order.
pub(super) fn table(title: &str, heads: &[&str], rows: &str) -> String {
    table_under("h2", title, heads, rows)
}

/// The same; nothing where there is no row.
pub(super) fn filled_table(title: &str, heads: &[&str], rows: &str) -> String {
    if rows.is_empty() { String::new() } else { table(title, heads, rows) }
}

/// A table under a heading of this order.
pub(super) fn table_under(heading: &str, title: &str, heads: &[&str], rows: &str) -> String {
    let heads: String = heads.iter().map(|head| format!("<th scope=\"col\">{}</th>", escape(head))).collect();
    format!(
        "<{heading}>{title}</{heading}>\n<div class=\"scroll\" tabindex=\"0\"><table>\n<thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n"
    )
}

/// A row of a table.
pub(super) fn row(cells: &[String]) -> String {
    let cell = |(n, cell): (usize, &String)| {
        // Signs of numbers, not what joins words.
        let cell = if cell.parse::<f64>().is_ok() { cell.replace('-', "−") } else { cell.clone() };
        let cell = escape(&cell);
        if n == 0 { format!("<th scope=\"row\">{cell}</th>") } else { format!("<td>{cell}</td>") }
    };
    format!("<tr>{}</tr>\n", cells.iter().enumerate().map(cell).collect::<String>())
}

/// The velocity of a chance and its interval, under a name.
pub(super) fn quantile_row(name: String, quantile: &Quantile) -> String {
    let value = quantile.value.map_or_else(String::new, |value| short(value, 5));
    let [low, high] = quantile.bounds.words();
    row(&[name, value, low, high])
}

/// The arithmetic V50 of each rule.
pub(super) fn arithmetic_table(title: &str, rules: &[(Rule, Result<Arithmetic, Refusal>)]) -> String {
    let one = |(of, found): &(Rule, Result<Arithmetic, Refusal>)| {
        let (value, why) = match found {
            Ok(found) => (short(found.mean, 5), format!("spread {} m/s", short(found.spread, 3))),
            Err(why) => ("none".to_owned(), refusal(why)),
        };
        row(&[rule(of), of.standard.to_owned(), value, why])
    };
    table(title, &["rule", "standard", "V50 [m/s]", ""], &rules.iter().map(one).collect::<String>())
}

/// The curves through residual velocities. `limit`: what their limit is called.
pub(super) fn residual_table(
    title: &str,
    limit: &str,
    curves: &[(ResidualModel, Result<ResidualFit, TooFew>)],
) -> String {
    let one = |(curve, found): &(ResidualModel, Result<ResidualFit, TooFew>)| {
        let name = curve.words().to_owned();
        match found {
            Ok(found) => {
                let [factor, exponent, scatter] = [found.factor, found.exponent, found.scatter].map(|x| short(x, 4));
                let [low, high] = found.bounds.words();
                row(&[name, short(found.limit, 5), low, high, factor, exponent, scatter])
            }
            Err(few) => row(&[name, too_few(few)]),
        }
    };
    let heads = ["curve", limit, "low [m/s]", "high [m/s]", "a", "p", "scatter [m/s]"];
    table(title, &heads, &curves.iter().map(one).collect::<String>())
}

const PAGE: &str = "
:root { color-scheme: light; --line: #d5dbe3; --soft: #566273 }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 70em; margin: 1.5em auto; padding: 0 1em; color: #17202b; background: #fff }
h1 { font-size: 1.5rem; overflow-wrap: anywhere } h2 { font-size: 1.15rem; margin: 1.8em 0 .5em } .answer { font-size: 1.1rem }
table { border-collapse: collapse; font-size: .92rem } .scroll { overflow-x: auto }
th, td { text-align: right; padding: .3em 1em .3em 0; border-bottom: 1px solid var(--line); font-variant-numeric: tabular-nums }
th { font-weight: 500; color: var(--soft) } th:first-child { text-align: left; color: inherit } td:last-child { text-align: left }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 420px), 1fr)); gap: 12px }
figure { margin: 0 } figure svg { width: 100%; height: auto; font-size: 12px }
.note { color: var(--soft); font-size: .95rem }
@media print { figure, tr { break-inside: avoid } }
";
