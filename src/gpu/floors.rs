//! Floors of a device: the least time of a dispatch, of a barrier and of a read that waits for another, and the rate at which a kernel
//! copies memory.

use std::time::Instant;

use super::{Device, DeviceError};

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

/// What no kernel of a device can beat.
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
