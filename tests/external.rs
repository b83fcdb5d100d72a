//! Results as programs of others see them: frames by VTK's own reader, the schema of cases by a validator, `report.html` in Chromium without
//! a window. Needs a Python with `vtk` and `jsonschema` (`RIPSTOP_PYTHON`, else `python3`), and a Chromium.
//!
//! Promises: every point, cell, array and time of the frames is what the library says, whatever part of the scene was computed; the projectile
//! moves and turns as the body does. The schema is one, takes every shipped case and refuses what the program refuses. With its script
//! allowed by its hash alone the page draws its playback and every figure, and what a user wrote stays words. The scripts of `examples/` run.
//! A test whose program is missing is ignored and says so; with `RIPSTOP_REQUIRE_PYTHON=1`, `RIPSTOP_REQUIRE_BROWSER=1` it fails instead.
//! `RIPSTOP_SCREENSHOTS=DIR` leaves a picture of the page. Cannot see: keyboard, pointer, printing.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};

use libtest_mimic::{Arguments, Completion, Trial};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use ripstop::run::frame::{Frame, PlyMesh, Pose, Scene};
use ripstop::run::{Options, Precision};
use ripstop::{FrameCollector, case};
use serde_json::{Value, json};
use tempfile::TempDir;

/// Prints time, part, points, corners and arrays of every file in the list as JSON.
const READER: &str = r#"
import json, sys, xml.etree.ElementTree as tree
from pathlib import Path
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
window, files, folder = vtkStringOutputWindow(), [], Path(sys.argv[1])
vtkOutputWindow.SetInstance(window)
numbers = lambda array: vtk_to_numpy(array).astype(float).ravel().tolist()
for entry in tree.parse(folder / "frames.pvd").getroot().findall("./Collection/DataSet"):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(folder / entry.get("file")))
    reader.Update()
    grid = reader.GetOutput()
    arrays = {"points": numbers(grid.GetPoints().GetData()), "corners": numbers(grid.GetCells().GetConnectivityArray()),
              "ends": numbers(grid.GetCells().GetOffsetsArray()), "time": numbers(grid.GetFieldData().GetArray("TimeValue"))}
    for data in (grid.GetPointData(), grid.GetCellData()):
        arrays.update((data.GetArrayName(n), numbers(data.GetArray(n))) for n in range(data.GetNumberOfArrays()))
    files.append([float(entry.get("timestep")), entry.get("name"), arrays])
assert not window.GetOutput(), window.GetOutput()
print(json.dumps(files))
"#;

type Arrays = BTreeMap<String, Vec<f64>>;

fn python() -> String {
    std::env::var("RIPSTOP_PYTHON").unwrap_or_else(|_| "python3".to_owned())
}

fn main() -> ExitCode {
    let lacking = |modules: &str, words: &'static str| {
        let found = Command::new(python()).args(["-c", &format!("import {modules}")]).output();
        if found.is_ok_and(|output| output.status.success()) { None } else { Some(words) }
    };
    let missing = lacking("jsonschema, numpy, vtkmodules.vtkIOXML", "no Python with vtk and jsonschema");
    let trial = |name, test| optional(name, missing, "RIPSTOP_REQUIRE_PYTHON", test);
    let mut tests = vec![
        trial("the_schema_takes_cases_and_refuses_others", schema),
        trial("a_torn_quarter", || {
            let frames = read_back(&[]);
            assert!(frames[5].alive[0].contains(&0) && !frames[0].alive[0].contains(&0));
        }),
        trial("two_plies_one_turned", || drop(read_back(&[r#"/pack/layup=[{}, {"orientation_deg": 30}]"#]))),
        trial("an_oblique_fragment_that_spins_in_single_precision", || {
            let flight = r#""mass_g": 1, "velocity_m_s": 400, "obliquity_deg": 30, "angular_velocity_rad_s": [9000, 20000, 40000]"#;
            let shape = r#""shape": "fragment", "diameter_mm": 6, "length_mm": 14"#;
            read_back(&[&format!("/projectile={{{shape}, {flight}}}"), "/pack/edges=free", "f32"]);
        }),
    ];
    let missing = lacking("matplotlib, pandas, pyvista", "no Python with matplotlib, pandas and pyvista");
    tests.push(optional("the_scripts_of_examples_run", missing, "RIPSTOP_REQUIRE_PYTHON", examples));
    let folder = tempfile::tempdir().unwrap();
    let is_there = |name: &&&str| chromium(name, folder.path(), &["--version"]).is_some();
    let missing = if NAMES.iter().find(is_there).is_some() { None } else { Some("no Chromium") };
    tests.push(optional("the_page_plays_and_draws", missing, "RIPSTOP_REQUIRE_BROWSER", draws));
    libtest_mimic::run(&Arguments::from_args(), tests).exit_code()
}

/// A test that is ignored and says so where a program is missing, and fails instead where the variable `require` is 1.
fn optional(name: &str, missing: Option<&'static str>, require: &str, test: fn()) -> Trial {
    let required = std::env::var(require).is_ok_and(|value| value == "1");
    Trial::ignorable_test(name, move || match missing {
        Some(missing) if required => Err(missing.into()),
        Some(missing) => Ok(Completion::ignored_with(missing)),
        None => {
            test();
            Ok(Completion::Completed)
        }
    })
}

/// Prints the numbers of the documents that the schema refuses.
const VALIDATOR: &str = r#"
import json, sys
from jsonschema import Draft202012Validator
schema, documents = json.load(sys.stdin)
Draft202012Validator.check_schema(schema)
print([number for number, document in enumerate(documents) if not Draft202012Validator(schema).is_valid(document)])
"#;

/// Values that make the README's shot a bad case, by pointer.
const BAD: [(&str, &str); 9] = [
    ("/zzz", "1"),
    ("/projectile/mass_gg", "1"),
    ("/projectile/shape", "\"ogiv\""),
    ("/projectile/velocity_m_s", "0"),
    ("/projectile/offset_mm", "[0]"),
    ("/solver", "{\"courant\": 1.5}"),
    ("/fabric", "{\"file\": 1}"),
    ("/pack/plies", "65"),
    ("/pack/layup", "[]"),
];

fn schema() {
    let mut documents = Vec::new();
    for folder in ["cases", "cases/verify", "cases/stress"] {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_file()) {
            if path.extension().is_some_and(|end| end == "json") {
                documents.push(serde_json::from_str::<Value>(&fs::read_to_string(&path).unwrap()).unwrap());
                documents.push(case::read(&path, &[]).unwrap().as_run);
            }
        }
    }
    let good = documents.len();
    assert!(good > 60, "{good}");
    let shot: Value = serde_json::from_str(include_str!("../cases/s728-4ply-91.json")).unwrap();
    for (pointer, value) in BAD {
        let mut document = shot.clone();
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        document.pointer_mut(parent).unwrap()[key] = serde_json::from_str(value).unwrap();
        documents.push(document);
    }
    let mut validator = Command::new(python());
    let mut child = validator.args(["-c", VALIDATOR]).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    serde_json::to_writer(child.stdin.take().unwrap(), &(case::schema(), &documents)).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    let refused: Vec<usize> = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(refused, (good..documents.len()).collect::<Vec<_>>());
}

/// A folder with a case, its fabric, and what the program makes of it.
fn run_in_a_folder(case: &str, more: &[String]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("fabrics")).unwrap();
    fs::write(folder.path().join("fabrics/s-720.json"), include_str!("../cases/fabrics/s-720.json")).unwrap();
    fs::write(folder.path().join("shot.json"), case).unwrap();
    let mut program = Command::new(env!("CARGO_BIN_EXE_ripstop"));
    program.args(["run", "shot.json", "--backend", "cpu", "--quiet", "--out", "."]).args(more);
    let run = program.current_dir(folder.path()).output().unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    folder
}

/// Writes the frames of a shot with the program, and compares what VTK reads with the frames of the library.
fn read_back(sets: &[&str]) -> Vec<Frame> {
    let (sets, precision) = match sets {
        [sets @ .., "f32"] => (sets, Precision::F32),
        sets => (sets, Precision::F64),
    };
    let text = r#"{"title": "shot", "fabric": {"file": "fabrics/s-720.json"}, "pack": {"width_mm": 30, "height_mm": 25},
        "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 20, "mass_g": 3, "velocity_m_s": 600},
        "solver": {"end_time_us": 10, "run_until": "end_time"}, "output": {"frames": 6}}"#;
    let more: Vec<String> = sets.iter().map(|set| format!("--set={set}")).collect();
    let folder = run_in_a_folder(text, &[&["--precision".to_owned(), precision.name().to_owned()], &more[..]].concat());
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    let case = case::from_str("shot", text, &sets).unwrap();
    let mut collector = FrameCollector::new(&case, 6);
    Options::default().precision(precision).observe(&case, &mut collector).unwrap();
    let (frames, scene) = (collector.frames(), collector.scene().unwrap());

    let read = Command::new(python()).args(["-c", READER]).arg(folder.path()).output().unwrap();
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
    let files: Vec<(f64, String, Arrays)> = serde_json::from_slice(&read.stdout).unwrap();
    assert_eq!((files.len(), frames.len()), (12, 6));
    for (n, (time, part, arrays)) in files.iter().enumerate() {
        let frame = &frames[n / 2];
        assert!((time - frame.time * 1e6).abs() < 1e-9 && arrays["time"] == [*time], "{time} {:?}", arrays["time"]);
        if n % 2 == 0 {
            compare(part, "fabric", arrays, &fabric_of(scene, frame));
        } else {
            let (start, now) = (frames[0].projectile.unwrap(), frame.projectile.unwrap());
            compare(part, "projectile", arrays, &projectile_of(arrays, &files[1].2["points"], &start, &now));
        }
    }
    frames
}

/// All arrays of a part are as expected, and no other is there.
fn compare(part: &str, expected_part: &str, found: &Arrays, expected: &Arrays) {
    assert_eq!(part, expected_part);
    let names = |arrays: &Arrays| arrays.keys().filter(|name| *name != "time").cloned().collect::<Vec<_>>();
    assert_eq!(names(found), names(expected));
    for (name, expected) in expected {
        let largest = expected.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        assert_eq!(found[name].len(), expected.len(), "{part} {name}");
        let off = found[name].iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        // Single precision, once more for the change of units, and twice for a difference of places.
        let allowed = if part == "projectile" { 1e-5 * largest.max(1.0) } else { 4e-7 * largest };
        assert!(off <= allowed, "{part} {name}: off by {off}, at most {allowed} is rounding");
    }
}

fn fabric_of(scene: &Scene, frame: &Frame) -> Arrays {
    let floats = |numbers: &[f32], unit: f64| numbers.iter().map(|x| f64::from(*x) * unit).collect::<Vec<_>>();
    let flags = |numbers: &[u8]| numbers.iter().map(|x| f64::from(*x)).collect::<Vec<_>>();
    let moved = scene.reference.iter().flatten().zip(frame.displacement.iter().flatten());
    let places = |ply: &PlyMesh| (0..ply.elements()).map(|n| [n / ply.columns, n % ply.columns]).collect::<Vec<_>>();
    let corners =
        scene.plies.iter().flat_map(|ply| places(ply).into_iter().flat_map(|[row, column]| ply.corners(row, column)));
    let plies = scene.plies.iter().enumerate().flat_map(|(n, ply)| vec![n as f64; ply.elements()]);
    let hidden =
        frame.alive[0].iter().zip(&frame.alive[1]).map(|(warp, weft)| if warp + weft == 0 { 32.0 } else { 0.0 });
    Arrays::from(
        [
            ("points", moved.map(|(x, u)| 1e3 * (f64::from(*x) + f64::from(*u))).collect()),
            ("corners", corners.map(|corner| corner as f64).collect()),
            ("ends", (0..=scene.elements).map(|n| 4.0 * n as f64).collect()),
            ("displacement_mm", floats(&frame.displacement.concat(), 1e3)),
            ("velocity_m_s", floats(&frame.velocity.concat(), 1.0)),
            ("ply", plies.collect()),
            ("warp_tension_n", floats(&frame.tension[0], 1.0)),
            ("weft_tension_n", floats(&frame.tension[1], 1.0)),
            ("warp_strain", floats(&frame.strain[0], 1.0)),
            ("weft_strain", floats(&frame.strain[1], 1.0)),
            ("warp_crimp_height_mm", floats(&frame.height[0], 1e3)),
            ("weft_crimp_height_mm", floats(&frame.height[1], 1e3)),
            ("shear_angle_rad", floats(&frame.shear_angle, 1.0)),
            ("warp_alive", flags(&frame.alive[0])),
            ("weft_alive", flags(&frame.alive[1])),
            ("vtkGhostType", hidden.collect()),
        ]
        .map(|(name, numbers)| (name.to_owned(), numbers)),
    )
}

/// The points of the start, moved and turned as the body; the faces are what they are.
fn projectile_of(found: &Arrays, start: &[f64], from: &Pose, to: &Pose) -> Arrays {
    let rotation = |[w, x, y, z]: [f64; 4]| UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z));
    let (before, now) = (rotation(from.rotation), rotation(to.rotation));
    let [place, velocity, spin] = [to.position, to.velocity, to.angular_velocity].map(Vector3::from);
    let mut expected = found.clone();
    expected.remove("time");
    let (mut points, mut displacement, mut velocities) = (Vec::new(), Vec::new(), Vec::new());
    for point in start.chunks(3).map(Vector3::from_column_slice) {
        let arm = now * (before.inverse() * (point - 1e3 * Vector3::from(from.position)));
        points.extend((1e3 * place + arm).iter());
        displacement.extend((1e3 * place + arm - point).iter());
        velocities.extend((velocity + spin.cross(&(1e-3 * arm))).iter());
    }
    expected.extend(
        [("points", points), ("displacement_mm", displacement), ("velocity_m_s", velocities)]
            .map(|(n, x)| (n.to_owned(), x)),
    );
    expected
}

/// Every script of `examples/`, in a folder with two runs of a small shot, and its picture or table.
fn examples() {
    let folder = tempfile::tempdir().unwrap();
    let case = json!({
        "title": "a small ball", "fabric": {"file": "s-720.json"}, "pack": {"width_mm": 20, "height_mm": 20},
        "projectile": {"shape": "sphere", "diameter_mm": 5, "mass_g": 0.5, "velocity_m_s": 150},
        "solver": {"end_time_us": 100}, "variability": {"hit": "unit_cell"},
    });
    fs::write(folder.path().join("s-720.json"), include_str!("../cases/fabrics/s-720.json")).unwrap();
    fs::write(folder.path().join("shot.json"), case.to_string()).unwrap();
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let program = Path::new(env!("CARGO_BIN_EXE_ripstop")).parent().unwrap().to_owned();
    let others = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([program].into_iter().chain(std::env::split_paths(&others))).unwrap();
    let call = |program: &str, arguments: &[&str], task: &str| {
        let mut command = Command::new(program);
        command.args(arguments).current_dir(folder.path()).env("PATH", &path).env("SLURM_ARRAY_TASK_ID", task);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let script = |name: &str| scripts.join(name).to_str().unwrap().to_owned();
    call("ripstop", &["run", "shot.json", "--backend", "cpu", "--frames", "4", "-o", "a", "-q"], "");
    call(&python(), &[&script("picture.py"), "a", "30", "shot.png"], "");
    let picture = fs::read(folder.path().join("shot.png")).unwrap();
    assert!(picture.starts_with(b"\x89PNG") && picture.len() > 5000, "{}", picture.len());
    for task in ["0", "1", "10"] {
        call("bash", &[&script("shots.sbatch"), "shot.json", "60..300", "out"], task);
    }
    call(&python(), &[&script("collect.py"), "out"], "");
    let table = fs::read_to_string(folder.path().join("out/all.csv")).unwrap();
    let heading = table.lines().next().unwrap();
    assert_eq!((table.lines().count(), heading), (4, "velocity_m_s,perforated,residual_velocity_m_s"));
    assert!(call("ripstop", &["fit", "out/all.csv"], "").contains("3 shots"), "{table}");
    // ParaView is not at hand: that the script is one, and that what it names is there.
    let state = fs::read_to_string(script("paraview_state.py")).unwrap();
    call(
        &python(),
        &["-c", "import sys; compile(open(sys.argv[1]).read(), sys.argv[1], 'exec')", &script("paraview_state.py")],
        "",
    );
    let frame = fs::read(folder.path().join("a/frames/fabric_0000.vtu")).unwrap();
    let head = String::from_utf8_lossy(&frame[..4000]).into_owned()
        + &fs::read_to_string(folder.path().join("a/frames.pvd")).unwrap();
    for name in ["displacement_mm", "warp_tension_n", "fabric", "projectile"] {
        assert!(state.contains(&format!("\"{name}\"")) && head.contains(&format!("\"{name}\"")), "{name}");
    }
}

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

fn draws() {
    let case = json!({
        "title": TITLE, "fabric": {"file": "fabrics/s-720.json"}, "pack": {"width_mm": 30, "height_mm": 30}, "solver": {"end_time_us": 20},
        "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 12, "mass_g": 3, "velocity_m_s": 600},
    });
    let folder = run_in_a_folder(&case.to_string(), &[]);
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
