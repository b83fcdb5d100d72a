//! Contact between plies: motion, cells, what may have moved, energies, supports, depth.

use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::{ACCOUNT_FIELDS, CONTACT_WORDS, status};
use ripstop::gpu::stepper::Stage;

use super::nodes::compare_nodes;
use super::{Outcome, Pair, STEPS, Seen, reach};

pub(super) fn compare(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    pair.begin();
    for _ in 0..STEPS {
        pair.advance(&[Stage::Nodes, Stage::Plies], None)?;
        if pair.totals.ply_contacts == 0 {
            return Err("no ply touches another: the scene shows nothing".into());
        }
        compare_nodes(pair, seen, "ply_contact", [pair.ply_length, pair.ply_closing()])?;
        reach::compare(pair, seen, "ply_contact")?;
        let contacts = pair.read_floats(BufferId::Contacts)?;
        let found = contacts.chunks_exact(CONTACT_WORDS as usize).filter(|words| words[7] != 0.0).count();
        seen.see(["ply_contact", "contacts"], found as f64, pair.totals.ply_contacts as f64, 1.0, || {
            format!("step {}", pair.expected.step - 1)
        });
        for name in [BufferId::Shares, BufferId::Impulses] {
            let left = pair.read(name)?.iter().filter(|word| **word != 0).count();
            seen.see(["step", "cleared"], left as f64, 0.0, 1.0, || format!("{name:?}"));
        }
    }
    let words = pair.read(BufferId::Status)?;
    let depth = f64::from(f32::from_bits(words[status::PLY_DEPTH]));
    seen.see(["ply_contact", "penetration"], depth, pair.penetration[1], pair.scales.length, || "ply".into());
    compare_energies(pair, seen)?;
    compare_supports(pair, seen)
}

/// Accounts of every node: loss, rubbed, and the work of moving nodes out of other plies.
fn compare_energies(pair: &Pair<'_>, seen: &mut Seen) -> Outcome {
    let accounts = pair.read_floats(BufferId::Accounts)?;
    let (elements, nodes) = (pair.gpu.sizes().elements as usize, pair.gpu.sizes().nodes as usize);
    let sum =
        |field: usize| accounts[ACCOUNT_FIELDS as usize * elements + field * nodes..][..nodes].iter().sum::<f64>();
    see_energies(pair, seen, [0, 1, 2].map(sum), "accounts");
    Ok(())
}

/// Loss, rubbed, and the work of separation, as the ledger of the CPU has them.
pub(super) fn see_energies(pair: &Pair<'_>, seen: &mut Seen, got: [f64; 3], place: &str) {
    let energy = pair.node_momentum() * pair.free.speed;
    let [loss, rubbed, separation] = got;
    let sums = [
        ("inelastic", loss - rubbed, pair.ledger.contact),
        ("separation", separation, pair.ledger.separation),
        ("rubbed", rubbed, pair.ledger.friction),
    ];
    for (name, got, expected) in sums {
        seen.see(["ply_contact", "energy"], got, expected, energy + expected.abs(), || format!("{place}, {name}"));
    }
}

/// Impulse that held nodes take out of the pack.
fn compare_supports(pair: &Pair<'_>, seen: &mut Seen) -> Outcome {
    let supports = pair.read_floats(BufferId::Supports)?;
    let impulse = pair.node_momentum();
    for a in 0..3 {
        let got: f64 = supports.iter().skip(a).step_by(3).sum();
        let expected = pair.ledger.support[a];
        seen.see(["ply_contact", "support"], got, expected, impulse + expected.abs(), || format!("direction {a}"));
    }
    Ok(())
}
