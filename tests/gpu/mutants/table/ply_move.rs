//! Defects of `ply_move`.

use super::super::Mutant;

const fn mutant(name: &'static str, scene: &'static str, find: &'static str, put: &'static str) -> Mutant {
    Mutant { name, kernel: "ply_move", scene, find, put }
}

pub(super) const MUTANTS: &[Mutant] = &[
    mutant("shares stay", "two free plies", "    shares[node] = 0u;\n", ""),
    mutant("impulses stay", "two free plies", "    impulses[at + 1u] = 0;\n", ""),
    mutant("touched nodes not taken in", "resting plies", "    touch(ply, place);\n", ""),
    mutant(
        "last row touched not taken in",
        "resting plies",
        "atomicMax(&status[at + 1u], place.x + 1u);",
        "atomicMax(&status[at + 1u], place.x);",
    ),
    mutant(
        "last column touched not taken in",
        "resting plies",
        "atomicMax(&status[at + 3u], place.y + 1u);",
        "atomicMax(&status[at + 3u], place.y);",
    ),
    mutant("first row touched not taken in", "resting plies, a corner", "atomicMin(&status[at], place.x);", ""),
    mutant("first column touched not taken in", "resting plies, a corner", "atomicMin(&status[at + 2u], place.y);", ""),
    mutant(
        "impulses of a turned ply",
        "thirty degrees, clamped, smooth",
        "return to_ply(ply, count * unit);",
        "return count * unit;",
    ),
    mutant(
        "whole kick in the loss of the first step",
        "the first step",
        "let pull = step.kick *",
        "let pull = scene.dt *",
    ),
    mutant(
        "held nodes move",
        "thirty degrees, clamped, smooth",
        "let change = inverse * impulse;",
        "let change = plies[ply].inverse_inner * impulse;",
    ),
    mutant("impulses do not move", "two free plies", "u + (scene.dt * change + way)", "u + way"),
    mutant("nodes not moved out", "two free plies", "u + (scene.dt * change + way)", "u + scene.dt * change"),
    mutant(
        "way kept as velocity",
        "two free plies",
        "let now = free + change;",
        "let now = free + change + inverse * shift;",
    ),
    mutant(
        "loss of the free velocity",
        "two free plies",
        "0.5 * dot(impulse, (free - pull) + now)",
        "0.5 * dot(impulse, free + now)",
    ),
    mutant("loss not added up", "two free plies", "accounts[at] -= 0.5 *", "accounts[at] = -0.5 *"),
    mutant(
        "work of separation not noted",
        "two free plies",
        "accounts[at + 2u * n] -= dot(force - viscous_force(node, place), way);",
        "",
    ),
    mutant("viscosity stores", "graded plies", "force - viscous_force(node, place)", "force"),
    mutant(
        "viscous forces exchanged",
        "graded plies",
        "yarns[yarn * scene.elements + element]",
        "yarns[(1u - yarn) * scene.elements + element]",
    ),
    mutant(
        "viscous forces of finest elements",
        "graded plies",
        "let size = geometry_of(element);",
        "let size = geometry_of(0u);",
    ),
    mutant("viscous forces of the wrong corner", "graded plies", "return above - below;", "return above + below;"),
    mutant(
        "supports push instead of pull",
        "thirty degrees, clamped, smooth",
        "-select(vec3<f32>(0.0), impulse, inverse <= vec3<f32>(0.0))",
        "select(vec3<f32>(0.0), impulse, inverse <= vec3<f32>(0.0))",
    ),
    mutant(
        "supports in the axes of the ply",
        "thirty degrees, clamped, smooth",
        "let turned = to_pack(ply, impulse);",
        "let turned = impulse;",
    ),
    mutant(
        "own unit forgotten",
        "graded plies",
        "shot.impulse_unit * f32(1u << count_shift(ply, place))",
        "shot.impulse_unit",
    ),
    mutant(
        "masses of the finest",
        "graded plies",
        "inverse = plies[ply].inverse_inner / mass_share(ply, place);",
        "inverse = plies[ply].inverse_inner;",
    ),
];
