//! Forces, heights, life and accounts of the elements.

use nalgebra::Vector3;
use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::status;
use ripstop::gpu::stepper::Stage;
use ripstop::kernels::element_force::field as element;
use ripstop::solver::FailureEvent;
use ripstop::solver::state::State;

use super::{Outcome, Pair, Scales, Seen};

/// The second half of what predicts heights: not lengths but shares.
const GUIDE_SHARE: usize = element::PREDICTOR + 2;

/// Cells of a scene that may need the safeguarded iteration on one backend alone.
const SAFEGUARDED_ON_ONE: usize = 1;

pub(super) fn compare(pair: &mut Pair<'_>, seen: &mut Seen) -> Outcome {
    pair.begin();
    pair.advance(&[Stage::Elements], None)?;
    let first_status = pair.read(BufferId::Status)?;
    seen.see(
        ["element_force", "residual"],
        residual(&first_status),
        pair.totals.max_residual,
        pair.scales.force,
        String::new,
    );
    seen.see(["step", "counters"], first_status[status::ERODED].into(), pair.totals.eroded as f64, 1.0, || {
        "eroded".into()
    });
    compare_elements(pair, seen)?;
    let first_unconverged = pair.totals.unconverged;
    pair.advance(&[Stage::Elements], Some(0))?;
    compare_elements(pair, seen)?;
    let words = pair.read(BufferId::Status)?;
    let unconverged = (first_unconverged + pair.totals.unconverged) as f64;
    seen.see(["step", "counters"], words[status::UNCONVERGED].into(), unconverged, 1.0, || "unconverged".into());
    seen.see(["step", "counters"], words[status::BAD_STEP].into(), u32::MAX.into(), 1.0, || "bad step".into());
    compare_failures(pair, seen, &words)?;
    let flags = pair.read(BufferId::Flags)?;
    let evaluations: u32 = flags.iter().map(|word| word >> 8).sum();
    seen.see(["element_force", "evaluations"], evaluations.into(), pair.evaluations, pair.evaluations.max(1.0), || {
        "sum".into()
    });
    compare_accounts(pair, seen)
}

fn residual(words: &[u32]) -> f64 {
    f32::from_bits(words[status::RESIDUAL]).into()
}

/// Forces, heights and life of every element.
pub(super) fn compare_elements(pair: &Pair<'_>, seen: &mut Seen) -> Outcome {
    let (model, expected, got) = (&pair.scene.model, &pair.expected, pair.download()?);
    let Scales { force, height, failure_strain, viscous_force, .. } = pair.scales;
    let mut safeguarded_on_one = 0;
    for row in 0..model.grid.element_rows() {
        for column in 0..model.grid.columns {
            let number = |state: &State<f32>, field| f64::from(state.elements.get(row, field, column + 1));
            // A rounding decides whether Newton's steps end, or the safeguarded iteration, which predicts nothing: heights are as right.
            let predicts =
                |state: &State<f32>| (element::PREDICTOR..element::HEIGHT).any(|field| number(state, field) != 0.0);
            let on_one = predicts(&got) != predicts(expected);
            safeguarded_on_one += usize::from(on_one);
            let size = |first: usize| force + Vector3::from([0, 1, 2].map(|a| number(expected, first + a))).norm();
            let compared = (0..expected.elements.fields)
                .filter(|field| !on_one || !(element::PREDICTOR..element::HEIGHT).contains(field));
            for field in compared {
                let (quantity, scale) = match field {
                    0..element::HOURGLASS => ("membrane force", size(field / 3 * 3)),
                    element::HOURGLASS..element::PREDICTOR => ("hourglass force", size(element::HOURGLASS)),
                    element::PREDICTOR..GUIDE_SHARE => ("predicted height", height),
                    GUIDE_SHARE..element::HEIGHT => ("predicted height", 1.0),
                    // From one state: half of what whole runs may differ by.
                    element::HEIGHT..element::ALIVE => ("yarn height", 0.5 * height),
                    element::ALIVE..element::COUNT => ("yarn alive", 1.0),
                    _ if field >= expected.elements.fields - element::STRAIN => {
                        ("strain", failure_strain + number(expected, field).abs())
                    }
                    _ => ("viscous force", viscous_force),
                };
                let place = || format!("step {}, row {row}, column {column}, field {field}", expected.step - 1);
                seen.see(["element_force", quantity], number(&got, field), number(expected, field), scale, place);
            }
        }
    }
    if safeguarded_on_one > SAFEGUARDED_ON_ONE {
        return Err(format!("{safeguarded_on_one} cells need the safeguarded iteration on one backend alone"));
    }
    Ok(())
}

fn compare_failures(pair: &Pair<'_>, seen: &mut Seen, words: &[u32]) -> Outcome {
    let grid = &pair.scene.model.grid;
    let count = words[status::EVENTS] as usize;
    let raw = pair.read(BufferId::Events)?;
    let mut got: Vec<&[u32]> = raw.chunks_exact(4).take(count).collect();
    got.sort();
    let place = |f: &FailureEvent| {
        [f.step as u32, ((f.ply as usize * grid.rows + f.j as usize) * grid.columns) as u32 + f.i, u32::from(f.yarn)]
    };
    let expected: Vec<_> = pair.failures.iter().map(|f| (place(f), f.strain)).collect();
    let same = got.len() == expected.len() && got.iter().zip(&expected).all(|(g, e)| g[..3] == e.0);
    seen.see(["element_force", "failures"], f64::from(u8::from(!same)), 0.0, 1.0, || {
        format!("{} for {}", got.len(), expected.len())
    });
    for yarn in 0..2 {
        let broken = expected.iter().filter(|e| e.0[2] == yarn as u32).count();
        seen.see(["step", "counters"], words[status::FAILED + yarn].into(), broken as f64, 1.0, || {
            format!("failed, {yarn}")
        });
    }
    for (g, e) in got.iter().zip(&expected).filter(|_| same) {
        // A yarn that has grown slack in the step in which it breaks has no strain.
        let strain = f64::from(f32::from_bits(g[3])).max(0.0);
        let scale = pair.scales.failure_strain + e.1.max(0.0);
        seen.see(["element_force", "failure strain"], strain, e.1.max(0.0), scale, || format!("{:?}", e.0));
    }
    Ok(())
}

fn compare_accounts(pair: &Pair<'_>, seen: &mut Seen) -> Outcome {
    let accounts = pair.read_floats(BufferId::Accounts)?;
    let count = pair.gpu.sizes().elements as usize;
    let field = |n: usize| accounts[n * count..(n + 1) * count].iter().copied();
    let add = |n: usize| field(n).sum::<f64>();
    let most = |n: usize| field(n).fold(0.0, f64::max);
    let sums = [add(0), add(1), add(2), add(3), add(4), most(5), most(6), add(7), add(8), most(9)];
    compare_sums(pair, seen, sums, "accounts");
    Ok(())
}

/// Work, released membrane and hourglass energy, stored and hourglass energy, tension, deflection, viscous work, energy of the unit-cell
/// law, load.
pub(super) fn compare_sums(pair: &Pair<'_>, seen: &mut Seen, got: [f64; 10], place: &str) {
    let balance = pair.ledger.balance();
    let Scales { energy, force, length, .. } = pair.scales;
    let deflection = pair.ledger.plies().iter().map(|ply| ply.deflection).fold(0.0, f64::max);
    // What contact between plies adds to the work of the membrane has its own sum on the device.
    let work = if pair.scene.elements { pair.ledger.work } else { 0.0 };
    let expected = [
        ("work", work, energy),
        ("released energy", pair.ledger.released[0], energy),
        ("released energy", pair.ledger.released[1], energy),
        ("stored energy", balance.stored, energy),
        ("stored energy", balance.hourglass, energy),
        ("tension", balance.max_tension, force),
        ("deflection", deflection, length),
        ("work", pair.ledger.viscous, energy),
        ("law energy", balance.law, energy),
        ("load", balance.max_load, 1.0),
    ];
    for (n, (quantity, value, scale)) in expected.into_iter().enumerate() {
        seen.see(["ledger", quantity], got[n], value, scale + value.abs(), || format!("{place} {n}"));
    }
}
