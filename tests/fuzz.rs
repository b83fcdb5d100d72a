//! What fuzzers have found, and what they began with, once more.
//!
//! Promise: any case, changes of it, fabric file, checkpoint, or frame beside a checkpoint is taken or refused
//! in words. Nothing panics, and nothing goes on for ever.
//! Red when: one of the inputs under `tests/fuzz/corpora` panics, or the program ends with it in another way than by an exit code of
//! its own. Every finding is one of them; what mended it has a test of its own where it belongs.
//! Cannot see: what no input has led to. `fuzz/` looks for that; the book says how.

pub(crate) mod targets;

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::support::Random;

/// Inputs of a target, in the order of their names.
fn corpus(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpora").join(target);
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut inputs: Vec<(String, Vec<u8>)> = paths
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&path).unwrap()))
        .collect();
    inputs.sort();
    assert!(inputs.len() >= 4, "{target}: {}", inputs.len());
    inputs
}

/// Feeds a target with its corpus, and with each input changed so many times, the same on every machine. `RIPSTOP_FUZZ` is another
/// number of changes; another number makes other ones.
fn replay(target: &str, run: fn(&[u8]), changes: u64) {
    let asked = std::env::var("RIPSTOP_FUZZ").ok().map(|count| count.parse().unwrap());
    let mut random = Random(asked.unwrap_or(0x5eed));
    for (name, bytes) in corpus(target) {
        let mut told = Told { target, name, bytes: bytes.clone() };
        run(&bytes);
        for _ in 0..asked.unwrap_or(changes) {
            told.bytes = altered(&bytes, &mut random);
            run(&told.bytes);
        }
    }
}

/// Keeps the input that a panic came from.
struct Told<'a> {
    target: &'a str,
    name: String,
    bytes: Vec<u8>,
}

impl Drop for Told<'_> {
    #[allow(clippy::print_stderr, reason = "whoever reads of the panic wants the input")]
    fn drop(&mut self) {
        if std::thread::panicking() {
            let path = std::env::temp_dir().join(format!("ripstop-fuzz-{}-{}", self.target, self.name));
            let kept = fs::write(&path, &self.bytes).is_ok();
            eprintln!(
                "from {}, {}",
                self.name,
                if kept { path.display().to_string() } else { format!("{:?}", self.bytes) }
            );
        }
    }
}

/// One to four places changed: a byte replaced or removed, up to 16 bytes put in.
fn altered(bytes: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..random.between(1.0, 5.0) as usize {
        let at = random.between(0.0, bytes.len() as f64) as usize;
        match random.between(0.0, 3.0) as u8 {
            0 if at < bytes.len() => bytes[at] = random.between(0.0, 256.0) as u8,
            1 if at < bytes.len() => drop(bytes.remove(at)),
            _ => {
                let new: Vec<u8> =
                    (0..random.between(1.0, 17.0) as usize).map(|_| random.between(0.0, 256.0) as u8).collect();
                let at = if random.between(0.0, 2.0) < 1.0 { at } else { bytes.len() };
                bytes.splice(at..at, new).for_each(drop);
            }
        }
    }
    bytes
}

#[test]
fn cases_are_read_or_refused() {
    replay("case", targets::case, 20);
}

#[test]
fn checkpoints_are_gone_on_from_or_refused() {
    replay("checkpoint", targets::checkpoint, 5);
}

#[test]
fn frames_beside_a_checkpoint_are_read_or_refused() {
    replay("frames", targets::frames, 5);
}

/// Runs the program in a folder; it ends by itself, with an exit code that is documented.
fn program(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ripstop"));
    let output = command.args(arguments).current_dir(folder).stdin(Stdio::null()).output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code().is_some_and(|code| code <= 2), "{:?}: {message}", output.status);
    assert!(!message.contains("panicked"), "{message}");
    output
}

/// What is printed is not in the library.
#[test]
fn the_program_takes_every_case_or_says_why_not() {
    for (name, bytes) in corpus("case") {
        let folder = targets::folder();
        let parts = targets::parts(&bytes);
        fs::create_dir(folder.path().join("fabrics")).unwrap();
        fs::write(folder.path().join("shot.json"), parts[0]).unwrap();
        for (file, text) in [("fabrics/own.json", parts.get(2)), ("fabrics/s-720.json", None)] {
            let builtin = ripstop::case::builtin_fabric("fabrics/s-720.json").unwrap().as_bytes();
            fs::write(folder.path().join(file), text.unwrap_or(&builtin)).unwrap();
        }
        let sets = String::from_utf8_lossy(parts.get(1).unwrap_or(&&b""[..])).into_owned();
        // What the system itself does not take as an argument never comes to the program.
        let sets: Vec<String> =
            sets.lines().filter(|set| !set.contains('\0')).take(6).map(|set| format!("--set={set}")).collect();
        let arguments: Vec<&str> = ["check", "shot.json"].into_iter().chain(sets.iter().map(String::as_str)).collect();
        let _told = Told { target: "program", name, bytes };
        program(folder.path(), &arguments);
    }
}
