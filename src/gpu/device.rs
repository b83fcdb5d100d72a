//! Adapters and devices: the graphics processors of the machine, the choice of one, and the floors of an open one: the least time of a
//! dispatch, of a barrier and of a read that waits for another, and the rate at which a kernel copies memory.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use web_time::Instant;

use super::DeviceError;

/// A graphics processor, or software that acts as one.
#[derive(Clone, Debug)]
pub struct Adapter {
    inner: wgpu::Adapter,
    info: wgpu::AdapterInfo,
}

impl Adapter {
    /// Name.
    pub fn name(&self) -> &str {
        &self.info.name
    }

    /// Rank and kind: hardware before software.
    fn class(&self) -> (u32, &'static str) {
        match self.info.device_type {
            wgpu::DeviceType::DiscreteGpu => (0, "discrete GPU"),
            wgpu::DeviceType::IntegratedGpu => (1, "integrated GPU"),
            wgpu::DeviceType::VirtualGpu => (2, "virtual GPU"),
            wgpu::DeviceType::Other => (3, "unknown"),
            wgpu::DeviceType::Cpu => (4, "software"),
        }
    }

    /// Whether it is hardware.
    pub fn is_hardware(&self) -> bool {
        self.class().0 < 3
    }

    /// Kind, in words.
    pub fn kind(&self) -> &'static str {
        self.class().1
    }

    /// Programming interface and driver.
    pub fn driver(&self) -> String {
        format!("{} {} {}", self.info.backend, self.info.driver, self.info.driver_info).trim().to_owned()
    }

    /// Largest storage buffer [bytes].
    pub fn largest_buffer(&self) -> u64 {
        let limits = self.inner.limits();
        limits.max_storage_buffer_binding_size.min(limits.max_buffer_size)
    }
}

/// Every adapter, the best first; their numbers on the command line follow this order.
///
/// Vulkan, Metal or DirectX 12. OpenGL is left out: its one context at a time fails where several threads open devices, and machines
/// that have it alone compute in software, slower than the CPU backend.
pub fn adapters() -> Vec<Adapter> {
    pollster::block_on(find_adapters())
}

/// As [`adapters`], where nothing may block.
pub async fn find_adapters() -> Vec<Adapter> {
    let backends = wgpu::Backends::PRIMARY;
    let descriptor = wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() };
    let found = wgpu::Instance::new(descriptor).enumerate_adapters(backends).await;
    let mut adapters: Vec<Adapter> = found.into_iter().map(|inner| Adapter { info: inner.get_info(), inner }).collect();
    adapters.sort_by_key(|adapter| adapter.class().0);
    adapters
}

/// Adapter that `auto` takes of those found, or why none.
///
/// # Errors
/// When there is no real one.
pub fn automatic(adapters: &[Adapter]) -> Result<&Adapter, &'static str> {
    match adapters.first() {
        Some(best) if best.is_hardware() => Ok(best),
        Some(_) => Err("only software adapters were found"),
        None => Err("no graphics adapter was found"),
    }
}

/// The adapter of that name (or part of it, whatever the case) or number, or the best one.
///
/// # Errors
/// When there is none.
pub fn choose(adapters: &[Adapter], wanted: Option<&str>) -> Result<Adapter, DeviceError> {
    let Some(first) = adapters.first() else { return Err(DeviceError::NoAdapter) };
    let Some(wanted) = wanted else { return Ok(first.clone()) };
    let by_number = wanted.parse::<usize>().ok().and_then(|n| adapters.get(n));
    let lower = wanted.to_lowercase();
    let by_name = || adapters.iter().find(|a| a.name().to_lowercase().contains(&lower));
    by_number.or_else(by_name).cloned().ok_or_else(|| DeviceError::NoSuchAdapter {
        wanted: wanted.to_owned(),
        found: adapters.iter().map(|a| a.name().to_owned()).collect(),
    })
}

/// Compiled kernels by their source and the values of its overridable constants, as bits.
type Compiled = HashMap<(String, Vec<u64>), wgpu::ComputePipeline>;

/// An open device.
#[derive(Debug)]
pub struct Device {
    pub(crate) inner: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    name: String,
    hardware: bool,
    fault: Arc<Mutex<Option<String>>>,
    compiled: Mutex<Compiled>,
}

/// Limits that kernels need: those of every WebGPU device, and storage buffers for contact with the projectile.
fn limits() -> wgpu::Limits {
    wgpu::Limits { max_storage_buffers_per_shader_stage: 10, ..wgpu::Limits::default() }
}

impl Device {
    /// Opens the adapter of that name (or part of it) or number, or the best one.
    ///
    /// # Errors
    /// When there is none, or it cannot be opened.
    pub fn find(wanted: Option<&str>) -> Result<Self, DeviceError> {
        Self::open(&choose(&adapters(), wanted)?)
    }

    /// Opens an adapter.
    ///
    /// # Errors
    /// When it grants less than every WebGPU device must, or fewer storage buffers than a kernel binds, or the driver refuses.
    pub fn open(adapter: &Adapter) -> Result<Self, DeviceError> {
        pollster::block_on(Self::request(adapter))
    }

    /// As [`Self::open`], where nothing may block.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub async fn request(adapter: &Adapter) -> Result<Self, DeviceError> {
        Self::request_narrow(adapter, wgpu::Limits::default().max_compute_workgroups_per_dimension).await
    }

    /// Opens an adapter with at most `workgroups` per dimension of a dispatch: larger ones spread over two dimensions, which
    /// ordinary limits ask for only from four million elements on.
    ///
    /// # Errors
    /// As [`Self::open`].
    #[doc(hidden)]
    pub async fn request_narrow(adapter: &Adapter, workgroups: u32) -> Result<Self, DeviceError> {
        let has = adapter.inner.limits();
        let limits = wgpu::Limits {
            max_compute_workgroups_per_dimension: workgroups,
            max_storage_buffer_binding_size: has.max_storage_buffer_binding_size,
            max_buffer_size: has.max_buffer_size,
            ..limits()
        };
        let timing = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("ripstop"),
            required_features: adapter.inner.features() & timing,
            required_limits: limits,
            memory_hints: wgpu::MemoryHints::Performance,
            ..wgpu::DeviceDescriptor::default()
        };
        let (inner, queue) = adapter
            .inner
            .request_device(&descriptor)
            .await
            .map_err(|e| DeviceError::Refused { adapter: adapter.name().to_owned(), reason: e.to_string() })?;
        Ok(Self::new(inner, queue, adapter.name().to_owned(), adapter.is_hardware()))
    }

    /// A device that accepts everything and computes nothing: it checks pipelines and bindings where there is no driver.
    #[cfg(not(target_family = "wasm"))]
    #[doc(hidden)]
    pub fn noop() -> Self {
        let descriptor = wgpu::DeviceDescriptor { required_limits: limits(), ..wgpu::DeviceDescriptor::default() };
        let (inner, queue) = wgpu::Device::noop(&descriptor);
        Self::new(inner, queue, "noop".to_owned(), false)
    }

    fn new(inner: wgpu::Device, queue: wgpu::Queue, name: String, hardware: bool) -> Self {
        let fault = Arc::new(Mutex::new(None));
        let note = |fault: &Arc<Mutex<Option<String>>>, text: String| {
            // The first fault is the cause; what follows are its consequences.
            fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(text);
        };
        let seen = Arc::clone(&fault);
        inner.on_uncaptured_error(Arc::new(move |error: wgpu::Error| note(&seen, error.to_string())));
        let seen = Arc::clone(&fault);
        inner.set_device_lost_callback(move |reason, message| {
            note(&seen, format!("device lost ({reason:?}): {message}"))
        });
        Self { inner, queue, name, hardware, fault, compiled: Mutex::default() }
    }

    /// Name of the adapter.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it is hardware, which need not round every operation to the nearest.
    pub fn is_hardware(&self) -> bool {
        self.hardware
    }

    /// Whether it has a clock that can be read between kernels.
    #[doc(hidden)]
    pub fn has_clock(&self) -> bool {
        self.inner.features().contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES)
    }

    /// Takes the device away in mid-run, as a driver reset would.
    #[doc(hidden)]
    pub fn destroy(&self) {
        self.inner.destroy();
    }

    /// Largest storage buffer, and other limits.
    #[doc(hidden)]
    pub fn limits(&self) -> wgpu::Limits {
        self.inner.limits()
    }

    /// Kernels that were compiled for earlier scenes.
    pub(super) fn compiled(&self) -> MutexGuard<'_, Compiled> {
        self.compiled.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A buffer that is copied to.
    pub(super) fn buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        self.inner.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
    }

    /// Waits for a submission, or for everything submitted.
    pub(crate) fn wait(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<(), DeviceError> {
        let polled = self.inner.poll(wgpu::PollType::Wait { submission_index, timeout: None });
        let fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner).clone();
        match (fault, polled) {
            (Some(reason), _) => Err(self.lost(reason)),
            (None, Err(error)) => Err(self.lost(error.to_string())),
            (None, Ok(_)) => Ok(()),
        }
    }

    pub(crate) fn lost(&self, reason: String) -> DeviceError {
        DeviceError::Lost { adapter: self.name.clone(), reason }
    }
}

/// Copies one array to another, 16 bytes an invocation; waits again and again at barriers, and for reads whose place the last one gave.
const SOURCE: &str = "
@group(0) @binding(0) var<storage, read> source: array<vec4<u32>>;
@group(0) @binding(1) var<storage, read_write> copy: array<vec4<u32>>;
@compute @workgroup_size(256)
fn copy_all(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let at = id.y * groups.x * 256u + id.x;
    if (at < arrayLength(&copy)) { copy[at] = source[at]; }
}
@compute @workgroup_size(256)
fn storage_barrier(@builtin(local_invocation_index) local: u32) {
    for (var i = 0u; i < 1000u; i++) { copy[local].x = source[local].x + i; storageBarrier(); }
}
@compute @workgroup_size(256)
fn workgroup_barrier(@builtin(local_invocation_index) local: u32) {
    for (var i = 0u; i < 1000u; i++) { workgroupBarrier(); }
    copy[local] = source[local];
}
@compute @workgroup_size(1)
fn dependent_read() {
    var at = 0u;
    for (var i = 0u; i < 1000u; i++) { at = (source[at].x + at + 40961u) % arrayLength(&source); }
    copy[0].x = at;
}";
/// Rounds of the loops above.
const ROUNDS: f64 = 1000.0;
/// Bytes copied by an invocation, and by a workgroup.
const EACH: u64 = 16;
const GROUP: u64 = 256 * EACH;
/// Bytes of an array on hardware, beyond its caches, and on software.
const BYTES: [u64; 2] = [512 << 20, 32 << 20];
/// Dispatches of a submission that are timed together: copies, and single workgroups.
const COPIES: u32 = 10;
const EMPTY: u32 = 2000;
/// Times that each is measured; the best counts.
const TRIALS: usize = 5;

/// Times and rate that no kernel of a device can beat.
#[derive(Clone, Copy, Debug)]
pub struct Floors {
    /// Bytes read and written by a kernel that copies [B/s].
    pub copy_rate: f64,
    /// Time of a dispatch that waits for the one before it and does nothing else [s].
    pub dispatch: f64,
    /// Time of a barrier of storage, of one of the workgroup, of 256 invocations [s].
    pub barriers: [f64; 2],
    /// Time of a read that waits for the one before it [s].
    pub dependent_read: f64,
}

impl Floors {
    /// Measures them.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn measure(device: &Device) -> Result<Self, DeviceError> {
        let limits = device.limits();
        let [hardware, software] = BYTES;
        let wanted = if device.is_hardware() { hardware } else { software };
        let bytes = wanted.min(limits.max_storage_buffer_binding_size).min(limits.max_buffer_size) / GROUP * GROUP;
        let buffers = ["source", "copy"].map(|label| device.buffer(label, bytes, wgpu::BufferUsages::STORAGE));
        let gpu = &device.inner;
        let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("floors"),
            source: wgpu::ShaderSource::Wgsl(SOURCE.into()),
        });
        let timed = |kernel: &str, dispatches: u32, [x, y]: [u32; 2]| -> Result<f64, DeviceError> {
            let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(kernel),
                layout: None,
                module: &module,
                entry_point: Some(kernel),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
            let bound = buffers.iter().zip(0..);
            let entries =
                bound.map(|(buffer, binding)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() });
            let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(kernel),
                layout: &pipeline.get_bind_group_layout(0),
                entries: &entries.collect::<Vec<_>>(),
            });
            let mut best = f64::INFINITY;
            for _ in 0..TRIALS {
                let mut encoder = gpu.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                {
                    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                    pass.set_pipeline(&pipeline);
                    pass.set_bind_group(0, &group, &[]);
                    (0..dispatches).for_each(|_| pass.dispatch_workgroups(x, y, 1));
                }
                let commands = encoder.finish();
                let start = Instant::now();
                device.queue.submit([commands]);
                device.wait(None)?;
                best = best.min(start.elapsed().as_secs_f64() / f64::from(dispatches));
            }
            Ok(best)
        };
        let most = limits.max_compute_workgroups_per_dimension;
        let all = super::stepper::workgroups(bytes / GROUP, most);
        let each = |kernel: &str| Ok::<_, DeviceError>(timed(kernel, COPIES, [1, 1])? / ROUNDS);
        Ok(Self {
            copy_rate: 2.0 * bytes as f64 / timed("copy_all", COPIES, all)?,
            dispatch: timed("copy_all", EMPTY, [1, 1])?,
            barriers: [each("storage_barrier")?, each("workgroup_barrier")?],
            dependent_read: each("dependent_read")?,
        })
    }
}
