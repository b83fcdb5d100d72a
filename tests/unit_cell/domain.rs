//! The whole domain Λ1, Λ2 ∈ [0.5, 1.2]: residuals, growth, energy, and heights predicted for the next step.

use ripstop::physics::coupled_newton::COMPATIBILITY_TOLERANCE;

use super::*;

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
            assert!(
                m.tension <= 1e-13 && m.force <= 5e-11 && m.height <= COMPATIBILITY_TOLERANCE,
                "{law:?} {d:?} {m:?}"
            );
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
