//! Runs that end before their time: by their outcome, by the user, by numbers that blow up, by a device that goes away; and runs
//! that go on from a checkpoint. Many shots in one dispatch: each gives the bits that it gives alone, whatever its neighbours are and
//! whatever becomes of them.

use std::fs::File;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use ripstop::case::{Backing, BackingMaterial, Case, ContactSampling};
use ripstop::gpu::{Device, adapters, device};
use ripstop::output::Folder;
use ripstop::run::batch::{DeviceBatch, PreparedShot};
use ripstop::run::checkpoint::{Checkpoint, Checkpointable, Header};
use ripstop::run::device::DeviceSimulation;
use ripstop::run::{self, Observer, Options, Outcome as Fate, Precision, Run, RunError, Simulation, Skips};
use ripstop::study::batch::{Batch, BatchError, BatchOptions, ShotOrder};
use ripstop::study::shots::ShotRow;
use tempfile::TempDir;

use super::{Outcome, Tests, begun, failures_add_up, run_on, run_until, sound};
use crate::support::{Random, builtin, pack, ply, quarter, result, run, shipped, torn};

pub(super) const TESTS: Tests = &[
    ("shots_of_a_batch_are_what_they_are_alone", each_as_alone),
    ("rows_do_not_depend_on_the_batch", batch_rows),
    ("an_interrupt_gives_up_what_is_under_way", batch_interrupted),
    ("an_interrupt_ends_with_a_row", interrupted),
    ("numbers_that_blow_up_are_reported_with_step_and_place", unstable),
    ("a_run_ends_with_its_outcome_as_on_the_processor", decided),
    ("debris_ahead_does_not_keep_a_shot_undecided", debris),
    ("a_run_goes_on_bit_by_bit_from_random_times", resumed),
    ("a_checkpoint_that_does_not_fit_is_refused_and_timings_are_kept", checkpoints),
    ("a_device_lost_in_mid_run_leaves_the_history_so_far", lost),
];

/// The last row is of the positions that the last step began with.
#[track_caller]
fn ends_with_a_row(case: &Case, run: &Run) {
    let last = run.history.last().unwrap();
    assert_eq!(last.time, (run.steps - 1) as f64 * run.time_step);
    assert!(run.history.windows(2).all(|rows| rows[0].time < rows[1].time));
    failures_add_up(case, run);
}

fn options(device: &Device) -> Options<'_> {
    Options::default().threads(1).device(device)
}

fn interrupted(device: &'static Device) -> Outcome {
    // Rows so far apart that only the interrupt can have asked for the last one.
    let case = builtin("cases/verify/mirror.json", &["/output/history_interval_us=40", "/projectile/velocity_m_s=600"]);
    let run = run_until(device, &case, &AtomicBool::new(true));
    assert!(run.interrupted && run.divergence.is_none() && run.lost.is_none());
    ends_with_a_row(&case, &run);
    let interrupt = AtomicBool::new(false);
    let mut stop = |at: &run::Progress| interrupt.store(at.steps > 100, Ordering::Relaxed);
    let run = run::run(&case, options(device), &interrupt, &mut stop).map_err(|e| e.to_string())?;
    assert!(run.interrupted && run.steps > 100 && !run.events.is_empty());
    assert!(run.history.len() == 2 && run.history[1].time < 40e-6, "{} rows", run.history.len());
    ends_with_a_row(&case, &run);
    Ok(())
}

fn unstable(device: &'static Device) -> Outcome {
    let mut case = builtin("cases/verify/mirror.json", &[]);
    case.solver.courant = 5.0;
    let run = run_until(device, &case, &AtomicBool::new(false));
    let found = run.divergence.as_ref().ok_or("no divergence at five times the stable step")?;
    assert!(run.lost.is_none() && !run.interrupted && found.step <= run.steps && found.step > 0, "{found:?}");
    assert!(["node_update", "projectile_contact", "rigid_body"].contains(&found.kernel), "{found:?}");
    let [ply, row, column] = found.place;
    assert!(
        ply == 0 && row <= case.pack.mesh.count[1] && column <= case.pack.mesh.count[0] && !found.quantity.is_empty(),
        "{found:?}"
    );
    for row in &run.history {
        let numbers = ripstop::output::csv::COLUMNS.map(|(_, read)| read(row));
        assert!(numbers.iter().all(|x| x.is_finite()), "{row:?}");
    }
    Ok(())
}

fn decided(device: &'static Device) -> Outcome {
    let slow = ["/projectile/velocity_m_s=60", "/projectile/obliquity_deg=0"];
    let carried = ["/pack/width_mm=40", "/pack/height_mm=40", "/pack/edges=free", "/pack/elements_per_crossover=1"];
    let bare = ["/output/profile_times_us=[]", "/expect=[]", "/solver/end_time_us=1500"];
    let back = ["/projectile/offset_mm=[0,0]", "/solver/end_time_us=1500", "/solver/run_until=separation"];
    let stop = ["/solver/end_time_us=400", "/solver/run_until=outcome"];
    // Far above and far below the limit no chance decides.
    let far = ["/solver/end_time_us=150", "/output/history_interval_us=0.5", "/projectile/mass_g=0.3"];
    let mirror = |sets: &[&str]| builtin("cases/verify/mirror.json", &[&slow[..], sets].concat());
    let paper = |sets: &[&[&str]]| builtin("cases/s720-1ply-155.json", &sets.concat());
    for (case, outcome, end, allowed) in [
        (mirror(&stop), Fate::Stopped, 390e-6, 0.2e-6),
        (mirror(&back), Fate::Rebounded, 1400e-6, 0.02),
        (paper(&[&slow[..1], &carried, &bare]), Fate::Stopped, 1.0, 0.01),
        (super::graded(&[&far[..], &["/projectile/velocity_m_s=600"]].concat()), Fate::Perforated, 1.0, 0.02),
        (super::graded(&[&far[..], &["/projectile/velocity_m_s=60"]].concat()), Fate::Stopped, 1.0, 0.02),
    ] {
        let (cpu, gpu) = (run(&case), run_on(device, &case));
        assert_eq!((gpu.outcome, cpu.outcome), (outcome, outcome), "{}", case.title);
        let last = |run: &Run| Some(run.history.last().unwrap().projectile_velocity);
        let impact = case.projectile.as_ref().unwrap().velocity;
        // A time of 0.2 µs, velocities by themselves or by that of the impact.
        let numbers = |run: &Run| match (run.rebound_velocity, run.carried_velocity, end < 400e-6) {
            (_, _, true) => vec![(run.stop_time, 1.0)],
            (Some(back), ..) => vec![(Some(back), back)],
            (_, Some(carried), _) => vec![(run.stop_time, run.stop_time.unwrap()), (Some(carried), carried)],
            _ => vec![(last(run), impact)],
        };
        for ((c, scale), (g, _)) in numbers(&cpu).into_iter().zip(numbers(&gpu)) {
            assert!((c.unwrap() - g.unwrap()).abs() < allowed * scale, "{}, {outcome:?}: {g:?} for {c:?}", case.title);
        }
        assert!(gpu.history.last().unwrap().time < end);
        ends_with_a_row(&case, &gpu);
    }
    Ok(())
}

/// The fabric that covers the projectile is looked at after the same samples as on the processor, whatever the batches: a longer one waits.
fn debris(device: &'static Device) -> Outcome {
    let case = torn::case(&[]);
    for (detached, expected) in [(true, Fate::Perforated), (false, Fate::Running)] {
        let mut cpu = Simulation::<f32>::new(&case).map_err(|e| e.to_string())?;
        torn::tear(&cpu.model, &mut cpu.state, detached);
        while !cpu.finished(&case) {
            cpu.advance(&case);
        }
        let cpu = cpu.into_run(1.0);
        assert_eq!(cpu.outcome, expected);
        for batch in [Some(7), None] {
            let mut gpu =
                begun(device, &case, Skips::WHOLE).with_state(|model, state| torn::tear(model, state, detached));
            if let Some(steps) = batch {
                gpu = gpu.with_batch(steps);
            }
            while !gpu.finished() {
                gpu.advance(&case);
            }
            let gpu = gpu.into_run(1.0);
            assert!(gpu.divergence.is_none() && gpu.lost.is_none(), "{:?} {:?}", gpu.divergence, gpu.lost);
            let [c, g] = [&cpu, &gpu].map(|run| run.history.last().unwrap());
            let found = (gpu.outcome, g.time, g.perforated_plies);
            assert_eq!(found, (expected, c.time, c.perforated_plies), "batches of {batch:?}");
        }
    }
    Ok(())
}

/// Observer that saves a run at given times [s], ascending.
struct Saved {
    folder: TempDir,
    header: Header,
    times: Vec<f64>,
    kept: Vec<PathBuf>,
}

impl Observer for Saved {
    fn checkpoint_due(&self, time: f64, _: f64) -> bool {
        self.times.get(self.kept.len()).is_some_and(|due| time >= *due)
    }

    fn on_checkpoint(&mut self, run: &dyn Checkpointable, _: f64) {
        let path = self.folder.path().join(self.kept.len().to_string());
        run.save(&self.header, &[], &mut File::create(&path).unwrap()).unwrap();
        self.kept.push(path);
    }
}

/// Results of a run to its end, and its checkpoints at random times.
fn saved(device: &Device, case: &Case, count: usize, seed: u64) -> (Run, Saved) {
    let mut random = Random(seed);
    let mut times: Vec<f64> = (0..count).map(|_| random.between(0.0, case.solver.end_time)).collect();
    times.sort_by(f64::total_cmp);
    let header = Header::new(case, &options(device), 1e-6);
    let mut saved = Saved { folder: TempDir::new().unwrap(), header, times, kept: Vec::new() };
    let run = options(device).observe(case, &mut saved).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(saved.kept.len(), count);
    (sound(case, run), saved)
}

/// One ply that is met at the edge of the projectile's face too.
fn edges() -> Case {
    let mut case = ply();
    case.solver.contact_sampling = ContactSampling::Edges;
    case.solver.end_time = 14e-6;
    case.output.profile_times.clear();
    case
}

fn resumed(device: &'static Device) -> Outcome {
    for (case, count, seed) in [(ply(), 14, 21), (pack(), 6, 22), (edges(), 3, 23)] {
        let whole = result(&case, &run_on(device, &case));
        assert!(whole.iter().any(|row| row.starts_with("FailureEvent")), "nothing has failed");
        let (run, saved) = saved(device, &case, count, seed);
        assert_eq!(result(&case, &run), whole, "to save a run changes nothing");
        for path in &saved.kept {
            let checkpoint = Checkpoint::open(path).unwrap_or_else(|e| panic!("{e}"));
            let resumed = options(device).resume(&checkpoint).run(&case).unwrap_or_else(|e| panic!("{e}"));
            let resumed = result(&case, &sound(&case, resumed));
            let other = whole.iter().zip(&resumed).find(|(one, two)| one != two);
            let step = checkpoint.header.step;
            assert!(other.is_none() && whole.len() == resumed.len(), "from step {step}: {other:?}");
        }
    }
    Ok(())
}

fn checkpoints(device: &'static Device) -> Outcome {
    let (case, (_, saved)) = (ply(), saved(device, &ply(), 1, 24));
    let checkpoint = Checkpoint::open(&saved.kept[0]).map_err(|e| e.to_string())?;
    let found = |result: Result<(), RunError>| match result {
        Err(RunError::Checkpoint(error)) => error.found,
        other => panic!("{other:?}"),
    };
    let from = |case: &Case, options: Options<'_>| found(options.resume(&checkpoint).run(case).map(drop));
    assert_eq!(from(&case, Options::default()), "cpu, f64");
    assert!(from(&pack(), options(device)).starts_with("one that computes something else"));
    let mut simulation = begun(device, &case, Skips::default()).with_batch(10);
    (0..4).for_each(|_| simulation.advance(&case));
    simulation.settle(&case);
    let path = saved.folder.path().join("timed");
    simulation.save(&saved.header, &[], &mut File::create(&path).unwrap()).unwrap();
    // Long enough for all that was timed.
    let before = simulation.into_run(1e9).kernel_seconds;
    let resumed = DeviceSimulation::resume(&case, device, &Checkpoint::open(&path).unwrap());
    assert_eq!(resumed.unwrap_or_else(|e| panic!("{e}")).into_run(1e9).kernel_seconds, before);
    assert_eq!(before.is_empty(), !device.has_clock());
    Ok(())
}

fn lost(device: &'static Device) -> Outcome {
    let case = builtin("cases/verify/mirror.json", &["/projectile/velocity_m_s=600"]);
    let adapter = device::choose(&adapters(), Some(device.name())).map_err(|e| e.to_string())?;
    let other = Device::open(&adapter).map_err(|e| e.to_string())?;
    let mut simulation = begun(&other, &case, Skips::WHOLE).with_batch(8);
    while simulation.steps() < 64 {
        simulation.advance(&case);
    }
    assert!(!simulation.finished());
    let steps = simulation.steps();
    other.destroy();
    let mut more = 0;
    while !simulation.finished() {
        simulation.advance(&case);
        more += 1;
        assert!(more < 4, "the run goes on without a device");
    }
    let run = simulation.into_run(1.0);
    let reason = run.lost.as_ref().ok_or("nothing was lost")?;
    assert!(reason.contains(device.name()), "{reason}");
    assert!(run.divergence.is_none() && !run.interrupted && run.steps >= steps);
    // The history is that of an undisturbed run up to that time; the device of the other tests is still there.
    let mut whole = begun(device, &case, Skips::WHOLE).with_batch(8);
    while whole.steps() < run.steps {
        whole.advance(&case);
    }
    let whole = whole.into_run(1.0);
    assert!(run.history.len() > 10 && run.history == whole.history[..run.history.len()]);
    assert!(run.events == whole.events[..run.events.len()]);
    Ok(())
}

/// A case at other velocities [m/s].
fn at(case: &Case, velocities: &[f64]) -> Vec<Case> {
    let at = |velocity: &f64| {
        let mut case = case.clone();
        case.projectile.as_mut().unwrap().velocity = *velocity;
        case
    };
    velocities.iter().map(at).collect()
}

fn prepared(case: &Case) -> PreparedShot {
    PreparedShot::new(case.clone()).unwrap_or_else(|e| panic!("{e}"))
}

/// Everything that shots gave, in their order.
fn together(batch: &mut DeviceBatch<'_>, cases: &[Case]) -> Vec<Vec<String>> {
    let shots: Vec<PreparedShot> = cases.iter().map(prepared).collect();
    assert!(batch.takes(&shots[0], shots.len()));
    let mut results = vec![Vec::new(); cases.len()];
    let mut ended = |number: usize, run: &Run| {
        assert!(results[number].is_empty(), "reported twice");
        results[number] = result(&cases[number], run);
        true
    };
    assert_eq!(batch.fire(&shots, &AtomicBool::new(false), &mut ended), Ok(true));
    results
}

fn each_as_alone(device: &'static Device) -> Outcome {
    let mut clay = pack();
    clay.backing = Some(Backing { material: BackingMaterial::Clay, gap: 0.0, pressure: 0.71e6, doubling_depth: None });
    for (case, velocities) in [
        // One whose numbers blow up ends alone.
        (ply(), &[400.0, 250.0, 1e30, 400.5][..]),
        (pack(), &[500.0, 350.0, 650.0]),
        (clay, &[500.0, 350.0]),
        (quarter(), &[350.0, 140.0, 250.0]),
        (edges(), &[400.0, 550.0]),
    ] {
        let cases = at(&case, velocities);
        let runs: Vec<Run> = cases.iter().map(|case| run_until(device, case, &AtomicBool::new(false))).collect();
        for (velocity, run) in velocities.iter().zip(&runs) {
            assert_eq!(run.divergence.is_some(), *velocity > 1e6, "{velocity} m/s");
        }
        assert!(runs.iter().any(|run| !run.events.is_empty()), "nothing has failed");
        let alone: Vec<_> = cases.iter().zip(&runs).map(|(case, run)| result(case, run)).collect();
        let room = cases.len() as u64 + 1;
        let mut batch = DeviceBatch::new(device, &prepared(&cases[0]), room).map_err(|e| e.to_string())?;
        assert!(together(&mut batch, &cases) == alone, "{velocities:?} together");
        // With other neighbours, in another place, and after a batch that has left its traces.
        let turned = together(&mut batch, &[cases[1].clone(), cases[0].clone()]);
        assert!(turned == [alone[1].clone(), alone[0].clone()], "{velocities:?} turned");
        assert!(batch.room() == room && batch.bytes() > 0);
    }
    Ok(())
}

fn batch_options<'a>(device: &'a Device, interrupt: &'a AtomicBool) -> BatchOptions<'a> {
    let (device, precision, progress) = (Some(device), Precision::F32, &|_| {});
    BatchOptions { seed: 3, threads: 1, threads_per_shot: 1, precision, device, interrupt, resume: false, progress }
}

/// Shots in an empty folder until the end, or the first row where `once` is set: how they ended, their rows, and how many the device computed
/// at a time at most.
fn fired(
    device: &Device,
    case: &Case,
    shots: &[(u32, f64)],
    once: bool,
) -> (Result<(), BatchError>, Vec<ShotRow>, u64) {
    let (place, stop) = (TempDir::new().unwrap(), AtomicBool::new(false));
    let folder = Folder::prepare_for(place.path(), &[], &[]).unwrap_or_else(|e| panic!("{e}"));
    let orders: Vec<ShotOrder> =
        shots.iter().map(|(shot, velocity)| ShotOrder { shot: *shot, velocity: Some(*velocity) }).collect();
    let batch = Batch::open(case.clone(), &batch_options(device, &stop), &folder, "shots.csv").unwrap();
    let ended = batch.fire(&orders, 1, &|_| stop.store(once, Ordering::Relaxed));
    let rows = batch.table().rows(u32::MAX).cloned().collect();
    (ended, rows, batch.room())
}

/// A small ply that differs from shot to shot.
fn varied(sets: &[&str]) -> Case {
    let small = ["/pack/width_mm=25.4", "/pack/height_mm=25.4", "/pack/elements_per_crossover=2", "/expect=[]"];
    shipped("cases/s720-1ply-155.json", &[&small[..], sets].concat())
}

fn batch_rows(device: &'static Device) -> Outcome {
    const STRENGTH: &str = r#"/variability={"velocity": {"scatter_m_s": 5}, "obliquity": {"scatter_deg": 1},
        "yarn_strength": {"shape": 11.5, "gauge_length_mm": 125, "yarn_shape": 20}}"#;
    let case = varied(&[STRENGTH, "/solver/end_time_us=20"]);
    // The third is faster than any case may ask for.
    let shots = [(0, 400.0), (1, 300.0), (2, 1e6), (3, 500.0)];
    let (ended, all, at_a_time) = fired(device, &case, &shots, false);
    ended.map_err(|e| e.to_string())?;
    assert_eq!((all.len(), at_a_time), (4, 3), "those that can be set up go together");
    assert!(all[2].outcome.is_none() && all[2].reason.contains("velocity"), "{:?}", all[2]);
    assert!(all.iter().all(|row| row.order.shot == 2 || row.outcome.is_some()), "{all:?}");
    for (number, shot) in shots.iter().enumerate() {
        assert_eq!(fired(device, &case, &[*shot], false).1, [all[number].clone()], "shot {number} alone");
    }
    assert_eq!(fired(device, &case, &[shots[3], shots[1]], false).1, [all[1].clone(), all[3].clone()]);
    // Other moduli give another time step: each has pipelines of its own.
    let case = varied(&[r#"/variability={"modulus": {"scatter": 0.05}}"#, "/solver/end_time_us=10"]);
    let (_, rows, at_a_time) = fired(device, &case, &shots[..2], false);
    assert_eq!((rows.len(), at_a_time), (2, 1));
    assert_eq!(fired(device, &case, &shots[1..2], false).1, rows[1..]);
    Ok(())
}

fn batch_interrupted(device: &'static Device) -> Outcome {
    let (ended, rows, _) = fired(device, &varied(&["/solver/end_time_us=200"]), &[(0, 900.0), (1, 60.0)], true);
    match ended {
        Err(BatchError::Interrupted) if rows.len() == 1 => Ok(()),
        other => Err(format!("{} rows, {other:?}", rows.len())),
    }
}
