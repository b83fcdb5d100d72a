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
            "sweep" => &[Part::Sweep, Part::EnergyBalance, Part::Contact],
            "projectile_search" | "projectile_contact" => &[Part::Contact],
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

/// Kernel, then name and scene of a defect, the text and the wrong one; in the order of a step.
macro_rules! defects {
    ($($kernel:ident { $($name:literal in $scene:literal: $find:literal => $put:literal;)+ })+) => {
        /// At least one defect of every kernel, and of nearly every file of `shaders`.
        const DEFECTS: &[Defect] = &[$($(Defect {
            kernel: stringify!($kernel), name: $name, scene: $scene, find: $find, put: $put
        }),+),+];
    };
}

defects! {
    sweep {
        "the rate of strain adds nothing" in "stress by the rate of strain": "added * elastic" => "added * 0.0";
        "clay as soft below" in "against clay": "plies[ply].clay_gain * crater" => "0.0 * crater";
        "hourglass mode of the wrong sign" in "variational, compressible": "let top = c - d;" => "let top = d - c;";
        "shear force not square to the weft" in "variational, compressible":
            "(k.warp - k.sine * k.weft)" => "(k.warp + k.sine * k.weft)";
        "last drag forgotten" in "variational, compressible":
            "force * grown.along + taut * before" => "force * grown.along + 0.0 * before";
        "hourglass work of the first step" in "variational, rigid": "mode - step.span * v.mode" => "mode - step.kick * v.mode";
        "row of elements before the reach left out" in "only a part reached":
            "let row = place.x + before >= reach.x" => "let row = place.x + 1u >= reach.x + before";
        "mean along the other yarn" in "failure over a length":
            "vec2<u32>(u32(at), place.y), vec2<u32>(place.x, u32(at)), which == 0u" => "vec2<u32>(u32(at), place.y), vec2<u32>(place.x, u32(at)), which == 1u";
        "weft force of the finest" in "graded": "scene.membrane * width.yx" => "scene.membrane * vec2<f32>(width.y, 1.0)";
        "lines of the first sheet" in "graded plies of two fabrics": "(2u * plies[ply].ply_type + axis)" => "axis";
        "compression missing" in "variational, compressible": "scene.compression_a - scene.compression_b * q, 0.0" => "0.0, 0.0";
        "warm start not used" in "variational, compressible":
            "vec2<f32>(warm[PIVOT], warm[1u - PIVOT])" => "vec2<f32>(0.5 * top)";
        "curvature of the arc" in "variational, compressible":
            "(1.0 + excess) * inverse_secant * inverse_secant - b" => "(1.0 + excess) * inverse_secant - b";
        "energy of a linear yarn" in "yarns with curves":
            "select(0.0, scene.stiffness[which] * sum, 0.0 < tension)" => "tension * strain";
        "contact force halved" in "variational, compressible": "force = PI * s.arc.slope" => "force = HALF_PI * s.arc.slope";
        "sums of a row alone" in "variational, compressible": "i < INVOCATIONS; i += side()" => "i < side(); i += side()";
        "elements of the next tile left out" in "several workgroups of the energy balance": "corner_force(local - side(), 1.0, -1.0, 1.0)" => "select(vec3<f32>(0.0), corner_force(local - side(), 1.0, -1.0, 1.0), local >= 2u * side())";
        "slot of the last step written" in "variational, compressible": "nodes[node_word(slot_now(), 3u + a, node)] = after[a];" => "nodes[node_word(slot_before(), 3u + a, node)] = after[a];";
        "rows and columns of an edge" in "variational, compressible":
            "select(0u, sides, place.y == 0u)" => "select(0u, sides, place.x == 0u)";
        "no node of a frame held" in "a round window, graded": "in_frame(ply, SHARES, place) <= 0.0" => "false";
        "supports along the axes of the ply" in "thirty degrees, clamped, smooth": "let turned = to_pack(ply, impulse);" => "let turned = impulse;";
        "clay that throws back" in "against clay": "into * most / max(free, most)" => "most";
    }
    yarn_load {
        "strains of the step before" in "variational, compressible": "fn strain_slot() -> u32 { return slot_now(); }" => "fn strain_slot() -> u32 { return slot_before(); }";
        "rows of a yarn apart" in "failure over a length": "max(strain_of(element_at(ply, place_across(place, which, at)), which), 0.0)" => "max(strain_of(element_at(ply, place), which), 0.0)";
    }
    ply_search {
        "one element around a node not asked" in "two fabrics, holes, no hourglass":
            "let around = vec4<u32>(e, e - 1u, e - scene.columns - 1u, e - scene.columns);" => "let around = vec4<u32>(e, e - 1u, e - scene.columns - 1u, e);";
        "no ridges" in "ridges": "direction * dot(edge.arm, f.normal) > 0.0;" => "false;";
        "resting nodes not asked" in "resting plies": "return all(lies.xy >= low) && all(lies.xy <= high);" => "return false;";
        "velocity of a turned ply" in "thirty degrees, clamped, smooth":
            "return to_pack(ply, node_vector(3u, node));" => "return node_vector(3u, node);";
    }
    ply_impulse {
        "friction without its limit" in "two free plies": "let most = scene.ply_friction * normal;" => "let most = normal;";
        "corners pushed along" in "two free plies": "-part * each, -way" => "part * each, -way";
        "corners count in the largest unit" in "graded plies": "let each = 1 << (largest - theirs[i]);" => "let each = 1;";
    }
    ply_move {
        "shares stay" in "two free plies": "    shares[node] = 0u;\n" => "";
        "loss of the free velocity" in "two free plies":
            "0.5 * dot(impulse, before + now)" => "0.5 * dot(impulse, free + now)";
    }
    projectile_search {
        "cell of the node in every ply" in "sphere on turned plies, friction":
            "cell_over(ply, over[at])" => "cell_over(ply, over[node])";
        "rows do not spread" in "face of a cylinder exactly touching resting plies":
            "min(reach.y + 1u, p.rows + 1u)" => "min(reach.y, p.rows + 1u)";
        "nodes of the plies in front not counted" in "between nodes on turned plies, friction":
            "let before = atomicLoad(&in_front);" => "let before = 0u;";
        "ellipse as a circle" in "edges of a fragment": "let bend = squared(scene.chisel_slope);" => "let bend = 0.0;";
        "nodes of the ply in front in the same word" in "between nodes, wider than the plies are high":
            "word == first / 32u);" => "false);";
    }
    projectile_contact {
        "points of the rim of the first ply alone" in "between nodes on turned plies, friction":
            "cursor.ply += 1u;" => "break;";
        "nodes pull" in "sphere, spinning, oblique, friction":
            "state == PUSHING && touches[touch_number(t)].friction_impulse.w < 0.0" => "state == PUSHING && touches[touch_number(t)].friction_impulse.w < -1e30";
        "inertia off the diagonal" in "cylinder, yawed, friction":
            "more_x * side.y * side.x + more_z * axis.y * axis.x," => "0.0,";
        "position without its carry" in "sphere": "coarse + (moved >> vec3<u32>(24u))" => "coarse";
        "touches independent" in "between nodes, yawed, friction": "select(0.0, coupling(t, other), pushes)" => "0.0";
    }
    energy_balance {
        "largest deflections added" in "several workgroups of the energy balance": "which == DEFLECTION ||" => "";
        "tiles not counted anew" in "variational, compressible": "tiles[first + which] = 0.0;" => "";
        "absent elements do not cover" in "sphere in a round window": " && is_present(ply, cell)" => "";
    }
}
