//! Batches of shots on a device: those that share mesh, constants and time step are computed together, each as if it were alone.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use tracing::debug;

use super::device::DeviceLoop;
use super::device_shot::DeviceShot;
use super::{Run, Skips};
use crate::case::Case;
use crate::gpu::buffers::Sizes;
use crate::gpu::layout;
use crate::gpu::shader::Kernel;
use crate::gpu::stepper::DeviceStepper;
use crate::gpu::{Device, DeviceError};
use crate::model::Features;
use crate::model::{Model, ModelError};
use crate::solver;
use crate::solver::state::State;

/// A shot that is ready to be computed.
#[derive(Debug)]
pub struct PreparedShot {
    /// Case of the shot.
    pub case: Case,
    model: Arc<Model<f32>>,
    sizes: Sizes,
    /// Uniforms, features and times that all shots of a batch have in common.
    common: Vec<u8>,
}

impl PreparedShot {
    /// Sets a case up.
    ///
    /// # Errors
    /// When it cannot become a model.
    pub fn new(case: Case) -> Result<Self, ModelError> {
        let (model, _) = solver::state::set_up::<f32>(&case, Skips::default().symmetry)?;
        let sizes = Sizes::new(&model);
        let features: Vec<Features> = model.ply_types.iter().map(|own| Features::new(&model, own)).collect();
        let times = [model.dt, case.solver.end_time, case.output.history_interval];
        let mut common = format!("{features:?} {times:?}").into_bytes();
        common.extend_from_slice(bytemuck::cast_slice(&layout::plies(&model)));
        common.extend_from_slice(bytemuck::cast_slice(&layout::lines(&model)));
        for (at, ply_type) in model.ply_types.iter().enumerate() {
            common.extend_from_slice(bytemuck::bytes_of(&layout::scene(&model, at, &sizes)));
            common.extend_from_slice(bytemuck::cast_slice(&layout::law_energy(ply_type)));
        }
        Ok(Self { case, model: Arc::new(model), sizes, common })
    }

    /// Whether it can be computed together with another.
    pub(crate) fn fits(&self, other: &Self) -> bool {
        self.common == other.common
    }

    /// Largest batch of such shots that a device holds in `memory` bytes.
    pub fn room(&self, device: &Device, memory: u64) -> u64 {
        self.sizes.most_shots(&device.limits(), memory)
    }
}

/// Use of a device by shots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeviceUse {
    /// Shots computed.
    pub shots: u64,
    /// Dispatches.
    pub dispatches: u64,
    /// Most shots that there was room for at a time.
    pub room: u64,
    /// Memory of that batch on the device [bytes].
    pub bytes: u64,
}

impl DeviceUse {
    /// Sum with the use by other shots.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        let larger = if other.room >= self.room { other } else { self };
        Self { shots: self.shots + other.shots, dispatches: self.dispatches + other.dispatches, ..larger }
    }
}

/// Pipelines and buffers for batches of shots that are computed together.
pub struct DeviceBatch<'a> {
    common: Vec<u8>,
    device_loop: DeviceLoop<'a>,
    shots: u64,
}

impl<'a> DeviceBatch<'a> {
    /// For `room` shots at a time like this one.
    ///
    /// # Errors
    /// When the device cannot hold them.
    pub fn new(device: &'a Device, shot: &PreparedShot, room: u64) -> Result<Self, DeviceError> {
        let stepper = DeviceStepper::with_sources(device, &shot.model, room, &Kernel::source)?;
        debug!(adapter = device.name(), shots = room, bytes = stepper.sizes().planned(), "room for a batch of shots");
        let state = State::new(&shot.case, &shot.model);
        let device_loop = DeviceLoop::new(stepper, Vec::new(), state);
        Ok(Self { common: shot.common.clone(), device_loop, shots: 0 })
    }

    /// Whether it has room for `count` shots like this one.
    pub fn takes(&self, shot: &PreparedShot, count: usize) -> bool {
        self.common == shot.common && count as u64 <= self.device_loop.stepper.sizes().shots
    }

    /// Use of the device so far.
    pub fn device_use(&self) -> DeviceUse {
        let sizes = self.device_loop.stepper.sizes();
        let dispatches = self.device_loop.stepper.dispatches;
        DeviceUse { shots: self.shots, dispatches, room: sizes.shots, bytes: sizes.planned() }
    }

    /// Computes shots that it takes. `ended` gets the run of each, with its place among them, as soon as it has ended; false ends the others,
    /// as does the user. True where all have ended.
    ///
    /// # Errors
    /// When the device was lost; a failure of a single shot is in its run.
    pub fn fire(
        &mut self,
        shots: &[PreparedShot],
        interrupt: &AtomicBool,
        ended: &mut dyn FnMut(usize, &Run) -> bool,
    ) -> Result<bool, DeviceError> {
        self.begin(shots)?;
        let cases: Vec<&Case> = shots.iter().map(|shot| &shot.case).collect();
        let start = Instant::now();
        let mut reported = vec![false; shots.len()];
        while reported.contains(&false) {
            if interrupt.load(Ordering::Relaxed) {
                return Ok(false);
            }
            self.device_loop.advance(&cases, &mut ())?;
            for (number, reported) in reported.iter_mut().enumerate() {
                if *reported || !self.device_loop.shots[number].ended {
                    continue;
                }
                *reported = true;
                self.shots += 1;
                if !ended(number, &self.device_loop.run_of(number, start.elapsed().as_secs_f64())) {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Puts the states of shots on the device.
    fn begin(&mut self, shots: &[PreparedShot]) -> Result<(), DeviceError> {
        let stepper = &mut self.device_loop.stepper;
        stepper.clear_shots();
        let mut begun = Vec::with_capacity(shots.len());
        for (number, shot) in shots.iter().enumerate() {
            let state = State::new(&shot.case, &shot.model);
            stepper.upload_shot(number, &shot.model, &state);
            // What is on its way lies in memory twice: not that of all shots at once.
            stepper.flush()?;
            begun.push(DeviceShot::new(number, Arc::clone(&shot.model), &state, Skips::default()));
        }
        stepper.set_running((0..shots.len()).collect());
        self.device_loop.begin(begun);
        Ok(())
    }
}
