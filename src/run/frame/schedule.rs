//! Schedule of the frames: evenly over a run whose end is not known before it comes.
//!
//! Frames are taken more often than asked for. Each time there are twice as many as asked for, every second one is given up, and
//! those to come lie twice as far apart. So at any time between half and all of twice as many lie evenly from the start on, and
//! [`even`] chooses from them.

/// Ratio of the frames taken at first to those asked for: a run that ends after this part of its end time has as many frames
/// as asked for. A power of two, so that a run that reaches its end time has frames at even times to the step.
const FINEST: f64 = 64.0;

/// Times at which frames are due, and those of them that are kept.
#[derive(Clone, Debug)]
pub(crate) struct Schedule {
    /// Frames asked for.
    wanted: usize,
    /// Interval of the frames of a run that reaches its end time [s].
    widest: f64,
    /// Interval now [s].
    interval: f64,
    /// Multiples of the interval whose time has come.
    passed: u64,
    /// Multiple of the interval, and steps done, of the frames kept.
    kept: Vec<[u64; 2]>,
}

impl Schedule {
    /// Schedule of `wanted` frames from 0 to the end of a run, at `end_time` [s] or before.
    pub(crate) fn new(wanted: usize, end_time: f64) -> Self {
        let widest = end_time / wanted.saturating_sub(1).max(1) as f64;
        Self { wanted, widest, interval: widest / FINEST, passed: 0, kept: Vec::new() }
    }

    /// Schedule of a run that goes on before the step of this number, `dt` [s] long.
    pub(crate) fn resume(wanted: usize, end_time: f64, step: u64, dt: f64) -> Self {
        let mut schedule = Self::new(wanted, end_time);
        (0..step).for_each(|past| schedule.pass(past, dt));
        schedule
    }

    /// The interval [s]: no finer than the time step `dt` [s].
    fn interval(&self, dt: f64) -> f64 {
        let mut interval = self.interval;
        while interval < dt && interval < self.widest {
            interval *= 2.0;
        }
        interval
    }

    /// Whether a frame is due at `time` [s], or nearer to it than to the next step `dt` [s] later.
    pub(crate) fn is_due(&self, time: f64, dt: f64) -> bool {
        (self.wanted > 1 || self.passed < self.wanted as u64)
            && time >= self.passed as f64 * self.interval(dt) - 0.5 * dt
    }

    /// The frame before this step, `dt` [s] long, is taken; others may be given up.
    pub(crate) fn pass(&mut self, step: u64, dt: f64) {
        let time = step as f64 * dt;
        if !self.is_due(time, dt) {
            return;
        }
        while self.is_due(time, dt) {
            self.passed += 1;
        }
        self.kept.push([self.passed - 1, step]);
        if self.wanted > 1 && self.kept.len() > 2 * (self.wanted - 1) + 1 {
            self.interval = 2.0 * self.interval(dt);
            self.passed = self.passed.div_ceil(2);
            self.kept.retain(|[number, _]| number % 2 == 0);
            self.kept.iter_mut().for_each(|[number, _]| *number /= 2);
        }
    }

    /// Whether the state after the last step is one more frame: not where it is the last frame or the step after that.
    pub(crate) fn wants_end(&self, step: u64) -> bool {
        self.wanted > 1 && self.kept.last().is_none_or(|[_, last]| last + 1 < step)
    }

    /// Steps done before the frames that are kept, in order.
    pub(crate) fn kept(&self) -> impl Iterator<Item = u64> {
        self.kept.iter().map(|[_, step]| *step)
    }
}

/// Which of these ascending times lie most evenly from the first to the last: at most `wanted`, all if there are fewer.
pub fn even(times: &[f64], wanted: usize) -> Vec<usize> {
    let count = times.len();
    if count <= wanted || wanted < 2 {
        return (0..count.min(wanted)).collect();
    }
    let (first, last) = (times[0], times[count - 1]);
    let mut chosen = Vec::with_capacity(wanted);
    let mut free = 0;
    for number in 0..wanted {
        let ideal = first + (last - first) * number as f64 / (wanted - 1) as f64;
        // Enough must be left for those that follow.
        let most = count - (wanted - number);
        let mut nearest = free;
        while nearest < most && (times[nearest + 1] - ideal).abs() <= (times[nearest] - ideal).abs() {
            nearest += 1;
        }
        chosen.push(nearest);
        free = nearest + 1;
    }
    chosen
}

#[cfg(test)]
#[path = "schedule_tests.rs"]
mod tests;
