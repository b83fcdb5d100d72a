//! Runs that end before their time.

use std::sync::atomic::{AtomicBool, Ordering};

use ripstop::case::Case;
use ripstop::gpu::Device;
use ripstop::run::device::DeviceSimulation;
use ripstop::run::outcome;
use ripstop::run::{self, Options, Run, Skips};

use super::{Outcome, Tests, failures_add_up, run_on, run_until};
use crate::scene::{builtin, run};
use crate::support::torn;

pub(super) const TESTS: Tests = &[
    ("an_interrupt_ends_with_a_row", interrupted),
    ("numbers_that_blow_up_are_told_with_step_and_place", unstable),
    ("a_run_that_is_decided_ends_there", decided),
    ("debris_ahead_does_not_keep_a_shot_undecided", debris),
    ("a_shot_that_stopped_flies_back", separated),
    ("a_pack_that_nothing_holds_stops_a_shot_and_carries_it", carried),
];

/// The last row is of the positions that the last step began with.
#[track_caller]
fn ends_with_a_row(case: &Case, run: &Run) {
    let last = run.history.last().unwrap();
    assert_eq!(last.time, (run.steps - 1) as f64 * run.time_step);
    assert!(run.history.windows(2).all(|rows| rows[0].time < rows[1].time));
    failures_add_up(case, run);
}

fn interrupted(device: &'static Device) -> Outcome {
    // Rows so far apart that only the interrupt can have asked for the last one.
    let case = builtin("cases/verify/mirror.json", &["/output/history_interval_us=40", "/projectile/velocity_m_s=600"]);
    let run = run_until(device, &case, &AtomicBool::new(true));
    assert!(run.interrupted && run.divergence.is_none() && run.lost.is_none());
    ends_with_a_row(&case, &run);
    let interrupt = AtomicBool::new(false);
    let options = Options::default().threads(1).device(device);
    let mut stop = |at: &run::Progress| interrupt.store(at.steps > 100, Ordering::Relaxed);
    let run = run::run(&case, options, &interrupt, &mut stop).map_err(|e| e.to_string())?;
    assert!(run.interrupted && run.steps > 100);
    let last = run.history.last().unwrap();
    assert!(last.time < 40e-6 && run.history.len() == 2, "{} rows up to {} s", run.history.len(), last.time);
    assert!(!run.events.is_empty());
    ends_with_a_row(&case, &run);
    Ok(())
}

fn unstable(device: &'static Device) -> Outcome {
    let mut case = builtin("cases/verify/mirror.json", &[]);
    case.solver.courant = 5.0;
    let run = run_until(device, &case, &AtomicBool::new(false));
    let trouble = run.divergence.as_ref().ok_or("no trouble at five times the stable step")?;
    assert!(run.lost.is_none() && !run.interrupted);
    assert!(trouble.step <= run.steps && trouble.step > 0, "{trouble:?} {}", run.steps);
    assert!(
        ["element_force", "node_update", "projectile_contact", "rigid_body"].contains(&trouble.kernel),
        "{trouble:?}"
    );
    let [ply, row, column] = trouble.place;
    assert!(ply == 0 && row <= case.pack.rows && column <= case.pack.columns, "{trouble:?}");
    assert!(!trouble.quantity.is_empty());
    for row in &run.history {
        let numbers = ripstop::output::history::COLUMNS.map(|column| (column.read)(row));
        assert!(numbers.iter().all(|x| x.is_finite()), "{row:?}");
    }
    Ok(())
}

fn decided(device: &'static Device) -> Outcome {
    let sets = [
        "/projectile/velocity_m_s=60",
        "/projectile/obliquity_deg=0",
        "/solver/end_time_us=400",
        "/solver/run_until=outcome",
    ];
    let case = builtin("cases/verify/mirror.json", &sets);
    let (cpu, gpu) = (run(&case), run_on(device, &case));
    assert_eq!(gpu.outcome, cpu.outcome);
    let [c, g] = [&cpu, &gpu].map(|run| run.stop_time.unwrap());
    assert!((c - g).abs() < 0.2e-6, "stops at {g} for {c} s");
    assert!(gpu.history.last().unwrap().time < 390e-6);
    ends_with_a_row(&case, &gpu);
    Ok(())
}

/// What covers the projectile is looked at after the same samples as on the processor, whatever the batches: a longer one waits.
fn debris(device: &'static Device) -> Outcome {
    let case = torn::case(&[]);
    for loose in [true, false] {
        let mut cpu = run::Simulation::<f32>::new(&case).map_err(|e| e.to_string())?;
        torn::tear(&cpu.model, &mut cpu.state, loose);
        while !cpu.finished(&case) {
            cpu.advance(&case);
        }
        let cpu = cpu.into_run(1.0);
        let expected = if loose { outcome::Outcome::Perforated } else { outcome::Outcome::Running };
        assert_eq!(cpu.outcome, expected);
        for batch in [Some(1), Some(7), Some(256), None] {
            let gpu = DeviceSimulation::with_skips(&case, device, Skips::WHOLE).map_err(|e| e.to_string())?;
            let mut gpu = gpu.with_state(|model, state| torn::tear(model, state, loose));
            if let Some(steps) = batch {
                gpu = gpu.with_batch(steps);
            }
            while !gpu.finished() {
                gpu.advance(&case);
            }
            let gpu = gpu.into_run(1.0);
            assert!(gpu.divergence.is_none() && gpu.lost.is_none(), "{:?} {:?}", gpu.divergence, gpu.lost);
            assert_eq!(gpu.outcome, expected, "batches of {batch:?}");
            let [c, g] = [&cpu, &gpu].map(|run| run.history.last().unwrap());
            assert_eq!((g.time, g.perforated_plies), (c.time, c.perforated_plies), "batches of {batch:?}");
        }
    }
    Ok(())
}

fn separated(device: &'static Device) -> Outcome {
    let sets = [
        "/projectile/velocity_m_s=60",
        "/projectile/obliquity_deg=0",
        "/projectile/offset_mm=[0,0]",
        "/solver/end_time_us=1500",
        "/solver/run_until=separation",
    ];
    let case = builtin("cases/verify/mirror.json", &sets);
    let (cpu, gpu) = (run(&case), run_on(device, &case));
    assert_eq!((gpu.outcome, cpu.outcome), (outcome::Outcome::Rebounded, outcome::Outcome::Rebounded));
    let [c, g] = [&cpu, &gpu].map(|run| run.rebound_velocity.unwrap());
    assert!((c - g).abs() < 0.02 * c, "flies back at {g} for {c} m/s");
    assert!(gpu.history.last().unwrap().time < 1400e-6);
    ends_with_a_row(&case, &gpu);
    Ok(())
}

fn carried(device: &'static Device) -> Outcome {
    let sets = [
        "/pack/width_mm=40",
        "/pack/height_mm=40",
        "/pack/edges=free",
        "/pack/elements_per_crossover=1",
        "/projectile/velocity_m_s=60",
        "/output/profile_times_us=[]",
        "/expect=[]",
        "/solver/end_time_us=1500",
    ];
    let case = builtin("cases/s720-1ply-155.json", &sets);
    let (cpu, gpu) = (run(&case), run_on(device, &case));
    assert_eq!((gpu.outcome, cpu.outcome), (outcome::Outcome::Stopped, outcome::Outcome::Stopped));
    for of in [|run: &Run| run.stop_time, |run: &Run| run.carried_velocity] {
        let [c, g] = [&cpu, &gpu].map(|run| of(run).unwrap());
        assert!((c - g).abs() < 0.01 * c, "{g} for {c}");
    }
    ends_with_a_row(&case, &gpu);
    Ok(())
}
