//! Every kernel against its twin on the processor, both in single precision and from the same state.
//!
//! Goes red when a shader and its twin disagree by more than rounding explains. That it can is proved by the
//! [mutants](super::mutants).

pub(crate) mod compare;
pub(crate) mod scenes;
pub(crate) mod tolerances;

use libtest_mimic::Trial;
use ripstop::gpu::Device;
use ripstop::gpu::shader::Kernel;

use super::harness::{Outcome, trial};
use compare::Part;
use scenes::Scene;

/// One scene, some parts of a step.
pub(crate) fn check(device: &Device, scene: &Scene, parts: &[Part], source: &dyn Fn(&Kernel) -> String) -> Outcome {
    compare::differences(device, scene, parts, source)?.verdict().map_err(|e| format!("{}: {e}", scene.name))
}

/// The tests.
pub(crate) fn tests() -> Vec<Trial> {
    let scenes = scenes::element_scenes().into_iter().map(|scene| ("elements", scene));
    let contact = scenes::contact_scenes().into_iter().map(|scene| ("contact", scene));
    let mut out: Vec<Trial> = scenes
        .chain(contact)
        .map(|(kind, scene)| {
            let name = format!("kernels::{kind}::{}", scene.name.replace(", ", "_").replace(' ', "_"));
            trial(name, move |device| check(device, &scene, &Part::ALL, &Kernel::source))
        })
        .collect();
    out.push(trial("kernels::nothing_happens_after_a_bad_step", compare::bad_step));
    out
}
