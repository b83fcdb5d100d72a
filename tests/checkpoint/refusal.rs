//! Files that no run goes on from.

use std::fs;
use std::path::{Path, PathBuf};

use ripstop::run::RunError;
use ripstop::run::checkpoint::{CheckpointError, CheckpointFault, FORMAT};

use super::*;
use crate::fuzz::targets::Plain;
use crate::kept::pack;
use crate::scene::builtin;
use crate::support::Random;

/// A checkpoint of the small ply after 40 steps, as a file.
fn written(shelf: &Shelf) -> PathBuf {
    let case = ply();
    let mut simulation = start::<f64>(&case);
    while simulation.state.step < 40 {
        simulation.advance(&case);
    }
    shelf.save(&case, &simulation);
    shelf.0.path().join("40.bin")
}

fn fault(path: &Path) -> CheckpointFault {
    Checkpoint::open(path).err().unwrap_or_else(|| panic!("{} was taken", path.display())).fault
}

#[test]
fn every_flipped_bit_is_noticed() {
    let shelf = Shelf::new();
    let path = written(&shelf);
    let whole = fs::read(&path).unwrap();
    let mut random = Random(7);
    // The head bit by bit, the rest at random places, the checksum itself.
    let anywhere = (0..400).map(|_| random.between(0.0, 8.0 * whole.len() as f64) as usize);
    let ends = (0..8 * 200).chain(8 * (whole.len() - 8)..8 * whole.len());
    for bit in ends.chain(anywhere) {
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        fs::write(&path, &bytes).unwrap();
        let expected = match bit / 8 {
            0..8 => [CheckpointFault::Foreign, CheckpointFault::Foreign],
            8..12 => [CheckpointFault::Format(FORMAT ^ 1 << (bit - 64)), CheckpointFault::Damaged],
            _ => [CheckpointFault::Damaged, CheckpointFault::Damaged],
        };
        assert!(expected.contains(&fault(&path)), "bit {bit}");
    }
}

#[test]
fn what_is_cut_short_or_grown_is_refused() {
    let shelf = Shelf::new();
    let path = written(&shelf);
    let whole = fs::read(&path).unwrap();
    for length in [0, 3, 8, 11, 15, 16, 60, whole.len() / 2, whole.len() - 1] {
        fs::write(&path, &whole[..length]).unwrap();
        let expected = if length < 16 { CheckpointFault::Foreign } else { CheckpointFault::Damaged };
        assert_eq!(fault(&path), expected, "{length} bytes");
    }
    fs::write(&path, [&whole[..], &[0]].concat()).unwrap();
    assert_eq!(fault(&path), CheckpointFault::Damaged);
}

#[test]
fn other_files_are_foreign_and_no_file_is_unreadable() {
    let shelf = Shelf::new();
    let path = shelf.0.path().join("other");
    for bytes in [&b"{\"title\": \"a case, and no checkpoint at all\"}"[..], &[0; 4096], b""] {
        fs::write(&path, bytes).unwrap();
        assert_eq!(fault(&path), CheckpointFault::Foreign);
    }
    assert!(matches!(fault(shelf.0.path()), CheckpointFault::Unreadable(_) | CheckpointFault::Foreign));
    assert!(matches!(fault(&shelf.0.path().join("absent")), CheckpointFault::Unreadable(_)));
}

#[test]
fn a_checkpoint_of_another_model_or_precision_does_not_fit() {
    let shelf = Shelf::new();
    let checkpoint = Checkpoint::open(&written(&shelf)).unwrap();
    let smaller = builtin("cases/verify/mirror.json", &["/pack/width_mm=12.7", "/pack/height_mm=12.7"]);
    let larger = builtin("cases/verify/mirror.json", &[]);
    let case = ply();
    let refused = |run: Result<(), RunError>| match run {
        Err(RunError::Checkpoint(CheckpointError { fault: CheckpointFault::Contents(_), .. })) => {}
        other => panic!("{other:?}"),
    };
    refused(Simulation::<f64>::resume(&smaller, &checkpoint).map(drop));
    refused(Simulation::<f64>::resume(&larger, &checkpoint).map(drop));
    refused(Simulation::<f64>::resume(&pack(), &checkpoint).map(drop));
    refused(Simulation::<f32>::resume(&case, &checkpoint).map(drop));
    assert!(Simulation::<f64>::resume(&case, &checkpoint).is_ok());
}

/// Whoever goes on from a checkpoint counts through the steps before it. Found by reading, before a fuzzer did.
#[test]
fn a_head_that_no_run_can_have_is_refused() {
    let shelf = Shelf::new();
    let path = written(&shelf);
    let whole = Plain::of(&fs::read(&path).unwrap());
    let of_head = |edits: &[u8]| {
        fs::write(&path, whole.clone().edited(edits).seal()).unwrap();
        Checkpoint::open(&path).unwrap_or_else(|e| panic!("{e}")).check_case(&ply())
    };
    assert_eq!(of_head(&[]), Ok(()));
    // From the end of the head: 24 bytes of time spent, 8 of the time step, 8 of the time; before them the steps, one byte here.
    let many_steps = [7, 41, 0, 8, 255, 255, 255, 255, 255, 255, 255, 255];
    let no_time_step = [3, 32, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0];
    let another_time = [3, 40, 0, 8, 0, 0, 0, 0, 0, 0, 240, 63];
    for edits in [&many_steps[..], &no_time_step, &another_time] {
        let fault = of_head(edits).unwrap_err().fault;
        assert_eq!(fault, CheckpointFault::Contents("steps and times of the head"), "{edits:?}");
    }
    let case = ply();
    let options = Options::default();
    for head in [
        Header { every: 0.0, ..Header::new(&case, &options, 1e-6) },
        Header { every: f64::NAN, ..Header::new(&case, &options, 1e-6) },
        Header { threads: Some(1 << 20), ..Header::new(&case, &options, 1e-6) },
    ] {
        let mut simulation = start::<f64>(&case);
        simulation.advance(&case);
        simulation.save(&head, &[], &mut File::create(&path).unwrap()).unwrap();
        let checkpoint = Checkpoint::open(&path).unwrap_or_else(|e| panic!("{e}"));
        let fault = checkpoint.check_case(&case).unwrap_err().fault;
        assert_eq!(fault, CheckpointFault::Contents("steps and times of the head"), "{head:?}");
    }
}
