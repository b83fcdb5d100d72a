//! The element: kinematics, forces, energies and failure of small patches.
//!
//! Promised: forces turn with the fabric and are the slope of the energy; a trellis resists by its shear resultant
//! alone; linear fields leave no force inside and no hourglass; a yarn fails by its own strain, at its limit, in its
//! element, for good, and the energy released is what was there; what is dead does nothing; the books close.
//!
//! How it goes red: warp and weft of the patch differ in everything (stiffness, count, crimp, length of the element), so
//! swapped indices and missing factors show at first sight; energies and forces are compared with each other and
//! with closed forms written here. Mutants seen to fail: corner signs of gather and differences, Λ − 1 and sin γ from
//! gradients, shear lever and its guards, the projection of q, factors of force, energy and work, failure by fabric strain or one
//! bit late, shear kept after a failure, wrong release, forces of dead elements.

#![allow(clippy::print_stderr, reason = "the drift of the printed equations is shown with --nocapture")]

mod energy;
mod failure;
mod hourglass;
mod increments;
mod kinematics;
mod robustness;
mod symmetry;

use ripstop::case::{Case, Law, StretchSampling};
use ripstop::kernels::element_force::field as element;
use ripstop::kernels::shear::{self, ShearConstants};
use ripstop::solver::Stepper;
use ripstop::solver::energy_balance::EnergyBalance;

use crate::support::patch::{Patch, Vector, affine, bare, case, difference, dot, length, swapped};
use crate::support::{FAILURE_STRAIN, RUN_LAWS as LAWS, Random, Worst};

/// The case with another law.
fn with_law(mut case: Case, law: Law) -> Case {
    case.fabric.crossover.law = law;
    case
}

/// Straight yarns that do not touch: every strain is a stretch less one, every tension EA times that.
fn uncrimped(case: Case) -> Case {
    let mut case = unbreakable(case);
    for yarn in [&mut case.fabric.warp, &mut case.fabric.weft] {
        yarn.crimp = 0.0;
    }
    case.fabric.crossover.compression = None;
    case
}

/// Yarns that never fail.
fn unbreakable(mut case: Case) -> Case {
    for yarn in [&mut case.fabric.warp, &mut case.fabric.weft] {
        yarn.failure_strain = 10.0;
    }
    case
}

/// Yarns so crimped that they stay slack: only shear and hourglass forces are left.
fn slack(mut case: Case) -> Case {
    for yarn in [&mut case.fabric.warp, &mut case.fabric.weft] {
        yarn.crimp = 0.25;
    }
    case
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

/// Displacements of a patch: uniform deformation and noise of `size` [m] on top.
fn rough(patch: &Patch<f64>, f1: Vector, f2: Vector, size: f64, random: &mut Random) -> Vec<Vector> {
    let noisy = |x: [f64; 2]| {
        let (u, n) = (affine(f1, f2, x), random.vector(size));
        [u[0] + n[0], u[1] + n[1], u[2] + n[2]]
    };
    patch.reference().into_iter().map(noisy).collect()
}

/// One element length, the unit of roughness [m].
const CELL: f64 = 1.27e-3;

/// A square of fabric in a hinged frame of side L, pulled along its diagonal: F = L·C_s/sin(π/4 − γ/2), with C_s the
/// torque per initial area. Frame and fabric do the same work, F·dD = L² C_s dγ, with D = 2L cos(π/4 − γ/2).
#[test]
fn a_picture_frame_measures_the_shear_resultant() {
    const CELLS: usize = 4;
    let mut square = slack(case(CELLS, CELLS));
    square.pack.element_length_y = square.pack.element_length_x;
    let side = CELLS as f64 * square.pack.element_length_x;
    let shear = square.fabric.shear.clone().unwrap();
    let t = square.fabric.thickness;
    // ∫G dγ of (25), by hand: G1, a ramp, G2.
    let torque = |gamma: f64| {
        let ramp = shear.gamma2 - shear.gamma1;
        let into = (gamma - shear.gamma1).clamp(0.0, ramp);
        let past = (gamma - shear.gamma2).max(0.0);
        let rise = shear.g2 - shear.g1;
        t * (shear.g1 * gamma + rise * (0.5 * into * into / ramp + past))
    };
    let mut patch = Patch::<f64>::new(&square);
    for gamma in [0.05, 0.2, 0.35, 0.45, 0.6, 0.8, 1.1] {
        // Sides at ±(π/4 − γ/2) to the x axis, the pulled diagonal; the fabric is clamped along them.
        let half = std::f64::consts::FRAC_PI_4 - 0.5 * gamma;
        patch.deform([half.cos(), -half.sin(), 0.0], [half.cos(), half.sin(), 0.0]);
        let (forces, _) = patch.solve();
        // The frame turns its sides; the corner pulled moves with dD. Nodal forces work on the frame's motion.
        let (da, db) = ([0.5 * half.sin(), 0.5 * half.cos()], [0.5 * half.sin(), -0.5 * half.cos()]);
        let work: f64 = patch
            .reference()
            .iter()
            .zip(&forces)
            .map(|(x, f)| -(f[0] * (da[0] * x[0] + db[0] * x[1]) + f[1] * (da[1] * x[0] + db[1] * x[1])))
            .sum();
        let force = work / (side * half.sin());
        let expected = side * torque(gamma) / half.sin();
        assert!((force / expected - 1.0).abs() < 1e-10, "{gamma}: {force} {expected}");
    }
}

/// Heights are remembered: the next solve starts where the last one ended.
#[test]
fn the_heights_of_the_last_solve_are_kept_for_the_next() {
    let case = unbreakable(case(1, 1));
    let mut patch = Patch::<f64>::new(&case);
    patch.deform([1.03, 0.0, 0.0], [0.0, 1.02, 0.0]);
    let first: f64 = patch.evaluate_rows(0.0).iter().map(|t| t.iterations).sum();
    let heights = [0, 1].map(|i| patch.state.elements.get(0, element::HEIGHT + i, 1));
    assert!(heights.iter().all(|h| *h > 1e-5), "{heights:?}");
    let second: f64 = patch.evaluate_rows(0.0).iter().map(|t| t.iterations).sum();
    assert!(first > 1.0 && second == 1.0, "{first} {second}");
    assert_eq!(heights, [0, 1].map(|i| patch.state.elements.get(0, element::HEIGHT + i, 1)));
}
