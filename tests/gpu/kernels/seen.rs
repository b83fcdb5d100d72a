//! The largest differences of a comparison, held against the table of tolerances.

use std::collections::BTreeMap;

use ripstop::gpu::Device;

use super::tolerances::{TOLERANCES, line};
use crate::gpu::harness::Outcome;

/// Set to 1 to see the differences of every comparison, which then fails.
const SHOW: &str = "RIPSTOP_SHOW_DIFFERENCES";

/// The largest difference of a line of the table.
#[derive(Default)]
struct Worst {
    /// Over the scale.
    error: f64,
    place: String,
    /// What it would be if every number of the device were off by twice the tolerance more, or by one where nothing may differ.
    moved: f64,
}

/// The largest differences seen, by line of the table.
pub(crate) struct Seen {
    worst: BTreeMap<usize, Worst>,
    /// Whether they are of a card.
    hardware: bool,
}

impl Seen {
    /// Nothing yet, of a device.
    pub(crate) fn on(device: &Device) -> Self {
        Self { worst: BTreeMap::new(), hardware: device.is_hardware() }
    }

    fn limit(&self, what: usize) -> f64 {
        TOLERANCES[what].limit(self.hardware)
    }

    /// Takes note of a pair of numbers of a kernel and a quantity. `scale`: size of which an error is a fraction.
    pub(crate) fn see(
        &mut self,
        [kernel, quantity]: [&str; 2],
        got: f64,
        expected: f64,
        scale: f64,
        place: impl FnOnce() -> String,
    ) {
        let what = line(kernel, quantity);
        let error = |got: f64| {
            let error = if got == expected { 0.0 } else { (got - expected).abs() / scale };
            if error.is_nan() { f64::INFINITY } else { error }
        };
        let limit = self.limit(what);
        let twice = if limit > 0.0 { 2.0 * limit * scale } else { 1.0 };
        let worst = self.worst.entry(what).or_default();
        worst.moved = worst.moved.max(error(got + twice));
        if error(got) > worst.error {
            worst.error = error(got);
            worst.place = format!("{}: {got:e} for {expected:e}", place());
        }
    }

    /// Lines of the table of which something was compared.
    pub(crate) fn lines(&self) -> impl Iterator<Item = usize> + '_ {
        self.worst.keys().copied()
    }

    /// Lines whose numbers could be off by twice the tolerance unseen.
    pub(crate) fn blind(&self) -> Vec<&'static str> {
        let blind = self.worst.iter().filter(|(what, worst)| worst.moved <= self.limit(**what));
        blind.map(|(what, _)| TOLERANCES[*what].quantity).collect()
    }

    /// Everything against the table.
    pub(crate) fn verdict(&self) -> Outcome {
        let show = std::env::var(SHOW).is_ok_and(|value| value == "1");
        let lines: Vec<String> = self
            .worst
            .iter()
            .filter(|(what, worst)| show || worst.error > self.limit(**what))
            .map(|(what, Worst { error, place, .. })| {
                let line = &TOLERANCES[*what];
                format!(
                    "{}, {}: {error:.2e} > {:.1e} ({}; {}) at {place}",
                    line.kernel,
                    line.quantity,
                    self.limit(*what),
                    line.scale,
                    line.reason
                )
            })
            .collect();
        if lines.is_empty() { Ok(()) } else { Err(lines.join("\n")) }
    }
}
