//! `diff.csv` and JSON.

use serde_json::{Value, json};

use super::curve::at;
use super::pair::RunPair;
use super::quantity::TIME;
use super::{CurveRow, Diff, Input, letter};
use crate::output::csv::{header, number, row};

/// Every compared curve at the times of all inputs: the values of each, and the differences from the first. A cell is empty where an
/// input does not cover the time.
pub fn csv(diff: &Diff) -> String {
    let mut times: Vec<f64> = diff.inputs.iter().flat_map(|input| input.table.times.iter().copied()).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let mut heads = vec![TIME.to_owned()];
    let mut columns: Vec<Vec<Option<f64>>> = Vec::new();
    for name in diff.names() {
        let values: Vec<Option<Vec<Option<f64>>>> =
            diff.inputs.iter().map(|input| values(input, name, &times)).collect();
        for (n, values) in values.iter().enumerate() {
            if let Some(values) = values {
                heads.push(format!("{name}_{}", letter(n).to_lowercase()));
                columns.push(values.clone());
            }
        }
        for (n, other) in values.iter().enumerate().skip(1) {
            if let (Some(Some(first)), Some(other)) = (values.first(), other) {
                heads.push(format!("{name}_{}_minus_a", letter(n).to_lowercase()));
                columns.push(first.iter().zip(other).map(|(a, b)| Some((*b)? - (*a)?)).collect());
            }
        }
    }
    let mut text = header(heads.iter().map(|head| quoted(head)).collect::<Vec<_>>().iter().map(String::as_str));
    for (n, time) in times.iter().enumerate() {
        let cells = columns.iter().map(|column| column[n].map_or_else(String::new, number));
        row(&mut text, std::iter::once(number(*time)).chain(cells));
    }
    text
}

/// A heading as RFC 4180 writes it: a user's may hold anything.
fn quoted(head: &str) -> String {
    let plain = head.chars().all(|c| !c.is_control() && !matches!(c, ',' | '"' | '#'));
    if plain { head.to_owned() } else { format!("\"{}\"", head.replace('"', "\"\"")) }
}

fn values(input: &Input, name: &str, times: &[f64]) -> Option<Vec<Option<f64>>> {
    let points = input.table.points(input.table.column(name)?);
    Some(times.iter().map(|time| at(&points, *time)).collect())
}

/// The whole comparison.
pub fn json(diff: &Diff) -> Value {
    let inputs: Vec<Value> = diff.inputs.iter().enumerate().map(|(n, input)| input_json(n, input)).collect();
    let pairs: Vec<Value> = diff.pairs.iter().enumerate().map(|(n, pair)| pair_json(n + 1, pair)).collect();
    json!({
        "pass": diff.pass(),
        "within": diff.options.within,
        "part": diff.options.part(),
        "shift_us": diff.options.shift_us,
        "inputs": inputs,
        "comparisons": pairs,
    })
}

/// A value in one line, words without quotes.
pub fn word(value: Option<&Value>) -> String {
    match value {
        None | Some(Value::Null) => "-".to_owned(),
        Some(Value::String(text)) => text.clone(),
        Some(value) => value.to_string(),
    }
}

fn input_json(n: usize, input: &Input) -> Value {
    json!({
        "letter": letter(n).to_string(),
        "path": input.path.display().to_string(),
        "kind": input.kind.word(),
        "title": input.title(),
        "rows": input.table.times.len(),
        "span_us": input.table.span(),
        "columns": input.table.columns.iter().map(|column| &column.name).collect::<Vec<_>>(),
        "notes": input.notes,
    })
}

fn pair_json(n: usize, pair: &RunPair) -> Value {
    json!({
        "first": "A",
        "other": letter(n).to_string(),
        "summary": pair.summary,
        "case": pair.keys,
        "machine": pair.machine,
        "curves": pair.curves.iter().map(curve_json).collect::<Vec<_>>(),
        "parts": pair.parts().map(|(curve, at)| json!({ "name": curve.name, "at_us": at })),
        "only_in_first": pair.alone[0],
        "only_in_other": pair.alone[1],
    })
}

fn curve_json(row: &CurveRow) -> Value {
    let found = &row.difference;
    json!({
        "name": row.name,
        "span_us": found.span,
        "largest": found.largest,
        "largest_at_us": found.at,
        "rms": found.rms,
        "scale": found.scale,
        "largest_relative": found.share(),
        "rms_relative": found.rms_share(),
        "parts_at_us": found.parts_at,
        "judged": row.judged,
        "pass": row.pass,
    })
}
