//! Failure and erosion.

use super::*;

/// The case with failure strains for warp and weft.
fn brittle(mut case: Case, limits: [f64; 2]) -> Case {
    case.fabric.warp.failure_strain = limits[0];
    case.fabric.weft.failure_strain = limits[1];
    case
}

fn rigid(mut case: Case) -> Case {
    case.fabric.crossover.compression = None;
    case
}

#[test]
fn straightening_of_crimp_is_not_strain() {
    for law in LAWS {
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
    assert_eq!(pulled(strain), [(0, 0, 0, strain[0]), (0, 0, 1, strain[1])]);
}

#[test]
fn failure_stays_in_its_element() {
    for yarn in 0..2 {
        let mut fabric = bare(uncrimped(case(5, 4)));
        fabric = brittle(fabric, [FAILURE_STRAIN; 2]);
        let mut patch = Patch::<f64>::new(&fabric);
        // One edge of element (row 1, column 2) moves outwards: 6.5 % there, half of it beside.
        let length = [fabric.pack.element_length_x, fabric.pack.element_length_y][yarn];
        let edge = [[(1, 3), (2, 3)], [(2, 2), (2, 3)]][yarn];
        let mut u = vec![[0.0; 3]; 30];
        for (row, column) in edge {
            u[row * 6 + column][yarn] = 0.065 * length;
        }
        patch.set_displacements(&u);
        let failures = patch.evaluate(0.0).failures;
        assert_eq!(failures.len(), 1, "{failures:?}");
        let (row, column, which, strain) = failures[0];
        assert_eq!((row, column, which), (1, 2, yarn as u8));
        assert!((strain - 0.065).abs() < 1e-14, "{strain}");
        assert_eq!(patch.evaluate(0.0).failures, [], "a yarn fails once");
    }
}

/// Force that the elements put on one side of a patch of one element [N]: right (0) or top (1).
fn side(forces: &[Vector], side: usize) -> Vector {
    let [p, q] = [[1, 3], [2, 3]][side];
    [0, 1, 2].map(|a| forces[p][a] + forces[q][a])
}

#[test]
fn a_failed_yarn_and_the_shear_of_its_element_are_gone_for_good() {
    for law in LAWS {
        for dead in 0..2 {
            let mut limits = [1.0; 2];
            limits[dead] = 0.01;
            let case = brittle(with_law(case(1, 1), law), limits);
            let left = [&case.fabric.weft, &case.fabric.warp][dead].clone();
            let other = 1 - dead;
            let mut patch = Patch::<f64>::new(&case);
            let taut = |t: f64| ([1.0 + 0.04 * t, 0.3 * t, 0.1 * t], [0.2 * t, 1.0 + 0.03 * t, -0.2 * t]);
            let (f1, f2) = taut(1.0);
            patch.deform(f1, f2);
            assert_eq!(patch.evaluate(0.0).failures.len(), 1);
            // Loaded as at the failure, unloaded, loaded again and beyond.
            for t in [1.0, 0.0, 0.5, 1.0, 1.1] {
                let (f1, f2) = taut(t);
                patch.deform(f1, f2);
                let (forces, sums) = patch.solve();
                assert_eq!(sums.failures, []);
                let yarn = [f2, f1][dead];
                let stretch = length(yarn);
                let tension = stiffness(&case, other) * (stretch / (1.0 + left.crimp) - 1.0).max(0.0);
                // One crossover: the side carries one yarn, straight along itself, and nothing across it.
                let pull = side(&forces, other);
                for a in [0, 1, 2] {
                    let expected = -tension * yarn[a] / stretch;
                    let error = pull[a] - expected;
                    assert!(error.abs() < 1e-10 * stiffness(&case, 0), "{law:?} {dead} {t}: {pull:?}");
                }
                let gone = side(&forces, dead);
                let half = [0, 1, 2].map(|a| forces[3][a] - forces[[2, 1][dead]][a]);
                assert!(length(gone) < 1e-11 * stiffness(&case, 0), "{law:?} {dead} {t}: {gone:?}");
                assert!(length(half) < 1e-11 * stiffness(&case, 0), "{law:?} {dead} {t}: {half:?}");
                assert!((sums.max_tension - tension).abs() <= 1e-9 * tension);
                let rest = 2.0 * left.half_span() * (1.0 + left.crimp);
                let stored = 0.5 * tension * tension / stiffness(&case, other) * rest;
                assert!((sums.stored - stored).abs() <= 1e-9 * stored, "{law:?} {dead} {t}: {sums:?} {stored}");
            }
            assert!(!patch.state.alive(0, 0, dead) && patch.state.alive(0, 0, other));
            assert!(patch.state.is_intact(0, 0));
        }
    }
}

#[test]
fn what_failure_releases_is_the_energy_before_less_that_after() {
    let mut random = Random(11);
    for law in LAWS {
        for (limits, count) in [([0.01, 1.0], 6), ([1.0, 0.01], 6), ([0.01, 0.01], 12)] {
            let whole = with_law(unbreakable(case(3, 2)), law);
            let mut intact = Patch::<f64>::new(&whole);
            let mut broken = Patch::<f64>::new(&brittle(whole, limits));
            let u = rough(&intact, [1.04, 0.3, 0.1], [0.2, 1.05, 0.0], 0.01 * CELL, &mut random);
            intact.set_displacements(&u);
            broken.set_displacements(&u);
            let (before, after) = (intact.evaluate(0.0), broken.evaluate(0.0));
            assert_eq!(after.failures.len(), count);
            let expected = [before.stored - after.stored, before.hourglass - after.hourglass];
            for (got, expected) in after.released.iter().zip(expected) {
                assert!(expected > 0.0 && (got / expected - 1.0).abs() < 1e-12, "{law:?} {got} {expected}");
            }
            // What is left is all there is: evaluating again releases nothing and finds the same, forces included.
            let forces = broken.forces();
            let again = broken.evaluate(0.0);
            if count == 6 {
                assert!(difference(&forces, &broken.forces()) < 1e-14);
            }
            assert_eq!((again.released, again.failures), ([0.0; 2], vec![]));
            assert!((again.stored - after.stored).abs() <= 1e-14 * before.stored);
        }
    }
}

/// Stored energy + work − release = stored energy, through a step in which a yarn fails: exact but for the
/// trapezium rule on the forces, third order in the step.
#[test]
fn the_books_close_over_the_step_of_a_failure() {
    let mut random = Random(12);
    for law in [Law::Variational] {
        for limits in [[0.02, 1.0], [1.0, 0.01], [0.02, 0.01]] {
            let mut case = with_law(unbreakable(case(3, 2)), law);
            case.solver.hourglass = 0.3;
            let mut patch = Patch::<f64>::new(&case);
            let u = rough(&patch, [1.05, 0.3, 0.1], [0.2, 1.06, 0.0], 0.01 * CELL, &mut random);
            patch.set_displacements(&u);
            let before = patch.evaluate(0.0);
            let weak = Patch::<f64>::new(&brittle(case, limits));
            patch.model = weak.model;
            let dt = 1e-7;
            let v: Vec<Vector> = u.iter().map(|_| random.vector(2.0)).collect();
            let moved: Vec<Vector> = u.iter().zip(&v).map(|(u, v)| [0, 1, 2].map(|a| u[a] + dt * v[a])).collect();
            patch.set_displacements(&moved);
            patch.set_velocities(&v);
            let after = patch.evaluate(dt);
            assert!(after.failures.len() >= 6, "{after:?}");
            let [held, left] = [&before, &after].map(|sums| sums.stored + sums.hourglass);
            let gap = held + after.work - after.released[0] - after.released[1] - left;
            assert!(gap.abs() < 1e-7 * before.stored, "{law:?} {limits:?}: {gap:e} of {before:?} {after:?}");
            // Hourglass forces are linear: their trapezium work is ½ k (q + q′)·(q′ − q), element by element.
            let expected = hourglass_release(&patch, &u, &moved);
            assert!(expected > 0.0 && (after.released[1] / expected - 1.0).abs() < 1e-9, "{after:?} {expected}");
        }
    }
}

/// ½ k q·q′ over all elements in which a yarn failed.
fn hourglass_release(patch: &Patch<f64>, from: &[Vector], to: &[Vector]) -> f64 {
    let grid = &patch.model.grid;
    let mut sum = 0.0;
    for row in 0..grid.rows {
        for column in 0..grid.columns {
            let at = row * (grid.columns + 1) + column;
            let mode = |u: &[Vector]| {
                let above = at + grid.columns + 1;
                [0, 1, 2].map(|a| 0.25 * (u[at][a] - u[at + 1][a] + u[above + 1][a] - u[above][a]))
            };
            let broken = (0..2).any(|yarn| !patch.state.alive(row, column, yarn));
            let lost = if broken { patch.model.ply_types[0].element.hourglass.iter().sum() } else { 0.0 };
            sum += 0.5 * lost * dot(mode(from), mode(to));
        }
    }
    sum
}

/// `sizes`: how far the nodes fly [m]; `speed`: at most how fast [m/s].
fn assert_dead<S: ripstop::num::scalar::Scalar>(sizes: &[f64], speed: f64) {
    let mut random = Random(13);
    for law in LAWS {
        let mut patch = Patch::<S>::new(&with_law(case(3, 3), law));
        patch.solve();
        patch.kill(1, 1, 0);
        patch.kill(1, 1, 1);
        for yarn in 0..2 {
            for column in 0..3 {
                patch.kill(0, column, yarn);
                patch.kill(2, column, yarn);
            }
            patch.kill(1, 0, yarn);
            patch.kill(1, 2, yarn);
        }
        for size in sizes {
            let wild: Vec<Vector> = (0..16).map(|_| random.vector(*size)).collect();
            patch.set_displacements(&wild);
            let fast: Vec<Vector> = (0..16).map(|_| random.vector(size.min(speed))).collect();
            patch.set_velocities(&fast);
            let sums = patch.evaluate(1e-7);
            let forces = patch.forces();
            assert!(forces.iter().flatten().all(|f| *f == 0.0), "{size:e} {forces:?}");
            let zero = [sums.work, sums.stored, sums.hourglass, sums.released[0], sums.released[1]];
            assert!(zero.iter().all(|e| *e == 0.0), "{size:e} {sums:?}");
            assert_eq!((sums.max_tension, sums.max_deflection), (0.0, 0.0));
            assert_eq!(sums.failures, []);
        }
    }
}

#[test]
fn an_eroded_element_does_nothing_wherever_its_nodes_go() {
    assert_dead::<f64>(&[1e-3, 1.0, 1e6, 1e30, 1e150, 1.7e308], 1e150);
    assert_dead::<f32>(&[1e-3, 1.0, 1e6, 1e15, 1e30, 3.3e38], 1e30);
}

#[test]
fn an_eroded_element_leaves_its_neighbours_as_they_were() {
    let mut random = Random(14);
    let mut patch = Patch::<f64>::new(&unbreakable(case(3, 3)));
    let u = rough(&patch, [1.02, 0.1, 0.0], [0.1, 1.03, 0.0], 0.02 * CELL, &mut random);
    patch.set_displacements(&u);
    // The second time, unit cells are where they stay: what a last step along a tangent rounds off is gone.
    patch.solve();
    let (whole, all) = patch.solve();
    patch.kill(1, 1, 0);
    patch.kill(1, 1, 1);
    let (holed, rest) = patch.solve();
    let mut hole = Patch::<f64>::new(&unbreakable(case(3, 3)));
    for (row, column) in (0..9).map(|n| (n / 3, n % 3)).filter(|at| *at != (1, 1)) {
        hole.kill(row, column, 0);
        hole.kill(row, column, 1);
    }
    hole.set_displacements(&u);
    let (centre, one) = hole.solve();
    let sum: Vec<Vector> = holed.iter().zip(&centre).map(|(a, b)| [a[0] + b[0], a[1] + b[1], a[2] + b[2]]).collect();
    assert!(difference(&sum, &whole) < 1e-13);
    assert!(((one.stored + rest.stored) / all.stored - 1.0).abs() < 1e-13);
    // Corner nodes of the patch touch no other element.
    assert_eq!([holed[0], holed[3], holed[12], holed[15]], [whole[0], whole[3], whole[12], whole[15]]);
}

#[test]
fn a_step_reports_ply_place_yarn_and_strain_of_a_failure_and_the_erosion_of_its_element() {
    let mut two = brittle(bare(uncrimped(case(5, 4))), [FAILURE_STRAIN, 10.0]);
    two.pack.plies = 2;
    let mut both = two.clone();
    both.fabric.weft.failure_strain = FAILURE_STRAIN;
    for (case, yarns) in [(two, vec![0_u8]), (both, vec![0, 1])] {
        let mut patch = Patch::<f64>::new(&case);
        let (lx, ly) = (case.pack.element_length_x, case.pack.element_length_y);
        // Second ply, node rows 5…9: opens element (j = 1, i = 2) by 6.5 % both ways.
        for (row, column, u) in [(6, 3, [lx, 0.0]), (7, 3, [lx, ly]), (7, 2, [0.0, ly])] {
            for a in [0, 1] {
                patch.state.nodes.set(5 + row - 5, a, column, 0.065 * u[a]);
            }
        }
        let mut stepper = Stepper::<f64>::new(&patch.model);
        // The strains of one step break in the next: of the same positions here.
        let mut first = patch.state.clone();
        stepper.step(&patch.model, &mut first, &mut EnergyBalance::default(), true);
        patch.state.elements = first.elements;
        let totals = stepper.step(&patch.model, &mut patch.state, &mut EnergyBalance::default(), true);
        let found: Vec<_> = stepper.failures.iter().map(|f| (f.step, f.ply, f.i, f.j, f.yarn)).collect();
        let expected: Vec<_> = yarns.iter().map(|yarn| (0, 1, 2, 1, *yarn)).collect();
        assert_eq!(found, expected);
        assert!(stepper.failures.iter().all(|f| (f.strain - 0.065).abs() < 1e-14), "{:?}", stepper.failures);
        assert_eq!(totals.eroded, u64::from(yarns.len() == 2));
        assert_eq!(patch.state.is_intact(5, 2), yarns.len() == 1);
    }
}
