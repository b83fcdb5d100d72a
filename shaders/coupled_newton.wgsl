// coupled_newton: the unit cell's fast iteration, Newton on both heights and the compression together, and the predictor of the next heights.
// Twin: src/physics/coupled_newton.rs

const NEWTON_ITERATIONS: u32 = 7u;

/// q = (a − d)/b where the heights sum up to `sum`; a compression that is none but for rounding is none.
fn opening(sum: f32) -> f32 {
    let q = (sum - (scene.height_sum - scene.compression_a)) * scene.compression_per_b;
    let least = scene.compression_uncompressed - 4.0 * EPSILON * scene.height_sum * scene.compression_per_b;
    return select(q, scene.compression_uncompressed, least <= q);
}

/// Height that compatibility leaves the other yarn: H − d − x, where d = a − b q is 0 once the crossover is loose.
fn other_height(x: f32, q: f32) -> f32 {
    let loose = !COMPRESSION || scene.compression_uncompressed <= q;
    return scene.height_sum - select(scene.compression_a - scene.compression_b * q, 0.0, loose) - x;
}

/// Values of the pivot and of the other yarn in the order of warp and weft.
fn in_order(pair: vec2<f32>) -> vec2<f32> { return select(pair.yx, pair, PIVOT == 0u); }

/// Iterates from the heights of the pivot and of the other yarn.
fn coupled_newton(stretch: vec2<f32>, start: vec2<f32>) -> Found {
    let b = select(0.0, scene.compression_b, COMPRESSION);
    let loose = scene.compression_uncompressed;
    var x = start.x;
    var q = max(opening(x + start.y), 0.01 * loose);
    var y = other_height(x, q);
    var pivot = yarn_response(PIVOT, stretch[PIVOT], x);
    var other = yarn_response(1u - PIVOT, stretch[1u - PIVOT], y);
    var iterations = 1u;
    var met = false;
    var bound = 0.0;
    for (var round = 1u; round <= NEWTON_ITERATIONS; round++) {
        let cube = q * q * q;
        // The force that compresses by a − b q, and its compliance.
        let force = select(pivot.force, 1.0 / cube - scene.compression_offset, COMPRESSION);
        let give = b * q * cube * (1.0 / 3.0);
        let sp = max(pivot.stiffness, scene.min_stiffness);
        let so = max(other.stiffness, scene.min_stiffness);
        // How far the heights miss the compression of the pivot's force, but for what that rounds to; and with it what
        // the residual would be, at most.
        let misfit = give * max(abs(pivot.force - force) - scene.roundoff_tolerance, 0.0);
        let off = abs(pivot.force - other.force) + so * misfit;
        // Both yarns slack although the crossover is not compressed: nothing presses.
        let slack = (!COMPRESSION || loose <= q) && pivot.strain <= 0.0 && other.strain <= 0.0;
        let limit = accepted(pivot.force);
        met = (off <= limit && misfit <= 8.0 * EPSILON * scene.height_sum) || slack;
        if (met || round == NEWTON_ITERATIONS) { break; }
        // To the force they have in common, Σ F/S over Σ 1/S, from that of each; one division for all.
        let product = sp * so;
        let soft = give * product;
        let sum = sp + so + soft;
        let inverse = 1.0 / (product * sum);
        let between = other.force - pivot.force;
        let climb_x = so * (between * sp + (force - pivot.force) * soft);
        let climb_y = sp * ((force - other.force) * soft - between * so);
        let next_x = min(max(x + climb_x * inverse, 0.0), scene.height_sum);
        let linear_y = y + climb_y * inverse;
        let next_q = max(opening(next_x + linear_y), 0.3 * q);
        let next_y = other_height(next_x, next_q);
        // What the curves bend away from their tangents over this step: F″h ≤ 3F′ and ε″h ≤ ε′ of a yarn in any law, twice
        // as much for q.
        let rise = vec2<f32>(next_x - x, next_y - y);
        let far_pivot = raised(pivot, rise.x);
        let far_other = raised(other, rise.y);
        let square = rise * rise;
        let bends = !(4.0 * pivot.stiffness * square.x <= limit * x && 4.0 * other.stiffness * square.y <= limit * y);
        let strays = !(pivot.growth * square.x <= 0.5 * EPSILON * x && other.growth * square.y <= 0.5 * EPSILON * y);
        let bends_q = !(4.0 * b * squared(next_q - q) <= 8.0 * EPSILON * scene.height_sum * q);
        let balanced = abs(far_pivot.force - far_other.force) <= limit;
        let taut = 0.0 < min(min(pivot.strain, other.strain), min(far_pivot.strain, far_other.strain))
            && curve_slope(PIVOT, pivot.strain) == curve_slope(PIVOT, far_pivot.strain)
            && curve_slope(1u - PIVOT, other.strain) == curve_slope(1u - PIVOT, far_other.strain);
        x = next_x;
        y = next_y;
        q = next_q;
        if (!(bends || strays || bends_q) && balanced && taut) {
            pivot = far_pivot;
            other = far_other;
            bound = limit;
            met = true;
            break;
        }
        pivot = yarn_response(PIVOT, stretch[PIVOT], x);
        other = yarn_response(1u - PIVOT, stretch[1u - PIVOT], y);
        iterations += 1u;
    }
    var predictor = Predictor();
    if (met) {
        let give = b * q * (q * q * q) * (1.0 / 3.0);
        let slope = max(vec2<f32>(pivot.stiffness, other.stiffness), vec2<f32>(scene.min_stiffness));
        let length = 1.0 + vec2<f32>(stretch[PIVOT], stretch[1u - PIVOT]);
        let secant = vec2<f32>(secant_strain(PIVOT, pivot.strain), secant_strain(1u - PIVOT, other.strain));
        let both = predictor_of(
            vec2<f32>(pivot.strain, other.strain), secant, vec2<f32>(pivot.force, other.force), slope, give, vec2<f32>(x, y), length);
        predictor = Predictor(in_order(both.dh_dstretch), in_order(both.force_share));
    }
    return Found(x, CellPoint(pivot, other, y, pivot.force - other.force, 1.0), iterations, bound, met, predictor);
}

/// Strain below which a yarn is not followed: F/ε is of two numbers that vanish.
const LEAST_STRAIN: f32 = 1e-6;

/// Change of the two heights of a cell with its two stretches, to first order.
struct Predictor {
    /// Fall of a height per stretch at constant contact force [m].
    dh_dstretch: vec2<f32>,
    /// 1/S over 1/S₁ + 1/S₂ + c [-].
    force_share: vec2<f32>,
}

/// Predictor of a cell in equilibrium: strains of its yarns, tensions over the slopes of these, contact forces, their slopes S [N/m], the compliance c of the crossover [m/N],
/// heights [m] and stretches Λ.
fn predictor_of(strain: vec2<f32>, secant: vec2<f32>, force: vec2<f32>, slope: vec2<f32>, give: f32, height: vec2<f32>, length: vec2<f32>) -> Predictor {
    let below = max(secant, vec2<f32>(LEAST_STRAIN)) * slope * length;
    let per_both = 1.0 / (below.x * below.y);
    let per_sum = 1.0 / (give * (slope.x * slope.y) + (slope.x + slope.y));
    let above = force * (1.0 + strain) - height * slope * secant;
    let fall = above * (below.yx * per_both);
    // No number that is not finite passes either.
    let followed = (vec2<f32>(LEAST_STRAIN) < strain) & (abs(fall) < vec2<f32>(1.0));
    return Predictor(select(vec2<f32>(0.0), fall, followed), slope.yx * per_sum);
}

/// Heights after the stretches have grown by `change`.
fn predicted(predictor: Predictor, height: vec2<f32>, change: vec2<f32>) -> vec2<f32> {
    let push = predictor.dh_dstretch.x * change.x + predictor.dh_dstretch.y * change.y;
    return predictor.force_share * push + height - predictor.dh_dstretch * change;
}
