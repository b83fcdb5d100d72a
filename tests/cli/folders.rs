//! Folders, disks and checkpoints: what refuses is one error with its exit code, nothing is half written, nothing of others is lost, and
//! a run that was stopped goes on as if it had not been.
#![cfg(unix)]

use ripstop::run::checkpoint::Checkpoint;

use super::*;
use crate::support::Random;
use crate::support::{files, same_files, wait_for_another};

const CHECKPOINT: &str = "out/shot/checkpoint.bin";
const RUN: [&str; 7] = ["run", "shot.json", "--backend", "cpu", "--quiet", "--checkpoint-every", "3"];

/// Two plies that a projectile goes through in good time, for long enough to be killed often.
fn long() -> Bench {
    let mut case = small_with("/pack/plies", json!(2));
    case["solver"] = json!({"end_time_us": 600, "run_until": "end_time"});
    case["pack"]["elements_per_crossover"] = json!(1);
    case["output"] = json!({"history_interval_us": 0.9, "profile_times_us": [3, 77.7, 240]});
    Bench::new(&case)
}

/// A run with checkpoints, once the first of them lies there.
fn started(bench: &Bench, more: &[&str]) -> Child {
    let run: Vec<&str> = RUN.iter().filter(|word| **word != "--quiet").copied().collect();
    let mut command = bench.command(&[&run[..], more].concat());
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for_another(&bench.path(CHECKPOINT), None);
    child
}

fn kill(mut child: Child) {
    child.kill().unwrap(); // -9
    child.wait().unwrap();
}

/// One error of exit code 2 with help, and beside it nothing but warnings and notes.
#[track_caller]
fn refused(output: &Output, parts: &[&str]) {
    let message = stderr(output);
    assert_eq!(code(output), 2, "{message}");
    assert_eq!(message.lines().filter(|line| line.starts_with("error: ")).count(), 1, "{message}");
    let known = |line: &str| ["error: ", "warning: ", "note: ", "  "].iter().any(|start| line.starts_with(start));
    assert!(message.lines().all(known) && message.contains("  help: "), "{message}");
    parts.iter().for_each(|part| assert!(message.contains(part), "{part} is not in {message}"));
}

#[test]
fn a_second_run_in_a_folder_is_refused_and_the_first_loses_nothing() {
    let bench = long();
    assert_eq!(code(&bench.shoot(&["--out", "alone", "--quiet"])), 0);
    let first = started(&bench, &[]);
    let busy = ["error: out/shot\n", "expected: a folder that no other run writes to", "found: another run"];
    refused(&bench.shoot(&["--quiet"]), &busy);
    refused(&bench.ripstop(&["resume", "out/shot"]), &[&busy[..], &["help: wait for the end"]].concat());
    refused(&bench.ripstop(&["bench", "shot.json", "--backend", "cpu", "--out", "out/shot"]), &busy);
    let first = first.wait_with_output().unwrap();
    assert_eq!(code(&first), 0, "{}", stderr(&first));
    same_files(&files(&bench.path("alone")), &files(&bench.path("out/shot")));
}

#[test]
fn a_folder_that_is_gone_at_the_end_is_not_made_again_and_another_is_left_alone() {
    for another in [false, true] {
        let bench = long();
        let child = started(&bench, &["--frames", "20"]);
        fs::rename(bench.path("out/shot"), bench.path("away")).unwrap();
        let (found, left) = match another {
            true => {
                fs::create_dir(bench.path("out/shot")).unwrap();
                fs::write(bench.path("out/shot/history.csv"), "of somebody else").unwrap();
                ("found: another one of this name", vec!["out/shot/history.csv"])
            }
            false => ("found: none: it was removed meanwhile", vec![]),
        };
        let output = child.wait_with_output().unwrap();
        refused(&output, &["error: out/shot\n", found]);
        assert!(another || stderr(&output).matches("warning: no checkpoint at").count() == 1, "{}", stderr(&output));
        // The result is printed all the same.
        assert!(stdout(&output).contains("PERFORATED"), "{}", stdout(&output));
        left.iter().for_each(|file| assert_eq!(bench.text(file), "of somebody else"));
        assert_eq!(bench.names("out").len(), left.len());
    }
}

/// Runs a script where files are small: on a disk of `size` [KiB], or where this user may mount none, with files of 16 KiB at most.
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
fn a_full_disk_leaves_the_earlier_results_and_costs_frames_or_checkpoints_alone() {
    let run = "\"$RIPSTOP\" run shot.json --backend cpu --quiet";
    let bench = Bench::new(&small());
    let list = "(cd out/shot && cksum $(ls -A))";
    let again = format!("full {run} --set /projectile/velocity_m_s=610 --out out/shot; code=$?");
    let script = format!("{run} --no-report && {list} >before; {again}; {list} >after; exit $code");
    let (output, word) = on_a_small_disk(&bench, 64, &script);
    refused(&output, &["error: out/shot/report.html", "a disk that takes the results", word]);
    assert_eq!(bench.text("before"), bench.text("after"));
    assert_eq!(bench.text("before").lines().count(), 5, "{}", bench.text("before"));

    let ended = "code=$?; ls -A out/shot >after; exit $code";
    let bench = Bench::new(&small());
    let (output, word) = on_a_small_disk(&bench, 64, &format!("full {run} --no-report --frames 60; {ended}"));
    refused(&output, &["error: out/shot/frames", "a disk that takes the frames", word]);
    let without_report: Vec<&str> = FILES.into_iter().filter(|name| *name != "report.html").collect();
    assert_eq!(bench.text("after").lines().collect::<Vec<_>>(), without_report);

    let bench = long();
    let (output, word) = on_a_small_disk(&bench, 24, &format!("full {run} --no-report --checkpoint-every 3; {ended}"));
    refused(&output, &[word, "there is none so far"]);
    assert_eq!(stderr(&output).matches("warning: no checkpoint at").count(), 1, "{}", stderr(&output));
    // The case of the run that did not come to its end, and nothing unfinished.
    assert_eq!(bench.text("after").lines().collect::<Vec<_>>(), ["case.json"]);
}

/// Writing to `/dev/full` meets a full disk.
#[cfg(target_os = "linux")]
#[test]
fn standard_output_that_takes_nothing_is_one_error() {
    let bench = Bench::new(&small());
    for arguments in [&["check", "shot.json"][..], &["run", "shot.json", "--backend", "cpu", "--json"], &["schema"]] {
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        let child = bench.command(arguments).stdout(full).stderr(Stdio::piped()).spawn().unwrap();
        let output = child.wait_with_output().unwrap();
        let message = stderr(&output);
        assert_eq!((code(&output), message.lines().count()), (2, 1), "{message}");
        assert!(message.starts_with("error: cannot write to standard output: No space left on device"), "{message}");
    }
    assert!(bench.path("out/shot/summary.json").exists());
}

#[test]
fn killed_at_random_moments_a_run_ends_as_if_nothing_had_been() {
    let bench = long();
    let frames = ["--frames", "60"];
    assert_eq!(code(&bench.shoot(&[&["--out", "whole", "--quiet"], &frames[..]].concat())), 0);
    let path = bench.path(CHECKPOINT);
    let mut random = Random(11);
    let (mut file, mut last) = (None, 0.0);
    for number in 0..10 {
        let run = [&RUN[..], &frames].concat();
        let child = bench.command(if number == 0 { &run } else { &["resume", "out/shot", "--quiet"] }).spawn().unwrap();
        wait_for_another(&path, file);
        thread::sleep(Duration::from_micros(random.between(0.0, 4e3) as u64));
        kill(child);
        // Whatever was being written: the checkpoint is whole, and further than the last time.
        let head = Checkpoint::open(&path).unwrap_or_else(|e| panic!("{e}")).header.clone();
        assert!(head.time > last, "{} after {last}", head.time);
        last = head.time;
        file = wait_for_another(&path, None);
    }
    assert!(last > 2.0 * 600e-6 / 59.0, "no frame but the first was taken by {last}");
    let output = bench.ripstop(&["resume", "out/shot"]);
    let words = stderr(&output);
    assert_eq!(code(&output), 0, "{words}");
    assert!(words.starts_with("note: goes on from ") && !words.contains("lost"), "{words}");
    same_files(&files(&bench.path("whole")), &files(&bench.path("out/shot")));
    let summary = bench.json("out/shot/summary.json");
    let [wall, inner] = ["wall_s", "loop_s"].map(|key| summary[key].as_f64().unwrap());
    assert!(summary["failed_yarns"]["warp"].as_u64() > Some(10) && wall > inner && inner > 0.0, "{summary}");
}

#[test]
fn ctrl_c_leaves_complete_results_and_a_checkpoint_of_that_very_step() {
    let bench = long();
    assert_eq!(code(&bench.shoot(&["--out", "whole", "--quiet"])), 0);
    let output = interrupt(started(&bench, &["--json"]));
    assert_eq!(code(&output), 130, "{}", stderr(&output));
    let message = stderr(&output);
    assert!(message.contains("help: `ripstop resume out/shot` goes on"), "{message}");
    let summary = bench.json("out/shot/summary.json");
    assert_eq!(summary, serde_json::from_str::<Value>(&stdout(&output)).unwrap());
    assert_eq!(summary["interrupted"], true);
    let last = bench.text("out/shot/history.csv").lines().last().unwrap().split(',').next().unwrap().parse::<f64>();
    let time = summary["time_us"].as_f64().unwrap();
    assert_eq!((last.unwrap(), Checkpoint::open(&bench.path(CHECKPOINT)).unwrap().header.time * 1e6), (time, time));
    assert_eq!(code(&bench.ripstop(&["resume", "out/shot", "--quiet"])), 0);
    same_files(&files(&bench.path("whole")), &files(&bench.path("out/shot")));
}

#[test]
fn a_run_that_ends_leaves_no_checkpoint_and_is_not_resumed() {
    let bench = Bench::new(&small());
    fs::create_dir_all(bench.path("out/shot")).unwrap();
    for left in ["summary.json", "plies.csv", "checkpoint.bin", ".ripstop-killed.tmp"] {
        fs::write(bench.path("out/shot").join(left), "of an earlier run").unwrap();
    }
    let output = bench.shoot(&["--checkpoint-every", "1"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("note: out/shot holds a checkpoint, which this run replaces"));
    assert_eq!(bench.names("out/shot"), FILES);
    let before = bench.text("out/shot/summary.json");
    let output = bench.ripstop(&["resume", "out/shot"]);
    assert_eq!(code(&output), 0);
    assert_eq!(stderr(&output), "note: out/shot: the run has ended; there is nothing to resume\n");
    assert_eq!(bench.text("out/shot/summary.json"), before);
    // The cost of checkpoints is no result.
    assert_eq!(code(&bench.shoot(&["--out", "plain", "--quiet"])), 0);
    same_files(&files(&bench.path("plain")), &files(&bench.path("out/shot")));
}

#[test]
fn what_is_not_the_checkpoint_of_this_run_is_2_and_says_why() {
    let bench = long();
    kill(started(&bench, &[]));
    let path = bench.path(CHECKPOINT);
    let whole = fs::read(&path).unwrap();
    let shot = bench.text("out/shot/case.json");
    let changed = shot.replacen("\"velocity_m_s\": 600", "\"velocity_m_s\": 601", 1);
    assert_ne!(changed, shot);
    let cases: [(&[u8], &str, [&str; 2]); 3] = [
        (&whole[..whole.len() - 20], &shot, ["whose checksum holds", "damaged or cut short"]),
        (&whole, &changed, ["the case that the run began with", "help: undo the change"]),
        (&whole, "{", ["out/shot/case.json", "line 1, column"]),
    ];
    for (checkpoint, case, parts) in cases {
        fs::write(&path, checkpoint).unwrap();
        fs::write(bench.path("out/shot/case.json"), case).unwrap();
        let output = bench.ripstop(&["resume", "out/shot"]);
        let message = stderr(&output);
        assert_eq!((code(&output), message.matches("error: ").count()), (2, 1), "{message}");
        parts.iter().for_each(|part| assert!(message.contains(part), "{part} in {message}"));
        assert!(output.stdout.is_empty() && fs::read(&path).unwrap() == checkpoint, "{message}");
    }
    // A title does not make another case.
    fs::write(&path, &whole).unwrap();
    fs::write(bench.path("out/shot/case.json"), shot.replacen("a small shot", "another name", 1)).unwrap();
    assert_eq!(code(&bench.ripstop(&["resume", "out/shot", "--quiet"])), 0);
}

#[test]
fn frames_that_are_lost_are_refused() {
    let bench = long();
    let child = started(&bench, &["--frames", "121"]);
    (0..12).fold(None, |file, _| wait_for_another(&bench.path(CHECKPOINT), file));
    kill(child);
    let kept = bench.path("out/shot/checkpoint.frames");
    let names = bench.names("out/shot/checkpoint.frames");
    let fabric: Vec<&String> = names.iter().filter(|name| name.starts_with("fabric_")).collect();
    assert!(fabric.len() >= 6, "{names:?}");
    fs::remove_file(kept.join(fabric[2])).unwrap();
    refused(&bench.ripstop(&["resume", "out/shot"]), &[fabric[2], "expected: a frame of the checkpoint"]);
}
