//! Run time against error: a case run in every way a user may choose, each against one reference.
//!
//! The reference is as good as this program can do: the processor in f64, Courant 0.25, one crossover per element (for which the
//! published failure strain holds), history four times as fine. The choices change one thing at a time from the case as it
//! is, and combine what promises most.
//!
//! Failure of yarns makes a shot sensitive to anything, so the reference is run a second time with a time step a fifth
//! longer: errors smaller than the difference of the two are scatter and rank nothing.

mod error;

use std::sync::atomic::AtomicBool;

use serde_json::{Value, json};

use crate::case::{Case, CaseError, case_hash};
use crate::gpu::Device;
use crate::num::simd::Vectors;
use crate::output;
use crate::run::{self, Options, Precision, Progress, Run, RunError, Skips};

pub use error::Errors;

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
pub struct Configuration {
    /// Difference to the case as it is, in words.
    pub name: String,
    /// Number type of the state.
    pub precision: Precision,
    /// Whether the graphics processor computes.
    pub on_gpu: bool,
    /// Shortcuts taken.
    pub skips: Skips,
    /// Changes of the case.
    pub sets: Vec<String>,
}

/// Every configuration for a case: one thing changed at a time, then what promises most together.
pub fn configurations(case: &Case, gpu: bool) -> Vec<Configuration> {
    let [f64, f32] = [Precision::F64, Precision::F32];
    let (courant, mesh, graded) = (case.solver.courant, case.pack.crossovers_per_element, case.pack.grading.is_some());
    let with = |name: String, precision: Precision, set: Option<String>| Configuration {
        name,
        precision,
        on_gpu: false,
        skips: Skips::default(),
        sets: Vec::from_iter(set),
    };
    let set_courant = |value: f64| Some(format!("/solver/courant={value}"));
    let set_mesh = |count: u32| Some(format!("/pack/crossovers_per_element={count}"));
    let set_grading = |word: &str| Some(format!("/pack/mesh_grading={word}"));
    let words = if graded { " graded" } else { "" };
    let mut all = vec![
        with(format!("default: f64, Courant {courant}, mesh {mesh}{words}"), f64, None),
        with("f32".to_owned(), f32, None),
    ];
    let other = COURANT.into_iter().filter(|value| *value != courant);
    all.extend(other.map(|value| with(format!("Courant {value}"), f64, set_courant(value))));
    let other = MESH.into_iter().filter(|count| *count != mesh);
    all.extend(other.map(|count| with(format!("mesh {count}"), f64, set_mesh(count))));
    let gradable = !graded && case.projectile.is_some();
    if gradable {
        all.push(with("graded".to_owned(), f64, set_grading("graded")));
    } else if graded {
        all.push(with("not graded".to_owned(), f64, set_grading("none")));
    }
    all.push(Configuration { skips: Skips::WHOLE, ..with("no symmetry".to_owned(), f64, None) });
    all.push(Configuration { skips: Skips::NONE, ..with("no skip".to_owned(), f64, None) });
    if courant != COURANT[0] {
        all.push(with(format!("f32, Courant {}", COURANT[0]), f32, set_courant(COURANT[0])));
    }
    if mesh != 2 {
        all.push(with("f32, mesh 2".to_owned(), f32, set_mesh(2)));
    }
    if gradable {
        all.push(with("f32, graded".to_owned(), f32, set_grading("graded")));
    }
    if gpu {
        all.push(Configuration { on_gpu: true, ..with("gpu f32".to_owned(), f32, None) });
    }
    all
}

/// Measuring options.
#[derive(Clone, Copy, Debug)]
pub struct BenchPlan<'a> {
    /// Worker threads; `None` takes all cores.
    pub threads: Option<usize>,
    /// The graphics processor among the choices, if any.
    pub device: Option<&'a Device>,
    /// Runs of every choice.
    pub repeat: usize,
    /// Largest error of velocity history and end that is good enough [-].
    pub tolerance: f64,
}

/// Result of one configuration.
#[derive(Clone, Debug)]
pub struct BenchRow {
    /// The way it was run.
    pub configuration: Configuration,
    /// The case as run.
    pub case: Case,
    /// The first of its runs.
    pub run: Run,
    /// Time in the loop of every run [s].
    pub loop_seconds: Vec<f64>,
    /// Differences to the reference; none for a run that became unstable or lost its device.
    pub errors: Option<Errors>,
    /// Whether the outcome is the reference's.
    pub same_outcome: bool,
}

impl BenchRow {
    /// The shortest time in the loop [s].
    pub fn time(&self) -> f64 {
        self.loop_seconds.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Elements times steps over the shortest time in the loop [1/s].
    pub fn rate(&self) -> f64 {
        self.run.elements as f64 * self.run.steps as f64 / self.time()
    }

    /// Whether outcome, velocity history and end are the reference's within `tolerance` [-].
    pub fn is_within(&self, tolerance: f64) -> bool {
        let within = |error: Option<f64>| error.is_some_and(|error| error <= tolerance);
        self.same_outcome && within(self.velocity_error()) && within(self.errors.and_then(|errors| errors.end))
    }

    /// Error of the velocity history [-], where there is one.
    pub fn velocity_error(&self) -> Option<f64> {
        self.errors.and_then(|errors| errors.velocity)
    }
}

/// Everything measured on one case.
#[derive(Clone, Debug)]
pub struct BenchResult {
    /// The case as the reference ran it.
    pub case: Case,
    /// The reference.
    pub reference: Run,
    /// Error of the velocity history of a second reference, below which errors rank nothing [-]; none where it did not end.
    pub scatter: Option<f64>,
    /// Rows in the order of the configurations.
    pub rows: Vec<BenchRow>,
    /// Name of each configuration that was not run, and why.
    pub skipped: Vec<(String, String)>,
    /// Whether the user stopped it.
    pub interrupted: bool,
    /// Index of the cheapest row that is good enough.
    pub cheapest: Option<usize>,
}

/// Reason why nothing was measured.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BenchError {
    /// The case, or the reference made of it, is refused.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The reference did not start.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Runs the reference and every configuration.
///
/// # Errors
/// When the reference is refused or does not start. A configuration that does not is left out with the reason.
pub fn measure(
    read: ReadCase<'_>,
    plan: BenchPlan<'_>,
    interrupt: &AtomicBool,
    progressed: Progressed<'_>,
) -> Result<BenchResult, BenchError> {
    let base = read(&[])?;
    let options = Options { threads: plan.threads, skips: Skips::WHOLE, ..Options::default() };
    let mut reference = |courant: f64, name: &str| -> Result<(Case, Run), BenchError> {
        let case = read(&reference_sets(&base, courant))?;
        let run = run::run(&case, options, interrupt, &mut |at: &Progress| progressed(name, at))?;
        Ok((case, run))
    };
    let (case, run) = reference(REFERENCE_COURANT[0], "reference")?;
    let interrupted = run.interrupted;
    let mut measured = BenchResult {
        case,
        reference: run,
        scatter: None,
        rows: Vec::new(),
        skipped: Vec::new(),
        interrupted,
        cheapest: None,
    };
    if interrupted || measured.reference.divergence.is_some() {
        return Ok(measured);
    }
    let (_, second) = reference(REFERENCE_COURANT[1], "second reference")?;
    measured.interrupted = second.interrupted;
    if complete(&second) && !second.interrupted {
        measured.scatter = error::errors(&measured.reference, &second).and_then(|errors| errors.velocity);
    }
    for configuration in configurations(&base, plan.device.is_some()) {
        if measured.interrupted {
            break;
        }
        match runs(read, &base, &configuration, plan, interrupt, progressed) {
            Ok((case, runs)) => {
                measured.interrupted |= runs.iter().any(|run| run.interrupted);
                // Interrupted runs say nothing about time or error.
                let mut runs = runs.into_iter().filter(|run| !run.interrupted);
                let Some(run) = runs.next() else { continue };
                let loop_seconds = [run.loop_seconds].into_iter().chain(runs.map(|run| run.loop_seconds)).collect();
                let errors = complete(&run).then(|| error::errors(&measured.reference, &run)).flatten();
                let same_outcome = complete(&run) && error::same_outcome(&measured.reference, &run);
                let row = BenchRow { configuration, case, run, loop_seconds, errors, same_outcome };
                measured.rows.push(row);
            }
            Err(reason) => measured.skipped.push((configuration.name, reason)),
        }
    }
    let good = measured.rows.iter().enumerate().filter(|(_, row)| row.is_within(plan.tolerance));
    measured.cheapest = good.min_by(|a, b| a.1.time().total_cmp(&b.1.time())).map(|(at, _)| at);
    Ok(measured)
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

/// The runs of one configuration, or why there are none.
fn runs(
    read: ReadCase<'_>,
    base: &Case,
    configuration: &Configuration,
    plan: BenchPlan<'_>,
    interrupt: &AtomicBool,
    progressed: Progressed<'_>,
) -> Result<(Case, Vec<Run>), String> {
    let one_line = |error: CaseError| format!("{}: expected {}, found {}", error.location, error.expected, error.found);
    let case = read(&configuration.sets).map_err(one_line)?;
    covers_the_same(base, &case)?;
    let options = Options {
        threads: plan.threads,
        precision: configuration.precision,
        device: plan.device.filter(|_| configuration.on_gpu),
        skips: configuration.skips,
        from: None,
    };
    let mut runs: Vec<Run> = Vec::new();
    // A run that failed once fails again.
    while runs.len() < plan.repeat.max(1) && runs.last().is_none_or(|run| complete(run) && !run.interrupted) {
        let run = run::run(&case, options, interrupt, &mut |at: &Progress| progressed(&configuration.name, at));
        runs.push(run.map_err(|error| error.to_string())?);
    }
    Ok((case, runs))
}

/// Whether another mesh covers the same cloth: whole elements where the case has whole crossovers.
///
/// # Errors
/// Count of crossovers that does not divide, in words.
pub fn covers_the_same(base: &Case, case: &Case) -> Result<(), String> {
    let crossovers = |case: &Case| {
        let each = [case.pack.crossovers_per_element, case.pack.elements_per_crossover].map(|count| count as usize);
        let layers = case.layers();
        layers
            .iter()
            .map(|layer| [layer.columns, layer.rows].map(|count| count * each[0] / each[1]))
            .collect::<Vec<_>>()
    };
    let mesh = case.pack.crossovers_per_element;
    for (had, has) in crossovers(base).into_iter().zip(crossovers(case)) {
        if let Some(yarn) = (0..2).find(|yarn| had[*yarn] != has[*yarn]) {
            let along = ["warp", "weft"][yarn];
            return Err(format!("{} crossovers along the {along} do not divide by {mesh}", had[yarn]));
        }
    }
    Ok(())
}

/// Whether a run came to its end.
fn complete(run: &Run) -> bool {
    run.divergence.is_none() && run.lost.is_none()
}

/// `bench.json`: everything measured. `wall_seconds`: time since the command began [s].
pub fn json(measured: &[BenchResult], plan: BenchPlan<'_>, wall_seconds: f64) -> Value {
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "threads": measured.first().map(|one| one.reference.threads),
        "vectors": Vectors::widest().name(),
        "adapter": plan.device.map(|device| device.name()),
        "repeat": plan.repeat,
        "tolerance_percent": plan.tolerance * 100.0,
        "wall_s": wall_seconds,
        "interrupted": measured.iter().any(|one| one.interrupted),
        "error_is": "root mean square of the difference to the reference's velocity history over the time both cover, \
                     over the velocity the reference lost in that time; residual velocity and stop time at the end of each",
        "scatter_is": "the error of a second reference, with a time step a fifth longer: smaller errors rank nothing",
        "cases": measured.iter().map(|one| case_json(one, plan.tolerance)).collect::<Vec<_>>(),
    })
}

fn case_json(measured: &BenchResult, tolerance: f64) -> Value {
    let percent = |error: Option<f64>| error.map(|error| error * 100.0);
    let mut reference = run_json(&measured.case, &measured.reference);
    reference["what"] = json!(REFERENCE);
    reference["loop_s"] = json!(measured.reference.loop_seconds);
    reference["scatter_percent"] = json!(percent(measured.scatter));
    let choice = |row: &BenchRow| {
        let errors = row.errors;
        let mut out = run_json(&row.case, &row.run);
        out["name"] = json!(row.configuration.name);
        out["sets"] = json!(row.configuration.sets);
        out["loop_s"] = json!(row.time());
        out["loop_s_of_each_run"] = json!(row.loop_seconds);
        out["element_steps_per_s"] = json!(row.rate());
        out["velocity_error_percent"] = json!(percent(row.velocity_error()));
        out["residual_velocity_error_m_s"] = json!(errors.map(|errors| errors.residual_velocity));
        out["stop_time_error_us"] = json!(errors.and_then(|errors| errors.stop_time).map(|time| time * 1e6));
        out["end_error_percent"] = json!(percent(errors.and_then(|errors| errors.end)));
        out["same_outcome"] = json!(row.same_outcome);
        out["within_tolerance"] = json!(row.is_within(tolerance));
        out
    };
    let skipped = measured.skipped.iter().map(|(name, reason)| json!({ "name": name, "reason": reason }));
    json!({
        "case": measured.case.name,
        "title": measured.case.title,
        "interrupted": measured.interrupted,
        "reference": reference,
        "choices": measured.rows.iter().map(choice).collect::<Vec<_>>(),
        "skipped": skipped.collect::<Vec<_>>(),
        "cheapest_within_tolerance": measured.cheapest.map(|at| &measured.rows[at].configuration.name),
    })
}

/// Settings of a run and its results.
fn run_json(case: &Case, run: &Run) -> Value {
    json!({
        "case_hash": case_hash(&case.as_run),
        "backend": run.backend,
        "precision": run.precision,
        "courant": case.solver.courant,
        "crossovers_per_element": case.pack.crossovers_per_element,
        "switched_off": run.skips.switched_off(),
        "elements": run.elements,
        "steps": run.steps,
        "time_step_us": run.time_step * 1e6,
        "outcome": run.outcome.word(),
        "residual_velocity_m_s": output::residual_velocity(case, run),
        "stop_time_us": run.stop_time.map(|time| time * 1e6),
        "energy_error": run.energy_error,
        "unstable": run.divergence.as_ref().map(|divergence| divergence.quantity.clone()),
        "device_lost": run.lost,
    })
}

#[cfg(test)]
#[path = "bench_tests.rs"]
mod tests;
