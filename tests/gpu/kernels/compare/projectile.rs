//! Contact with the projectile, and its motion.

use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::{self, status};
use ripstop::gpu::stepper::Stage;
use ripstop::model::Model;
use ripstop::solver::active_region::ActiveRegion;

use super::nodes::compare_nodes;
use super::{Outcome, Pair, STEPS, Seen, reach};

pub(super) fn compare(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    pair.begin();
    let mut before = pair.expected.body.clone();
    let mut computed = 0;
    for _ in 0..STEPS {
        before = pair.expected.body.clone();
        computed += elements_reached(&pair.scene.model, &pair.reach, pair.expected.step);
        pair.advance(&[Stage::Nodes, Stage::Projectile], None)?;
    }
    let way = pair.scene.speed * pair.scene.model.dt;
    compare_nodes(
        pair,
        seen,
        [
            (pair.kind("contact displacement", "contact displacement, held"), way),
            (pair.kind("contact velocity", "contact velocity, held"), pair.scene.speed),
        ],
    )?;
    reach::compare(pair, seen)?;
    let visited = pair.read(BufferId::Status)?[status::COMPUTED];
    seen.see("counters", visited.into(), computed as f64, 1.0, || "elements computed".into());
    let marks = pair.read(BufferId::Candidates)?;
    seen.see("cleared", marks.iter().map(|w| w.count_ones()).sum::<u32>().into(), 0.0, 1.0, || "candidates".into());
    let words = pair.read(BufferId::Body)?;
    let start = pair.scene.model.projectile.as_ref().ok_or("no projectile")?;
    let record = layout::read_body(&words, start);
    let before = before.ok_or("no projectile")?;
    for a in 0..3 {
        let (velocity, position) = record.before;
        seen.see(
            pair.kind("body velocity", "body velocity, held"),
            velocity[a],
            before.velocity[a],
            pair.scene.speed,
            || format!("before, {a}"),
        );
        seen.see(pair.kind("body position", "body position, held"), position[a], before.position[a], way, || {
            format!("before, {a}")
        });
    }
    compare_body(pair, seen, &record)
}

/// Elements that a step computes.
fn elements_reached(model: &Model<f32>, reach: &[ActiveRegion], step: u64) -> usize {
    if step == 0 {
        return model.elements();
    }
    let of_ply = |(ply, reach): (usize, &ActiveRegion)| {
        let [rows, columns] = reach.elements(&model.ply_type(ply).mesh);
        rows.len() * columns.len()
    };
    reach.iter().enumerate().map(of_ply).sum()
}

/// The projectile and what contact did to it.
fn compare_body(pair: &Pair<'_>, seen: &mut Seen, got: &layout::BodyRecord) -> Outcome {
    let Some(expected) = &pair.expected.body else { return Ok(()) };
    let scene = pair.scene;
    let (speed, reach) = (scene.speed, expected.body.bounding_radius);
    let mass = pair.pushed_mass();
    let (impulse, energy) = (mass * speed, mass * speed * speed);
    let ledger = &pair.ledger;
    let supports = pair.read_floats(BufferId::Supports)?;
    for a in 0..3 {
        let place = || format!("direction {a}");
        let velocity = speed * (mass / expected.mass).min(1.0);
        seen.see(
            pair.kind("body velocity", "body velocity, held"),
            got.body.velocity[a],
            expected.velocity[a],
            velocity,
            place,
        );
        seen.see(
            pair.kind("body position", "body position, held"),
            got.body.position[a],
            expected.position[a],
            speed * scene.model.dt,
            place,
        );
        let spin = [got.body.angular_momentum[a], expected.angular_momentum[a]];
        seen.see("angular momentum", spin[0], spin[1], pair.node_mass() * speed * reach + spin[1].abs(), place);
        let given = -ledger.contact_impulse[a];
        seen.see(pair.kind("impulse", "impulse, held"), got.impulse[a], given, impulse + given.abs(), place);
        let fabric: f64 = supports.iter().skip(a).step_by(3).sum();
        let held = ledger.support[a];
        seen.see(pair.kind("impulse", "impulse, held"), fabric + got.support[a], held, impulse + held.abs(), || {
            format!("support {a}")
        });
    }
    for (n, value) in [ledger.contact, ledger.friction, ledger.external].into_iter().enumerate() {
        seen.see(
            pair.kind("contact energy", "contact energy, held"),
            got.energy[n],
            value,
            energy + value.abs(),
            || format!("energy {n}"),
        );
    }
    seen.see("penetration", got.penetration, pair.penetration[0], scene.model.ply_types[0].mesh.length[0], String::new);
    let turn = got.body.orientation.coords - expected.orientation.coords;
    seen.see("orientation", turn.norm(), 0.0, 1.0, String::new);
    Ok(())
}
