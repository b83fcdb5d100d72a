//! Disks and folders that refuse: one error and its exit code, nothing half written, nothing of others lost.
#![cfg(unix)]

use std::os::unix::fs::{MetadataExt as _, PermissionsExt, chown};
use std::os::unix::process::CommandExt as _;

use super::resume::long;
use super::*;
use crate::kept::{files, same_files, wait_for_another};

/// Says that one thing went wrong, and what.
#[track_caller]
fn refused(output: &Output, parts: &[&str]) {
    let message = stderr(output);
    assert_eq!(code(output), 2, "{message}");
    assert_eq!(message.lines().filter(|line| line.starts_with("error: ")).count(), 1, "{message}");
    // Nothing but it, and warnings of the way to it.
    let known = |line: &str| ["error: ", "warning: ", "note: ", "  "].iter().any(|start| line.starts_with(start));
    assert!(message.lines().all(known) && message.contains("  help: "), "{message}");
    parts.iter().for_each(|part| assert!(message.contains(part), "{part} is not in {message}"));
}

/// A run with checkpoints, once the first of them lies there.
fn started(bench: &Bench, more: &[&str]) -> Child {
    let run = ["run", "shot.json", "--backend", "cpu", "--threads", "1", "--checkpoint-every", "3"];
    let mut command = bench.command(&[&run[..], more].concat());
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for_another(&bench.path("out/shot/checkpoint.bin"), None);
    child
}

#[test]
fn a_second_run_in_a_folder_is_refused_and_the_first_loses_nothing() {
    let bench = Bench::new(&long());
    assert_eq!(code(&bench.shoot(&["--out", "alone", "--quiet"])), 0);
    let first = started(&bench, &[]);
    let busy = ["error: out/shot\n", "expected: a folder that no other run writes to", "found: another run"];
    refused(&bench.shoot(&["--quiet"]), &busy);
    refused(&bench.shoot(&["--checkpoint-every", "1"]), &busy);
    refused(&bench.ripstop(&["resume", "out/shot"]), &[&busy[..], &["help: wait for the end"]].concat());
    refused(&bench.ripstop(&["bench", "shot.json", "--out", "out/shot"]), &busy);
    let first = first.wait_with_output().unwrap();
    assert_eq!(code(&first), 0, "{}", stderr(&first));
    same_files(&files(&bench.path("alone")), &files(&bench.path("out/shot")));
    // It is free again.
    assert_eq!(code(&bench.shoot(&["--quiet"])), 0);
    same_files(&files(&bench.path("alone")), &files(&bench.path("out/shot")));
}

#[test]
fn of_two_that_start_at_once_one_runs() {
    let bench = Bench::new(&small());
    for _ in 0..5 {
        let start = || {
            let mut command = bench.command(&["run", "shot.json", "--backend", "cpu", "--quiet"]);
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
        };
        let ended = [start(), start(), start()].map(|child| child.wait_with_output().unwrap());
        let done = ended.iter().filter(|output| code(output) == 0).count();
        assert!(done >= 1, "{ended:?}");
        ended.iter().filter(|output| code(output) != 0).for_each(|output| refused(output, &["another run"]));
        let expected = ["case.json", "events.csv", "history.csv", "report.html", "shot.svg", "summary.json"];
        assert_eq!(bench.names("out/shot"), expected);
    }
}

#[test]
fn a_run_that_was_killed_keeps_nobody_away() {
    let bench = Bench::new(&long());
    let mut child = started(&bench, &[]);
    child.kill().unwrap(); // -9
    child.wait().unwrap();
    assert!(bench.path("out/shot/.ripstop.lock").exists());
    assert_eq!(code(&bench.ripstop(&["resume", "out/shot", "--quiet"])), 0);
    assert!(!bench.path("out/shot/.ripstop.lock").exists());
    fs::write(bench.path("out/shot/.ripstop.lock"), "of a killed run").unwrap();
    assert_eq!(code(&bench.shoot(&["--quiet"])), 0);
    assert!(!bench.path("out/shot/.ripstop.lock").exists());
}

#[test]
fn a_folder_removed_while_running_is_told_and_not_made_again() {
    let bench = Bench::new(&long());
    for frames in [&[][..], &["--frames", "20"]] {
        let child = started(&bench, frames);
        fs::rename(bench.path("out/shot"), bench.path("away")).unwrap();
        fs::remove_dir_all(bench.path("away")).unwrap();
        let output = child.wait_with_output().unwrap();
        refused(&output, &["error: out/shot\n", "found: none: it was removed meanwhile"]);
        let message = stderr(&output);
        assert_eq!(message.matches("warning: no checkpoint at").count(), 1, "{message}");
        assert!(message.contains("the one before is gone"), "{message}");
        assert_eq!(bench.names("out"), [""; 0]);
        // What was computed is told all the same.
        assert!(stdout(&output).contains("PERFORATED"), "{}", stdout(&output));
    }
}

#[test]
fn a_folder_that_took_its_place_is_left_alone() {
    let bench = Bench::new(&long());
    let child = started(&bench, &["--frames", "20"]);
    fs::rename(bench.path("out/shot"), bench.path("away")).unwrap();
    fs::create_dir(bench.path("out/shot")).unwrap();
    fs::write(bench.path("out/shot/history.csv"), "of somebody else").unwrap();
    refused(&child.wait_with_output().unwrap(), &["error: out/shot\n", "found: another one of this name"]);
    assert_eq!(bench.names("out/shot"), ["history.csv"]);
    assert_eq!(bench.text("out/shot/history.csv"), "of somebody else");
}

/// Runs a script where files are small: on a disk of so many KiB, or where this user may mount none, with files of 16 KiB at most.
/// `$RIPSTOP` stands for the program; `full` before it for the small disk, where it is not one already.
fn on_a_small_disk(bench: &Bench, size: u32, script: &str) -> (Output, &'static str) {
    let mount = format!("mount -t tmpfs -o size={size}k tmpfs out");
    let unshare = ["--user", "--map-root-user", "--mount", "sh", "-c"];
    fs::create_dir_all(bench.path("out")).unwrap();
    let tried = Command::new("unshare").args(unshare).arg(&mount).current_dir(bench.folder.path()).output();
    let can_mount = tried.is_ok_and(|output| output.status.success());
    let (prelude, word) = match can_mount {
        true => (format!("{mount}; full() {{ \"$@\"; }};"), "No space left on device"),
        // Both a shell that counts in 512 and one that counts in 1024 bytes give too little for a report.
        false => ("full() { (trap '' XFSZ; ulimit -f 16; exec \"$@\"); };".to_owned(), "File too large"),
    };
    let mut command = if can_mount { bench.command_of("unshare", &unshare) } else { bench.command_of("sh", &["-c"]) };
    command.arg(format!("{prelude} {script}")).env("RIPSTOP", env!("CARGO_BIN_EXE_ripstop"));
    (command.output().unwrap(), word)
}

#[test]
fn a_full_disk_leaves_the_results_of_the_earlier_run() {
    let bench = Bench::new(&small());
    let list = "(cd out/shot && cksum $(ls -A))";
    let run = "\"$RIPSTOP\" run shot.json --backend cpu --quiet";
    let script = format!(
        "{run} --no-report && {list} >before; full {run} --set /projectile/velocity_m_s=610 --out out/shot; \
         code=$?; {list} >after; exit $code"
    );
    let (output, word) = on_a_small_disk(&bench, 64, &script);
    refused(&output, &["error: out/shot/report.html", "a disk that takes the results", word]);
    assert_eq!(bench.text("before"), bench.text("after"));
    assert_eq!(bench.text("before").lines().count(), 5, "{}", bench.text("before"));
}

#[test]
fn frames_that_find_no_room_are_told_and_the_rest_is_written() {
    let bench = Bench::new(&small());
    let run = "\"$RIPSTOP\" run shot.json --backend cpu --quiet --no-report --frames 60";
    let script = format!("full {run}; code=$?; ls -A out/shot >after; cp out/shot/summary.json .; exit $code");
    let (output, word) = on_a_small_disk(&bench, 64, &script);
    refused(&output, &["error: out/shot/frames", "a disk that takes the frames", word]);
    let names = ["case.json", "events.csv", "history.csv", "shot.svg", "summary.json"];
    assert_eq!(bench.text("after").lines().collect::<Vec<_>>(), names);
    assert_eq!(bench.json("summary.json")["interrupted"], false);
}

#[test]
fn a_disk_that_is_full_on_the_way_costs_checkpoints_and_is_told_once() {
    let bench = Bench::new(&long());
    let run = "\"$RIPSTOP\" run shot.json --backend cpu --quiet --no-report --checkpoint-every 3";
    let (output, word) =
        on_a_small_disk(&bench, 24, &format!("full {run}; code=$?; ls -A out/shot >after; exit $code"));
    let message = stderr(&output);
    assert_eq!(message.matches("warning: no checkpoint at").count(), 1, "{message}");
    refused(&output, &[word, "there is none so far"]);
    // The case of the run that did not come to its end, and nothing unfinished.
    assert_eq!(bench.text("after").lines().collect::<Vec<_>>(), ["case.json"]);
}

/// A program that may not do everything: started by root it is nobody's.
fn as_nobody(bench: &Bench, arguments: &[&str]) -> Command {
    let mut command = bench.command(arguments);
    if fs::metadata(bench.folder.path()).unwrap().uid() != 0 {
        return command;
    }
    // Where the program lies nobody may come.
    let program = bench.path("program");
    if !program.exists() {
        fs::copy(env!("CARGO_BIN_EXE_ripstop"), &program).unwrap();
    }
    let mut command_of_nobody = Command::new(&program);
    command_of_nobody.args(command.get_args()).current_dir(bench.folder.path()).stdin(Stdio::null());
    command_of_nobody.envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))));
    command = command_of_nobody;
    command.uid(NOBODY).gid(NOBODY);
    command
}

/// The user of no rights, where root is the one who tests.
const NOBODY: u32 = 65534;

/// Gives a folder to whom the program runs as, with these rights.
fn hand_over(bench: &Bench, name: &str, mode: u32) {
    let path = bench.path(name);
    if fs::metadata(&path).unwrap().uid() == 0 {
        chown(&path, Some(NOBODY), Some(NOBODY)).unwrap();
    }
    fs::set_permissions(&path, PermissionsExt::from_mode(mode)).unwrap();
}

#[test]
fn a_folder_that_may_not_be_written_is_refused_before_anything_is_computed() {
    let bench = Bench::new(&long());
    fs::set_permissions(bench.folder.path(), PermissionsExt::from_mode(0o755)).unwrap();
    fs::create_dir(bench.path("closed")).unwrap();
    fs::write(bench.path("closed/history.csv"), "of somebody else").unwrap();
    fs::set_permissions(bench.path("closed"), PermissionsExt::from_mode(0o555)).unwrap();
    for out in ["closed", "closed/below", "closed/below/further"] {
        let output = as_nobody(&bench, &["run", "shot.json", "--backend", "cpu", "--out", out]).output().unwrap();
        refused(&output, &[&format!("error: {out}\n"), "a folder that can be written", "ermission denied"]);
    }
    assert_eq!(bench.names("closed"), ["history.csv"]);
    assert_eq!(bench.text("closed/history.csv"), "of somebody else");
    fs::set_permissions(bench.path("closed"), PermissionsExt::from_mode(0o755)).unwrap();
}

#[test]
fn a_folder_that_is_closed_while_running_keeps_what_it_has() {
    let bench = Bench::new(&long());
    fs::set_permissions(bench.folder.path(), PermissionsExt::from_mode(0o755)).unwrap();
    fs::create_dir(bench.path("out")).unwrap();
    hand_over(&bench, "out", 0o755);
    let run = ["run", "shot.json", "--backend", "cpu", "--threads", "1", "--checkpoint-every", "3"];
    let child = as_nobody(&bench, &run).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for_another(&bench.path("out/shot/checkpoint.bin"), None);
    fs::set_permissions(bench.path("out/shot"), PermissionsExt::from_mode(0o555)).unwrap();
    let output = child.wait_with_output().unwrap();
    refused(&output, &["error: out/shot/", "ermission denied", "is still there"]);
    fs::set_permissions(bench.path("out/shot"), PermissionsExt::from_mode(0o755)).unwrap();
    let left = bench.names("out/shot");
    assert!(
        left.iter().all(
            |name| ["case.json", "checkpoint.bin", ".ripstop.lock", ".checkpoint.bin.tmp"].contains(&name.as_str())
        ),
        "{left:?}"
    );
    // Once it may be written again, the run goes on from there.
    let output = as_nobody(&bench, &["resume", "out/shot", "--quiet"]).output().unwrap();
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(
        bench.names("out/shot"),
        [
            "case.json",
            "events.csv",
            "history.csv",
            "plies.csv",
            "profiles.csv",
            "report.html",
            "shot.svg",
            "summary.json"
        ]
    );
}

/// What is written to `/dev/full` meets a full disk.
#[cfg(target_os = "linux")]
#[test]
fn standard_output_that_takes_nothing_is_one_error() {
    let bench = Bench::new(&small());
    for arguments in [&["check", "shot.json"][..], &["run", "shot.json", "--backend", "cpu", "--json"], &["schema"]] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let output = bench.command(arguments).stdout(full).stderr(Stdio::piped()).spawn().unwrap();
        let output = output.wait_with_output().unwrap();
        let message = stderr(&output);
        assert_eq!(code(&output), 2, "{message}");
        assert!(message.starts_with("error: cannot write to standard output: No space left on device"), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    // The results are on the disk.
    assert!(bench.path("out/shot/summary.json").exists());
}
