//! `fit.html`: tables and figures in one file that asks nothing of a network.

use super::draw::{PANEL, STYLE as DRAWING, panels};
use super::text::{notes, refusal, rule, too_few};
use super::{Fit, Quantile};
use crate::output::chart::escape;
use crate::output::number::short;

/// The page. `title`: what was fitted.
pub fn html(fit: &Fit, title: &str) -> String {
    document(&format!("Ballistic limit: {title}"), &sections(fit), "fit.json")
}

/// What the fit says, without a page around it.
pub(in crate::study) fn sections(fit: &Fit) -> String {
    let mut body = format!("<p class=\"answer\">{}</p>\n", escape(&answer(fit)));
    for note in notes(fit) {
        body += &format!("<p class=\"note\">{}.</p>\n", escape(&note));
    }
    body += &figures(panels(fit));
    body += &quantiles(fit);
    body += &arithmetic(fit);
    body + &residual(fit)
}

/// Drawings beside each other, each with its name.
pub(in crate::study) fn figures<'a>(panels: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let [width, height] = PANEL;
    let mut body = "<div class=\"plots\">\n".to_owned();
    for (name, drawing) in panels {
        let name = escape(name);
        body += &format!(
            "<figure><svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{name}\">\n{drawing}</svg></figure>\n"
        );
    }
    body + "</div>\n"
}

/// A page that asks nothing of a network. `numbers`: the file that holds every number.
pub(in crate::study) fn document(title: &str, body: &str, numbers: &str) -> String {
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; \
         base-uri 'none'; form-action 'none'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<link rel=\"icon\" href=\"data:,\">\n\
         <title>{title} – ripstop</title>\n<style>{PAGE}{DRAWING}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{body}\
         <p class=\"note\">ripstop {}. All numbers are in {numbers}.</p>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION"),
    )
}

/// V50 and σ in one sentence.
fn answer(fit: &Fit) -> String {
    let [perforated, stopped] = fit.outcomes.counts();
    let shots = format!("{} shots: {perforated} perforated, {stopped} stopped.", perforated + stopped);
    match (&fit.estimate, fit.v50()) {
        (Ok(found), Some(v50)) => {
            let [low, high] = v50.bounds.words();
            let level = short(100.0 * fit.request.level, 3);
            let sigma = short(found.sigma, 3);
            format!("{shots} V50 {} m/s, {level} % interval {low} to {high} m/s; σ {sigma} m/s.", short(found.mu, 4))
        }
        _ => shots,
    }
}

pub(in crate::study) fn table(title: &str, heads: &[&str], rows: &str) -> String {
    let heads: String = heads.iter().map(|head| format!("<th scope=\"col\">{}</th>", escape(head))).collect();
    format!(
        "<h2>{title}</h2>\n<div class=\"scroll\" tabindex=\"0\"><table>\n<thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n"
    )
}

pub(in crate::study) fn row(cells: &[String]) -> String {
    let cell = |(n, cell): (usize, &String)| {
        // Signs of numbers, not what joins words.
        let cell = if cell.parse::<f64>().is_ok() { cell.replace('-', "−") } else { cell.clone() };
        let cell = escape(&cell);
        if n == 0 { format!("<th scope=\"row\">{cell}</th>") } else { format!("<td>{cell}</td>") }
    };
    format!("<tr>{}</tr>\n", cells.iter().enumerate().map(cell).collect::<String>())
}

fn quantiles(fit: &Fit) -> String {
    let one = |quantile: &Quantile| {
        let value = quantile.value.map_or_else(String::new, |value| short(value, 5));
        let [low, high] = quantile.bounds.words();
        row(&[format!("{} %", short(100.0 * quantile.p, 3)), value, low, high])
    };
    let rows: String = fit.quantiles.iter().map(one).collect();
    let title = format!("Velocities by chance, {}, {} intervals", fit.request.link.word(), fit.request.interval.word());
    table(&title, &["chance of a perforation", "velocity [m/s]", "low [m/s]", "high [m/s]"], &rows)
}

fn arithmetic(fit: &Fit) -> String {
    let rows: String = fit
        .arithmetic
        .iter()
        .map(|(of, found)| {
            let (value, why) = match found {
                Ok(found) => (short(found.mean, 5), format!("spread {} m/s", short(found.spread, 3))),
                Err(why) => ("none".to_owned(), refusal(why)),
            };
            row(&[rule(of), of.standard.to_owned(), value, why])
        })
        .collect();
    table("Arithmetic V50", &["rule", "standard", "V50 [m/s]", ""], &rows)
}

fn residual(fit: &Fit) -> String {
    if fit.residual.is_empty() {
        return String::new();
    }
    let rows: String = fit
        .residual
        .iter()
        .map(|(curve, found)| {
            let name = curve.words().to_owned();
            match found {
                Ok(found) => {
                    let numbers = [found.factor, found.exponent, found.scatter].map(|number| short(number, 4));
                    let [factor, exponent, scatter] = numbers;
                    let [low, high] = found.bounds.words();
                    row(&[name, short(found.limit, 5), low, high, factor, exponent, scatter])
                }
                Err(few) => row(&[name, too_few(few)]),
            }
        })
        .collect();
    table(
        "Residual velocity, Vr = a (Vs^p − V₀^p)^(1/p)",
        &["curve", "V₀ [m/s]", "low [m/s]", "high [m/s]", "a", "p", "scatter [m/s]"],
        &rows,
    )
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
