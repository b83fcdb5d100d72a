//! Shots on a device: those with one layout and time step in one batch, each as if it were alone.

use std::sync::atomic::AtomicBool;

use tracing::debug;

use super::batch::{BatchError, BatchOptions, ShotOrder, ready};
use super::shot_table::ShotRow;
use crate::case::Case;
use crate::gpu::{Device, DeviceError};
use crate::run::Run;
use crate::run::batch::{DeviceBatch, DeviceUse, PreparedShot};

/// Device memory of a batch at most [bytes].
const MEMORY: u64 = 4 << 30;
/// Earlier batches that are kept when another is made, and the memory that they may take [bytes]: searches of eight realisations take turns.
const KEPT: (usize, u64) = (7, 512 << 20);
/// Shots that wait for others to go with, at most: they lie in the memory of the host.
const WAITING: usize = 2048;

/// A shot that waits: its number among those to fire, and what was asked for.
type Waiting = (usize, ShotOrder);

/// Shots that go together.
type Group = Vec<(Waiting, PreparedShot)>;

/// Receiver of rows with their numbers among the shots to fire.
type Done<'d> = dyn FnMut(usize, ShotRow) -> Result<(), BatchError> + 'd;

/// Runner of shots on a device, with pipelines and buffers of earlier batches where they serve again.
pub(super) struct DeviceRunner<'a> {
    device: &'a Device,
    options: BatchOptions<'a>,
    /// Batches, that used last at the end.
    batches: Vec<DeviceBatch<'a>>,
    /// Use of batches that are gone.
    total: DeviceUse,
}

impl<'a> DeviceRunner<'a> {
    /// Runner on the device of these options; `None` where they ask for none.
    pub(super) fn new(options: &BatchOptions<'a>) -> Option<Self> {
        Some(Self { device: options.device?, options: *options, batches: Vec::new(), total: DeviceUse::default() })
    }

    /// Computes shots and hands their rows over as they end, in any order, each with its number among `shots`.
    ///
    /// # Errors
    /// An error of `done`, the end that the user has asked for, or a lost device. Shots under way are given up then.
    pub(super) fn fire<'c>(
        &mut self,
        shots: impl Iterator<Item = (&'c Case, ShotOrder)>,
        done: &mut Done<'_>,
    ) -> Result<(), BatchError> {
        let mut groups: Vec<Group> = Vec::new();
        for (number, (case, order)) in shots.enumerate() {
            if self.options.stopped() {
                return Err(BatchError::Interrupted);
            }
            let prepared = ready(case, order, self.options.seed).and_then(|case| {
                PreparedShot::new(case.clone())
                    .map_err(|error| Box::new(ShotRow::of_failure(order, &case, &error.to_string())))
            });
            match prepared {
                Err(row) => done(number, *row)?,
                Ok(shot) => match groups.iter_mut().find(|group| group[0].1.fits(&shot)) {
                    Some(group) => group.push(((number, order), shot)),
                    None => groups.push(vec![((number, order), shot)]),
                },
            }
            if groups.iter().map(Vec::len).sum::<usize>() >= WAITING {
                groups.drain(..).try_for_each(|group| self.fire_group(group, done))?;
            }
        }
        groups.into_iter().try_for_each(|group| self.fire_group(group, done))
    }

    /// Use of the device so far.
    pub(super) fn device_use(&self) -> DeviceUse {
        self.batches.iter().map(DeviceBatch::device_use).fold(self.total, DeviceUse::with)
    }

    fn fire_group(&mut self, group: Group, done: &mut Done<'_>) -> Result<(), BatchError> {
        let (mut orders, mut shots): (Vec<Waiting>, Vec<PreparedShot>) = group.into_iter().unzip();
        while let Some(first) = shots.first() {
            let interrupt = self.options.interrupt;
            match self.batch_for(first, shots.len()) {
                Ok(batch) => {
                    let taken = shots.len().min(batch.device_use().room as usize);
                    let later = (orders.split_off(taken), shots.split_off(taken));
                    fire_together(batch, interrupt, &orders, &shots, done)?;
                    (orders, shots) = later;
                }
                Err(lost @ DeviceError::Lost { .. }) => return Err(BatchError::Device(lost)),
                Err(error) => {
                    let mut lost = orders.iter().zip(&shots);
                    return lost.try_for_each(|((number, order), shot)| {
                        done(*number, ShotRow::of_failure(*order, &shot.case, &error.to_string()))
                    });
                }
            }
        }
        Ok(())
    }

    /// Batch for `count` shots like this one, or for as many of them as there is memory for.
    fn batch_for(&mut self, shot: &PreparedShot, count: usize) -> Result<&mut DeviceBatch<'a>, DeviceError> {
        let batch = match self.batches.iter().position(|batch| batch.takes(shot, count)) {
            Some(at) => self.batches.remove(at),
            None => self.new_batch(shot, count)?,
        };
        self.batches.push(batch);
        self.batches.last_mut().ok_or(DeviceError::NoAdapter)
    }

    fn new_batch(&mut self, shot: &PreparedShot, count: usize) -> Result<DeviceBatch<'a>, DeviceError> {
        let bytes = |batches: &[DeviceBatch<'_>]| batches.iter().map(|batch| batch.device_use().bytes).sum::<u64>();
        while self.batches.len() > KEPT.0 || bytes(&self.batches) > KEPT.1 {
            self.drop_oldest();
        }
        let mut room = shot.room(self.device, MEMORY).min(count as u64);
        loop {
            match DeviceBatch::new(self.device, shot, room) {
                Err(DeviceError::OutOfMemory { .. }) if !self.batches.is_empty() => self.drop_oldest(),
                Err(DeviceError::OutOfMemory { .. }) if room > 1 => room /= 2,
                made => return made,
            }
        }
    }

    fn drop_oldest(&mut self) {
        let used = self.batches.remove(0).device_use();
        self.total = self.total.with(used);
    }
}

/// Fires shots that a batch takes.
fn fire_together(
    batch: &mut DeviceBatch<'_>,
    interrupt: &AtomicBool,
    orders: &[Waiting],
    shots: &[PreparedShot],
    done: &mut Done<'_>,
) -> Result<(), BatchError> {
    let mut refused = None;
    let mut ended = |at: usize, run: &Run| {
        let (number, order) = orders[at];
        refused = done(number, ShotRow::of_run(order, &shots[at].case, run)).err();
        refused.is_none()
    };
    debug!(shots = shots.len(), "batch of shots on the device");
    let all = batch.fire(shots, interrupt, &mut ended).map_err(BatchError::Device)?;
    match refused {
        Some(error) => Err(error),
        None if !all => Err(BatchError::Interrupted),
        None => Ok(()),
    }
}
