//! Defects of `ply_impulse`.

use super::super::Mutant;

const fn mutant(name: &'static str, scene: &'static str, find: &'static str, put: &'static str) -> Mutant {
    Mutant { name, kernel: "ply_impulse", scene, find, put }
}

pub(super) const MUTANTS: &[Mutant] = &[
    mutant(
        "light touch of a corner",
        "two free plies",
        "max(f32(shares[node]) * (1.0 / SHARE_UNIT), 1.0)",
        "f32(shares[node]) * (1.0 / SHARE_UNIT)",
    ),
    mutant("mass not shared out", "two free plies", "max(f32(shares[node]) * (1.0 / SHARE_UNIT), 1.0)", "1.0"),
    mutant(
        "rollers give way everywhere",
        "quarter turns, rollers",
        "let mixed = dot(own * own, inverse);",
        "let mixed = max(inverse.x, inverse.y);",
    ),
    mutant("rollers of a turned ply", "quarter turns, rollers", "let own = to_ply(ply, along);", "let own = along;"),
    mutant(
        "held nodes give way",
        "thirty degrees, clamped, smooth",
        "let bits = vec3<u32>(held(ply, place)) & vec3<u32>(1u, 2u, 4u);",
        "let bits = vec3<u32>(0u);",
    ),
    mutant(
        "shares of the corners not met",
        "two free plies",
        "compliance += weights[i] * share_of(around[i]) *",
        "compliance += weights[i] *",
    ),
    mutant(
        "own inertia missing",
        "two free plies",
        "var compliance = share_of(node) * inverse_along(ply, node_place(node), push);",
        "var compliance = 0.0;",
    ),
    mutant(
        "velocity of the surface missing",
        "two free plies",
        "velocity -= ply_velocity(other, around[i]) * weights[i];",
        "",
    ),
    mutant("no friction", "two free plies", "if (!PLY_FRICTION) {", "if (true) {"),
    mutant(
        "friction without its limit",
        "two free plies",
        "let most = scene.ply_friction * normal;",
        "let most = normal;",
    ),
    mutant(
        "sticking missing",
        "the first step",
        "select(stick, stick * (most / max(size, 1e-30)), size > most)",
        "stick * (most / max(size, 1e-30))",
    ),
    mutant(
        "sliding along the normal",
        "two free plies",
        "let slide = velocity - push * along;",
        "let slide = velocity;",
    ),
    mutant(
        "rubbing at the first velocity",
        "two free plies",
        "slide + found.friction_impulse * (0.5 * compliance)",
        "slide",
    ),
    mutant(
        "rubbing not noted",
        "two free plies",
        "accounts[10u * scene.elements + scene.nodes + node] -=",
        "accounts[10u * scene.elements + scene.nodes + node] -= 0.0 *",
    ),
    mutant("gap closed at once", "two free plies", "max(kappa * (limit - along), 0.0)", "max(kappa * (-along), 0.0)"),
    mutant("contacts pull", "two free plies", "max(kappa * (limit - along), 0.0)", "kappa * (limit - along)"),
    mutant("nodes not moved out", "two free plies", "kappa * contact.foot.z", "0.0 * contact.foot.z"),
    mutant("corners pushed along", "two free plies", "-part * each, -way", "part * each, -way"),
    mutant("corners moved along", "two free plies", "each, -way * each);", "each, way * each);"),
    mutant("node pushed without its corners", "two free plies", "add(around[i], -part * each, -way * each);", ""),
    mutant("one side alone", "two free plies", "side < 2u", "side < 1u"),
    mutant(
        "cell of the node's own ply",
        "two fabrics, holes, no hourglass",
        "cell_over(other, over[at])",
        "cell_over(ply, over[at])",
    ),
    mutant(
        "contacts that are over",
        "two free plies",
        "if (contacts[side * scene.nodes + node].foot.w != 0.0) {",
        "if (neighbour(node_ply(node), side) != NO_PLY) {",
    ),
    mutant(
        "corners count in the largest unit",
        "graded plies",
        "let each = 1 << (largest - theirs[i]);",
        "let each = 1;",
    ),
    mutant("node counts in the largest unit", "graded plies", "let each = 1 << (largest - own);", "let each = 1;"),
    mutant(
        "largest unit not counted in",
        "graded plies",
        "shot.impulse_unit * f32(1u << largest)",
        "shot.impulse_unit",
    ),
    mutant("unit of one corner forgotten", "graded plies", "max(theirs.z, theirs.w)", "theirs.z"),
    mutant(
        "units twice as large",
        "graded plies",
        "u32(ceil(mass_share(ply, place))) - 1u",
        "u32(ceil(mass_share(ply, place)))",
    ),
    mutant(
        "masses of the finest",
        "graded plies",
        "inverse = plies[ply].inverse_inner / mass_share(ply, place);",
        "inverse = plies[ply].inverse_inner;",
    ),
];
