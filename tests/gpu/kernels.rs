//! Every kernel against its twin on the processor, both in single precision and from the same state.
//!
//! Goes red when a shader and its twin disagree by more than rounding explains. That it can is proved by the
//! [mutants](super::mutants).

pub(crate) mod compare;
mod scales;
pub(crate) mod scenes;
pub(crate) mod seen;
mod tolerances;

use std::collections::BTreeSet;

use libtest_mimic::Trial;
use ripstop::gpu::Device;
use ripstop::gpu::shader::Kernel;

use super::harness::{Outcome, trial};
use compare::Part;
use scenes::Scene;
use tolerances::TOLERANCES;

/// One scene, some parts of a step.
pub(crate) fn check(device: &Device, scene: &Scene, parts: &[Part], source: &dyn Fn(&Kernel) -> String) -> Outcome {
    compare::differences(device, scene, parts, source)?.verdict().map_err(|e| format!("{}: {e}", scene.name))
}

/// Every line of the table is held by some scene, and numbers off by twice its tolerance would turn it red.
fn whole_table(device: &Device) -> Outcome {
    let scenes = all_scenes();
    let mut lines = BTreeSet::new();
    for name in [
        "pieces of yarn of different strength",
        "sphere, spinning, oblique, friction",
        "between nodes, light",
        "two free plies",
        "resting plies of two fabrics",
    ] {
        let scene = scenes.iter().find(|scene| scene.name == name).ok_or_else(|| format!("no scene {name}"))?;
        let seen = compare::differences(device, scene, &Part::ALL, &Kernel::source)?;
        let blind = seen.blind();
        if !blind.is_empty() {
            return Err(format!("{name}: blind to {blind:?}"));
        }
        lines.extend(seen.lines());
    }
    let open: Vec<_> =
        (0..TOLERANCES.len()).filter(|line| !lines.contains(line)).map(|line| TOLERANCES[line]).collect();
    if open.is_empty() { Ok(()) } else { Err(format!("held by nothing: {open:?}")) }
}

/// Every scene, by the kernels it is for.
fn groups() -> [(&'static str, Vec<Scene>); 3] {
    [("elements", scenes::element_scenes()), ("contact", scenes::contact_scenes()), ("plies", scenes::packs::scenes())]
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
    for scene in scenes::packs::scenes().into_iter().chain([scenes::packs::aligned(), scenes::packs::slow()]) {
        let name = format!("kernels::plies::impulses_cancel::{}", word(&scene));
        out.push(trial(name, move |device| compare::cancels(device, &scene)));
    }
    for scene in scenes::packs::scenes().into_iter().filter(scenes::packs::is_free) {
        let name = format!("kernels::plies::momentum_stays::{}", word(&scene));
        out.push(trial(name, move |device| compare::keeps_momentum(device, &scene)));
    }
    out.push(trial("kernels::no_line_of_the_table_is_idle_or_blind", whole_table));
    out.push(trial("kernels::nothing_happens_after_a_bad_step", compare::bad_step));
    out.push(trial("kernels::a_rim_without_room_is_told_and_not_heeded", compare::crowded));
    out.push(trial("kernels::contact_without_rest_lets_go_what_pulls", compare::restless));
    out
}
