//! Stretches, rotation, shear: rigid motion, trellis, simple shear, linear fields.

use super::*;

#[test]
fn a_rigid_rotation_turns_forces_and_keeps_the_energy() {
    let mut random = Random(1);
    for law in LAWS {
        let mut patch = Patch::<f64>::new(&unbreakable(with_law(case(4, 3), law)));
        for _ in 0..20 {
            let u = rough(&patch, [1.02, 0.1, 0.05], [0.2, 1.01, -0.1], 0.02 * CELL, &mut random);
            patch.set_displacements(&u);
            let (still, energy) = patch.solve();
            let r = rotation(&mut random);
            let shift = random.vector(CELL);
            let reference = patch.reference();
            let turned = |(x, u): (&[f64; 2], &Vector)| {
                let p = turn(&r, [x[0] + u[0], x[1] + u[1], u[2]]);
                [p[0] + shift[0] - x[0], p[1] + shift[1] - x[1], p[2] + shift[2]]
            };
            let u: Vec<Vector> = reference.iter().zip(&u).map(turned).collect();
            patch.set_displacements(&u);
            let (got, after) = patch.solve();
            let expected: Vec<Vector> = still.iter().map(|f| turn(&r, *f)).collect();
            // Stretches are known to 1e-15, strains of 0.01 and more to 1e-13.
            let off = difference(&got, &expected);
            assert!(off < 1e-12, "{law:?}: {off:e}");
            assert!((after.stored / energy.stored - 1.0).abs() < 1e-12, "{law:?} {after:?} {energy:?}");
            assert!((after.hourglass / energy.hourglass - 1.0).abs() < 1e-12, "{law:?} {after:?} {energy:?}");
        }
    }
}

/// Yarns of a trellis sheared by γ, placed symmetrically.
fn trellis(gamma: f64) -> [Vector; 2] {
    let (s, c) = (0.5 * gamma).sin_cos();
    [[c, s, 0.0], [s, c, 0.0]]
}

#[test]
fn a_pure_trellis_stretches_nothing_and_resists_by_the_shear_resultant_alone() {
    // Straight yarns feel every stretch; 8 roundings of EA·Λ are what "nothing" means.
    let straight = uncrimped(case(3, 2));
    let limit = 8.0 * f64::EPSILON * stiffness(&straight, 0);
    let mut without = straight.clone();
    without.fabric = bare(straight.clone()).fabric;
    let mut patch = Patch::<f64>::new(&without);
    for gamma in [-1.2, -0.5, -0.01, 0.001, 0.2, 0.4, 0.7, 1.3] {
        let [f1, f2] = trellis(gamma);
        patch.deform(f1, f2);
        assert!(patch.evaluate(0.0).max_tension <= limit, "{gamma}");
    }
    for law in LAWS {
        let crimped = with_law(case(3, 2), law);
        let shear = ShearConstants::<f64>::new(crimped.fabric.shear.as_ref(), crimped.fabric.thickness);
        let mut patch = Patch::<f64>::new(&crimped);
        let area = crimped.pack.element_length_x * crimped.pack.element_length_y * 6.0;
        for gamma in [-1.2, -0.5, -0.01, 0.001, 0.2, 0.4, 0.7, 1.3] {
            let [f1, f2] = trellis(gamma);
            patch.deform(f1, f2);
            let (forces, sums) = patch.solve();
            // A crimped yarn needs a tension only beyond the rounding of Λ.
            assert!(sums.max_tension <= limit, "{law:?} {gamma}: {}", sums.max_tension);
            // Virtual work of the nodal forces in a further dγ: −q·A (torque per area is q).
            let (s, c) = (0.5 * gamma).sin_cos();
            let rate = |x: &[f64; 2]| [0.5 * (-s * x[0] + c * x[1]), 0.5 * (c * x[0] - s * x[1]), 0.0];
            let torque: f64 = patch.reference().iter().zip(&forces).map(|(x, f)| -dot(*f, rate(x))).sum();
            let expected = shear::resultant(&shear, gamma) * area;
            assert!((torque / expected - 1.0).abs() < 1e-9, "{law:?} {gamma}: {torque} {expected}");
            let stored = shear::energy(&shear, gamma) * area;
            assert!((sums.stored / stored - 1.0).abs() < 1e-9, "{law:?} {gamma}: {sums:?} {stored}");
        }
    }
}

#[test]
fn simple_shear_stretches_the_weft_by_the_root_of_one_plus_tan_squared() {
    let straight = bare(uncrimped(case(3, 2)));
    for yarn in 0..2 {
        let mut one = straight.clone();
        [&mut one.fabric.weft, &mut one.fabric.warp][yarn].present = false;
        let mut patch = Patch::<f64>::new(&one);
        for gamma in [-0.8_f64, 0.01, 0.3, 1.0] {
            // Warp held, weft sheared along it.
            patch.deform([1.0, 0.0, 0.0], [gamma.tan(), 1.0, 0.0]);
            let tension = patch.evaluate(0.0).max_tension;
            let stretch = if yarn == 0 { 1.0 } else { (1.0 + gamma.tan().powi(2)).sqrt() };
            let expected = stiffness(&one, yarn) * (stretch - 1.0);
            assert!((tension - expected).abs() <= 1e-14 * stiffness(&one, yarn), "{yarn} {gamma}: {tension}");
        }
    }
}

#[test]
fn a_linear_field_leaves_interior_nodes_without_force() {
    let mut random = Random(2);
    for law in LAWS {
        let mut patch = Patch::<f64>::new(&unbreakable(with_law(case(6, 5), law)));
        for _ in 0..20 {
            let [a, b] = [random.vector(0.1), random.vector(0.1)];
            patch.deform([1.025 + 0.1 * a[0], a[1], a[2]], [b[0], 1.025 + 0.1 * b[1], b[2]]);
            let (forces, sums) = patch.solve();
            let largest = forces.iter().map(|f| length(*f)).fold(0.0, f64::max);
            assert!(largest > 1.0 && sums.max_tension > 1.0, "{sums:?}");
            for ((row, column), f) in patch.nodes().into_iter().zip(&forces) {
                if (1..5).contains(&row) && (1..6).contains(&column) {
                    // Neighbours differ by roundings of their differences, 1e-16·6 cells, over strains of 1e-3.
                    assert!(length(*f) < 1e-11 * largest, "{law:?} {row} {column} {f:?} of {largest}");
                }
            }
            // The hourglass sees the rounding of displacements only.
            assert!(sums.hourglass < 1e-24 * sums.stored, "{sums:?}");
        }
    }
}

#[test]
fn internal_forces_have_no_resultant_and_no_moment() {
    let mut random = Random(3);
    for law in LAWS {
        let mut patch = Patch::<f64>::new(&unbreakable(with_law(case(4, 3), law)));
        patch.kill(1, 1, 0);
        let u = rough(&patch, [1.02, 0.1, 0.3], [0.3, 1.01, -0.1], 0.05 * CELL, &mut random);
        patch.set_displacements(&u);
        let (forces, _) = patch.solve();
        let largest = forces.iter().map(|f| length(*f)).fold(0.0, f64::max);
        let mut sum = [0.0; 6];
        for ((x, u), f) in patch.reference().iter().zip(&u).zip(&forces) {
            let p = [x[0] + u[0], x[1] + u[1], u[2]];
            for a in [0, 1, 2] {
                let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                sum[a] += f[a];
                sum[3 + a] += (p[b] * f[c] - p[c] * f[b]) / CELL;
            }
        }
        assert!(sum.iter().all(|s| s.abs() < 1e-12 * largest), "{law:?}: {sum:?} of {largest}");
    }
}

#[test]
fn the_largest_deflection_is_that_of_any_corner_to_either_side() {
    let mut patch = Patch::<f64>::new(&unbreakable(case(1, 1)));
    for corner in 0..4 {
        for side in [1e-4, -1e-4] {
            let mut u = vec![[0.0, 0.0, 2e-5]; 4];
            u[corner][2] = side;
            patch.set_displacements(&u);
            assert_eq!(patch.evaluate(0.0).max_deflection, 1e-4, "{corner} {side}");
        }
    }
}
