//! The page in a real browser: shots by WebGPU and on its processor, beside the same shots by the library in double precision.
//!
//! Chromium compiles the kernels by a compiler of its own, which refuses more than the one of wgpu. Its graphics processor is software here.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::LazyLock;
use std::time::Duration;
use std::{env, thread};

use libtest_mimic::{Arguments, Completion, Trial};
use ripstop::run::Precision;
use ripstop::{Options, case};
use serde_json::{Value, json};

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// Time after which a shot of a second counts as hung. A first compile in software takes a quarter of a minute.
const PATIENCE: Duration = Duration::from_secs(300);

/// Folder with the page, built once: with few optimisations, which change no bit, it takes a minute less.
static PAGE: LazyLock<tempfile::TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let mut builder = Command::new(env!("CARGO_BIN_EXE_ripstop-web"));
    builder.arg(folder.path().join("page.html")).env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "1");
    assert!(builder.status().unwrap().success(), "the page was not built");
    folder
});

/// A small ply struck off its middle by a body that spins and slides, in a round window.
fn oblique() -> Value {
    json!({
        "title": "oblique", "fabric": {"file": "fabrics/s-728.json"},
        "pack": {"width_mm": 24, "height_mm": 24, "edges": "clamped", "window": {"diameter_mm": 22}},
        "projectile": {
            "shape": "fragment", "diameter_mm": 5.5, "length_mm": 6.2, "mass_g": 1.1, "velocity_m_s": 260, "friction": 0.2,
            "obliquity_deg": 25, "angular_velocity_rad_s": [3000, -2000, 9000], "offset_mm": [1.3, -0.7]
        },
        "solver": {"end_time_us": 8},
    })
}

/// Three plies, the middle one turned, before clay; yarns that differ in strength and resist by their rate of strain.
fn pack() -> Value {
    let mut fabric: Value = serde_json::from_str(case::builtin_fabric("fabrics/s-728.json").unwrap()).unwrap();
    fabric.as_object_mut().unwrap().remove("sources");
    fabric["rate"] = json!({"c_per_s": 2e6, "p": 3});
    json!({
        "title": "pack", "fabric": fabric, "backing": {"material": "clay"},
        "pack": {"width_mm": 12, "height_mm": 12, "edges": "clamped", "plies": 3, "layup": [{}, {"orientation_deg": 30}, {}], "friction": 0.2},
        "projectile": {"shape": "sphere", "diameter_mm": 5, "mass_g": 0.5, "velocity_m_s": 300, "friction": 0.1},
        "variability": {"yarn_strength": {"shape": 20, "gauge_length_mm": 50}},
        "solver": {"end_time_us": 5.5},
    })
}

/// Result of a shot as the page prints it to the console.
fn shoot(case: &Value, by: &str) -> Value {
    let page = PAGE.path().join("page.html");
    let profile = tempfile::tempdir().unwrap();
    let link = |text: &str| text.bytes().map(|byte| format!("%{byte:02x}")).collect::<String>();
    let place = format!("file://{}#run=1&by={by}&case={}", page.display(), link(&case.to_string()));
    let start = |name: &&str| browser(name, profile.path(), &place).stderr(Stdio::piped()).spawn().ok();
    let mut child = NAMES.iter().find_map(start).unwrap();
    let lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let mut guard = Killed(child);
    let (sender, receiver) = std::sync::mpsc::channel();
    thread::spawn(move || {
        let said = lines.map_while(Result::ok).find_map(|line| {
            let (_, said) = line.split_once("\"ripstop: ")?;
            Some(said.rsplit_once("\", source: ").unwrap().0.to_owned())
        });
        sender.send(said).ok();
    });
    let said = receiver.recv_timeout(PATIENCE);
    guard.end();
    serde_json::from_str(&said.unwrap().expect("the browser ended")).unwrap()
}

/// Chromium without a window, with WebGPU in software; tests run as root in containers.
fn browser(name: &str, profile: &Path, page: &str) -> Command {
    let mut command = Command::new(name);
    command.args(["--headless=new", "--no-sandbox", "--no-first-run", "--disable-background-networking"]);
    command.args(["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-logging=stderr"]);
    command.arg(format!("--user-data-dir={}", profile.display())).arg(page).stdout(Stdio::null());
    // It brings a driver in software of its own, which these would hide.
    command.env_remove("VK_DRIVER_FILES").env_remove("VK_ICD_FILENAMES");
    command
}

/// A process that ends with its test.
struct Killed(Child);

impl Killed {
    fn end(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

impl Drop for Killed {
    fn drop(&mut self) {
        self.end();
    }
}

fn numbers(said: &Value, key: &str) -> Vec<f64> {
    said[key].as_array().unwrap_or_else(|| panic!("{said}")).iter().map(|number| number.as_f64().unwrap()).collect()
}

/// Times of the history [µs] and velocities at these [m/s] by the library.
fn native(case: &Value, precision: Precision) -> [Vec<f64>; 2] {
    let run = Options::default()
        .precision(precision)
        .run(&case::from_str("case.json", &case.to_string(), &[]).unwrap())
        .unwrap();
    [
        run.history.iter().map(|row| row.time * 1e6).collect(),
        run.history.iter().map(|row| row.projectile_velocity).collect(),
    ]
}

/// A shot in the browser follows that by the library to `most` of the velocity at impact.
fn follows(case: &Value, by: &str, precision: Precision, most: f64) {
    let said = shoot(case, by);
    assert_eq!(said["backend"], by, "{said}");
    let [times, velocities] = native(case, precision);
    let (time, velocity) = (numbers(&said, "time"), numbers(&said, "velocity"));
    assert!(
        time.len() > 5 && time.len() == times.len() && velocities[0] - velocities[time.len() - 1] > 1.0,
        "{time:?}"
    );
    for (row, (v, expected)) in velocity.iter().zip(&velocities).enumerate() {
        assert!(
            (time[row] - times[row]).abs() < 1e-6 && (v - expected).abs() <= most * velocities[0],
            "{by} {row}: {v} {expected}"
        );
    }
}

fn main() -> ExitCode {
    let is_there = |name: &&str| Command::new(name).arg("--version").output().is_ok();
    let missing = !NAMES.iter().any(is_there);
    let required = env::var("RIPSTOP_REQUIRE_BROWSER").is_ok_and(|value| value == "1");
    let trial = |name: &str, test: fn()| {
        Trial::ignorable_test(name, move || match (missing, required) {
            (true, true) => Err("no Chromium".into()),
            (true, false) => Ok(Completion::ignored_with("no Chromium")),
            _ => {
                test();
                Ok(Completion::Completed)
            }
        })
    };
    let tests = vec![
        trial("a_shot_on_the_processor_of_a_browser_has_the_bits_of_the_library", || {
            follows(&pack(), "cpu", Precision::F32, 0.0)
        }),
        trial("an_oblique_shot_by_webgpu_follows_that_in_double_precision", || {
            follows(&oblique(), "gpu", Precision::F64, 1e-6)
        }),
        trial("a_pack_by_webgpu_follows_that_in_double_precision", || follows(&pack(), "gpu", Precision::F64, 1e-6)),
        trial("a_refusal_says_where_and_what", || {
            let said = shoot(&json!({"title": "none", "fabric": {"file": "fabrics/none.json"}}), "cpu");
            assert!(said["error"].as_str().unwrap().contains("/fabric/file"), "{said}");
        }),
    ];
    libtest_mimic::run(&Arguments::from_args(), tests).exit_code()
}
