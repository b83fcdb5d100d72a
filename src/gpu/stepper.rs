//! Steps on the device: pipelines, batches recorded in one submission, and what is read back after each.

use std::time::{Duration, Instant};

use super::buffers::{BufferId, Sizes, spread};
use super::layout::{
    self, BODY_WORDS, EVENT_WORDS, GROUP, LAW_STRIDE, LINE_TEXELS, LINE_WORDS, LINES_ACROSS, PLIES, PLY_WORDS,
    SCENE_STRIDE, STATUS_WORDS, STEP_BYTES, STEP_STRIDE, StepInfo, status,
};
use super::program::{self, Program};
use super::shader::{self, Kernel};
use super::timing::{DeviceClock, Timed};
use super::{Device, DeviceError};
use crate::model::{Features, Grid, Model, PlyType};
use crate::solver::FailureEvent;

/// Steps in one submission at most.
pub const BATCH: usize = 256;
/// Failure events fetched with every batch; more are fetched when there are more.
const EVENT_WINDOW: u64 = 256;

/// A part of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// `element_force`
    Elements,
    /// `node_update`
    Nodes,
    /// `ply_search`, `ply_impulse`, `ply_move`
    Plies,
    /// `projectile_contact`, or `projectile_points` and `projectile_rim`, with the motion of the body.
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
/// Speed of any node over the largest at the start, at most: all the energy in one place.
const SPEED_MARGIN: f64 = 4.0;

/// What a batch leaves behind.
#[derive(Clone, Debug, Default)]
pub struct BatchResult {
    /// Words of each sample, in order of the slots.
    pub samples: Vec<Vec<u32>>,
    /// The counters.
    pub status: [u32; STATUS_WORDS],
    /// Failures of the batch in order of step, element and yarn.
    pub events: Vec<FailureEvent>,
}

/// A batch on its way.
pub struct Pending {
    /// Which staging buffer it fills.
    staging: usize,
    samples: usize,
    /// Events before these were known when it was recorded, and how many follow.
    first_event: u64,
    window: u64,
    /// Whether the step whose stages were timed was sampled.
    timed_sample: bool,
    submission: wgpu::SubmissionIndex,
}

/// Batches on their way at once: one computes while the next is recorded.
const IN_FLIGHT: usize = 2;

/// Advances a state on a device.
pub struct DeviceStepper<'a> {
    pub(crate) device: &'a Device,
    pub(crate) sizes: Sizes,
    pub(crate) grid: Grid,
    pub(crate) terms: Features,
    dt: f64,
    /// How far any node may go in a step [m].
    travel_bound: f64,
    /// Per dimension of a dispatch.
    most_workgroups: u32,
    pub(crate) buffers: Vec<wgpu::Buffer>,
    steps: wgpu::Buffer,
    staging: [wgpu::Buffer; IN_FLIGHT],
    submitted: usize,
    common: wgpu::BindGroup,
    /// By ply type: plain, and with the ledger.
    element: Vec<[Program; 2]>,
    node: Program,
    plies: [Program; 3],
    /// One, or two where the rim is sampled.
    contact: Vec<Program>,
    ledger: Program,
    pub(crate) events_read: u64,
    /// Time spent waiting for the device.
    pub(crate) waited: Duration,
    /// Where the device has one.
    clock: Option<DeviceClock>,
    pub(crate) timed: Timed,
}

impl<'a> DeviceStepper<'a> {
    /// Pipelines and buffers for a model; the state is not there yet.
    ///
    /// # Errors
    /// When the device cannot hold the case, or refuses a pipeline.
    pub fn new(device: &'a Device, model: &Model<f32>) -> Result<Self, DeviceError> {
        Self::with_sources(device, model, &Kernel::source)
    }

    /// The same with other sources: for tests that break a shader on purpose.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_sources(
        device: &'a Device,
        model: &Model<f32>,
        source: &dyn Fn(&Kernel) -> String,
    ) -> Result<Self, DeviceError> {
        let sizes = Sizes::new(model);
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
        let buffer = |label: &str, size: u64, usage: wgpu::BufferUsages| {
            let usage = usage | wgpu::BufferUsages::COPY_DST;
            gpu.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
        };
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let buffers: Vec<_> =
            BufferId::ALL.map(|name| buffer(name.variable(), sizes.bytes(name), storage)).into_iter().collect();
        let ply_types = 0..model.ply_types.len();
        let scene = buffer("scene", SCENE_STRIDE * ply_types.len() as u64, wgpu::BufferUsages::UNIFORM);
        for ply_type in ply_types {
            let block = layout::scene(model, ply_type, &sizes).words();
            device.queue.write_buffer(&scene, SCENE_STRIDE * ply_type as u64, bytemuck::cast_slice(&block));
        }
        let law = buffer("law", LAW_STRIDE * model.ply_types.len() as u64, wgpu::BufferUsages::UNIFORM);
        for (at, ply_type) in model.ply_types.iter().enumerate() {
            let words = layout::law_energy(ply_type);
            device.queue.write_buffer(&law, LAW_STRIDE * at as u64, bytemuck::cast_slice(&words));
        }
        let plies = buffer("plies", 4 * (PLIES * PLY_WORDS) as u64, wgpu::BufferUsages::UNIFORM);
        let words: Vec<u32> = layout::plies(model).iter().flat_map(|ply| ply.words()).collect();
        device.queue.write_buffer(&plies, 0, bytemuck::cast_slice(&words));
        let lines = grid_lines(device, model);
        let steps = buffer("steps", STEP_STRIDE * BATCH as u64, wgpu::BufferUsages::UNIFORM);
        let staging_size = sizes.bytes(BufferId::Samples) + STATUS_BYTES + EVENT_BYTES * EVENT_WINDOW + STAMP_BYTES;
        let staging = [0; IN_FLIGHT].map(|_| buffer("staging", staging_size, wgpu::BufferUsages::MAP_READ));
        let layout = program::common_layout(gpu);
        let common = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("scene and step"),
            layout: &layout,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: part(&scene, SCENE_STRIDE) },
                wgpu::BindGroupEntry { binding: 1, resource: part(&steps, STEP_BYTES) },
                wgpu::BindGroupEntry { binding: 2, resource: plies.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::TextureView(&lines) },
                wgpu::BindGroupEntry { binding: 4, resource: part(&law, LAW_STRIDE) },
            ],
        });
        let module = |kernel: &Kernel| {
            gpu.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(kernel.name),
                source: wgpu::ShaderSource::Wgsl(source(kernel).into()),
            })
        };
        let program = |kernel: &Kernel, module: &wgpu::ShaderModule, terms: &Features, ledger: bool| {
            program::program(gpu, kernel, module, &layout, &buffers, &shader::constants(terms, ledger))
        };
        let single = |kernel: &Kernel, ledger: bool| program(kernel, &module(kernel), &terms, ledger);
        let elements = module(&shader::ELEMENT_FORCE);
        let element = |ply_type: &PlyType<f32>| {
            let terms = Features::new(model, ply_type);
            [false, true].map(|ledger| program(&shader::ELEMENT_FORCE, &elements, &terms, ledger))
        };
        let contact: &[Kernel] = match model.edges {
            true => &[shader::PROJECTILE_POINTS, shader::PROJECTILE_RIM],
            false => &[shader::PROJECTILE_CONTACT],
        };
        Self {
            element: model.ply_types.iter().map(element).collect(),
            plies: [&shader::PLY_SEARCH, &shader::PLY_IMPULSE, &shader::PLY_MOVE].map(|kernel| single(kernel, false)),
            travel_bound: model.dt * SPEED_MARGIN * layout::start_speed(model),
            node: single(&shader::NODE_UPDATE, false),
            contact: contact.iter().map(|kernel| single(kernel, false)).collect(),
            ledger: single(&shader::LEDGER, true),
            most_workgroups: device.limits().max_compute_workgroups_per_dimension,
            device,
            sizes,
            grid: model.grid,
            terms,
            dt: model.dt,
            buffers,
            steps,
            staging,
            submitted: 0,
            common,
            events_read: 0,
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

    /// Sends steps off in one submission. At most two batches may be on their way.
    pub fn submit(&mut self, steps: &[StepInfo]) -> Pending {
        self.write_steps(steps);
        let samples = steps.iter().filter(|s| s.slot.is_some()).count();
        let (sample_bytes, first_event) = (self.sample_bytes(samples), self.events_read);
        let window = EVENT_WINDOW.min(2 * self.sizes.elements - first_event);
        let staging = self.submitted % IN_FLIGHT;
        let target = &self.staging[staging];
        let mut encoder = self.device.inner.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        // One step of the batch is timed, another one each time.
        let timed = 7 * self.submitted % steps.len().max(1);
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            for (at, info) in steps.iter().enumerate() {
                match &self.clock {
                    Some(clock) if at == timed => self.record_timed(&mut pass, at, info, &PARTS, clock),
                    _ => self.record(&mut pass, at, info, &PARTS),
                }
            }
        }
        if let Some(clock) = &self.clock {
            clock.resolve(&mut encoder);
            let to = sample_bytes + STATUS_BYTES + window * EVENT_BYTES;
            encoder.copy_buffer_to_buffer(&clock.resolved, 0, target, to, STAMP_BYTES);
        }
        self.timed.send(steps);
        let timed_sample = steps.get(timed).is_some_and(|step| step.slot.is_some());
        let copies = [
            (BufferId::Samples, 0, 0, sample_bytes),
            (BufferId::Status, 0, sample_bytes, STATUS_BYTES),
            (BufferId::Events, first_event * EVENT_BYTES, sample_bytes + STATUS_BYTES, window * EVENT_BYTES),
        ];
        for (name, from, to, size) in copies {
            encoder.copy_buffer_to_buffer(self.buffer(name), from, target, to, size);
        }
        let submission = self.device.queue.submit([encoder.finish()]);
        self.submitted += 1;
        Pending { staging, samples, first_event, window, timed_sample, submission }
    }

    fn sample_bytes(&self, samples: usize) -> u64 {
        4 * (samples * self.sizes.sample_words()) as u64
    }

    /// Waits for the oldest batch on its way and reads what the ledger and the kernels noted.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn collect(&mut self, batch: &Pending) -> Result<BatchResult, DeviceError> {
        let known = self.sample_bytes(batch.samples) + STATUS_BYTES + batch.window * EVENT_BYTES;
        let size = known + if self.clock.is_some() { STAMP_BYTES } else { 0 };
        let start = Instant::now();
        let words = self.fetch(&self.staging[batch.staging], size, Some(batch.submission.clone()));
        self.waited += start.elapsed();
        let words = words?;
        let (words, stamps) = words.split_at(known as usize / 4);
        if let Some(clock) = &self.clock {
            self.timed.add(batch.timed_sample, &clock.seconds(stamps));
        }
        let (sampled, rest) = words.split_at(batch.samples * self.sizes.sample_words());
        let (counters, events) = rest.split_at(STATUS_WORDS);
        let mut result = BatchResult {
            samples: sampled.chunks(self.sizes.sample_words()).map(<[u32]>::to_vec).collect(),
            ..BatchResult::default()
        };
        result.status.copy_from_slice(counters);
        let count = u64::from(result.status[status::EVENTS]);
        let events = if count <= batch.first_event + batch.window {
            let [from, to] = [self.events_read, count].map(|at| ((at - batch.first_event) * EVENT_WORDS) as usize);
            events[from..to].to_vec()
        } else {
            let [from, size] = [self.events_read, count - self.events_read].map(|n| n * EVENT_BYTES);
            self.read_part(BufferId::Events, from, size)?
        };
        self.events_read = count;
        result.events = self.sorted(&events);
        Ok(result)
    }

    /// Runs steps in one submission and waits for them.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn run(&mut self, steps: &[StepInfo]) -> Result<BatchResult, DeviceError> {
        let batch = self.submit(steps);
        self.collect(&batch)
    }

    /// What each kernel took by the device's clock [s], from one step of every batch; empty where it has none.
    pub fn kernel_seconds(&self) -> Vec<(&'static str, f64)> {
        self.timed.seconds()
    }

    /// Time spent waiting for the device.
    pub fn waited(&self) -> Duration {
        self.waited
    }

    pub(crate) fn write_steps(&self, steps: &[StepInfo]) {
        let stride = STEP_STRIDE as usize / 4;
        let mut words = vec![0; steps.len() * stride];
        for (row, info) in words.chunks_mut(stride).zip(steps) {
            let block = layout::step(info).words();
            row[..block.len()].copy_from_slice(&block);
        }
        self.device.queue.write_buffer(&self.steps, 0, bytemuck::cast_slice(&words));
    }

    /// Records the stages that the scene and the step have.
    pub(crate) fn record(&self, pass: &mut wgpu::ComputePass<'_>, at: usize, info: &StepInfo, stages: &[Stage]) {
        let sampled = info.slot.is_some();
        let step = at as u32 * STEP_STRIDE as u32;
        let mut dispatch = |program: &Program, ply_type: usize, [x, y]: [u32; 2]| {
            let [constants, law] = [SCENE_STRIDE, LAW_STRIDE].map(|stride| ply_type as u32 * stride as u32);
            pass.set_bind_group(0, &self.common, &[constants, step, law]);
            pass.set_pipeline(&program.pipeline);
            pass.set_bind_group(1, &program.group, &[]);
            pass.dispatch_workgroups(x, y, 1);
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
                Stage::Projectile if self.terms.projectile => {
                    self.contact.iter().for_each(|program| dispatch(program, 0, [1, 1]));
                }
                Stage::Ledger if sampled => dispatch(&self.ledger, 0, [self.sizes.groups as u32, 1]),
                Stage::Plies | Stage::Projectile | Stage::Ledger => {}
            }
        }
    }

    /// One step. `slot`: where the ledger writes, if it runs; `since`: steps since it did.
    pub fn whole_step(&self, index: u64, slot: Option<u32>, since: u32) -> StepInfo {
        StepInfo { index, slot, since, dt: self.dt, travel: self.travel_bound * (index + 1) as f64 }
    }

    /// Events in the order the processor would have found them.
    fn sorted(&self, words: &[u32]) -> Vec<FailureEvent> {
        let mut raw: Vec<&[u32]> = words.chunks_exact(EVENT_WORDS as usize).collect();
        raw.sort_by_key(|w| (w[0], w[1], w[2]));
        raw.into_iter()
            .map(|w| {
                let element = w[1] as usize;
                let (ply, j) = self.grid.element_row(element / self.grid.columns);
                FailureEvent {
                    step: u64::from(w[0]),
                    ply: ply as u32,
                    i: (element % self.grid.columns) as u32,
                    j: j as u32,
                    yarn: w[2] as u8,
                    strain: f64::from(f32::from_bits(w[3])),
                }
            })
            .collect()
    }

    /// Words of the body in a sample begin here.
    pub(crate) fn body_at(&self) -> usize {
        self.sizes.sample_words() - STATUS_WORDS - BODY_WORDS
    }
}

/// Bytes of the counters, of an event, of the stamps around the parts of a step.
const STATUS_BYTES: u64 = 4 * STATUS_WORDS as u64;
const STAMP_BYTES: u64 = DeviceClock::bytes(PARTS.len());
const EVENT_BYTES: u64 = 4 * EVENT_WORDS;

/// The grid lines, of which each has its texels.
fn grid_lines(device: &Device, model: &Model<f32>) -> wgpu::TextureView {
    let words = layout::lines(model);
    let lines = words.len() / LINE_WORDS;
    let across = lines.min(LINES_ACROSS);
    let (width, height) = ((LINE_TEXELS * across) as u32, (lines / across) as u32);
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let texture = device.inner.create_texture(&wgpu::TextureDescriptor {
        label: Some("grid lines"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let bytes_per_row = Some((4 * LINE_WORDS * across) as u32);
    let rows = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row, rows_per_image: None };
    device.queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(&words), rows, size);
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// The first bytes of a buffer, to be moved by a dynamic offset.
fn part(buffer: &wgpu::Buffer, size: u64) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size: wgpu::BufferSize::new(size) })
}
