//! Defects of `ply_search`.

use super::super::Mutant;

const fn mutant(name: &'static str, scene: &'static str, find: &'static str, put: &'static str) -> Mutant {
    Mutant { name, kernel: "ply_search", scene, find, put }
}

pub(super) const MUTANTS: &[Mutant] = &[
    mutant(
        "more of a penetration driven out",
        "two free plies",
        "const RECOVERY: f32 = 0.2;",
        "const RECOVERY: f32 = 0.3;",
    ),
    mutant("more of a penetration let be", "two free plies", "const SLOP: f32 = 1e-4;", "const SLOP: f32 = 1e-2;"),
    mutant("no walk", "two free plies", "const WALK: u32 = 4u;", "const WALK: u32 = 0u;"),
    mutant("shorter walk", "two free plies", "const WALK: u32 = 4u;", "const WALK: u32 = 1u;"),
    mutant(
        "nodes that have passed come back",
        "two free plies",
        "const PASSED: f32 = 2.0;",
        "const PASSED: f32 = 20.0;",
    ),
    mutant("folded cells are surfaces", "folded cells", "const FOLDED: f32 = 0.05;", "const FOLDED: f32 = 0.0;"),
    mutant("twist of the cell", "two free plies", "arm - twist * (first.x * first.y)", "arm"),
    mutant("shear of the cell along", "two free plies", "cc * q.x - ac * q.y", "cc * q.x"),
    mutant("shear of the cell across", "two free plies", "aa * q.y - ac * q.x", "aa * q.y"),
    mutant(
        "corners of the cell exchanged",
        "two free plies",
        "(0.5 + x) * (0.5 + y), (0.5 - x) * (0.5 + y)",
        "(0.5 - x) * (0.5 + y), (0.5 + x) * (0.5 + y)",
    ),
    mutant("no way back", "two free plies", "x < -0.5 - EDGE", "x < -50.0"),
    mutant(
        "rows for columns in a walk",
        "two free plies",
        "step_over(cell.x, foot.place.y, o.rows)",
        "step_over(cell.x, foot.place.x, o.rows)",
    ),
    mutant(
        "beyond the edge of the ply",
        "two free plies",
        "return abs(place.x) <= 0.5 + EDGE && abs(place.y) <= 0.5 + EDGE;",
        "return true;",
    ),
    mutant("gap not left open", "two free plies", "return -max(gap, 0.0) / scene.dt;", "return 0.0 * gap;"),
    mutant("own way not counted", "two free plies", "- max(along, 0.0), 0.0)", ", 0.0)"),
    mutant("ply behind forgotten", "two free plies", "ply + 1u < scene.plies", "ply + 2u < scene.plies"),
    mutant("one side alone", "two free plies", "side < 2u", "side < 1u"),
    mutant(
        "resting nodes not asked",
        "resting plies",
        "return all(lies.xy >= low) && all(lies.xy <= high);",
        "return false;",
    ),
    mutant(
        "rest seen unturned",
        "resting plies, a corner",
        "let lies = to_ply(other, to_pack(own, reference(own, place)));",
        "let lies = reference(own, place);",
    ),
    mutant(
        "rows for columns of the rest",
        "resting plies, a corner",
        "o.length_x * f32(reach.w)",
        "o.length_x * f32(reach.y)",
    ),
    mutant(
        "no room around the rest",
        "resting plies, a corner",
        "let slack = step.travel + 3.0 * longest;",
        "let slack = 0.0;",
    ),
    mutant("moving nodes over rest not asked", "resting plies", "(moving || sees(", "(sees("),
    mutant(
        "ring around the reach not asked",
        "resting plies",
        "let row = place.x + 1u >= reach.x && place.x <= reach.y;",
        "let row = place.x >= reach.x && place.x < reach.y;",
    ),
    mutant(
        "closer plies touch as others",
        "quarter turns, rollers",
        "direction * foot.height - front.touching",
        "direction * foot.height - front.thickness",
    ),
    mutant(
        "distance of the next pair",
        "two fabrics, holes, no hourglass",
        "let front = plies[min(ply, other)];",
        "let front = plies[ply];",
    ),
    mutant(
        "pushed to the wrong side",
        "two free plies",
        "let push = foot.normal * direction;",
        "let push = foot.normal;",
    ),
    mutant(
        "height from the wrong side",
        "two free plies",
        "let direction = select(-1.0, 1.0, side == 0u);",
        "let direction = 1.0;",
    ),
    mutant(
        "holes touch",
        "two fabrics, holes, no hourglass",
        "if ((flags[element] & 3u) == 0u || !stands(node, place)) {",
        "if (!stands(node, place)) {",
    ),
    mutant("debris touches", "two fabrics, holes, no hourglass", "|| !stands(node, place)) {", ") {"),
    mutant(
        "one element around a node not asked",
        "two fabrics, holes, no hourglass",
        "if (there.w) { bits |= flags[e - scene.columns]; }",
        "",
    ),
    mutant("gap after the step", "two free plies", "let gap = end - along * scene.dt;", "let gap = end;"),
    mutant("depth not noted", "two free plies", "atomicMax(&status[PLY_DEPTH], depth);", ""),
    mutant(
        "depth driven out only while closing",
        "two free plies",
        "if (!(along < limit || recovery > 0.0)) {",
        "if (!(along < limit)) {",
    ),
    mutant("limit forgotten", "two free plies", "vec4<f32>(push, limit)", "vec4<f32>(push, 0.0)"),
    mutant(
        "speed of recovery forgotten",
        "two free plies",
        "vec4<f32>(foot.place, recovery, 1.0)",
        "vec4<f32>(foot.place, 0.0, 1.0)",
    ),
    mutant(
        "velocity of the surface missing",
        "two free plies",
        "velocity -= ply_velocity(other, around[i]) * weights[i];",
        "",
    ),
    mutant("own share not counted", "two free plies", "atomicAdd(&shares[node], u32(SHARE_UNIT));", ""),
    mutant("shares of the corners not counted", "two free plies", "atomicAdd(&shares[around[i]], share);", ""),
    mutant("old contacts stay", "two free plies", "            contacts[at].foot.w = 0.0;", ""),
    mutant("cell not remembered", "two free plies", "    over[at] = cell.x * o.columns + cell.y;\n", ""),
    mutant(
        "columns of the node's own ply",
        "two fabrics, holes, no hourglass",
        "over[at] / o.columns, over[at] % o.columns",
        "over[at] / plies[ply].columns, over[at] % plies[ply].columns",
    ),
    mutant(
        "plies turned the wrong way",
        "thirty degrees, clamped, smooth",
        "c * v.x - s * v.y, s * v.x + c * v.y",
        "c * v.x + s * v.y, c * v.y - s * v.x",
    ),
    mutant(
        "all plies in one plane",
        "two free plies",
        "return vec3<f32>(x, y, plies[ply].z);",
        "return vec3<f32>(x, y, 0.0);",
    ),
    mutant(
        "velocity of a turned ply",
        "thirty degrees, clamped, smooth",
        "return to_pack(ply, ply_vector(3u, node));",
        "return ply_vector(3u, node);",
    ),
];
