//! `diff.html`: tables and figures in one file that asks nothing of a network.

use super::draw;
use super::pair::RunPair;
use super::text::word;
use super::{CurveRow, Diff, KeyDifference, SummaryRow, letter};
use crate::output::chart::escape;
use crate::output::number::{fraction, short};
use crate::study::page::{framed, table_under};

/// The page.
pub fn html(diff: &Diff) -> String {
    let mut body = "<ul class=\"legend\">\n".to_owned();
    for input in 0..diff.inputs.len() {
        body += &format!(
            "<li><svg viewBox=\"0 0 44 8\"><line x1=\"2\" x2=\"42\" y1=\"4\" y2=\"4\" {}/></svg>{}</li>\n",
            draw::stroke(input),
            escape(&draw::name(diff, input))
        );
    }
    body += "</ul>\n";
    if diff.options.shift_us != 0.0 {
        body += &format!("<p>Times of all but A are moved by {} µs.</p>\n", diff.options.shift_us);
    }
    for note in diff.inputs.iter().flat_map(|input| &input.notes) {
        body += &format!("<p class=\"note\">{}</p>\n", escape(note));
    }
    let judged = match (diff.options.within, diff.pass()) {
        (Some(within), Some(pass)) => {
            let word = if pass { "pass" } else { "fail" };
            format!("<p class=\"{word}\">{word}: judged by a difference of at most {}</p>\n", fraction(within))
        }
        _ => String::new(),
    };
    body += &judged;
    for (n, pair) in diff.pairs.iter().enumerate() {
        body += &section(n + 1, pair, diff.options.part());
    }
    body += "<h2>Curves over each other</h2>\n<div class=\"plots\">\n";
    for (name, drawing) in draw::panels(diff) {
        body += &format!("<figure>{}</figure>\n", draw::alone(&name, &drawing));
    }
    body += "</div>\n";
    let title =
        format!("Differences from {}", diff.inputs.first().map_or_else(String::new, |a| a.path.display().to_string()));
    framed(&title, PAGE, &body, "All curves at all times are in diff.csv.")
}

/// What differs between the first and another.
fn section(n: usize, pair: &RunPair, part: f64) -> String {
    let b = letter(n);
    let mut out = format!("<h2>{b} against A</h2>\n");
    if let Some((row, time)) = pair.parts() {
        let (name, part) = (escape(&row.name), fraction(part));
        out +=
            &format!("<p>They part first at {} µs, in <code>{name}</code>, by more than {part}.</p>\n", short(time, 4));
    }
    if !pair.summary.is_empty() {
        let rows: String = pair.summary.iter().map(summary_row).collect();
        out += &table_under(
            "h3",
            "Results",
            &["quantity", "A", &b.to_string(), &format!("{b} − A"), "relative", ""],
            &rows,
        );
    }
    let keys = [("Case", pair.keys.as_deref().unwrap_or_default()), ("Computed by", &pair.machine)];
    for (title, keys) in keys.into_iter().filter(|(_, keys)| !keys.is_empty()) {
        let rows: String = keys.iter().map(key_row).collect();
        out += &table_under("h3", title, &["key", "A", &b.to_string()], &rows);
    }
    if pair.keys.as_ref().is_some_and(Vec::is_empty) {
        out += "<p>The cases are the same.</p>\n";
    }
    let rows: String = pair.curves.iter().map(curve_row).collect();
    let heads = [
        "curve",
        "from µs",
        "to µs",
        "largest",
        "at µs",
        "rms",
        "largest / peak of A",
        "rms / peak of A",
        "parts at µs",
        "",
    ];
    out + &table_under("h3", "Curves", &heads, &rows)
}

fn cells(cells: &[String], pass: Option<bool>) -> String {
    let mut out = String::from("<tr>");
    for (n, cell) in cells.iter().enumerate() {
        let cell = escape(&cell.replace('-', "−"));
        out += &if n == 0 {
            format!("<th scope=\"row\"><code>{}</code></th>", escape(&cells[0]))
        } else {
            format!("<td>{cell}</td>")
        };
    }
    out += match pass {
        Some(true) => "<td class=\"pass\">pass</td>",
        Some(false) => "<td class=\"fail\">fail</td>",
        None => "<td></td>",
    };
    out + "</tr>\n"
}

fn summary_row(row: &SummaryRow) -> String {
    let values = [&row.a, &row.b].map(|value| match value.as_f64() {
        Some(number) => short(number, 6),
        None => word(Some(value)),
    });
    let [a, b] = values;
    let difference = row.difference.map_or_else(String::new, |difference| short(difference, 4));
    let relative = row.relative.map_or_else(String::new, fraction);
    cells(&[row.name.to_owned(), a, b, difference, relative], row.pass)
}

fn key_row(key: &KeyDifference) -> String {
    let [a, b] = [&key.a, &key.b].map(|value| escape(&word(value.as_ref())));
    format!("<tr><th scope=\"row\"><code>{}</code></th><td>{a}</td><td>{b}</td></tr>\n", escape(&key.pointer))
}

fn curve_row(row: &CurveRow) -> String {
    let found = &row.difference;
    let share = |share: Option<f64>| share.map_or_else(String::new, fraction);
    let numbers = [found.span[0], found.span[1], found.largest, found.at, found.rms].map(|number| short(number, 4));
    let parts = found.parts_at.map_or_else(String::new, |time| short(time, 4));
    let mut all = vec![row.name.clone()];
    all.extend(numbers);
    all.extend([share(found.share()), share(found.rms_share()), parts]);
    cells(&all, row.pass)
}

const PAGE: &str = "
:root { color-scheme: light; --line: #d5dbe3; --soft: #566273 }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 70em; margin: 1.5em auto; padding: 0 1em; color: #17202b; background: #fff }
h1 { font-size: 1.5rem; overflow-wrap: anywhere } h2 { margin: 2em 0 .5em } h3 { margin: 1.2em 0 .3em }
.legend { list-style: none; padding: 0 } .legend li { overflow-wrap: anywhere } .legend svg { width: 44px; height: 8px; margin-right: .7em }
table { border-collapse: collapse; font-size: .92rem } .scroll { overflow-x: auto }
th, td { text-align: right; padding: .3em 1em .3em 0; border-bottom: 1px solid var(--line); font-variant-numeric: tabular-nums }
th { font-weight: 500; color: var(--soft) } th:first-child { text-align: left; color: inherit }
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 420px), 1fr)); gap: 12px }
figure { margin: 0 } figure svg { width: 100%; height: auto; font-size: 12px }
.pass { color: #1a6b3c } .fail { color: #b3261e; font-weight: 600 } .note { color: var(--soft); font-size: .9rem }
@media print { figure, tr { break-inside: avoid } }
";
