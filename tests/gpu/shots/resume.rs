//! Runs that go on from a checkpoint.

use std::fs::File;
use std::path::PathBuf;

use ripstop::case::{Case, ContactSampling};
use ripstop::gpu::Device;
use ripstop::run::checkpoint::{Checkpoint, CheckpointError, CheckpointReason, Checkpointable, Header};
use ripstop::run::device::DeviceSimulation;
use ripstop::run::{self, Observer, Options, Run, RunError, Skips};
use tempfile::TempDir;

use super::{Outcome, Tests, sound};
use crate::kept::{pack, ply, result};
use crate::support::Random;

pub(super) const TESTS: Tests = &[
    ("one_ply_goes_on_bit_by_bit_from_14_random_times", |device| resumes_equal(device, &ply(), random::<14, 21>)),
    ("a_pack_goes_on_bit_by_bit_from_6_random_times", |device| resumes_equal(device, &pack(), random::<6, 22>)),
    ("contact_at_the_rim_goes_on_bit_by_bit_from_3_random_times", |device| {
        resumes_equal(device, &rim(), random::<3, 23>)
    }),
    ("what_does_not_fit_is_refused", refused),
    ("what_each_kernel_took_so_far_is_kept", keeps_times),
];

/// Keeps a run at given times [s], ascending.
struct Shelf {
    folder: TempDir,
    head: Header,
    times: Vec<f64>,
    kept: Vec<PathBuf>,
}

impl Shelf {
    fn new(case: &Case, options: &Options<'_>, times: Vec<f64>) -> Self {
        Self { folder: TempDir::new().unwrap(), head: Header::new(case, options, 1e-6), times, kept: Vec::new() }
    }
}

impl Observer for Shelf {
    fn checkpoint_due(&self, time: f64, _: f64) -> bool {
        self.times.get(self.kept.len()).is_some_and(|due| time >= *due)
    }

    fn on_checkpoint(&mut self, run: &dyn Checkpointable, _: f64) {
        let path = self.folder.path().join(self.kept.len().to_string());
        run.save(&self.head, &[], &mut File::create(&path).unwrap()).unwrap();
        self.kept.push(path);
    }
}

/// One ply that is met at the rim of the projectile's face too.
pub(super) fn rim() -> Case {
    let mut case = ply();
    case.solver.contact_sampling = ContactSampling::Edges;
    case.solver.end_time = 14e-6;
    case.output.profile_times.clear();
    case
}

fn options(device: &Device) -> Options<'_> {
    Options::default().threads(1).device(device)
}

fn run(case: &Case, options: Options<'_>, watch: &mut dyn Observer) -> Run {
    let run = run::run(case, options, &false.into(), watch);
    sound(case, run.unwrap_or_else(|e| panic!("{}: {e}", case.name)))
}

/// Times in a run at random [s], ascending.
fn random<const COUNT: usize, const SEED: u64>(case: &Case, _: &Run) -> Vec<f64> {
    let mut random = Random(SEED);
    let mut times = [0.0; COUNT].map(|_| random.between(0.0, case.solver.end_time));
    times.sort_by(f64::total_cmp);
    times.into()
}

fn resumes_equal(device: &'static Device, case: &Case, times: fn(&Case, &Run) -> Vec<f64>) -> Outcome {
    let first = run(case, options(device), &mut ());
    let times = times(case, &first);
    let count = times.len();
    let mut shelf = Shelf::new(case, &options(device), times);
    let whole = result(case, &first);
    assert!(whole.iter().any(|row| row.starts_with("FailureEvent")), "nothing has failed");
    // To keep a run changes nothing.
    assert_eq!(result(case, &run(case, options(device), &mut shelf)), whole);
    assert_eq!(shelf.kept.len(), count);
    for path in &shelf.kept {
        let checkpoint = Checkpoint::open(path).unwrap_or_else(|e| panic!("{e}"));
        let resumed = result(case, &run(case, options(device).resume(&checkpoint), &mut ()));
        for (one, two) in whole.iter().zip(&resumed) {
            assert_eq!(one, two, "from step {}", checkpoint.header().step);
        }
        assert_eq!(whole.len(), resumed.len());
    }
    Ok(())
}

fn keeps_times(device: &'static Device) -> Outcome {
    let case = ply();
    let begun = DeviceSimulation::with_skips(&case, device, Skips::default()).unwrap_or_else(|e| panic!("{e}"));
    let mut begun = begun.with_batch(10);
    (0..4).for_each(|_| begun.advance(&case));
    begun.settle(&case);
    let folder = TempDir::new().map_err(|e| e.to_string())?;
    let path = folder.path().join("kept");
    let head = Header::new(&case, &options(device), 1e-6);
    begun.save(&head, &[], &mut File::create(&path).unwrap()).unwrap();
    // Long enough for all that was timed.
    let before = begun.into_run(1e9).kernel_seconds;
    let resumed =
        DeviceSimulation::resume(&case, device, &Checkpoint::open(&path).unwrap()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(resumed.into_run(1e9).kernel_seconds, before);
    assert_eq!(before.is_empty(), !device.has_clock());
    Ok(())
}

fn refused(device: &'static Device) -> Outcome {
    let case = ply();
    let mut shelf = Shelf::new(&case, &options(device), vec![5e-6]);
    run(&case, options(device), &mut shelf);
    let checkpoint = Checkpoint::open(&shelf.kept[0]).map_err(|e| e.to_string())?;
    let fault = |result: Result<Run, RunError>| match result {
        Err(RunError::Checkpoint(CheckpointError { reason, .. })) => reason,
        other => panic!("{:?}", other.map(drop)),
    };
    let from = |case: &Case, options: Options<'_>| {
        let options = options.resume(&checkpoint);
        fault(run::run(case, options, &false.into(), &mut ()))
    };
    assert!(matches!(from(&case, Options::default()), CheckpointReason::Backend(_)));
    assert!(matches!(from(&pack(), options(device)), CheckpointReason::Case { .. }));
    // Behind the fingerprint, sizes are looked at too.
    let unfit = DeviceSimulation::resume(&pack(), device, &checkpoint).map(drop);
    assert!(matches!(unfit, Err(RunError::Checkpoint(CheckpointError { reason: CheckpointReason::Contents(_), .. }))));
    Ok(())
}
