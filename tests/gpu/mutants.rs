//! Shaders broken on purpose, each of which the kernel tests must catch.
//!
//! Goes red when a defect of a shader would go unseen: then [`kernels`](super::kernels) has a gap.

use std::sync::OnceLock;

use libtest_mimic::Trial;
use ripstop::gpu::Device;
use ripstop::gpu::shader::{KERNELS, Kernel};

use super::harness::{Outcome, trial_unless};
use super::kernels::compare::Part;
use super::kernels::scenes::Scene;
use super::kernels::{all_scenes, check};

mod table;

/// Defects that a card may not show, for its roundings are larger: an H200 hid these.
const WITHIN_ROUNDINGS: [&str; 4] = [
    "last drag without the mode",
    "refined height beyond that without compression",
    "lighter held nodes",
    "released nodes are dragged",
];
/// Why they are not looked for there.
const UNSEEN: &str = "a card may differ by more than this defect makes";

/// One defect: in a kernel, replaces a text by another.
pub(crate) struct Mutant {
    /// What is wrong.
    pub(crate) name: &'static str,
    /// The kernel it is in.
    pub(crate) kernel: &'static str,
    /// The scene it shows in.
    pub(crate) scene: &'static str,
    pub(crate) find: &'static str,
    pub(crate) put: &'static str,
}

impl Mutant {
    /// The broken source; nothing else is changed.
    fn source(&self, kernel: &Kernel) -> String {
        let source = kernel.source();
        if kernel.name == self.kernel { source.replace(self.find, self.put) } else { source }
    }

    /// Where its kernel shows.
    fn parts(&self) -> &'static [Part] {
        match self.kernel {
            "element_force" => &[Part::Elements],
            "node_update" => &[Part::Nodes, Part::Contact],
            "projectile_points" | "projectile_contact" => &[Part::Contact],
            "ply_search" | "ply_impulse" | "ply_move" => &[Part::Plies],
            _ => &[Part::Ledger],
        }
    }

    fn caught(&self, device: &Device) -> Outcome {
        let kernel = KERNELS.iter().find(|k| k.name == self.kernel).ok_or("no such kernel")?;
        if !kernel.source().contains(self.find) {
            return Err(format!("the shader has no {:?}", self.find));
        }
        let scene = scenes().iter().find(|s| s.name == self.scene).ok_or("no such scene")?;
        match check(device, scene, self.parts(), &|kernel| self.source(kernel)) {
            Ok(()) => Err(format!("nothing is wrong with {:?}", self.put)),
            // A shader that no longer compiles proves nothing.
            Err(text) if text.contains("failed: ") => Err(text),
            Err(_) => Ok(()),
        }
    }
}

fn scenes() -> &'static [Scene] {
    static SCENES: OnceLock<Vec<Scene>> = OnceLock::new();
    SCENES.get_or_init(all_scenes)
}

/// The tests.
pub(crate) fn tests() -> Vec<Trial> {
    let name = |m: &Mutant| format!("mutants::{}::{}", m.kernel, m.name.replace(' ', "_"));
    let unseen =
        |m: &Mutant, device: &Device| (device.is_hardware() && WITHIN_ROUNDINGS.contains(&m.name)).then_some(UNSEEN);
    let test =
        |m: &'static Mutant| trial_unless(name(m), move |device| unseen(m, device), move |device| m.caught(device));
    table::MUTANTS.into_iter().flatten().map(test).collect()
}
