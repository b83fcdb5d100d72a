//! Ill-shaped elements and single precision.

use ripstop::kernels::element_force::{FOLDED_STRETCH, LONGEST_LEVER};

use super::*;

/// Collapsed to a line or a point, folded over, warp along weft: forces stay finite, shear keeps a lever.
fn assert_finite<S: ripstop::num::scalar::Scalar>() {
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

/// However far it collapses, a slack element resists shear with the slope of an energy that fades with its stretch: the step bound
/// counts on the lever.
#[test]
fn shear_of_a_collapsed_element_fades_and_is_the_slope_of_its_energy() {
    let case = slack(case(1, 1));
    let mut patch = Patch::<f64>::new(&case);
    let gamma = 0.9_f64;
    let mut energy = |squeeze: f64| {
        patch.deform([squeeze, 0.0, 0.0], [squeeze * gamma.sin(), squeeze * gamma.cos(), 0.0]);
        let (forces, sums) = patch.solve();
        assert_eq!(sums.max_tension, 0.0);
        (forces, sums.stored)
    };
    let [lx, ly] = [case.pack.element_length_x, case.pack.element_length_y];
    let whole = energy(0.9).1;
    for squeeze in [0.45, 0.3, 0.2, 0.1, 1e-2, 1e-4] {
        let (forces, stored) = energy(squeeze);
        let part = squeeze / FOLDED_STRETCH;
        let fade = part * part * (3.0 - 2.0 * part);
        assert!((stored / whole - fade * fade).abs() < 1e-12, "{squeeze}: {stored} of {whole}");
        // Work of the corners as the square shrinks, against the energy it gives back.
        let step = 1e-4 * squeeze;
        let slope = (energy(squeeze + step).1 - energy(squeeze - step).1) / (2.0 * step);
        let way = |corner: usize| {
            let [x, y] = [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]][corner];
            [lx * x + ly * y * gamma.sin(), ly * y * gamma.cos(), 0.0]
        };
        let power: f64 = (0..4).map(|c| (0..3).map(|a| forces[c][a] * way(c)[a]).sum::<f64>()).sum();
        assert!((power.abs() / slope.abs() - 1.0).abs() < 1e-5, "{squeeze}: {power} {slope}");
        assert!(fade / squeeze <= LONGEST_LEVER * (1.0 + 1e-12));
    }
}
