//! Contact that is sampled at the rim of a flat face too, on edges between nodes.

use nalgebra::Vector3;
use ripstop::run::{Precision, Run};
use ripstop::solver::edge_contact::{EdgeConstraint, Rim, SHARED};
use ripstop::solver::projectile_contact;

use super::{cylinder, difference, momentum, point};
use crate::scene::{builtin, run, run_as};

/// The paper's shot on a small ply that never breaks, at 144 m/s.
const UNBROKEN: [&str; 9] = [
    "/projectile/velocity_m_s=144",
    "/fabric/warp/failure_strain=1",
    "/fabric/weft/failure_strain=1",
    "/pack/width_mm=50.8",
    "/pack/height_mm=50.8",
    "/solver/end_time_us=30",
    "/solver/run_until=end_time",
    "/output/profile_times_us=[]",
    "/expect=[]",
];

fn unbroken(more: &[&str]) -> Run {
    run(&builtin("cases/s720-1ply-155.json", &[&UNBROKEN, more].concat()))
}

#[test]
fn a_point_on_an_edge_moves_both_nodes_and_conserves_both_momenta() {
    let mut body = cylinder(&[]);
    body.angular_momentum = Vector3::new(1e-5, -2e-5, 3e-6);
    let nose = 0.02105;
    let at = |x: f64| point([x, 0.001, nose], [0.0, 0.0, 1.0], [1.0, 2.0, 0.0], 4e-5, f64::INFINITY);
    let mut points = vec![at(0.002), at(0.003), point([0.00225, 0.001, nose], [0.0, 0.0, 1.0], [0.0; 3], 1.0, 0.0)];
    points.iter_mut().for_each(|p| p.shared = true);
    let mut rim = Rim::default();
    rim.constraints.push(EdgeConstraint { nodes: [0, 1], weights: [0.75, 0.25] });
    let before = momentum(&body, &points[..2]);
    points.iter_mut().for_each(|p| p.friction = 0.1);
    let totals = projectile_contact::resolve(&mut body, &mut points, &mut rim, 1e-7);
    let after = momentum(&body, &points[..2]);
    assert!((after.0 - before.0).norm() < 1e-15 && (after.1 - before.1).norm() < 1e-17, "{before:?} {after:?}");
    let (near, far) = (points[0].velocity(), points[1].velocity());
    // Impulses as the weights, and what lies on the rim keeps up with it but for its compliance.
    assert!(((far.z / near.z) - 1.0 / 3.0).abs() < 1e-9, "{near} {far}");
    let between = near * 0.75 + far * 0.25;
    let lag = SHARED * (0.75 * 0.75 + 0.25 * 0.25) / 4e-5 * points[2].normal_impulse;
    assert!((between.z - body.twist().at(&points[2].arm).z + lag).abs() < 1e-9, "{between} {lag}");
    assert!(between.x < 1.0 && totals.friction > 0.0 && totals.dissipation > 0.0, "{totals:?}");
    assert_eq!(totals.touching, 1);
}

#[test]
fn a_hit_sampled_at_the_rim_depends_less_on_where_in_a_cell_it_is() {
    let spread = |sampling: &str| {
        let mut ends = [f64::INFINITY, 0.0, f64::INFINITY, 0.0];
        for shift in ["[0, 0]", "[0.635, 0]", "[0, 0.635]", "[0.635, 0.635]", "[0.3175, 0.3175]"] {
            let sets = [format!("/projectile/offset_mm={shift}"), format!("/solver/contact_sampling={sampling}")];
            let run = unbroken(&[&sets[0], &sets[1]]);
            let velocity = run.history.last().unwrap().projectile_velocity;
            let tension = run.history.iter().map(|row| row.balance.max_tension).fold(0.0, f64::max);
            ends = [ends[0].min(velocity), ends[1].max(velocity), ends[2].min(tension), ends[3].max(tension)];
        }
        [ends[1] - ends[0], ends[3] / ends[2] - 1.0]
    };
    let (nodes, rim) = (spread("nodes"), spread("edges"));
    assert!(rim[0] < 0.75 * nodes[0] && rim[1] < 0.9 * nodes[1], "velocity, tension: {nodes:?} {rim:?}");
}

#[test]
fn contact_at_the_rim_closes_the_ledger_and_is_its_own_mirror_image() {
    let rim = "/solver/contact_sampling=edges";
    let (part, whole) = (unbroken(&[rim]), unbroken(&[rim, "/solver/symmetry=\"none\""]));
    assert_eq!((part.planes.copies(), whole.planes.copies()), (4, 1));
    assert!(difference(&part, &whole) < 1e-9, "{}", difference(&part, &whole));
    // It takes more from the projectile than nodes alone do: the face is as wide as it is.
    let slower = |run: &Run| run.history.last().unwrap().projectile_velocity;
    assert!(slower(&part) < slower(&unbroken(&[])) - 0.2);
    let oblique = unbroken(&[rim, "/projectile/obliquity_deg=20", "/projectile/azimuth_deg=30"]);
    for run in [part, whole, oblique] {
        assert!(run.energy_error < 1e-9 && run.momentum_error < 1e-9, "{} {}", run.energy_error, run.momentum_error);
    }
}

#[test]
fn a_rim_across_a_clamped_edge_meets_what_cannot_move() {
    // The face is wider than the ply: its rim crosses edges of elements between two held nodes, and between a held and a free one.
    let scene =
        ["/solver/contact_sampling=edges", "/pack/width_mm=3.81", "/pack/height_mm=6.35", "/projectile/friction=0.3"];
    let aside = ["/projectile/offset_mm=[0.3,-2]", "/projectile/obliquity_deg=10"];
    for more in [&[][..], &aside] {
        for precision in [Precision::F64, Precision::F32] {
            let sets = [&UNBROKEN, &scene[..], more].concat();
            let run = run_as(&builtin("cases/s720-1ply-155.json", &sets), precision, 1);
            let error = if precision == Precision::F64 { 1e-9 } else { 5e-3 };
            assert!(
                run.energy_error < error && run.momentum_error < error,
                "{} {}",
                run.energy_error,
                run.momentum_error
            );
            // It lands on the clamps, or turns about those that it meets.
            assert!(run.history.last().unwrap().projectile_velocity.abs() < 15.0, "the clamps stop it");
        }
    }
    // A drive and the clamps hold both sides of such a point: neither gives way, and the fabric inside is pushed all the same.
    let driven = unbroken(&[&scene[..], &["/projectile/motion=prescribed", "/solver/end_time_us=3"]].concat());
    assert!(driven.energy_error < 1e-9, "{}", driven.energy_error);
    let last = driven.history.last().unwrap();
    assert!(last.deflection > 0.99 * last.projectile_displacement, "{} m", last.deflection);
}
