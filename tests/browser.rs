//! `report.html` in a real browser: Chromium without a window.
//!
//! Promise: with its script allowed by its hash alone the page draws its playback and every figure, and what a user wrote stays words.
//! Without Chromium the test is ignored and says so; with `RIPSTOP_REQUIRE_BROWSER=1` it fails instead. `RIPSTOP_SCREENSHOTS=DIR`
//! leaves a picture to look at.
//! Cannot see: keyboard, pointer, printing.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::process::{Command, ExitCode};

use libtest_mimic::Arguments;
use serde_json::json;

#[path = "support/optional.rs"]
mod optional;

const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
const TITLE: &str = "</title></script><script>document.title='taken'</script><img src=x onerror=\"document.title='taken'\">'\"&amp;<!--";

/// Chromium with a fresh profile, without window, sandbox (tests run as root in containers) and network, WebGL in software.
fn chromium(name: &str, folder: &Path, arguments: &[&str]) -> Option<String> {
    let mut command = Command::new(name);
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]);
    command.args(["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]);
    command.args(["--virtual-time-budget=20000", "--window-size=1200,4200", "--hide-scrollbars"]);
    command.arg(format!("--user-data-dir={}", folder.display())).args(arguments);
    // It brings a driver in software of its own, which these would hide.
    let output = command.env_remove("VK_DRIVER_FILES").env_remove("VK_ICD_FILENAMES").output().ok()?;
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn main() -> ExitCode {
    let folder = tempfile::tempdir().unwrap();
    let is_there = |name: &&&str| chromium(name, folder.path(), &["--version"]).is_some();
    let missing = if NAMES.iter().find(is_there).is_some() { None } else { Some("no Chromium") };
    let tests = vec![optional::trial("the_page_plays_and_draws", missing, "RIPSTOP_REQUIRE_BROWSER", draws)];
    libtest_mimic::run(&Arguments::from_args(), tests).exit_code()
}

fn draws() {
    let folder = tempfile::tempdir().unwrap();
    let fabric = include_str!("../cases/fabrics/s-720.json");
    std::fs::create_dir(folder.path().join("fabrics")).unwrap();
    std::fs::write(folder.path().join("fabrics/s-720.json"), fabric).unwrap();
    let case = json!({
        "title": TITLE, "fabric": {"file": "fabrics/s-720.json"}, "pack": {"width_mm": 30, "height_mm": 30}, "solver": {"end_time_us": 20},
        "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 12, "mass_g": 3, "velocity_m_s": 600},
    });
    std::fs::write(folder.path().join("shot.json"), case.to_string()).unwrap();
    let mut run = Command::new(env!("CARGO_BIN_EXE_ripstop"));
    let run =
        run.args(["run", "shot.json", "--backend", "cpu", "--out", "."]).current_dir(folder.path()).output().unwrap();
    assert!(run.status.success(), "{run:?}");
    let page = format!("file://{}", folder.path().join("report.html").display());
    let profile = folder.path().join("profile");
    let look = |argument: &str| NAMES.iter().find_map(|name| chromium(name, &profile, &[argument, &page])).unwrap();

    let found = look("--dump-dom");
    assert!(found.contains("data-playback=\"ready\""), "the script did not run, or WebGL failed: {found:.300}");
    // The script has given the canvas its place, every figure over time its mark, and paper a picture of the scene.
    assert!(found.contains("data-place=") && !found.contains("<div class=\"player\" hidden"), "{found:.300}");
    for id in ["velocity", "force", "deflection", "energy", "failures"] {
        let figure = found.split_once(&format!("id=\"{id}\"")).unwrap().1.split_once("</figure>").unwrap().0;
        assert!(figure.contains("class=\"now\"") && figure.contains("class=\"reading\""), "{id}: {figure:.500}");
    }
    let picture = found.split_once("id=\"paper\"").unwrap().1.split_once("</figure>").unwrap().0;
    assert!(picture.contains("src=\"data:image/png;base64,") && picture.len() > 10_000, "{}", picture.len());
    assert!(!found.contains("<title>taken") && found.contains("&lt;/title&gt;&lt;/script&gt;&lt;script&gt;"));

    if let Ok(pictures) = std::env::var("RIPSTOP_SCREENSHOTS") {
        look(&format!("--screenshot={}", Path::new(&pictures).join("report.png").display()));
    }
}
