//! Defects of `projectile_points` and `projectile_contact` where the rim of the face is sampled.

use super::super::Mutant;

const fn of_points(name: &'static str, scene: &'static str, find: &'static str, put: &'static str) -> Mutant {
    Mutant { name, kernel: "projectile_points", scene, find, put }
}

const fn of_contact(name: &'static str, scene: &'static str, find: &'static str, put: &'static str) -> Mutant {
    Mutant { name, kernel: "projectile_contact", scene, find, put }
}

pub(super) const MUTANTS: &[Mutant] = &[
    of_points(
        "crossings of one side",
        "between nodes, rounded, and behind the rim",
        "select(crossings.x, crossings.y, (slot & 1u) != 0u)",
        "crossings.x",
    ),
    of_points(
        "height of the first node",
        "between nodes, yawed, friction",
        "mix(points[point_number(p)].pressed.z, points[point_number(q)].pressed.z, at)",
        "points[point_number(p)].pressed.z",
    ),
    of_points(
        "face without its rounding",
        "between nodes, rounded, and behind the rim",
        "(scene.profile[1].y + scene.profile_radius)",
        "scene.profile[1].y",
    ),
    of_points(
        "debris between nodes touches",
        "between nodes beside a slit",
        "!is_node(ply, next) || !edge_is_intact(node, place, up)",
        "!is_node(ply, next)",
    ),
    of_points(
        "element beside an edge not asked",
        "between nodes beside a slit",
        "if (!up && there.w) { bits |= flags[e - scene.columns]; }",
        "",
    ),
    of_points(
        "edges where no yarn is",
        "between nodes where no weft is left",
        "(bits & select(1u, 2u, up)) != 0u",
        "(bits & 3u) != 0u",
    ),
    of_points(
        "edges along the other yarn",
        "between nodes where no weft is left",
        "select(1u, 2u, up)",
        "select(2u, 1u, up)",
    ),
    of_points(
        "edge from the left not known",
        "between nodes, yawed, friction",
        "points[point_number(left)].to_right > 0u",
        "false",
    ),
    of_contact(
        "touches independent",
        "between nodes, yawed, friction",
        "select(0.0, coupling(t, other), pushes)",
        "0.0",
    ),
    of_contact(
        "weights of the other end",
        "between nodes, yawed, friction",
        "select(second, 1.0 - second, edge == 0u)",
        "second",
    ),
    of_contact(
        "no mass between held nodes",
        "between nodes of a clamped corner",
        "select(unheld, most, most > 0.0)",
        "most",
    ),
    of_contact(
        "one triangle for all plies",
        "between nodes on turned plies, friction",
        "ply_number(ply) * (most * (most + 1u) / 2u) + row",
        "row",
    ),
    of_points(
        "blocks end at edges along a row",
        "between nodes on turned plies, friction",
        "if (left != NONE) { first = min(first, points[point_number(left)].block); }",
        "",
    ),
    of_points(
        "blocks end at edges along a column",
        "between nodes, yawed, friction",
        "if (below != NONE) { first = min(first, points[point_number(below)].block); }",
        "",
    ),
    of_contact("entries left of the last not known", "between nodes on graded plies, friction", "min(entry, m)", "m"),
    of_contact(
        "members that were let go stay",
        "between nodes, yawed, friction",
        "same = false;\n            change++;",
        "change++;",
    ),
    of_contact("friction asks nothing new", "between nodes, yawed, friction", "ask(t);", "if (!same) { ask(t); }"),
    of_contact(
        "no way back through a block",
        "between nodes, yawed, friction",
        "substitute_back(m, end_of(m, count));",
        "",
    ),
    Mutant {
        name: "edges around the rim not marked",
        kernel: "node_update",
        scene: "between nodes, yawed, friction",
        find: "room += scene.rim_depth;",
        put: "room -= scene.rim_depth;",
    },
];
