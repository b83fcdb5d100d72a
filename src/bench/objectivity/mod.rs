//! Objectivity: how far ballistic limit and residual velocity depend on what is numerical.
//!
//! A result worth having is that of the fabric, not of the mesh, the time step, the place in a cell that the projectile
//! happens to hit, or the way contact is sampled. Each of these is varied alone. For every setting the ballistic limit is
//! bisected, the residual velocity at one and a half times the limit of the reference is read, and the velocity history
//! before the first broken yarn is compared with the reference's. Shots moved by a nanometre tell what of a difference is
//! chance: once yarns break, a shot near its limit is sensitive to anything.

pub mod axes;
pub mod limit;
pub mod report;

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::{BenchError, Subject, complete};
use crate::case::Case;
use crate::outcome::Outcome;
use crate::output::{history, velocity_left};
use crate::simulation::{self, Options, Run, Sample};

pub use axes::{Axis, Setting};
pub use limit::Limit;

/// Velocity of the shots whose residual velocity is compared, over the limit of the reference [-].
pub const ABOVE: f64 = 1.5;
/// A shot near its limit takes longer than one that the case was made for: end times are so many times longer [-].
const PATIENCE: f64 = 4.0;

/// How to measure.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Runs at a time, one thread each.
    pub threads: usize,
    /// A part of the settings.
    pub quick: bool,
    /// Width of the bracket at which bisection ends, over the limit [-].
    pub width: f64,
}

/// What one setting gave.
#[derive(Clone, Debug)]
pub struct Row {
    /// The setting.
    pub setting: Setting,
    /// Where the limit lies; none where no bracket was found.
    pub limit: Option<Limit>,
    /// Velocity left at [`ABOVE`] times the limit of the reference [m/s]; none where there is no such limit.
    pub residual: Option<f64>,
    /// When the first yarn of the case as it is breaks [s].
    pub first_failure: Option<f64>,
    /// Largest difference of velocity to the reference before either's first broken yarn, over the velocity the
    /// reference lost until then [-].
    pub before_failure: Option<f64>,
    /// Shots without an outcome, which count as not perforated.
    pub undecided: u32,
    /// Shots that became unstable, which count as not perforated.
    pub unstable: u32,
    /// Shots in all.
    pub shots: u32,
}

/// Everything measured on a case.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The case as it is.
    pub case: Case,
    /// Of every setting that was done, the reference first.
    pub rows: Vec<Row>,
    /// Whether the user stopped it.
    pub interrupted: bool,
}

/// Measures every setting; `progress` is told how many are done, and of how many.
///
/// # Errors
/// When the case, or one with a setting, is refused or does not start.
pub fn measure(
    subject: &Subject,
    plan: Plan,
    interrupt: &AtomicBool,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<Measured, BenchError> {
    let case = subject.case(&[])?;
    let settings = axes::settings(&case, plan.quick);
    let all = settings.len();
    let shooter = |setting: &Setting| Shooter::new(subject, &case, setting, interrupt);
    let mut settings = settings.into_iter();
    let mut rows = Vec::new();
    let Some(first) = settings.next() else { return Ok(Measured { case, rows, interrupted: false }) };
    progress(0, all);
    let mut reference = shooter(&first);
    let guess = case.projectile.as_ref().map_or(0.0, |projectile| projectile.velocity);
    let limit = reference.limit(guess, plan.width)?;
    let as_it_is = reference.shoot(None)?;
    let above = limit.map(|limit| ABOVE * limit.middle());
    rows.push(reference.row(first, limit, above, &as_it_is, &as_it_is)?);
    let rest: Vec<Setting> = settings.collect();
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(1));
    let found: Mutex<Vec<(usize, Result<Row, BenchError>)>> = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..plan.threads.max(1) {
            scope.spawn(|| {
                while let Some((at, setting)) = take(&rest, &next, interrupt) {
                    let mut own = shooter(setting);
                    let row = own.whole(setting, limit.map_or(guess, |limit| limit.middle()), above, plan, &as_it_is);
                    // Of a setting that was interrupted nothing is kept.
                    if let Ok(mut found) = found.lock()
                        && !interrupt.load(Ordering::Relaxed)
                    {
                        found.push((at, row));
                    }
                    progress(done.fetch_add(1, Ordering::Relaxed) + 1, all);
                }
            });
        }
    });
    let mut found = found.into_inner().unwrap_or_default();
    found.sort_by_key(|(at, _)| *at);
    for (_, row) in found {
        rows.push(row?);
    }
    Ok(Measured { case, rows, interrupted: interrupt.load(Ordering::Relaxed) })
}

/// The next setting to work on.
fn take<'a>(rest: &'a [Setting], next: &AtomicUsize, interrupt: &AtomicBool) -> Option<(usize, &'a Setting)> {
    let at = next.fetch_add(1, Ordering::Relaxed);
    rest.get(at).filter(|_| !interrupt.load(Ordering::Relaxed)).map(|setting| (at, setting))
}

/// Shoots with one setting, on one thread, and counts what became of the shots.
struct Shooter<'a> {
    subject: &'a Subject,
    sets: Vec<String>,
    interrupt: &'a AtomicBool,
    undecided: u32,
    unstable: u32,
    shots: u32,
}

impl<'a> Shooter<'a> {
    fn new(subject: &'a Subject, case: &Case, setting: &Setting, interrupt: &'a AtomicBool) -> Self {
        let end = format!("/solver/end_time_us={:?}", PATIENCE * case.solver.end_time * 1e6);
        let sets = std::iter::once(end).chain(setting.sets.iter().cloned()).collect();
        Self { subject, sets, interrupt, undecided: 0, unstable: 0, shots: 0 }
    }

    /// One shot, at the case's velocity or another [m/s].
    fn shoot(&mut self, velocity: Option<f64>) -> Result<Run, BenchError> {
        let velocity = velocity.map(|velocity| format!("/projectile/velocity_m_s={velocity:?}"));
        let sets: Vec<String> = self.sets.iter().cloned().chain(velocity).collect();
        let case = self.subject.case(&sets)?;
        let options = Options { threads: Some(1), ..Options::default() };
        let run = simulation::run(&case, options, self.interrupt, &mut ())?;
        self.shots += 1;
        self.undecided += u32::from(run.outcome == Outcome::Running && run.trouble.is_none());
        self.unstable += u32::from(!complete(&run));
        Ok(run)
    }

    /// The ballistic limit, from a guess [m/s].
    fn limit(&mut self, guess: f64, width: f64) -> Result<Option<Limit>, BenchError> {
        limit::bisect(guess, width, |velocity| {
            if self.interrupt.load(Ordering::Relaxed) {
                return Ok(true); // ends the search soon; nothing of an interrupted one is kept
            }
            let run = self.shoot(Some(velocity))?;
            Ok(complete(&run) && run.outcome == Outcome::Perforated)
        })
    }

    /// Everything about a setting that is not the reference.
    fn whole(
        &mut self,
        setting: &Setting,
        guess: f64,
        above: Option<f64>,
        plan: Plan,
        reference: &Run,
    ) -> Result<Row, BenchError> {
        let limit = self.limit(guess, plan.width)?;
        let as_it_is = self.shoot(None)?;
        self.row(setting.clone(), limit, above, &as_it_is, reference)
    }

    fn row(
        &mut self,
        setting: Setting,
        limit: Option<Limit>,
        above: Option<f64>,
        as_it_is: &Run,
        reference: &Run,
    ) -> Result<Row, BenchError> {
        let residual = above.map(|velocity| self.shoot(Some(velocity))).transpose()?;
        Ok(Row {
            setting,
            limit,
            residual: residual.filter(complete).as_ref().and_then(velocity_left),
            first_failure: first_failure(as_it_is),
            before_failure: before_failure(reference, as_it_is),
            undecided: self.undecided,
            unstable: self.unstable,
            shots: self.shots,
        })
    }
}

/// When the first yarn breaks [s].
fn first_failure(run: &Run) -> Option<f64> {
    run.events.first().map(|event| event.step as f64 * run.time_step)
}

/// The velocity along the line of flight, as a column.
const VELOCITY: history::Column =
    history::Column { name: "projectile_velocity_m_s", read: |sample| sample.projectile_velocity };

/// Largest difference of velocity before either's first broken yarn, over the velocity the reference lost until then [-].
fn before_failure(reference: &Run, run: &Run) -> Option<f64> {
    let last = |run: &Run| run.history.last().map_or(0.0, |row| row.time);
    let end = [reference, run].map(|run| first_failure(run).unwrap_or(f64::INFINITY).min(last(run)));
    let end = end[0].min(end[1]);
    let at = |history: &[Sample], time: f64| history::at(history, &VELOCITY, time);
    let lost = at(&reference.history, 0.0)? - at(&reference.history, end)?;
    let times = run.history.iter().map(|row| row.time).filter(|time| *time <= end);
    let mut largest: f64 = 0.0;
    for time in times {
        largest = largest.max((at(&run.history, time)? - at(&reference.history, time)?).abs());
    }
    (lost > 0.0).then(|| largest / lost)
}
