//! The table for files: Markdown, and a page of HTML that needs nothing but itself.

use super::{PAPER, Prediction, counts};
use crate::markdown;
use crate::output::chart::escape;

/// Above and below every table.
const TITLE: &str = "Predictions";
const NOTE: &str = "Not judged: published as a curve, without numbers.";

/// What is judged, what is not.
fn verdict(row: &Prediction) -> &'static str {
    if row.pass.is_none() { "not judged" } else { row.mark() }
}

/// The table in Markdown.
pub fn markdown(rows: &[Prediction]) -> String {
    let cells = |row: &Prediction| {
        vec![
            row.group.clone(),
            row.name.clone(),
            row.expected_text(),
            row.got_text(),
            row.difference_text(),
            verdict(row).to_owned(),
            row.source_text(),
        ]
    };
    markdown::table(&["of", "quantity", "expected", "got", "difference", "", "source"], rows.iter().map(cells))
}

/// The table as a page. `machine`: what computed it.
pub fn html(rows: &[Prediction], machine: &str) -> String {
    let [pass, fail, open] = counts(rows);
    let mut body = String::new();
    let mut group = "";
    for row in rows {
        if row.group != group {
            group = &row.group;
            body += &format!("<tr><th colspan=\"6\" scope=\"rowgroup\">{}</th></tr>\n", escape(group));
        }
        let class = match row.pass {
            Some(true) => "pass",
            Some(false) => "fail",
            None => "open",
        };
        let cells = [row.name.clone(), row.expected_text(), row.got_text(), row.difference_text()];
        let cells: String = cells.iter().map(|cell| format!("<td>{}</td>", escape(cell))).collect();
        let source = escape(&row.source_text());
        body += &format!("<tr class=\"{class}\">{cells}<td>{}</td><td>{source}</td></tr>\n", verdict(row));
    }
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>ripstop: {TITLE}</title>\n\
         <style>{STYLE}</style>\n</head>\n<body>\n<h1>{TITLE}</h1>\n\
         <p>What closed forms and publications say of these scenes, and what this program computes for them.</p>\n\
         <p>{pass} pass, {fail} fail, {open} not judged. ripstop {}, {}.</p>\n\
         <table>\n<thead><tr><th>quantity</th><th>expected</th><th>got</th><th>difference</th><th></th><th>source</th></tr>\
         </thead>\n<tbody>\n{body}</tbody>\n</table>\n<p>{NOTE} Paper: {PAPER}</p>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION"),
        escape(machine),
    )
}

const STYLE: &str = "
:root { color-scheme: light dark }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em }
table { border-collapse: collapse; width: 100% }
th, td { text-align: left; vertical-align: top; padding: .35em .8em .35em 0; border-bottom: 1px solid #8884 }
td:nth-child(n+2):nth-child(-n+4) { font-variant-numeric: tabular-nums }
tr.pass td:nth-child(5) { color: #1a7f37 }
tr.fail td:nth-child(5) { color: #d1242f; font-weight: bold }
tr.open td { opacity: .75 }
";
