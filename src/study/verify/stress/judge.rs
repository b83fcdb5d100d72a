//! Runs a scene on one backend and precision, and says whether the run is sound.
//!
//! Sound is: every number finite, every unit cell converged, the ledger closed, no energy that was never put in.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};

use super::disturbance::Perturbation;
use super::law_path::LawPath;
use crate::case::{Case, Rotation, Shape};
use crate::gpu::Device;
use crate::kernels::rigid_body::RigidBody;
use crate::output::history;
use crate::run::graphics;
use crate::run::{Precision, Run, RunError, RunScalar, Sample, Simulation};
use crate::solver;
use crate::solver::energy_balance::Balance;

/// What computes a scene.
#[derive(Clone, Copy, Debug)]
pub enum StressBackend<'a> {
    /// The processor, in a number type.
    Cpu(Precision),
    /// A graphics processor, in f32.
    Gpu(&'a Device),
}

impl StressBackend<'_> {
    /// Short name for the table.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Cpu(Precision::F64) => "cpu f64",
            Self::Cpu(Precision::F32) => "cpu f32",
            Self::Gpu(_) => "gpu f32",
        }
    }

    /// Whether the state is in double precision.
    pub(super) fn is_double(&self) -> bool {
        matches!(self, Self::Cpu(Precision::F64))
    }
}

/// What is wrong with a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// The program panicked.
    Panic,
    /// The device was lost.
    Lost,
    /// The run stopped itself: a number that is not finite, or energy that was never put in.
    Unstable,
    /// A number of the result is not finite, though the run did not notice.
    NotFinite,
    /// Unit cells without equilibrium.
    Unconverged,
    /// The ledger does not close.
    Ledger,
    /// More energy, by state functions, than was put in.
    Energy,
    /// What the scene was made for did not happen.
    Missed,
}

/// A run that is not sound.
#[derive(Clone, Debug, PartialEq)]
pub struct Unsound {
    /// What kind of.
    pub kind: FaultKind,
    /// In words, with the number and its bound.
    pub what: String,
}

impl Unsound {
    pub(super) fn new(kind: FaultKind, what: impl Into<String>) -> Self {
        Self { kind, what: what.into() }
    }
}

/// Why there is no run to judge.
#[derive(Clone, Debug)]
pub(super) enum SkipReason {
    /// The case cannot become a model: a named diagnosis.
    Refused(String),
    /// The device does not compute such a case, or cannot hold it: a named diagnosis.
    Unable(String),
    /// The program panicked.
    Panicked(String),
    /// Stopped by the user.
    Interrupted,
}

/// A run, and what was not finite in the state it left behind.
pub(super) struct Finished {
    pub(super) run: Run,
    /// What rounding makes of the energy of the scene [J].
    rounding: f64,
    /// Energy that the scene begins with [J].
    start: f64,
    /// Energy put in by the end, which what is gained is measured against [J].
    given: f64,
    /// Whether a drive keeps the projectile's velocity up: its energy is no part of the scene's.
    driven: bool,
    left: Option<String>,
}

/// Runs a case. `disturbance` changes the state on the way, which a case cannot.
pub(super) fn run(
    case: &Case,
    machine: StressBackend<'_>,
    disturbance: Option<Perturbation>,
    interrupt: &AtomicBool,
) -> Result<Finished, SkipReason> {
    let work = || match machine {
        StressBackend::Cpu(Precision::F64) => on_cpu::<f64>(case, disturbance, interrupt),
        StressBackend::Cpu(Precision::F32) => on_cpu::<f32>(case, disturbance, interrupt),
        StressBackend::Gpu(device) => on_gpu(case, device, disturbance, interrupt),
    };
    let finished = caught(work)?.map_err(|error| match error {
        RunError::Device(error) => SkipReason::Unable(error.to_string()),
        other => SkipReason::Refused(other.to_string()),
    })?;
    if interrupt.load(Ordering::Relaxed) { Err(SkipReason::Interrupted) } else { Ok(finished) }
}

/// Does a piece of work that may panic.
pub(super) fn caught<T>(work: impl FnOnce() -> T) -> Result<T, SkipReason> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| SkipReason::Panicked(message(&*panic)))
}

fn message(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message").to_owned()
}

fn on_cpu<S: RunScalar>(
    case: &Case,
    disturbance: Option<Perturbation>,
    interrupt: &AtomicBool,
) -> Result<Finished, RunError> {
    let mut simulation = Simulation::<S>::new(case)?;
    while !simulation.finished(case) && !interrupt.load(Ordering::Relaxed) {
        if let Some(change) = disturbance.filter(|d| d.step() == simulation.state.step) {
            change.apply(&simulation.model, &mut simulation.state);
        }
        simulation.advance(case);
    }
    Ok(finish(simulation))
}

/// The end of a run on the processor.
fn finish<S: RunScalar>(simulation: Simulation<S>) -> Finished {
    let left =
        solver::find_divergence(&simulation.model, &simulation.state).map(|t| format!("{}: {}", t.kernel, t.quantity));
    let body = simulation.model.projectile.clone();
    let rounding = solver::rounding(&simulation.model, body.as_ref());
    Finished::new(simulation.into_run(0.0), body.as_ref(), rounding, left)
}

fn on_gpu(
    case: &Case,
    device: &Device,
    disturbance: Option<Perturbation>,
    interrupt: &AtomicBool,
) -> Result<Finished, RunError> {
    let mut simulation = graphics::DeviceSimulation::new(case, device)?;
    if let Some(change) = disturbance {
        simulation = simulation.with_state(|model, state| change.apply(model, state));
    }
    while !simulation.finished() && !interrupt.load(Ordering::Relaxed) {
        simulation.advance(case);
    }
    let body = simulation.model.projectile.clone();
    let rounding = solver::rounding(&simulation.model, body.as_ref());
    Ok(Finished::new(simulation.into_run(0.0), body.as_ref(), rounding, None))
}

impl Finished {
    fn new(run: Run, body: Option<&RigidBody>, rounding: f64, left: Option<String>) -> Self {
        let driven = body.filter(|body| body.prescribed);
        let spin = driven.map_or(0.0, RigidBody::rotational_energy);
        let start = run.history.first().map_or(f64::NAN, |row| {
            let b = &row.balance;
            // The leapfrog's kinetic energy of a start at rest is below zero.
            held(b, driven.is_some()).max(b.stored + b.hourglass) + spin
        });
        let start = start.max(solver::MEASURABLE * rounding);
        let work = run.history.iter().map(|row| row.balance.external).fold(0.0, f64::max);
        Self { start, given: start.max(work), driven: driven.is_some(), rounding, run, left }
    }
}

/// Energy there is and was lost, by state functions, less what was put in since the start, what the unit-cell law made and what moving
/// plies apart made [J].
fn held(balance: &Balance, driven: bool) -> f64 {
    let made = balance.law + balance.separation;
    balance.without_projectile() - balance.external - made + if driven { 0.0 } else { balance.projectile }
}

/// Largest energy there is and was lost, by state functions, over the energy put in [-].
pub(super) fn largest_energy(finished: &Finished) -> f64 {
    let Some(first) = finished.run.history.first() else { return f64::NAN };
    let held = |row: &Sample| held(&row.balance, finished.driven);
    let most = finished.run.history.iter().map(held).fold(0.0, f64::max);
    1.0 + (most - held(first)) / finished.given
}

/// What the ledger may miss, over the energy put in [-].
pub(super) fn ledger_bound(case: &Case, machine: StressBackend<'_>) -> f64 {
    let uneven = case
        .projectile
        .as_ref()
        .is_some_and(|p| matches!(p.shape, Shape::Fragment { .. }) && p.rotation == Rotation::Free);
    match (machine.is_double(), case.pack.plies) {
        // Free rotation with three different moments of inertia is second order in the step.
        (true, 1) if uneven => 1e-5,
        // The leapfrog's identity is exact but for rounding ...
        (true, 1) => 1e-9,
        // ... and plies pressed into each other are moved apart against the hourglass stiffness to first order.
        (true, _) => 1e-3,
        // 0.5 % over a shot, spec of the ledger in single precision.
        (false, _) => 5e-3,
    }
}

/// What the energy by state functions may exceed the energy put in by, over it [-]: what the law and ply separation make is told apart.
pub(super) const ENERGY_BOUND: f64 = 0.01;

/// What is wrong with a run; `None`: nothing. `gain`: energy by state functions over what was put in, less one, at most.
pub(super) fn fault(case: &Case, machine: StressBackend<'_>, finished: &Finished, gain: f64) -> Option<Unsound> {
    unsound(finished).or_else(|| unbalanced(case, machine, finished, gain))
}

/// What the energy that the unit-cell law makes by itself hangs on the path of its stretches by, over that energy [-], where it is told along a
/// straight one.
const STRAIGHT_PATH: f64 = 0.2;

/// The largest of an energy in the course of a run, over the energy put in [-].
fn largest(finished: &Finished, of: fn(&Balance) -> f64) -> f64 {
    finished.run.history.iter().map(|row| of(&row.balance).abs()).fold(0.0, f64::max) / finished.given
}

/// Runs a random scene and judges it; `None`: it is sound.
pub(super) fn judge(
    case: &Case,
    machine: StressBackend<'_>,
    interrupt: &AtomicBool,
) -> Result<Option<Unsound>, SkipReason> {
    let finished = run(case, machine, None, interrupt)?;
    let found = fault(case, machine, &finished, ENERGY_BOUND);
    let law = largest(&finished, |balance| balance.law);
    if law == 0.0 || found.as_ref().is_none_or(|fault| fault.kind != FaultKind::Energy) {
        return Ok(found);
    }
    // The law's share again, now along the path that was taken.
    match machine {
        StressBackend::Cpu(Precision::F64) => followed::<f64>(case, machine, interrupt),
        StressBackend::Cpu(Precision::F32) => followed::<f32>(case, machine, interrupt),
        StressBackend::Gpu(_) => Ok(fault(case, machine, &finished, ENERGY_BOUND + STRAIGHT_PATH * law)),
    }
}

/// Runs a scene on the processor and judges it with what the unit-cell law makes along the path of every element.
fn followed<S: RunScalar>(
    case: &Case,
    machine: StressBackend<'_>,
    interrupt: &AtomicBool,
) -> Result<Option<Unsound>, SkipReason> {
    let work = || {
        let mut simulation = Simulation::<S>::new(case)?;
        let mut path = LawPath::new(&simulation.model, &simulation.state);
        let mut made = Vec::new();
        while !simulation.finished(case) && !interrupt.load(Ordering::Relaxed) {
            let law = path.follow(&simulation.model, &simulation.state);
            if simulation.advance(case) {
                made.push(law);
            }
        }
        let mut finished = finish(simulation);
        for (row, made) in finished.run.history.iter_mut().zip(made) {
            row.balance.law = made;
        }
        Ok::<_, RunError>(finished)
    };
    let finished = caught(work)?.map_err(|error| SkipReason::Refused(error.to_string()))?;
    Ok(fault(case, machine, &finished, ENERGY_BOUND))
}

/// Numbers that are not finite or did not converge.
pub(super) fn unsound(finished: &Finished) -> Option<Unsound> {
    let run = &finished.run;
    if let Some(why) = &run.lost {
        return Some(Unsound::new(FaultKind::Lost, why));
    }
    if let Some(t) = &run.divergence {
        let [ply, row, column] = t.place;
        let what = format!("step {} in {} at ply {ply}, row {row}, column {column}: {}", t.step, t.kernel, t.quantity);
        return Some(Unsound::new(FaultKind::Unstable, what));
    }
    if let Some(what) = not_finite(finished) {
        return Some(Unsound::new(FaultKind::NotFinite, what));
    }
    let count = run.newton.unconverged;
    (count > 0).then(|| Unsound::new(FaultKind::Unconverged, format!("{count} unit cells without equilibrium")))
}

/// Roundings of the largest energy that an error may be made of: two sums of nine terms, half a unit in the last place each, and
/// as much for the terms themselves.
const ROUNDINGS: f64 = 10.0;

/// Energy that the ledger misses or that was never put in. A NaN is within no bound.
fn unbalanced(case: &Case, machine: StressBackend<'_>, finished: &Finished, gain: f64) -> Option<Unsound> {
    for row in &finished.run.history {
        // Where next to nothing has been put in by then, rounding is a large part of it.
        let scale = finished.start.max(row.balance.external.abs());
        let bound = ledger_bound(case, machine).max(ROUNDINGS * finished.rounding / scale);
        let error = row.balance.error;
        let closed = error.abs() <= bound;
        if !closed {
            let at = row.time * 1e6;
            let what = format!("energy error {error:.3e} at {at:.3} µs, bound {bound:.1e}");
            return Some(Unsound::new(FaultKind::Ledger, what));
        }
    }
    let (most, bound) = (largest_energy(finished), 1.0 + gain);
    let within = most <= bound;
    if !within {
        return Some(Unsound::new(FaultKind::Energy, format!("energy {most:.4} of what was put in, bound {bound:.3}")));
    }
    None
}

fn not_finite(finished: &Finished) -> Option<String> {
    let run = &finished.run;
    if let Some(left) = &finished.left {
        return Some(left.clone());
    }
    for row in &run.history {
        if let Some(column) = history::COLUMNS.iter().find(|column| !(column.read)(row).is_finite()) {
            return Some(format!("{} at {:.3} µs", column.name, row.time * 1e6));
        }
    }
    let rest = [
        ("residual of the unit cells", run.newton.max_residual),
        ("penetration", run.max_penetration),
        ("penetration of plies", run.max_ply_penetration),
        ("momentum error", run.momentum_error),
        ("hourglass fraction", run.hourglass_fraction),
    ];
    rest.into_iter().find(|(_, x)| !x.is_finite()).map(|(name, x)| format!("{name} = {x}"))
}
