//! A run on a device: to a checkpoint and back.
//!
//! Buffers go into the file as they are, word by word: the device counts energies between two samples, and holds the
//! projectile finer than any number of the host's state does.

use std::io::{self, Write};
use std::time::Duration;

use crate::case::Case;
use crate::gpu::Device;
use crate::gpu::buffers::BufferId;
use crate::gpu::stepper::DeviceStepper;
use crate::run::RunError;
use crate::run::checkpoint::{Checkpoint, CheckpointFault, Checkpointable, Header, write};
use crate::run::graphics::{DeviceLoop, DeviceSimulation};

/// The buffers that later steps depend on. The others hold nothing from one step to the next, but failures already told.
const KEPT: [BufferId; 9] = [
    BufferId::Nodes,
    BufferId::Forces,
    BufferId::Heights,
    BufferId::Flags,
    BufferId::Accounts,
    BufferId::Status,
    BufferId::Supports,
    BufferId::Body,
    BufferId::Over,
];

impl DeviceStepper<'_> {
    fn kept(&self) -> impl Iterator<Item = BufferId> + use<> {
        let yarns = (self.sizes.yarn_fields > 0).then_some(BufferId::Yarns);
        KEPT.into_iter().chain(yarns)
    }
}

impl Checkpointable for DeviceSimulation<'_> {
    fn time(&self) -> f64 {
        self.device_loop.time_of(self.device_loop.next)
    }

    /// After the last step sent off, whose results must have been taken over; see [`DeviceSimulation::settle`].
    fn save(&self, head: &Header, followed: &[u8], to: &mut dyn Write) -> io::Result<()> {
        let DeviceLoop { stepper, next, sampled, .. } = &self.device_loop;
        let mut head = Header { step: *next, time: self.time(), time_step: self.model.dt, ..head.clone() };
        head.spent.waited = stepper.waited.as_secs_f64();
        write(to, &head, followed, |contents| {
            contents.value(&self.shot().balance)?;
            contents.value(&self.shot().record)?;
            contents.value(&(sampled, stepper.events_read[0]))?;
            contents.value(&stepper.times)?;
            for name in stepper.kept() {
                contents.numbers(&stepper.read(name).map_err(io::Error::other)?)?;
            }
            Ok(())
        })
    }
}

impl<'a> DeviceSimulation<'a> {
    /// A run that goes on from a checkpoint, bit by bit as the one that wrote it.
    ///
    /// # Errors
    /// When the case cannot become a model, the device cannot hold it, or the checkpoint is not one of it.
    pub fn resume(case: &Case, device: &'a Device, checkpoint: &Checkpoint) -> Result<Self, RunError> {
        let head = checkpoint.head();
        let mut simulation = Self::with_skips(case, device, head.skips)?;
        checkpoint.contents(|contents| {
            simulation.shot_mut().balance = contents.value("sums of energy")?;
            simulation.shot_mut().record = contents.value("results so far")?;
            if !simulation.shot().record.fits(&simulation.model) {
                return Err(CheckpointFault::Contents("results so far"));
            }
            let DeviceLoop { stepper, sampled, .. } = &mut simulation.device_loop;
            (*sampled, stepper.events_read[0]) = contents.value("counts of the device")?;
            if stepper.events_read[0] > 2 * stepper.sizes.elements {
                return Err(CheckpointFault::Contents("counts of the device"));
            }
            stepper.times = contents.value("time that each kernel took")?;
            for name in stepper.kept() {
                let mut words = vec![0_u32; (stepper.sizes.bytes(name) / 4) as usize];
                contents.numbers(&mut words, name.variable())?;
                stepper.write(name, &words);
            }
            stepper.waited = Duration::try_from_secs_f64(head.spent.waited).unwrap_or_default();
            Ok(())
        })?;
        simulation.device_loop.next = head.step;
        simulation.shot_mut().step = head.step;
        Ok(simulation)
    }
}
