//! Objectivity: how far ballistic limit, absorbed energy and residual velocity depend on what is numerical.
//!
//! A result worth having is that of the fabric, not of the mesh, the time step, the place in a cell that the projectile
//! happens to hit, or the way contact is sampled. Each of these is varied alone. For every setting the ballistic limit is
//! bisected, the energy absorbed at five velocities above the limit of the reference is read, and the velocity history
//! before the first broken yarn is compared with the reference's.
//!
//! Once yarns break, a shot is sensitive to anything. What is chance in a residual velocity, and what is not, is told by shots at places
//! that nobody could tell apart ([`scatter`]): their scatter says what one shot is worth, their means what settings do.

pub mod axes;
pub mod limit;
pub mod report;
pub mod scatter;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::error::velocity_at;
use super::{BenchError, CaseSource, complete};
use crate::case::Case;
use crate::output;
use crate::run::outcome::Outcome;
use crate::run::{self, Options, Run};
use crate::study::threads::side_by_side;

pub use axes::{Setting, VariedAxis};
pub use limit::VelocityBracket;
pub use scatter::Scatter;

/// Velocity of the shots whose residual velocity is compared, over the limit of the reference [-].
pub const ABOVE: f64 = 1.5;
/// Velocities of the shots whose absorbed energy is compared, over the limit of the reference [-].
pub const FACTORS: [f64; 5] = [1.05, 1.2, ABOVE, 2.0, 3.0];
/// A shot near its limit takes longer than one that the case was made for: end times are so many times longer [-].
const PATIENCE: f64 = 4.0;

/// How to measure.
#[derive(Clone, Copy, Debug)]
pub struct ObjectivityPlan {
    /// Runs at a time, one thread each.
    pub threads: usize,
    /// A part of the settings.
    pub quick: bool,
    /// Width of the bracket at which bisection ends, over the limit [-].
    pub width: f64,
}

/// What one setting gave.
#[derive(Clone, Debug)]
pub struct ObjectivityRow {
    /// The setting.
    pub setting: Setting,
    /// Where the limit lies; none where no bracket was found.
    pub limit: Option<VelocityBracket>,
    /// Velocity left at [`ABOVE`] times the limit of the reference [m/s], of one shot; none where there is no such limit.
    pub residual: Option<f64>,
    /// Energy absorbed at [`FACTORS`] times the limit of the reference [J]; none where a shot became unstable or has no outcome, empty
    /// where there is no limit.
    pub absorbed: Vec<Option<f64>>,
    /// The same of many shots that nobody could tell apart, where a figure is asked; none where one became unstable.
    pub scatter: Option<Scatter>,
    /// When the first yarn of the case as it is breaks [s].
    pub first_failure: Option<f64>,
    /// Largest difference of velocity to the reference before either's first broken yarn, over the velocity the
    /// reference lost until then [-].
    pub before_failure: Option<f64>,
    /// The shots it took.
    pub shots: Shots,
}

/// How many shots, and what became of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Shots {
    /// In all.
    pub all: u32,
    /// Without an outcome; they count as not perforated.
    pub undecided: u32,
    /// That became unstable; they count as not perforated.
    pub unstable: u32,
}

impl Shots {
    fn add(&mut self, other: Self) {
        self.all += other.all;
        self.undecided += other.undecided;
        self.unstable += other.unstable;
    }
}

/// Everything measured on a case.
#[derive(Clone, Debug)]
pub struct ObjectivityResult {
    /// The case as it is.
    pub case: Case,
    /// Of every setting that was done, the reference first.
    pub rows: Vec<ObjectivityRow>,
    /// Whether the user stopped it.
    pub interrupted: bool,
}

/// Something to be done for a setting, on one thread.
#[derive(Clone, Copy, Debug)]
enum Task {
    /// All but the scatter.
    Row(usize),
    /// One shot of the scatter, so far from the setting's place [mm].
    Shot(usize, [f64; 2]),
}

/// What came of it, for which setting.
enum Answer {
    Row(usize, ObjectivityRow),
    /// Velocity left [m/s].
    Left(usize, Option<f64>, Shots),
}

/// Measures every setting; `progress` is told how many parts are done, and of how many.
///
/// # Errors
/// When the case, or one with a setting, is refused or does not start.
pub fn measure(
    subject: &CaseSource,
    plan: ObjectivityPlan,
    interrupt: &AtomicBool,
    progress: &(dyn Fn(usize, usize) + Sync),
) -> Result<ObjectivityResult, BenchError> {
    let case = subject.case(&[])?;
    let settings = axes::settings(&case, plan.quick);
    let count = if plan.quick { scatter::SHOTS_QUICK } else { scatter::SHOTS };
    let with_mean: Vec<usize> = (0..settings.len()).filter(|at| settings[*at].axis.asks_for_a_mean()).collect();
    let all = settings.len() + with_mean.len() * count;
    progress(0, all);
    let shooter = |at: usize| LimitRunner::new(subject, &case, &settings[at], interrupt);

    let mut reference = shooter(0);
    let guess = case.projectile.as_ref().map_or(0.0, |projectile| projectile.velocity);
    let limit = reference.limit(guess, plan.width)?;
    let as_it_is = reference.shoot(&[])?;
    let above = limit.map(|limit| ABOVE * limit.middle());
    let first = reference.row(&settings[0], limit, above, &as_it_is, &as_it_is)?;

    let rows = (1..settings.len()).map(Task::Row);
    let shots = with_mean.iter().flat_map(|&at| scatter::shifts(count).map(move |shift| Task::Shot(at, shift)));
    let tasks: Vec<Task> = rows.chain(shots.filter(|_| above.is_some())).collect();
    let guess = limit.map_or(guess, |limit| limit.middle());
    let answer = |task| match task {
        Task::Row(at) => {
            let mut own = shooter(at);
            let limit = own.limit(guess, plan.width)?;
            let run = own.shoot(&[])?;
            own.row(&settings[at], limit, above, &run, &as_it_is).map(|row| Answer::Row(at, row))
        }
        Task::Shot(at, shift) => {
            let mut own = shooter(at);
            let left = own.shifted(above.unwrap_or_default(), shift)?;
            Ok(Answer::Left(at, left, own.shots))
        }
    };
    let done = AtomicUsize::new(1);
    let stopped = || interrupt.load(Ordering::Relaxed);
    // What is begun after an interruption, or broken off by it, is left out.
    let answers = side_by_side(plan.threads.max(1), 0..tasks.len(), |number| {
        let answer = (!stopped()).then(|| answer(tasks[number]))?;
        progress(done.fetch_add(1, Ordering::Relaxed) + 1, all);
        (!stopped()).then_some(answer)
    });

    let mut rows = vec![(0, first)];
    let mut left = vec![Vec::new(); settings.len()];
    for answer in answers.into_iter().flatten() {
        match answer? {
            Answer::Row(at, row) => rows.push((at, row)),
            Answer::Left(at, velocity, shots) => left[at].push((velocity, shots)),
        }
    }
    for (at, row) in &mut rows {
        left[*at].iter().for_each(|(_, shots)| row.shots.add(*shots));
        let velocities: Option<Vec<f64>> = left[*at].iter().map(|(velocity, _)| *velocity).collect();
        row.scatter = velocities.filter(|all| all.len() == count).and_then(|all| Scatter::of(&all));
    }
    let rows = rows.into_iter().map(|(_, row)| row).collect();
    Ok(ObjectivityResult { case, rows, interrupted: stopped() })
}

/// Shoots with one setting, on one thread, and counts what became of the shots.
struct LimitRunner<'a> {
    subject: &'a CaseSource,
    sets: Vec<String>,
    interrupt: &'a AtomicBool,
    shots: Shots,
}

impl<'a> LimitRunner<'a> {
    fn new(subject: &'a CaseSource, case: &Case, setting: &Setting, interrupt: &'a AtomicBool) -> Self {
        let end = format!("/solver/end_time_us={:?}", PATIENCE * case.solver.end_time * 1e6);
        let sets = std::iter::once(end).chain(setting.sets.iter().cloned()).collect();
        Self { subject, sets, interrupt, shots: Shots::default() }
    }

    /// One shot, with changes.
    fn shoot(&mut self, changes: &[String]) -> Result<Run, BenchError> {
        let sets: Vec<String> = self.sets.iter().chain(changes).cloned().collect();
        let case = self.subject.case(&sets)?;
        let options = Options { threads: Some(1), ..Options::default() };
        let run = run::run(&case, options, self.interrupt, &mut ())?;
        self.shots.add(Shots {
            all: 1,
            undecided: u32::from(run.outcome == Outcome::Running && run.divergence.is_none()),
            unstable: u32::from(!complete(&run)),
        });
        Ok(run)
    }

    /// The velocity left [m/s] of a shot at a velocity [m/s], so far from the place that is meant [mm].
    fn shifted(&mut self, velocity: f64, shift: [f64; 2]) -> Result<Option<f64>, BenchError> {
        let place = axes::offset(&self.subject.case(&self.sets)?, shift);
        Ok(scatter::left(&self.shoot(&[at_velocity(velocity), place])?))
    }

    /// The ballistic limit, from a guess [m/s].
    fn limit(&mut self, guess: f64, width: f64) -> Result<Option<VelocityBracket>, BenchError> {
        limit::bisect(guess, width, |velocity| {
            if self.interrupt.load(Ordering::Relaxed) {
                return Ok(true); // ends the search soon; nothing of an interrupted one is kept
            }
            let run = self.shoot(&[at_velocity(velocity)])?;
            Ok(complete(&run) && run.outcome == Outcome::Perforated)
        })
    }

    /// All but the scatter. `as_it_is`: the shot at the case's velocity.
    fn row(
        &mut self,
        setting: &Setting,
        limit: Option<VelocityBracket>,
        above: Option<f64>,
        as_it_is: &Run,
        reference: &Run,
    ) -> Result<ObjectivityRow, BenchError> {
        let velocities = above.map(|above| FACTORS.map(|factor| factor / ABOVE * above));
        let runs = velocities.into_iter().flatten().map(|velocity| self.shoot(&[at_velocity(velocity)]));
        let runs = runs.collect::<Result<Vec<Run>, _>>()?;
        let residual = FACTORS.iter().zip(&runs).find(|(factor, _)| **factor == ABOVE).map(|(_, run)| run);
        let decided = |run: &Run| complete(run) && run.outcome != Outcome::Running;
        Ok(ObjectivityRow {
            setting: setting.clone(),
            limit,
            scatter: None,
            residual: residual.and_then(scatter::left),
            absorbed: runs.iter().map(|run| decided(run).then(|| output::absorbed_energy(run))).collect(),
            first_failure: first_failure(as_it_is),
            before_failure: before_failure(reference, as_it_is),
            shots: self.shots,
        })
    }
}

/// The change that makes a shot one of this velocity [m/s].
fn at_velocity(velocity: f64) -> String {
    format!("/projectile/velocity_m_s={velocity:?}")
}

/// When the first yarn breaks [s].
fn first_failure(run: &Run) -> Option<f64> {
    run.events.first().map(|event| event.step as f64 * run.time_step)
}

/// Largest difference of velocity before either's first broken yarn, over the velocity the reference lost until then [-].
fn before_failure(reference: &Run, run: &Run) -> Option<f64> {
    let last = |run: &Run| run.history.last().map_or(0.0, |row| row.time);
    let end = [reference, run].map(|run| first_failure(run).unwrap_or(f64::INFINITY).min(last(run)));
    let end = end[0].min(end[1]);
    let lost = velocity_at(&reference.history, 0.0)? - velocity_at(&reference.history, end)?;
    let times = run.history.iter().map(|row| row.time).filter(|time| *time <= end);
    let mut largest: f64 = 0.0;
    for time in times {
        largest = largest.max((velocity_at(&run.history, time)? - velocity_at(&reference.history, time)?).abs());
    }
    (lost > 0.0).then(|| largest / lost)
}
