//! Steps on the device: buffers of shots that share a model, kernels compiled for it, and the dispatches of a step.
//!
//! All kernels bind the uniforms in group 0, each its buffers in group 1.

use std::time::Duration;

use bytemuck::Pod;

use super::buffers::{BufferId, IN_FLIGHT, Sizes};
use super::layout::{self, GROUP, LAW_STRIDE, PLIES, Ply, SCENE_STRIDE, SHOTS, STEP_STRIDE, Shot, StepInfo};
pub use super::shader::Stage;
use super::shader::{self, Access, Extent, KERNELS, Kernel};
use super::submission::{DeviceClock, STAMP_BYTES, StageTimes};
use super::{Device, DeviceError};
use crate::model::mesh::Grid;
use crate::model::{Features, Model};

/// Steps in one submission at most.
pub const BATCH: usize = 1024;
/// Compiled kernels that a device keeps at most: scenes of eight that share most of them.
const KEPT: usize = 256;
const UNIFORM: wgpu::BufferUsages = wgpu::BufferUsages::UNIFORM;

/// One dispatch of a step.
struct Dispatch {
    stage: Stage,
    ply_type: usize,
    workgroups: [u32; 2],
    pipeline: wgpu::ComputePipeline,
    /// Buffers that the kernel binds.
    group: wgpu::BindGroup,
}

/// Advances the states of shots on a device, all by the same steps.
pub struct DeviceStepper<'a> {
    pub(crate) device: &'a Device,
    /// Sizes of the buffers.
    pub sizes: Sizes,
    pub(crate) grid: Grid,
    pub(crate) features: Features,
    dt: f64,
    pub(super) buffers: Vec<wgpu::Buffer>,
    /// Constants of every shot.
    pub(super) constants: Vec<Shot>,
    /// Numbers of the shots that run.
    pub(crate) running: Vec<usize>,
    pub(super) staging: [wgpu::Buffer; IN_FLIGHT],
    pub(super) submitted: usize,
    common: Common,
    /// In the order of a step.
    step: Vec<Dispatch>,
    /// Failure events read of each shot.
    pub(crate) events_read: Vec<u64>,
    /// Time spent waiting for the device.
    pub(crate) waited: Duration,
    /// Clock of the device, where it has one.
    pub(super) clock: Option<DeviceClock>,
    pub(crate) times: StageTimes,
}

impl<'a> DeviceStepper<'a> {
    /// Pipelines and buffers for one shot of a model; the state is not there yet.
    ///
    /// # Errors
    /// When the device cannot hold the case, or refuses a pipeline.
    pub fn new(device: &'a Device, model: &Model<f32>) -> Result<Self, DeviceError> {
        Self::with_sources(device, model, 1, &Kernel::source)
    }

    /// Pipelines and buffers with room for `shots` shots, whose models differ from this one by what [`layout::shot`] holds and by the strength
    /// of their yarns. `source`: of a kernel, which tests break on purpose.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_sources(
        device: &'a Device,
        model: &Model<f32>,
        shots: u64,
        source: &dyn Fn(&Kernel) -> String,
    ) -> Result<Self, DeviceError> {
        let sizes = Sizes::new(model).with_shots(shots);
        sizes.check(&device.limits(), device.name())?;
        if cfg!(target_family = "wasm") {
            // Nothing may wait for the answer in a browser. There the device keeps such errors for the next wait.
            return Ok(Self::build(device, model, sizes, source));
        }
        let memory = device.inner.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = device.inner.push_error_scope(wgpu::ErrorFilter::Validation);
        let built = Self::build(device, model, sizes, source);
        let [invalid, full] = [validation, memory].map(|scope| pollster::block_on(scope.pop()));
        if invalid.is_some() || full.is_some() {
            device.compiled().clear();
        }
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
        let features = model.features();
        let storage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let buffers = BufferId::ALL.map(|id| device.buffer(id.variable(), sizes.bytes(id), storage)).to_vec();
        device.queue.write_buffer(
            &buffers[BufferId::Nodes as usize],
            4 * sizes.lines_at(),
            bytemuck::cast_slice(&layout::lines(model)),
        );
        let common = Common::new(device, model, &sizes);
        let staging_size = sizes.staging() + STAMP_BYTES;
        let staging = [0; IN_FLIGHT].map(|_| device.buffer("staging", staging_size, wgpu::BufferUsages::MAP_READ));
        let most = device.limits().max_compute_workgroups_per_dimension;
        let mut step = Vec::new();
        for kernel in KERNELS.iter().filter(|kernel| kernel.is_in(&features)) {
            let invocations = |count: u64| workgroups(count.div_ceil(u64::from(GROUP)), most);
            let (workgroups, together) = match kernel.extent {
                Extent::Tiles => (workgroups(sizes.plies * sizes.tiles[0] * sizes.tiles[1], most), 1),
                Extent::Elements => (invocations(sizes.elements), 1),
                Extent::Nodes => (invocations(sizes.nodes), usize::MAX),
                Extent::Plies => ([sizes.plies as u32, 1], usize::MAX),
                Extent::Shot => ([1, 1], usize::MAX),
                Extent::Balance => ([sizes.groups as u32, 1], usize::MAX),
            };
            let storage = |(id, access): &(BufferId, Access)| {
                let ty = wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Storage { read_only: *access == Access::Read },
                    has_dynamic_offset: false,
                    min_binding_size: None,
                };
                (ty, buffers[*id as usize].as_entire_binding())
            };
            let bindings: Vec<_> = kernel.bindings.iter().map(storage).collect();
            let (layout, group) = bind(device, kernel.name, &bindings);
            for (ply_type, ply_types) in model.ply_types.chunks(together).enumerate() {
                let constants = shader::constants(kernel, &Features::new(model, ply_types), &sizes);
                let pipeline = compile(device, kernel, source(kernel), [&common.layout, &layout], &constants);
                step.push(Dispatch { stage: kernel.stage, ply_type, workgroups, pipeline, group: group.clone() });
            }
        }
        Self {
            device,
            sizes,
            grid: model.grid,
            features,
            dt: model.dt,
            buffers,
            constants: vec![Shot::default(); sizes.shots as usize],
            running: Vec::new(),
            staging,
            submitted: 0,
            common,
            step,
            events_read: vec![0; sizes.shots as usize],
            waited: Duration::ZERO,
            clock: DeviceClock::new(device),
            times: StageTimes::default(),
        }
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
            let mut bound = None;
            stages.iter().for_each(|stage| self.record(&mut pass, 0, info, *stage, &mut bound));
        }
        self.device.queue.submit([encoder.finish()]);
        self.device.wait(None)
    }

    /// Time that each kernel took by the device's clock [s], from one step of every batch; empty where it has none.
    pub fn kernel_seconds(&self) -> Vec<(&'static str, f64)> {
        self.times.seconds()
    }

    pub(crate) fn write_steps(&self, steps: &[StepInfo]) {
        let bytes = strided(STEP_STRIDE, steps.iter().map(layout::step));
        self.device.queue.write_buffer(&self.common.steps, 0, &bytes);
    }

    /// Sets which shots run from now on, by number: one layer of every dispatch each.
    pub(crate) fn set_running(&mut self, numbers: Vec<usize>) {
        let constants: Vec<Shot> = numbers.iter().map(|number| self.constants[*number]).collect();
        self.device.queue.write_buffer(&self.common.shots, 0, bytemuck::cast_slice(&constants));
        self.running = numbers;
    }

    /// Records a stage of the step at a place of the batch. `bound`: offsets at which group 0 is bound in the pass, the same for most dispatches
    /// of a step.
    pub(crate) fn record(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        at: usize,
        info: &StepInfo,
        stage: Stage,
        bound: &mut Option<[u32; 3]>,
    ) {
        let step = at as u32 * STEP_STRIDE as u32;
        if stage == Stage::EnergyBalance && info.slot.is_none() {
            return;
        }
        for dispatch in self.step.iter().filter(|dispatch| dispatch.stage == stage) {
            let [scene, law] = [SCENE_STRIDE, LAW_STRIDE].map(|stride| dispatch.ply_type as u32 * stride as u32);
            let [x, y] = dispatch.workgroups;
            let offsets = [scene, step, law];
            if bound.replace(offsets) != Some(offsets) {
                pass.set_bind_group(0, &self.common.group, &offsets);
            }
            pass.set_pipeline(&dispatch.pipeline);
            pass.set_bind_group(1, &dispatch.group, &[]);
            pass.dispatch_workgroups(x, y, self.running.len() as u32);
        }
    }

    /// One step. `slot`: of its sample; `since`: steps since the last one.
    pub fn whole_step(&self, index: u64, slot: Option<u32>, since: u32) -> StepInfo {
        StepInfo { index, slot, since, dt: self.dt }
    }
}

/// Group 0: constants of a ply type, step, plies, energy of a law, and shots.
struct Common {
    layout: wgpu::BindGroupLayout,
    group: wgpu::BindGroup,
    /// Steps of a batch.
    steps: wgpu::Buffer,
    /// Constants of the shots that run.
    shots: wgpu::Buffer,
}

impl Common {
    /// Writes all but steps and shots. Constants of a ply type, step and law are bound at dynamic offsets.
    fn new(device: &Device, model: &Model<f32>, sizes: &Sizes) -> Self {
        let uniform = |label: &str, size: u64, bytes: &[u8]| {
            let buffer = device.buffer(label, size, UNIFORM);
            device.queue.write_buffer(&buffer, 0, bytes);
            buffer
        };
        let ply_types = model.ply_types.len() as u64;
        let scenes = (0..model.ply_types.len()).map(|ply_type| layout::scene(model, ply_type, sizes));
        let laws: Vec<f32> = model.ply_types.iter().flat_map(layout::law_energy).collect();
        let scene = uniform("scene", SCENE_STRIDE * ply_types, &strided(SCENE_STRIDE, scenes));
        let law = uniform("law", LAW_STRIDE * ply_types, bytemuck::cast_slice(&laws));
        let plies = uniform("plies", (PLIES * size_of::<Ply>()) as u64, bytemuck::cast_slice(&layout::plies(model)));
        let steps = device.buffer("steps", STEP_STRIDE * BATCH as u64, UNIFORM);
        let shots_bytes = SHOTS * size_of::<Shot>() as u64;
        let shots = device.buffer("shots", shots_bytes, UNIFORM);
        let step_bytes = size_of::<layout::Step>() as u64;
        let of = |has_dynamic_offset: bool, size: u64| wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset,
            min_binding_size: wgpu::BufferSize::new(size),
        };
        let bindings = [
            (of(true, SCENE_STRIDE), part(&scene, SCENE_STRIDE)),
            (of(true, step_bytes), part(&steps, step_bytes)),
            (of(false, 0), plies.as_entire_binding()),
            (of(true, LAW_STRIDE), part(&law, LAW_STRIDE)),
            (of(false, shots_bytes), shots.as_entire_binding()),
        ];
        let (layout, group) = bind(device, "scene and step", &bindings);
        Self { layout, group, steps, shots }
    }
}

/// Group of resources bound in order, and its layout.
fn bind(
    device: &Device,
    label: &str,
    bindings: &[(wgpu::BindingType, wgpu::BindingResource<'_>)],
) -> (wgpu::BindGroupLayout, wgpu::BindGroup) {
    let (gpu, label, visibility) = (&device.inner, Some(label), wgpu::ShaderStages::COMPUTE);
    let numbered = bindings.iter().zip(0..);
    let entries: Vec<_> = numbered
        .clone()
        .map(|((ty, _), binding)| wgpu::BindGroupLayoutEntry { binding, visibility, ty: *ty, count: None })
        .collect();
    let layout = gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label, entries: &entries });
    let entries: Vec<_> =
        numbered.map(|((_, resource), binding)| wgpu::BindGroupEntry { binding, resource: resource.clone() }).collect();
    let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor { label, layout: &layout, entries: &entries });
    (layout, group)
}

/// First bytes of a buffer, to be moved by a dynamic offset.
fn part(buffer: &wgpu::Buffer, size: u64) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size: wgpu::BufferSize::new(size) })
}

/// Compiles a kernel with values of its overridable constants, or takes what the device has compiled before. `layouts`: of its groups.
fn compile(
    device: &Device,
    kernel: &Kernel,
    source: String,
    layouts: [&wgpu::BindGroupLayout; 2],
    constants: &[(&str, f64)],
) -> wgpu::ComputePipeline {
    let (gpu, label) = (&device.inner, Some(kernel.name));
    let used: Vec<(&str, f64)> =
        constants.iter().filter(|(name, _)| kernel.constants.contains(name)).copied().collect();
    let compile = |source: &str| {
        let source = wgpu::ShaderSource::Wgsl(source.into());
        let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor { label, source });
        let pipeline_layout = gpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label,
            bind_group_layouts: &layouts.map(Some),
            immediate_size: 0,
        });
        gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some(kernel.name),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &used, ..Default::default() },
            cache: None,
        })
    };
    let values = used.iter().map(|(_, value)| value.to_bits()).collect();
    let mut compiled = device.compiled();
    if compiled.len() >= KEPT {
        compiled.clear();
    }
    compiled.entry((source, values)).or_insert_with_key(|(source, _)| compile(source)).clone()
}

/// Bytes of values that begin at multiples of a stride.
fn strided<T: Pod>(stride: u64, values: impl Iterator<Item = T>) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (count, value) in (1..).zip(values) {
        bytes.extend_from_slice(bytemuck::bytes_of(&value));
        bytes.resize(count * stride as usize, 0);
    }
    bytes
}

/// Workgroups as a two-dimensional dispatch within `most` per dimension.
pub(super) fn workgroups(count: u64, most: u32) -> [u32; 2] {
    let groups = count.max(1);
    let rows = groups.div_ceil(u64::from(most));
    [groups.div_ceil(rows) as u32, rows as u32]
}
