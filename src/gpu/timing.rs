//! How long kernels take on the device, by its own clock.

use serde::{Deserialize, Serialize};

use super::layout::StepInfo;
use super::stepper::{self, DeviceStepper, Stage};
use super::{Device, DeviceError};

/// Stages of a sampled step of a single ply, in order.
const STAGES: [Stage; 4] = [Stage::Elements, Stage::Nodes, Stage::Projectile, Stage::Ledger];

/// Stamps of the device's clock before and after each of some stages.
pub(crate) struct DeviceClock {
    queries: wgpu::QuerySet,
    stamps: u32,
    /// Where the stamps lie once they are resolved.
    pub(crate) resolved: wgpu::Buffer,
    /// Of a tick [s].
    period: f64,
}

impl DeviceClock {
    /// A clock for so many stages; `None` where the device has none that can be read between them.
    pub(crate) fn new(gpu: &Device, stages: usize) -> Option<Self> {
        if !gpu.has_clock() {
            return None;
        }
        let stamps = stages as u32 + 1;
        let queries = gpu.inner.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("stages"),
            ty: wgpu::QueryType::Timestamp,
            count: stamps,
        });
        let resolved = gpu.inner.create_buffer(&wgpu::BufferDescriptor {
            label: Some("stamps"),
            size: Self::bytes(stages),
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let period = 1e-9 * f64::from(gpu.queue.get_timestamp_period());
        Some(Self { queries, stamps, resolved, period })
    }

    /// Size of the stamps around so many stages.
    pub(crate) const fn bytes(stages: usize) -> u64 {
        8 * (stages as u64 + 1)
    }

    /// Takes the time: 0 before the first stage, n after the n-th.
    pub(crate) fn stamp(&self, pass: &mut wgpu::ComputePass<'_>, number: usize) {
        pass.write_timestamp(&self.queries, number as u32);
    }

    /// Puts the stamps where they can be copied from.
    pub(crate) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..self.stamps, &self.resolved, 0);
    }

    /// What lies between the stamps [s].
    pub(crate) fn seconds(&self, words: &[u32]) -> Vec<f64> {
        let stamps: Vec<u64> = bytemuck::pod_collect_to_vec(words);
        stamps.windows(2).map(|pair| pair[1].saturating_sub(pair[0]) as f64 * self.period).collect()
    }
}

impl DeviceStepper<'_> {
    /// Device time of each stage of sampled steps [s], mean over `steps`; `None` where the device has no clock.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn time_stages(&self, steps: &[StepInfo]) -> Result<Option<[f64; 4]>, DeviceError> {
        let gpu = self.device;
        let Some(clock) = DeviceClock::new(gpu, STAGES.len()) else { return Ok(None) };
        let mut sums = [0.0; 4];
        for info in steps {
            self.write_steps(std::slice::from_ref(info));
            let mut encoder = gpu.inner.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                self.record_timed(&mut pass, 0, info, &STAGES, &clock);
            }
            clock.resolve(&mut encoder);
            gpu.queue.submit([encoder.finish()]);
            let words = self.read_buffers(&[(&clock.resolved, [0, DeviceClock::bytes(STAGES.len())])])?;
            for (sum, seconds) in sums.iter_mut().zip(clock.seconds(&words)) {
                *sum += seconds;
            }
        }
        Ok(Some(sums.map(|s| s / steps.len().max(1) as f64)))
    }

    /// Records parts of a step with the time taken before and after each.
    pub(crate) fn record_timed(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        at: usize,
        info: &StepInfo,
        parts: &[Stage],
        clock: &DeviceClock,
    ) {
        clock.stamp(pass, 0);
        for (number, part) in (1..).zip(parts) {
            self.record(pass, at, info, std::slice::from_ref(part));
            clock.stamp(pass, number);
        }
    }

    /// Bandwidth of a copy between two buffers of `size` bytes [bytes/s], reads and writes counted: the device's measure.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn copy_bandwidth(&self, size: u64, repeats: u32) -> Result<f64, DeviceError> {
        let gpu = self.device;
        let [from, to] = ["from", "to"].map(|label| gpu.buffer(label, size, wgpu::BufferUsages::COPY_SRC));
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
    // Nodes 24; old forces 24, heights 24, flags 4, work 4 read; forces 36, heights 24, flags 4, work 4 written.
    ("element_force", 24 + 56 + 68),
    // Forces 36, nodes 24 read; nodes 24 written.
    ("node_update", 36 + 24 + 24),
    // The few nodes near the projectile.
    ("projectile_contact", 0),
    // Accounts 28, flags 4, forces 36, nodes 24 read; accounts 12, flags 4 written. Only in sampled steps.
    ("energy_balance", 28 + 4 + 36 + 24 + 16),
];

/// What the parts of a step take, from one step of every batch.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct Timed {
    /// By part [s], and in how many steps it was there to be timed.
    sums: [(f64, u64); stepper::PARTS.len()],
    /// Steps sent off, and those of them that were sampled.
    sent: [u64; 2],
}

impl Timed {
    /// Adds the steps of a batch.
    pub(crate) fn send(&mut self, steps: &[StepInfo]) {
        self.sent[0] += steps.len() as u64;
        self.sent[1] += steps.iter().filter(|step| step.slot.is_some()).count() as u64;
    }

    /// Adds the parts of one step [s].
    pub(crate) fn add(&mut self, sampled: bool, seconds: &[f64]) {
        for ((sum, part), seconds) in self.sums.iter_mut().zip(stepper::PARTS).zip(seconds) {
            if sampled || part != Stage::Ledger {
                *sum = (sum.0 + seconds, sum.1 + 1);
            }
        }
    }

    /// Every part by the name of its kernel and what it took in all steps [s], as far as the timed ones tell; empty
    /// where the device has no clock.
    pub(crate) fn seconds(&self) -> Vec<(&'static str, f64)> {
        if self.sums[0].1 == 0 {
            return Vec::new();
        }
        let all = |stage: Stage| self.sent[usize::from(stage == Stage::Ledger)] as f64;
        let parts = stepper::PARTS.into_iter().zip(self.sums);
        parts.map(|(stage, (sum, count))| (stage.name(), all(stage) * sum / count.max(1) as f64)).collect()
    }
}
