//! The element: kinematics, forces and energies of small patches.
//!
//! Promised: forces turn with the fabric and are the slope of the energy; a trellis resists by its shear resultant
//! alone; linear fields leave no force inside and no hourglass; whatever its shape, an element stays finite.
//! Red when: corner signs of gather and differences, Λ − 1 and sin γ, the shear lever and its guards, the projection of q, or factors
//! of force, energy and work are wrong. Warp and weft of the patch differ in everything (stiffness, count, crimp, length), so
//! swapped indices show at first sight.

mod failure;

use ripstop::case::{Case, Law, StretchSampling};
use ripstop::num::scalar::Scalar;
use ripstop::physics::membrane::{FOLDED_STRETCH, LONGEST_LEVER};

use crate::support::patch::{Patch, Sums, Vector, affine, bare, case, difference, dot, graded, length};
use crate::support::{Random, SOLVER_LAWS, Worst, close};

/// The case with another law.
fn with_law(mut case: Case, law: Law) -> Case {
    case.fabric.crossover.law = law;
    case
}

/// The case with warp and weft changed alike.
fn with_yarns(mut case: Case, change: impl Fn(&mut ripstop::case::Yarn)) -> Case {
    [&mut case.fabric.warp, &mut case.fabric.weft].into_iter().for_each(change);
    case
}

/// Yarns that never fail.
fn unbreakable(case: Case) -> Case {
    with_yarns(case, |yarn| yarn.failure_strain = 10.0)
}

/// Straight yarns that do not touch: every strain is a stretch less one, every tension EA times that.
fn uncrimped(case: Case) -> Case {
    rigid(with_yarns(unbreakable(case), |yarn| yarn.crimp = 0.0))
}

/// Crossovers without compression.
fn rigid(mut case: Case) -> Case {
    case.fabric.crossover.compression = None;
    case
}

/// Yarns so crimped that they stay slack: only shear and hourglass forces are left.
fn slack(case: Case) -> Case {
    with_yarns(case, |yarn| yarn.crimp = 0.25)
}

/// E·A of warp or weft [N].
fn stiffness(case: &Case, yarn: usize) -> f64 {
    let y = [&case.fabric.warp, &case.fabric.weft][yarn];
    y.modulus * y.area(case.fabric.fibre_density)
}

/// Random rotation: columns are where the axes go.
fn rotation(random: &mut Random) -> [Vector; 3] {
    let q: [f64; 4] = std::array::from_fn(|_| random.between(-1.0, 1.0));
    let n = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [w, x, y, z] = q.map(|c| c / n);
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)],
        [2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)],
        [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

fn turn(r: &[Vector; 3], v: Vector) -> Vector {
    [0, 1, 2].map(|a| r[0][a] * v[0] + r[1][a] * v[1] + r[2][a] * v[2])
}

fn add(u: Vector, share: f64, v: Vector) -> Vector {
    [0, 1, 2].map(|a| u[a] + share * v[a])
}

/// Displacements of a patch: uniform deformation and noise of `size` [m] on top.
fn rough(patch: &Patch<f64>, f1: Vector, f2: Vector, size: f64, random: &mut Random) -> Vec<Vector> {
    patch.reference().into_iter().map(|x| add(affine(f1, f2, x), 1.0, random.vector(size))).collect()
}

/// Length of an element, the unit of roughness [m].
const CELL: f64 = 1.27e-3;

#[test]
fn a_rigid_motion_turns_forces_and_keeps_the_energy() {
    let mut random = Random(1);
    for law in SOLVER_LAWS {
        let mut patch = Patch::<f64>::new(&unbreakable(with_law(case(4, 3), law)));
        for _ in 0..10 {
            let u = rough(&patch, [1.02, 0.1, 0.05], [0.2, 1.01, -0.1], 0.02 * CELL, &mut random);
            patch.set_displacements(&u);
            let (still, energy) = patch.solve();
            let (r, shift) = (rotation(&mut random), random.vector(CELL));
            let turned = |(x, u): (&[f64; 2], &Vector)| {
                let p = turn(&r, [x[0] + u[0], x[1] + u[1], u[2]]);
                [p[0] + shift[0] - x[0], p[1] + shift[1] - x[1], p[2] + shift[2]]
            };
            let u: Vec<Vector> = patch.reference().iter().zip(&u).map(turned).collect();
            patch.set_displacements(&u);
            let (got, after) = patch.solve();
            let expected: Vec<Vector> = still.iter().map(|f| turn(&r, *f)).collect();
            // Stretches are known to 1e-15, strains of 0.01 and more to 1e-13.
            assert!(difference(&got, &expected) < 1e-12, "{law:?}");
            close(after.stored, energy.stored, 1e-12);
            close(after.hourglass, energy.hourglass, 1e-12);
        }
    }
}

/// A square of fabric in a hinged frame of side L, pulled along its diagonal: F = L·C_s/sin(π/4 − γ/2), with C_s the
/// torque per initial area. Frame and fabric do the same work, F·dD = L² C_s dγ, with D = 2L cos(π/4 − γ/2). No yarn stretches.
#[test]
fn a_picture_frame_measures_the_shear_resultant() {
    const CELLS: usize = 4;
    let square = |mut case: Case| {
        case.pack.mesh.length[1] = case.pack.mesh.length[0];
        case
    };
    let slack = square(slack(case(CELLS, CELLS)));
    let side = CELLS as f64 * slack.pack.mesh.length[0];
    let (shear, t) = (slack.fabric.shear.clone().unwrap(), slack.fabric.thickness);
    // ∫G dγ of (25), by hand: G1, a ramp, G2; and its integral, the energy per area.
    let (ramp, rise) = (shear.gamma2 - shear.gamma1, shear.g2 - shear.g1);
    let parts = |gamma: f64| ((gamma - shear.gamma1).clamp(0.0, ramp), (gamma - shear.gamma2).max(0.0));
    let torque = |gamma: f64| {
        let (into, past) = parts(gamma);
        t * (shear.g1 * gamma + rise * (0.5 * into * into / ramp + past))
    };
    let energy = |gamma: f64| {
        let (into, past) = parts(gamma);
        t * (0.5 * shear.g1 * gamma * gamma
            + rise * (into.powi(3) / (6.0 * ramp) + 0.5 * ramp * past + 0.5 * past * past))
    };
    // Straight yarns feel every stretch; 8 roundings of EA·Λ are what "nothing" means.
    let straight = square(bare(uncrimped(case(CELLS, CELLS))));
    let limit = 8.0 * f64::EPSILON * stiffness(&straight, 0);
    let (mut patch, mut taut) = (Patch::<f64>::new(&slack), Patch::<f64>::new(&straight));
    for gamma in [0.05, 0.2, 0.35, 0.45, 0.6, 0.8, 1.1] {
        // Sides at ±(π/4 − γ/2) to the x axis, the pulled diagonal; the fabric is clamped along them.
        let half = std::f64::consts::FRAC_PI_4 - 0.5 * gamma;
        let sides = ([half.cos(), -half.sin(), 0.0], [half.cos(), half.sin(), 0.0]);
        patch.deform(sides.0, sides.1);
        let (forces, sums) = patch.solve();
        // The frame turns its sides; the corner pulled moves with dD. Nodal forces work on the frame's motion.
        let (da, db) = ([0.5 * half.sin(), 0.5 * half.cos()], [0.5 * half.sin(), -0.5 * half.cos()]);
        let rate = |x: &[f64; 2]| [da[0] * x[0] + db[0] * x[1], da[1] * x[0] + db[1] * x[1], 0.0];
        let work: f64 = patch.reference().iter().zip(&forces).map(|(x, f)| -dot(*f, rate(x))).sum();
        let (force, expected) = (work / (side * half.sin()), side * torque(gamma) / half.sin());
        assert!((force / expected - 1.0).abs() < 1e-10, "{gamma}: {force} {expected}");
        let stored = side * side * energy(gamma);
        assert!((sums.stored / stored - 1.0).abs() < 1e-9, "{gamma}: {sums:?} {stored}");
        taut.deform(sides.0, sides.1);
        assert!(taut.evaluate(0.0).max_tension <= limit, "{gamma}");
    }
}

#[test]
fn simple_shear_stretches_the_weft_by_the_root_of_one_plus_tan_squared() {
    for yarn in 0..2 {
        let mut one = bare(uncrimped(case(3, 2)));
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
        // The total form forgets the path: there and back leaves nothing.
        patch.deform([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
        let (forces, sums) = patch.solve();
        assert!(sums.max_tension == 0.0 && sums.stored == 0.0 && forces.iter().flatten().all(|f| *f == 0.0));
    }
}

#[test]
fn a_linear_field_leaves_interior_nodes_without_force_and_costs_no_hourglass() {
    let mut random = Random(2);
    for law in SOLVER_LAWS {
        let even = unbreakable(with_law(case(12, 10), law));
        let [mut even, mut graded] = [even.clone(), graded(even)].map(|case| Patch::<f64>::new(&case));
        assert!(graded.model.grid.columns < 11 && graded.model.grid.rows < 9);
        for _ in 0..10 {
            let [a, b] = [random.vector(0.1), random.vector(0.1)];
            let energies = [&mut even, &mut graded].map(|patch| {
                patch.deform([1.025 + 0.1 * a[0], a[1], a[2]], [b[0], 1.025 + 0.1 * b[1], b[2]]);
                let (forces, sums) = patch.solve();
                let largest = forces.iter().map(|f| length(*f)).fold(0.0, f64::max);
                assert!(largest > 1.0 && sums.max_tension > 1.0, "{sums:?}");
                let (rows, columns) = (patch.model.grid.rows, patch.model.grid.columns);
                for ((row, column), f) in patch.nodes().into_iter().zip(&forces) {
                    if (1..rows).contains(&row) && (1..columns).contains(&column) {
                        // Neighbours differ by roundings of their differences, 1e-16·6 cells, over strains of 1e-3.
                        assert!(length(*f) < 1e-11 * largest, "{law:?} {row} {column} {f:?} of {largest}");
                    }
                }
                // The hourglass sees the rounding of displacements only.
                assert!(sums.hourglass < 1e-24 * sums.stored, "{sums:?}");
                sums.stored
            });
            assert!((energies[0] / energies[1] - 1.0).abs() < 1e-12, "{law:?}: {energies:?}");
        }
    }
    // Two fields that differ by a linear one have the same hourglass energy.
    let mut patch = Patch::<f64>::new(&case(4, 3));
    let noise = rough(&patch, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.05 * CELL, &mut random);
    patch.set_displacements(&noise);
    let alone = patch.evaluate(0.0).hourglass;
    let linear = |(x, n): (&[f64; 2], &Vector)| add(affine([0.9, 0.3, -0.2], [0.1, 0.95, 0.3], *x), 1.0, *n);
    let both: Vec<Vector> = patch.reference().iter().zip(&noise).map(linear).collect();
    patch.set_displacements(&both);
    let together = patch.evaluate(0.0).hourglass;
    assert!((together / alone - 1.0).abs() < 1e-13 && alone > 0.0, "{together} {alone}");
}

/// Largest error of the forces against −∂W/∂x by central differences, over the largest force.
fn gradient_error(patch: &mut Patch<f64>, u: &[Vector]) -> f64 {
    let energy = |patch: &mut Patch<f64>, u: &[Vector]| {
        patch.set_displacements(u);
        let sums = patch.evaluate(0.0);
        assert!(sums.failures.is_empty());
        sums.stored + sums.hourglass
    };
    // Truncation (1e-5)² of the third derivative's scale, rounding 1e-16/1e-5 of the energy.
    let step = 1e-5 * CELL;
    let mut slopes = vec![[0.0; 3]; u.len()];
    for (at, a) in (0..u.len()).flat_map(|at| [0, 1, 2].map(|a| (at, a))) {
        let mut moved = u.to_vec();
        moved[at][a] = u[at][a] + step;
        let plus = energy(patch, &moved);
        moved[at][a] = u[at][a] - step;
        slopes[at][a] = -(plus - energy(patch, &moved)) / (2.0 * step);
    }
    patch.set_displacements(u);
    difference(&slopes, &patch.solve().0)
}

/// Deformations that put the patch into different states: taut, nearly at rest, slack, slack and sheared, taut and sheared past
/// locking, one yarn straight and the other slack.
const STATES: [(Vector, Vector); 6] = [
    ([1.03, 0.05, 0.1], [-0.02, 1.025, 0.15]),
    ([1.004, 0.02, 0.0], [0.01, 1.003, 0.02]),
    ([0.96, 0.01, 0.02], [-0.03, 0.97, 0.02]),
    ([0.85, 0.3, 0.05], [0.35, 0.88, 0.0]),
    ([0.96, 0.4, 0.1], [0.4, 0.97, -0.1]),
    ([1.045, 0.1, 0.1], [-0.1, 0.8, 0.1]),
];

#[test]
fn forces_are_the_slope_of_the_stored_energy() {
    let (mut random, mut worst) = (Random(6), Worst::default());
    let soft = unbreakable(case(2, 2));
    let mut coarse = soft.clone();
    coarse.pack.crossovers_per_element = 3;
    coarse.pack.mesh.length[0] *= 3.0;
    coarse.pack.mesh.length[1] *= 3.0;
    let graded = graded(unbreakable(case(6, 5)));
    for case in [soft.clone(), rigid(soft.clone()), coarse, graded] {
        for (f1, f2) in STATES {
            // Whole; one warp dead; one warp and one weft dead; an element gone and a weft dead.
            for dead in [&[][..], &[(0, 0, 0)], &[(0, 1, 0), (1, 0, 1)], &[(0, 0, 0), (0, 0, 1), (1, 1, 1)]] {
                let mut patch = Patch::<f64>::new(&case);
                dead.iter().for_each(|&(row, column, yarn)| patch.kill(row, column, yarn));
                let u = rough(&patch, f1, f2, 2e-3 * case.pack.mesh.length[0], &mut random);
                worst.see(gradient_error(&mut patch, &u), || format!("{f1:?} {f2:?}, dead {dead:?}"));
            }
        }
    }
    worst.assert_at_most(5e-7);
    // Forces of the published law are close to that slope, not equal.
    let mut patch = Patch::<f64>::new(&with_law(soft, Law::Published));
    let u = rough(&patch, STATES[0].0, STATES[0].1, 2e-3 * CELL, &mut random);
    let error = gradient_error(&mut patch, &u);
    assert!((1e-4..1e-1).contains(&error), "{error:e}");
}

/// The one mode that one-point quadrature does not see costs its share of the full-integration stiffness, mean of both in-plane
/// directions: (2/3)(C1 Ly/Lx + C2 Lx/Ly). Where one yarn is left, nothing ties its neighbours together any more.
#[test]
fn the_hourglass_mode_costs_its_share_of_the_full_integration_stiffness() {
    let mut case = slack(case(1, 1));
    // Stretches that are means over the element see the mode, too.
    case.solver.stretch_sampling = StretchSampling::Centre;
    let (lx, ly) = (case.pack.mesh.length[0], case.pack.mesh.length[1]);
    // C_i = EA_i·count of the other yarn.
    let [c1, c2] = [stiffness(&case, 0) * case.fabric.weft.count, stiffness(&case, 1) * case.fabric.warp.count];
    let whole = case.solver.hourglass * 2.0 / 3.0 * (c1 * ly / lx + c2 * lx / ly);
    let (amplitude, sign) = ([2e-5, -1e-5, 3e-5], |x: &[f64; 2]| (x[0] * x[1]).signum());
    for (dead, k) in [(None, whole), (Some(0), 0.0), (Some(1), 0.0)] {
        let mut patch = Patch::<f64>::new(&case);
        dead.into_iter().for_each(|yarn| patch.kill(0, 0, yarn));
        patch.displace(|x| amplitude.map(|a| sign(&x) * a));
        let (forces, sums) = patch.solve();
        let expected = 0.5 * k * dot(amplitude, amplitude);
        assert!((sums.hourglass - expected).abs() <= 1e-12 * expected, "{dead:?}: {sums:?} {expected}");
        assert_eq!(sums.stored, 0.0);
        // The mode is the sum of four corners with weight ¼: each resists with k·a/4.
        for (x, f) in patch.reference().iter().zip(&forces) {
            let off = add(*f, 0.25 * k * sign(x), amplitude);
            assert!(off.iter().all(|f| f.abs() <= 1e-12 * k * CELL), "{dead:?} {x:?} {f:?}");
        }
    }
}

/// Collapsed to a line or a point, folded over, warp along weft: forces stay finite.
fn assert_finite<S: Scalar>() {
    for law in SOLVER_LAWS {
        for (f1, f2) in [
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
            patch.deform(f1, f2);
            let (forces, sums) = patch.solve();
            let finite = forces.iter().flatten().chain([&sums.stored, &sums.hourglass]).all(|f| f.is_finite());
            assert!(finite, "{law:?} {f1:?} {f2:?}: {forces:?} {sums:?}");
        }
    }
}

#[test]
fn collapsed_and_folded_elements_stay_finite() {
    assert_finite::<f64>();
    assert_finite::<f32>();
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
    let [lx, ly] = case.pack.mesh.length;
    let whole = energy(0.9).1;
    for squeeze in [0.45, 0.2, 1e-2, 1e-4] {
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
        let power: f64 = (0..4).map(|corner| dot(forces[corner], way(corner))).sum();
        assert!((power.abs() / slope.abs() - 1.0).abs() < 1e-5, "{squeeze}: {power} {slope}");
        assert!(fade / squeeze <= LONGEST_LEVER * (1.0 + 1e-12));
    }
}
