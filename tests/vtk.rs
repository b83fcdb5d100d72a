//! Frames as VTK's own readers see them. Needs a Python with `vtk`: `RIPSTOP_PYTHON`, else `python3`.
//!
//! Promise: every point, cell, array and time of `frames.vtkhdf` and of the `.vtu` series is what the frame of the library
//! says, whatever part of the scene was computed; a projectile is a closed surface around its own volume, nose first, that
//! moves and turns as the body does. Without VTK every test is ignored and says so; with `RIPSTOP_REQUIRE_VTK=1`
//! it fails instead.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

use std::f64::consts::PI;
use std::path::Path;
use std::process::{Command, ExitCode};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use libtest_mimic::{Arguments, Completion, Failed, Trial};
use ripstop::case::{self, Case};
use ripstop::output::frames::Recorder;
use ripstop::output::{self, Folder};
use ripstop::run::frame::{Frame, Scene, SnapshotTaker};
use ripstop::run::{self, Observer, Options, Precision, Progress, View};
use serde_json::{Value, json};

#[path = "support/filmed.rs"]
mod filmed;

use filmed::Frames;

fn python() -> Option<&'static str> {
    static PYTHON: OnceLock<Option<String>> = OnceLock::new();
    let found = PYTHON.get_or_init(|| {
        let python = std::env::var("RIPSTOP_PYTHON").unwrap_or_else(|_| "python3".to_owned());
        let there = Command::new(&python).args(["-c", "import numpy, vtkmodules.vtkIOHDF"]).output();
        there.is_ok_and(|output| output.status.success()).then_some(python)
    });
    found.as_deref()
}

fn trial(name: &str, test: impl FnOnce(&Path, &str) + Send + 'static) -> Trial {
    Trial::ignorable_test(name, || match python() {
        Some(python) => {
            let folder = tempfile::tempdir().unwrap();
            test(folder.path(), python);
            Ok(Completion::Completed)
        }
        None if std::env::var("RIPSTOP_REQUIRE_VTK").is_ok_and(|value| value == "1") => {
            Err(Failed::from("no Python with vtk"))
        }
        None => Ok(Completion::ignored_with("no Python with vtk")),
    })
}

fn main() -> ExitCode {
    let mut tests = vec![
        trial("a_torn_quarter", |folder, python| {
            let frames = written(folder, python, &shot(&[]), Options::default(), None, true, None);
            assert_eq!(frames.len(), 6);
            assert!(frames[5].alive[0].contains(&0) && !frames[0].alive[0].contains(&0));
        }),
        trial("two_plies_one_turned", |folder, python| {
            let sets = [r#"/pack/layup=[{}, {"orientation_deg": 30}]"#, "/output/frames=3"];
            let frames = written(folder, python, &shot(&sets), Options::default(), None, true, None);
            assert_eq!(frames.len(), 3);
        }),
        trial("an_oblique_sphere_in_single_precision", |folder, python| {
            let sphere = r#"/projectile={"shape": "sphere", "diameter_mm": 6, "mass_g": 1, "velocity_m_s": 400, "obliquity_deg": 30}"#;
            let options = Options::default().precision(Precision::F32);
            written(folder, python, &shot(&[sphere, "/output/frames=4"]), options, None, false, None);
        }),
        trial("an_interrupted_run_keeps_its_frames", |folder, python| {
            let frames = written(folder, python, &shot(&[]), Options::default(), Some(5e-6), true, None);
            assert_eq!(frames.len(), 6);
            assert!((4.9e-6..6e-6).contains(&frames[5].time), "{} s", frames[5].time);
        }),
    ];
    tests.extend(bodies().into_iter().map(|(name, shape, solid)| {
        trial(name, move |folder, python| {
            let flight = r#""mass_g": 1, "velocity_m_s": 300"#;
            let turn = if name == "a_bar" {
                ""
            } else {
                r#", "obliquity_deg": 30, "azimuth_deg": 20, "yaw_deg": 5, "angular_velocity_rad_s": [9000, 20000, 40000]"#
            };
            let projectile = format!("/projectile={{{shape}, {flight}{turn}}}");
            written(folder, python, &shot(&[&projectile, "/pack/edges=free"]), Options::default(), None, false, Some(solid));
        })
    }));
    libtest_mimic::run(&Arguments::from_args(), tests).exit_code()
}

/// A body as textbooks have it.
#[derive(Clone, Copy)]
struct Solid {
    /// [mm³]; of a bar, of one millimetre of its length [mm²].
    volume: f64,
    /// Half the width of its tip and of its tail, across the axis: along y in the body's axes [mm].
    ends: [f64; 2],
}

/// Name of the test, keys of the case, and what it must be; 6 mm wide, 14 mm long.
fn bodies() -> Vec<(&'static str, &'static str, Solid)> {
    let (r, long) = (3.0_f64, 14.0);
    let disc = PI * r * r;
    // What a rounding of radius e takes from a square rim: its area, at its centroid's distance from the rim (Pappus).
    let e = 0.8;
    let rim = 2.0 * PI * (r - e * (10.0 - 3.0 * PI) / (12.0 - 3.0 * PI)) * (1.0 - PI / 4.0) * e * e;
    // A tangent ogive: an arc of radius a about a point so far off the axis.
    let nose = 8.0_f64;
    let a = (r * r + nose * nose) / (2.0 * r);
    let off = a - r;
    let bow = nose * (a * a - nose * nose).sqrt() + a * a * (nose / a).asin();
    let ogive = PI * (a * a * nose - nose.powi(3) / 3.0 + off * off * nose - off * bow);
    // What two flats of slope m take from a cylinder beside a strip of half-width h.
    let (h, m) = (1.4_f64, 35.0_f64.to_radians().tan());
    let segment = r * r * (h / r).acos() - h * (r * r - h * h).sqrt();
    let flats = 2.0 * m * (2.0 / 3.0 * (r * r - h * h).powf(1.5) - h * segment);
    let solid = |volume: f64, tip: f64, tail: f64| Solid { volume, ends: [tip, tail] };
    vec![
        ("a_cylinder", r#""shape": "cylinder", "diameter_mm": 6, "length_mm": 14"#, solid(disc * long, r, r)),
        (
            "a_cylinder_with_rounded_rims",
            r#""shape": "cylinder", "diameter_mm": 6, "length_mm": 14, "edge_radius_mm": 0.8"#,
            solid(disc * long - 2.0 * rim, r - e, r - e),
        ),
        ("a_sphere", r#""shape": "sphere", "diameter_mm": 6"#, solid(4.0 / 3.0 * disc * r, 0.0, 0.0)),
        (
            "a_cone",
            r#""shape": "cone", "diameter_mm": 6, "length_mm": 14, "nose_length_mm": 8, "edge_radius_mm": 0"#,
            solid(disc * (8.0 / 3.0 + 6.0), 0.0, r),
        ),
        (
            "an_ogive",
            r#""shape": "ogive", "diameter_mm": 6, "length_mm": 14, "nose_length_mm": 8, "edge_radius_mm": 0"#,
            solid(ogive + disc * 6.0, 0.0, r),
        ),
        (
            "a_fragment",
            r#""shape": "fragment", "diameter_mm": 6, "length_mm": 14, "nose_flat_mm": 2.8, "nose_angle_deg": 35"#,
            solid(disc * long - flats, h, r),
        ),
        ("a_bar", r#""shape": "bar", "diameter_mm": 6"#, solid(disc, f64::NAN, f64::NAN)),
    ]
}

fn shot(sets: &[&str]) -> Case {
    let text = r#"{"title": "shot", "fabric": {"file": "fabrics/s-720.json"},
        "pack": {"width_mm": 30, "height_mm": 25},
        "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 20, "mass_g": 3, "velocity_m_s": 600},
        "solver": {"end_time_us": 10, "run_until": "end_time"}, "output": {"frames": 6}}"#;
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    case::from_str("shot", text, &sets).unwrap_or_else(|error| panic!("{error}"))
}

/// Writes frames, and keeps its own.
struct Follower<'a> {
    recorder: Recorder,
    own: Frames,
    interrupt: &'a AtomicBool,
    until: Option<f64>,
}

impl Observer for Follower<'_> {
    fn on_progress(&mut self, at: &Progress) {
        self.interrupt.store(self.until.is_some_and(|until| at.time > until), Ordering::Relaxed);
    }

    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        assert_eq!(self.recorder.snapshot_due(time, dt), self.own.snapshot_due(time, dt));
        self.own.snapshot_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        self.recorder.on_snapshot(view);
        self.own.on_snapshot(view);
    }

    fn on_end(&mut self, view: &View<'_>) {
        self.recorder.on_end(view);
        self.own.on_end(view);
    }
}

/// Runs a case, writes its files, lets VTK read them and compare; the frames.
fn written(
    folder: &Path,
    python: &str,
    case: &Case,
    options: Options<'_>,
    until: Option<f64>,
    vtu: bool,
    solid: Option<Solid>,
) -> Vec<Frame> {
    let place = Folder::prepare(folder, case).unwrap();
    let interrupt = AtomicBool::new(false);
    let mut follower = Follower {
        recorder: Recorder::new(folder, case, &options, vtu, None),
        own: Frames::new(SnapshotTaker::new(case.output.frames as usize, case.solver.end_time)),
        interrupt: &interrupt,
        until,
    };
    let run = run::run(case, options, &interrupt, &mut follower).unwrap();
    assert_eq!(run.interrupted, until.is_some());
    let staged = follower.recorder.finish().unwrap();
    let names = place.write(case, &run, &output::summary(case, &run, 0.0), None, staged).unwrap();
    assert!(names.contains(&"frames.vtkhdf") && names.contains(&"frames.pvd") == vtu);
    let (frames, scene) = follower.own.chosen(case.output.frames as usize);
    let scene = scene.unwrap();
    let expected: Vec<Value> = frames.iter().map(|frame| expected(&scene, frame, solid)).collect();
    std::fs::write(folder.join("expected.json"), Value::from(expected).to_string()).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/vtk/read_back.py");
    let read = Command::new(python).arg(script).arg(folder).output().unwrap();
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
    frames
}

fn expected(scene: &Scene, frame: &Frame, solid: Option<Solid>) -> Value {
    let mm = |numbers: &[f32]| numbers.iter().map(|x| f64::from(*x) * 1e3).collect::<Vec<_>>();
    let moved = |(x, u): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|a| 1e3 * (f64::from(x[a]) + f64::from(u[a])));
    let plies = scene.plies.iter().enumerate();
    let broken = |(warp, weft): (&u8, &u8)| if *warp == 0 && *weft == 0 { 32 } else { 0 };
    let corners = scene
        .plies
        .iter()
        .flat_map(|ply| (0..ply.rows).flat_map(move |r| (0..ply.columns).map(move |c| ply.corners(r, c))));
    let fabric = json!({
        "points_mm": scene.reference.iter().zip(&frame.displacement).map(moved).collect::<Vec<_>>(),
        "cells": scene.elements,
        "corners": corners.collect::<Vec<_>>(),
        "of_points": {
            "displacement_mm": frame.displacement.iter().map(|u| mm(u)).collect::<Vec<_>>(),
            "velocity_m_s": frame.velocity,
        },
        "of_cells": {
            "ply": plies.flat_map(|(n, ply)| vec![n; ply.rows * ply.columns]).collect::<Vec<_>>(),
            "warp_tension_n": frame.tension[0],
            "weft_tension_n": frame.tension[1],
            "warp_strain": frame.strain[0],
            "weft_strain": frame.strain[1],
            "warp_crimp_height_mm": mm(&frame.height[0]),
            "weft_crimp_height_mm": mm(&frame.height[1]),
            "shear_angle_rad": frame.shear_angle,
            "warp_alive": frame.alive[0],
            "weft_alive": frame.alive[1],
            "vtkGhostType": frame.alive[0].iter().zip(&frame.alive[1]).map(broken).collect::<Vec<_>>(),
        }
    });
    json!({ "time_us": frame.time * 1e6, "parts": { "fabric": fabric, "projectile": body(scene, frame, solid) } })
}

/// What is known of the projectile without its mesh: how it stands and moves, and what it encloses.
fn body(scene: &Scene, frame: &Frame, solid: Option<Solid>) -> Value {
    let pose = frame.projectile.unwrap();
    let mut known = json!({
        "centre_mm": pose.position.map(|x| 1e3 * x),
        "rotation": pose.rotation,
        "velocity_m_s": pose.velocity,
        "angular_velocity_rad_s": pose.angular_velocity,
    });
    if let Some(Solid { volume, ends }) = solid {
        // A bar lies over the whole pack.
        let half = scene.reference.iter().flatten().fold(0.0_f64, |half, x| half.max(1e3 * f64::from(x.abs())));
        let bar = ends[0].is_nan();
        known["volume_mm3"] = json!(if bar { 2.0 * half * volume } else { volume });
        known["ends_mm"] = if bar { Value::Null } else { json!(ends) };
    }
    known
}
