//! Steps sent off in one submission, and the results read back after it: samples, counters and failures of every shot that runs, and the
//! time that stages took by the device's clock.

use serde::{Deserialize, Serialize};
use web_time::Instant;

use super::buffers::{BufferId, EVENT_WINDOW, IN_FLIGHT};
use super::layout::{EVENT_WORDS, Event, STATUS_WORDS, StepInfo, status};
use super::shader::Stage;
use super::stepper::DeviceStepper;
use super::{Device, DeviceError};
use crate::solver::FailureEvent;

/// Bytes of an event.
const EVENT_BYTES: u64 = 4 * EVENT_WORDS;
/// Bytes of the stamps around the stages of a step.
pub(super) const STAMP_BYTES: u64 = 8 * (Stage::ALL.len() as u64 + 1);

/// Results of a submission for one shot.
#[derive(Clone, Debug, Default)]
pub struct BatchResult {
    /// Number of the shot.
    pub shot: usize,
    /// Words of each sample, in order of the slots.
    pub samples: Vec<Vec<u32>>,
    /// The counters.
    pub status: [u32; STATUS_WORDS],
    /// Failures in order of step, element and yarn.
    pub events: Vec<FailureEvent>,
}

/// Events of a shot that are copied with a submission.
struct EventWindow {
    shot: usize,
    /// Events known when it was recorded.
    first: u64,
    /// Events copied after those.
    count: u64,
}

/// Steps on their way.
pub struct Pending {
    /// Staging buffer that they fill.
    staging: usize,
    samples: usize,
    /// Event windows of the shots that run, in order.
    windows: Vec<EventWindow>,
    /// Whether the step whose stages were timed was sampled.
    timed_sample: bool,
    submission: wgpu::SubmissionIndex,
}

impl DeviceStepper<'_> {
    /// Sends steps off in one submission. At most two may be on their way.
    pub fn submit(&mut self, steps: &[StepInfo]) -> Pending {
        self.write_steps(steps);
        let samples = steps.iter().filter(|s| s.slot.is_some()).count();
        let staging = self.submitted % IN_FLIGHT;
        let mut encoder = self.device.inner.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        // One step is timed, another one each time.
        let timed = 7 * self.submitted % steps.len().max(1);
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            let mut bound = None;
            for (at, info) in steps.iter().enumerate() {
                let clock = self.clock.as_ref().filter(|_| at == timed);
                if let Some(clock) = clock {
                    clock.stamp(&mut pass, 0);
                }
                for (number, stage) in (1..).zip(Stage::ALL) {
                    self.record(&mut pass, at, info, stage, &mut bound);
                    if let Some(clock) = clock {
                        clock.stamp(&mut pass, number);
                    }
                }
            }
        }
        let window = |shot: &usize| {
            let first = self.events_read[*shot];
            EventWindow { shot: *shot, first, count: EVENT_WINDOW.min(2 * self.sizes.elements - first) }
        };
        let windows: Vec<EventWindow> = self.running.iter().map(window).collect();
        let copied = self.copy_results(&mut encoder, staging, samples, &windows);
        if let Some(clock) = &self.clock {
            clock.resolve(&mut encoder);
            encoder.copy_buffer_to_buffer(&clock.resolved, 0, &self.staging[staging], copied, STAMP_BYTES);
        }
        self.times.send(steps);
        let timed_sample = steps.get(timed).is_some_and(|step| step.slot.is_some());
        let submission = self.device.queue.submit([encoder.finish()]);
        self.submitted += 1;
        Pending { staging, samples, windows, timed_sample, submission }
    }

    /// Copies samples, counters and events into a staging buffer; gives how much that is [bytes].
    fn copy_results(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        staging: usize,
        samples: usize,
        windows: &[EventWindow],
    ) -> u64 {
        let sampled = (BufferId::Samples, 0, self.sample_bytes(samples, windows.len()));
        let counters = (BufferId::Status, 0, self.sizes.bytes(BufferId::Status));
        let events = windows
            .iter()
            .map(|window| (BufferId::Events, self.event_offset(window.shot, window.first), window.count * EVENT_BYTES));
        let mut to = 0;
        for (name, from, size) in [sampled, counters].into_iter().chain(events) {
            encoder.copy_buffer_to_buffer(self.buffer(name), from, &self.staging[staging], to, size);
            to += size;
        }
        to
    }

    fn event_offset(&self, shot: usize, event: u64) -> u64 {
        shot as u64 * self.sizes.bytes_of_shot(BufferId::Events) + event * EVENT_BYTES
    }

    fn sample_bytes(&self, samples: usize, shots: usize) -> u64 {
        4 * (samples * shots * self.sizes.sample_words()) as u64
    }

    /// Waits for the oldest steps on their way and reads the results of every shot that ran.
    ///
    /// # Errors
    /// When the device was lost.
    pub async fn collect(&mut self, batch: &Pending) -> Result<Vec<BatchResult>, DeviceError> {
        let shots = batch.windows.len();
        let window_bytes: u64 = batch.windows.iter().map(|window| window.count * EVENT_BYTES).sum();
        let known = self.sample_bytes(batch.samples, shots) + self.sizes.bytes(BufferId::Status) + window_bytes;
        let size = known + if self.clock.is_some() { STAMP_BYTES } else { 0 };
        let start = Instant::now();
        let words = self.fetch(&self.staging[batch.staging], size, Some(batch.submission.clone())).await;
        self.waited += start.elapsed();
        let words = words?;
        let (words, stamps) = words.split_at(known as usize / 4);
        if let Some(clock) = &self.clock {
            self.times.add(batch.timed_sample, &clock.seconds(stamps));
        }
        let sample_words = self.sizes.sample_words();
        let (sampled, rest) = words.split_at(batch.samples * shots * sample_words);
        let (counters, mut events) = rest.split_at(self.sizes.bytes(BufferId::Status) as usize / 4);
        let status_words = counters.len() / self.sizes.shots as usize;
        let mut results = Vec::with_capacity(shots);
        for (layer, window) in batch.windows.iter().enumerate() {
            let of_shot = sampled.chunks(sample_words).skip(layer).step_by(shots);
            let mut result = BatchResult {
                shot: window.shot,
                samples: of_shot.map(<[u32]>::to_vec).collect(),
                ..BatchResult::default()
            };
            result.status.copy_from_slice(&counters[window.shot * status_words..][..STATUS_WORDS]);
            let (copied, later) = events.split_at((window.count * EVENT_WORDS) as usize);
            events = later;
            result.events = self.new_events(window, copied, u64::from(result.status[status::EVENTS])).await?;
            results.push(result);
        }
        Ok(results)
    }

    /// Events of a shot up to the `count`-th that have not been read, in the order in which the processor finds them.
    async fn new_events(
        &mut self,
        window: &EventWindow,
        copied: &[u32],
        count: u64,
    ) -> Result<Vec<FailureEvent>, DeviceError> {
        let read = self.events_read[window.shot];
        // A forged checkpoint may count more than there are.
        let count = count.max(read);
        self.events_read[window.shot] = count;
        let words = if count <= window.first + window.count {
            let [from, to] = [read, count].map(|at| ((at - window.first) * EVENT_WORDS) as usize);
            copied[from..to].to_vec()
        } else {
            self.read_part(BufferId::Events, self.event_offset(window.shot, read), (count - read) * EVENT_BYTES).await?
        };
        let mut events: Vec<Event> = bytemuck::pod_collect_to_vec(&words);
        events.sort_by_key(|event| (event.step, event.element, event.yarn));
        let first = window.shot * self.sizes.elements as usize;
        let failure = |event: Event| {
            let element = event.element as usize - first;
            let (ply, row) = self.grid.element_row(element / self.grid.columns);
            FailureEvent {
                step: u64::from(event.step),
                ply: ply as u32,
                i: (element % self.grid.columns) as u32,
                j: row as u32,
                yarn: event.yarn as u8,
                strain: f64::from(event.strain),
            }
        };
        Ok(events.into_iter().map(failure).collect())
    }
}

/// Stamps of the device's clock before and after each stage of a step.
pub(super) struct DeviceClock {
    queries: wgpu::QuerySet,
    /// Buffer of the stamps once they are resolved.
    resolved: wgpu::Buffer,
    /// Period of a tick [s].
    period: f64,
}

impl DeviceClock {
    /// The clock; `None` where the device has none that can be read between stages.
    pub(super) fn new(gpu: &Device) -> Option<Self> {
        if !gpu.has_clock() {
            return None;
        }
        let queries = gpu.inner.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("stages"),
            ty: wgpu::QueryType::Timestamp,
            count: Stage::ALL.len() as u32 + 1,
        });
        let resolved = gpu.inner.create_buffer(&wgpu::BufferDescriptor {
            label: Some("stamps"),
            size: STAMP_BYTES,
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        Some(Self { queries, resolved, period: 1e-9 * f64::from(gpu.queue.get_timestamp_period()) })
    }

    /// Takes the time: 0 before the first stage, n after the n-th.
    fn stamp(&self, pass: &mut wgpu::ComputePass<'_>, number: u32) {
        pass.write_timestamp(&self.queries, number);
    }

    /// Puts the stamps where they can be copied from.
    fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        encoder.resolve_query_set(&self.queries, 0..Stage::ALL.len() as u32 + 1, &self.resolved, 0);
    }

    /// Time between the stamps [s].
    fn seconds(&self, words: &[u32]) -> Vec<f64> {
        let stamps: Vec<u64> = bytemuck::pod_collect_to_vec(words);
        stamps.windows(2).map(|pair| pair[1].saturating_sub(pair[0]) as f64 * self.period).collect()
    }
}

/// Time that the stages of a step take, from one step of every batch.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(crate) struct StageTimes {
    /// Sum of each stage [s], and steps in which it was timed.
    sums: [(f64, u64); Stage::ALL.len()],
    /// Steps sent off, and those of them that were sampled.
    sent: [u64; 2],
}

impl StageTimes {
    /// Counts the steps of a batch.
    fn send(&mut self, steps: &[StepInfo]) {
        self.sent[0] += steps.len() as u64;
        self.sent[1] += steps.iter().filter(|step| step.slot.is_some()).count() as u64;
    }

    /// Adds the stages of one step [s].
    fn add(&mut self, sampled: bool, seconds: &[f64]) {
        for ((sum, stage), seconds) in self.sums.iter_mut().zip(Stage::ALL).zip(seconds) {
            if sampled || stage != Stage::EnergyBalance {
                *sum = (sum.0 + seconds, sum.1 + 1);
            }
        }
    }

    /// Stages by the name of their kernel, and their time in all steps [s] by the timed ones; empty where the device has no clock.
    pub(super) fn seconds(&self) -> Vec<(&'static str, f64)> {
        if self.sums[0].1 == 0 {
            return Vec::new();
        }
        let all = |stage: Stage| self.sent[usize::from(stage == Stage::EnergyBalance)] as f64;
        let stages = Stage::ALL.into_iter().zip(self.sums);
        stages.map(|(stage, (sum, count))| (stage.name(), all(stage) * sum / count.max(1) as f64)).collect()
    }
}
