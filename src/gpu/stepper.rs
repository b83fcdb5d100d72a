//! Steps on the device: pipelines and buffers of shots that share a model, and the stages of a step.

use std::time::Duration;

use super::buffers::{BufferId, IN_FLIGHT, Sizes, spread};
use super::common::Common;
use super::layout::{self, BODY_WORDS, GROUP, LAW_STRIDE, SCENE_STRIDE, STATUS_WORDS, STEP_STRIDE, StepInfo};
use super::program::{self, Program};
use super::shader::{self, Kernel};
use super::timing::{DeviceClock, Timed};
use super::{Device, DeviceError};
use crate::model::{Features, Grid, Model, PlyType};

/// Steps in one submission at most.
pub const BATCH: usize = 256;

/// A part of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// `element_force`
    Elements,
    /// `node_update`
    Nodes,
    /// `ply_search`, `ply_impulse`, `ply_move`
    Plies,
    /// `projectile_points`, and `projectile_contact` with the motion of the body.
    Projectile,
    /// `ledger`
    Ledger,
}

impl Stage {
    /// Its kernel, as scripts know it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Elements => "element_force",
            Self::Nodes => "node_update",
            Self::Plies => "ply_contact",
            Self::Projectile => "projectile_contact",
            Self::Ledger => "energy_balance",
        }
    }
}

/// A whole step, in parts that are timed one by one.
pub(crate) const PARTS: [Stage; 5] = [Stage::Elements, Stage::Nodes, Stage::Plies, Stage::Projectile, Stage::Ledger];
/// Advances the states of shots on a device, all by the same steps.
pub struct DeviceStepper<'a> {
    pub(crate) device: &'a Device,
    pub(crate) sizes: Sizes,
    pub(crate) grid: Grid,
    pub(crate) terms: Features,
    dt: f64,
    /// Per dimension of a dispatch.
    most_workgroups: u32,
    pub(crate) buffers: Vec<wgpu::Buffer>,
    /// Constants of every shot.
    pub(super) constants: Vec<Vec<u32>>,
    /// Numbers of the shots that run.
    pub(crate) running: Vec<usize>,
    pub(super) staging: [wgpu::Buffer; IN_FLIGHT],
    pub(super) submitted: usize,
    /// Dispatches sent off.
    pub(crate) dispatches: u64,
    common: Common,
    /// By ply type: plain, and with the ledger.
    element: Vec<[Program; 2]>,
    node: Program,
    plies: [Program; 3],
    /// None without a projectile.
    contact: Vec<Program>,
    ledger: Program,
    /// Of each shot.
    pub(crate) events_read: Vec<u64>,
    /// Time spent waiting for the device.
    pub(crate) waited: Duration,
    /// Where the device has one.
    pub(super) clock: Option<DeviceClock>,
    pub(crate) timed: Timed,
}

impl<'a> DeviceStepper<'a> {
    /// Pipelines and buffers for one shot of a model; the state is not there yet.
    ///
    /// # Errors
    /// When the device cannot hold the case, or refuses a pipeline.
    pub fn new(device: &'a Device, model: &Model<f32>) -> Result<Self, DeviceError> {
        Self::with_sources(device, model, &Kernel::source)
    }

    /// The same with room for so many shots, whose models differ from this one by what [`layout::shot`] holds, and by the strength of their
    /// yarns alone.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn for_shots(device: &'a Device, model: &Model<f32>, shots: u64) -> Result<Self, DeviceError> {
        Self::checked(device, model, Sizes::new(model).with_shots(shots), &Kernel::source)
    }

    /// As [`Self::new`] with other sources: for tests that break a shader on purpose.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_sources(
        device: &'a Device,
        model: &Model<f32>,
        source: &dyn Fn(&Kernel) -> String,
    ) -> Result<Self, DeviceError> {
        Self::checked(device, model, Sizes::new(model), source)
    }

    fn checked(
        device: &'a Device,
        model: &Model<f32>,
        sizes: Sizes,
        source: &dyn Fn(&Kernel) -> String,
    ) -> Result<Self, DeviceError> {
        sizes.check(&device.limits(), device.name())?;
        let memory = device.inner.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = device.inner.push_error_scope(wgpu::ErrorFilter::Validation);
        let built = Self::build(device, model, sizes, source);
        let [invalid, full] = [validation, memory].map(|scope| pollster::block_on(scope.pop()));
        if let Some(error) = full {
            let adapter = device.name().to_owned();
            return Err(DeviceError::OutOfMemory { adapter, total: sizes.total(), reason: error.to_string() });
        }
        match invalid {
            Some(error) => Err(device.lost(error.to_string())),
            None => Ok(built),
        }
    }

    fn build(device: &'a Device, model: &Model<f32>, sizes: Sizes, source: &dyn Fn(&Kernel) -> String) -> Self {
        let gpu = &device.inner;
        let terms = model.features();
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let buffers = BufferId::ALL.map(|name| device.buffer(name.variable(), sizes.bytes(name), storage)).to_vec();
        let common = Common::new(device, model, &sizes);
        let staging_size = sizes.staging() + STAMP_BYTES;
        let staging = [0; IN_FLIGHT].map(|_| device.buffer("staging", staging_size, wgpu::BufferUsages::MAP_READ));
        let module = |kernel: &Kernel| {
            gpu.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(kernel.name),
                source: wgpu::ShaderSource::Wgsl(source(kernel).into()),
            })
        };
        let program = |kernel: &Kernel, module: &wgpu::ShaderModule, terms: &Features, ledger: bool| {
            program::program(gpu, kernel, module, &common.layout, &buffers, &shader::constants(terms, ledger))
        };
        let single = |kernel: &Kernel, ledger: bool| program(kernel, &module(kernel), &terms, ledger);
        let elements = module(&shader::ELEMENT_FORCE);
        let element = |ply_type: &PlyType<f32>| {
            let terms = Features::new(model, ply_type);
            [false, true].map(|ledger| program(&shader::ELEMENT_FORCE, &elements, &terms, ledger))
        };
        let contact = [&shader::PROJECTILE_POINTS, &shader::PROJECTILE_CONTACT];
        Self {
            element: model.ply_types.iter().map(element).collect(),
            plies: [&shader::PLY_SEARCH, &shader::PLY_IMPULSE, &shader::PLY_MOVE].map(|kernel| single(kernel, false)),
            node: single(&shader::NODE_UPDATE, false),
            contact: contact
                .into_iter()
                .filter(|kernel| kernel.is_in(&terms))
                .map(|kernel| single(kernel, false))
                .collect(),
            ledger: single(&shader::LEDGER, true),
            most_workgroups: device.limits().max_compute_workgroups_per_dimension,
            device,
            sizes,
            grid: model.grid,
            terms,
            dt: model.dt,
            buffers,
            constants: vec![Vec::new(); sizes.shots as usize],
            running: Vec::new(),
            staging,
            submitted: 0,
            dispatches: 0,
            common,
            events_read: vec![0; sizes.shots as usize],
            waited: Duration::ZERO,
            clock: DeviceClock::new(device, PARTS.len()),
            timed: Timed::default(),
        }
    }

    /// The sizes of its buffers.
    pub fn sizes(&self) -> &Sizes {
        &self.sizes
    }

    /// Runs some stages of one step and waits.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn run_stages(&self, info: &StepInfo, stages: &[Stage]) -> Result<(), DeviceError> {
        self.write_steps(std::slice::from_ref(info));
        let mut encoder = self.device.inner.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            self.record(&mut pass, 0, info, stages);
        }
        self.device.queue.submit([encoder.finish()]);
        self.device.wait(None)
    }

    /// What each kernel took by the device's clock [s], from one step of every batch; empty where it has none.
    pub fn kernel_seconds(&self) -> Vec<(&'static str, f64)> {
        self.timed.seconds()
    }

    /// Time spent waiting for the device.
    pub(crate) fn waited(&self) -> Duration {
        self.waited
    }

    pub(crate) fn write_steps(&self, steps: &[StepInfo]) {
        let stride = STEP_STRIDE as usize / 4;
        let mut words = vec![0; steps.len() * stride];
        for (row, info) in words.chunks_mut(stride).zip(steps) {
            let block = layout::step(info).words();
            row[..block.len()].copy_from_slice(&block);
        }
        self.device.queue.write_buffer(&self.common.steps, 0, bytemuck::cast_slice(&words));
    }

    /// Which shots run from now on, by number: one layer of every dispatch each.
    pub(crate) fn set_running(&mut self, numbers: Vec<usize>) {
        let words: Vec<u32> = numbers.iter().flat_map(|number| self.constants[*number].iter().copied()).collect();
        self.device.queue.write_buffer(&self.common.shots, 0, bytemuck::cast_slice(&words));
        self.running = numbers;
    }

    /// Dispatches of a step of this scene.
    pub(crate) fn dispatches_of(&self, info: &StepInfo) -> u64 {
        let plies = if self.terms.plies { self.plies.len() } else { 0 };
        (self.element.len() + 1 + plies + self.contact.len() + usize::from(info.slot.is_some())) as u64
    }

    /// Records the stages that the scene and the step have.
    pub(crate) fn record(&self, pass: &mut wgpu::ComputePass<'_>, at: usize, info: &StepInfo, stages: &[Stage]) {
        let sampled = info.slot.is_some();
        let step = at as u32 * STEP_STRIDE as u32;
        let mut dispatch = |program: &Program, ply_type: usize, [x, y]: [u32; 2]| {
            let [constants, law] = [SCENE_STRIDE, LAW_STRIDE].map(|stride| ply_type as u32 * stride as u32);
            pass.set_bind_group(0, &self.common.group, &[constants, step, law]);
            pass.set_pipeline(&program.pipeline);
            pass.set_bind_group(1, &program.group, &[]);
            pass.dispatch_workgroups(x, y, self.running.len() as u32);
        };
        let [elements, nodes] = [self.sizes.elements, self.sizes.nodes].map(|n| spread(n, GROUP, self.most_workgroups));
        for stage in stages {
            match stage {
                Stage::Elements => {
                    for (ply_type, programs) in self.element.iter().enumerate() {
                        dispatch(&programs[usize::from(sampled)], ply_type, elements);
                    }
                }
                Stage::Nodes => dispatch(&self.node, 0, nodes),
                Stage::Plies if self.terms.plies => self.plies.iter().for_each(|program| dispatch(program, 0, nodes)),
                Stage::Projectile => self.contact.iter().for_each(|program| dispatch(program, 0, [1, 1])),
                Stage::Ledger if sampled => dispatch(&self.ledger, 0, [self.sizes.groups as u32, 1]),
                Stage::Plies | Stage::Ledger => {}
            }
        }
    }

    /// One step. `slot`: where the ledger writes, if it runs; `since`: steps since it did.
    pub fn whole_step(&self, index: u64, slot: Option<u32>, since: u32) -> StepInfo {
        StepInfo { index, slot, since, dt: self.dt }
    }

    /// Words of the body in a sample begin here.
    pub(crate) fn body_at(&self) -> usize {
        self.sizes.sample_words() - STATUS_WORDS - BODY_WORDS
    }
}

/// Bytes of the stamps around the parts of a step.
pub(super) const STAMP_BYTES: u64 = DeviceClock::bytes(PARTS.len());
