//! The shipped cases, each held against what it states: closed forms, hard scenes, a run of an independent prototype.

use std::sync::atomic::AtomicBool;

use serde_json::Value;

use crate::case;
use crate::output;
use crate::run::{self, Observer, Options};

macro_rules! cases {
    ($($name:literal)*) => {
        /// Name and text of every case.
        pub const CASES: &[(&str, &str)] = &[$(($name, include_str!(concat!("../../cases/", $name, ".json")))),*];
    };
}

cases! {
    "verify/smith-yarn-155" "verify/strip-uncrimped-155" "verify/strip-crimped-155" "verify/strip-compressible-155"
    "verify/strip-compressible-250" "verify/strip-pulled-weft-free" "verify/strip-pulled-weft-held"
    "verify/membrane-frequency" "verify/cone-on-membrane" "verify/mass-on-strip" "verify/first-drop" "verify/free-flight"
    "verify/free-impact" "verify/mirror" "verify/s720-prototype"
    "stress/light-projectile" "stress/heavy-courant-0.99" "stress/oblique-tip" "stress/spinning-fragment" "stress/thick-pack"
    "stress/pretension-free-edges" "stress/no-crimp" "stress/large-crimp" "stress/rigid-crossovers" "stress/one-yarn-absent"
    "stress/one-element" "stress/everything-erodes"
}

/// Expectations of one of [`CASES`], each with what its run gave, as `summary.json` has them; none of an interrupted run.
///
/// # Errors
/// Why there is no result: a case that is refused, a run that did not start or became unstable.
pub fn check(
    (name, text): (&str, &str),
    options: Options<'_>,
    interrupt: &AtomicBool,
    observer: &mut dyn Observer,
) -> Result<Vec<Value>, String> {
    let case = case::from_str(name, text, &[]).map_err(|error| error.to_string())?;
    let run = run::run(&case, options, interrupt, observer).map_err(|error| error.to_string())?;
    if let Some(divergence) = &run.divergence {
        return Err(format!("unstable at {}: {}", output::place(divergence), divergence.quantity));
    }
    if let Some(reason) = &run.lost {
        return Err(format!("device lost at {}: {reason}", output::reached(&run)));
    }
    if run.interrupted {
        return Ok(Vec::new());
    }
    Ok(output::check(&case, &run, &output::summary(&case, &run, 0.0)))
}
