//! Forces and work against the stored energy.

use super::*;

/// Energy of a patch as a function of its displacements [J].
fn energy(patch: &mut Patch<f64>, u: &[Vector]) -> f64 {
    patch.set_displacements(u);
    let sums = patch.evaluate(0.0);
    assert!(sums.failures.is_empty());
    sums.stored + sums.hourglass
}

/// Largest error of the forces against −∂W/∂x by central differences, over the largest force.
fn gradient_error(patch: &mut Patch<f64>, u: &[Vector]) -> f64 {
    patch.set_displacements(u);
    let (forces, _) = patch.solve();
    // Truncation (1e-5)² of the third derivative's scale, rounding 1e-16/1e-5 of the energy.
    let step = 1e-5 * CELL;
    let mut slopes = vec![[0.0; 3]; u.len()];
    for at in 0..u.len() {
        for a in [0, 1, 2] {
            let mut moved = u.to_vec();
            moved[at][a] = u[at][a] + step;
            let plus = energy(patch, &moved);
            moved[at][a] = u[at][a] - step;
            let minus = energy(patch, &moved);
            slopes[at][a] = -(plus - minus) / (2.0 * step);
        }
    }
    patch.set_displacements(u);
    difference(&slopes, &forces)
}

/// Deformations that put the patch into different states.
const STATES: [(&str, Vector, Vector); 6] = [
    ("taut", [1.03, 0.05, 0.1], [-0.02, 1.025, 0.15]),
    ("nearly at rest", [1.004, 0.02, 0.0], [0.01, 1.003, 0.02]),
    ("slack", [0.96, 0.01, 0.02], [-0.03, 0.97, 0.02]),
    ("slack and sheared", [0.85, 0.3, 0.05], [0.35, 0.88, 0.0]),
    ("taut and sheared past locking", [0.96, 0.4, 0.1], [0.4, 0.97, -0.1]),
    ("one yarn straight, the other slack", [1.045, 0.1, 0.1], [-0.1, 0.8, 0.1]),
];

fn conservative() -> Vec<Case> {
    let mut out = Vec::new();
    for law in [Law::Variational] {
        let soft = unbreakable(with_law(case(2, 2), law));
        let mut rigid = soft.clone();
        rigid.fabric.crossover.compression = None;
        let mut coarse = soft.clone();
        coarse.pack.crossovers_per_element = 3;
        coarse.pack.element_length_x *= 3.0;
        coarse.pack.element_length_y *= 3.0;
        out.extend([soft, rigid, coarse]);
    }
    out
}

#[test]
fn forces_are_the_slope_of_the_stored_energy() {
    let mut random = Random(6);
    let mut worst = Worst::default();
    for case in conservative() {
        for (name, f1, f2) in STATES {
            for damage in 0..4 {
                let mut patch = Patch::<f64>::new(&case);
                // Whole; one warp dead; one warp and one weft dead; an element gone and a weft dead.
                let dead: &[(usize, usize, usize)] =
                    [&[][..], &[(0, 0, 0)], &[(0, 1, 0), (1, 0, 1)], &[(0, 0, 0), (0, 0, 1), (1, 1, 1)]][damage];
                for &(row, column, yarn) in dead {
                    patch.kill(row, column, yarn);
                }
                let u = rough(&patch, f1, f2, 2e-3 * case.pack.element_length_x, &mut random);
                let error = gradient_error(&mut patch, &u);
                worst.see(error, || format!("{name}, damage {damage}, {:?}", case.fabric.crossover));
            }
        }
    }
    worst.assert_at_most(5e-7);
}

#[test]
fn forces_of_the_published_law_are_close_to_that_slope_but_not_equal() {
    let mut random = Random(7);
    let mut patch = Patch::<f64>::new(&unbreakable(with_law(case(2, 2), Law::Published)));
    let (_, f1, f2) = STATES[0];
    let u = rough(&patch, f1, f2, 2e-3 * CELL, &mut random);
    let error = gradient_error(&mut patch, &u);
    assert!((1e-4..1e-1).contains(&error), "{error:e}");
}

/// The work of a step is that of the nodal forces through the nodal velocities, by the trapezium rule.
#[test]
fn the_work_of_a_step_is_the_work_of_the_nodal_forces() {
    let mut random = Random(8);
    for law in LAWS {
        let mut quiet = unbreakable(with_law(case(4, 3), law));
        quiet.solver.hourglass = 0.0;
        let mut patch = Patch::<f64>::new(&quiet);
        patch.kill(1, 2, 1);
        let (_, f1, f2) = STATES[0];
        let u = rough(&patch, f1, f2, 0.01 * CELL, &mut random);
        patch.set_displacements(&u);
        let (before, _) = patch.solve();
        let dt = 1e-7;
        let v: Vec<Vector> = u.iter().map(|_| random.vector(20.0)).collect();
        let moved: Vec<Vector> = u.iter().zip(&v).map(|(u, v)| [0, 1, 2].map(|a| u[a] + dt * v[a])).collect();
        patch.set_displacements(&moved);
        patch.set_velocities(&v);
        let sums = patch.evaluate(dt);
        let after = patch.forces();
        let expected: f64 =
            (0..v.len()).map(|n| -0.5 * dt * dot(v[n], [0, 1, 2].map(|a| before[n][a] + after[n][a]))).sum();
        let scale: f64 = (0..v.len()).map(|n| dt * length(v[n]) * length(after[n])).sum();
        assert!((sums.work - expected).abs() < 1e-13 * scale, "{law:?}: {} {expected} of {scale}", sums.work);
        assert!(expected.abs() > 1e-3 * scale);
    }
}
