//! Checkpoints: a run that goes on from one is the run that was never interrupted.
//!
//! Promises: from 20 random steps of a shot, in f64 and f32, for one ply and for a pack with failures, friction, profiles and
//! mirror planes, the resumed run has the same bits everywhere (history, failures, profiles, plies, summary, last
//! state), on any number of threads; a file that is damaged, cut short, foreign or of another run is refused by name.
//! Red when: something that later steps depend on is not in the file, or is not put back as it was; a changed bit of the file
//! goes unnoticed.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::ThreadPoolBuilder;
use ripstop::case::{Backing, BackingMaterial, Case};
use ripstop::output::{CHECKPOINT, CheckpointWriter, Folder};
use ripstop::run::checkpoint::{Checkpoint, Checkpointable, FORMAT, Header};
use ripstop::run::{self, Observer, Options, Run, RunError, RunScalar, Simulation, Skips};
use tempfile::TempDir;

use crate::support::Random;
use crate::support::{builtin, pack, ply, quarter, result};

fn start<S: RunScalar>(case: &Case) -> Simulation<S> {
    Simulation::with_skips(case, Skips::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn advance<S: RunScalar>(simulation: &mut Simulation<S>, case: &Case, steps: usize) {
    for _ in 0..steps {
        simulation.advance(case);
    }
}

/// A checkpoint of a run, as a file named by the steps done.
fn saved<S: RunScalar>(folder: &TempDir, case: &Case, simulation: &Simulation<S>) -> PathBuf {
    let path = folder.path().join(format!("{}.bin", simulation.state.step));
    let header = Header::new(case, &Options::default().precision(S::PRECISION), 1e-6);
    simulation.save(&header, b"seen", &mut File::create(&path).unwrap()).unwrap();
    path
}

fn open(path: &Path) -> Checkpoint {
    Checkpoint::open(path).unwrap_or_else(|e| panic!("{e}"))
}

/// Runs to the end on this number of threads: all that it gives, and its last state. `before`: called before every step.
fn finish<S: RunScalar>(
    case: &Case,
    mut simulation: Simulation<S>,
    threads: usize,
    mut before: impl FnMut(&Simulation<S>) + Send,
) -> (Run, Vec<String>) {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        while !simulation.finished(case) {
            before(&simulation);
            simulation.advance(case);
        }
        let ripstop::solver::state::State { nodes, elements, active, over, body, step } = simulation.state.clone();
        let state = [
            format!("{:?}", &nodes.data[..]),
            format!("{:?}", &elements.data[..]),
            format!("{active:?} {over:?} {body:?} {step}"),
        ];
        let run = simulation.into_run(1.0);
        let all = [result(case, &run), state.into()].concat();
        (run, all)
    })
}

/// From 20 random steps before this one the same end.
fn resumes_equal<S: RunScalar>(case: &Case, steps: u64, seed: u64) -> Run {
    let (folder, mut random) = (TempDir::new().unwrap(), Random(seed));
    let at: Vec<u64> = (0..20).map(|_| random.between(1.0, steps as f64) as u64).collect();
    let mut kept = Vec::new();
    let (run, whole) = finish(case, start::<S>(case), 2, |simulation| {
        if at.contains(&simulation.state.step) {
            kept.push(saved(&folder, case, simulation));
        }
    });
    assert!(kept.len() >= 15 && run.steps > steps, "{} of {}", kept.len(), run.steps);
    for (path, threads) in kept.iter().zip([1, 2, 3].into_iter().cycle()) {
        let resumed = Simulation::<S>::resume(case, &open(path)).unwrap_or_else(|e| panic!("{e}"));
        let (_, resumed) = finish(case, resumed, threads, |_| {});
        let other = whole.iter().zip(&resumed).find(|(one, two)| one != two);
        assert!(other.is_none() && whole.len() == resumed.len(), "{path:?} on {threads} threads: {other:?}");
    }
    run
}

#[test]
fn one_ply_goes_on_bit_by_bit() {
    let run = resumes_equal::<f64>(&ply(), 160, 1);
    assert!(run.events.len() > 20 && run.profiles.len() == 3, "{} {}", run.events.len(), run.profiles.len());
    let run = resumes_equal::<f32>(&ply(), 160, 2);
    assert!(run.events.len() > 20, "{}", run.events.len());
    let mut viscous = ply();
    viscous.solver.shock_viscosity = 0.3;
    let run = resumes_equal::<f64>(&viscous, 160, 6);
    assert!(run.events.len() > 20, "{}", run.events.len());
}

#[test]
fn a_pack_goes_on_bit_by_bit() {
    let run = resumes_equal::<f64>(&pack(), 110, 3);
    let last = run.history.last().unwrap();
    assert!(run.events.len() > 20 && last.eroded > 0, "{} {}", run.events.len(), last.eroded);
    assert!(last.balance.friction > 0.0 && run.max_ply_penetration > 0.0);
    let run = resumes_equal::<f32>(&pack(), 110, 4);
    assert!(run.events.len() > 20, "{}", run.events.len());
}

#[test]
fn a_quarter_of_a_scene_goes_on_to_its_outcome() {
    let run = resumes_equal::<f64>(&quarter(), 100, 5);
    assert_eq!((run.planes.copies(), run.stop_time.is_some()), (4, true));
    let mut backed = quarter();
    backed.backing =
        Some(Backing { material: BackingMaterial::Clay, gap: 0.05e-3, pressure: 5e6, doubling_depth: None });
    let run = resumes_equal::<f32>(&backed, 100, 7);
    assert!(run.history.last().unwrap().balance.crater > 0.2e-3, "{:?}", run.history.last());
}

#[test]
fn timings_and_the_state_of_the_observer_are_kept() {
    let (case, folder) = (pack(), TempDir::new().unwrap());
    let mut simulation = start::<f32>(&case);
    advance(&mut simulation, &case, 20);
    let checkpoint = open(&saved(&folder, &case, &simulation));
    assert_eq!(checkpoint.observer, b"seen");
    let before = simulation.into_run(1.0).kernel_seconds;
    assert!(before.len() == 4 && before.iter().all(|(_, seconds)| *seconds > 0.0), "{before:?}");
    let resumed = Simulation::<f32>::resume(&case, &checkpoint).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(resumed.into_run(1.0).kernel_seconds, before);
}

/// Observer that takes every checkpoint it is offered.
struct Noted<'a> {
    writer: CheckpointWriter<'a>,
    times: Vec<f64>,
}

impl Observer for Noted<'_> {
    fn checkpoint_due(&self, time: f64, dt: f64) -> bool {
        self.writer.is_due(time, dt)
    }

    fn on_checkpoint(&mut self, run: &dyn Checkpointable, loop_seconds: f64) {
        self.writer.write(run, &[], loop_seconds).unwrap();
        self.times.push(run.clock()[0]);
    }
}

#[test]
fn no_more_than_an_interval_is_ever_lost() {
    let (case, place) = (ply(), TempDir::new().unwrap());
    let folder = Folder::prepare(place.path(), &case).unwrap();
    let (options, every) = (Options::default().threads(1), 2.5e-6);
    let writer = CheckpointWriter::new(&folder, &case, Header::new(&case, &options, every), Instant::now());
    let mut noted = Noted { writer, times: vec![0.0] };
    let run = run::run(&case, options, &false.into(), &mut noted).unwrap();
    let mut times = noted.times;
    times.push(run.history.last().unwrap().time);
    assert_eq!(times.len(), 1 + 14 + 1, "{times:?}");
    assert!(times.windows(2).all(|pair| pair[1] - pair[0] <= every + run.time_step), "{times:?}");
    // Each in place of the one before, under its name only; the lock goes with the folder.
    drop(folder);
    assert_eq!(fs::read_dir(place.path()).unwrap().count(), 2);
    assert_eq!(open(&place.path().join(CHECKPOINT)).header.time, times[14]);
}

/// A run that meets a full disk.
struct Full;

impl Checkpointable for Full {
    fn clock(&self) -> [f64; 2] {
        [30e-6, 1e-9]
    }

    fn save(&self, _: &Header, _: &[u8], to: &mut dyn Write) -> io::Result<()> {
        to.write_all(b"half of it")?;
        Err(io::ErrorKind::StorageFull.into())
    }
}

#[test]
fn the_last_good_checkpoint_survives_a_full_disk() {
    let (case, place) = (ply(), TempDir::new().unwrap());
    let folder = Folder::prepare(place.path(), &case).unwrap();
    let header = Header::new(&case, &Options::default(), 1e-6);
    let mut writer = CheckpointWriter::new(&folder, &case, header, Instant::now());
    let mut simulation = start::<f64>(&case);
    let kept = || open(&place.path().join(CHECKPOINT)).header.step;
    advance(&mut simulation, &case, 20);
    assert_eq!((writer.write(&simulation, &[], 1.0), kept()), (Ok(()), 20));
    let complaint = writer.write(&Full, &[], 1.0).unwrap_err();
    assert!(complaint.starts_with("no checkpoint at 30.000 µs: "), "{complaint}");
    // With the case and the lock.
    assert_eq!((kept(), fs::read_dir(place.path()).unwrap().count()), (20, 3));
    // Room again.
    advance(&mut simulation, &case, 20);
    assert_eq!((writer.write(&simulation, &[], 1.0), kept()), (Ok(()), 40));
}

/// A checkpoint of the small ply after 40 steps, as a file.
fn written(folder: &TempDir) -> PathBuf {
    let case = ply();
    let mut simulation = start::<f64>(&case);
    advance(&mut simulation, &case, 40);
    saved(folder, &case, &simulation)
}

/// What is found in place of a checkpoint.
fn found(path: &Path) -> String {
    Checkpoint::open(path).err().unwrap_or_else(|| panic!("{} was taken", path.display())).found
}

#[test]
fn every_file_that_is_not_a_whole_checkpoint_is_refused() {
    const FOREIGN: &str = "another kind of file";
    const DAMAGED: &str = "one that is damaged or cut short";
    let folder = TempDir::new().unwrap();
    let path = written(&folder);
    let (whole, mut random) = (fs::read(&path).unwrap(), Random(7));
    let refused = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        found(&path)
    };
    // The beginning bit by bit, the rest at random places, the checksum itself.
    let anywhere = (0..400).map(|_| random.between(0.0, 8.0 * whole.len() as f64) as usize);
    for bit in (0..8 * 200).chain(8 * (whole.len() - 8)..8 * whole.len()).chain(anywhere) {
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        let expected = match bit / 8 {
            0..8 => FOREIGN,
            8..12 => &format!("format {}", FORMAT ^ 1 << (bit - 64)),
            _ => DAMAGED,
        };
        assert_eq!(refused(&bytes), expected, "bit {bit}");
    }
    for length in [0, 3, 8, 11, 12, 15, 60, whole.len() / 2, whole.len() - 1] {
        assert_eq!(refused(&whole[..length]), if length < 12 { FOREIGN } else { DAMAGED }, "{length} bytes");
    }
    assert_eq!(refused(&[&whole[..], &[0]].concat()), DAMAGED);
    for bytes in [&b"{\"title\": \"a case, and no checkpoint at all\"}"[..], &[0; 4096]] {
        assert_eq!(refused(bytes), FOREIGN);
    }
    let absent = Checkpoint::open(&folder.path().join("absent")).unwrap_err();
    assert_eq!(absent.expected, "a checkpoint that can be read");
}

#[test]
fn a_checkpoint_of_another_case_or_precision_is_refused() {
    let folder = TempDir::new().unwrap();
    let checkpoint = open(&written(&folder));
    let refused = |run: Result<(), RunError>, words: &str| match run {
        Err(RunError::Checkpoint(error)) if error.found.starts_with(words) => {}
        other => panic!("{other:?}"),
    };
    let smaller = builtin("cases/verify/mirror.json", &["/pack/width_mm=12.7", "/pack/height_mm=12.7"]);
    for case in [&smaller, &pack()] {
        refused(Simulation::<f64>::resume(case, &checkpoint).map(drop), "one that computes something else");
    }
    refused(Simulation::<f32>::resume(&ply(), &checkpoint).map(drop), "cpu, f32");
    assert!(Simulation::<f64>::resume(&ply(), &checkpoint).is_ok());
}
