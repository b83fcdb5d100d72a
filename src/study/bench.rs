//! Run time against error: a case run in every way a user may choose, each against one reference.
//!
//! The reference is as good as this program can do: the processor in f64, Courant 0.25, one crossover per element (for which the
//! published failure strain holds), history four times as fine. The choices change one thing at a time from the case as it
//! is.
//!
//! Failure of yarns makes a shot sensitive to anything, so the reference is run a second time with a time step a fifth
//! longer: errors smaller than the difference of the two are scatter and rank nothing.

use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::{Value, json};

use crate::case::{Case, CaseError};
use crate::output::{self, csv};
use crate::run::{self, Options, Precision, Progress, Run, RunError, Sample, Skips};

/// Description of the reference.
pub const REFERENCE: &str = "CPU, f64, Courant 0.25, one crossover per element everywhere, history four times as fine, otherwise \
                             the case as it is";

/// Courant numbers of the two references [-].
const REFERENCE_COURANT: [f64; 2] = [0.25, 0.3];
/// Rows of the reference's history in one interval of the case's, so that reading between them adds no error.
const REFERENCE_ROWS: f64 = 4.0;
/// Courant numbers to choose from [-], the fastest first.
const COURANT: [f64; 4] = [0.95, 0.9, 0.8, 0.5];
/// Crossovers along each side of an element to choose from.
const MESH: [u32; 3] = [1, 2, 4];

/// Reader of the case with changes, each `/pointer=value`.
pub type ReadCase<'a> = &'a dyn Fn(&[String]) -> Result<Case, CaseError>;
/// Listener that hears what runs and where it is.
pub type Progressed<'a> = &'a mut (dyn FnMut(&str, &Progress) + Send);

/// One way to run a case.
#[derive(Clone, Debug, PartialEq)]
struct Configuration {
    /// Difference to the case as it is, in words.
    name: String,
    precision: Precision,
    on_gpu: bool,
    skips: Skips,
    /// Changes of the case.
    sets: Vec<String>,
}

/// Every configuration for a case: one thing changed at a time.
fn configurations(case: &Case, gpu: bool) -> Vec<Configuration> {
    let (courant, mesh, graded) =
        (case.solver.courant, case.pack.crossovers_per_element, case.pack.mesh.grading.is_some());
    let with = |name: &str, set: &str| Configuration {
        name: name.to_owned(),
        precision: Precision::F64,
        on_gpu: false,
        skips: Skips::default(),
        sets: Vec::from_iter((!set.is_empty()).then(|| set.to_owned())),
    };
    let single = Configuration { precision: Precision::F32, ..with("f32", "") };
    let words = if graded { " graded" } else { "" };
    let mut all = vec![with(&format!("default: f64, Courant {courant}, mesh {mesh}{words}"), ""), single.clone()];
    let other = COURANT.into_iter().filter(|value| *value != courant);
    all.extend(other.map(|value| with(&format!("Courant {value}"), &format!("/solver/courant={value}"))));
    let other = MESH.into_iter().filter(|count| *count != mesh);
    all.extend(other.map(|count| with(&format!("mesh {count}"), &format!("/pack/crossovers_per_element={count}"))));
    if graded {
        all.push(with("not graded", "/pack/mesh_grading=none"));
    } else if case.projectile.is_some() {
        all.push(with("graded", "/pack/mesh_grading=graded"));
    }
    all.push(Configuration { skips: Skips::WHOLE, ..with("no symmetry", "") });
    // Without the skip of the time after the outcome it would not be the same run.
    all.push(Configuration { skips: Skips { outcome: true, ..Skips::NONE }, ..with("no skip", "") });
    if gpu {
        all.push(Configuration { name: "gpu f32".to_owned(), on_gpu: true, ..single });
    }
    all
}

/// Cases of the references and of every configuration that can be read, each with what its run skips.
///
/// # Errors
/// When the case itself cannot be read.
pub fn plan(read: ReadCase<'_>, gpu: bool) -> Result<Vec<(Case, Skips)>, CaseError> {
    let base = read(&[])?;
    let references = REFERENCE_COURANT.map(|courant| (reference_sets(&base, courant).to_vec(), Skips::WHOLE));
    let others = configurations(&base, gpu).into_iter().map(|one| (one.sets, one.skips));
    let all = references.into_iter().chain(others);
    Ok(all.filter_map(|(sets, skips)| Some((read(&sets).ok()?, skips))).collect())
}

/// Row of `bench.json`: a configuration or the reference, and its run.
fn row(name: &str, sets: &[String], case: &Case, run: &Run) -> Value {
    let divergence = run.divergence.as_ref();
    let unstable = divergence.map(|found| format!("unstable at {}: {}", output::place(found), found.quantity));
    json!({
        "name": name,
        "sets": sets,
        "backend": run.backend,
        "precision": run.precision,
        "courant": case.solver.courant,
        "elements": run.elements,
        "steps": run.steps,
        "loop_s": run.loop_seconds,
        "element_steps_per_s": run.elements as f64 * run.steps as f64 / run.loop_seconds,
        "outcome": run.outcome.word(),
        "energy_error": run.energy_error,
        "failed": unstable.or_else(|| run.lost.clone()),
    })
}

/// Runs the reference and every configuration, the graphics processor of `on` among them: what `bench.json` has of a case.
///
/// # Errors
/// When the reference is refused or does not start. A configuration that does not is left out with the reason.
pub fn measure(
    read: ReadCase<'_>,
    on: Options<'_>,
    interrupt: &AtomicBool,
    progressed: Progressed<'_>,
) -> Result<Value, RunError> {
    let base = read(&[])?;
    let options = Options::default().threads(on.threads);
    let mut shoot = |name: &str, case: &Case, options: Options<'_>| {
        run::run(case, options, interrupt, &mut |at: &Progress| progressed(name, at))
    };
    let [sets, second_sets] = REFERENCE_COURANT.map(|courant| reference_sets(&base, courant));
    let case = read(&sets)?;
    let reference = shoot("reference", &case, options.skips(Skips::WHOLE))?;
    let mut reference_row = row(REFERENCE, &sets, &case, &reference);
    let (mut choices, mut skipped) = (Vec::new(), Vec::new());
    let error = |run: &Run| velocity_error(&reference.history, &run.history).map(|error| error * 100.0);
    let is_whole = |run: &Run| run.divergence.is_none() && run.lost.is_none();
    if is_whole(&reference) && !reference.interrupted {
        let second = shoot("second reference", &read(&second_sets)?, options.skips(Skips::WHOLE))?;
        reference_row["scatter_percent"] = json!(error(&second).filter(|_| is_whole(&second)));
        for Configuration { name, precision, on_gpu, skips, sets } in configurations(&base, on.device.is_some()) {
            if interrupt.load(Ordering::Relaxed) {
                break;
            }
            let options = options.precision(precision).skips(skips).device(on.device.filter(|_| on_gpu));
            let refused =
                |error: CaseError| format!("{}: expected {}, found {}", error.location, error.expected, error.found);
            let done = read(&sets).map_err(refused).and_then(|case| {
                covers_the_same(&base, &case)?;
                let run = shoot(&name, &case, options).map_err(|error| error.to_string())?;
                Ok((row(&name, &sets, &case, &run), run))
            });
            match done {
                // An interrupted run says nothing about time or error.
                Ok((_, run)) if run.interrupted => {}
                Ok((mut row, run)) => {
                    row["velocity_error_percent"] = json!(error(&run).filter(|_| is_whole(&run)));
                    row["same_outcome"] = json!(is_whole(&run) && run.outcome == reference.outcome);
                    choices.push(row);
                }
                Err(reason) => skipped.push(json!({ "name": name, "reason": reason })),
            }
        }
    }
    Ok(json!({
        "case": case.name,
        "title": case.title,
        "interrupted": interrupt.load(Ordering::Relaxed),
        "reference": reference_row,
        "choices": choices,
        "skipped": skipped,
    }))
}

/// Changes that make a case the reference.
fn reference_sets(case: &Case, courant: f64) -> [String; 4] {
    let interval = case.output.history_interval * 1e6 / REFERENCE_ROWS;
    [
        format!("/solver/courant={courant}"),
        "/pack/crossovers_per_element=1".to_owned(),
        "/pack/mesh_grading=none".to_owned(),
        format!("/output/history_interval_us={interval:?}"),
    ]
}

/// Whether another mesh covers the same cloth: whole elements where the case has whole crossovers.
fn covers_the_same(base: &Case, case: &Case) -> Result<(), String> {
    let crossovers = |case: &Case| {
        let each = [case.pack.crossovers_per_element, case.pack.elements_per_crossover].map(|count| count as usize);
        let layers = case.layers();
        layers.iter().map(|layer| layer.mesh.count.map(|count| count * each[0] / each[1])).collect::<Vec<_>>()
    };
    if crossovers(base) == crossovers(case) {
        return Ok(());
    }
    Err(format!("the crossovers along warp or weft do not divide by {}", case.pack.crossovers_per_element))
}

/// Root mean square of the velocity difference over the time that both cover, over the velocity that the reference lost in that time [-];
/// `None` where it lost none, or where there is no common time.
fn velocity_error(reference: &[Sample], run: &[Sample]) -> Option<f64> {
    let at = |history: &[Sample], time: f64| csv::between(history, time, |row| row.projectile_velocity);
    let span = reference.last()?.time.min(run.last()?.time);
    let lost = at(reference, 0.0)? - at(reference, span)?;
    // Trapezoidal in time, over the rows of the run.
    let (mut integral, mut last) = (0.0, None);
    for time in run.iter().map(|row| row.time).filter(|time| *time < span).chain([span]) {
        let square = (at(run, time)? - at(reference, time)?).powi(2);
        if let Some((before, start)) = last {
            integral += 0.5 * (start + square) * (time - before);
        }
        last = Some((time, square));
    }
    (lost > 0.0 && span > 0.0).then(|| (integral / span).sqrt() / lost)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;

    fn paper(changes: &[String]) -> Result<Case, CaseError> {
        case::from_str("s720-1ply-155", include_str!("../../cases/s720-1ply-155.json"), changes)
    }

    #[test]
    fn every_configuration_has_its_name_and_none_is_the_default_again() -> Result<(), CaseError> {
        let changes = ["/expect=[]", "/solver/courant=0.8", "/pack/crossovers_per_element=2"].map(str::to_owned);
        let all = configurations(&paper(&changes)?, true);
        let names: Vec<&str> = all.iter().map(|one| one.name.as_str()).collect();
        let expected = "default: f64, Courant 0.8, mesh 2; f32; Courant 0.95; Courant 0.9; Courant 0.5; mesh 1; mesh 4; graded; \
                        no symmetry; no skip; gpu f32";
        assert_eq!(names.join("; "), expected);
        for one in all {
            paper(&[&changes[..], &one.sets].concat())?;
        }
        Ok(())
    }

    /// A history from 0 to `end` [µs] in steps of `step` [µs] with this velocity [m/s].
    fn history(step: f64, end: f64, velocity: impl Fn(f64) -> f64) -> Vec<Sample> {
        let rows = 0..=(end / step).round() as usize;
        let row = |time: f64| Sample { time: time * 1e-6, projectile_velocity: velocity(time), ..Sample::default() };
        rows.map(|n| row(n as f64 * step)).collect()
    }

    #[test]
    fn the_error_is_the_root_mean_square_over_the_velocity_lost() {
        let is = |found: Option<f64>, error: f64| found.is_some_and(|found| (found - error).abs() < 1e-6);
        // A constant difference; rows of the run that come later do not count.
        let reference = history(0.5, 10.0, |t| 100.0 - 2.0 * t);
        assert!(is(velocity_error(&reference, &history(0.7, 14.0, |t| 101.0 - 2.0 * t)), 1.0 / 20.0));
        // √(∫ (0.1 t)² dt / 10) = 1/√3 of 10, whichever of the two is faster.
        let reference = history(0.25, 10.0, |t| 50.0 - t);
        for slope in [1.1, 0.9] {
            assert!(is(velocity_error(&reference, &history(0.01, 10.0, |t| 50.0 - slope * t)), 0.1 / 3.0_f64.sqrt()));
        }
        assert!(is(velocity_error(&reference, &reference), 0.0));
        let flight = history(0.5, 10.0, |_| 100.0);
        assert_eq!([&flight[..], &[], &flight[..1]].map(|run| velocity_error(&flight, run)), [None; 3]);
    }
}
