//! The whole domain Λ1, Λ2 ∈ [0.5, 1.2]: residuals, growth and energy; and yarns with curves.

use ripstop::physics::coupled_newton::COMPATIBILITY_TOLERANCE;

use super::*;

/// The unit cell's equations by other means than the solver's: the complete elliptic integrals come from the
/// arithmetic–geometric mean (the solver sums a Gauss–Kummer series), and an answer is judged by putting it back
/// into (13)–(22) instead of solving again.
mod oracle {
    use super::{Cell, CurveLaw, Scalar, Solved};

    /// Sinusoid at end slope k: s = S/(2w), ds/dk, and ∂S/∂(2w) at fixed height.
    pub(super) struct Sinusoid {
        pub(super) length: f64,
        pub(super) slope: f64,
        pub(super) pull: f64,
    }

    /// E = K·(1 − Σ) and K = π/(2·AGM) at parameter −k², so s = 2E/π, ds/dk = 2(E − K)/(πk), s − k ds/dk = 2K/π.
    pub(super) fn sinusoid(k: f64) -> Sinusoid {
        if k == 0.0 {
            return Sinusoid { length: 1.0, slope: 0.0, pull: 1.0 };
        }
        let (mut a, mut b) = (1.0, k.hypot(1.0));
        let (mut power, mut sum) = (0.5, -0.5 * k * k);
        for _ in 0..8 {
            let c = 0.5 * (a - b);
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
            power *= 2.0;
            sum += power * c * c;
        }
        Sinusoid { length: (1.0 - sum) / a, slope: -sum / (a * k), pull: 1.0 / a }
    }

    /// One yarn at a stretch and a height: strain, contact force over tension, in-plane force over tension.
    pub(super) struct Yarn {
        pub(super) strain: f64,
        pub(super) press: f64,
        pub(super) pull: f64,
    }

    pub(super) fn yarn(law: CurveLaw, half_span: f64, crimp: f64, stretch: f64, height: f64) -> Yarn {
        let w = stretch * half_span;
        let rest = half_span * (1.0 + crimp);
        if law == CurveLaw::Kawabata {
            let leg = w.hypot(height);
            return Yarn { strain: leg / rest - 1.0, press: 2.0 * height / leg, pull: w / leg };
        }
        let k = std::f64::consts::FRAC_PI_2 * height / w;
        let s = sinusoid(k);
        let strain = w * s.length / rest - 1.0;
        let (press, pull) = match law {
            CurveLaw::Published => (2.0 * k / k.hypot(1.0), 1.0),
            _ => (std::f64::consts::PI * s.slope, s.pull),
        };
        Yarn { strain, press, pull }
    }

    /// d(F), (21) regularised [m].
    pub(super) fn compression(a: f64, b: f64, force: f64) -> f64 {
        if a == 0.0 { 0.0 } else { a - b / (force + (b / a).powi(3)).cbrt() }
    }

    /// Distance of a double-precision answer from the physical conditions.
    #[derive(Clone, Copy, Debug, Default)]
    pub(super) struct Misfit {
        /// Tensions and in-plane forces, over the yarn's breaking tension.
        pub(super) tension: f64,
        /// Contact forces of the two yarns against each other and against the answer, over the softer's breaking tension.
        pub(super) force: f64,
        /// Compatibility (22), over the sum of heights.
        pub(super) height: f64,
    }

    /// Puts an answer for two living yarns back into (13)–(22).
    pub(super) fn misfit<R: Scalar>(cell: &Cell<R>, stretch: [f64; 2], got: &Solved) -> Misfit {
        let exact = &cell.exact;
        let breaking = cell.breaking();
        let softer = cell.softer_breaking();
        let mut out = Misfit::default();
        let top = exact.height_sum;
        for i in [0, 1] {
            let y = &exact.yarn[i];
            // Without contact there is nothing to hold a yarn off the plane.
            let height = if top > 0.0 { got.height[i] } else { 0.0 };
            let ideal = yarn(cell.law, y.half_span, y.crimp, stretch[i], height);
            let tension = y.stiffness * ideal.strain.max(0.0);
            let pull = if top > 0.0 { ideal.pull } else { 1.0 };
            for error in [tension - got.tension[i], pull * tension - got.in_plane[i]] {
                out.tension = out.tension.max((error / breaking[i]).abs());
            }
            if top > 0.0 {
                out.force = out.force.max(((ideal.press * tension - got.force) / softer).abs());
            }
        }
        if top > 0.0 {
            let [a, b, _] = exact.compression;
            let sum = got.height[0] + got.height[1] + compression(a, b, got.force);
            out.height = (sum / top - 1.0).abs();
        }
        out
    }
}

fn sound(got: &Solved) -> bool {
    let numbers = [got.tension, got.in_plane, got.strain, got.height, [got.force, got.residual]];
    let finite = numbers.iter().flatten().all(|x| x.is_finite());
    let pulling = [got.tension, got.in_plane].iter().flatten().all(|t| *t >= 0.0);
    finite && pulling && got.force >= 0.0 && got.converged
}

/// Grid of the domain in one precision, each point started from the solution beside it as in a run. `ripple`: what a tension may
/// fall by where it should rise, over the breaking tension.
fn grid<R: Scalar>(law: CurveLaw, compression: Option<Compression>, ripple: f64) -> Vec<(Solved, oracle::Misfit)> {
    const POINTS: usize = 71;
    let cell = Cell::<R>::new(&s720(law, compression));
    let (mut rising, breaking) = (Worst::default(), cell.breaking());
    let mut all: Vec<(Solved, oracle::Misfit)> = Vec::new();
    for (j, i) in (0..POINTS).flat_map(|j| (0..POINTS).map(move |i| (j, i))) {
        let stretch = [i, j].map(|n| 0.5 + 0.7 * n as f64 / (POINTS - 1) as f64);
        let left = (i > 0).then(|| all[all.len() - 1].0);
        let below = (j > 0).then(|| all[all.len() - POINTS].0);
        let got = cell.solve(stretch, left.map_or(cell.rest_heights(), |p| p.height), true);
        let place = || format!("{} {law:?} {compression:?} {stretch:?} {got:?}", R::NAME);
        assert!(sound(&got), "{}", place());
        for earlier in [left, below].into_iter().flatten() {
            (0..2).for_each(|y| rising.see(((earlier.tension[y] - got.tension[y]) / breaking[y]).max(0.0), place));
        }
        all.push((got, oracle::misfit(&cell, stretch, &got)));
    }
    rising.assert_at_most(ripple);
    all
}

#[test]
fn grid_of_the_whole_domain() {
    for (law, compression) in kinds() {
        // The residual accepted, 1e-12 EA, over 2 sin α, for two solutions (double); the roundings of a strain near 1 (single).
        let double = grid::<f64>(law, compression, 3e-10);
        let single = grid::<f32>(law, compression, 1e-5);
        let breaking = S720_STIFFNESS * FAILURE_STRAIN;
        for ((d, m), (s, _)) in double.iter().zip(&single) {
            // Tensions follow from the heights to rounding; heights add up to the misfit accepted.
            let limits = [(m.tension, 1e-13), (m.force, 5e-11), (m.height, COMPATIBILITY_TOLERANCE)];
            assert!(limits.iter().all(|(misfit, limit)| misfit <= limit), "{law:?} {d:?} {m:?}");
            for y in [0, 1] {
                let apart = (d.tension[y] - s.tension[y]).abs().max((d.in_plane[y] - s.in_plane[y]).abs());
                assert!(apart <= 1e-5 * breaking, "{law:?} {compression:?} {d:?} {s:?}");
            }
        }
    }
}

/// A fabric and where to look at it.
#[derive(Clone, Debug)]
struct Probe {
    fabric: Woven,
    stretch: [f64; 2],
    /// Start of the iteration, over the sum of heights.
    warm: [f64; 2],
    /// Further stretch.
    more: f64,
}

fn any_fabric(random: &mut Random) -> Woven {
    let power = |random: &mut Random, low: f64, high: f64| 10_f64.powf(random.between(low, high));
    let crimp = |random: &mut Random| match random.between(0.0, 10.0) as u32 {
        0 => 0.0,
        1..7 => random.between(0.0, 0.25),
        7..9 => power(random, -4.0, -0.6),
        _ => 0.25,
    };
    let stiffness = power(random, 3.0, 5.0);
    let stiffness = [stiffness, stiffness * power(random, -3.0, 3.0)];
    let span = random.between(3e-4, 1e-3);
    let span = [span, span * 3_f64.powf(random.between(-1.0, 1.0))];
    let crimps = [crimp(random), crimp(random)];
    let law = LAWS[random.between(0.0, LAWS.len() as f64) as usize];
    let gap = random.between(-5e-5, 5e-5).max(0.0);
    let soft = random.between(1e-5, 2e-4);
    let soft = Compression { a: soft, b: soft * random.between(0.5, 3.0) };
    let compression = (random.between(0.0, 3.0) > 1.0).then_some(soft);
    fabric([0, 1].map(|i| yarn(stiffness[i], span[i], crimps[i])), law, gap, compression)
}

fn any_probe(random: &mut Random) -> Probe {
    let [low, high] = if random.between(0.0, 1.0) < 0.5 { [0.5, 1.2] } else { [0.95, 1.06] };
    Probe {
        fabric: any_fabric(random),
        stretch: [0, 1].map(|_| random.between(low, high)),
        warm: [0, 1].map(|_| random.between(-0.5, 1.5)),
        more: 10_f64.powf(random.between(-9.0, -1.0)),
    }
}

/// Everything that must hold at one probe in one precision; the tensions there and further out.
fn hold<R: Scalar>(probe: &Probe, ripple: f64) -> Solved {
    let cell = Cell::<R>::new(&probe.fabric);
    let here = cell.solve(probe.stretch, probe.warm.map(|w| w * cell.exact.height_sum), true);
    assert!(sound(&here), "{} {here:?} {probe:?}", R::NAME);
    for grown in 0..2 {
        let mut stretch = probe.stretch;
        stretch[grown] += probe.more;
        let there = cell.solve(stretch, here.height, true);
        assert!(sound(&there), "{} {there:?} {probe:?}", R::NAME);
        for i in [0, 1] {
            let fall = (here.tension[i] - there.tension[i]) / cell.breaking()[i];
            assert!(fall <= ripple, "{} yarn {i} falls {fall:e}: {here:?} {there:?} {probe:?}", R::NAME);
        }
    }
    here
}

#[test]
fn any_fabric_in_either_precision() {
    let mut random = Random(20_060_720);
    for _ in 0..5_000 {
        let probe = any_probe(&mut random);
        let got = hold::<f64>(&probe, 1e-8);
        let cell = Cell::<f64>::new(&probe.fabric);
        let m = oracle::misfit(&cell, probe.stretch, &got);
        // Up to an end slope of 1.5 the arc length is exact; beyond, its twelve terms leave what they leave. A soft
        // crossover turns the rounding of F into 1e-15 m of height, and a taut straight yarn that into a force.
        let steepest = [0, 1].map(|i| got.height[i] / cell.exact.yarn[i].half_span / probe.stretch[i]);
        let exact = steepest.iter().all(|k| std::f64::consts::FRAC_PI_2 * k.abs() <= 1.5);
        let limit = if exact { [1e-9, 1e-7] } else { [1e-5, 1e-5] };
        assert!(m.tension <= limit[0] && m.force <= limit[1] && m.height <= 1e-11, "{m:?} {got:?} {probe:?}");
        // Roundings of a strain, 6e-8, turn into height by the softness of the crossover and back into tension.
        hold::<f32>(&probe, 5e-4);
    }
}

/// Newton from one side of the root only, a rounding at a time, must not use up the iterations.
#[test]
fn roundings_do_not_let_the_iteration_creep() {
    let nearly_straight = [
        (31_686.735_122_676_78, 5e-4, 0.208_536_406_515_824_3),
        (216.314_161_433_585_35, 4.466_083_533_542_356e-4, 3.572_300_402_113_822e-5),
    ];
    let c = cell::<f32>(nearly_straight, CurveLaw::Kawabata, 0.0, None);
    let start = [3.185_016_678_025_338e-4, -5.815_455_311_736_267e-5];
    let got = c.solve([0.996_408_302_935_984_3, 1.008_075_040_568_850_1], start, true);
    assert!(got.converged, "{got:?}");
}

/// Energy stored in the cell [J].
fn stored(cell: &Cell<f64>, got: &Solved) -> f64 {
    let of_yarn =
        |i: usize| got.tension[i] * got.strain[i] * cell.exact.yarn[i].half_span * (1.0 + cell.exact.yarn[i].crimp);
    of_yarn(0) + of_yarn(1) + crossover::compression_energy(&cell.exact, got.force)
}

/// Forces conjugate to Λ, N·2w0 [J].
fn conjugate(cell: &Cell<f64>, got: &Solved) -> [f64; 2] {
    [0, 1].map(|i| got.in_plane[i] * 2.0 * cell.exact.yarn[i].half_span)
}

/// S-720 and an unbalanced fabric with a gap.
fn cells(law: CurveLaw) -> Vec<Cell<f64>> {
    let unequal = [yarn(2e4, 6e-4, 0.05), yarn(5e3, 9e-4, 0.02)];
    let fabrics = CROSSOVERS.into_iter().flat_map(|c| [s720(law, c), fabric(unequal.clone(), law, 4e-6, c)]);
    fabrics.map(|f| Cell::new(&f)).collect()
}

#[test]
fn in_plane_forces_of_the_conservative_laws_are_derivatives_of_the_energy() {
    let (mut random, mut worst) = (Random(5), Worst::default());
    for cell in [CurveLaw::Variational, CurveLaw::Kawabata].into_iter().flat_map(cells) {
        for _ in 0..100 {
            let stretch = [random.between(1.0, 1.06), random.between(1.0, 1.06)];
            let got = cell.solve_from_rest(stretch);
            for i in [0, 1] {
                // Five points: truncation 1e-13, rounding of U over the step 1e-12 of the energy scale.
                let step = 1e-4;
                let at = |n: f64| {
                    let mut moved = stretch;
                    moved[i] += n * step;
                    cell.solve_from_rest(moved)
                };
                if [-2.0, 2.0].iter().any(|n| at(*n).tension.iter().any(|t| *t < 1.0)) {
                    continue; // a yarn becomes slack in between
                }
                let u = |n: f64| stored(&cell, &at(n));
                let slope = (8.0 * (u(1.0) - u(-1.0)) - (u(2.0) - u(-2.0))) / (12.0 * step);
                let scale = cell.breaking()[i] * 2.0 * cell.exact.yarn[i].half_span;
                worst.see((slope - conjugate(&cell, &got)[i]) / scale, || format!("{:?} {stretch:?}", cell.law));
            }
        }
    }
    worst.assert_at_most(1e-8);
}

/// Work of the in-plane forces over one round, over the largest energy: stretch the warp, then the weft, release the warp, then the
/// weft. No yarn becomes slack: the integrand is smooth, and Simpson's rule over 2000 intervals is exact to 1e-11 of the energy.
fn loop_work(cell: &Cell<f64>) -> f64 {
    const STEPS: usize = 2000;
    let corners = [[1.004, 1.004], [1.036, 1.004], [1.036, 1.034], [1.004, 1.034]];
    let side = |n: usize| {
        let (from, to) = (corners[n], corners[(n + 1) % 4]);
        let along = [to[0] - from[0], to[1] - from[1]];
        let term = |n: usize| {
            let t = n as f64 / STEPS as f64;
            let f = conjugate(cell, &cell.solve_from_rest([from[0] + along[0] * t, from[1] + along[1] * t]));
            let weight = if n == 0 || n == STEPS { 1.0 } else { 2.0 + 2.0 * (n % 2) as f64 };
            weight * (f[0] * along[0] + f[1] * along[1])
        };
        (0..=STEPS).map(term).sum::<f64>() / (3.0 * STEPS as f64)
    };
    (0..4).map(side).sum::<f64>() / stored(cell, &cell.solve_from_rest(corners[2]))
}

/// (18) is not conjugate to the sinusoid: the published law gains or loses a little on every closed path, 0.05–0.3 %.
/// A change that removes it has changed the law.
#[test]
fn a_closed_strain_path_returns_all_work_for_the_conservative_laws_only() {
    for (law, range) in
        [(CurveLaw::Variational, 0.0..1e-9), (CurveLaw::Kawabata, 0.0..1e-9), (CurveLaw::Published, 5e-4..3e-3)]
    {
        // The unbalanced fabric is for the conservative laws: it has no measured loss.
        for cell in cells(law).into_iter().step_by(if range.start > 0.0 { 2 } else { 1 }) {
            let lost = loop_work(&cell).abs();
            assert!(range.contains(&lost), "{law:?}: {lost:e}");
        }
    }
}

/// Yarn with a curve of these points of strain and of stress over that of the linear yarn at the last one.
fn curved(points: &[[f64; 2]], (stiffness, half_span, crimp): YarnNumbers) -> Yarn {
    let top = stiffness * points.last().unwrap()[0];
    let curve: Vec<[f64; 2]> = points.iter().map(|[strain, part]| [*strain, part * top]).collect();
    let slopes = curve.windows(2).map(|ends| (ends[1][1] - ends[0][1]) / (ends[1][0] - ends[0][0]));
    let modulus = slopes.fold(0.0, f64::max);
    Yarn { modulus, curve, ..yarn(stiffness, half_span, crimp) }
}

/// Curves that soften, stiffen and do both.
const CURVES: [&[[f64; 2]]; 3] = [
    &[[0.0, 0.0], [0.006, 0.3], [0.015, 0.55], [0.035, 0.8]],
    &[[0.0, 0.0], [0.004, 0.02], [0.012, 0.15], [0.035, 1.0]],
    &[[0.0, 0.0], [0.003, 0.2], [0.007, 0.22], [0.011, 0.6], [0.024, 0.7], [0.035, 1.1]],
];

/// Tensions and contact force by bisection of the warp's height, strains from the elliptic integrals and stresses between points.
fn by_bisection(cell: &Cell<f64>, curves: [&[[f64; 2]]; 2], stretch: [f64; 2]) -> ([f64; 2], f64) {
    let exact = &cell.exact;
    let respond = |i: usize, height: f64| {
        let y = &exact.yarn[i];
        let at = oracle::yarn(cell.law, y.half_span, y.crimp, stretch[i], height);
        let ends =
            curves[i].windows(2).find(|ends| at.strain <= ends[1][0]).unwrap_or(&curves[i][curves[i].len() - 2..]);
        let slope = (ends[1][1] - ends[0][1]) / (ends[1][0] - ends[0][0]);
        let tension = if at.strain > 0.0 { ends[0][1] + slope * (at.strain - ends[0][0]) } else { 0.0 };
        (tension, tension * at.press)
    };
    let [a, b, _] = exact.compression;
    let other = |height: f64| exact.height_sum - oracle::compression(a, b, respond(0, height).1) - height;
    let (mut low, mut high) = (0.0, exact.height_sum);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if respond(0, middle).1 > respond(1, other(middle).max(0.0)).1 { high = middle } else { low = middle }
    }
    let height = 0.5 * (low + high);
    let [warp, weft] = [respond(0, height), respond(1, other(height).max(0.0))];
    ([warp.0, weft.0], warp.1)
}

#[test]
fn yarns_with_curves_are_in_equilibrium_as_an_independent_solve_finds_it() {
    let mut random = Random(7);
    for (law, compression) in kinds() {
        let mut worst = Worst::default();
        for curves in [[0, 0], [0, 1], [1, 2], [2, 2]] {
            let yarns = [0, 1].map(|i: usize| curved(CURVES[curves[i]], S720[i]));
            let points = [0, 1].map(|i: usize| yarns[i].curve.clone());
            let cell = Cell::<f64>::new(&fabric(yarns, law, 0.0, compression));
            for _ in 0..400 {
                let stretch = [0, 1].map(|_| random.between(0.985, 1.055));
                let got = cell.solve_from_rest(stretch);
                let (tension, force) = by_bisection(&cell, [&points[0], &points[1]], stretch);
                let breaking = S720_STIFFNESS * FAILURE_STRAIN;
                assert!(got.converged, "{law:?} {stretch:?}");
                for error in [got.tension[0] - tension[0], got.tension[1] - tension[1], got.force - force] {
                    worst.see(error / breaking, || format!("{law:?} {compression:?} {curves:?} {stretch:?}"));
                }
            }
        }
        worst.assert_at_most(1e-9);
    }
}

/// Points of a straight line whose slope has no rounding.
#[test]
fn a_straight_curve_is_the_modulus_bit_for_bit() {
    let straight = &[[0.0, 0.0], [0.125, 0.25], [0.25, 0.5], [0.5, 1.0]];
    let mut random = Random(8);
    for (law, compression) in kinds() {
        let cell = |yarns| Cell::<f64>::new(&fabric(yarns, law, 0.0, compression));
        let [bent, linear] = [cell(S720.map(|y| curved(straight, y))), cell(S720.map(|(ea, w, c)| yarn(ea, w, c)))];
        assert_eq!(bent.exact.yarn[0].curve.count, 3);
        for _ in 0..200 {
            let stretch = [0, 1].map(|_| random.between(0.985, 1.055));
            let [bent, linear] = [&bent, &linear].map(|cell| cell.solve_from_rest(stretch));
            let of = |got: Solved| (got.tension, got.force, got.height);
            assert_eq!(of(bent), of(linear), "{stretch:?}");
        }
    }
}
