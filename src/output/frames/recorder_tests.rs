use std::fs;
use std::sync::atomic::AtomicBool;

use super::*;
use crate::case;
use crate::run;

/// The frames of a small shot, where so many bytes may wait in memory; how many waited on the disk at the end.
fn written(room: Option<usize>) -> (Vec<u8>, usize) {
    let sets =
        ["/pack/width_mm=11.43", "/pack/height_mm=11.43", "/solver/end_time_us=40", "/output/frames=9", "/expect=[]"];
    let case = case::shipped(&sets);
    let folder = tempfile::tempdir().unwrap_or_else(|error| unreachable!("{error}"));
    let mut recorder = Recorder::new(folder.path(), &case, &Options::default(), false, None);
    recorder.room = room.unwrap_or(recorder.room);
    let run = run::run(&case, Options::default(), &AtomicBool::new(false), &mut recorder);
    assert!(run.is_ok());
    let spooled = recorder.waiting.values().filter(|frame| frame.snapshot.is_none()).count();
    let files = |path: &Path| fs::read_dir(path).map_or(0, Iterator::count);
    let lying = recorder.spool.as_ref().map_or(0, |spool| files(spool.folder()));
    assert_eq!(lying, recorder.waiting.values().filter(|frame| frame.spooled).count(), "files given up lie there");
    let names = recorder
        .finish()
        .and_then(|staged| staged.place(folder.path()).map_err(|error| failed(folder.path(), HDF)(error)));
    assert_eq!(names.unwrap_or_else(|error| unreachable!("{error}")), [HDF]);
    assert_eq!(files(folder.path()), 1, "something is left");
    (fs::read(folder.path().join(HDF)).unwrap_or_default(), spooled)
}

#[test]
fn frames_that_have_waited_on_the_disk_are_the_same() {
    let (from_memory, none) = written(None);
    let (from_disk, some) = written(Some(20_000));
    assert!(none == 0 && some >= 9, "{none} {some}");
    assert!(from_memory.len() > 10_000 && from_memory == from_disk);
}
