// element_force: stretches, crossover equilibrium, shear, failure and corner forces of an element. Needs `cells`, `status` and `events`.
// Twin: src/solver/element_force.rs

/// A yarn failure.
struct Event {
    step: u32,
    element: u32,
    /// 0 warp, 1 weft.
    yarn: u32,
    strain: f32,
}

/// Energy of one element [J]: yarns, crossover compression, shear.
fn stored_energy(size: ElementGeometry, tension: vec2<f32>, strain: vec2<f32>, force: f32, shear: f32) -> f32 {
    let warp = twice_energy(0u, tension.x, strain.x) * scene.half_span.x * (1.0 + scene.crimp.x);
    let weft = twice_energy(1u, tension.y, strain.y) * scene.half_span.y * (1.0 + scene.crimp.y);
    return size.cells * (warp + weft + compression_energy(force)) + size.area * shear;
}

/// Field after both slots of the overstress in one of them.
fn rate_field(slot: u32) -> u32 { return select(0u, 2u, STRENGTH) + RATE_FIELDS * slot; }

fn put_pair(slot: u32, field: u32, element: u32, value: vec2<f32>) {
    let at = cell_word(slot, field, element);
    cells[at] = bitcast<u32>(value.x);
    cells[at + scene.elements] = bitcast<u32>(value.y);
}

/// Keeps yarns that stand, heights [m] and what predicts the next ones: a first guess, which few bits do for.
fn keep_heights(element: u32, alive: vec2<bool>, height: vec2<f32>, predictor: Predictor) {
    let per_sum = 1.0 / max(scene.height_sum, 1e-30);
    let steps = vec2<u32>(round(min(max(height * per_sum, vec2<f32>(0.0)), vec2<f32>(1.0)) * f32(HEIGHT_STEPS)));
    let slopes = pack2x16float(min(max(predictor.dh_dstretch * per_sum, vec2<f32>(-65504.0)), vec2<f32>(65504.0)));
    let shares = vec2<u32>(round(predictor.force_share * 511.0));
    let yarns = select(0u, 1u, alive.x) | select(0u, 2u, alive.y);
    let at = cell_word(slot_now(), YARNS, element);
    cells[at] = yarns | (steps.x << 2u) | (steps.y << 26u);
    cells[at + scene.elements] = (steps.y >> 6u) | ((slopes & 0xfffcu) << 16u);
    cells[at + 2u * scene.elements] = (slopes & 0xfffc0000u) | (shares.x << 9u) | shares.y;
}

/// The three words of the last step.
fn kept_words(element: u32) -> vec3<u32> {
    let at = cell_word(slot_before(), YARNS, element);
    return vec3<u32>(cells[at], cells[at + scene.elements], cells[at + 2u * scene.elements]);
}

/// Heights in them [m].
fn kept_heights(words: vec3<u32>) -> vec2<f32> {
    let steps = vec2<u32>(words.x >> 2u, (words.x >> 26u) | (words.y << 6u)) & vec2<u32>(HEIGHT_STEPS);
    return vec2<f32>(steps) * (scene.height_sum / f32(HEIGHT_STEPS));
}

fn kept_predictor(words: vec3<u32>) -> Predictor {
    let slopes = unpack2x16float(((words.y >> 16u) & 0xfffcu) | (words.z & 0xfffc0000u));
    let shares = vec2<u32>(words.z >> 9u, words.z) & vec2<u32>(511u);
    return Predictor(slopes * scene.height_sum, vec2<f32>(shares) * (1.0 / 511.0));
}

fn record_failure(element: u32, which: u32, strain: f32) {
    atomicAdd(&status[counter(FAILED + which)], 1u);
    let at = atomicAdd(&status[counter(EVENTS)], 1u);
    events[2u * first_element() + at] = Event(step.index, element, which, strain);
}

/// Motion of an element.
struct Motion {
    size: ElementGeometry,
    k: Kinematics,
    /// Differences of velocities.
    v: Differences,
    /// Since the last forces.
    grown: Growth,
}

fn motion_of(ply: u32, place: vec2<u32>, u: Differences, v: Differences) -> Motion {
    let size = geometry_of(ply, place);
    let k = kinematics(size, u);
    return Motion(size, k, v, growth(size, k, v));
}

/// Yarns of an element, and which of them fail.
struct YarnsLeft {
    was_alive: vec2<bool>,
    failed: vec2<bool>,
    alive: vec2<bool>,
    /// Strains [-] and tensions [N] of yarns that none presses on.
    free_strain: vec2<f32>,
    free: vec2<f32>,
}

/// Failure is judged by the strains of the last step.
fn strain_slot() -> u32 { return slot_before(); }

fn judge(element: u32, stretch: vec2<f32>, cell: Equilibrium, was_alive: vec2<bool>) -> YarnsLeft {
    let limit = failure_strain(element);
    // Almost always nothing has to be looked at.
    let near = step.index <= atomicLoad(&status[counter(AT_LIMIT)]);
    let failed = vec2<bool>(
        near && was_alive.x && (limit.x <= piece_of(element, 0u, limit.x).x || breaks_with_another(element, 0u)),
        near && was_alive.y && (limit.y <= piece_of(element, 1u, limit.y).x || breaks_with_another(element, 1u)));
    let alive = was_alive & !failed;
    if (any(alive & (limit <= cell.strain))) { atomicMax(&status[counter(AT_LIMIT)], step.index + 1u); }
    let straight = straight_strain(stretch);
    return YarnsLeft(was_alive, failed, alive, max(straight, vec2<f32>(0.0)), tensions(straight));
}

/// Forces on it.
struct Forces {
    /// Viscous forces of the yarns [N].
    drag: vec2<f32>,
    /// Overstress of the rate of strain over the tension.
    rate: vec2<f32>,
    dissipated: f32,
    /// Trellis shear, had the element two yarns.
    trellis: Shear,
    membrane: Membrane,
    /// Force of the yarns on the difference of opposite edges [N].
    on_mode: vec3<f32>,
    /// Hourglass stiffness on the difference of opposite edges [N/m].
    hourglass: f32,
}

/// Hourglass stiffness on the difference of opposite edges [N/m] where both yarns are there: the mode is a quarter of that.
fn hourglass_where(both: bool, size: ElementGeometry) -> f32 {
    return select(0.0, (1.0 / 16.0) * size.hourglass, both);
}

/// Forces on it, and what viscous ones dissipated [J].
fn forces_of(element: u32, motion: Motion, cell: Equilibrium, yarns_left: YarnsLeft) -> Forces {
    let size = motion.size;
    let k = motion.k;
    let zero = vec2<f32>(0.0);
    let free = yarns_left.free;
    let both_left = all(yarns_left.alive);
    let elastic = select(zero, select(free, cell.in_plane, both_left), yarns_left.alive);
    var drag = zero;
    var rate = zero;
    var dissipated = 0.0;
    if (VISCOUS) {
        let at_last = yarn_pair(slot_before(), DRAG, element);
        var rate_before = zero;
        if (RATE) { rate_before = yarn_pair(2u, rate_field(slot_before()), element); }
        let shock = viscous_forces(size, k, motion.v, motion.grown, elastic, at_last, rate_before);
        drag = shock.force;
        rate = shock.rate;
        // N over the element's width times its length.
        dissipated = dot(shock.work, 0.5 * size.membrane / size.gradient);
    }
    let pull = elastic + drag;
    var trellis = Shear();
    if (SHEAR) { trellis = trellis_shear(k); }
    let left = shear_where(both_left, trellis);
    let m = membrane(size, k, pull, left);
    return Forces(drag, rate, dissipated, trellis, m, mode_force(size, k, elastic, left), hourglass_where(both_left, size));
}

/// Energy that the law has made of what the cells store, where both yarns are there.
fn law_energy(motion: Motion, both: bool, stored: f32) -> f32 {
    if (both) { return law_share(motion.k.stretch) * stored; }
    return 0.0;
}

/// Books what the yarns release that fail in this step.
fn release(element: u32, motion: Motion, cell: Equilibrium, yarns_left: YarnsLeft, acting: Forces) {
    let zero = vec2<f32>(0.0);
    let size = motion.size;
    let m = acting.membrane;
    let v = motion.v;
    let mode = motion.k.mode;
    let was_alive = yarns_left.was_alive;
    let both = all(was_alive);
    let was = shear_where(both, acting.trellis);
    let before = stored_energy(size, select(zero, cell.tension, was_alive), cell.strain, cell.force, was.energy);
    let after = stored_energy(size, select(zero, yarns_left.free, yarns_left.alive), yarns_left.free_strain, 0.0, 0.0);
    // Forces that break in this step never act, so the last half step's work on them was not done either.
    // Of what acts now only the elastic part changes what is stored.
    let elastic = select(zero, cell.in_plane, was_alive);
    let intact = membrane(size, motion.k, elastic + acting.drag, was);
    let mode_intact = mode_force(size, motion.k, elastic, was);
    let undone = dot(intact.warp - m.warp, v.x) + dot(intact.weft - m.weft, v.y) + dot(mode_intact - acting.on_mode, v.mode);
    part[RELEASED] += before - after - 0.5 * step.span * undone;
    // The part of the hourglass work that the state function ½k|q|² does not hold once k dropped.
    let lost = hourglass_where(both, size) - acting.hourglass;
    part[RELEASED_HOURGLASS] += 0.5 * lost * dot(mode, mode - step.span * v.mode);
    // What the law has made by now stays.
    part[LAW_RELEASED] += law_energy(motion, both, stored_energy(size, select(zero, cell.tension, was_alive), cell.strain, cell.force, 0.0));
    if (yarns_left.failed.x) { record_failure(element, 0u, cell.strain.x); }
    if (yarns_left.failed.y) { record_failure(element, 1u, cell.strain.y); }
    if (!any(yarns_left.alive)) { atomicAdd(&status[counter(ERODED)], 1u); }
}

/// Adds energies of the state, and the cell if it is counted, for the energy balance.
fn add_state(motion: Motion, cell: Equilibrium, yarns_left: YarnsLeft, acting: Forces, counted: bool) {
    let zero = vec2<f32>(0.0);
    let size = motion.size;
    let mode = motion.k.mode;
    let alive = yarns_left.alive;
    let free = yarns_left.free;
    let both_left = all(alive);
    let tension = select(zero, select(free, cell.tension, both_left), alive);
    let strain = select(yarns_left.free_strain, cell.strain, both_left);
    let left = shear_where(both_left, acting.trellis);
    part[STORED] += stored_energy(size, tension, strain, select(0.0, cell.force, both_left), left.energy);
    part[HOURGLASS_NOW] += 0.5 * acting.hourglass * dot(mode, mode);
    part[LAW_MADE] += law_energy(motion, both_left, stored_energy(size, tension, strain, select(0.0, cell.force, both_left), 0.0));
    part[SOLVED] += select(0.0, f32(step.since), both_left && counted);
}

/// Forces of an element on its corners [N]: P1·Ly/2, P2·Lx/2, on the difference of opposite edges.
struct ElementForces {
    warp: vec3<f32>,
    weft: vec3<f32>,
    mode: vec3<f32>,
    /// Whether any of its yarns carried load at the beginning of the step.
    stood: bool,
}

/// Notes a residual [N], or that it was not met.
fn note_residual(cell: Equilibrium, both: bool) {
    if (!both) { return; }
    if (!cell.converged) {
        atomicAdd(&open_cells, 1u);
    } else if (cell.residual > 0.0) {
        atomicMax(&worst, bitcast<u32>(cell.residual));
    }
}

/// One element, from the differences of its corners' displacements and velocities. `own`: keeps and books what came of it; `counted`: its
/// evaluations count.
fn element_step(ply: u32, place: vec2<u32>, u: Differences, v: Differences, own: bool, counted: bool) -> ElementForces {
    let element = element_at(ply, place);
    let words = kept_words(element);
    let was_alive = vec2<bool>((words.x & 1u) != 0u, (words.x & 2u) != 0u);
    let zero = vec2<f32>(0.0);
    if (!any(was_alive)) {
        if (own) {
            keep_heights(element, was_alive, zero, Predictor());
            put_pair(slot_now(), DRAG, element, zero);
            if (RATE) { put_pair(2u, rate_field(slot_now()), element, zero); }
            put_pair(slot_now(), STRAIN, element, vec2<f32>(BROKEN));
        }
        return ElementForces();
    }
    let both = all(was_alive);
    let motion = motion_of(ply, place, u, v);
    let warm = predicted(kept_predictor(words), kept_heights(words), stretching(motion.k, motion.grown));
    let cell = solve(motion.k.stretch, warm, both);
    let yarns_left = judge(element, motion.k.stretch, cell, was_alive);
    let acting = forces_of(element, motion, cell, yarns_left);
    if (own) {
        keep_heights(element, yarns_left.alive, cell.height, cell.predictor);
        put_pair(slot_now(), DRAG, element, acting.drag);
        if (RATE) { put_pair(2u, rate_field(slot_now()), element, acting.rate); }
        put_pair(slot_now(), STRAIN, element, select(vec2<f32>(BROKEN), max(cell.strain, zero), yarns_left.alive));
        part[VISCOUS_WORK] += acting.dissipated;
        if (counted) { part[EVALUATIONS] += f32(cell.iterations); }
        note_residual(cell, both);
        if (any(yarns_left.failed)) { release(element, motion, cell, yarns_left, acting); }
        if (is_sampled()) { add_state(motion, cell, yarns_left, acting, counted); }
    }
    let mode = acting.hourglass * motion.k.mode + acting.on_mode;
    return ElementForces(acting.membrane.warp, acting.membrane.weft, mode, true);
}
