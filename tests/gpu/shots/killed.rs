//! The program, killed while it computes on the device.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use ripstop::case;
use ripstop::gpu::Device;
use ripstop::run::checkpoint::Checkpoint;
use serde_json::{Value, json};
use tempfile::TempDir;

use super::{Outcome, Tests};
use crate::kept::{files, same_files, wait_for_another};
use crate::support::Random;

pub(super) const TESTS: Tests = &[("at_random_moments_a_run_ends_as_if_nothing_had_been", killed)];

/// Kills.
const KILLS: usize = 4;

/// Two small plies that a projectile goes through, with frames.
fn shot() -> Value {
    let mut fabric: Value = serde_json::from_str(case::builtin_fabric("fabrics/s-720.json").unwrap()).unwrap();
    fabric.as_object_mut().unwrap().remove("sources");
    json!({
        "title": "a small shot",
        "fabric": fabric,
        "pack": {"width_mm": 30, "height_mm": 30, "plies": 2},
        "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 42.1, "mass_g": 3, "velocity_m_s": 600},
        "solver": {"end_time_us": 120, "run_until": "end_time"},
        "output": {"history_interval_us": 0.9, "profile_times_us": [3, 40.1], "frames": 41},
    })
}

fn ripstop(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_ripstop"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null()).stderr(Stdio::piped());
    command
}

fn killed(_: &'static Device) -> Outcome {
    let shelf = TempDir::new().map_err(|e| e.to_string())?;
    let folder = shelf.path();
    fs::write(folder.join("shot.json"), shot().to_string()).map_err(|e| e.to_string())?;
    let run = ["run", "shot.json", "--backend", "gpu", "--quiet"];
    let whole = ripstop(folder, &[&run[..], &["--out", "whole"]].concat()).output().unwrap();
    assert!(whole.status.success(), "{}", String::from_utf8_lossy(&whole.stderr));
    let (path, mut random) = (folder.join("out/shot/checkpoint.bin"), Random(12));
    let (mut file, mut last) = (None, 0.0);
    for kill in 0..KILLS {
        let first = [&run[..], &["--checkpoint-every", "2"]].concat();
        let arguments = if kill == 0 { &first[..] } else { &["resume", "out/shot", "--quiet"] };
        let mut child = ripstop(folder, arguments).spawn().unwrap();
        wait_for_another(&path, file);
        thread::sleep(Duration::from_micros(random.between(0.0, 3e4) as u64));
        child.kill().unwrap(); // -9
        assert!(!child.wait().unwrap().success(), "over before kill {kill}: take a longer run");
        let head = Checkpoint::open(&path).unwrap_or_else(|e| panic!("{e}")).header().clone();
        assert!(head.time > last, "{} after {last}", head.time);
        last = head.time;
        file = wait_for_another(&path, None);
    }
    assert!(last > 6e-6, "no frame but the first was taken by {last}");
    let output = ripstop(folder, &["resume", "out/shot"]).output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    // A driver may have a word before.
    let goes_on = words.lines().any(|line| line.starts_with("note: goes on from "));
    assert!(output.status.success() && goes_on && !words.contains("lost"), "{words}");
    same_files(&files(&folder.join("whole")), &files(&folder.join("out/shot")));
    let summary: Value = serde_json::from_slice(&fs::read(folder.join("whole/summary.json")).unwrap()).unwrap();
    assert!(summary["backend"] == "gpu" && summary["failed_yarns"]["warp"].as_u64() > Some(10), "{summary}");
    Ok(())
}
