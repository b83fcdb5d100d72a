//! When checkpoints are taken, and what becomes of the last one.

use std::time::Instant;

use ripstop::output::CheckpointWriter;
use ripstop::output::{CHECKPOINT, Folder};
use ripstop::run::{self, Observer};

use super::*;

/// Takes every checkpoint it is offered, and notes their times.
struct Noted<'a> {
    keeper: CheckpointWriter<'a>,
    times: Vec<f64>,
}

impl Observer for Noted<'_> {
    fn checkpoint_due(&self, time: f64, dt: f64) -> bool {
        self.keeper.is_due(time, dt)
    }

    fn on_checkpoint(&mut self, run: &dyn Checkpointable, loop_seconds: f64) {
        self.keeper.write(run, &[], loop_seconds).unwrap();
        self.times.push(run.time());
    }
}

#[test]
fn no_more_than_an_interval_is_ever_lost() {
    let (case, shelf) = (ply(), TempDir::new().unwrap());
    let folder = Folder::prepare(shelf.path(), &case).unwrap();
    let options = Options::default().threads(1);
    let every = 2.5e-6;
    let keeper = CheckpointWriter::new(&folder, &case, Header::new(&case, &options, every), Instant::now());
    let mut noted = Noted { keeper, times: vec![0.0] };
    let run = run::run(&case, options, &false.into(), &mut noted).unwrap();
    noted.times.push(run.history.last().unwrap().time);
    assert_eq!(noted.times.len(), 1 + 14 + 1, "{:?}", noted.times);
    for pair in noted.times.windows(2) {
        assert!(pair[1] - pair[0] <= every + run.time_step, "{pair:?}");
    }
    // Each in place of the one before, under its name only; the lock goes with the folder.
    let times = noted.times;
    drop(folder);
    let names: Vec<_> = std::fs::read_dir(shelf.path()).unwrap().map(|file| file.unwrap().file_name()).collect();
    assert_eq!(names.len(), 2, "{names:?}");
    let last = Checkpoint::open(&shelf.path().join(CHECKPOINT)).unwrap();
    assert_eq!(last.head().time, times[14]);
}

/// What is written to `/dev/full` meets a full disk.
#[cfg(target_os = "linux")]
#[test]
fn the_last_good_checkpoint_survives_a_full_disk() {
    let (case, shelf) = (ply(), TempDir::new().unwrap());
    let folder = Folder::prepare(shelf.path(), &case).unwrap();
    let head = Header::new(&case, &Options::default(), 1e-6);
    let mut keeper = CheckpointWriter::new(&folder, &case, head, Instant::now());
    let mut simulation = start::<f64>(&case);
    let mut advance = || {
        for _ in 0..20 {
            simulation.advance(&case);
        }
        let step = simulation.state.step;
        (keeper.write(&simulation, &[], 1.0), step)
    };
    let kept = || Checkpoint::open(&shelf.path().join(CHECKPOINT)).map(|last| last.head().step);
    assert_eq!(advance(), (Ok(()), 20));
    std::os::unix::fs::symlink("/dev/full", shelf.path().join(".checkpoint.bin.tmp")).unwrap();
    let complaint = advance().0.unwrap_err().to_string();
    assert!(complaint.contains("No space left on device"), "{complaint}");
    assert!(complaint.contains("µs is still there"), "{complaint}");
    assert_eq!(kept(), Ok(20));
    // Room again.
    assert_eq!(advance(), (Ok(()), 60));
    assert_eq!(kept(), Ok(60));
}
