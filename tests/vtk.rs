//! Frames as VTK's own readers see them. Needs a Python with `vtk`: `RIPSTOP_PYTHON`, else `python3`.
//!
//! Promise: every point, cell, array and time of `frames.vtkhdf` and of the `.vtu` series is what the frame of the library
//! says, whatever part of the scene was computed. Without VTK every test is ignored and says so; with `RIPSTOP_REQUIRE_VTK=1`
//! it fails instead.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on has failed")]

use std::path::Path;
use std::process::{Command, ExitCode};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use libtest_mimic::{Arguments, Completion, Failed, Trial};
use ripstop::case::{self, Case};
use ripstop::frame::{Camera, Frame, Scene};
use ripstop::output::frames::Recorder;
use ripstop::output::{self, Folder};
use ripstop::simulation::{self, Options, Precision, Progress, View, Watch};
use serde_json::{Value, json};

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
    let tests = vec![
        trial("a_torn_quarter", |folder, python| {
            let frames = written(folder, python, &shot(&[]), Options::default(), None, true);
            assert_eq!(frames.len(), 6);
            assert!(frames[5].alive[0].contains(&0) && !frames[0].alive[0].contains(&0));
        }),
        trial("two_plies_one_turned", |folder, python| {
            let sets = [r#"/pack/layup=[{}, {"orientation_deg": 30}]"#, "/output/frames=3"];
            let frames = written(folder, python, &shot(&sets), Options::default(), None, true);
            assert_eq!(frames.len(), 3);
        }),
        trial("an_oblique_sphere_in_single_precision", |folder, python| {
            let sphere = r#"/projectile={"shape": "sphere", "diameter_mm": 6, "mass_g": 1, "velocity_m_s": 400, "obliquity_deg": 30}"#;
            let options = Options { precision: Precision::F32, ..Options::default() };
            written(folder, python, &shot(&[sphere, "/output/frames=4"]), options, None, false);
        }),
        trial("an_interrupted_run_keeps_its_frames", |folder, python| {
            let frames = written(folder, python, &shot(&[]), Options::default(), Some(5e-6), true);
            assert!((2..6).contains(&frames.len()), "{} frames", frames.len());
        }),
    ];
    libtest_mimic::run(&Arguments::from_args(), tests).exit_code()
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
    camera: Camera,
    frames: Vec<Frame>,
    scene: Option<Scene>,
    interrupt: &'a AtomicBool,
    until: Option<f64>,
}

impl Watch for Follower<'_> {
    fn progress(&mut self, at: &Progress) {
        self.interrupt.store(self.until.is_some_and(|until| at.time > until), Ordering::Relaxed);
    }

    fn is_due(&self, time: f64, dt: f64) -> bool {
        assert_eq!(self.recorder.is_due(time, dt), self.camera.is_due(time, dt));
        self.camera.is_due(time, dt)
    }

    fn look(&mut self, view: &View<'_>) {
        self.recorder.look(view);
        let snapshot = self.camera.take(view);
        self.frames.push(snapshot.frame());
        self.scene = Some(snapshot.scene().clone());
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
) -> Vec<Frame> {
    let place = Folder::prepare(folder, case).unwrap();
    let interrupt = AtomicBool::new(false);
    let mut follower = Follower {
        recorder: Recorder::start(folder, case, vtu, None).unwrap(),
        camera: Camera::new(case.output.frames as usize, case.solver.end_time),
        frames: Vec::new(),
        scene: None,
        interrupt: &interrupt,
        until,
    };
    let run = simulation::run(case, options, &interrupt, &mut follower).unwrap();
    assert_eq!(run.interrupted, until.is_some());
    let staged = follower.recorder.finish().unwrap();
    let names = place.write(case, &run, &output::summary(case, &run, 0.0), None, staged).unwrap();
    assert!(names.contains(&"frames.vtkhdf") && names.contains(&"frames.pvd") == vtu);
    let scene = follower.scene.unwrap();
    let expected: Vec<Value> = follower.frames.iter().map(|frame| expected(&scene, frame)).collect();
    std::fs::write(folder.join("expected.json"), Value::from(expected).to_string()).unwrap();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/vtk/read_back.py");
    let read = Command::new(python).arg(script).arg(folder).output().unwrap();
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
    follower.frames
}

fn expected(scene: &Scene, frame: &Frame) -> Value {
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
    json!({ "time_us": frame.time * 1e6, "parts": { "fabric": fabric, "projectile": solid(frame) } })
}

/// What is known of the projectile without its mesh: where its points lie around the centre of mass.
fn solid(frame: &Frame) -> Value {
    let pose = frame.projectile.unwrap();
    json!({ "centre_mm": pose.position.map(|x| 1e3 * x), "velocity_m_s": pose.velocity })
}
