//! A checkpoint, to the results of the run that goes on from it.

use std::fs::File;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use ripstop::case::{self, Case};
use ripstop::output::report::{self, Animation};
use ripstop::output::{self, Folder, StagedFrames};
use ripstop::run::RunScalar;
use ripstop::run::checkpoint::{BackendId, Checkpoint, Checkpointable as _, Header};
use ripstop::run::{self, Observer, Options, Precision, Simulation, Skips, View};

use super::sealed::Plain;
use super::{assert_told, folder, write};

/// Steps before a checkpoint.
const BEFORE: usize = 12;
/// Steps of a run that should have ended long before.
const TOO_MANY: usize = 1000;

/// A case, and a checkpoint of a run of it.
struct Scene {
    case: Case,
    plain: Plain,
}

/// The first byte chooses: the file itself, or changes of a checkpoint of one ply or of a pack; and whether the results are written.
pub(crate) fn checkpoint(bytes: &[u8]) {
    static SCENES: OnceLock<[Scene; 2]> = OnceLock::new();
    let scenes =
        SCENES.get_or_init(|| [scene::<f64>(1, Precision::F64, "clamped"), scene::<f32>(2, Precision::F32, "free")]);
    let Some((first, rest)) = bytes.split_first() else { return };
    let scene = &scenes[usize::from(first & 1)];
    let file = if first & 2 == 0 { scene.plain.clone().edited(rest).seal() } else { rest.to_vec() };
    let folder = folder();
    let path = folder.path().join("checkpoint.bin");
    write(&path, &file);
    match Checkpoint::open(&path) {
        Ok(checkpoint) => go_on(&scene.case, &checkpoint, (first & 4 != 0).then_some(folder.path())),
        Err(error) => assert_told(&error.to_string()),
    }
}

/// Few elements, struck hard: yarns break, plies touch.
pub(super) fn small(plies: u32, edges: &str) -> Case {
    let text = format!(
        r#"{{"title": "few elements", "fabric": {{"file": "fabrics/s-720.json"}},
        "pack": {{"plies": {plies}, "width_mm": 6.35, "height_mm": 5.08, "edges": "{edges}", "friction": 0.2}},
        "projectile": {{"shape": "sphere", "diameter_mm": 3, "mass_g": 0.2, "velocity_m_s": 600, "offset_mm": [0.3, 0.2],
            "friction": 0.1}},
        "solver": {{"end_time_us": 3, "numerics": "paper"}},
        "output": {{"history_interval_us": 0.3, "profile_times_us": [0.5, 1.5], "frames": 3}}}}"#
    );
    case::from_str("small", &text, &[]).expect("a case")
}

fn scene<S: RunScalar>(plies: u32, precision: Precision, edges: &str) -> Scene {
    let case = small(plies, edges);
    let mut simulation = Simulation::<S>::with_skips(&case, Skips::default()).expect("a model");
    let mut animation = Animation::new(&case);
    for _ in 0..BEFORE {
        animation.on_snapshot(&simulation.view());
        simulation.advance(&case);
    }
    let options = Options::default().precision(precision);
    let folder = folder();
    let path = folder.path().join("checkpoint.bin");
    let mut file = File::create(&path).expect("a file");
    simulation.save(&Header::new(&case, &options, 1e-6), &animation.to_bytes(), &mut file).expect("a checkpoint");
    Scene { case, plain: Plain::of(&std::fs::read(&path).expect("a checkpoint")) }
}

/// Films, and sees to it that a run ends.
struct Follower<'a> {
    animation: Animation,
    steps: AtomicUsize,
    interrupt: &'a AtomicBool,
}

impl Observer for Follower<'_> {
    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        let steps = self.steps.fetch_add(1, Ordering::Relaxed);
        assert!(steps < TOO_MANY, "a run of {TOO_MANY} steps that does not end");
        self.interrupt.store(steps > TOO_MANY / 2, Ordering::Relaxed);
        self.animation.snapshot_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        self.animation.on_snapshot(view);
    }

    fn on_end(&mut self, view: &View<'_>) {
        self.animation.on_end(view);
    }
}

/// As `ripstop resume` does. `path`: where the results are written, which takes longer than all else.
fn go_on(case: &Case, checkpoint: &Checkpoint, path: Option<&Path>) {
    if let Err(error) = checkpoint.check_case(case) {
        return assert_told(&error.to_string());
    }
    let head = checkpoint.head();
    let animation = match checkpoint.observer_state() {
        Ok(bytes) => Animation::resume(case, &bytes, head.step, head.time_step).unwrap_or_else(|| Animation::new(case)),
        Err(error) => return assert_told(&error.to_string()),
    };
    let BackendId::Cpu(precision) = head.backend else { return };
    let interrupt = AtomicBool::new(false);
    let mut follower = Follower { animation, steps: AtomicUsize::new(0), interrupt: &interrupt };
    let options = Options::default().threads(1).precision(precision).skips(head.skips).resume(checkpoint);
    let run = match run::run(case, options, &interrupt, &mut follower) {
        Ok(run) => run,
        Err(error) => return assert_told(&error.to_string()),
    };
    let summary = output::summary(case, &run, 1.0);
    let Some(path) = path else { return };
    let page = report::report(case, &run, &summary, &follower.animation);
    let folder = Folder::prepare(&path.join("out"), case).expect("a folder");
    folder.write(case, &run, &summary, Some(page), StagedFrames::default()).expect("results");
}
