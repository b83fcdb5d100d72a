//! Ill-shaped elements and single precision.

use super::*;

/// Collapsed to a line or a point, folded over, warp along weft: forces stay finite, shear keeps a lever.
fn assert_finite<S: ripstop::number::Scalar>() {
    for law in LAWS {
        for shape in [
            ([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
            ([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]),
            ([1.0, 0.0, 0.0], [0.999_999, 1e-6, 0.0]),
            ([0.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
            ([0.01, 0.0, 0.0], [0.005, 0.01, 0.0]),
            ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0]),
            ([-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]),
            ([1.2, 0.0, 0.0], [0.0, 1e-3, 0.0]),
        ] {
            let mut patch = Patch::<S>::new(&with_law(unbreakable(case(2, 2)), law));
            patch.deform(shape.0, shape.1);
            let rows = patch.evaluate_rows(0.0);
            let forces = patch.forces();
            assert!(forces.iter().flatten().all(|f| f.is_finite()), "{law:?} {shape:?}: {forces:?}");
            for row in rows {
                assert!(row.stored.is_finite() && row.hourglass.is_finite(), "{law:?} {shape:?}: {row:?}");
                assert_eq!(row.unconverged, 0, "{law:?} {shape:?}");
            }
        }
    }
}

#[test]
fn collapsed_and_folded_elements_stay_finite_in_double_precision() {
    assert_finite::<f64>();
}

#[test]
fn collapsed_and_folded_elements_stay_finite_in_single_precision() {
    assert_finite::<f32>();
}

#[test]
fn single_precision_forces_are_those_of_double() {
    let mut random = Random(15);
    for law in LAWS {
        let case = with_law(unbreakable(case(4, 3)), law);
        let (mut double, mut single) = (Patch::<f64>::new(&case), Patch::<f32>::new(&case));
        for _ in 0..10 {
            let u = rough(&double, [1.02, 0.1, 0.05], [0.1, 1.02, -0.1], 0.02 * CELL, &mut random);
            double.set_displacements(&u);
            single.set_displacements(&u);
            let (expected, energy) = double.solve();
            let (got, rounded) = single.solve();
            // Displacements of 1e-4 m are rounded to 1e-11 m, or a strain of 1e-8 in 1e-2; shear at 1 GPa likewise.
            let off = difference(&got, &expected);
            assert!(off < 1e-5, "{law:?}: {off:e}");
            assert!((rounded.stored / energy.stored - 1.0).abs() < 1e-5);
        }
    }
}

/// However far it collapses, a slack element resists shear with a lever of no less than 0.3 of its length: the step bound
/// counts on it.
#[test]
fn the_lever_of_shear_is_never_shorter_than_its_floor() {
    let case = slack(case(1, 1));
    let shear = ShearConstants::<f64>::new(case.fabric.shear.as_ref().unwrap(), case.fabric.thickness);
    let mut patch = Patch::<f64>::new(&case);
    let gamma = 0.9_f64;
    for squeeze in [0.9, 0.3, 0.2, 1e-2, 1e-4, 1e-6] {
        patch.deform([squeeze, 0.0, 0.0], [squeeze * gamma.sin(), squeeze * gamma.cos(), 0.0]);
        let (forces, sums) = patch.solve();
        assert_eq!(sums.max_tension, 0.0);
        // |P1| = q/Λ1 on Ly, |P2| = q/Λ2 on Lx; both meet at each corner, across e1 and e2.
        let lever = squeeze.max(0.3);
        let q = shear::resultant(&shear, gamma) / lever;
        let sides = [0.5 * q * case.pack.element_length_y, 0.5 * q * case.pack.element_length_x];
        // At the corner where both pull apart; their directions enclose the angle π/2 + γ.
        let expected = (sides[0].powi(2) + sides[1].powi(2) - 2.0 * sides[0] * sides[1] * gamma.sin()).sqrt();
        // Displacements of a cell are rounded at 1e-19 m, over what is left of the cell.
        let error = length(forces[3]) / expected - 1.0;
        assert!(error.abs() < 1e-14 / squeeze + 1e-12, "{squeeze}: {error:e}");
    }
}
