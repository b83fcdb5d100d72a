// contact_candidates: nodes that may meet the projectile, their contact before it acts, and what may have moved after it. Needs `nodes`,
// `cells`, `status`, `body`, `candidates`, `points` and `over`.
// Twin: src/solver/contact/contact_candidates.rs

/// Lists the marked nodes in storage order and clears the marks; gives their number.
fn collect(local: u32) -> u32 {
    let words = mark_words().x;
    let summaries = mark_words().y;
    var total = 0u;
    for (var base = 0u; base < summaries; base += WIDTH) {
        let summary = base + local;
        var bits = 0u;
        if (summary < summaries) { bits = atomicLoad(&candidates[mark_word(words + summary)]); }
        var count = 0u;
        for (var rest = bits; rest != 0u; rest &= rest - 1u) {
            count += countOneBits(atomicLoad(&candidates[mark_word(summary * 32u + firstTrailingBit(rest))]));
        }
        var at = total + sum_up_to(count, local) - count;
        for (var rest = bits; rest != 0u; rest &= rest - 1u) {
            let word = summary * 32u + firstTrailingBit(rest);
            for (var marks = atomicLoad(&candidates[mark_word(word)]); marks != 0u; marks &= marks - 1u) {
                if (at < scene.points) { points[point_number(at)].node = first_node() + word * 32u + firstTrailingBit(marks); }
                at += 1u;
            }
            atomicStore(&candidates[mark_word(word)], 0u);
        }
        if (bits != 0u) { atomicStore(&candidates[mark_word(words + summary)], 0u); }
        total += scan[WIDTH - 1u];
        workgroupBarrier();
    }
    if (total > scene.points && local == 0u) { atomicStore(&status[counter(OVERFLOW)], total); }
    storageBarrier();
    return min(total, scene.points);
}

/// Thickness of the fabric between a node and the struck side [m]: of each ply in front whose element there stands.
fn fabric_between(node: u32) -> f32 {
    if (!PLIES) { return 0.0; }
    var at = node;
    var thickness = 0.0;
    for (var front = node_ply(node); front > 0u; front--) {
        let ply = front - 1u;
        let element = element_at(ply, cell_over(ply, over[at]));
        let place = element_place(element);
        thickness += select(0.0, plies[ply].touching, yarns_left(element) != 0u);
        // On through the corner nearest to the node by its place in the ply behind.
        let lies = to_ply(ply, to_pack(front, reference(front, node_place(at))));
        let corner = reference(ply, place);
        let size = cell_size(ply, place);
        let further = vec2<u32>(u32(lies.y - corner.y > 0.5 * size.y), u32(lies.x - corner.x > 0.5 * size.x));
        at = node_at(ply, place + further);
    }
    return thickness;
}

/// Node near the projectile, before contact.
struct Candidate {
    /// Outward normal of the body in the axes of the pack, and the gap [m].
    normal: vec3<f32>,
    gap: f32,
    /// From the body's centre of mass [m].
    arm: vec3<f32>,
    /// Depth inside the body [m].
    depth: f32,
    /// Velocity relative to the body's material [m/s].
    relative: vec3<f32>,
    /// In the body's frame, without the fabric in front of it [m], and the thickness of that [m].
    pressed: vec3<f32>,
    between: f32,
    state: u32,
}

/// Looks at one node closely.
fn candidate_at(node: u32) -> Candidate {
    var candidate: Candidate;
    let ply = node_ply(node);
    let place = node_place(node);
    if (!is_intact(node, place)) { return candidate; }
    let own = node_vector(3u, node);
    let free = to_pack(ply, own);
    let before = to_pack(ply, node_vector(0u, node) - scene.dt * own);
    let from_nose = arm_of(body.nose_coarse, body.nose_fine, to_pack(ply, reference(ply, place)), before);
    candidate.between = fabric_between(node);
    candidate.pressed = rotate_back(body.orientation, from_nose - vec3<f32>(0.0, 0.0, candidate.between));
    let g = contact_distance(candidate.pressed);
    let arm = from_nose + nose_of(body.orientation);
    let relative = free - body.velocity.xyz - cross(body.turning.xyz, arm);
    candidate.normal = rotate(body.orientation, g.normal);
    candidate.gap = g.distance;
    candidate.arm = arm;
    candidate.relative = relative;
    candidate.depth = max(0.0, -g.distance);
    let approach = dot(relative, candidate.normal);
    if (stays_away(g.distance, approach)) { return candidate; }
    let along = dot(candidate.normal, inverse_in_pack(ply, place) * candidate.normal);
    if (scene.body_prescribed != 0u && along <= 0.0) { return candidate; } // both are held: neither can give way
    candidate.state = select(NEAR, PUSHING, approach < closing_limit(g.distance));
    return candidate;
}

/// Whether what approaches at a relative normal velocity cannot touch within the step.
fn stays_away(gap: f32, approach: f32) -> bool {
    // A body that turns under impulses may reach a little further than its velocity now takes it.
    return gap + scene.dt * (approach - 0.1 * body.velocity.w) > 0.0;
}

/// Coulomb coefficient where so much fabric lies between [m]: what the projectile rubs against is the fabric it touches;
/// further plies rub against each other.
fn friction_through(between: f32) -> f32 {
    return select(scene.friction, min(scene.friction, scene.ply_friction), between > 0.0);
}

/// Takes note of the elements computed in this step, and lets what may have moved grow by a ring of nodes.
fn grow_active_region(local: u32) {
    if (local == 0u) {
        for (var ply = 0u; ply < scene.plies; ply++) {
            let p = plies[ply];
            let reach = reach_of(ply);
            let all = step.index == 0u;
            let none = reach.x >= reach.y;
            // A ring more on each side, cut at the edges of the ply.
            let rows = min(reach.y, p.rows) - (max(reach.x, 1u) - 1u);
            let columns = min(reach.w, p.columns) - (max(reach.z, 1u) - 1u);
            let count = select(select(rows * columns, 0u, none), p.rows * p.columns, all);
            let before = atomicAdd(&status[counter(COMPUTED)], count);
            if (before + count < before) { atomicAdd(&status[counter(COMPUTED + 1u)], 1u); }
        }
    }
    workgroupBarrier();
    storageBarrier();
    let reach = reach_of(min(local, scene.plies - 1u));
    if (local < scene.plies && reach.x < reach.y) {
        let at = counter(REACH + 4u * local);
        atomicStore(&status[at], max(reach.x, 1u) - 1u);
        atomicStore(&status[at + 1u], min(reach.y + 1u, plies[local].rows + 1u));
        atomicStore(&status[at + 2u], max(reach.z, 1u) - 1u);
        atomicStore(&status[at + 3u], min(reach.w + 1u, plies[local].columns + 1u));
    }
    workgroupBarrier();
    storageBarrier();
}
