//! Steps sent off in one submission, and the results read back after it: samples, counters and failures of every shot that runs.

use std::time::Instant;

use super::DeviceError;
use super::buffers::{BufferId, EVENT_WINDOW, IN_FLIGHT};
use super::layout::{EVENT_WORDS, Event, STATUS_WORDS, StepInfo, status};
use super::shader::Stage;
use super::stepper::DeviceStepper;
use crate::solver::FailureEvent;

/// Bytes of an event.
const EVENT_BYTES: u64 = 4 * EVENT_WORDS;

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
    submission: wgpu::SubmissionIndex,
}

impl DeviceStepper<'_> {
    /// Sends steps off in one submission. At most two may be on their way.
    pub fn submit(&mut self, steps: &[StepInfo]) -> Pending {
        self.write_steps(steps);
        let samples = steps.iter().filter(|s| s.slot.is_some()).count();
        let staging = self.submitted % IN_FLIGHT;
        let mut encoder = self.device.inner.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            for (at, info) in steps.iter().enumerate() {
                Stage::ALL.into_iter().for_each(|stage| self.record(&mut pass, at, info, stage));
            }
        }
        let window = |shot: &usize| {
            let first = self.events_read[*shot];
            EventWindow { shot: *shot, first, count: EVENT_WINDOW.min(2 * self.sizes.elements - first) }
        };
        let windows: Vec<EventWindow> = self.running.iter().map(window).collect();
        self.copy_results(&mut encoder, staging, samples, &windows);
        let submission = self.device.queue.submit([encoder.finish()]);
        self.submitted += 1;
        Pending { staging, samples, windows, submission }
    }

    /// Copies samples, counters and events into a staging buffer.
    fn copy_results(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        staging: usize,
        samples: usize,
        windows: &[EventWindow],
    ) {
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
    pub fn collect(&mut self, batch: &Pending) -> Result<Vec<BatchResult>, DeviceError> {
        let shots = batch.windows.len();
        let window_bytes: u64 = batch.windows.iter().map(|window| window.count * EVENT_BYTES).sum();
        let size = self.sample_bytes(batch.samples, shots) + self.sizes.bytes(BufferId::Status) + window_bytes;
        let start = Instant::now();
        let words = self.fetch(&self.staging[batch.staging], size, Some(batch.submission.clone()));
        self.waited += start.elapsed();
        let words = words?;
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
            result.events = self.new_events(window, copied, u64::from(result.status[status::EVENTS]))?;
            results.push(result);
        }
        Ok(results)
    }

    /// Events of a shot up to the `count`-th that have not been read, in the order in which the processor finds them.
    fn new_events(
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
            self.read_part(BufferId::Events, self.event_offset(window.shot, read), (count - read) * EVENT_BYTES)?
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

    /// Runs steps of the first shot that runs in one submission and waits for them.
    ///
    /// # Errors
    /// When the device was lost.
    pub fn run(&mut self, steps: &[StepInfo]) -> Result<BatchResult, DeviceError> {
        let batch = self.submit(steps);
        Ok(self.collect(&batch)?.into_iter().next().unwrap_or_default())
    }
}
