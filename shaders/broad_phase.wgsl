// broad_phase: nodes that may meet the projectile, their contact before it acts, and what may have moved after it. Needs `nodes`,
// `cells`, `status`, `body`, `candidates`, `points`, `extent` and `over`.
// Twin: src/solver/contact/broad_phase.rs

/// Marked nodes of all plies in front of the searched one.
var<workgroup> in_front: atomic<u32>;

/// Marks in a word of the nodes of the shot from `first` on and before `past`.
fn marks_between(first: u32, past: u32, word: u32) -> u32 {
    var marks = atomicLoad(&candidates[mark_word(word)]);
    if (first > 32u * word) { marks &= 0xffffffffu << (first & 31u); }
    if (past < 32u * word + 32u) { marks &= (1u << (past & 31u)) - 1u; }
    return marks;
}

/// Lists the marked nodes of a ply in storage order, behind those of the plies in front of it, and notes in `extent` which they are. Behind the marks
/// it notes how many nodes come before those of a word.
fn collect(ply: u32, local: u32) {
    let of_ply = scene.shot_nodes / scene.plies;
    let first = ply * of_ply;
    let past = first + of_ply;
    var count = 0u;
    for (var word = local; 32u * word < first; word += WIDTH) { count += countOneBits(marks_between(0u, first, word)); }
    atomicAdd(&in_front, count);
    let each = (of_ply / 32u + 1u + WIDTH) / WIDTH;
    let begin = first / 32u + local * each;
    let end = min(begin + each, (past + 31u) / 32u);
    count = 0u;
    for (var word = begin; word < end; word++) { count += countOneBits(marks_between(first, past, word)); }
    var total = 0u;
    let sum = sum_up_to(count, &total, local);
    let before = atomicLoad(&in_front);
    var at = before + sum - count;
    for (var word = begin; word < end; word++) {
        var marks = marks_between(first, past, word);
        if (marks == 0u) { continue; }
        // Of the first word some nodes may belong to the ply in front.
        let theirs = select(0u, countOneBits(marks_between(0u, first, word)), word == first / 32u);
        atomicStore(&candidates[mark_word(BEFORE * mark_words() + word)], at - theirs);
        for (; marks != 0u; marks &= marks - 1u) {
            if (at < scene.points) { points[point_number(at)].node = first_node() + word * 32u + firstTrailingBit(marks); }
            at += 1u;
        }
    }
    if (local == 0u) {
        if (before + total > scene.points) { atomicMax(&status[counter(OVERFLOW)], before + total); }
        extent = Extent(min(before, scene.points), min(before + total, scene.points), ply, 0u);
        ends[ply] = 0u;
    }
    storageBarrier();
}

/// Clears all bits.
fn clear_marks(local: u32) {
    for (var word = local; word < mark_words(); word += WIDTH) {
        atomicStore(&candidates[mark_word(word)], 0u);
        for (var i = IDLE; i < MARKS; i++) { atomicStore(&candidates[mark_word(i * mark_words() + word)], 0u); }
    }
}

/// First guess of the state of what may touch, a node (0) or the edge that begins there along its row (1), along its column (2): what did not push
/// in the last step mostly does not in this one.
fn first_state(what: u32, node: u32, closes: bool) -> u32 {
    let was_idle = (atomicLoad(&candidates[mark_at(IDLE + what, node)]) & mark_bit(node)) != 0u;
    return select(NEAR, PUSHING, closes && !was_idle);
}

/// Thickness of the fabric between a node and the struck side [m]: of each ply in front whose element there stands.
fn fabric_between(node: u32) -> f32 {
    let missing = atomicLoad(&status[counter(HOLES)]) + atomicLoad(&status[counter(ERODED)]);
    if (missing == 0u) { return plies[node_ply(node)].depth; }
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

/// Takes a node in; gives how deep it is inside the body [m]. One that does not touch may be the end of an edge that does.
fn take_in(p: u32) -> f32 {
    let point = point_number(p);
    let node = points[point].node;
    let ply = node_ply(node);
    let place = node_place(node);
    let inverse = inverse_in_pack(ply, place);
    let mass = node_mass(ply, place);
    points[point].inverse = vec4<f32>(inverse, 0.0);
    points[point].relative = vec4<f32>(0.0, 0.0, 0.0, mass);
    points[point].pressed = vec4<f32>(0.0);
    var touch: Touch;
    touch.ends = vec2<u32>(p, p);
    touch.member = NONE;
    touches[touch_number(p)] = touch;
    if (!is_intact(node, place)) { return 0.0; }
    let own = node_vector(3u, node);
    let before = to_pack(ply, node_vector(0u, node) - scene.dt * own);
    let from_nose = arm_of(body.nose_coarse, body.nose_fine, to_pack(ply, reference(ply, place)), before);
    let between = fabric_between(node);
    let pressed = rotate_back(body.orientation, from_nose - vec3<f32>(0.0, 0.0, between));
    let g = contact_distance(pressed);
    let arm = from_nose + nose_of(body.orientation);
    let relative = to_pack(ply, own) - body.velocity.xyz - cross(body.turning.xyz, arm);
    let normal = rotate(body.orientation, g.normal);
    points[point].relative = vec4<f32>(relative, mass);
    points[point].pressed = vec4<f32>(pressed, between);
    touch.normal = vec4<f32>(normal, g.distance);
    touch.arm = vec4<f32>(arm, mass);
    touch.friction = friction_through(between);
    let approach = dot(relative, normal);
    // Where body and node are held neither can give way.
    let are_held = scene.body_prescribed != 0u && dot(normal, inverse * normal) <= 0.0;
    if (!stays_away(g.distance, approach) && !are_held) {
        touch.state = first_state(0u, node, approach < closing_limit(g.distance));
    }
    touches[touch_number(p)] = touch;
    return max(0.0, -g.distance);
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

/// Takes note of the elements of a ply computed in this step, and lets what may have moved of it grow by a ring of nodes.
fn grow_active_region(ply: u32, local: u32) {
    if (local != 0u) { return; }
    let p = plies[ply];
    let reach = reach_of(ply);
    let grown = vec4<u32>(
        max(reach.x, 1u) - 1u, min(reach.y + 1u, p.rows + 1u), max(reach.z, 1u) - 1u, min(reach.w + 1u, p.columns + 1u));
    let none = reach.x >= reach.y;
    let computed = (grown.y - 1u - grown.x) * (grown.w - 1u - grown.z);
    let count = select(select(computed, 0u, none), p.rows * p.columns, step.index == 0u);
    let before = atomicAdd(&status[counter(COMPUTED)], count);
    if (before + count < before) { atomicAdd(&status[counter(COMPUTED + 1u)], 1u); }
    if (none) { return; }
    for (var i = 0u; i < 4u; i++) { atomicStore(&status[counter(REACH + 4u * ply + i)], grown[i]); }
}
