//! Running shipped scenes from tests.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use ripstop::case::{self, Case};
use ripstop::output;
use ripstop::run::{self, Options, Precision, Run, Simulation};
use serde_json::Value;

/// A shipped case on the paper's numerics (one even element per crossover, contact at nodes, no viscosity) with changes, each
/// `/pointer=value`.
pub(crate) fn builtin(path: &str, sets: &[&str]) -> Case {
    shipped(path, &[&["/solver/numerics=paper"], sets].concat())
}

/// A shipped case as it is, with changes, each `/pointer=value`.
pub(crate) fn shipped(path: &str, sets: &[&str]) -> Case {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    case::read(Path::new(path), &sets).unwrap_or_else(|e| panic!("{e}"))
}

/// Runs a case in double precision on two threads.
pub(crate) fn run(case: &Case) -> Run {
    run_as(case, Precision::F64, 2)
}

/// Runs a case.
pub(crate) fn run_as(case: &Case, precision: Precision, threads: usize) -> Run {
    let options = Options::default().threads(threads).precision(precision);
    let run = run::run(case, options, &AtomicBool::new(false), &mut ()).unwrap_or_else(|e| panic!("{e}"));
    assert!(run.divergence.is_none(), "{}: {:?}", case.title, run.divergence);
    assert_eq!(run.newton.unconverged, 0, "{}", case.title);
    run
}

/// The run of a simulation that goes on to its end, whatever becomes of it.
pub(crate) fn finish(mut simulation: Simulation<f64>, case: &Case) -> Run {
    while !simulation.finished(case) {
        simulation.advance(case);
    }
    simulation.into_run(1.0)
}

/// The expectations of a case against its run.
pub(crate) fn checked(case: &Case, run: &Run) -> Vec<Value> {
    output::check(case, run, &output::summary(case, run, 0.0))
}
