//! Floors of a device: the least time of a dispatch, and the rate at which a kernel copies memory.

use std::time::Instant;

use super::{Device, DeviceError};

/// Copies one array to another, 16 bytes an invocation.
const COPY: &str = "
@group(0) @binding(0) var<storage, read> source: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> copy: array<vec4<f32>>;
@compute @workgroup_size(256)
fn copy_all(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let at = id.y * groups.x * 256u + id.x;
    if (at < arrayLength(&copy)) { copy[at] = source[at]; }
}";
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

/// What no kernel of a device can beat.
#[derive(Clone, Copy, Debug)]
pub struct Floors {
    /// Bytes read and written by a kernel that copies [B/s].
    pub copy_rate: f64,
    /// Time of a dispatch that waits for the one before it and does nothing else [s].
    pub dispatch: f64,
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
            label: Some("copy"),
            source: wgpu::ShaderSource::Wgsl(COPY.into()),
        });
        let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("copy"),
            layout: None,
            module: &module,
            entry_point: Some("copy_all"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        let entry =
            |binding: u32| wgpu::BindGroupEntry { binding, resource: buffers[binding as usize].as_entire_binding() };
        let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("copy"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[entry(0), entry(1)],
        });
        let timed = |dispatches: u32, [x, y]: [u32; 2]| -> Result<f64, DeviceError> {
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
            Ok(start.elapsed().as_secs_f64() / f64::from(dispatches))
        };
        let best = |dispatches, groups| -> Result<f64, DeviceError> {
            let times: Result<Vec<f64>, _> = (0..TRIALS).map(|_| timed(dispatches, groups)).collect();
            Ok(times?.into_iter().fold(f64::INFINITY, f64::min))
        };
        let most = limits.max_compute_workgroups_per_dimension;
        let all = super::stepper::workgroups(bytes / GROUP, most);
        Ok(Self { copy_rate: 2.0 * bytes as f64 / best(COPIES, all)?, dispatch: best(EMPTY, [1, 1])? })
    }
}
