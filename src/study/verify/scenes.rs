//! Scenes with an `expect` block, built into the program.

use std::sync::atomic::{AtomicBool, Ordering};

use super::{Check, simulate};
use crate::case::{self, Bound};
use crate::output;
use crate::run::Options;

macro_rules! scenes {
    ($($name:literal),+ $(,)?) => {
        /// Name and text of every scene of `cases/verify`.
        pub(crate) const SCENES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../../cases/verify/", $name, ".json")))),+];
    };
}

scenes!(
    "smith-yarn-155",
    "strip-uncrimped-155",
    "strip-crimped-155",
    "strip-compressible-155",
    "strip-compressible-250",
    "membrane-frequency",
    "mass-on-strip",
    "first-drop",
    "free-flight",
    "free-impact",
    "mirror",
    "s720-prototype",
);

/// Text of a scene; empty for a name there is not.
pub(crate) fn text(name: &str) -> &'static str {
    SCENES.iter().find(|(of, _)| *of == name).map_or("", |(_, text)| text)
}

/// One row per expectation of each scene.
pub(super) fn rows(options: Options<'_>, interrupt: &AtomicBool, keep: &mut dyn FnMut(Check)) {
    for (name, text) in SCENES {
        if interrupt.load(Ordering::Relaxed) {
            return;
        }
        let case = match case::from_str(name, text, &[]) {
            Ok(case) => case,
            Err(error) => {
                keep(Check::failed("scenes", name, "a valid case", error.to_string()));
                continue;
            }
        };
        let run = match simulate("scenes", &case, options, interrupt) {
            Ok(run) => run,
            Err(row) => {
                keep(*row);
                continue;
            }
        };
        if run.interrupted {
            return;
        }
        for checked in output::check(&case, &run, &output::summary(&case, &run, 0.0)) {
            let (expected, tolerance) = match &checked.expect.bound {
                Bound::Word(word) => (word.clone(), String::new()),
                Bound::Value { value, tolerance } => (format!("{value}"), format!("±{tolerance:.3e}")),
                Bound::Range { min, max } if min.is_finite() && max.is_finite() => {
                    (format!("{min:e} to {max:e}"), String::new())
                }
                Bound::Range { min, .. } if min.is_finite() => (format!("≥ {min:e}"), String::new()),
                Bound::Range { max, .. } => (format!("≤ {max:e}"), String::new()),
            };
            let at = checked.expect.at.map_or(String::new(), |t| format!(" at {} µs", round(t * 1e6)));
            keep(Check {
                group: "scenes",
                name: format!("{name}: {}{at}", checked.expect.quantity),
                expected,
                got: checked.got.as_f64().map_or_else(|| checked.got.to_string(), short),
                tolerance,
                source: checked.expect.source.clone(),
                pass: checked.pass,
            });
        }
    }
}

fn round(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

fn short(x: f64) -> String {
    if x != 0.0 && x.abs() < 1e-3 { format!("{x:.2e}") } else { format!("{x:.6}") }
}
