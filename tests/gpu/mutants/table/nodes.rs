//! Defects of `node_update`.

use super::super::Mutant;

const fn mutant(name: &'static str, scene: &'static str, find: &'static str, put: &'static str) -> Mutant {
    Mutant { name, kernel: "node_update", scene, find, put }
}

pub(super) const MUTANTS: &[Mutant] = &[
    mutant(
        "hourglass of the wrong corner",
        "Variational, compressible",
        "corner_force(e, there.x, 1.0, 1.0, -1.0)",
        "corner_force(e, there.x, 1.0, 1.0, 1.0)",
    ),
    mutant(
        "warp and weft exchanged in a corner",
        "Variational, compressible",
        "there.w, 1.0, -1.0, 1.0)",
        "there.w, -1.0, 1.0, 1.0)",
    ),
    mutant("wrong element in a corner", "Variational, compressible", "corner_force(e - 1u,", "corner_force(e,"),
    mutant(
        "elements of the first ply",
        "Variational, compressible",
        "(ply_number(ply) * scene.rows + place.x)",
        "(place.x)",
    ),
    mutant(
        "element beyond the edge",
        "Variational, compressible",
        "let left = place.y > 0u;",
        "let left = place.y > 1u;",
    ),
    mutant(
        "whole kick at the first step",
        "Variational, rigid",
        "step.kick * force * inverse",
        "scene.dt * force * inverse",
    ),
    mutant("half a drift at the first step", "Variational, rigid", "u + scene.dt * v", "u + step.kick * v"),
    mutant(
        "rows and columns of an edge",
        "Variational, compressible",
        "select(0u, sides, place.y == 0u)",
        "select(0u, sides, place.x == 0u)",
    ),
    mutant("roller holds the other way", "Variational, compressible", "vec3<u32>(1u, 2u, 4u)", "vec3<u32>(2u, 1u, 4u)"),
    mutant(
        "corner as light as an edge",
        "Variational, compressible",
        "inverse_corner, count == 2u",
        "inverse_corner, count == 3u",
    ),
    mutant(
        "two sides of the rim in one",
        "Variational, rigid",
        "return first + across + place.y;",
        "return first + place.y;",
    ),
    mutant(
        "supports push instead of pull",
        "Variational, compressible",
        "-step.kick * force, inverse",
        "step.kick * force, inverse",
    ),
    mutant(
        "nodes ahead not marked",
        "rough cylinder on two fabrics",
        "var room = 1.01 * scene.dt * (speed + 1.1 * body.velocity.w)",
        "var room = 0.0 * scene.dt * (speed + 1.1 * body.velocity.w)",
    ),
    mutant(
        "far words of marks lost",
        "sphere",
        "mark_words().x + (word >> 5u))], 1u << (word & 31u)",
        "mark_words().x)], 1u << (word & 31u)",
    ),
    mutant("bit off by one", "sphere", "1u << (number & 31u)", "1u << ((number + 1u) & 31u)"),
    mutant(
        "body frame turned the wrong way",
        "cylinder, yawed, friction",
        "rotate_back(body.orientation, arm_of(",
        "rotate(body.orientation, arm_of(",
    ),
    mutant(
        "ring around the reach not moved",
        "resting plies",
        "let row = place.x + 1u >= reach.x && place.x <= reach.y;",
        "let row = place.x >= reach.x && place.x < reach.y;",
    ),
    mutant(
        "ring beside the reach not moved",
        "resting plies",
        "let column = place.y + 1u >= reach.z && place.y <= reach.w;",
        "let column = place.y >= reach.z && place.y < reach.w;",
    ),
    mutant(
        "supports in the axes of the ply",
        "thirty degrees, clamped, smooth",
        "let turned = to_pack(ply, impulse);",
        "let turned = impulse;",
    ),
    mutant(
        "resting plies behind not marked",
        "face of a cylinder exactly touching resting plies",
        "mark(node, in_pack, vec3<f32>(0.0), 0.0, plies[ply].depth);",
        "mark(node, in_pack, vec3<f32>(0.0), 0.0, 0.0);",
    ),
    mutant(
        "moving plies behind not marked",
        "sphere on turned plies, friction",
        "sqrt(square), plies[ply].depth);",
        "sqrt(square), 0.0);",
    ),
    mutant(
        "place behind the fabric alone",
        "sphere on turned plies, friction",
        "max(min(local.z, pressed.z),",
        "max(local.z,",
    ),
    mutant(
        "reference of a turned ply",
        "cone on held plies with gaps",
        "let in_pack = to_pack(ply, lies);",
        "let in_pack = lies;",
    ),
    mutant(
        "mass of the first fabric",
        "two fabrics, holes, no hourglass",
        "plies[ply].inverse_inner, plies[ply].inverse_edge, count == 1u",
        "plies[0].inverse_inner, plies[0].inverse_edge, count == 1u",
    ),
    mutant(
        "masses of the finest",
        "graded",
        "inverse = plies[ply].inverse_inner / mass_share(ply, place);",
        "inverse = plies[ply].inverse_inner;",
    ),
    mutant("masses of a row", "graded", "line_at(ply, 0u, place.y).share * line_at", "line_at"),
    mutant("masses of a column", "graded", " * line_at(ply, 1u, place.x).share", ""),
    mutant(
        "columns where the finest would be",
        "cylinder beside the middle of a graded ply, friction",
        "        x = line_at(ply, 0u, place.y).place;\n",
        "",
    ),
    mutant(
        "rows where the finest would be",
        "cylinder beside the middle of a graded ply, friction",
        "        y = line_at(ply, 1u, place.x).place;\n",
        "",
    ),
];
