//! Whole shots in parallel, one thread each. Whoever is done takes the next. On a device see `on_device`.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

use super::{BatchError, BatchOptions, DeviceRunner, ShotOrder, ShotRow};
use crate::case::{self, Case, CaseError, Drawn};
use crate::run::batch::DeviceUse;
use crate::run::{self, Options};

/// The case of a shot, as `ripstop run` would run it.
///
/// # Errors
/// When something was drawn that its key does not allow.
pub fn order_case(case: &Case, seed: u32, order: ShotOrder) -> Result<Case, CaseError> {
    case::realisation(case, seed, order.shot, order.velocity)
}

/// Computes shots and hands their rows over as they end, in any order; tells what they took of a device.
///
/// # Errors
/// What `done` refuses, the end that the user has asked for, or a device that was lost. Shots under way are given up then.
pub fn fire(
    case: &Case,
    orders: &[ShotOrder],
    options: &BatchOptions<'_>,
    done: &mut dyn FnMut(ShotRow) -> Result<(), BatchError>,
) -> Result<DeviceUse, BatchError> {
    if let Some(mut runner) = DeviceRunner::new(options) {
        runner.fire(orders.iter().map(|order| (case, *order)), &mut |_, row| done(row))?;
        return Ok(runner.device_use());
    }
    in_parallel(case, orders, options, done).map(|()| DeviceUse::default())
}

/// On the processor.
fn in_parallel(
    case: &Case,
    orders: &[ShotOrder],
    options: &BatchOptions<'_>,
    done: &mut dyn FnMut(ShotRow) -> Result<(), BatchError>,
) -> Result<(), BatchError> {
    let next = AtomicUsize::new(0);
    let given_up = AtomicBool::new(false);
    let stop = || options.stopped() || given_up.load(Ordering::Relaxed);
    let (sender, receiver) = mpsc::channel();
    let work = |sender: mpsc::Sender<ShotRow>| {
        while !stop() {
            let Some(order) = orders.get(next.fetch_add(1, Ordering::Relaxed)) else { return };
            let Some(row) = shoot(case, *order, options, &given_up) else { return };
            if sender.send(row).is_err() {
                return;
            }
        }
    };
    let mut count = 0;
    let mut refused = None;
    thread::scope(|scope| {
        for _ in 0..options.threads.min(orders.len()) {
            let sender = sender.clone();
            scope.spawn(|| work(sender));
        }
        drop(sender);
        for row in receiver {
            count += 1;
            if let Err(error) = done(row) {
                given_up.store(true, Ordering::Relaxed);
                refused = Some(error);
                break;
            }
        }
    });
    match refused {
        Some(error) => Err(error),
        None if count < orders.len() => Err(BatchError::Interrupted),
        None => Ok(()),
    }
}

/// A shot that can be set up.
pub(super) struct Ready {
    pub(super) case: Case,
    /// Of its projectile [m/s].
    pub(super) velocity: f64,
    pub(super) drawn: Vec<Drawn>,
}

/// The case of a shot with nothing that a row does not need; or the row of one that cannot be drawn.
pub(super) fn ready(case: &Case, order: ShotOrder, options: &BatchOptions<'_>) -> Result<Ready, Box<ShotRow>> {
    let asked = order.velocity.or(case.projectile.as_ref().map(|projectile| projectile.velocity)).unwrap_or(0.0);
    let mut shot = order_case(case, options.seed, order)
        .map_err(|error| Box::new(ShotRow::of_failure(order, asked, Vec::new(), &error.to_string())))?;
    // None of these changes what becomes of the projectile.
    shot.output.frames = 0;
    shot.output.profile_times.clear();
    shot.expect.clear();
    let velocity = shot.projectile.as_ref().map_or(asked, |projectile| projectile.velocity);
    Ok(Ready { velocity, drawn: shot.drawn.clone(), case: shot })
}

/// One shot on the processor; `None` where it was given up.
pub(in crate::study) fn shoot(
    case: &Case,
    order: ShotOrder,
    options: &BatchOptions<'_>,
    given_up: &AtomicBool,
) -> Option<ShotRow> {
    let Ready { case: shot, velocity, drawn } = match ready(case, order, options) {
        Ok(ready) => ready,
        Err(row) => return Some(*row),
    };
    let failure = |reason: &str| Some(ShotRow::of_failure(order, velocity, drawn, reason));
    let run_options =
        Options { threads: Some(options.threads_per_shot), precision: options.precision, ..Options::default() };
    let run = || run::run(&shot, run_options, options.interrupt, &mut ());
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(run)) if run.interrupted || given_up.load(Ordering::Relaxed) => None,
        Ok(Ok(run)) => Some(ShotRow::of_run(order, &shot, &run)),
        Ok(Err(error)) => failure(&error.to_string()),
        Err(_) => failure("a fault of ripstop: the computation ended in a panic; please report it"),
    }
}
