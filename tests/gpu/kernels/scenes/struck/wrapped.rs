//! Fabric around the nose of a projectile.

use nalgebra::Vector3;
use ripstop::case::Case;
use ripstop::model::Model;
use ripstop::physics::rigid_body::RigidBody;
use ripstop::solver::active_region::ActiveRegion;
use ripstop::solver::node_update::field as node;
use ripstop::solver::projectile_points::fabric_between;
use ripstop::solver::state::State;

use super::super::{Scene, kill, packs, random_elements};
use super::CYLINDER;
use super::torn::{erode_around_a_node, run_on, tear};
use crate::support::Random;

/// Fabric wrapped around the nose, behind the fabric in front of it, a rounding to a step's travel away from it or inside
/// it, at random speeds.
pub(super) fn struck(name: &str, case: Case) -> Scene {
    let model = Model::<f32>::new(&case).unwrap();
    let mut state = State::new(&case, &model);
    if name.contains("resting") {
        state.active.fill(ActiveRegion::nothing());
    } else {
        state.reach_everything(&model);
    }
    let mut random = Random(name.len() as u64);
    let mut body = model.projectile.clone().unwrap();
    let touching = name.contains("exactly");
    let speed = body.velocity.norm();
    if !touching {
        state.step = 40;
        body.velocity *= 0.9;
        body.velocity.x -= 3.0;
        let inside = if matches!(case.projectile.as_ref().map(|p| p.shape), Some(CYLINDER)) { 0.8e-3 } else { 1.5e-3 };
        body.position.z += if name.contains("away") { 0.0 } else { inside };
        if name == "sphere" {
            // Its fixed-point position carries within the first step.
            body.position.z = (body.position.z * 1024.0).round() / 1024.0 - 5e-6;
        }
        kill(&model, &mut state, &mut random, 0.3);
        if name == "sphere" {
            erode_around_a_node(&model, &mut state);
        }
        if name.contains(" on ") {
            packs::astray(&model, &mut state, &mut random);
        }
        run_on(&model, &mut state, &body, name);
        random_elements(&model, &mut state, &mut random, 0.2);
    }
    tear(&model, &mut state, &body, name);
    place_nodes(&model, &mut state, &mut random, &body, speed, name);
    state.body = Some(body);
    let held = name.contains("clamped") || name.contains("held plies");
    Scene { name: name.to_owned(), model, state, elements: false, pack: false, held, speed }
}

/// Lays the nodes around a body, and gives them velocities by its speed at the start [m/s].
fn place_nodes(
    model: &Model<f32>,
    state: &mut State<f32>,
    random: &mut Random,
    body: &RigidBody,
    speed: f64,
    name: &str,
) {
    let touching = name.contains("exactly");
    for ply in 0..model.grid.plies {
        let mesh = &model.ply_type(ply).mesh;
        for (row, column) in (0..=mesh.rows).flat_map(|row| (0..=mesh.columns).map(move |column| (row, column))) {
            let reference = Vector3::from(model.reference(ply, row, column));
            let mut at = reference;
            if !touching {
                at = wrapped(random, name, body, &reference);
                at.z += fabric_between(model, state, ply, row, column);
            }
            let moved = mesh.to_ply((at - reference).into());
            let inverse = &model.ply_type(ply).row_mass(row).inverse;
            for a in 0..3 {
                // Away from the body as often as towards it.
                let forward = if a == 2 { if name.contains("flap") { 1.5 } else { 0.6 } } else { 0.0 };
                // One side is struck and turns the body; the other flies ahead of it until it does.
                let ahead = a == 2 && name.contains("one side") && at.x < body.position.x;
                let forward = if ahead { 0.92 } else { forward };
                let spread = if ahead { 1.0 } else { 40.0 };
                let free = inverse[a][column] > 0.0;
                let v = if free { random.between(-spread, spread) + forward * speed } else { 0.0 };
                let at = model.grid.first_node_row(ply) + row;
                state.nodes.set(at, node::DISPLACEMENT + a, column, moved[a] as f32);
                state.nodes.set(at, node::VELOCITY + a, column, if touching { 0.0 } else { v as f32 });
            }
        }
    }
}

/// Where a node lies on the body, were there no fabric in front of it.
fn wrapped(random: &mut Random, name: &str, body: &RigidBody, reference: &Vector3<f64>) -> Vector3<f64> {
    let mut at = Vector3::new(reference.x, reference.y, 0.0);
    let inside = body.gap(&at).0 < 0.0;
    for _ in 0..30 {
        let (gap, normal) = body.gap(&at);
        let goes = inside && normal.z > 0.2;
        at.z -= if goes { gap / normal.z } else { 0.0 };
    }
    let near = (at - body.position).xy().norm() < 1.5 * body.body.radius;
    if name.contains("edges") && near && random.between(0.0, 1.0) < 0.6 {
        // Where the surface is nearest to a far point is an edge or a corner more often than a face; one in three lies
        // about the axis, where the tip is.
        let across = if random.between(0.0, 1.0) < 0.33 { 0.2 } else { 1.0 };
        let [x, y, z] = random.vector(4.0 * body.body.bounding_radius);
        let far = Vector3::new(across * x, across * y, z);
        at = body.position + body.orientation.transform_vector(&far);
        let (gap, normal) = body.gap(&at);
        at -= normal * gap;
    }
    at += Vector3::from(random.vector(3e-6));
    if name.contains("rim") && random.between(0.0, 1.0) < 0.3 {
        at.z -= 0.5e-3; // hangs behind the face, in its shadow or just beside it
        let arm = at.xy() - body.position.xy();
        if (arm.norm() - body.body.radius).abs() < 0.7e-3 {
            let beside = body.position.xy() + arm * ((body.body.radius + 8e-6) / arm.norm());
            (at.x, at.y) = (beside.x, beside.y);
        }
    }
    at
}
