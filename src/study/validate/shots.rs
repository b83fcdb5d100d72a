//! Runs: what their cases state with a published source, and what the paper's figures show as curves.

use std::sync::atomic::{AtomicBool, Ordering};

use super::{Expected, Prediction};
use crate::case::{self, Bound, Case};
use crate::output::{self, Checked, expectation};
use crate::run::{self, Options, Progress, Run};

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
pub(super) fn paper(
    options: Options<'_>,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&str, &Progress) + Send),
    rows: &mut Vec<Prediction>,
) {
    for (name, text) in SHOTS {
        for (numerics, words) in [("default", ""), ("paper", ", numerics paper")] {
            let case = case::from_str(name, text, &[format!("/solver/numerics={numerics}")]);
            let case = match case {
                Ok(case) => Case { title: case.title.clone() + words, ..case },
                Err(error) => {
                    rows.push(Prediction::failed(name, error.to_string()));
                    continue;
                }
            };
            let run = add(&case, options, interrupt, progress, rows);
            rows.extend(run.iter().flat_map(|run| beside_the_case(&case, run)));
        }
    }
}

/// Runs a shot and adds what its case states; nothing of an interrupted one. The run, if it came to its end.
pub(super) fn add(
    case: &Case,
    options: Options<'_>,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&str, &Progress) + Send),
    rows: &mut Vec<Prediction>,
) -> Option<Run> {
    if interrupt.load(Ordering::Relaxed) {
        return None;
    }
    match shot(case, options, interrupt, progress) {
        Ok(run) if run.interrupted => None,
        Ok(run) => {
            let checked = output::check(case, &run, &output::summary(case, &run, 0.0));
            let published = checked.iter().filter(|checked| is_published(&checked.expect.source));
            rows.extend(published.map(|checked| statement(&case.title, checked)));
            Some(run)
        }
        Err(why) => {
            rows.push(Prediction::failed(&case.title, why));
            None
        }
    }
}

/// A run that came to its end or was interrupted.
pub(super) fn shot(
    case: &Case,
    options: Options<'_>,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&str, &Progress) + Send),
) -> Result<Run, String> {
    let run = run::run(case, options, interrupt, &mut |at: &Progress| progress(&case.name, at))
        .map_err(|error| error.to_string())?;
    if let Some(trouble) = &run.divergence {
        return Err(format!("unstable at step {}: {}", trouble.step, trouble.quantity));
    }
    if let Some(reason) = &run.lost {
        return Err(reason.clone());
    }
    Ok(run)
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

/// What a case states.
fn statement(title: &str, checked: &Checked) -> Prediction {
    let expected = match &checked.expect.bound {
        Bound::Word(word) => Expected::Statement(word.clone()),
        Bound::Value { value, tolerance } => Expected::Number {
            text: value.to_string(),
            value: *value,
            tolerance: *tolerance,
            because: "as the case states",
        },
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
