//! Shots on a device: those that go together in one batch, each as if it were alone.

use tracing::debug;

use super::fire::{Ready, ready};
use super::{BatchError, BatchOptions, ShotOrder, ShotRow};
use crate::case::Case;
use crate::gpu::{Device, DeviceError};
use crate::run::Run;
use crate::run::graphics::{DeviceBatch, DeviceUse, PreparedShot};

/// Memory of the device that a batch may take [bytes].
const MEMORY: u64 = 4 << 30;
/// Shots that wait for others to go with, at most: they lie in the memory of the host.
const WAITING: usize = 2048;

/// Shots that go together.
type Group = Vec<(ShotOrder, PreparedShot)>;

/// Computes shots on a device and hands their rows over as they end, in any order; tells what they took of it.
///
/// # Errors
/// What `done` refuses, the end that the user has asked for, or that the device was lost. Shots under way are given up then.
pub(super) fn fire(
    case: &Case,
    orders: &[ShotOrder],
    device: &Device,
    options: &BatchOptions<'_>,
    done: &mut dyn FnMut(ShotRow) -> Result<(), BatchError>,
) -> Result<DeviceUse, BatchError> {
    let mut range = Range { device, options, batch: None, total: DeviceUse::default() };
    let mut groups: Vec<Group> = Vec::new();
    for order in orders {
        if options.stopped() {
            return Err(BatchError::Interrupted);
        }
        let shot = match ready(case, *order, options) {
            Ok(shot) => shot,
            Err(row) => {
                done(*row)?;
                continue;
            }
        };
        let Ready { case, velocity, drawn } = shot;
        let shot = match PreparedShot::new(case) {
            Ok(shot) => shot,
            Err(error) => {
                done(ShotRow::of_failure(*order, velocity, drawn, &error.to_string()))?;
                continue;
            }
        };
        let at = groups.iter().position(|group| group[0].1.goes_with(&shot)).unwrap_or(groups.len());
        if at == groups.len() {
            groups.push(Vec::new());
        }
        groups[at].push((*order, shot));
        let full = groups[at].len() as u64 >= groups[at][0].1.room(device, MEMORY);
        if full || groups.iter().map(Vec::len).sum::<usize>() >= WAITING {
            let largest = (0..groups.len()).rev().max_by_key(|at| groups[*at].len()).unwrap_or(at);
            range.fire(groups.swap_remove(if full { at } else { largest }), done)?;
        }
    }
    for group in groups {
        range.fire(group, done)?;
    }
    range.add_use();
    Ok(range.total)
}

/// A device with the pipelines of the last batch.
struct Range<'a> {
    device: &'a Device,
    options: &'a BatchOptions<'a>,
    batch: Option<DeviceBatch<'a>>,
    total: DeviceUse,
}

impl<'a> Range<'a> {
    fn fire(
        &mut self,
        group: Group,
        done: &mut dyn FnMut(ShotRow) -> Result<(), BatchError>,
    ) -> Result<(), BatchError> {
        let (mut orders, mut shots): (Vec<ShotOrder>, Vec<PreparedShot>) = group.into_iter().unzip();
        while let Some(first) = shots.first() {
            let taken = match self.batch_for(first, shots.len()) {
                Ok(batch) => shots.len().min(batch.device_use().room as usize),
                Err(lost @ DeviceError::Lost { .. }) => return Err(BatchError::Device(lost)),
                Err(error) => {
                    for (order, shot) in orders.iter().zip(&shots) {
                        let velocity = shot.case.projectile.as_ref().map_or(0.0, |projectile| projectile.velocity);
                        done(ShotRow::of_failure(*order, velocity, shot.case.drawn.clone(), &error.to_string()))?;
                    }
                    return Ok(());
                }
            };
            let (later_orders, later_shots) = (orders.split_off(taken), shots.split_off(taken));
            self.fire_together(&orders, &shots, done)?;
            (orders, shots) = (later_orders, later_shots);
        }
        Ok(())
    }

    /// The batch that takes so many shots like this one, or as many of them as there is memory for.
    fn batch_for(&mut self, shot: &PreparedShot, count: usize) -> Result<&mut DeviceBatch<'a>, DeviceError> {
        if !self.batch.as_ref().is_some_and(|batch| batch.takes(shot, count)) {
            self.add_use();
            let mut room = shot.room(self.device, MEMORY).min(count as u64);
            let batch = loop {
                match DeviceBatch::new(self.device, shot, room) {
                    Err(DeviceError::OutOfMemory { .. }) if room > 1 => room /= 2,
                    made => break made?,
                }
            };
            self.batch = Some(batch);
        }
        self.batch.as_mut().ok_or(DeviceError::NoAdapter)
    }

    fn fire_together(
        &mut self,
        orders: &[ShotOrder],
        shots: &[PreparedShot],
        done: &mut dyn FnMut(ShotRow) -> Result<(), BatchError>,
    ) -> Result<(), BatchError> {
        let Some(batch) = &mut self.batch else { return Ok(()) };
        let mut refused = None;
        let mut ended = |number: usize, run: &Run| {
            refused = done(ShotRow::of_run(orders[number], &shots[number].case, run)).err();
            refused.is_none()
        };
        debug!(shots = shots.len(), "batch of shots on the device");
        let all = batch.fire(shots, self.options.interrupt, &mut ended).map_err(BatchError::Device)?;
        match refused {
            Some(error) => Err(error),
            None if !all => Err(BatchError::Interrupted),
            None => Ok(()),
        }
    }

    /// Counts what the last batch took, which comes to its end.
    fn add_use(&mut self) {
        let Some(batch) = self.batch.take() else { return };
        self.total = self.total.with(batch.device_use());
    }
}
