//! Shaders broken on purpose, each of which the kernel tests must catch.
//!
//! Goes red when a defect of a shader would go unseen: then [`kernels`](super::kernels) has a gap.

use std::sync::OnceLock;

use libtest_mimic::Trial;
use ripstop::gpu::Device;
use ripstop::gpu::shader::{KERNELS, Kernel};

use super::harness::{Outcome, trial};
use super::kernels::compare::Part;
use super::kernels::scenes::Scene;
use super::kernels::{all_scenes, check};
use table::DEFECTS;

mod table;

/// Text of a kernel, and the wrong one that takes its place.
pub(crate) struct Defect {
    /// The kernel it is in.
    kernel: &'static str,
    /// Fault of the broken kernel.
    name: &'static str,
    /// The scene it shows in.
    scene: &'static str,
    find: &'static str,
    put: &'static str,
}

impl Defect {
    /// The broken source; other kernels are as they are.
    fn source(&self, kernel: &Kernel) -> String {
        let source = kernel.source();
        if kernel.name == self.kernel { source.replace(self.find, self.put) } else { source }
    }

    /// Comparisons that its kernel shows in.
    fn parts(&self) -> &'static [Part] {
        match self.kernel {
            "element_force" => &[Part::Elements, Part::EnergyBalance],
            "node_update" => &[Part::Nodes, Part::Contact],
            "projectile_points" | "projectile_contact" => &[Part::Contact],
            "ply_search" | "ply_impulse" | "ply_move" => &[Part::Plies, Part::EnergyBalance],
            _ => &[Part::EnergyBalance],
        }
    }

    fn caught(&self, device: &Device) -> Outcome {
        static SCENES: OnceLock<Vec<Scene>> = OnceLock::new();
        let kernel = KERNELS.iter().find(|k| k.name == self.kernel).ok_or("no such kernel")?;
        if !kernel.source().contains(self.find) {
            return Err(format!("the shader has no {:?}: the entry no longer applies", self.find));
        }
        let scene = SCENES.get_or_init(all_scenes).iter().find(|s| s.name == self.scene).ok_or("no such scene")?;
        match check(device, scene, self.parts(), &|kernel| self.source(kernel)) {
            Ok(()) => Err(format!("nothing is wrong with {:?}", self.put)),
            // A shader that no longer compiles proves nothing.
            Err(text) if text.contains("failed: ") => Err(text),
            Err(_) => Ok(()),
        }
    }
}

/// Every kernel has a defect.
fn every_kernel(_: &Device) -> Outcome {
    let without = KERNELS.iter().find(|kernel| DEFECTS.iter().all(|defect| defect.kernel != kernel.name));
    without.map_or(Ok(()), |kernel| Err(format!("no defect of {}", kernel.name)))
}

/// The tests.
pub(crate) fn tests() -> Vec<Trial> {
    let name = |defect: &Defect| format!("mutants::{}::{}", defect.kernel, defect.name.replace(' ', "_"));
    let of_defect = |defect: &'static Defect| trial(name(defect), move |device| defect.caught(device));
    DEFECTS.iter().map(of_defect).chain([trial("mutants::every_kernel", every_kernel)]).collect()
}
