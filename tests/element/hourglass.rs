//! The one mode that one-point quadrature does not see.

use super::*;

/// Four corners of one element, alternately up and down.
fn mode(patch: &mut Patch<f64>, amplitude: Vector) {
    patch.displace(|x| {
        let sign = if x[0] * x[1] > 0.0 { 1.0 } else { -1.0 };
        amplitude.map(|a| sign * a)
    });
}

/// Stiffness of full integration, mean of both in-plane directions: (2/3)(C1 Ly/Lx + C2 Lx/Ly) [N/m].
fn full(case: &Case) -> f64 {
    let (lx, ly) = (case.pack.element_length_x, case.pack.element_length_y);
    // C_i = EA_i·count of the other yarn.
    let c1 = stiffness(case, 0) * case.fabric.weft.count;
    let c2 = stiffness(case, 1) * case.fabric.warp.count;
    2.0 / 3.0 * (c1 * ly / lx + c2 * lx / ly)
}

/// Stretches at the centre of elements.
fn at_centre(mut case: Case) -> Case {
    case.solver.stretch_sampling = StretchSampling::Centre;
    case
}

#[test]
fn the_mode_costs_its_share_of_the_full_integration_stiffness() {
    // Stretches that are means over the element see the mode, too.
    let case = at_centre(slack(case(1, 1)));
    let whole = case.solver.hourglass * full(&case);
    let amplitude = [2e-5, -1e-5, 3e-5];
    // Where one yarn is left, nothing ties its neighbours together any more.
    for (dead, k) in [(None, whole), (Some(0), 0.0), (Some(1), 0.0)] {
        let mut patch = Patch::<f64>::new(&case);
        if let Some(yarn) = dead {
            patch.kill(0, 0, yarn);
        }
        mode(&mut patch, amplitude);
        let (forces, sums) = patch.solve();
        let expected = 0.5 * k * dot(amplitude, amplitude);
        assert!((sums.hourglass - expected).abs() <= 1e-12 * expected, "{dead:?}: {sums:?} {expected}");
        assert_eq!(sums.stored, 0.0);
        // The mode is the sum of four corners with weight ¼: each resists with k·a/4.
        for (x, f) in patch.reference().iter().zip(&forces) {
            let sign = if x[0] * x[1] > 0.0 { -0.25 } else { 0.25 };
            for a in [0, 1, 2] {
                let expected = sign * k * amplitude[a];
                assert!((f[a] - expected).abs() <= 1e-12 * k * CELL, "{dead:?} {x:?} {f:?} {expected}");
            }
        }
    }
}

#[test]
fn rigid_motion_and_linear_fields_cost_nothing() {
    let mut random = Random(9);
    let mut patch = Patch::<f64>::new(&slack(case(3, 3)));
    for _ in 0..50 {
        let r = rotation(&mut random);
        let squeeze = random.between(0.6, 1.0);
        patch.deform(r[0].map(|x| squeeze * x), r[1]);
        let (forces, sums) = patch.solve();
        // Displacements of a few cells are rounded at 1e-19 m.
        let limit = 1e-18 * full(&case(1, 1));
        assert!(sums.hourglass < 1e-18 * limit, "{sums:?}");
        assert!(forces.iter().all(|f| length(*f) < 20.0 * limit), "{forces:?}");
    }
}

#[test]
fn two_fields_that_differ_by_a_linear_one_have_the_same_hourglass_energy() {
    let mut random = Random(10);
    let mut patch = Patch::<f64>::new(&case(4, 3));
    let noise = rough(&patch, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.05 * CELL, &mut random);
    patch.set_displacements(&noise);
    let alone = patch.evaluate(0.0).hourglass;
    let linear = |(x, n): (&[f64; 2], &Vector)| {
        let u = affine([0.9, 0.3, -0.2], [0.1, 0.95, 0.3], *x);
        [0, 1, 2].map(|a| u[a] + n[a])
    };
    let both: Vec<Vector> = patch.reference().iter().zip(&noise).map(linear).collect();
    patch.set_displacements(&both);
    let together = patch.evaluate(0.0).hourglass;
    assert!((together / alone - 1.0).abs() < 1e-13 && alone > 0.0, "{together} {alone}");
}
