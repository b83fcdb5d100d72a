//! Contact with the projectile, and its motion.

use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::{self, status};
use ripstop::gpu::stepper::Stage;
use ripstop::model::Model;
use ripstop::solver::active_region::ActiveRegion;

use super::nodes::compare_nodes;
use super::{Outcome, Pair, STEPS, Seen, reach};

/// As the table names the kernel.
pub(super) const CONTACT: &str = "projectile_contact";

pub(super) fn compare(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    pair.begin();
    let mut before = pair.expected.body.clone();
    let mut computed = 0;
    for _ in 0..STEPS {
        before = pair.expected.body.clone();
        computed += elements_reached(&pair.scene.model, &pair.reach, pair.expected.step);
        pair.advance(&[Stage::Nodes, Stage::Projectile], None)?;
    }
    compare_nodes(pair, seen, CONTACT, [pair.contact_way(), pair.scales.closing])?;
    reach::compare(pair, seen, CONTACT)?;
    let visited = pair.read(BufferId::Status)?[status::COMPUTED];
    seen.see(["step", "counters"], visited.into(), computed as f64, 1.0, || "elements computed".into());
    let marks = pair.read(BufferId::Candidates)?;
    seen.see(["step", "cleared"], marks.iter().map(|w| w.count_ones()).sum::<u32>().into(), 0.0, 1.0, || {
        "candidates".into()
    });
    let words = pair.read(BufferId::Body)?;
    let start = pair.scene.model.projectile.as_ref().ok_or("no projectile")?;
    let record = layout::read_body(&words, start, &layout::device_origin(&pair.scene.model));
    let before = before.ok_or("no projectile")?;
    for a in 0..3 {
        let (velocity, position) = record.before;
        let (speed, length) = (pair.scales.body_velocity(), pair.scales.body_position());
        let place = || format!("before, {a}");
        seen.see([CONTACT, "body velocity"], velocity[a], before.velocity[a], speed, place);
        seen.see([CONTACT, "body position"], position[a], before.position[a], length, place);
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
    let (scales, ledger) = (&pair.scales, &pair.ledger);
    let [impulse, energy] = [scales.impulse(), scales.contact_energy];
    let supports = pair.read_floats(BufferId::Supports)?;
    let [turning, spins] = [expected, &got.body].map(|body| body.angular_momentum);
    for a in 0..3 {
        let place = || format!("direction {a}");
        let mut see =
            |quantity, got: f64, expected: f64, scale: f64| seen.see([CONTACT, quantity], got, expected, scale, place);
        see("body velocity", got.body.velocity[a], expected.velocity[a], scales.body_velocity());
        see("body position", got.body.position[a], expected.position[a], scales.body_position());
        see("angular momentum", spins[a], turning[a], scales.spin + turning.norm());
        let given = -ledger.contact_impulse[a];
        see("impulse", got.impulse[a], given, impulse + given.abs());
        let fabric: f64 = supports.iter().skip(a).step_by(3).sum();
        let held = ledger.support[a];
        see("impulse", fabric + got.support[a], held, impulse + held.abs());
    }
    for (n, value) in [ledger.contact, ledger.friction, ledger.external].into_iter().enumerate() {
        seen.see([CONTACT, "energy"], got.energy[n], value, energy + value.abs(), || format!("energy {n}"));
    }
    seen.see([CONTACT, "penetration"], got.penetration, pair.penetration[0], scales.length, String::new);
    let turn = got.body.orientation.coords - expected.orientation.coords;
    seen.see([CONTACT, "body orientation"], turn.norm(), 0.0, 1.0, String::new);
    Ok(())
}
