//! Defects of `ledger`.

use super::super::Mutant;

const fn mutant(name: &'static str, scene: &'static str, find: &'static str, put: &'static str) -> Mutant {
    Mutant { name, kernel: "energy_balance", scene, find, put }
}

pub(super) const MUTANTS: &[Mutant] = &[
    mutant("edge nodes too heavy", "Variational, compressible", "0.25, count == 2u", "0.5, count == 2u"),
    mutant(
        "every sample in the first slot",
        "Variational, compressible",
        "let first = (step.slot * groups.z + group.z) * (",
        "let first = 0u * (",
    ),
    mutant("evaluations not counted anew", "Variational, compressible", "flags[element] = word & 3u;", ""),
    mutant("work not counted anew", "Variational, compressible", "    accounts[element] = 0.0;\n", ""),
    mutant("supports not counted anew", "Variational, compressible", "supports[at] = 0.0;", ""),
    mutant("largest tensions added", "Variational, compressible", "local == TENSION ||", ""),
    mutant("steps since the last ledger", "Variational, compressible", "f32(step.since)", "1.0"),
    mutant(
        "kinetic energy of the new velocity",
        "Variational, compressible",
        "dot(v, v - scene.dt * gather(node, place) * inverse_mass(ply, place))",
        "square",
    ),
    mutant(
        "momentum along the wrong axis",
        "Variational, compressible",
        "part[MOMENTUM + 1u] += momentum.y;",
        "part[MOMENTUM + 1u] += momentum.x;",
    ),
    mutant(
        "one workgroup adds alone",
        "several workgroups of the ledger",
        "i += stride) {\n        let element",
        "i += 1000000u) {\n        let element",
    ),
    mutant(
        "cut yarns cover",
        "cylinder in front of a hole",
        "if ((flags[element_at(ply, cell)] & yarn) == 0u) {",
        "if (false) {",
    ),
    mutant("flaps cut further on cover", "cylinder behind a faster flap", "at < pieces.y; at++", "at <= along; at++"),
    mutant("flaps cut before cover", "cylinder behind a faster flap", "var at = pieces.x;", "var at = along;"),
    mutant(
        "yarns run on for a cell only",
        "cylinder behind a faster flap",
        "min(along + span + 1u, count)",
        "min(along + 2u, count)",
    ),
    mutant("wefts do not cover", "sphere under a weft", "runs_on(ply, place, 2u)", "false"),
    mutant("warps do not cover", "sphere", "runs_on(ply, place, 1u)", "false"),
    mutant(
        "yarns along the other direction",
        "sphere under a weft",
        "let cell = select(vec2<u32>(at, place.y), vec2<u32>(place.x, at), warp);",
        "let cell = vec2<u32>(place.x, at);",
    ),
    mutant("flats not part of the nose", "fragment in front of a slit", "local.z + recess(local)", "local.z"),
    mutant("everything behind the nose", "sphere", "scene.body_shoulder < local.z", "local.z < -1.0"),
    mutant(
        "losses not counted anew",
        "cone, oblique, friction",
        "bodies[shot.number].energy = vec4<f32>(0.0, 0.0, 0.0, body.energy.w);",
        "",
    ),
    mutant("depth forgotten", "sphere", "vec4<f32>(0.0, 0.0, 0.0, body.energy.w)", "vec4<f32>(0.0)"),
    mutant("losses of plies not counted", "two free plies", "part[PLY_LOSS] += accounts[at];", ""),
    mutant(
        "rubbing of plies not counted",
        "two free plies",
        "part[PLY_FRICTION_WORK] += accounts[at + n];",
        "part[PLY_FRICTION_WORK] += accounts[at];",
    ),
    mutant(
        "work of separation not counted",
        "two free plies",
        "part[PLY_SEPARATION_WORK] += accounts[at + 2u * n];",
        "",
    ),
    mutant("losses of plies not counted anew", "two free plies", "        accounts[at] = 0.0;\n", ""),
    mutant("work of plies not counted anew", "two free plies", "        accounts[at + 2u * n] = 0.0;\n", ""),
    mutant(
        "momentum of a turned ply",
        "thirty degrees, clamped, smooth",
        "let momentum = mass * to_pack(ply, v);",
        "let momentum = mass * v;",
    ),
    mutant(
        "elements of every ply in the first",
        "plies of two fabrics",
        "let element = ply_number(ply) * ply_elements + i;",
        "let element = i;",
    ),
    mutant(
        "nodes of every ply in the first",
        "two fabrics, holes, no hourglass",
        "let node = ply_number(ply) * ply_nodes + i;",
        "let node = i;",
    ),
    mutant(
        "supports of every ply in the first",
        "thirty degrees, clamped, smooth",
        "add_support(3u * (ply_number(ply) * rim + i));",
        "add_support(3u * i);",
    ),
    mutant(
        "mass of the first fabric",
        "two fabrics, holes, no hourglass",
        "return plies[ply].mass *",
        "return plies[0].mass *",
    ),
    mutant(
        "a turned ply ahead",
        "cone in front of a torn turned ply",
        "let lies = to_pack(ply, reference(ply, node_place(node)));",
        "let lies = reference(ply, node_place(node));",
    ),
    mutant("nothing is near enough", "sphere", "a)) >= far", "a)) >= 0.0"),
    mutant(
        "masses of the finest",
        "graded",
        "return plies[ply].mass * mass_share(ply, place);",
        "return plies[ply].mass;",
    ),
    mutant(
        "elements before it count alike",
        "graded yarns cut close and far away",
        "left -= line_at(ply, axis, first).width)",
        "left -= 1.0)",
    ),
    mutant(
        "elements behind it count alike",
        "graded yarns cut close and far away",
        "left -= line_at(ply, axis, end - 1u).width)",
        "left -= 1.0)",
    ),
    mutant("no elements before it", "graded yarns cut close and far away", "left > WITHIN && first > 0u;", "false;"),
    mutant("no elements behind it", "graded yarns cut close and far away", "left > WITHIN && end < count;", "false;"),
    mutant(
        "lines of the other axis",
        "graded yarns cut close and far away",
        "within(ply, select(1u, 0u, warp), along)",
        "within(ply, select(0u, 1u, warp), along)",
    ),
    mutant(
        "finest elements are near enough",
        "coarse row beside the middle",
        "    let size = cell_size(ply, place);\n    let far",
        "    let size = vec2<f32>(plies[ply].length_x, plies[ply].length_y);\n    let far",
    ),
];
