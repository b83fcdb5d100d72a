//! The program as users and scripts meet it: files, exit codes, what is printed where.
//!
//! Promise: names and codes are those of the contract; nothing is written when a run is refused; results do not
//! depend on the number of threads; output that is not a terminal holds no escape codes.
//! Every program here runs as on a machine without a graphics adapter; those that want one are in `tests/gpu`.

mod campaigns;
mod commands;
mod exit_codes;
mod folders;
mod results;
mod terminal;

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::{Duration, Instant};

use ripstop::run::{self, Options, Run};
use ripstop::solver::Divergence;
use ripstop::{case, output};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Hides every adapter from a program, hardware or software, where drivers are found by files (not on macOS and Windows).
pub(crate) const DRIVER_FILES: [&str; 3] = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES", "__EGL_VENDOR_LIBRARY_FILENAMES"];

/// Files of a run in their order.
const FILES: [&str; 6] = ["case.json", "events.csv", "history.csv", "report.html", "shot.svg", "summary.json"];

/// A folder with a case in it.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new(case: &Value) -> Self {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join("shot.json"), case.to_string()).unwrap();
        Self { folder }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        self.command_of(env!("CARGO_BIN_EXE_ripstop"), arguments)
    }

    /// Another program, run like this one.
    fn command_of(&self, program: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(program);
        command.current_dir(self.folder.path()).args(arguments).stdin(Stdio::null());
        command.envs(DRIVER_FILES.map(|name| (name, "/nowhere/at/all"))).env("NODEVICE_SELECT", "1");
        command
    }

    /// Runs a program that would go on for long until its folder is there and something is in the making, then sends Ctrl-C.
    #[cfg(unix)]
    fn interrupt(&self, arguments: &[&str], folder: &str) -> Output {
        let child = self.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let patience = Instant::now() + Duration::from_secs(60);
        while !self.path(folder).exists() && Instant::now() < patience {
            thread::sleep(Duration::from_millis(5));
        }
        thread::sleep(Duration::from_millis(300));
        interrupt(child)
    }

    fn ripstop(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// `ripstop run shot.json --backend cpu` and more.
    fn shoot(&self, arguments: &[&str]) -> Output {
        self.ripstop(&[&["run", "shot.json", "--backend", "cpu"], arguments].concat())
    }

    fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.text(name)).unwrap()
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// Names in the folder, hidden ones too.
    fn names(&self, folder: &str) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.path(folder))
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

/// Sends Ctrl-C, and again while results are written, as batch systems do that signal a process and its group.
#[cfg(unix)]
fn interrupt(child: Child) -> Output {
    for _ in 0..10 {
        let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(killed.success());
    }
    child.wait_with_output().unwrap()
}

/// 24 × 24 elements, ten microseconds, fast enough to break yarns.
fn small() -> Value {
    let mut fabric: Value = serde_json::from_str(case::builtin_fabric("fabrics/s-720.json").unwrap()).unwrap();
    fabric.as_object_mut().unwrap().remove("sources");
    json!({
        "title": "a small shot",
        "fabric": fabric,
        "pack": {"width_mm": 30, "height_mm": 30},
        "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 42.1, "mass_g": 3, "velocity_m_s": 600},
        "solver": {"end_time_us": 10, "numerics": "paper"},
        "output": {"history_interval_us": 0.5},
        "sources": {"/fabric/crossover": "assumed: for this test"}
    })
}

fn small_with(pointer: &str, value: Value) -> Value {
    let mut case = small();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    case.pointer_mut(parent).unwrap()[key] = value;
    case
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Runs a case through the library.
fn run(case: &Value) -> (case::Case, Run) {
    let case = case::from_str("shot.json", &case.to_string(), &[]).unwrap();
    let options = Options::default().threads(1);
    let run = run::run(&case, options, &AtomicBool::new(false), &mut ()).unwrap();
    (case, run)
}
