//! Defects of `projectile_points` and `projectile_contact` beyond the shape of the body and the rim of its face.

use super::super::Mutant;

const fn of_points(name: &'static str, scene: &'static str, find: &'static str, put: &'static str) -> Mutant {
    Mutant { name, kernel: "projectile_points", scene, find, put }
}

const fn of_contact(name: &'static str, scene: &'static str, find: &'static str, put: &'static str) -> Mutant {
    Mutant { name, kernel: "projectile_contact", scene, find, put }
}

pub(super) const MUTANTS: &[Mutant] = &[
    of_points(
        "word of marks left out",
        "sphere",
        "countOneBits(atomicLoad(&candidates[mark_word(summary * 32u + firstTrailingBit(rest))]))",
        "1u",
    ),
    of_points("debris touches", "sphere", "return (bits & 3u) != 0u;", "return true;"),
    of_points(
        "one element around a node not asked",
        "sphere",
        "if (there.w) { bits |= flags[e - scene.columns]; }",
        "",
    ),
    of_points("gap after the step", "sphere", "displacement_of(node) - scene.dt * own);", "displacement_of(node));"),
    of_contact("gap not left open", "sphere", "return -max(gap, 0.0) / scene.dt;", "return 0.0 * gap;"),
    of_contact(
        "held direction pushes as a free one",
        "bar along warp, clamped ends",
        "1.0 / max(along, 1.0 / (HELD * max(scene.body_mass, mass)))",
        "mass",
    ),
    // What is left of the body's speed differs by 1/584 − 1/1001, twice what is allowed at held nodes.
    of_contact(
        "lighter held nodes",
        "free sphere at a clamped edge",
        "const HELD: f32 = 1e3;",
        "const HELD: f32 = 583.0;",
    ),
    of_points(
        "body material does not turn",
        "sphere, spinning, oblique, friction",
        "- cross(body.turning.xyz, arm);",
        ";",
    ),
    of_contact(
        "friction turns the body the wrong way",
        "sphere, spinning, oblique, friction",
        "part[24] -= turn.x;",
        "part[24] += turn.x;",
    ),
    of_contact(
        "inertia off the diagonal",
        "cylinder, yawed, friction",
        "more_x * side.y * side.x + more_z * axis.y * axis.x,",
        "0.0,",
    ),
    of_contact(
        "two moments of inertia in contact",
        "edges of a fragment",
        "let more_x = (scene.body_inertia_x - scene.body_inertia_y) * scale;",
        "let more_x = 0.0;",
    ),
    of_contact(
        "two moments of inertia in flight",
        "edges of a fragment",
        "local / vec3<f32>(scene.body_inertia_x, scene.body_inertia_y,",
        "local / vec3<f32>(scene.body_inertia_y, scene.body_inertia_y,",
    ),
    of_contact(
        "nodes pull",
        "sphere, spinning, oblique, friction",
        "state == PUSHING && touches[touch_number(t)].friction_impulse.w < 0.0",
        "state == PUSHING && touches[touch_number(t)].friction_impulse.w < -1e30",
    ),
    of_contact(
        "released nodes are dragged",
        "edges of a fragment",
        "            touches[touch_number(t)].friction_impulse = vec4<f32>(0.0);\n",
        "",
    ),
    of_contact("no node joins", "light cylinder, one side of the face", "change < SET_CHANGES / 2u", "change < 0u"),
    of_contact("no friction", "cone, oblique, friction", "if (!FRICTION ||", "if (true ||"),
    of_contact(
        "friction that throws a light body",
        "light cylinder, one side of the face",
        "touches[touch_number(t)].arm.w * share)",
        "touches[touch_number(t)].arm.w)",
    ),
    of_contact(
        "friction that turns a light body too far",
        "light cylinder, one side of the face",
        "select(0.0, turned, ROTATION)",
        "0.0",
    ),
    of_contact(
        "friction without its limit",
        "cone, oblique, friction",
        "let limit = touches[touch_number(t)].friction * old.w;",
        "let limit = old.w;",
    ),
    of_contact("sliding along the normal", "cone, oblique, friction", "slip - normal * dot(slip, normal)", "slip"),
    of_contact(
        "fabric force not in the loss",
        "sphere, spinning, oblique, friction",
        "inverse * force * step.kick",
        "inverse * force * 0.0",
    ),
    of_contact(
        "supports of held nodes forgotten",
        "bar along warp, clamped ends",
        "select(vec3<f32>(0.0), -impulse, fixed)",
        "vec3<f32>(0.0)",
    ),
    of_contact(
        "work of the drive forgotten",
        "bar along weft, driven, rough",
        "dot(impulse, surface), prescribed",
        "0.0, prescribed",
    ),
    of_contact(
        "driven body pushed",
        "bar along weft, driven, rough",
        "if (scene.body_prescribed == 0u) {\n            b.change",
        "if (true) {\n            b.change",
    ),
    of_contact("nodes not moved", "sphere", "nodes[a * n + node] += scene.dt * change[a];", ""),
    of_contact(
        "spin without contact",
        "sphere, spinning, oblique, friction",
        "b.angular_momentum += vec4<f32>(about_planes(vec3<f32>(result[3], result[4], result[5])), 0.0);",
        "",
    ),
    of_contact(
        "half a turn",
        "cylinder, yawed, friction",
        "turned(q, scene.dt * inverse.y * b.angular_momentum.xyz)",
        "turned(q, 0.5 * scene.dt * inverse.y * b.angular_momentum.xyz)",
    ),
    of_contact(
        "no spin about the axis",
        "sphere, spinning, oblique, friction",
        "spun(q, b.angular_momentum.xyz, vec3<f32>(0.0, 0.0, 1.0), scene.dt * (inverse.z - inverse.y))",
        "spun(q, b.angular_momentum.xyz, vec3<f32>(0.0, 0.0, 1.0), scene.dt * inverse.z)",
    ),
    of_contact(
        "inertia of the axis across",
        "cylinder, yawed, friction",
        "local / vec3<f32>(scene.body_inertia_x, scene.body_inertia_y, scene.body_inertia_z)",
        "local / vec3<f32>(scene.body_inertia_z, scene.body_inertia_z, scene.body_inertia_x)",
    ),
    of_contact("position without its carry", "sphere", "coarse + (moved >> vec3<u32>(24u))", "coarse"),
    of_contact("velocity before the step", "sphere", "b.change_before = b.change;", ""),
    of_points("depth not noted", "sphere", "seen.depth = max(0.0, -g.distance);", "seen.depth = 0.0;"),
    of_points("marks not cleared", "sphere", "atomicStore(&candidates[mark_word(word)], 0u);", ""),
    of_points(
        "fabric in front missing",
        "sphere on turned plies, friction",
        "from_nose - vec3<f32>(0.0, 0.0, seen.between)",
        "from_nose",
    ),
    of_points(
        "holes as thick as fabric",
        "sphere on turned plies, friction",
        "select(0.0, plies[ply].touching, (flags[element] & 3u) != 0u)",
        "plies[ply].touching",
    ),
    of_points(
        "closer plies as thick as others",
        "rough cylinder on two fabrics",
        "select(0.0, plies[ply].touching,",
        "select(0.0, plies[ply].thickness,",
    ),
    of_points(
        "cell of the node in every ply",
        "sphere on turned plies, friction",
        "cell_over(ply, over[at])",
        "cell_over(ply, over[node])",
    ),
    of_points(
        "first corner of the cell",
        "sphere on turned plies, friction",
        "at = node_at(ply, place + further);",
        "at = node_at(ply, place);",
    ),
    of_points(
        "way through turned plies",
        "sphere on turned plies, friction",
        "let lies = to_ply(ply, to_pack(front, reference(front, node_place(at))));",
        "let lies = reference(front, node_place(at));",
    ),
    of_points(
        "columns of the first mesh",
        "rough cylinder on two fabrics",
        "element / plies[ply].columns, element % plies[ply].columns",
        "element / scene.columns, element % scene.columns",
    ),
    of_points(
        "friction of covered plies",
        "sphere on turned plies, friction",
        "min(scene.friction, scene.ply_friction), between > 0.0",
        "scene.friction, between > 0.0",
    ),
    of_points(
        "friction of plies everywhere",
        "sphere on turned plies, friction",
        "scene.ply_friction), between > 0.0",
        "scene.ply_friction), true",
    ),
    of_points(
        "velocity of a turned ply",
        "sphere on turned plies, friction",
        "let free = to_pack(ply, own);",
        "let free = own;",
    ),
    of_points("rollers of a turned ply", "cone on held plies with gaps", "abs(plies[ply].sine) > 0.5 &&", "false &&"),
    of_contact(
        "impulses of a turned ply",
        "sphere on turned plies, friction",
        "let change = to_ply(ply, inverse * impulse);",
        "let change = inverse * impulse;",
    ),
    of_contact(
        "forces of a turned ply",
        "sphere on turned plies, friction",
        "let force = to_pack(ply, gather(node, place));",
        "let force = gather(node, place);",
    ),
    of_contact(
        "touched nodes not taken in",
        "face of a cylinder exactly touching resting plies",
        "        touch(ply, place);\n",
        "",
    ),
    of_points(
        "rows do not spread",
        "face of a cylinder exactly touching resting plies",
        "min(reach.y + 1u, plies[local].rows + 1u)",
        "min(reach.y, plies[local].rows + 1u)",
    ),
    of_points(
        "columns do not spread back",
        "face of a cylinder exactly touching resting plies",
        "atomicStore(&status[at + 2u], max(reach.z, 1u) - 1u);",
        "",
    ),
    of_points(
        "first step counted as others",
        "face of a cylinder exactly touching resting plies",
        "p.rows * p.columns, all);",
        "p.rows * p.columns, false);",
    ),
    of_points(
        "elements before the reach not counted",
        "face of a cylinder exactly touching resting plies",
        "min(reach.y, p.rows) - (max(reach.x, 1u) - 1u)",
        "min(reach.y, p.rows) - reach.x",
    ),
    of_points(
        "elements not counted",
        "face of a cylinder exactly touching resting plies",
        "let before = atomicAdd(&status[counter(COMPUTED)], count);",
        "let before = 0u;",
    ),
    of_points(
        "columns where the finest would be",
        "cylinder beside the middle of a graded ply, friction",
        "        x = line_at(ply, 0u, place.y).place;\n",
        "",
    ),
    of_points(
        "rows where the finest would be",
        "cylinder beside the middle of a graded ply, friction",
        "        y = line_at(ply, 1u, place.x).place;\n",
        "",
    ),
    of_points(
        "friction meets the finest",
        "sphere on graded plies, friction",
        "return plies[ply].mass * mass_share(ply, place);",
        "return plies[ply].mass;",
    ),
    of_points(
        "contact meets the finest",
        "cylinder beside the middle of a graded ply, friction",
        "inverse = plies[ply].inverse_inner / mass_share(ply, place);",
        "inverse = plies[ply].inverse_inner;",
    ),
    of_points(
        "next node by the finest column",
        "sphere on graded plies, friction",
        "lies.x - corner.x > 0.5 * size.x",
        "lies.x - corner.x > 0.5 * plies[ply].length_x",
    ),
    of_points(
        "next node by the finest row",
        "sphere on graded plies, friction",
        "lies.y - corner.y > 0.5 * size.y",
        "lies.y - corner.y > 0.5 * plies[ply].length_y",
    ),
];
