//! The program as users and scripts meet it: files, exit codes, what is printed where.
//!
//! Promise: exit codes are 0, 1, 2, 3 and 130, with one message each; nothing is written when a run is refused; results do not
//! depend on the number of threads; output that is not a terminal holds no escape codes.
//! Every program here runs as on a machine without a graphics adapter; those that want one are in `tests/gpu`.

mod campaigns;
mod commands;
mod folders;
mod results;

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use ripstop::run::{Options, Run};
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
    let run = Options::default().threads(1).run(&case).unwrap();
    (case, run)
}

/// A deflection that lies in the projectile's way.
const OVERLAP: &str = r#"/pack/initial_deflection={"amplitude_mm":-2,"warp_half_waves":1,"weft_half_waves":1}"#;

#[test]
fn bad_input_is_2_and_nothing_is_written() {
    let bench = Bench::new(&small());
    fs::write(bench.path("broken.json"), "{ \"title\": ").unwrap();
    fs::write(bench.path("file"), "").unwrap();
    let heavy = small_with("/fabric/areal_density_g_m2", json!(2552));
    fs::write(bench.path("s-720.json"), heavy["fabric"].to_string()).unwrap();
    let before = bench.names(".");
    let refused = [
        ("run broken.json", "line 1, column"),
        ("run absent.json", "absent.json"),
        ("run shot.json --set /projectile/velocity=1", "velocity_m_s"),
        ("run shot.json --set /pack/pretension/warp_n_per_m=1e7", "/pack/pretension"),
        (&format!("run shot.json --set {OVERLAP}"), "/projectile"),
        // The pack has 30.48 mm, the projectile a radius of 2.75 mm.
        ("run shot.json --set /projectile/offset_mm=[0,15.24]", "found: [0, 15.24] mm"),
        ("v50 shot.json --set /pack/edges=free --set /projectile/offset_mm=[-18,0]", "a hit on free fabric"),
        ("run shot.json --set /fabric/areal_density_g_m2=0.2552", "about 252.9 g/m²"),
        ("check shot.json --set /fabric/areal_density_g_m2=189.6", "found: 189.6 g/m²"),
        (r#"run shot.json --set /pack/layup=[{},{"fabric":{"file":"s-720.json"}}]"#, "/pack/layup/1/fabric/areal"),
        (r#"run shot.json --set /pack/layup=[{},{"orientation_deg":30,"edges":"roller"}]"#, "a ply at 30.000000°"),
        ("run shot.json --out file", "a file"),
        ("run shot.json --out file/below", "file/below"),
        ("run shot.json --threads 0", "--threads"),
        ("run shot.json --precision f16", "f64"),
        ("run shot.json --backend cpu --adapter 0", "--adapter"),
        ("run shot.json --backend tpu", "auto, cpu, gpu"),
        ("run shot.json --frames 10001", "/output/frames"),
        ("run shot.json --no-skip=wavefront,mirror", "wavefront, outcome, symmetry, all"),
        ("run shot.json --checkpoint-every 0", "expected a time above 0 in µs"),
        ("run", "CASE.json"),
        ("fly", "fly"),
        ("resume .", "expected: a folder with a checkpoint, checkpoint.bin"),
        ("resume nowhere", "nowhere"),
        ("completions tcsh", "bash"),
        ("explain W10", "0, 1, 2, 3, 130, W1, W2, W3, W4, W5, W6, W7, W8, W9"),
        ("run shot.json --backend gpu --precision f64", "--backend cpu"),
        ("bench shot.json --backend cpu --out shot.json", "a file"),
        ("crossover shot.json --warp-stretch 1", "--weft-stretch"),
        ("crossover shot.json --warp-stretch 1 --weft-stretch 1 --json --csv", "--csv"),
        ("crossover shot.json --warp-stretch 1:2:2000 --weft-stretch 1:2:2000", "at most 1000000 points"),
        ("crossover shot.json --weft-stretch 1 --warp-stretch 0", "--warp-stretch"),
        ("crossover shot.json --weft-stretch 1 --warp-stretch 1:1.1:1", "--warp-stretch"),
        ("new shot.json", "--force"),
        ("new no/such/folder/x.json", "error: no/such/folder"),
        ("new y.json --velocity 1e9", "/projectile/velocity_m_s"),
        ("new y.json --velocity fast", "--velocity"),
        ("new y.json --plies 0", "/pack/plies"),
        ("new y.json --projectile stone", "fsp-22         chisel-nosed fragment simulator"),
        ("new y.json --fabric absent.json", "or a file with the keys of a fabric (No such file"),
    ];
    for (line, named) in refused {
        let output = bench.ripstop(&line.split(' ').collect::<Vec<_>>());
        let message = stderr(&output);
        assert_eq!(code(&output), 2, "{line}: {message}");
        assert!(message.contains(named), "{line}: {named} in {message}");
        assert_eq!(message.matches("error: ").count(), 1, "{line}: {message}");
        assert!(output.stdout.is_empty(), "{line}");
        assert_eq!(bench.names("."), before, "{line}");
    }
    // Just inside of the frame, past a free edge but not beside it; tape, whose resin has a weight, and a coating that is said.
    for set in [
        "/projectile/offset_mm=[0,15.2]",
        "/pack/edges=free --set /projectile/offset_mm=[17.9,0]",
        r#"/fabric/weft={"absent":true,"count_per_inch":20}"#,
        r#"/fabric/areal_density_g_m2=900 --set /sources={"/fabric/areal_density_g_m2":"assumed:coated"}"#,
    ] {
        let output = bench.ripstop(&format!("check shot.json --set {set}").split(' ').collect::<Vec<_>>());
        assert_eq!(code(&output), 0, "{set}: {}", stderr(&output));
    }
    // A kind of skip follows an equals sign only: a word by itself is the case.
    let output = bench.ripstop(&["run", "--backend", "cpu", "--quiet", "--no-skip", "shot.json"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
}

#[test]
fn results_never_replace_the_case() {
    let bench = Bench::new(&small());
    let before = bench.text("shot.json");
    for (name, command) in [("case.json", "run"), ("bench.json", "bench")] {
        fs::copy(bench.path("shot.json"), bench.path(name)).unwrap();
        let output = bench.ripstop(&[command, name, "--backend", "cpu", "--out", "."]);
        assert_eq!(code(&output), 2, "{}", stderr(&output));
        assert_eq!(bench.text(name), before);
    }
    assert_eq!(bench.names("."), ["bench.json", "case.json", "shot.json"]);
}

#[test]
fn a_failed_expectation_is_1_and_the_results_are_there() {
    let expect = json!([{"quantity": "outcome", "value": "stopped", "source": "this test"}]);
    let bench = Bench::new(&small_with("/expect", expect));
    let output = bench.shoot(&["--quiet"]);
    assert_eq!((code(&output), stdout(&output)), (1, String::new()));
    assert!(stderr(&output).contains("outcome: expected stopped, got running"), "{}", stderr(&output));
    assert_eq!(bench.json("out/shot/summary.json")["expect"][0]["pass"], false);
}

/// Elsewhere a program cannot be kept from the adapters.
#[cfg(target_os = "linux")]
#[test]
fn what_needs_an_adapter_is_3_and_auto_takes_the_processor_and_says_why() {
    let bench = Bench::new(&small());
    for line in [
        "run shot.json --backend gpu",
        "run shot.json --backend gpu --precision f32 --adapter 0",
        "run shot.json --adapter 0",
        "verify --backend gpu",
        "bench shot.json --backend gpu",
        "v50 shot.json --backend gpu",
        "sweep shot.json --over /pack/plies=1,2 --backend gpu",
    ] {
        let output = bench.ripstop(&line.split(' ').collect::<Vec<_>>());
        let message = stderr(&output);
        assert_eq!((code(&output), message.lines().count()), (3, 4), "{line}: {message}");
        for part in ["error: --backend gpu", "expected: a graphics adapter", "found: no ", "help: take --backend cpu"] {
            assert!(message.contains(part), "{line}: {part} in {message}");
        }
        assert!(output.stdout.is_empty() && bench.names(".") == ["shot.json"], "{line}");
    }
    let output = bench.ripstop(&["run", "shot.json"]);
    assert_eq!(code(&output), 0);
    assert_eq!(stderr(&output), "note: --backend auto takes the CPU: no graphics adapter was found\n");
    let summary = bench.json("out/shot/summary.json");
    assert_eq!((&summary["backend"], &summary["precision"]), (&json!("cpu"), &json!("f64")));
    let info = stdout(&bench.ripstop(&["info"]));
    let line = "auto chooses  cpu, because no graphics adapter was found";
    assert!(info.contains(line) && !info.contains("adapter 0"), "{info}");
}
