//! (1)–(10) of the paper as printed, against the total form.

use super::*;

/// How Δε_xy is to be read in (1) and in (7).
#[derive(Clone, Copy, Debug, PartialEq)]
enum Reading {
    /// The engineering increment in both, as LS-DYNA passes it.
    Engineering,
    /// The tensor increment in both.
    Tensor,
    /// Engineering in (1), tensor in (7): the only consistent one.
    Mixed,
}

/// Local components of a deformation gradient given by its columns: x along F1 (upper triangular).
fn local(f1: Vector, f2: Vector) -> [f64; 3] {
    let l1 = length(f1);
    let along = dot(f1, f2) / l1;
    [l1, along, (dot(f2, f2) - along * along).sqrt()]
}

/// Stretches by the paper's update along a path of `steps` steps from the reference state.
fn paper(path: impl Fn(f64) -> (Vector, Vector), steps: u32, reading: Reading) -> [f64; 2] {
    let mut q = [[1.0, 0.0], [0.0, 1.0]];
    let mut total = [1.0, 1.0];
    let mut old = [1.0, 0.0, 1.0];
    for n in 1..=steps {
        let (f1, f2) = path(f64::from(n) / f64::from(steps));
        let new = local(f1, f2);
        // Rate of deformation at mid-step, as an explicit code integrates it: 2(G − I)(G + I)⁻¹, G = F·F_old⁻¹.
        let g = [new[0] / old[0], (new[1] - new[0] / old[0] * old[1]) / old[2], new[2] / old[2]];
        let (ex, ey) = (2.0 * (g[0] - 1.0) / (g[0] + 1.0), 2.0 * (g[2] - 1.0) / (g[2] + 1.0));
        let shear = 4.0 * g[1] / ((g[0] + 1.0) * (g[2] + 1.0));
        old = new;
        let (in_f, in_e) = match reading {
            Reading::Engineering => (shear, shear),
            Reading::Tensor => (0.5 * shear, 0.5 * shear),
            Reading::Mixed => (shear, 0.5 * shear),
        };
        for i in [0, 1] {
            // (1), (3): q = F q.
            q[i] = [(1.0 + ex) * q[i][0] + in_f * q[i][1], (1.0 + ey) * q[i][1]];
            // (4)–(7): the strain along the yarn.
            let angle = q[i][1].atan2(q[i][0]);
            let (s, c) = angle.sin_cos();
            let strain = ex * c * c + ey * s * s + 2.0 * in_e * s * c;
            // (8), (9).
            total[i] *= 1.0 + strain;
        }
    }
    total
}

/// Stretches by the element kernel: tension over EA of straight yarns, one direction at a time.
fn kernel(f1: Vector, f2: Vector) -> [f64; 2] {
    [0, 1].map(|yarn| {
        let mut one = bare(uncrimped(case(1, 1)));
        [&mut one.fabric.weft, &mut one.fabric.warp][yarn].present = false;
        let mut patch = Patch::<f64>::new(&one);
        patch.deform(f1, f2);
        1.0 + patch.evaluate(0.0).max_tension / stiffness(&one, yarn)
    })
}

/// Largest difference of both stretches from the total form.
fn error(path: impl Fn(f64) -> (Vector, Vector) + Copy, steps: u32, reading: Reading) -> f64 {
    let (f1, f2) = path(1.0);
    let (got, exact) = (paper(path, steps, reading), kernel(f1, f2));
    (got[0] - exact[0]).abs().max((got[1] - exact[1]).abs())
}

#[track_caller]
fn assert_first_order(path: impl Fn(f64) -> (Vector, Vector) + Copy, reading: Reading) {
    let errors = [100, 200, 400, 800].map(|steps| error(path, steps, reading));
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((1.9..2.1).contains(&ratio) && pair[0] > 1e-8, "{reading:?} {errors:?}");
    }
}

fn stretching(t: f64) -> (Vector, Vector) {
    ([1.0 + 0.05 * t, 0.0, 0.0], [0.0, 1.0 + 0.08 * t, 0.0])
}

/// Stretch, rotation about an oblique axis and shear together.
fn everything(t: f64) -> (Vector, Vector) {
    let turn = |v: Vector| {
        let (s, c) = (1.2 * t).sin_cos();
        let v = [c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]];
        let (s, c) = (0.7 * t).sin_cos();
        [v[0], c * v[1] - s * v[2], s * v[1] + c * v[2]]
    };
    (turn([1.0 + 0.05 * t, 0.0, 0.0]), turn([0.4 * t, 1.0 + 0.08 * t, 0.0]))
}

#[test]
fn under_pure_stretch_and_rotation_every_reading_converges_to_first_order() {
    let rotating = |t: f64| {
        let (s, c) = (1.2 * t).sin_cos();
        let (a, b) = (1.0 + 0.05 * t, 1.0 + 0.08 * t);
        ([a * c, a * s, 0.0], [-b * s, b * c, 0.0])
    };
    for reading in [Reading::Engineering, Reading::Tensor, Reading::Mixed] {
        assert_first_order(stretching, reading);
        assert_first_order(rotating, reading);
    }
}

#[test]
fn with_shear_only_the_mixed_reading_converges_the_printed_ones_drift() {
    assert_first_order(everything, Reading::Mixed);
    for (reading, least) in [(Reading::Engineering, 0.05), (Reading::Tensor, 0.03)] {
        let drift = [100, 800, 6400].map(|steps| error(everything, steps, reading));
        eprintln!("{reading:?} shear in (1) and (7): the stretch is off by {drift:.4?} in 100, 800, 6400 steps");
        assert!(drift.iter().all(|d| *d > least), "{reading:?} {drift:?}");
        assert!((drift[2] / drift[1] - 1.0).abs() < 0.05, "{reading:?} {drift:?}");
    }
}

#[test]
fn the_total_form_forgets_the_path() {
    // There and back leaves nothing, whatever happened in between.
    let mut patch = Patch::<f64>::new(&bare(uncrimped(case(2, 2))));
    for t in [0.3, 1.0, 0.6, -0.4] {
        let (f1, f2) = everything(t);
        patch.deform(f1, f2);
        patch.evaluate(0.0);
    }
    patch.deform([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let (forces, sums) = patch.solve();
    assert_eq!((sums.max_tension, sums.stored), (0.0, 0.0));
    assert!(forces.iter().flatten().all(|f| *f == 0.0));
}

/// A turn of the whole element about an oblique axis changes nothing in its own axes, in which the paper's increments are taken.
#[test]
fn rigid_rotation_leaves_no_trace_in_the_increments() {
    let tumbling = |t: f64| {
        let angle = 4.0 * std::f64::consts::PI * t;
        let (s, c) = angle.sin_cos();
        let turn = |v: Vector| {
            let v = [c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]];
            [v[0], c * v[1] - s * v[2], s * v[1] + c * v[2]]
        };
        (turn([1.0, 0.0, 0.0]), turn([0.0, 1.0, 0.0]))
    };
    for reading in [Reading::Engineering, Reading::Tensor, Reading::Mixed] {
        let drift = error(tumbling, 1000, reading);
        assert!(drift < 1e-12, "{reading:?}: two turns leave {drift:e}");
    }
}

/// Simple shear to 45°: the weft is √2 long.
#[test]
fn large_shear_drifts_by_what_was_measured() {
    let sheared = |t: f64| ([1.0, 0.0, 0.0], [t, 1.0, 0.0]);
    let [coarse, fine] = [100, 1000].map(|steps| error(sheared, steps, Reading::Mixed));
    eprintln!("simple shear to 45°, consistent reading: {coarse:.2e} in 100 steps, {fine:.2e} in 1000");
    assert!((coarse / fine - 10.0).abs() < 0.2, "first order: {coarse} {fine}");
    assert!((2.4e-4..2.6e-4).contains(&fine), "{fine}");
    for (reading, range) in [(Reading::Engineering, 0.58..0.59), (Reading::Tensor, 0.16..0.17)] {
        let drift = [1000, 10_000].map(|steps| error(sheared, steps, reading));
        eprintln!("the same, {reading:?} shear in (1) and (7): {drift:.4?} in 1000 and 10 000 steps");
        assert!(drift.iter().all(|drift| range.contains(drift)), "{reading:?}: {drift:?}");
    }
}

/// A hundred cycles of stretch by 3 % and shear by 0.3 rad, as a vibrating ply makes them: the total form is back where it was.
#[test]
fn cyclic_straining_drifts_with_every_cycle() {
    const CYCLES: f64 = 100.0;
    let cycling = |t: f64| {
        let phase = 2.0 * std::f64::consts::PI * CYCLES * t;
        let (stretch, shear) = (0.03 * (1.0 - phase.cos()) * 0.5, 0.3 * phase.sin());
        ([1.0 + stretch, 0.0, 0.0], [shear, 1.0 + 0.5 * stretch, 0.0])
    };
    let drift = |cycles: f64, per_cycle: u32| {
        let part = |t: f64| cycling(t * cycles / CYCLES);
        error(part, per_cycle * cycles as u32, Reading::Mixed)
    };
    let [ten, hundred, finer] = [drift(10.0, 200), drift(100.0, 200), drift(100.0, 2000)];
    eprintln!(
        "cycles of 3 % and 0.3 rad, 200 steps each: {ten:.2e} after 10, {hundred:.2e} after 100; 2000 steps each: {finer:.2e}"
    );
    assert!((0.040..0.042).contains(&ten) && (0.49..0.50).contains(&hundred), "{ten} {hundred}");
    assert!(((1.0 + ten).powi(10) / (1.0 + hundred) - 1.0).abs() < 1e-3, "it multiplies: {ten} {hundred}");
    assert!((0.040..0.042).contains(&finer), "a tenth of the step, a tenth of what a cycle adds: {finer}");
    let (f1, f2) = cycling(1.0);
    let exact = kernel(f1, f2);
    assert!(exact.iter().all(|stretch| (stretch - 1.0).abs() < 1e-13), "{exact:?}");
}
