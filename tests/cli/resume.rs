//! `--checkpoint-every` and `ripstop resume`.

use super::*;
use crate::kept::{files, same_files, wait_for_another};
use crate::support::Random;
use ripstop::run::checkpoint::Checkpoint;

/// Two plies that a projectile goes through in good time, for long enough to be killed often.
pub(super) fn long() -> Value {
    let mut case = small_with("/pack/plies", json!(2));
    case["solver"] = json!({"end_time_us": 600, "run_until": "end_time"});
    // Four took forty times as long, and tell no more of files.
    case["pack"]["elements_per_crossover"] = json!(1);
    case["output"] = json!({"history_interval_us": 0.9, "profile_times_us": [3, 77.7, 240]});
    case
}

#[cfg(unix)]
#[test]
fn killed_at_20_random_moments_a_run_ends_as_if_nothing_had_been() {
    let bench = Bench::new(&long());
    let frames = ["--frames", "60"];
    assert_eq!(code(&bench.shoot(&[&["--out", "whole", "--quiet", "--threads", "2"], &frames[..]].concat())), 0);
    let path = bench.path("out/shot/checkpoint.bin");
    let run = ["run", "shot.json", "--backend", "cpu", "--quiet", "--checkpoint-every", "3", "--threads", "2"];
    let (run, resume) = ([&run[..], &frames].concat(), ["resume", "out/shot", "--quiet"]);
    let mut random = Random(11);
    let (mut file, mut last) = (None, 0.0);
    for kill in 0..20 {
        let arguments = if kill == 0 { &run[..] } else { &resume };
        let mut child = bench.command(arguments).spawn().unwrap();
        wait_for_another(&path, file);
        thread::sleep(Duration::from_micros(random.between(0.0, 4e3) as u64));
        child.kill().unwrap(); // -9
        let ended = child.wait().unwrap();
        assert!(!ended.success(), "over before kill {kill}: take a longer run");
        // Whatever was being written: what is there is whole, and further than the last time.
        let head = Checkpoint::open(&path).unwrap_or_else(|e| panic!("{e}")).header().clone();
        assert!(head.time > last, "{} after {last}", head.time);
        last = head.time;
        file = wait_for_another(&path, None);
    }
    let output =
        bench.command(&["resume", "out/shot"]).env("RIPSTOP_LOG", "ripstop::run::record=info").output().unwrap();
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let words = stderr(&output);
    assert!(words.starts_with("note: goes on from ") && !words.contains("lost"), "{words}");
    assert!(last > 3.0 * 600e-6 / 59.0, "no frame but the first was taken by {last}");
    // It does go on, and not begin anew: then it would meet the fabric again.
    assert!(!words.contains("first contact"), "{words}");
    same_files(&files(&bench.path("whole")), &files(&bench.path("out/shot")));
    let summary = bench.json("out/shot/summary.json");
    assert!(summary["failed_yarns"]["warp"].as_u64() > Some(10), "{}", summary["failed_yarns"]);
    // All parts together, as far as checkpoints knew of them.
    let [wall, inner] = ["wall_s", "loop_s"].map(|key| summary[key].as_f64().unwrap());
    assert!(wall > inner && inner > 0.0, "{wall} {inner}");
    // A last part that knew of itself alone would miss most of it.
    let kernels = summary["timings"].as_object().unwrap();
    let timed: f64 =
        kernels.iter().filter(|(name, _)| *name != "other").map(|(_, part)| part["s"].as_f64().unwrap()).sum();
    assert!(timed > 0.0 && timed <= inner, "{timed} of {inner}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_a_checkpoint_of_that_very_step() {
    let bench = Bench::new(&long());
    assert_eq!(code(&bench.shoot(&["--out", "whole", "--quiet"])), 0);
    let mut command = bench.command(&["run", "shot.json", "--backend", "cpu", "--checkpoint-every", "3"]);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let path = bench.path("out/shot/checkpoint.bin");
    wait_for_another(&path, None);
    let output = interrupt(child);
    assert_eq!(code(&output), 130, "{}", stderr(&output));
    assert!(stderr(&output).contains("help: `ripstop resume out/shot` goes on"), "{}", stderr(&output));
    let summary = bench.json("out/shot/summary.json");
    assert_eq!(summary["interrupted"], true);
    let kept = Checkpoint::open(&path).unwrap().header().time;
    assert_eq!(summary["time_us"].as_f64().unwrap(), kept * 1e6);
    assert_eq!(code(&bench.ripstop(&["resume", "out/shot", "--quiet"])), 0);
    same_files(&files(&bench.path("whole")), &files(&bench.path("out/shot")));
}

#[test]
fn a_run_that_ends_leaves_no_checkpoint_and_is_not_resumed() {
    let bench = Bench::new(&small());
    fs::create_dir_all(bench.path("out/shot")).unwrap();
    for left in ["summary.json", "plies.csv", "checkpoint.bin", ".checkpoint.bin.tmp"] {
        fs::write(bench.path("out/shot").join(left), "of an earlier run").unwrap();
    }
    let output = bench.shoot(&["--checkpoint-every", "1"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert!(stderr(&output).contains("note: out/shot holds a checkpoint, which this run replaces"));
    let expected = ["case.json", "events.csv", "history.csv", "report.html", "shot.svg", "summary.json"];
    assert_eq!(bench.names("out/shot"), expected);
    assert_eq!(bench.json("out/shot/summary.json")["checkpoint_failed"], Value::Null);
    let before = bench.text("out/shot/summary.json");
    let output = bench.ripstop(&["resume", "out/shot"]);
    assert_eq!(code(&output), 0);
    assert_eq!(stderr(&output), "note: out/shot: the run has ended; there is nothing to resume\n");
    assert_eq!(bench.text("out/shot/summary.json"), before);
    // What checkpoints cost is no result.
    assert_eq!(code(&bench.shoot(&["--out", "plain", "--quiet"])), 0);
    same_files(&files(&bench.path("plain")), &files(&bench.path("out/shot")));
}

/// A folder with a checkpoint, as a killed run leaves it.
#[cfg(unix)]
fn killed() -> Bench {
    let bench = Bench::new(&long());
    let mut child =
        bench.command(&["run", "shot.json", "--backend", "cpu", "--quiet", "--checkpoint-every", "3"]).spawn().unwrap();
    wait_for_another(&bench.path("out/shot/checkpoint.bin"), None);
    child.kill().unwrap();
    child.wait().unwrap();
    bench
}

#[cfg(unix)]
#[test]
fn what_is_not_the_checkpoint_of_this_run_is_2_and_says_why() {
    let bench = killed();
    let path = bench.path("out/shot/checkpoint.bin");
    let whole = fs::read(&path).unwrap();
    let flipped = |at: usize, bit: u8| {
        let mut bytes = whole.clone();
        bytes[at] ^= bit;
        bytes
    };
    let shot = bench.text("out/shot/case.json");
    let changed = shot.replacen("\"velocity_m_s\": 600", "\"velocity_m_s\": 601", 1);
    let renamed = shot.replacen("a small shot", "another name", 1);
    assert!(changed != shot && renamed != shot);
    let cases: [(&[u8], &str, [&str; 2]); 7] = [
        (b"something else", &shot, ["expected: a checkpoint of ripstop", "another kind of file"]),
        (&flipped(8, 1), &shot, ["expected: a checkpoint of format 10", "format 11"]),
        (&flipped(whole.len() / 2, 1), &shot, ["whose checksum holds", "damaged or cut short"]),
        (&whole[..whole.len() - 20], &shot, ["whose checksum holds", "damaged or cut short"]),
        (&whole, &changed, ["the case that the run began with", "help: undo the change"]),
        (&whole, "{", ["out/shot/case.json", "line 1, column"]),
        (b"", &shot, ["expected: a checkpoint of ripstop", "another kind of file"]),
    ];
    for (checkpoint, case, parts) in cases {
        fs::write(&path, checkpoint).unwrap();
        fs::write(bench.path("out/shot/case.json"), case).unwrap();
        let output = bench.ripstop(&["resume", "out/shot"]);
        let message = stderr(&output);
        assert_eq!(code(&output), 2, "{message}");
        assert_eq!(message.matches("error: ").count(), 1, "{message}");
        parts.iter().for_each(|part| assert!(message.contains(part), "{part} in {message}"));
        assert!(output.stdout.is_empty());
        // Nothing was touched.
        assert!(fs::read(&path).unwrap() == checkpoint);
    }
    // Words do not make another case.
    fs::write(&path, &whole).unwrap();
    fs::write(bench.path("out/shot/case.json"), renamed).unwrap();
    assert_eq!(code(&bench.ripstop(&["resume", "out/shot", "--quiet"])), 0);
}

/// Where the times of a series of frames begin [µs], and how many there are of each part.
fn series(bench: &Bench) -> (f64, usize) {
    let list = bench.text("out/shot/frames.pvd");
    let times: Vec<f64> =
        list.split("timestep=\"").skip(1).map(|rest| rest.split('"').next().unwrap().parse().unwrap()).collect();
    (times[0], times.len() / 2)
}

#[cfg(unix)]
#[test]
fn frames_that_are_lost_are_told_and_the_files_begin_after_them() {
    let bench = Bench::new(&long());
    let run = ["run", "shot.json", "--backend", "cpu", "--quiet", "--checkpoint-every", "3", "--frames", "121"];
    let mut child = bench.command(&run).spawn().unwrap();
    let path = bench.path("out/shot/checkpoint.bin");
    (0..9).fold(wait_for_another(&path, None), |file, _| wait_for_another(&path, file));
    child.kill().unwrap();
    child.wait().unwrap();
    let names = bench.names("out/shot/checkpoint.frames");
    let fabric: Vec<&String> = names.iter().filter(|name| name.starts_with("fabric_")).collect();
    assert!(fabric.len() >= 6, "{names:?}");
    let time = |name: &str| {
        let text = fs::read(bench.path("out/shot/checkpoint.frames").join(name)).unwrap();
        let text = String::from_utf8_lossy(&text).into_owned();
        text.split("format=\"ascii\">").nth(1).unwrap().split('<').next().unwrap().parse::<f64>().unwrap()
    };
    let (missing, fourth) = (fabric[2], time(fabric[3]));
    fs::remove_file(bench.path("out/shot/checkpoint.frames").join(missing)).unwrap();
    let output = bench.ripstop(&["resume", "out/shot"]);
    let said = stderr(&output);
    assert_eq!(code(&output), 0, "{said}");
    let lost = format!("{missing} is missing;");
    assert!(said.contains("warning: frames before ") && said.contains(&lost), "{said}");
    // The files begin with the fourth, or the first kept after it, and there are still as many as were asked for.
    let (first, count) = series(&bench);
    assert!((fourth..fourth + 2.6).contains(&first) && count == 121, "{count} frames from {first} µs, not {fourth}");
    assert!(!bench.path("out/shot/checkpoint.frames").exists());
}

#[test]
fn a_folder_without_a_run_and_an_interval_that_is_none_are_2() {
    let bench = Bench::new(&small());
    let output = bench.ripstop(&["resume", "."]);
    assert_eq!(code(&output), 2);
    assert!(stderr(&output).contains("expected: a folder with a checkpoint, checkpoint.bin"), "{}", stderr(&output));
    assert_eq!(code(&bench.ripstop(&["resume", "nowhere"])), 2);
    for interval in ["0", "-1", "nan", "inf", "often"] {
        let output = bench.shoot(&[&format!("--checkpoint-every={interval}")]);
        assert_eq!(code(&output), 2);
        assert!(stderr(&output).contains("expected a time above 0 in µs"), "{}", stderr(&output));
    }
    assert_eq!(bench.names("."), ["shot.json"]);
}

/// What is written to `/dev/full` meets a full disk.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_and_the_run_goes_on() {
    let bench = Bench::new(&small());
    fs::create_dir_all(bench.path("out/shot")).unwrap();
    std::os::unix::fs::symlink("/dev/full", bench.path("out/shot/.checkpoint.bin.tmp")).unwrap();
    let output = bench.shoot(&["--checkpoint-every", "2", "--json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let told = "No space left on device (os error 28); there is none so far";
    assert!(stderr(&output).contains("warning: no checkpoint at ") && stderr(&output).contains(told));
    let summary = bench.json("out/shot/summary.json");
    assert!(summary["checkpoint_failed"].as_str().unwrap().contains(told), "{}", summary["checkpoint_failed"]);
    assert_eq!(summary["outcome"], "running");
}

#[test]
fn frames_that_cannot_lie_beside_the_checkpoint_are_told_and_written_all_the_same() {
    let bench = Bench::new(&small());
    fs::create_dir_all(bench.path("out/shot")).unwrap();
    fs::write(bench.path("out/shot/checkpoint.frames"), "no folder").unwrap();
    let output = bench.shoot(&["--checkpoint-every", "2", "--frames", "6"]);
    let words = stderr(&output);
    assert_eq!(code(&output), 0, "{words}");
    assert_eq!(words.matches("warning: no frames are put beside the checkpoint from 0 µs on: ").count(), 1, "{words}");
    assert!(bench.path("out/shot/frames.pvd").exists());
    assert_eq!(bench.text("out/shot/checkpoint.frames"), "no folder");
}
