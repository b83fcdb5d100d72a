// crossover: equilibrium of warp and weft where they cross, (11)–(24): a bracketed Newton iteration where the fast one fails. Energy that the
// published unit-cell law does not conserve by itself.
// Twin: src/physics/crossover.rs, src/model/unit_cell.rs

const MAX_ITERATIONS: u32 = 80u;
const REFINEMENTS: u32 = 8u;

struct Equilibrium {
    /// T [N], warp and weft.
    tension: vec2<f32>,
    /// In-plane force [N].
    in_plane: vec2<f32>,
    strain: vec2<f32>,
    /// h [m].
    height: vec2<f32>,
    /// Predictor of the heights.
    predictor: Predictor,
    /// F [N].
    force: f32,
    /// Difference of the yarns' contact forces [N].
    residual: f32,
    /// Evaluations of the residual.
    iterations: u32,
    converged: bool,
}

/// Transverse compression d(F) (21), regularised [m], and its derivative [m/N].
fn compression(force: f32) -> vec2<f32> {
    if (!COMPRESSION) { return vec2<f32>(0.0); }
    let sum = max(0.0, force) + scene.compression_offset;
    let root = inverse_cube_root(sum);
    let left = scene.compression_b * root;
    let derivative = left * (1.0 / 3.0) * (root * root * root);
    return select(vec2<f32>(scene.compression_a - left, derivative), vec2<f32>(0.0), force <= 0.0);
}

/// Energy stored in the crossover [J].
fn compression_energy(force: f32) -> f32 {
    if (!COMPRESSION || force <= 0.0) { return 0.0; }
    let a = scene.compression_a;
    let b = scene.compression_b;
    let left = b * inverse_cube_root(max(0.0, force) + scene.compression_offset);
    let d = a - left;
    return b * b * b * (0.5 * (1.0 / (left * left) - 1.0 / (a * a)) - d / (a * a * a));
}

/// The residual and what it is made of at one trial height.
struct CellPoint {
    pivot: YarnResponse,
    other: YarnResponse,
    other_height: f32,
    residual: f32,
    slope: f32,
}

/// End of an iteration.
struct Found {
    /// Height of the pivot [m].
    x: f32,
    best: CellPoint,
    /// Evaluations.
    iterations: u32,
    /// Bound of the error of the responses, where these are tangents [N].
    bound: f32,
    met: bool,
    predictor: Predictor,
}

fn cell_point(stretch: vec2<f32>, x: f32) -> CellPoint {
    let pivot = yarn_response(PIVOT, stretch[PIVOT], x);
    let d = compression(pivot.force);
    let other_height = scene.height_sum - d.x - x;
    let other = yarn_response(1u - PIVOT, stretch[1u - PIVOT], other_height);
    return CellPoint(
        pivot,
        other,
        other_height,
        pivot.force - other.force,
        pivot.stiffness + other.stiffness * (1.0 + d.y * pivot.stiffness));
}

fn slack(point: CellPoint) -> bool { return point.pivot.strain <= 0.0 && point.other.strain <= 0.0; }

/// The residual that counts as met at a contact force [N].
fn accepted(force: f32) -> f32 { return scene.tolerance + 8.0 * EPSILON * abs(force); }

/// Lets the other yarn's height meet the force where the unknown's own resolution is too coarse for it.
fn refine(stretch: vec2<f32>, x: f32, start: CellPoint) -> CellPoint {
    var best = start;
    var trial = start;
    for (var i = 0u; i < REFINEMENTS; i++) {
        let rises = 0.0 < trial.other.stiffness;
        let lost = trial.pivot.strain <= 0.0 && 0.0 < trial.other.force;
        let met = abs(trial.residual) <= accepted(trial.pivot.force) || slack(trial);
        if (met || !rises || !(0.0 < trial.pivot.force || lost)) { break; }
        // No higher than without compression: a slack yarn that is nearly flat hardly rises, and its steps go far beyond.
        trial.other_height = min(trial.other_height + trial.residual / trial.other.stiffness, scene.height_sum - x);
        trial.other = yarn_response(1u - PIVOT, stretch[1u - PIVOT], trial.other_height);
        trial.residual = trial.pivot.force - trial.other.force;
        // The first step may leave a yarn slack, further off than before: the next one brings it back.
        if (abs(trial.residual) < abs(best.residual)) { best = trial; }
    }
    return best;
}

/// Solves the cell by the safeguarded iteration, the pivot's height from `start`, after `before` evaluations.
fn safeguarded(stretch: vec2<f32>, start: f32, before: u32) -> Found {
    let top = scene.height_sum;
    var x = start;
    var low = 0.0;
    var high = top;
    var low_seen = false;
    var high_seen = false;
    var last = 1e30;
    var best = cell_point(stretch, x);
    var iterations = before + 1u;
    var unmet = true;
    for (var i = 0u; i < MAX_ITERATIONS; i++) {
        let size = abs(best.residual);
        let resolved = abs(high - low) <= 2.0 * EPSILON * high;
        if (size <= accepted(best.pivot.force) || resolved || slack(best)) {
            unmet = false;
            break;
        }
        let above = 0.0 < best.residual;
        if (above) {
            high = x;
            high_seen = true;
        } else {
            low = x;
            low_seen = true;
        }
        let slow = 0.5 * last < size;
        last = size;
        var newton = x - best.residual / select(1.0, best.slope, 0.0 < best.slope);
        newton = select(newton, select(high, low, above), best.slope <= 0.0);
        let middle = 0.5 * (low + high);
        let below_end = newton <= low;
        let above_end = high <= newton;
        newton = select(newton, select(low, middle, low_seen), below_end);
        newton = select(newton, select(high, middle, high_seen), above_end);
        let unseen = select(select(high, middle, high_seen), select(low, middle, low_seen), above);
        x = select(newton, unseen, slow);
        best = cell_point(stretch, x);
        iterations += 1u;
    }
    return Found(x, refine(stretch, x, best), iterations, 0.0, !unmet, Predictor());
}

/// Strains of yarns that nothing presses [-].
fn straight_strain(stretch: vec2<f32>) -> vec2<f32> { return (stretch - scene.crimp) / (1.0 + scene.crimp); }

/// Tensions of warp and weft at their strains [N].
fn tensions(strain: vec2<f32>) -> vec2<f32> {
    return vec2<f32>(tension_at(0u, strain.x), tension_at(1u, strain.y));
}

/// Solves the cell for the stretches Λ = 1 + `stretch`, from the heights `warm` of the last step. `both`: both yarns
/// are alive and present; elsewhere each straightens freely.
fn solve(stretch: vec2<f32>, warm: vec2<f32>, both: bool) -> Equilibrium {
    let straight = straight_strain(stretch);
    let top = scene.height_sum;
    if (!both || !(0.0 < top)) {
        let tension = tensions(straight);
        return Equilibrium(tension, tension, straight, vec2<f32>(0.0), Predictor(), 0.0, 0.0, 0u, true);
    }
    let start = min(max(vec2<f32>(0.0), vec2<f32>(warm[PIVOT], warm[1u - PIVOT])), vec2<f32>(top));
    var found = coupled_newton(stretch, start);
    if (!found.met) { found = safeguarded(stretch, start.x, found.iterations); }
    let best = found.best;
    var out = Equilibrium(
        vec2<f32>(0.0), vec2<f32>(0.0), vec2<f32>(0.0), vec2<f32>(0.0), found.predictor,
        real_force(best.pivot), abs(real_force(best.pivot) - real_force(best.other)) + found.bound,
        found.iterations, found.met);
    out.height[PIVOT] = found.x;
    out.height[1u - PIVOT] = best.other_height;
    out.strain[PIVOT] = best.pivot.strain;
    out.strain[1u - PIVOT] = best.other.strain;
    out.tension = tensions(out.strain);
    out.in_plane = out.tension * vec2<f32>(
        in_plane_factor(0u, stretch.x, out.height.x),
        in_plane_factor(1u, stretch.y, out.height.y));
    return out;
}

/// Places along each axis of the law's energy.
const LAW_COUNT: u32 = 40u;

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
