//! Long runs: what the energy of a vibrating ply has become after a million steps.

use std::sync::atomic::AtomicBool;

use super::judge::{self, SkipReason, StressBackend};
use crate::case::{self, Case};
use crate::run::Run;
use crate::study::verify::{Check, scenes};

/// A pre-tensioned ply of 12 × 10 elements in its first mode, at Courant 0.9, over so many steps.
fn vibrating(steps: u64) -> Result<Case, String> {
    let sets = ["/pack/width_mm=60.96", "/pack/height_mm=50.8", "/solver/courant=0.9", "/solver/shock_viscosity=0"];
    let sets = sets.map(str::to_owned);
    let mut case =
        case::from_str("vibrating", scenes::text("membrane-frequency"), &sets).map_err(|error| error.to_string())?;
    let model = crate::model::Model::<f64>::new(&case).map_err(|error| error.to_string())?;
    case.solver.end_time = steps as f64 * model.dt;
    case.output.history_interval = case.solver.end_time / 3000.0;
    Ok(case)
}

/// Change of the mean energy from the first to the last third of a run, over the energy of the vibration [-].
fn drift(run: &Run) -> f64 {
    // By state functions, without any bookkeeping. Not over all the energy: most of it is that of the pre-tension.
    let energy: Vec<f64> =
        run.history.iter().map(|s| s.balance.kinetic + s.balance.stored + s.balance.hourglass).collect();
    let vibration = run.history.iter().map(|s| s.balance.kinetic).fold(0.0, f64::max);
    let third = energy.len() / 3;
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    (mean(&energy[2 * third..]) - mean(&energy[..third])) / vibration
}

/// Rows of the long run on one machine; `None` after an interrupt.
pub(super) fn rows(
    group: &'static str,
    machine: StressBackend<'_>,
    steps: u64,
    interrupt: &AtomicBool,
) -> Option<Vec<Check>> {
    let row = |what: &str, got: String, tolerance: f64, pass: bool| Check {
        group,
        name: format!("vibrating ply, {steps} steps: {what}"),
        expected: "0".to_owned(),
        got,
        tolerance: format!("±{tolerance:.0e}"),
        source: "a conservative law without contact or failure".to_owned(),
        pass,
    };
    let (most, error) = bounds(machine);
    let failed = |why: String| Some(vec![row("a finished run", why, most, false)]);
    let case = match vibrating(steps) {
        Ok(case) => case,
        Err(why) => return failed(why),
    };
    match judge::run(&case, machine, None, interrupt) {
        Err(SkipReason::Interrupted) => None,
        Err(SkipReason::Refused(why) | SkipReason::Unable(why) | SkipReason::Panicked(why)) => failed(why),
        Ok(finished) => {
            let run = &finished.run;
            if let Some(fault) = judge::unsound(&finished) {
                return failed(fault.what);
            }
            let found = drift(run);
            Some(vec![
                row("drift of its energy", format!("{found:.2e}"), most, found.abs() <= most),
                row("energy error", format!("{:.2e}", run.energy_error), error, run.energy_error <= error),
            ])
        }
    }
}

/// Largest drift, over the energy of the vibration, and energy error of the ledger.
fn bounds(machine: StressBackend<'_>) -> (f64, f64) {
    if machine.is_double() { (1e-6, 1e-9) } else { (1e-2, 5e-3) }
}
