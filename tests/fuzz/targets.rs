//! Readers of users' files, fed with any bytes: they may refuse them, but they never panic and never run on for ever.
//!
//! The programs in `fuzz/` feed these functions with bytes of a fuzzer, the suite with the corpora beside this file.

use std::fs::{self, File};
use std::hash::Hasher as _;
use std::io::{Read as _, Write as _};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use lz4_flex::frame::{FrameDecoder, FrameEncoder};
use ripstop::case::{self, Case};
use ripstop::model::Model;
use ripstop::output::{self, Animation, checks::case_warnings};
use ripstop::run::checkpoint::{BackendId, Checkpoint, Checkpointable as _, Header};
use ripstop::run::{self, Observer, Options, Precision, RunScalar, Simulation, Skips};
use twox_hash::XxHash3_64;

/// Separator of the files in one input.
const CUT: &str = "\n----\n";
/// Largest number of elements of a case that becomes a model, and of one that is computed for two steps.
const MODELLED: usize = 3000;
const COMPUTED: usize = 300;
/// Steps before a checkpoint is written, and steps within which the run ends.
const BEFORE: usize = 12;
const TOO_MANY: usize = 1000;

/// Refusal that says what was expected and what was found, each on one line.
fn assert_worded(text: &str) {
    assert!(text.starts_with("error: "), "{text}");
    for word in ["  expected: ", "  found: "] {
        let line = text.lines().find(|line| line.starts_with(word));
        assert!(line.is_some_and(|line| line.len() > word.len()), "{word} in {text}");
    }
}

/// Case, then a change on every line, then the fabric file `fabrics/own.json`.
pub(crate) fn case(bytes: &[u8]) {
    let whole = std::str::from_utf8(bytes);
    let mut parts = whole.unwrap_or("").split(CUT);
    let text = parts.next().unwrap_or("");
    let sets: Vec<String> = parts.next().unwrap_or("").lines().take(6).map(str::to_owned).collect();
    let read = match (whole, parts.next()) {
        (Ok(_), None) => case::from_str("shot.json", text, &sets),
        (_, fabric) => {
            let folder = tempfile::tempdir().expect("a folder");
            fs::create_dir(folder.path().join("fabrics")).expect("a folder");
            fs::write(folder.path().join("fabrics/own.json"), fabric.unwrap_or("{}")).expect("a file");
            let path = folder.path().join("shot.json");
            fs::write(&path, if whole.is_ok() { text.as_bytes() } else { bytes }).expect("a file");
            case::read(&path, &sets)
        }
    };
    match read {
        Ok(case) => checked(&case),
        Err(error) => {
            for error in error.all() {
                for part in [&*error.file, &error.location, &error.expected, &error.found] {
                    assert!(!part.contains('\n'), "{error:?}");
                }
            }
            assert_worded(&error.to_string());
        }
    }
}

/// Report, warnings, model and two steps of a case that was taken.
fn checked(case: &Case) {
    assert!(!case::report(case).is_empty());
    drop(case_warnings(case));
    // The case as run is a case again, and the same one; memory alone may have become less.
    match case::from_str("again.json", &case.as_run.to_string(), &[]) {
        Ok(again) => assert_eq!(again.fields.len(), case.fields.len()),
        Err(error) => assert!(error.location == "/pack" && error.expected.contains("memory"), "{error}"),
    }
    let elements: usize =
        case.layers().iter().map(|layer| layer.plies as usize * layer.counts().into_iter().product::<usize>()).sum();
    assert!(elements > 0, "{elements}");
    if elements <= COMPUTED {
        if let Ok(mut simulation) = Simulation::<f64>::new(case) {
            (0..2).for_each(|_| {
                simulation.advance(case);
            });
        }
    } else if elements <= MODELLED {
        Model::<f32>::part(case).ok();
    }
}

/// Checkpoint of a run. The first byte chooses: changes of one of a ply or of a pack, or the file itself.
pub(crate) fn checkpoint(bytes: &[u8]) {
    static SCENES: OnceLock<[(Case, Plain); 2]> = OnceLock::new();
    let scenes =
        SCENES.get_or_init(|| [saved::<f64>(1, "clamped", Precision::F64), saved::<f32>(2, "free", Precision::F32)]);
    let Some((first, rest)) = bytes.split_first() else { return };
    let (case, plain) = &scenes[usize::from(first & 1)];
    let file = if first & 2 == 0 { plain.clone().edited(rest).seal() } else { rest.to_vec() };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("checkpoint.bin");
    fs::write(&path, &file).expect("a file");
    match Checkpoint::open(&path) {
        Ok(checkpoint) => resume(case, &checkpoint),
        Err(error) => assert_worded(&error.to_string()),
    }
}

/// Few elements, struck hard: yarns break, plies touch; and a checkpoint of them.
fn saved<S: RunScalar>(plies: u32, edges: &str, precision: Precision) -> (Case, Plain) {
    let text = format!(
        r#"{{"title": "few elements", "fabric": {{"file": "fabrics/s-720.json"}},
        "pack": {{"plies": {plies}, "width_mm": 6.35, "height_mm": 5.08, "edges": "{edges}", "friction": 0.2}},
        "projectile": {{"shape": "sphere", "diameter_mm": 3, "mass_g": 0.2, "velocity_m_s": 600, "offset_mm": [0.3, 0.2],
            "friction": 0.1}},
        "solver": {{"end_time_us": 3, "numerics": "paper"}},
        "output": {{"history_interval_us": 0.3, "profile_times_us": [0.5, 1.5], "frames": 3}}}}"#
    );
    let case = case::from_str("small", &text, &[]).expect("a case");
    let mut simulation = Simulation::<S>::with_skips(&case, Skips::default()).expect("a model");
    let mut animation = Animation::new(&case);
    for _ in 0..BEFORE {
        animation.on_snapshot(&simulation.view());
        simulation.advance(&case);
    }
    let options = Options::default().precision(precision);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("checkpoint.bin");
    let mut file = File::create(&path).expect("a file");
    simulation.save(&Header::new(&case, &options, 1e-6), &animation.to_bytes(), &mut file).expect("a checkpoint");
    (case, Plain::of(&fs::read(&path).expect("a checkpoint")))
}

/// Observer that sees to it that a run ends.
struct Bounded<'a> {
    steps: AtomicUsize,
    interrupt: &'a AtomicBool,
}

impl Observer for Bounded<'_> {
    fn snapshot_due(&self, _: f64, _: f64) -> bool {
        let steps = self.steps.fetch_add(1, Ordering::Relaxed);
        assert!(steps < TOO_MANY, "a run of {TOO_MANY} steps that does not end");
        self.interrupt.store(steps > TOO_MANY / 2, Ordering::Relaxed);
        false
    }
}

/// Run that goes on from a checkpoint, as `ripstop resume` does.
fn resume(case: &Case, checkpoint: &Checkpoint) {
    if let Err(error) = checkpoint.check_case(case) {
        return assert_worded(&error.to_string());
    }
    let head = &checkpoint.header;
    drop(Animation::from_bytes(&checkpoint.observer));
    let BackendId::Cpu(precision) = head.backend else { return };
    let interrupt = AtomicBool::new(false);
    let mut observer = Bounded { steps: AtomicUsize::new(0), interrupt: &interrupt };
    let options = Options::default().threads(1).precision(precision).skips(head.skips).resume(checkpoint);
    match run::run(case, options, &interrupt, &mut observer) {
        Ok(run) => drop(output::summary(case, &run, 1.0)),
        Err(error) => assert_worded(&error.to_string()),
    }
}

/// Bytes before what is packed: what the file begins with, and the number of the format.
const START: usize = 12;
/// Bytes of the checksum.
const SUM: usize = 8;

/// Contents of a checkpoint, unpacked.
#[derive(Clone)]
pub(crate) struct Plain {
    start: Vec<u8>,
    head: Vec<u8>,
    contents: Vec<u8>,
}

impl Plain {
    /// Unpacks a file that is whole.
    pub(crate) fn of(file: &[u8]) -> Self {
        let mut all = Vec::new();
        FrameDecoder::new(&file[START..file.len() - SUM]).read_to_end(&mut all).expect("a whole file");
        let (_, contents) = postcard::take_from_bytes::<Header>(&all).expect("a header");
        let head = &all[..all.len() - contents.len()];
        Self { start: file[..START].into(), head: head.into(), contents: contents.into() }
    }

    /// Packs it again, with a checksum that holds.
    pub(crate) fn seal(&self) -> Vec<u8> {
        let mut encoder = FrameEncoder::new(Vec::new());
        encoder.write_all(&[&self.head[..], &self.contents].concat()).expect("memory");
        let mut file = [&self.start[..], &encoder.finish().expect("memory")].concat();
        let mut sum = XxHash3_64::new();
        sum.write(&file);
        file.extend(sum.finish().to_le_bytes());
        file
    }

    /// Makes changes: each has a byte that says what, a place, a count and as many bytes.
    pub(crate) fn edited(mut self, mut edits: &[u8]) -> Self {
        while let [what, low, high, count, rest @ ..] = edits {
            let count = usize::from(count & 31);
            let new = &rest[..count.min(rest.len())];
            edits = &rest[new.len()..];
            let part = if what & 1 == 0 { &mut self.contents } else { &mut self.head };
            let place = usize::from(u16::from_le_bytes([*low, *high]));
            let place = if what & 2 == 0 { place } else { part.len().saturating_sub(place) };
            let at = place.min(part.len());
            let end = (at + count).min(part.len());
            match (what >> 2) & 3 {
                0 => part.splice(at..(at + new.len()).min(part.len()), new.iter().copied()).for_each(drop),
                1 => part.splice(at..at, new.iter().copied()).for_each(drop),
                2 => part.splice(at..end, []).for_each(drop),
                _ => part[at..end].iter_mut().for_each(|byte| *byte ^= 1 << (what >> 5)),
            }
        }
        self
    }
}
