// element_force: stretches, crossover equilibrium, shear, failure and corner forces of every element.
//   in      nodes     array<f32>  (6, N)   displacement [m], velocity [m/s]
//   in/out  forces    array<f32>  (9, E)   P1·Ly/2, P2·Lx/2, hourglass per corner [N]
//   in/out  heights   array<f32>  (6, E)   `dh_dstretch` [m] and `force_share` [-] of warp and weft, which predict heights; h1, h2 [m], warm start
//   in/out  flags     array<u32>  (E)      bit 0 warp alive, bit 1 weft alive; evaluations since the last ledger << 8
//   in/out  accounts  array<f32>  (10, E)   see `energy_balance`
//   in/out  status    array<u32>           counters
//   out     events    array<Event>         yarn failures
//   in/out  yarns     array<f32>  (8, E)   viscous forces of warp and weft [N]; strains of warp and weft in steps of even number, of odd
//                                          number [-], where failure is judged over a length; failure strains of warp
//                                          and weft over the fabric's [-], where strength varies
// Twin: src/kernels/element_force.rs, src/solver/failure.rs

@group(1) @binding(0) var<storage, read> nodes: array<f32>;
@group(1) @binding(1) var<storage, read_write> forces: array<f32>;
@group(1) @binding(2) var<storage, read_write> heights: array<f32>;
@group(1) @binding(3) var<storage, read_write> flags: array<u32>;
@group(1) @binding(4) var<storage, read_write> accounts: array<f32>;
@group(1) @binding(5) var<storage, read_write> status: array<atomic<u32>>;
@group(1) @binding(6) var<storage, read_write> events: array<Event>;
@group(1) @binding(7) var<storage, read_write> yarns: array<f32>;

/// Places along each axis of the law's energy.
const LAW_COUNT: u32 = 40u;

/// Share of a cell's energy that the unit-cell law makes by itself, over both stretches; see src/kernels/law_energy.rs.
struct LawEnergy {
    /// Λ − 1 of the first place, warp and weft.
    low: vec2<f32>,
    /// Places per stretch.
    per_stretch: vec2<f32>,
    /// Shape (40 warp, 40 weft).
    values: array<vec4<f32>, 400>,
}

@group(0) @binding(4) var<uniform> law: LawEnergy;

fn law_value(i: u32, j: u32) -> f32 {
    let at = i * LAW_COUNT + j;
    return law.values[at / 4u][at % 4u];
}

/// At the stretches Λ − 1.
fn law_share(stretch: vec2<f32>) -> f32 {
    let place = min(max((stretch - law.low) * law.per_stretch, vec2<f32>(0.0)), vec2<f32>(f32(LAW_COUNT - 1u)));
    let i = min(u32(place.x), LAW_COUNT - 2u);
    let j = min(u32(place.y), LAW_COUNT - 2u);
    let x = place.x - f32(i);
    let y = place.y - f32(j);
    let low = law_value(i, j) + y * (law_value(i, j + 1u) - law_value(i, j));
    let high = law_value(i + 1u, j) + y * (law_value(i + 1u, j + 1u) - law_value(i + 1u, j));
    return low + x * (high - low);
}

/// A yarn failure.
struct Event {
    step: u32,
    element: u32,
    /// 0 warp, 1 weft.
    yarn: u32,
    strain: f32,
}

/// Stretch of a yarn below which it counts as folded: its element's trellis energy fades with the stretch.
const FOLDED_STRETCH: f32 = 0.5;

struct Kinematics {
    /// Λ − 1.
    stretch: vec2<f32>,
    warp: vec3<f32>,
    weft: vec3<f32>,
    /// 1/Λ.
    per_stretch: vec2<f32>,
    sine: f32,
}

/// Corner values (columns of four) to twice the edge differences along X and Y and the hourglass combination.
struct Differences {
    x: vec3<f32>,
    y: vec3<f32>,
    mode: vec3<f32>,
}

fn load(field: u32, at: u32) -> vec3<f32> {
    let n = scene.nodes;
    return vec3<f32>(nodes[field * n + at], nodes[(field + 1u) * n + at], nodes[(field + 2u) * n + at]);
}

fn differences(field: u32, at: vec4<u32>) -> Differences {
    let a = load(field, at.x);
    let b = load(field, at.y);
    let c = load(field, at.z);
    let d = load(field, at.w);
    let bottom = b - a;
    let top = c - d;
    return Differences(bottom + top, (d - a) + (c - b), top - bottom);
}

fn kinematics(size: ElementGeometry, u: Differences) -> Kinematics {
    let g1 = u.x * size.gradient_x;
    let g2 = u.y * size.gradient_y;
    let f1 = vec3<f32>(1.0 + g1.x, g1.y, g1.z);
    let f2 = vec3<f32>(g2.x, 1.0 + g2.y, g2.z);
    let l1 = max(sqrt(dot(f1, f1)), 1e-12);
    let l2 = max(sqrt(dot(f2, f2)), 1e-12);
    // Λ − 1 from the displacement gradient: no cancellation at small strain.
    let s1 = (2.0 * g1.x + dot(g1, g1)) / (1.0 + l1);
    let s2 = (2.0 * g2.y + dot(g2, g2)) / (1.0 + l2);
    let i1 = 1.0 / l1;
    let i2 = 1.0 / l2;
    let sine = (g2.x + g1.y + dot(g1, g2)) * i1 * i2;
    return Kinematics(vec2<f32>(s1, s2), f1 * i1, f2 * i2, vec2<f32>(i1, i2), min(max(sine, -1.0), 1.0));
}

/// What the stretches have grown by since the last forces, to second order. `v`: differences of velocities.
fn stretching(size: ElementGeometry, k: Kinematics, v: Differences) -> vec2<f32> {
    let warp = v.x * (step.span * size.gradient_x);
    let weft = v.y * (step.span * size.gradient_y);
    let along = vec2<f32>(dot(k.warp, warp), dot(k.weft, weft));
    return along - 0.5 * k.per_stretch * (vec2<f32>(dot(warp, warp), dot(weft, weft)) - along * along);
}

/// Trellis shear as the membrane feels it: the energy per reference area is fade(Λ1) fade(Λ2) W(sin γ).
struct Shear {
    /// Slope of that energy over Λ1 and Λ2, and over sin γ [N/m].
    along: vec2<f32>,
    slope: f32,
    /// The energy [J/m²].
    energy: f32,
}

fn trellis_shear(k: Kinematics) -> Shear {
    let trellis = trellis_at(k.sine);
    let part = min((1.0 + k.stretch) * (1.0 / FOLDED_STRETCH), vec2<f32>(1.0));
    let fade = part * part * (3.0 - 2.0 * part);
    let rise = (6.0 / FOLDED_STRETCH) * part * (1.0 - part);
    let both = fade.x * fade.y;
    return Shear(trellis.energy * (rise * fade.yx), trellis.slope * both, trellis.energy * both);
}

struct Membrane {
    warp: vec3<f32>,
    weft: vec3<f32>,
}

/// P1·Ly/2 and P2·Lx/2 [N] from in-plane yarn forces and trellis shear.
fn membrane(size: ElementGeometry, k: Kinematics, pull: vec2<f32>, shear: Shear) -> Membrane {
    let n1 = pull.x * size.membrane_warp;
    let n2 = pull.y * size.membrane_weft;
    if (!SHEAR) {
        return Membrane(n1 * k.warp, n2 * k.weft);
    }
    let m1 = n1 + shear.along.x * size.half_length_warp;
    let m2 = n2 + shear.along.y * size.half_length_weft;
    let q1 = shear.slope * size.half_length_warp * k.per_stretch.x;
    let q2 = shear.slope * size.half_length_weft * k.per_stretch.y;
    return Membrane(
        m1 * k.warp + q1 * (k.weft - k.sine * k.warp),
        m2 * k.weft + q2 * (k.warp - k.sine * k.weft));
}

/// Energy of one element [J]: yarns, crossover compression, shear.
fn stored_energy(size: ElementGeometry, tension: vec2<f32>, strain: vec2<f32>, force: f32, shear: f32) -> f32 {
    let warp = tension.x * strain.x * scene.warp_half_span * (1.0 + scene.warp_crimp);
    let weft = tension.y * strain.y * scene.weft_half_span * (1.0 + scene.weft_crimp);
    return size.cells * (warp + weft + compression_energy(force)) + size.area * shear;
}

fn store(field: u32, element: u32, value: vec3<f32>) {
    let e = scene.elements;
    forces[field * e + element] = value.x;
    forces[(field + 1u) * e + element] = value.y;
    forces[(field + 2u) * e + element] = value.z;
}

fn stored(field: u32, element: u32) -> vec3<f32> {
    let e = scene.elements;
    return vec3<f32>(forces[field * e + element], forces[(field + 1u) * e + element], forces[(field + 2u) * e + element]);
}

fn kept_predictor(element: u32) -> Predictor {
    let e = scene.elements;
    return Predictor(
        vec2<f32>(heights[element], heights[e + element]),
        vec2<f32>(heights[2u * e + element], heights[3u * e + element]));
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

fn keep_viscous(element: u32, force: vec2<f32>) {
    yarns[element] = force.x;
    yarns[scene.elements + element] = force.y;
}

/// Shock viscosity of an element's yarns.
struct Viscous {
    /// Now [N].
    force: vec2<f32>,
    /// Work since the last step over ½ of the element's length times its yarns [N].
    work: vec2<f32>,
}

/// Viscous forces of warp and weft: stiffness times viscosity times the rate of stretch, so large at a shock and small elsewhere. A slack
/// yarn has none, and a yarn never pushes. `elastic`: in-plane forces of the yarns; `before`: viscous forces at the last step.
fn shock_viscosity(size: ElementGeometry, k: Kinematics, v: Differences, elastic: vec2<f32>, before: vec2<f32>) -> Viscous {
    let warp = v.x * size.gradient_x;
    let weft = v.y * size.gradient_y;
    let rate = vec2<f32>(dot(k.warp, warp), dot(k.weft, weft));
    let stiffness = vec2<f32>(scene.warp_stiffness * size.viscosity_warp, scene.weft_stiffness * size.viscosity_weft);
    let zero = vec2<f32>(0.0);
    let force = select(max(stiffness * rate, -elastic), zero, elastic <= zero);
    // The same rate along the directions of the last step, from Λ² there.
    let along = rate * step.span;
    let now = 1.0 + k.stretch;
    let moved = vec2<f32>(dot(warp, warp), dot(weft, weft)) * (step.span * step.span);
    let last = sqrt(max(now * now - 2.0 * now * along + moved, vec2<f32>(1e-12)));
    return Viscous(force, force * along + before * ((now * along - moved) / last));
}

/// Stands for the strain of a piece of yarn that is broken or absent.
const BROKEN: f32 = -1.0;

fn keep_strains(element: u32, strain: vec2<f32>) {
    let slot = 2u + 2u * (step.index & 1u);
    yarns[slot * scene.elements + element] = strain.x;
    yarns[(slot + 1u) * scene.elements + element] = strain.y;
}

/// Strain of a yarn (0 warp, 1 weft) of an element in the last step.
fn last_strain(element: u32, which: u32) -> f32 {
    return yarns[(2u + 2u * ((step.index + 1u) & 1u) + which) * scene.elements + element];
}

/// Failure strains of an element's yarns. `nominal`: those of the fabric.
fn failure_strain(element: u32, nominal: vec2<f32>) -> vec2<f32> {
    if (!STRENGTH) {
        return nominal;
    }
    return nominal * vec2<f32>(yarns[6u * scene.elements + element], yarns[7u * scene.elements + element]);
}

/// Length of an element along a yarn over the finest.
fn width_along(ply: u32, axis: u32, at: u32) -> f32 {
    if (!GRADED) {
        return 1.0;
    }
    return line_at(ply, axis, at).width;
}

/// What breaks a yarn.
struct Mean {
    /// Mean strain over the elements of the piece of yarn that are whole.
    strain: f32,
    /// 1 where none of them is broken, else 0.
    whole: f32,
}

/// Sums over elements of a piece of yarn: strain times area and area of those that are whole, and 1 where none is broken.
struct Sums {
    strain: f32,
    area: f32,
    whole: f32,
}

/// Elements of a ply along an axis, and which of their ends a mirror plane cuts (1 the first, 2 the last).
struct Axis {
    count: i32,
    cut: u32,
}

fn axis_of(ply: u32, axis: u32) -> Axis {
    let count = i32(select(plies[ply].rows, plies[ply].columns, axis == 0u));
    return Axis(count, select(cut_sides(ply) >> 2u, cut_sides(ply), axis == 0u));
}

/// The element at a place along an axis; past a mirror plane lies the image. Negative: there is none.
fn element_along(a: Axis, at: i32) -> i32 {
    if (at < 0 && (a.cut & 1u) != 0u) {
        return -1 - at;
    }
    if (at >= a.count) {
        return select(-1, 2 * a.count - 1 - at, (a.cut & 2u) != 0u);
    }
    return at;
}

/// Adds an element of the last step. A broken one, slack beside its break, says nothing of the others.
fn add_strain(sums: ptr<function, Sums>, element: u32, which: u32, area: f32) {
    let strain = last_strain(element, which);
    if (strain >= 0.0) {
        (*sums).strain += area * strain;
        (*sums).area += area;
    } else {
        (*sums).whole = 0.0;
    }
}

/// Adds the elements along a yarn that lie within the failure length of the middle of one at a place (row, column).
fn add_along(sums: ptr<function, Sums>, ply: u32, place: vec2<u32>, which: u32, breadth: f32) {
    let reach = select(scene.failure_reach_weft, scene.failure_reach_warp, which == 0u);
    let own = place[1u - which];
    let axis = axis_of(ply, which);
    let half = 0.5 * width_along(ply, which, own);
    add_strain(sums, element_at(ply, place), which, 2.0 * min(half, reach) * breadth);
    for (var side = 0u; side < 2u; side++) {
        var begin = half;
        for (var along = 1; begin < reach; along++) {
            let at = element_along(axis, i32(own) + select(along, -along, side == 0u));
            if (at < 0) {
                break;
            }
            let width = width_along(ply, which, u32(at));
            let next = select(vec2<u32>(u32(at), place.y), vec2<u32>(place.x, u32(at)), which == 0u);
            add_strain(sums, element_at(ply, next), which, min(width, reach - begin) * breadth);
            begin += width;
        }
    }
}

/// The elements side by side in a yarn with one at a place (row, column): the first, and one past the last.
fn side_by_side(ply: u32, place: vec2<u32>, which: u32) -> vec2<u32> {
    let line = line_at(ply, 1u - which, place[which]);
    return vec2<u32>(u32(line.yarn_first), u32(line.yarn_end));
}

/// The place (row, column) so far across the yarn.
fn place_across(place: vec2<u32>, which: u32, at: u32) -> vec2<u32> {
    return select(vec2<u32>(place.x, at), vec2<u32>(at, place.y), which == 0u);
}

/// Of a yarn around an element in the last step, over the failure length along it and all of it across; zeros unless one of the elements side
/// by side reached the failure strain, which they share. They all get the same, so that they break together.
fn mean_strain(element: u32, which: u32, limit: f32) -> Mean {
    let ply = element_ply(element);
    let place = element_place(element);
    let across = side_by_side(ply, place, which);
    var largest = BROKEN;
    for (var at = across.x; at < across.y; at++) {
        largest = max(largest, last_strain(element_at(ply, place_across(place, which, at)), which));
    }
    if (largest < limit) {
        return Mean();
    }
    var sums = Sums(0.0, 0.0, 1.0);
    for (var at = across.x; at < across.y; at++) {
        add_along(&sums, ply, place_across(place, which, at), which, width_along(ply, 1u - which, at));
    }
    return Mean(sums.strain / sums.area, sums.whole);
}

/// Warp and weft of an element in the last step where their piece reached the failure strain; elsewhere zeros.
struct Judged {
    strain: vec2<f32>,
    whole: vec2<f32>,
}

fn judged(element: u32, limit: vec2<f32>) -> Judged {
    let warp = mean_strain(element, 0u, limit.x);
    let weft = mean_strain(element, 1u, limit.y);
    return Judged(vec2<f32>(warp.strain, weft.strain), vec2<f32>(warp.whole, weft.whole));
}

/// Both of a pair.
fn both_of(x: vec2<bool>) -> bool {
    return x.x && x.y;
}

fn any_of(x: vec2<bool>) -> bool {
    return x.x || x.y;
}

/// One element; gives the bits of its residual, or all ones where the residual was not met.
fn element_step(element: u32) -> u32 {
    let e = scene.elements;
    let word = flags[element];
    let was_alive = vec2<bool>((word & 1u) != 0u, (word & 2u) != 0u);
    let both = both_of(was_alive);
    if (!any_of(was_alive)) {
        if (SAMPLED) {
            accounts[3u * e + element] = 0.0;
            accounts[4u * e + element] = 0.0;
            accounts[5u * e + element] = 0.0;
            accounts[6u * e + element] = 0.0;
            accounts[9u * e + element] = 0.0;
        }
        keep_heights(element, vec2<f32>(0.0), Predictor());
        if (WINDOWS) {
            keep_strains(element, vec2<f32>(BROKEN));
        }
        return 0u;
    }
    let at = corners(element);
    let u = differences(0u, at);
    let v = differences(3u, at);
    let size = geometry_of(element);
    let k = kinematics(size, u);
    let warm = predicted(kept_predictor(element), vec2<f32>(heights[4u * e + element], heights[5u * e + element]), stretching(size, k, v));
    let cell = solve(k.stretch, warm, both);

    let zero = vec2<f32>(0.0);
    let nominal = vec2<f32>(scene.warp_failure_strain, scene.weft_failure_strain);
    var limit = nominal;
    var failed = vec2<bool>(false);
    var over_length = Judged();
    if (WINDOWS) {
        limit = failure_strain(element, nominal);
        over_length = judged(element, limit);
        failed = was_alive & (over_length.strain >= limit);
        keep_strains(element, select(vec2<f32>(BROKEN), max(cell.strain, zero), was_alive & !failed));
    } else if (FAILURE) {
        failed = was_alive & (limit <= cell.strain);
    }
    let alive = was_alive & !failed;
    let both_left = both_of(alive);
    let straight = vec2<f32>(straight_strain(yarn(0u), k.stretch.x), straight_strain(yarn(1u), k.stretch.y));
    let free_strain = max(straight, zero);
    let free = tensions(straight);
    let elastic = select(zero, select(free, cell.in_plane, both_left), alive);
    var drag = zero;
    if (VISCOUS) {
        let at_last = vec2<f32>(yarns[element], yarns[e + element]);
        let shock = shock_viscosity(size, k, v, elastic, at_last);
        drag = shock.force;
        keep_viscous(element, drag);
        // N over the element's width times its length.
        accounts[7u * e + element] += dot(shock.work,
            vec2<f32>(0.5 * size.membrane_warp / size.gradient_x, 0.5 * size.membrane_weft / size.gradient_y));
    }
    let pull = elastic + drag;

    var trellis = Shear();
    if (SHEAR) {
        trellis = trellis_shear(k);
    }
    var left = Shear();
    if (both_left) {
        left = trellis;
    }
    let m = membrane(size, k, pull, left);

    // Work done on the element between the last positions and these (trapezoid), and the new forces.
    let power = dot(stored(0u, element) + m.warp, v.x) + dot(stored(3u, element) + m.weft, v.y);
    store(0u, element, m.warp);
    store(3u, element, m.weft);
    accounts[element] += 0.5 * step.span * power;

    let mode = 0.25 * u.mode;
    let stiffness = select(0.0, size.hourglass, both_left);
    if (HOURGLASS) {
        store(6u, element, 0.25 * stiffness * mode);
    }
    keep_heights(element, cell.height, cell.predictor);

    if (FAILURE && any_of(failed)) {
        var was = Shear();
        if (both) {
            was = trellis;
        }
        let before = stored_energy(size, select(zero, cell.tension, was_alive), cell.strain, cell.force, was.energy);
        let after = stored_energy(size, select(zero, free, alive), free_strain, 0.0, 0.0);
        // Forces that break in this step never act, so the last half step's work on them was not done either.
        // Of what acts now only the elastic part changes what is stored.
        let intact = membrane(size, k, select(zero, cell.in_plane, was_alive) + drag, was);
        let undone = dot(intact.warp - m.warp, v.x) + dot(intact.weft - m.weft, v.y);
        accounts[e + element] += before - after - 0.5 * step.span * undone;
        if (HOURGLASS) {
            // The part of the hourglass work that the state function ½k|q|² does not hold once k dropped.
            let lost = select(0.0, size.hourglass, both) - stiffness;
            accounts[2u * e + element] += 0.5 * lost * dot(mode, mode - 0.25 * step.span * v.mode);
        }
        if (LAW_ENERGY && both) {
            // What it has made by now stays.
            let cells = stored_energy(size, select(zero, cell.tension, was_alive), cell.strain, cell.force, 0.0);
            accounts[8u * e + element] = law_share(k.stretch) * cells;
        }
        if (failed.x) { record_failure(element, 0u, cell.strain.x); }
        if (failed.y) { record_failure(element, 1u, cell.strain.y); }
        if (!any_of(alive)) { atomicAdd(&status[counter(ERODED)], 1u); }
    }
    let bits = select(0u, 1u, alive.x) | select(0u, 2u, alive.y);
    flags[element] = (word & 0xffffff00u) + (cell.iterations << 8u) + bits;

    if (SAMPLED) {
        let tension = select(zero, select(free, cell.tension, both_left), alive);
        let strain = select(free_strain, cell.strain, both_left);
        accounts[3u * e + element] = stored_energy(size, tension, strain, select(0.0, cell.force, both_left), left.energy);
        accounts[4u * e + element] = select(0.0, 0.5 * stiffness * dot(mode, mode), HOURGLASS);
        accounts[5u * e + element] = max(tension.x, tension.y);
        if (LAW_ENERGY && both_left) {
            let cells = stored_energy(size, tension, strain, select(0.0, cell.force, both_left), 0.0);
            accounts[8u * e + element] = law_share(k.stretch) * cells;
        }
        // Tension over breaking load is strain over failure strain.
        var load = select(zero, strain / nominal, alive);
        if (WINDOWS) {
            // A mean over the failure length stands for what is beyond.
            load = max(select(zero, load, load < vec2<f32>(1.0)), over_length.whole * over_length.strain / limit);
        }
        accounts[9u * e + element] = max(load.x, load.y);
        let n = 2u * scene.nodes;
        let z = abs(vec4<f32>(nodes[n + at.x], nodes[n + at.y], nodes[n + at.z], nodes[n + at.w]));
        accounts[6u * e + element] = max(max(z.x, z.y), max(z.z, z.w));
    }
    return select(0xffffffffu, bitcast<u32>(cell.residual), cell.converged || !both);
}

var<workgroup> worst: atomic<u32>;
var<workgroup> open_cells: atomic<u32>;

@compute @workgroup_size(64)
fn element_force(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    shot = shots[group.z];
    let number = invocation(group, groups, local);
    let element = first_element() + number;
    // Also when an earlier step went wrong nobody leaves before the barriers.
    if (number < scene.shot_elements && is_due(element) && step.index <= atomicLoad(&status[counter(BAD_STEP)])) {
        let residual = element_step(element);
        if (residual == 0xffffffffu) {
            atomicAdd(&open_cells, 1u);
        } else if (residual != 0u) {
            atomicMax(&worst, residual);
        }
    }
    workgroupBarrier();
    if (local == 0u) {
        let most = atomicLoad(&worst);
        if (most > atomicLoad(&status[counter(RESIDUAL)])) {
            atomicMax(&status[counter(RESIDUAL)], most);
        }
        let count = atomicLoad(&open_cells);
        if (count > 0u) {
            atomicAdd(&status[counter(UNCONVERGED)], count);
        }
    }
}
