//! Every kernel against its twin on the processor, both in single precision and from the same state.
//!
//! Red when: a shader and its twin disagree by more than rounding explains. That it can is proved by the
//! [mutants](super::mutants).

pub(crate) mod compare;
mod packs;
pub(crate) mod scenes;
mod struck;
mod tolerances;

use std::collections::BTreeMap;

use libtest_mimic::Trial;
use ripstop::gpu::Device;
use ripstop::gpu::shader::Kernel;

use super::harness::{Outcome, trial};
use compare::Part;
use scenes::Scene;
use tolerances::TOLERANCES;

/// Largest difference of a line of the table.
#[derive(Default)]
struct Worst {
    /// Over the scale.
    error: f64,
    place: String,
}

/// Largest differences seen, by line of the table.
pub(crate) struct Seen {
    worst: BTreeMap<usize, Worst>,
    /// Whether they are of a card.
    hardware: bool,
}

impl Seen {
    /// Takes in a pair of numbers of a kernel and a quantity. `scale`: size of which an error is a fraction.
    fn see(&mut self, kernel: &str, quantity: &str, [got, expected, scale]: [f64; 3], place: impl FnOnce() -> String) {
        let line = TOLERANCES.iter().position(|line| line.kernel == kernel && line.quantity == quantity);
        let line = line.unwrap_or_else(|| panic!("{quantity} of {kernel} is in no table"));
        let error = if got == expected { 0.0 } else { (got - expected).abs() / scale };
        let error = if error.is_nan() { f64::INFINITY } else { error };
        let worst = self.worst.entry(line).or_default();
        if error > worst.error {
            (worst.error, worst.place) = (error, format!("{}: {got:e} for {expected:e}", place()));
        }
    }

    fn verdict(&self) -> Outcome {
        let over = self.worst.iter().filter(|(line, worst)| worst.error > TOLERANCES[**line].limit(self.hardware));
        let lines: Vec<String> = over
            .map(|(line, Worst { error, place })| {
                let line = &TOLERANCES[*line];
                let limit = line.limit(self.hardware);
                format!("{}, {}: {error:.2e} > {limit:.1e} at {place}", line.kernel, line.quantity)
            })
            .collect();
        if lines.is_empty() { Ok(()) } else { Err(lines.join("\n")) }
    }
}

/// One scene, some parts of a step.
pub(crate) fn check(device: &Device, scene: &Scene, parts: &[Part], source: &dyn Fn(&Kernel) -> String) -> Outcome {
    compare::differences(device, scene, parts, source)?.verdict().map_err(|e| format!("{}: {e}", scene.name))
}

/// Every scene, by the kernels it is for.
fn groups() -> [(&'static str, Vec<Scene>); 3] {
    [("elements", scenes::element_scenes()), ("contact", struck::scenes()), ("plies", packs::scenes())]
}

/// Every scene.
pub(crate) fn all_scenes() -> Vec<Scene> {
    groups().into_iter().flat_map(|(_, scenes)| scenes).collect()
}

/// The tests.
pub(crate) fn tests() -> Vec<Trial> {
    let word = |scene: &Scene| scene.name.replace(", ", "_").replace(' ', "_");
    let mut out = Vec::new();
    for (kind, scene) in groups().into_iter().flat_map(|(kind, scenes)| scenes.into_iter().map(move |s| (kind, s))) {
        let name = format!("kernels::{kind}::{}", word(&scene));
        out.push(trial(name, move |device| check(device, &scene, &Part::ALL, &Kernel::source)));
    }
    out.push(trial("kernels::nothing_happens_after_a_bad_step", compare::bad_step));
    out
}
