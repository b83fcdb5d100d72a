//! Frames that wait beside a checkpoint, to the files for ParaView.

use std::fs;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;

use ripstop::case::Case;
use ripstop::output::frames::Recorder;
use ripstop::run::checkpoint::{Checkpointable, Header};
use ripstop::run::{self, Observer, Options, View};

use super::checkpoint::small;
use super::sealed::Plain;
use super::{assert_told, folder, write};

/// The run with its frames.
struct Scene {
    case: Case,
    head: Header,
    frames: Vec<(String, Vec<u8>)>,
}

/// The first byte chooses the scene, the frame, whether the rest is its file or changes of it, and whether a series is written, too.
pub(crate) fn frames(bytes: &[u8]) {
    static SCENES: OnceLock<[Scene; 2]> = OnceLock::new();
    let scenes = SCENES.get_or_init(|| [scene(1), scene(2)]);
    let [first, rest @ ..] = bytes else { return };
    let scene = &scenes[usize::from(first & 1)];
    let chosen = usize::from(first >> 2) % scene.frames.len();
    let folder = folder();
    for (number, (name, file)) in scene.frames.iter().enumerate() {
        let path = folder.path().join("checkpoint.frames").join(name);
        match (number == chosen, first & 2 == 0) {
            (true, true) => write(&path, &Plain::of(file).edited(rest).seal()),
            (true, false) => write(&path, rest),
            _ => write(&path, file),
        }
    }
    let options = Options::default().threads(1);
    let (recorder, lost) = Recorder::resume(folder.path(), &scene.case, &options, first & 64 != 0, &scene.head);
    assert!(lost.is_none_or(|lost| lost.contains("are lost: ")));
    if let Err(error) = recorder.finish() {
        assert_told(&error.to_string());
    }
}

/// Takes frames, and stops the run when some lie on the disk.
struct Taken<'a> {
    recorder: Recorder,
    head: Header,
    interrupt: &'a AtomicBool,
}

impl Observer for Taken<'_> {
    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.recorder.snapshot_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        self.recorder.on_snapshot(view);
        let [time, time_step] = view.clock();
        if time > 1e-6 {
            self.interrupt.store(true, std::sync::atomic::Ordering::Relaxed);
        }
        self.head = Header { step: view.step(), time, time_step, ..self.head.clone() };
    }

    fn on_checkpoint(&mut self, run: &dyn Checkpointable, _: f64) {
        assert_eq!(self.recorder.settle(), None);
        self.head.step += 1;
        self.head.time = run.time();
    }
}

fn scene(plies: u32) -> Scene {
    let case = small(plies, "clamped");
    let folder = folder();
    let options = Options::default().threads(1);
    let head = Header::new(&case, &options, 1e-6);
    let interrupt = AtomicBool::new(false);
    let recorder = Recorder::new(folder.path(), &case, &options, false, Some(&head));
    let mut taken = Taken { recorder, head, interrupt: &interrupt };
    run::run(&case, options, &interrupt, &mut taken).expect("a run");
    let entries = fs::read_dir(folder.path().join("checkpoint.frames")).expect("frames");
    let read = |entry: fs::DirEntry| {
        (entry.file_name().into_string().expect("a name"), fs::read(entry.path()).expect("a frame"))
    };
    let mut frames: Vec<(String, Vec<u8>)> = entries.map(|entry| read(entry.expect("a frame"))).collect();
    frames.sort();
    assert!(frames.len() > 2, "{}", frames.len());
    Scene { case, head: taken.head, frames }
}
