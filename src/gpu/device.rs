//! Adapters and devices: the graphics processors of the machine, and the choice of one.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

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
    let backends = wgpu::Backends::PRIMARY;
    let descriptor = wgpu::InstanceDescriptor { backends, ..wgpu::InstanceDescriptor::new_without_display_handle() };
    let found = pollster::block_on(wgpu::Instance::new(descriptor).enumerate_adapters(backends));
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
        Self::open_narrow(adapter, wgpu::Limits::default().max_compute_workgroups_per_dimension)
    }

    /// Opens an adapter with at most `workgroups` per dimension of a dispatch: larger ones spread over two dimensions, which
    /// ordinary limits ask for only from four million elements on.
    ///
    /// # Errors
    /// As [`Self::open`].
    #[doc(hidden)]
    pub fn open_narrow(adapter: &Adapter, workgroups: u32) -> Result<Self, DeviceError> {
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
        let (inner, queue) = pollster::block_on(adapter.inner.request_device(&descriptor))
            .map_err(|e| DeviceError::Refused { adapter: adapter.name().to_owned(), reason: e.to_string() })?;
        Ok(Self::new(inner, queue, adapter.name().to_owned(), adapter.is_hardware()))
    }

    /// A device that accepts everything and computes nothing: it checks pipelines and bindings where there is no driver.
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
