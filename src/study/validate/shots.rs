//! Runs: what their cases state with a published source, and what the paper's figures show as curves.

use super::{Expected, Prediction, PredictionRun};
use crate::case::{self, Bound, Case};
use crate::output::{self, Checked, expect as expectation};
use crate::run::Run;

/// Name and text of every case with a published shot.
pub const SHOTS: [(&str, &str); 2] = [
    ("s720-1ply-155", include_str!("../../../cases/s720-1ply-155.json")),
    ("s728-4ply-91", include_str!("../../../cases/s728-4ply-91.json")),
];

/// What a figure shows as a curve: case, quantity of `summary.json`, name, what can be said of it, figure.
const CURVES: [[&str; 5]; 2] = [
    ["s720-1ply-155", "residual_velocity_m_s", "exit velocity [m/s]", "a curve", "paper, Figure 6"],
    ["s728-4ply-91", "stop_time_us", "time to rest [µs]", "a curve", "paper, Figure 7"],
];

/// Whether the source of an expectation is a publication or a closed form: what a prediction can be held against.
pub fn is_published(source: &str) -> bool {
    ["paper", "published", "closed form"].iter().any(|word| source.starts_with(word))
}

/// Whether a case states anything with such a source.
pub fn has_published(case: &Case) -> bool {
    case.expect.iter().any(|expect| is_published(&expect.source))
}

/// Runs the paper's shots, by default and with the paper's numerics, and adds what they say.
pub(super) fn paper(table: &mut PredictionRun<'_>) {
    for (name, text) in SHOTS {
        for (numerics, words) in [("default", ""), ("paper", ", numerics paper")] {
            match case::from_str(name, text, &[format!("/solver/numerics={numerics}")]) {
                Ok(case) => {
                    let case = Case { title: case.title.clone() + words, ..case };
                    let run = add(&case, table);
                    table.rows.extend(run.iter().flat_map(|run| beside_the_case(&case, run)));
                }
                Err(error) => table.rows.push(Prediction::failed(name, error.to_string())),
            }
        }
    }
}

/// Runs a shot and adds what its case states; nothing of an interrupted one. The run, if it came to its end.
pub(super) fn add(case: &Case, table: &mut PredictionRun<'_>) -> Option<Run> {
    let run = table.run(case);
    table.take(&case.title, run.as_ref().map(|run| statements(case, run)).map_err(Clone::clone));
    run.ok().filter(|run| !run.interrupted)
}

/// What a case states with a published source.
fn statements(case: &Case, run: &Run) -> Vec<Prediction> {
    let checked = output::check(case, run, &output::summary(case, run, 0.0));
    let published = checked.iter().filter(|checked| is_published(&checked.expect.source));
    published.map(|checked| statement(&case.title, checked)).collect()
}

/// What the paper says of a shot that its case does not state.
fn beside_the_case(case: &Case, run: &Run) -> Vec<Prediction> {
    let summary = output::summary(case, run, 0.0);
    let mut rows = Vec::new();
    for [_, quantity, what, curve, source] in CURVES.iter().filter(|curve| curve[0] == case.name) {
        let expected = Expected::CurveOnly((*curve).to_owned());
        rows.push(Prediction::judged(&case.title, what, expected, summary[*quantity].clone(), source));
    }
    rows
}

/// One of them.
fn statement(title: &str, checked: &Checked) -> Prediction {
    let expected = match &checked.expect.bound {
        Bound::Word(word) => Expected::Statement(word.clone()),
        Bound::Value { value, tolerance } => Expected::number(value.to_string(), *tolerance, "as the case states"),
        Bound::Range { min, max } => Expected::Statement(format!("{min} to {max}")),
    };
    Prediction {
        group: title.to_owned(),
        name: expectation::quantity(&checked.to_json()),
        expected,
        got: checked.got.clone(),
        source: checked.expect.source.clone(),
        pass: Some(checked.pass),
        known_difference: checked.expect.known_difference.clone(),
    }
}
