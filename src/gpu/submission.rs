//! Steps sent off in one submission, and what is read back after it: samples, counters and failures of every shot that runs.

use std::time::Instant;

use super::DeviceError;
use super::buffers::{BufferId, EVENT_WINDOW, IN_FLIGHT};
use super::layout::{EVENT_WORDS, STATUS_WORDS, StepInfo, status};
use super::stepper::{DeviceStepper, PARTS, STAMP_BYTES};
use crate::solver::FailureEvent;

/// Bytes of an event.
const EVENT_BYTES: u64 = 4 * EVENT_WORDS;

/// What a submission leaves behind of one shot.
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
    /// Events before these were known when it was recorded, and how many are copied.
    first: u64,
    count: u64,
}

/// Steps on their way.
pub struct Pending {
    /// Which staging buffer they fill.
    staging: usize,
    samples: usize,
    /// Of the shots that run, in order.
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
            for (at, info) in steps.iter().enumerate() {
                match &self.clock {
                    Some(clock) if at == timed => self.record_timed(&mut pass, at, info, &PARTS, clock),
                    _ => self.record(&mut pass, at, info, &PARTS),
                }
            }
        }
        self.dispatches += steps.iter().map(|info| self.dispatches_of(info)).sum::<u64>();
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
        self.timed.send(steps);
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
        let events = windows.iter().map(|window| {
            let from = window.shot as u64 * self.sizes.bytes_of_shot(BufferId::Events) + window.first * EVENT_BYTES;
            (BufferId::Events, from, window.count * EVENT_BYTES)
        });
        let mut to = 0;
        for (name, from, size) in [sampled, counters].into_iter().chain(events) {
            encoder.copy_buffer_to_buffer(self.buffer(name), from, &self.staging[staging], to, size);
            to += size;
        }
        to
    }

    fn sample_bytes(&self, samples: usize, shots: usize) -> u64 {
        4 * (samples * shots * self.sizes.sample_words()) as u64
    }

    /// Waits for the oldest steps on their way and reads what the ledger and the kernels noted of every shot that ran.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn collect(&mut self, batch: &Pending) -> Result<Vec<BatchResult>, DeviceError> {
        let shots = batch.windows.len();
        let window_bytes: u64 = batch.windows.iter().map(|window| window.count * EVENT_BYTES).sum();
        let known = self.sample_bytes(batch.samples, shots) + self.sizes.bytes(BufferId::Status) + window_bytes;
        let size = known + if self.clock.is_some() { STAMP_BYTES } else { 0 };
        let start = Instant::now();
        let words = self.fetch(&self.staging[batch.staging], size, Some(batch.submission.clone()));
        self.waited += start.elapsed();
        let words = words?;
        let (words, stamps) = words.split_at(known as usize / 4);
        if let Some(clock) = &self.clock {
            self.timed.add(batch.timed_sample, &clock.seconds(stamps));
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
            let (known, later) = events.split_at((window.count * EVENT_WORDS) as usize);
            events = later;
            result.events = self.new_events(window, known, u64::from(result.status[status::EVENTS]))?;
            results.push(result);
        }
        Ok(results)
    }

    /// Events of a shot up to the `count`-th that nobody has seen, `known` of them copied.
    fn new_events(
        &mut self,
        window: &EventWindow,
        known: &[u32],
        count: u64,
    ) -> Result<Vec<FailureEvent>, DeviceError> {
        let read = self.events_read[window.shot];
        let words = if count <= window.first + window.count {
            let [from, to] = [read, count].map(|at| ((at - window.first) * EVENT_WORDS) as usize);
            known[from..to].to_vec()
        } else {
            let from = window.shot as u64 * self.sizes.bytes_of_shot(BufferId::Events) + read * EVENT_BYTES;
            self.read_part(BufferId::Events, from, (count - read) * EVENT_BYTES)?
        };
        self.events_read[window.shot] = count;
        Ok(self.sorted(window.shot, &words))
    }

    /// Runs steps of the first shot that runs in one submission and waits for them.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn run(&mut self, steps: &[StepInfo]) -> Result<BatchResult, DeviceError> {
        let batch = self.submit(steps);
        Ok(self.collect(&batch)?.into_iter().next().unwrap_or_default())
    }

    /// Events of a shot in the order the processor would have found them.
    fn sorted(&self, shot: usize, words: &[u32]) -> Vec<FailureEvent> {
        let mut raw: Vec<&[u32]> = words.chunks_exact(EVENT_WORDS as usize).collect();
        raw.sort_by_key(|w| (w[0], w[1], w[2]));
        raw.into_iter()
            .map(|w| {
                let element = w[1] as usize - shot * self.sizes.elements as usize;
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
}
