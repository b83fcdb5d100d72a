//! The sums of the ledger after whole steps.

use nalgebra::Vector3;
use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::{self, BODY_WORDS, BodyRecord, STATUS_WORDS, SUMS, sum};
use ripstop::gpu::stepper::Stage;
use ripstop::run::outcome;

use super::elements::compare_sums;
use super::plies::see_energies;
use super::projectile::CONTACT;
use super::{Outcome, Pair, STEPS, Seen, motion, places};

/// Sums that begin anew after a sample.
const ANEW: [usize; 12] = [
    sum::VISCOUS,
    sum::WORK,
    sum::RELEASED,
    sum::RELEASED_HOURGLASS,
    sum::EVALUATIONS,
    sum::SOLVED,
    sum::SUPPORT,
    sum::SUPPORT + 1,
    sum::SUPPORT + 2,
    sum::PLY_LOSS,
    sum::PLY_RUBBED,
    sum::PLY_SEPARATION_WORK,
];

pub(super) fn compare(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    pair.begin();
    // In a pack both contacts would share the processor's sums of what is lost; the shots hold their sum.
    let body = pair.scene.model.projectile.as_ref().filter(|_| !pair.scene.pack);
    let asked = [
        (Stage::Elements, pair.scene.elements),
        (Stage::Nodes, true),
        (Stage::Plies, pair.scene.pack),
        (Stage::Projectile, body.is_some()),
        (Stage::EnergyBalance, true),
    ];
    let stages: Vec<Stage> = asked.into_iter().filter_map(|(stage, asked)| asked.then_some(stage)).collect();
    pair.advance(&stages, None)?;
    pair.advance(&stages, Some(1))?;
    let (words, per_sample) = (pair.read(BufferId::Samples)?, pair.gpu.sizes().sample_words());
    let (sums, rest) = words[per_sample..2 * per_sample].split_at(per_sample - BODY_WORDS - STATUS_WORDS);
    let add = |which: usize| sum_of(sums, which);
    let most = |which: usize| sums.chunks_exact(SUMS).map(|s| f64::from(f32::from_bits(s[which]))).fold(0.0, f64::max);
    let same = [sum::WORK, sum::RELEASED, sum::RELEASED_HOURGLASS, sum::STORED, sum::HOURGLASS_NOW].map(add);
    let got = [
        same[0],
        same[1],
        same[2],
        same[3],
        same[4],
        most(sum::TENSION),
        most(sum::DEFLECTION),
        add(sum::VISCOUS),
        add(sum::LAW),
        most(sum::LOAD),
    ];
    compare_sums(pair, seen, got, "ledger");
    seen.see(
        ["element_force", "evaluations"],
        add(sum::EVALUATIONS),
        pair.evaluations,
        pair.evaluations.max(1.0),
        || "ledger".into(),
    );
    compare_motion(pair, seen, add, most(sum::FASTEST));
    compare_counts(pair, seen, add);
    if pair.scene.pack {
        let lost = [sum::PLY_LOSS, sum::PLY_RUBBED, sum::PLY_SEPARATION_WORK].map(add);
        see_energies(pair, seen, lost, "ledger");
    }
    if let Some(start) = body {
        let record = layout::read_body(&rest[..BODY_WORDS], start, &layout::device_origin(&pair.scene.model));
        compare_body(pair, seen, sums, &record)?;
    } else {
        let (row, scale) = if pair.scene.pack {
            (["ply_contact", "support"], pair.node_momentum())
        } else {
            (["ledger", "support"], pair.scales.force * pair.scene.model.dt)
        };
        for a in 0..3 {
            let expected = pair.ledger.support[a];
            seen.see(row, add(sum::SUPPORT + a), expected, scale + expected.abs(), || format!("ledger {a}"));
        }
    }
    let status = pair.read(BufferId::Status)?;
    seen.see(["step", "counters"], f64::from(u8::from(rest[BODY_WORDS..] != status[..STATUS_WORDS])), 0.0, 1.0, || {
        "copy".into()
    });
    anew(pair, seen)
}

/// One of the sums, over the workgroups.
fn sum_of(sums: &[u32], which: usize) -> f64 {
    sums.chunks_exact(SUMS).map(|s| f64::from(f32::from_bits(s[which]))).sum()
}

/// The projectile's supports, and what fabric lies ahead of it.
fn compare_body(pair: &Pair<'_>, seen: &mut Seen, sums: &[u32], record: &BodyRecord) -> Outcome {
    // The supports of the fabric are sums of the ledger now.
    for a in 0..3 {
        let got = record.support[a] + sum_of(sums, sum::SUPPORT + a);
        let expected = pair.ledger.support[a];
        seen.see([CONTACT, "impulse"], got, expected, pair.scales.impulse() + expected.abs(), || format!("ledger {a}"));
    }
    let body = pair.expected.body.as_ref().ok_or("no projectile")?;
    // Each ply has as many workgroups, one after the other.
    let count = pair.scene.model.plies.len();
    for (ply, sums) in sums.chunks_exact(sums.len() / count).enumerate() {
        let got = sum_of(sums, sum::COVERED);
        let covered = outcome::covered(&pair.scene.model, &pair.expected, body, ply);
        seen.see(["ledger", "covered"], (got > 0.5).into(), covered.into(), 1.0, || format!("ply {ply}"));
    }
    Ok(())
}

/// Kinetic energies, momentum and largest speed from the processor's state after the step.
fn compare_motion(pair: &Pair<'_>, seen: &mut Seen, add: impl Fn(usize) -> f64, fastest: f64) {
    let (model, state) = (&pair.scene.model, &pair.expected);
    let (mut kinetic, mut momentum, mut scale, mut square) = (0.0, Vector3::zeros(), 0.0, 0.0_f64);
    for place in places(model) {
        let (m, v) = motion(model, state, place);
        kinetic += 0.5 * m * v.norm_squared();
        momentum += m * v;
        scale += m * v.norm();
        square = square.max(v.norm_squared());
    }
    let balance = pair.ledger.balance();
    let energy = kinetic + pair.free.contact_energy;
    seen.see(["ledger", "kinetic energy"], add(sum::KINETIC), kinetic, energy, String::new);
    seen.see(["ledger", "kinetic energy now"], add(sum::KINETIC_NOW), balance.kinetic, energy, String::new);
    seen.see(["ledger", "largest square of speed"], fastest, square, square, String::new);
    for a in 0..3 {
        seen.see(["ledger", "momentum"], add(sum::MOMENTUM + a), momentum[a], scale, || format!("direction {a}"));
    }
}

/// Cells with both yarns left, once for every step since the last ledger.
fn compare_counts(pair: &Pair<'_>, seen: &mut Seen, add: impl Fn(usize) -> f64) {
    let (model, state) = (&pair.scene.model, &pair.expected);
    let whole = |ply: usize| {
        let mesh = &model.ply_type(ply).mesh;
        let first = model.grid.first_element_row(ply);
        let all = (0..mesh.rows).flat_map(move |row| (0..mesh.columns).map(move |column| (first + row, column)));
        all.filter(|(row, column)| (0..2).all(|yarn| state.alive(*row, *column, yarn))).count()
    };
    let left = (0..model.grid.plies).map(whole).sum::<usize>();
    seen.see(["step", "counters"], add(sum::SOLVED), (STEPS as usize * left) as f64, 1.0, || "solved".into());
}

/// A second ledger straight after the first finds that everything that adds up began anew.
fn anew(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    let info = pair.gpu.whole_step(pair.expected.step, Some(0), 0);
    pair.gpu.run_stages(&info, &[Stage::EnergyBalance]).map_err(|e| e.to_string())?;
    let words = pair.read(BufferId::Samples)?;
    let per_sample = pair.gpu.sizes().sample_words();
    let (sums, body) = words[..per_sample].split_at(per_sample - BODY_WORDS - STATUS_WORDS);
    for which in ANEW {
        let left = sums.chunks_exact(SUMS).map(|s| f64::from(f32::from_bits(s[which])).abs()).sum();
        seen.see(["step", "cleared"], left, 0.0, 1.0, || format!("sum {which}"));
    }
    if let Some(start) = &pair.scene.model.projectile {
        let record = layout::read_body(&body[..BODY_WORDS], start, &layout::device_origin(&pair.scene.model));
        let left: f64 = record.impulse.iter().chain(&record.support).chain(&record.energy).map(|x| x.abs()).sum();
        seen.see(["step", "cleared"], left, 0.0, 1.0, || "body".into());
        let length = pair.scales.length;
        seen.see([CONTACT, "penetration"], record.penetration, pair.penetration[0], length, || "kept".into());
    }
    Ok(())
}
