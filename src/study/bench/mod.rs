//! Run time against error: a case run in every way a user may choose, each against one reference.
//!
//! The reference is as good as this program can do: the processor in f64, Courant 0.25, one
//! crossover per element (for which the published failure strain holds), history four times as fine. The choices change
//! one thing at a time from the case as it is, and combine what promises most.
//!
//! Failure of yarns makes a shot sensitive to anything, so the reference is run a second time with a time step a fifth
//! longer: errors smaller than the difference of the two are scatter and rank nothing.

pub mod choice;
pub mod error;
pub mod plot;
pub mod report;

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use crate::case::{self, Case, CaseError};
use crate::gpu::Device;
use crate::output;
use crate::run::{self, Options, Precision, Progress, Run, RunError, Skips};

pub use choice::{Configuration, Processor};
pub use error::Errors;

/// What the reference is, for people.
pub const REFERENCE: &str = "CPU, f64, Courant 0.25, one crossover per element everywhere, history \
                             four times as fine, otherwise the case as it is";

/// Courant number of the reference [-].
const REFERENCE_COURANT: f64 = 0.25;
/// Courant number of the second reference [-].
const SECOND_COURANT: f64 = 0.3;
/// Rows of the reference's history in one interval of the case's, so that reading between them adds no error.
const REFERENCE_ROWS: f64 = 4.0;
/// What costs time or is checked but says nothing here, and would refuse a shorter run.
const LEFT_OUT: [&str; 2] = ["/expect=[]", "/output/profile_times_us=[]"];

/// A case to be changed and run again and again.
#[derive(Clone, Debug)]
pub struct CaseSource {
    source: CaseText,
    sets: Vec<String>,
}

#[derive(Clone, Debug)]
enum CaseText {
    File(PathBuf),
    BuiltIn(&'static str, &'static str),
}

impl CaseSource {
    /// A case file with changes in the form `/json/pointer=value`.
    pub fn file(path: PathBuf, sets: &[String]) -> Self {
        Self { source: CaseText::File(path), sets: sets.to_vec() }
    }

    /// The paper's shot, built in, with changes.
    pub fn paper(sets: &[String]) -> Self {
        let text = include_str!("../../../cases/s720-1ply-155.json");
        Self { source: CaseText::BuiltIn("s720-1ply-155", text), sets: sets.to_vec() }
    }

    /// What it is called in messages.
    pub fn name(&self) -> String {
        match &self.source {
            CaseText::File(path) => path.display().to_string(),
            CaseText::BuiltIn(name, _) => (*name).to_owned(),
        }
    }

    /// The case with more changes, checked like the file; without expectations and profiles.
    ///
    /// # Errors
    /// What is wrong with the case so changed.
    pub fn case(&self, changes: &[String]) -> Result<Case, CaseError> {
        let left_out = LEFT_OUT.iter().map(|set| (*set).to_owned());
        let sets: Vec<String> = left_out.chain(self.sets.iter().chain(changes).cloned()).collect();
        match &self.source {
            CaseText::File(path) => case::read(path, &sets),
            CaseText::BuiltIn(name, text) => case::from_str(name, text, &sets),
        }
    }
}

/// How to measure.
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

/// What one way to run a case gave.
#[derive(Clone, Debug)]
pub struct BenchRow {
    /// The way.
    pub choice: Configuration,
    /// The case as run.
    pub case: Case,
    /// The first of its runs.
    pub run: Run,
    /// Time in the loop of every run [s].
    pub loop_seconds: Vec<f64>,
    /// Against the reference; none for a run that became unstable or lost its device.
    pub errors: Option<Errors>,
    /// Whether the outcome is the reference's.
    pub same_outcome: bool,
    /// Whether no other choice is as fast and more accurate, or as accurate and faster.
    pub on_front: bool,
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
    pub(crate) fn is_within(&self, tolerance: f64) -> bool {
        let within = |error: Option<f64>| error.is_some_and(|error| error <= tolerance);
        self.same_outcome && within(self.velocity_error()) && within(self.errors.and_then(|errors| errors.end))
    }

    /// Error of the velocity history [-], where there is one.
    pub fn velocity_error(&self) -> Option<f64> {
        self.errors.as_ref().and_then(|errors| errors.velocity)
    }
}

/// A choice that was not run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Skipped {
    /// Its name.
    pub name: String,
    /// Why.
    pub reason: String,
}

/// Everything measured on one case.
#[derive(Clone, Debug)]
pub struct BenchResult {
    /// The case as the reference ran it.
    pub case: Case,
    /// The reference.
    pub reference: Run,
    /// A second reference, with a time step a fifth longer, against the first; none where it did not end.
    pub reference_scatter: Option<Errors>,
    /// What was run, in the order of the choices.
    pub rows: Vec<BenchRow>,
    /// What was not.
    pub skipped: Vec<Skipped>,
    /// Whether the user stopped it.
    pub interrupted: bool,
    /// The row that is the cheapest among those good enough.
    pub cheapest: Option<usize>,
}

impl BenchResult {
    /// Error of the velocity history below which choices cannot be told apart [-].
    pub fn scatter(&self) -> Option<f64> {
        self.reference_scatter.and_then(|doubt| doubt.velocity)
    }
}

/// Sets of the reference for a case.
fn reference_sets(case: &Case, courant: f64) -> Vec<String> {
    let interval = case.output.history_interval * 1e6 / REFERENCE_ROWS;
    vec![
        format!("/solver/courant={courant}"),
        "/pack/crossovers_per_element=1".to_owned(),
        "/pack/mesh_grading=none".to_owned(),
        format!("/output/history_interval_us={interval:?}"),
    ]
}

/// Runs the reference and every choice; `progress` is told what runs and where it is.
///
/// # Errors
/// When the reference is refused or does not start. A choice that does not is left out with the reason.
pub fn measure(
    subject: &CaseSource,
    plan: BenchPlan<'_>,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&str, &Progress) + Send),
) -> Result<BenchResult, BenchError> {
    let base = subject.case(&[])?;
    let case = subject.case(&reference_sets(&base, REFERENCE_COURANT))?;
    let skips = Skips::WHOLE;
    let options = Options { threads: plan.threads, precision: Precision::F64, skips, ..Options::default() };
    let reference = run::run(&case, options, interrupt, &mut |at: &Progress| progress("reference", at))?;
    let stopped = reference.interrupted;
    let mut measured = BenchResult {
        case,
        reference,
        reference_scatter: None,
        rows: Vec::new(),
        skipped: Vec::new(),
        interrupted: stopped,
        cheapest: None,
    };
    if stopped || measured.reference.divergence.is_some() {
        return Ok(measured);
    }
    let case = subject.case(&reference_sets(&base, SECOND_COURANT))?;
    let second = run::run(&case, options, interrupt, &mut |at: &Progress| progress("second reference", at))?;
    measured.interrupted = second.interrupted;
    if complete(&second) && !second.interrupted {
        measured.reference_scatter = error::errors(&measured.reference, &second);
    }
    for choice in choice::choices(&base, plan.device.is_some()) {
        if measured.interrupted {
            break;
        }
        match one(subject, &base, &choice, plan, interrupt, progress) {
            Ok((case, runs)) => take(&mut measured, choice, case, runs),
            Err(reason) => measured.skipped.push(Skipped { name: choice.name, reason }),
        }
    }
    rank(&mut measured, plan.tolerance);
    Ok(measured)
}

/// Why nothing was measured.
#[derive(Clone, Debug, thiserror::Error)]
pub enum BenchError {
    /// The case, or the reference made of it, is refused.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The reference did not start.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// The runs of one choice, or why there are none.
fn one(
    subject: &CaseSource,
    base: &Case,
    choice: &Configuration,
    plan: BenchPlan<'_>,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&str, &Progress) + Send),
) -> Result<(Case, Vec<Run>), String> {
    choice::fits(base, choice)?;
    let one_line = |error: CaseError| format!("{}: expected {}, found {}", error.location, error.expected, error.found);
    let case = subject.case(&choice.sets).map_err(one_line)?;
    let options = Options {
        threads: plan.threads,
        precision: choice.precision,
        device: plan.device.filter(|_| choice.processor == Processor::Gpu),
        skips: choice.skips,
        from: None,
    };
    let mut runs: Vec<Run> = Vec::new();
    // What went wrong once goes wrong again.
    while runs.len() < plan.repeat.max(1) && runs.last().is_none_or(|run| complete(run) && !run.interrupted) {
        let run = run::run(&case, options, interrupt, &mut |at: &Progress| progress(&choice.name, at));
        runs.push(run.map_err(|error| error.to_string())?);
    }
    Ok((case, runs))
}

/// Whether a run says something about its choice.
fn complete(run: &Run) -> bool {
    run.divergence.is_none() && run.lost.is_none()
}

/// Takes the runs of a choice over; interrupted ones say nothing about time or error.
fn take(measured: &mut BenchResult, choice: Configuration, case: Case, runs: Vec<Run>) {
    measured.interrupted |= runs.iter().any(|run| run.interrupted);
    let mut runs = runs.into_iter().filter(|run| !run.interrupted);
    let Some(run) = runs.next() else { return };
    let mut loop_seconds = vec![run.loop_seconds];
    loop_seconds.extend(runs.map(|run| run.loop_seconds));
    let errors = complete(&run).then(|| error::errors(&measured.reference, &run)).flatten();
    let same_outcome = complete(&run) && error::same_outcome(&measured.reference, &run);
    measured.rows.push(BenchRow { choice, case, run, loop_seconds, errors, same_outcome, on_front: false });
}

/// Marks the front and the cheapest row that is good enough.
fn rank(measured: &mut BenchResult, tolerance: f64) {
    let points: Vec<Option<[f64; 2]>> =
        measured.rows.iter().map(|row| row.velocity_error().map(|error| [row.time(), error])).collect();
    for (row, on) in measured.rows.iter_mut().zip(error::front(&points)) {
        row.on_front = on;
    }
    let rows = measured.rows.iter().enumerate().filter(|(_, row)| row.is_within(tolerance));
    measured.cheapest = rows.min_by(|a, b| a.1.time().total_cmp(&b.1.time())).map(|(at, _)| at);
}

/// Whether a velocity history has something to say about a case: a projectile that the fabric can slow down.
pub fn is_measurable(case: &Case) -> bool {
    output::flies_freely(case)
}
