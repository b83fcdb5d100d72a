//! Failure and erosion.
//!
//! Promised: a yarn fails by its own strain, at its limit, in its element, for good; the energy released is what was there; what is
//! dead does nothing; the books close.
//! Red when: failure goes by fabric strain or comes one bit late, shear stays after a failure, the release is wrong, a dead element
//! has forces.

use ripstop::solver::Stepper;
use ripstop::solver::energy_balance::EnergyBalance;

use super::*;
use crate::support::FAILURE_STRAIN;

/// The case with failure strains for warp and weft.
fn brittle(mut case: Case, limits: [f64; 2]) -> Case {
    (case.fabric.warp.failure_strain, case.fabric.weft.failure_strain) = (limits[0], limits[1]);
    case
}

#[test]
fn straightening_of_crimp_is_not_strain() {
    for law in SOLVER_LAWS {
        let mut patch = Patch::<f64>::new(&with_law(rigid(case(3, 2)), law));
        // The weft is slack: the warp straightens, then strains. 5 % of fabric strain is less than 3.5 % of yarn's.
        for stretch in [1.0218, 1.05, 1.057_562] {
            patch.deform([stretch, 0.0, 0.0], [0.0, 0.85, 0.0]);
            assert_eq!(patch.evaluate(0.0).failures, []);
        }
        patch.deform([1.057_564, 0.0, 0.0], [0.0, 0.85, 0.0]);
        let failures = patch.evaluate(0.0).failures;
        let places: Vec<_> = failures.iter().map(|f| (f.0, f.1, f.2)).collect();
        assert_eq!(places, [(0, 0, 0), (0, 1, 0), (0, 2, 0), (1, 0, 0), (1, 1, 0), (1, 2, 0)]);
        assert!(failures.iter().all(|f| f.3 >= FAILURE_STRAIN && f.3 < FAILURE_STRAIN + 2e-6), "{failures:?}");
    }
}

#[test]
fn a_yarn_fails_where_its_strain_reaches_the_limit_and_no_sooner() {
    let pulled = |limits: [f64; 2]| {
        let mut patch = Patch::<f64>::new(&brittle(case(1, 1), limits));
        patch.deform([1.03, 0.1, 0.0], [0.1, 1.04, 0.0]);
        patch.evaluate(0.0).failures
    };
    let strain = [0, 1].map(|yarn| pulled([1e-6, 1e-6])[yarn].3);
    assert!(strain.iter().all(|e| *e > 1e-3), "{strain:?}");
    for yarn in 0..2 {
        let mut limits = [1.0; 2];
        limits[yarn] = strain[yarn];
        assert_eq!(pulled(limits), [(0, 0, yarn as u8, strain[yarn])]);
        limits[yarn] = strain[yarn].next_up();
        assert_eq!(pulled(limits), []);
    }
}

/// One edge of an element moves outwards: 6.5 % there, half of it beside.
#[test]
fn failure_stays_in_its_element_and_a_step_reports_it() {
    let limits = |limits| brittle(bare(uncrimped(case(5, 4))), limits);
    for yarn in 0..2 {
        let fabric = limits([FAILURE_STRAIN; 2]);
        let mut patch = Patch::<f64>::new(&fabric);
        let length = fabric.pack.mesh.length[yarn];
        let mut u = vec![[0.0; 3]; 30];
        for (row, column) in [[(1, 3), (2, 3)], [(2, 2), (2, 3)]][yarn] {
            u[row * 6 + column][yarn] = 0.065 * length;
        }
        patch.set_displacements(&u);
        let failures = patch.evaluate(0.0).failures;
        let (row, column, which, strain) = failures[0];
        assert_eq!((failures.len(), row, column, which), (1, 1, 2, yarn as u8), "{failures:?}");
        assert!((strain - 0.065).abs() < 1e-14, "{strain}");
        assert_eq!(patch.evaluate(0.0).failures, [], "a yarn fails once");
    }
    for (limit, yarns) in [([FAILURE_STRAIN, 10.0], vec![0_u8]), ([FAILURE_STRAIN; 2], vec![0, 1])] {
        let mut case = limits(limit);
        case.pack.plies = 2;
        let mut patch = Patch::<f64>::new(&case);
        let (lx, ly) = (case.pack.mesh.length[0], case.pack.mesh.length[1]);
        // Second ply, node rows 5…9: opens element (j = 1, i = 2) both ways.
        for (row, column, u) in [(6, 3, [lx, 0.0]), (7, 3, [lx, ly]), (7, 2, [0.0, ly])] {
            (0..2).for_each(|a| patch.state.nodes.set(row, a, column, 0.065 * u[a]));
        }
        let mut stepper = Stepper::<f64>::new(&patch.model);
        // The strains of one step break in the next: of the same positions here.
        let mut first = patch.state.clone();
        stepper.step(&patch.model, &mut first, &mut EnergyBalance::default(), true);
        patch.state.elements = first.elements;
        let totals = stepper.step(&patch.model, &mut patch.state, &mut EnergyBalance::default(), true);
        let found: Vec<_> = stepper.failures.iter().map(|f| (f.step, f.ply, f.i, f.j, f.yarn)).collect();
        assert_eq!(found, yarns.iter().map(|yarn| (0, 1, 2, 1, *yarn)).collect::<Vec<_>>());
        assert!(stepper.failures.iter().all(|f| (f.strain - 0.065).abs() < 1e-14), "{:?}", stepper.failures);
        assert_eq!((totals.eroded, patch.state.is_intact(5, 2)), (u64::from(yarns.len() == 2), yarns.len() == 1));
    }
}

#[test]
fn a_failed_yarn_and_the_shear_of_its_element_are_gone_for_good() {
    for (law, dead) in SOLVER_LAWS.into_iter().flat_map(|law| [(law, 0), (law, 1)]) {
        let (other, mut limits) = (1 - dead, [1.0; 2]);
        limits[dead] = 0.01;
        let case = brittle(with_law(case(1, 1), law), limits);
        let left = [&case.fabric.weft, &case.fabric.warp][dead].clone();
        let mut patch = Patch::<f64>::new(&case);
        let taut = |t: f64| [[1.0 + 0.04 * t, 0.3 * t, 0.1 * t], [0.2 * t, 1.0 + 0.03 * t, -0.2 * t]];
        let [f1, f2] = taut(1.0);
        patch.deform(f1, f2);
        assert_eq!(patch.evaluate(0.0).failures.len(), 1);
        // Loaded as at the failure, unloaded, loaded again and beyond.
        for t in [1.0, 0.0, 0.5, 1.0, 1.1] {
            let [f1, f2] = taut(t);
            patch.deform(f1, f2);
            let (forces, sums) = patch.solve();
            assert_eq!(sums.failures, []);
            let (yarn, unit) = ([f2, f1][dead], stiffness(&case, 0));
            let stretch = length(yarn);
            let tension = stiffness(&case, other) * (stretch / (1.0 + left.crimp) - 1.0).max(0.0);
            // One crossover: the side, right (0) or top (1), carries one yarn, straight along itself, and nothing across it.
            let side = |side: usize| add(forces[3], 1.0, forces[[1, 2][side]]);
            let place = format!("{law:?} {dead} {t}: {forces:?}");
            assert!(length(add(side(other), tension / stretch, yarn)) < 1e-10 * unit, "{place}");
            assert!(length(side(dead)) < 1e-11 * unit, "{place}");
            assert!(length(add(forces[3], -1.0, forces[[2, 1][dead]])) < 1e-11 * unit, "{place}");
            assert!((sums.max_tension - tension).abs() <= 1e-9 * tension);
            let rest = 2.0 * left.half_span() * (1.0 + left.crimp);
            let stored = 0.5 * tension * tension / stiffness(&case, other) * rest;
            assert!((sums.stored - stored).abs() <= 1e-9 * stored, "{place}: {sums:?} {stored}");
        }
        assert!(!patch.state.alive(0, 0, dead) && patch.state.alive(0, 0, other) && patch.state.is_intact(0, 0));
    }
}

/// Stored energy + work − release = stored energy, through a step in which yarns fail: exact but for the
/// trapezium rule on the forces, third order in the step.
#[test]
fn the_books_close_over_the_step_of_a_failure() {
    let (mut random, dt) = (Random(12), 1e-7);
    for limits in [[0.02, 1.0], [1.0, 0.01], [0.02, 0.01]] {
        let mut case = unbreakable(case(3, 2));
        case.solver.hourglass = 0.3;
        let mut patch = Patch::<f64>::new(&case);
        let u = rough(&patch, [1.05, 0.3, 0.1], [0.2, 1.06, 0.0], 0.01 * CELL, &mut random);
        patch.set_displacements(&u);
        let before = patch.evaluate(0.0);
        patch.model = Patch::<f64>::new(&brittle(case, limits)).model;
        let v: Vec<Vector> = u.iter().map(|_| random.vector(2.0)).collect();
        let moved: Vec<Vector> = u.iter().zip(&v).map(|(u, v)| add(*u, dt, *v)).collect();
        patch.set_displacements(&moved);
        patch.set_velocities(&v);
        let old = patch.forces();
        let after = patch.evaluate(dt);
        let forces = patch.forces().into_iter().zip(old).map(|(new, old)| add(new, 1.0, old));
        let work: f64 = forces.zip(&v).map(|(f, v)| -0.5 * dt * dot(f, *v)).sum();
        assert!(after.failures.len() >= 6, "{after:?}");
        let [held, left] = [&before, &after].map(|sums| sums.stored + sums.hourglass);
        let gap = held + work - after.released[0] - after.released[1] - left;
        assert!(gap.abs() < 1e-7 * before.stored, "{limits:?}: {gap:e} of {before:?} {after:?}");
        // Hourglass forces are linear: their trapezium work is ½ k (q + q′)·(q′ − q), element by element.
        let grid = patch.model.grid;
        let mut expected = 0.0;
        for (row, column) in (0..grid.rows).flat_map(|row| (0..grid.columns).map(move |column| (row, column))) {
            let at = row * (grid.columns + 1) + column;
            let above = at + grid.columns + 1;
            let mode =
                |u: &[Vector]| [0, 1, 2].map(|a| 0.25 * (u[at][a] - u[at + 1][a] + u[above + 1][a] - u[above][a]));
            if (0..2).any(|yarn| !patch.state.alive(row, column, yarn)) {
                let lost: f64 = patch.model.ply_types[0].element.hourglass.iter().sum();
                expected += 0.5 * lost * dot(mode(&u), mode(&moved));
            }
        }
        assert!(expected > 0.0 && (after.released[1] / expected - 1.0).abs() < 1e-9, "{after:?} {expected}");
    }
}

/// `sizes`: how far the nodes fly [m]; `speed`: at most how fast [m/s].
fn assert_dead<S: Scalar>(sizes: &[f64], speed: f64) {
    let mut random = Random(13);
    let mut patch = Patch::<S>::new(&case(3, 3));
    patch.solve();
    (0..18).for_each(|n| patch.kill(n / 6, n / 2 % 3, n % 2));
    for size in sizes {
        let wild: Vec<Vector> = (0..16).map(|_| random.vector(*size)).collect();
        patch.set_displacements(&wild);
        let fast: Vec<Vector> = (0..16).map(|_| random.vector(size.min(speed))).collect();
        patch.set_velocities(&fast);
        let sums = patch.evaluate(1e-7);
        assert!(patch.forces().iter().flatten().all(|f| *f == 0.0), "{size:e}");
        let Sums { stored, hourglass, released: [warp, weft], max_tension, max_deflection, failures } = sums;
        assert_eq!([stored, hourglass, warp, weft, max_tension, max_deflection], [0.0; 6], "{size:e}");
        assert!(failures.is_empty(), "{size:e} {failures:?}");
    }
}

#[test]
fn an_eroded_element_does_nothing_and_leaves_its_neighbours_as_they_were() {
    assert_dead::<f64>(&[1e-3, 1.0, 1e6, 1e30, 1e150, 1.7e308], 1e150);
    assert_dead::<f32>(&[1e-3, 1.0, 1e6, 1e15, 1e30, 3.3e38], 1e30);
    let mut random = Random(14);
    let mut patch = Patch::<f64>::new(&unbreakable(case(3, 3)));
    let u = rough(&patch, [1.02, 0.1, 0.0], [0.1, 1.03, 0.0], 0.02 * CELL, &mut random);
    patch.set_displacements(&u);
    // The second time, unit cells are where they stay: what a last step along a tangent rounds off is gone.
    patch.solve();
    let (whole, all) = patch.solve();
    (0..2).for_each(|yarn| patch.kill(1, 1, yarn));
    let (holed, rest) = patch.solve();
    let mut hole = Patch::<f64>::new(&unbreakable(case(3, 3)));
    for (row, column) in (0..9).map(|n| (n / 3, n % 3)).filter(|at| *at != (1, 1)) {
        (0..2).for_each(|yarn| hole.kill(row, column, yarn));
    }
    hole.set_displacements(&u);
    let (centre, one) = hole.solve();
    let sum: Vec<Vector> = holed.iter().zip(&centre).map(|(a, b)| add(*a, 1.0, *b)).collect();
    assert!(difference(&sum, &whole) < 1e-13);
    assert!(((one.stored + rest.stored) / all.stored - 1.0).abs() < 1e-13);
    // Corner nodes of the patch touch no other element.
    assert_eq!([holed[0], holed[3], holed[12], holed[15]], [whole[0], whole[3], whole[12], whole[15]]);
}
