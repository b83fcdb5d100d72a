// element_force: stretches, crossover equilibrium, shear, failure and corner forces of every element.
//   in      nodes     array<f32>  (6, N)   displacement [m], velocity [m/s]
//   in/out  forces    array<f32>  (9, E)   P1·Ly/2, P2·Lx/2, force on the difference of opposite edges [N]
//   in/out  heights   array<f32>  (6, E)   `dh_dstretch` [m] and `force_share` [-] of warp and weft, which predict heights; h1, h2 [m], warm start
//   in/out  flags     array<u32>  (E)      bit 0 warp alive, bit 1 weft alive; evaluations since the last sample << 8
//   in/out  accumulators  array<f32>  (10, E)   see `energy_balance`
//   in/out  status    array<u32>           counters
//   out     events    array<Event>         yarn failures
//   in/out  yarns     array<f32>  (8, E)   viscous forces of warp and weft [N]; strains of warp and weft in steps of even number, of odd
//                                          number [-]; failure strains of warp and weft over the fabric's [-], where strength varies
// Twin: src/solver/element_force.rs

@group(1) @binding(0) var<storage, read> nodes: array<f32>;
@group(1) @binding(1) var<storage, read_write> forces: array<f32>;
@group(1) @binding(2) var<storage, read_write> heights: array<f32>;
@group(1) @binding(3) var<storage, read_write> flags: array<u32>;
@group(1) @binding(4) var<storage, read_write> accumulators: array<f32>;
@group(1) @binding(5) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(6) var<storage, read_write> events: array<Event>;
@group(1) @binding(7) var<storage, read_write> yarns: array<f32>;

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
    let warp = tension.x * strain.x * scene.warp_half_span * (1.0 + scene.warp_crimp);
    let weft = tension.y * strain.y * scene.weft_half_span * (1.0 + scene.weft_crimp);
    return size.cells * (warp + weft + compression_energy(force)) + size.area * shear;
}

fn store(field: u32, element: u32, value: vec3<f32>) {
    let e = scene.elements;
    for (var a = 0u; a < 3u; a++) { forces[(field + a) * e + element] = value[a]; }
}

fn keep_heights(element: u32, height: vec2<f32>, predictor: Predictor) {
    let e = scene.elements;
    heights[element] = predictor.dh_dstretch.x;
    heights[e + element] = predictor.dh_dstretch.y;
    heights[2u * e + element] = predictor.force_share.x;
    heights[3u * e + element] = predictor.force_share.y;
    heights[4u * e + element] = height.x;
    heights[5u * e + element] = height.y;
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

fn motion_of(element: u32, at: vec4<u32>) -> Motion {
    let u = differences(0u, at);
    let size = geometry_of(element);
    let k = kinematics(size, u);
    let v = differences(3u, at);
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

/// Strains of the last step.
fn strain_slot() -> u32 { return 2u + 2u * ((step.index + 1u) & 1u); }

fn keep_strains(element: u32, strain: vec2<f32>) {
    let slot = 2u + 2u * (step.index & 1u);
    yarns[slot * scene.elements + element] = strain.x;
    yarns[(slot + 1u) * scene.elements + element] = strain.y;
}

/// Also keeps the strains that failure is judged by.
fn judge(element: u32, stretch: vec2<f32>, cell: Equilibrium, was_alive: vec2<bool>) -> YarnsLeft {
    let zero = vec2<f32>(0.0);
    let limit = failure_strain(element);
    // Almost always nothing has to be looked at.
    let near = step.index <= atomicLoad(&status[counter(AT_LIMIT)]);
    let failed = vec2<bool>(
        near && was_alive.x && (limit.x <= piece_of(element, 0u, limit.x).x || breaks_with_another(element, 0u)),
        near && was_alive.y && (limit.y <= piece_of(element, 1u, limit.y).x || breaks_with_another(element, 1u)));
    let alive = was_alive & !failed;
    keep_strains(element, select(vec2<f32>(BROKEN), max(cell.strain, zero), alive));
    if (any(alive & (limit <= cell.strain))) { atomicMax(&status[counter(AT_LIMIT)], step.index + 1u); }
    let straight = vec2<f32>(straight_strain(yarn(0u), stretch.x), straight_strain(yarn(1u), stretch.y));
    return YarnsLeft(was_alive, failed, alive, max(straight, zero), tensions(straight));
}

/// Forces on it.
struct Forces {
    /// Viscous forces of the yarns [N].
    drag: vec2<f32>,
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

/// Also keeps the viscous forces, and books what they dissipate.
fn forces_of(element: u32, motion: Motion, cell: Equilibrium, yarns_left: YarnsLeft) -> Forces {
    let size = motion.size;
    let k = motion.k;
    let zero = vec2<f32>(0.0);
    let free = yarns_left.free;
    let both_left = all(yarns_left.alive);
    let elastic = select(zero, select(free, cell.in_plane, both_left), yarns_left.alive);
    var drag = zero;
    if (VISCOUS) {
        let e = scene.elements;
        let at_last = vec2<f32>(yarns[element], yarns[e + element]);
        let shock = shock_viscosity(size, k, motion.v, motion.grown, elastic, at_last);
        drag = shock.force;
        yarns[element] = drag.x;
        yarns[e + element] = drag.y;
        // N over the element's width times its length.
        accumulators[7u * e + element] += dot(shock.work,
            vec2<f32>(0.5 * size.membrane_warp / size.gradient_x, 0.5 * size.membrane_weft / size.gradient_y));
    }
    let pull = elastic + drag;
    var trellis = Shear();
    if (SHEAR) { trellis = trellis_shear(k); }
    let left = shear_where(both_left, trellis);
    let m = membrane(size, k, pull, left);
    return Forces(drag, trellis, m, mode_force(size, k, elastic, left), hourglass_where(both_left, size));
}

/// Keeps forces and books their work.
fn keep_forces(element: u32, motion: Motion, acting: Forces) {
    let m = acting.membrane;
    let v = motion.v;
    // Work done on the element between the last positions and these (trapezoid), and the new forces.
    var power = dot(element_forces(0u, element) + m.warp, v.x) + dot(element_forces(3u, element) + m.weft, v.y);
    store(0u, element, m.warp);
    store(3u, element, m.weft);
    if (HOURGLASS) {
        let force = acting.hourglass * motion.k.mode + acting.on_mode;
        power += dot(element_forces(6u, element) + force, v.mode);
        store(6u, element, force);
    }
    accumulators[element] += 0.5 * step.span * power;
}

/// Energy that the law has made of what the cells store, where both yarns are there.
fn keep_law(element: u32, motion: Motion, both: bool, cells: f32) {
    if (LAW_ENERGY && both) { accumulators[8u * scene.elements + element] = law_share(motion.k.stretch) * cells; }
}

/// Books what the yarns release that fail in this step.
fn release(element: u32, motion: Motion, cell: Equilibrium, yarns_left: YarnsLeft, acting: Forces) {
    let e = scene.elements;
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
    accumulators[e + element] += before - after - 0.5 * step.span * undone;
    if (HOURGLASS) {
        // The part of the hourglass work that the state function ½k|q|² does not hold once k dropped.
        let lost = hourglass_where(both, size) - acting.hourglass;
        accumulators[2u * e + element] += 0.5 * lost * dot(mode, mode - step.span * v.mode);
    }
    // What the law has made by now stays.
    keep_law(element, motion, both, stored_energy(size, select(zero, cell.tension, was_alive), cell.strain, cell.force, 0.0));
    if (yarns_left.failed.x) { record_failure(element, 0u, cell.strain.x); }
    if (yarns_left.failed.y) { record_failure(element, 1u, cell.strain.y); }
    if (!any(yarns_left.alive)) { atomicAdd(&status[counter(ERODED)], 1u); }
}

/// Energies of the state and largest values, for the energy balance.
fn keep_state(element: u32, at: vec4<u32>, motion: Motion, cell: Equilibrium, yarns_left: YarnsLeft, acting: Forces) {
    let e = scene.elements;
    let zero = vec2<f32>(0.0);
    let size = motion.size;
    let mode = motion.k.mode;
    let alive = yarns_left.alive;
    let free = yarns_left.free;
    let both_left = all(alive);
    let tension = select(zero, select(free, cell.tension, both_left), alive);
    let strain = select(yarns_left.free_strain, cell.strain, both_left);
    let left = shear_where(both_left, acting.trellis);
    accumulators[3u * e + element] = stored_energy(size, tension, strain, select(0.0, cell.force, both_left), left.energy);
    accumulators[4u * e + element] = select(0.0, 0.5 * acting.hourglass * dot(mode, mode), HOURGLASS);
    keep_law(element, motion, both_left, stored_energy(size, tension, strain, select(0.0, cell.force, both_left), 0.0));
    let n = 2u * scene.nodes;
    let z = abs(vec4<f32>(nodes[n + at.x], nodes[n + at.y], nodes[n + at.z], nodes[n + at.w]));
    accumulators[6u * e + element] = max(max(z.x, z.y), max(z.z, z.w));
}

/// An element that carries nothing.
fn keep_nothing(element: u32) {
    let e = scene.elements;
    if (SAMPLED) {
        for (var field = 3u; field < 7u; field++) { accumulators[field * e + element] = 0.0; }
    }
    keep_heights(element, vec2<f32>(0.0), Predictor());
    keep_strains(element, vec2<f32>(BROKEN));
}

/// One element; gives the bits of its residual, or all ones where the residual was not met.
fn element_step(element: u32) -> u32 {
    let e = scene.elements;
    let word = flags[element];
    let was_alive = vec2<bool>((word & 1u) != 0u, (word & 2u) != 0u);
    let both = all(was_alive);
    if (!any(was_alive)) {
        keep_nothing(element);
        return 0u;
    }
    let at = corners(element);
    let motion = motion_of(element, at);
    let height = vec2<f32>(heights[4u * e + element], heights[5u * e + element]);
    let slopes = vec2<f32>(heights[element], heights[e + element]);
    let kept = Predictor(slopes, vec2<f32>(heights[2u * e + element], heights[3u * e + element]));
    let warm = predicted(kept, height, stretching(motion.k, motion.grown));
    let cell = solve(motion.k.stretch, warm, both);
    let yarns_left = judge(element, motion.k.stretch, cell, was_alive);
    let acting = forces_of(element, motion, cell, yarns_left);
    keep_forces(element, motion, acting);
    keep_heights(element, cell.height, cell.predictor);
    if (any(yarns_left.failed)) { release(element, motion, cell, yarns_left, acting); }
    let bits = select(0u, 1u, yarns_left.alive.x) | select(0u, 2u, yarns_left.alive.y);
    flags[element] = (word & 0xffffff00u) + (cell.iterations << 8u) + bits;
    if (SAMPLED) { keep_state(element, at, motion, cell, yarns_left, acting); }
    return select(0xffffffffu, bitcast<u32>(cell.residual), cell.converged || !both);
}

var<workgroup> worst: atomic<u32>;
var<workgroup> open_cells: atomic<u32>;

@compute @workgroup_size(64)
fn element_force(id: Invocation) {
    shot = shots[id.group.z];
    let number = invocation_number(id);
    let element = first_element() + number;
    // No invocation leaves before the barriers, also when an earlier step went wrong.
    if (number < scene.shot_elements && is_due(element) && step.index <= atomicLoad(&status[counter(BAD_STEP)])) {
        let residual = element_step(element);
        if (residual == 0xffffffffu) {
            atomicAdd(&open_cells, 1u);
        } else if (residual != 0u) {
            atomicMax(&worst, residual);
        }
    }
    workgroupBarrier();
    if (id.local == 0u) {
        let most = atomicLoad(&worst);
        if (most > atomicLoad(&status[counter(RESIDUAL)])) { atomicMax(&status[counter(RESIDUAL)], most); }
        let count = atomicLoad(&open_cells);
        if (count > 0u) { atomicAdd(&status[counter(UNCONVERGED)], count); }
    }
}
