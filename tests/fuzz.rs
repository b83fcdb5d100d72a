//! Readers of users' files, fed with any bytes: they may refuse them, but they never panic and never run on for ever.
//!
//! The programs in `fuzz/` feed these functions with bytes of a fuzzer, the suite with inputs that fuzzers began with or found something by.
//! Promise: any case, changes of it, fabric file or checkpoint is taken or refused in words.
//! Red when: one of the inputs at the end, or one of a few changes of it, panics or runs on for ever.
//! Cannot see: what no input has led to. `fuzz/` looks for that; the book says how.

use std::fs;
use std::hash::Hasher as _;
use std::io::Write as _;

use lz4_flex::frame::FrameEncoder;
use ripstop::case::{self, Case, CaseError};
use ripstop::model::Model;
use ripstop::output::{Animation, checks::case_warnings};
use ripstop::run::Simulation;
use ripstop::run::checkpoint::{Checkpoint, FORMAT};
use twox_hash::XxHash3_64;

/// Separator of the files in one input.
const CUT: &str = "\n----\n";
/// Largest number of elements of a case that becomes a model, and of one that is computed for two steps.
const MODELLED: usize = 3000;
const COMPUTED: usize = 300;

/// Refusal that says what was expected and what was found, each on one line.
fn assert_worded(text: &str) {
    assert!(text.starts_with("error: "), "{text}");
    for word in ["  expected: ", "  found: "] {
        let line = text.lines().find(|line| line.starts_with(word));
        assert!(line.is_some_and(|line| line.len() > word.len()), "{word} in {text}");
    }
}

/// One line for each part of each error, none of them empty.
#[track_caller]
pub(crate) fn assert_well_formed(error: &CaseError) {
    for error in error.all() {
        for part in [&*error.file, &error.expected, &error.found, error.help.as_deref().unwrap_or("none")] {
            assert!(!part.trim().is_empty() && !part.contains('\n'), "{error:?}");
        }
        assert!(!error.location.contains('\n'), "{error:?}");
    }
    assert_worded(&error.to_string());
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
        Err(error) => assert_well_formed(&error),
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

/// Checkpoint of a run: the file, and what is packed in one whose checksum holds.
pub(crate) fn checkpoint(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("checkpoint.bin");
    for file in [bytes.to_vec(), sealed(bytes)] {
        fs::write(&path, &file).expect("a file");
        match Checkpoint::open(&path) {
            Ok(checkpoint) => drop(Animation::from_bytes(&checkpoint.observer)),
            Err(error) => assert_worded(&error.to_string()),
        }
    }
}

/// File of a checkpoint with these contents.
fn sealed(contents: &[u8]) -> Vec<u8> {
    let mut encoder = FrameEncoder::new(Vec::new());
    encoder.write_all(contents).expect("memory");
    let packed = encoder.finish().expect("memory");
    let mut file = [b"ripstop\x1a", &FORMAT.to_le_bytes()[..], &packed].concat();
    let mut sum = XxHash3_64::new();
    sum.write(&file);
    file.extend(sum.finish().to_le_bytes());
    file
}

#[cfg(test)]
mod replay {
    use crate::support::Random;

    const SMALL: &str = r#"{"title": "small", "fabric": {"file": "fabrics/s-720.json"},
        "pack": {"width_mm": 12.7, "height_mm": 12.7, "edges": "clamped"}, "solver": {"end_time_us": 5},
        "projectile": {"shape": "sphere", "diameter_mm": 6, "mass_g": 1, "velocity_m_s": 50}}"#;
    const SETS: &str = r#"/projectile/velocity_m_s=200
/pack/edges={"left": "free"}
/pack/layup=[{}, {"orientation_deg": 45}]
/pack/layup/1/plies=2
/fabric/warp/crimp=0.03
/solver/symmetry=none"#;
    const FABRIC: &str = include_str!("../cases/fabrics/s-720.json");

    /// Feeds a target with inputs, and with changes of each, the same on every machine.
    fn replay(inputs: &[Vec<u8>], run: fn(&[u8]), changes: usize) {
        let mut random = Random(0x5eed);
        for bytes in inputs {
            run(bytes);
            for _ in 0..changes {
                let changed = altered(bytes, &mut random);
                let _shown = Shown(&changed);
                run(&changed);
            }
        }
    }

    /// Input that is printed where it makes a target panic.
    struct Shown<'a>(&'a [u8]);

    impl Drop for Shown<'_> {
        #[allow(clippy::print_stderr, reason = "a panic without its input cannot be repeated")]
        fn drop(&mut self) {
            if std::thread::panicking() {
                eprintln!("{:?}", self.0);
            }
        }
    }

    /// One to four places changed: a byte replaced or removed, up to 16 bytes put in.
    fn altered(bytes: &[u8], random: &mut Random) -> Vec<u8> {
        let mut bytes = bytes.to_vec();
        for _ in 0..random.between(1.0, 5.0) as usize {
            let at = random.between(0.0, bytes.len() as f64) as usize;
            let mut byte = || random.between(0.0, 256.0) as u8;
            match byte() % 3 {
                0 if at < bytes.len() => bytes[at] = byte(),
                1 if at < bytes.len() => drop(bytes.remove(at)),
                _ => {
                    let new: Vec<u8> = (0..=byte() % 16).map(|_| byte()).collect();
                    bytes.splice(at..at, new).for_each(drop);
                }
            }
        }
        bytes
    }

    #[test]
    fn cases_are_read_or_refused() {
        let own = SMALL.replace("s-720", "own");
        let with_fabric = [&own, "/solver/end_time_us=3", FABRIC].join(super::CUT);
        let inputs =
            [with_fabric.into_bytes(), [SMALL, SETS].join(super::CUT).into_bytes(), b"{\"title\": \"\xff\"}".to_vec()];
        replay(&inputs, super::case, 20);
    }

    #[test]
    fn checkpoints_are_resumed_or_refused() {
        // A file of format 9, whose contents are none.
        replay(&[b"\x02ripstop\x1a\x09\0\0\0\x04\0\0\0abcd12345678".to_vec()], super::checkpoint, 5);
    }
}
