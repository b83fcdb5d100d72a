//! How long kernels take on the device, by its own clock.

use super::DeviceError;
use super::layout::StepInfo;
use super::stepper::{Stage, Stepper};

/// Stages of a sampled step, in order.
pub const STAGES: [Stage; 4] = [Stage::Elements, Stage::Nodes, Stage::Projectile, Stage::Ledger];

impl Stepper<'_> {
    /// Device time of each stage of sampled steps [s], mean over `steps`; `None` where the device has no clock.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn time_stages(&self, steps: &[StepInfo]) -> Result<Option<[f64; 4]>, DeviceError> {
        let gpu = self.device;
        let inside = wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES;
        if !gpu.inner.features().contains(inside) {
            return Ok(None);
        }
        let per_step = STAGES.len() as u32 + 1;
        let mut sums = [0.0; 4];
        for info in steps {
            let queries = gpu.inner.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("stages"),
                ty: wgpu::QueryType::Timestamp,
                count: per_step,
            });
            let size = 8 * u64::from(per_step);
            let resolved = gpu.inner.create_buffer(&wgpu::BufferDescriptor {
                label: Some("stamps"),
                size,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            self.write_steps(std::slice::from_ref(info));
            let mut encoder = gpu.inner.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.write_timestamp(&queries, 0);
                for (at, stage) in (1..).zip(STAGES) {
                    self.record(&mut pass, 0, info, &[stage]);
                    pass.write_timestamp(&queries, at);
                }
            }
            encoder.resolve_query_set(&queries, 0..per_step, &resolved, 0);
            gpu.queue.submit([encoder.finish()]);
            let words = self.read_buffer(&resolved, 0, size)?;
            let stamps: Vec<u64> = bytemuck::pod_collect_to_vec(&words);
            for (sum, pair) in sums.iter_mut().zip(stamps.windows(2)) {
                *sum += pair[1].saturating_sub(pair[0]) as f64 * 1e-9 * f64::from(gpu.queue.get_timestamp_period());
            }
        }
        Ok(Some(sums.map(|s| s / steps.len().max(1) as f64)))
    }

    /// Bandwidth of a copy between two buffers of `size` bytes [bytes/s], reads and writes counted: the device's measure.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn copy_bandwidth(&self, size: u64, repeats: u32) -> Result<f64, DeviceError> {
        let gpu = self.device;
        let usage = wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let [from, to] = ["from", "to"].map(|label| {
            let descriptor = wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false };
            gpu.inner.create_buffer(&descriptor)
        });
        let run = |repeats: u32| {
            let mut encoder = gpu.inner.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            for _ in 0..repeats {
                encoder.copy_buffer_to_buffer(&from, 0, &to, 0, size);
            }
            let start = std::time::Instant::now();
            gpu.queue.submit([encoder.finish()]);
            gpu.wait(None).map(|()| start.elapsed().as_secs_f64())
        };
        run(1)?;
        Ok(2.0 * size as f64 * f64::from(repeats) / run(repeats)?)
    }
}

/// Bytes a kernel moves per element and step, neighbours' shares once: what the memory bound is reckoned by.
pub const BYTES: [(&str, u64); 4] = [
    // Nodes 24; old forces 24, heights 8, flags 4, work 4 read; forces 36, heights 8, flags 4, work 4 written.
    ("element_force", 24 + 40 + 52),
    // Forces 36, nodes 24 read; nodes 24 written.
    ("node_update", 36 + 24 + 24),
    // The few nodes near the projectile.
    ("projectile_contact", 0),
    // Accounts 28, flags 4, forces 36, nodes 24 read; accounts 12, flags 4 written. Only in sampled steps.
    ("ledger", 28 + 4 + 36 + 24 + 16),
];
