//! Inputs that fuzzers began with or found something by, once more.
//!
//! Promise: any case, changes of it, fabric file or checkpoint is taken or refused in words.
//! Red when: one of the inputs under `tests/fuzz/corpora`, or one of a few changes of it, panics or runs on for ever.
//! Cannot see: what no input has led to. `fuzz/` looks for that; the book says how.

pub(crate) mod targets;

use std::fs;
use std::path::Path;

use crate::support::Random;

/// Feeds a target with its corpus, and with changes of each input, the same on every machine.
fn replay(target: &str, run: fn(&[u8]), changes: usize) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpora").join(target);
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    assert!(!paths.is_empty(), "{target}");
    let mut random = Random(0x5eed);
    for path in paths {
        let bytes = fs::read(&path).unwrap();
        run(&bytes);
        for _ in 0..changes {
            let changed = altered(&bytes, &mut random);
            let _shown = Shown { path: &path, bytes: &changed };
            run(&changed);
        }
    }
}

/// Input that is printed where it makes a target panic.
struct Shown<'a> {
    path: &'a Path,
    bytes: &'a [u8],
}

impl Drop for Shown<'_> {
    #[allow(clippy::print_stderr, reason = "a panic without its input cannot be repeated")]
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("from {}: {:?}", self.path.display(), self.bytes);
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
    replay("case", targets::case, 20);
}

#[test]
fn checkpoints_are_resumed_or_refused() {
    replay("checkpoint", targets::checkpoint, 5);
}
