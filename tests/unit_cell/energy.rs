//! Work and stored energy of one cell.

use super::*;

/// Energy stored in the cell [J].
fn stored(cell: &Cell<f64>, got: &Solved) -> f64 {
    let yarns: f64 = (0..2)
        .map(|i| {
            let y = &cell.exact.yarn[i];
            got.tension[i] * got.strain[i] * y.half_span * (1.0 + y.crimp)
        })
        .sum();
    yarns + crossover::compression_energy(&cell.exact, got.force)
}

/// Force conjugate to Λ_i, N_i·2w0_i [J].
fn conjugate(cell: &Cell<f64>, got: &Solved) -> [f64; 2] {
    [0, 1].map(|i| got.in_plane[i] * 2.0 * cell.exact.yarn[i].half_span)
}

fn cells(law: CurveLaw) -> Vec<Cell<f64>> {
    let unequal = [yarn(2e4, 6e-4, 0.05), yarn(5e3, 9e-4, 0.02)];
    CROSSOVERS
        .into_iter()
        .flat_map(|c| [s720(law, c), fabric(unequal.clone(), law, 4e-6, c)])
        .map(|f| Cell::new(&f))
        .collect()
}

#[test]
fn in_plane_forces_of_the_conservative_laws_are_derivatives_of_the_energy() {
    let mut random = Random(5);
    for law in [CurveLaw::Variational, CurveLaw::Kawabata] {
        let mut worst = Worst::default();
        for cell in cells(law) {
            let at = |stretch: [f64; 2]| cell.solve_from_rest(stretch);
            for _ in 0..300 {
                let stretch = [random.between(1.0, 1.06), random.between(1.0, 1.06)];
                let got = at(stretch);
                for i in [0, 1] {
                    // Five points: truncation 1e-13, rounding of U over the step 1e-12 of the energy scale.
                    let step = 1e-4;
                    let u = |n: f64| {
                        let mut moved = stretch;
                        moved[i] += n * step;
                        stored(&cell, &at(moved))
                    };
                    if [-2.0, 2.0].iter().any(|n| {
                        let mut moved = stretch;
                        moved[i] += n * step;
                        at(moved).tension.iter().any(|t| *t < 1.0)
                    }) {
                        continue;
                    }
                    let slope = (8.0 * (u(1.0) - u(-1.0)) - (u(2.0) - u(-2.0))) / (12.0 * step);
                    let scale = cell.breaking()[i] * 2.0 * cell.exact.yarn[i].half_span;
                    let error = (slope - conjugate(&cell, &got)[i]) / scale;
                    worst.see(error, || format!("{law:?} {stretch:?} {got:?}"));
                }
            }
        }
        worst.assert_at_most(1e-8);
    }
}

/// Work of the in-plane forces along a straight line of stretch, by Simpson's rule [J]. No yarn may become taut
/// or slack in between: the integrand is smooth and 2000 intervals are exact to 1e-11 of the energy.
fn work(cell: &Cell<f64>, from: [f64; 2], to: [f64; 2]) -> f64 {
    const STEPS: usize = 2000;
    let along = [to[0] - from[0], to[1] - from[1]];
    let term = |n: usize| {
        let t = n as f64 / STEPS as f64;
        let f = conjugate(cell, &cell.solve_from_rest([from[0] + along[0] * t, from[1] + along[1] * t]));
        let weight = if n == 0 || n == STEPS { 1.0 } else { 2.0 + 2.0 * (n % 2) as f64 };
        weight * (f[0] * along[0] + f[1] * along[1])
    };
    (0..=STEPS).map(term).sum::<f64>() / (3.0 * STEPS as f64)
}

/// Work over one round: stretch the warp, then the weft, release the warp, then the weft; over the largest energy.
fn loop_work(cell: &Cell<f64>) -> f64 {
    let corners = [[1.004, 1.004], [1.036, 1.004], [1.036, 1.034], [1.004, 1.034]];
    let round: f64 = (0..4).map(|n| work(cell, corners[n], corners[(n + 1) % 4])).sum();
    round / stored(cell, &cell.solve_from_rest(corners[2]))
}

#[test]
fn a_closed_strain_path_returns_all_work_for_the_conservative_laws() {
    for law in [CurveLaw::Variational, CurveLaw::Kawabata] {
        for cell in cells(law) {
            let lost = loop_work(&cell);
            assert!(lost.abs() < 1e-9, "{law:?}: {lost:e}");
        }
    }
}

/// (18) is not conjugate to the sinusoid: the published law gains or loses a little on every closed
/// path. That is a property of the law; who removes it has changed the law.
#[test]
fn the_published_law_does_not_return_all_work() {
    // Tension as in-plane force: 0.05–0.3 %. Its projection loses a hundredth of that.
    for (law, least, most) in [(CurveLaw::Published, 5e-4, 3e-3), (CurveLaw::Projected, 5e-6, 5e-4)] {
        for compression in CROSSOVERS {
            let lost = loop_work(&Cell::new(&s720(law, compression))).abs();
            eprintln!("{law:?}, compression {}: {:.4} % of the stored energy", compression.is_some(), 100.0 * lost);
            assert!((least..most).contains(&lost), "{law:?}: {lost:e}");
        }
    }
}

#[test]
fn work_from_rest_is_the_stored_energy_for_the_conservative_laws_only() {
    let far = [1.035, 1.03];
    let gap = |cell: &Cell<f64>| work(cell, [1.0; 2], far) / stored(cell, &cell.solve_from_rest(far)) - 1.0;
    for compression in CROSSOVERS {
        for law in [CurveLaw::Variational, CurveLaw::Kawabata] {
            let gap = gap(&Cell::new(&s720(law, compression)));
            assert!(gap.abs() < 1e-9, "{law:?}: {gap:e}");
        }
        let gap = gap(&Cell::new(&s720(CurveLaw::Published, compression)));
        assert!((1e-3..5e-2).contains(&gap.abs()), "{gap:e}");
    }
}
