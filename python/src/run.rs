//! One shot: its run, its results and its frames.

use std::path::PathBuf;
use std::time::Instant;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use ripstop::output::{self, Animation, Folder, StagedFrames, csv, report};
use ripstop::run::{self as runs, Observer, Progress, Run as Finished, RunError as StartError, View};
use ripstop::{Case as Nominal, Frame, FrameCollector};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::backend::{self, Wanted};
use crate::case::Case;
use crate::watch::{Watch, watched};
use crate::{DeviceError, RunError, arguments, bytes, not_started, refused, wrong};

/// Bytes of the frames in memory at most, and of a node with an element in one.
const FRAME_MEMORY: usize = 4 << 30;
const FRAME_BYTES: usize = 64;

/// Plies, reference positions, and the frames.
type Frames<'py> = (Vec<[usize; 3]>, Bound<'py, PyBytes>, Vec<(f64, Bound<'py, PyDict>, Option<Vec<f64>>)>);

/// A run that has ended.
#[pyclass(frozen, module = "ripstop._ripstop")]
pub(crate) struct Run {
    case: Nominal,
    run: Finished,
    summary: Value,
    frames: Option<FrameCollector>,
}

/// Observer of a run: progress, frames in memory, the playback of the page.
struct Observers<'a> {
    watch: &'a Watch,
    frames: Option<FrameCollector>,
    animation: Option<Animation>,
}

impl Observers<'_> {
    fn takers(&mut self) -> impl Iterator<Item = &mut dyn Observer> {
        let frames = self.frames.as_mut().map(|frames| frames as &mut dyn Observer);
        frames.into_iter().chain(self.animation.as_mut().map(|animation| animation as &mut dyn Observer))
    }
}

impl Observer for Observers<'_> {
    fn on_progress(&mut self, at: &Progress) {
        self.watch.progress(json!({
            "time_us": 1e6 * at.time, "end_time_us": 1e6 * at.end_time, "velocity_m_s": at.velocity,
            "failed_yarns": at.failed, "steps": at.steps,
        }));
    }

    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.frames.as_ref().is_some_and(|frames| frames.snapshot_due(time, dt))
            || self.animation.as_ref().is_some_and(|animation| animation.snapshot_due(time, dt))
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        let [time, dt] = view.clock();
        self.takers().filter(|taker| taker.snapshot_due(time, dt)).for_each(|taker| taker.on_snapshot(view));
    }

    fn on_end(&mut self, view: &View<'_>) {
        self.takers().for_each(|taker| taker.on_end(view));
    }
}

/// Options of a run.
#[derive(Deserialize)]
struct Request {
    frames: Option<usize>,
    out: Option<PathBuf>,
    #[serde(flatten)]
    backend: Wanted,
}

/// Runs a case: the run, and the exception that ended it early.
#[pyfunction]
pub(crate) fn run(
    py: Python<'_>,
    case: &Case,
    request: &str,
    show: Option<Py<PyAny>>,
) -> PyResult<(Run, Option<PyErr>)> {
    let start = Instant::now();
    let (file, case, request) = (case.file(), &case.case, arguments::<Request>(request)?);
    let frames = request.frames.unwrap_or(case.output.frames as usize);
    let most = FRAME_MEMORY / FRAME_BYTES / case.elements().max(1) / 2;
    if frames > most {
        let help = "`ripstop run --frames` writes them to the disk";
        return Err(wrong("frames", &format!("at most {most} in memory"), &frames.to_string(), help));
    }
    let chosen = py.detach(|| request.backend.open())?;
    let folder = request.out.map(|out| Folder::prepare(&out, case)).transpose().map_err(refused)?;
    let work = |watch: &Watch| {
        let attempt = |options| {
            let animation = folder.is_some().then(|| Animation::new(case));
            let frames = (frames > 0).then(|| FrameCollector::new(case, frames));
            let mut observers = Observers { watch, frames, animation };
            let run = runs::run(case, options, &watch.interrupt, &mut observers).map_err(Box::new)?;
            Ok::<_, Box<StartError>>((run, observers.frames, observers.animation))
        };
        let done = match attempt(chosen.options()) {
            Err(error) if chosen.auto && matches!(*error, StartError::Device(_)) => {
                attempt(chosen.options().device(None))
            }
            done => done,
        };
        done.map(|(run, frames, animation)| {
            let summary = output::summary(case, &run, start.elapsed().as_secs_f64());
            let page = animation.map(|animation| report::report(case, &run, &summary, &animation));
            let write = |folder: &Folder| folder.write(case, &run, &summary, page, &StagedFrames::default());
            let written = folder.as_ref().map_or(Ok(()), |folder| write(folder).and_then(|_| folder.forget()));
            (Run { case: case.clone(), run, summary, frames }, written)
        })
    };
    let (done, raised) = watched(py, show, work)?;
    match done {
        Ok((run, written)) => {
            let failure = raised.or_else(|| written.err().map(refused)).or_else(|| run.failure(&file));
            Ok((run, failure))
        }
        Err(error) => {
            if let Some(folder) = folder {
                folder.abandon();
            }
            Err(not_started(&file, *error))
        }
    }
}

impl Run {
    /// Failure of a run that became unstable or lost its device, in the words of the command line.
    fn failure(&self, file: &str) -> Option<PyErr> {
        if let Some(divergence) = &self.run.divergence {
            let place = output::place(divergence);
            return Some(RunError::new_err(format!(
                "error: {file}: the run became unstable\n  where: {place}\n  found: {}\n  help: lower /solver/courant",
                divergence.quantity
            )));
        }
        self.run.lost.as_ref().map(|reason| {
            backend::forget();
            DeviceError::new_err(format!(
                "error: {file}: the device gave up at {}\n  found: {reason}\n  help: take --backend cpu",
                output::reached(&self.run)
            ))
        })
    }
}

#[pymethods]
impl Run {
    /// `summary.json`.
    fn summary(&self) -> String {
        self.summary.to_string()
    }

    /// Verdict in a line.
    fn verdict(&self) -> String {
        let verdict = output::verdict(&self.case, &self.run);
        format!("{}{} {}", verdict.word.to_uppercase(), verdict.mark(), verdict.detail)
    }

    /// Columns of `history.csv`, and their numbers as float64, one column after the other.
    fn history<'py>(&self, py: Python<'py>) -> (Vec<&'static str>, Bound<'py, PyBytes>) {
        let rows = &self.run.history;
        // No negative zero, as in the file.
        let column = |(_, of): &csv::HistoryColumn| rows.iter().map(move |row| of(row) + 0.0).collect::<Vec<f64>>();
        let numbers: Vec<f64> = csv::COLUMNS.iter().flat_map(column).collect();
        (csv::COLUMNS.iter().map(|(name, _)| *name).collect(), bytes(py, &numbers))
    }

    /// Text of `events.csv`, `plies.csv` or `profiles.csv`.
    fn table(&self, name: &str) -> String {
        match name {
            "events" => csv::events(&self.case, &self.run.events, self.run.time_step),
            "plies" => csv::plies(&self.run.ply_history),
            _ => csv::profiles(&self.run.profiles),
        }
    }

    /// Plies as columns, rows and first node; reference positions [mm]; frames: their time [µs], arrays by the names that .vtu files have, and
    /// the projectile's position [m], rotation and velocity.
    fn frames<'py>(&self, py: Python<'py>) -> PyResult<Option<Frames<'py>>> {
        let Some((collector, scene)) = self.frames.as_ref().and_then(|frames| Some((frames, frames.scene()?))) else {
            return Ok(None);
        };
        let mm = |numbers: &[f32]| numbers.iter().map(|x| (f64::from(*x) * 1e3) as f32).collect::<Vec<f32>>();
        let frame = |frame: &Frame| {
            let of = PyDict::new(py);
            of.set_item("displacement_mm", bytes(py, &mm(frame.displacement.as_flattened())))?;
            of.set_item("velocity_m_s", bytes(py, &frame.velocity))?;
            for (n, yarn) in ["warp", "weft"].into_iter().enumerate() {
                of.set_item(format!("{yarn}_tension_n"), bytes(py, &frame.tension[n]))?;
                of.set_item(format!("{yarn}_strain"), bytes(py, &frame.strain[n]))?;
                of.set_item(format!("{yarn}_crimp_height_mm"), bytes(py, &mm(&frame.height[n])))?;
                of.set_item(format!("{yarn}_alive"), bytes(py, &frame.alive[n]))?;
            }
            of.set_item("shear_angle_rad", bytes(py, &frame.shear_angle))?;
            let pose = frame.projectile.map(|pose| [&pose.position[..], &pose.rotation, &pose.velocity].concat());
            Ok((1e6 * frame.time, of, pose))
        };
        let plies = scene.plies.iter().map(|ply| [ply.columns, ply.rows, ply.first_node]).collect();
        let frames = collector.frames().iter().map(frame).collect::<PyResult<_>>()?;
        Ok(Some((plies, bytes(py, &mm(scene.reference.as_flattened())), frames)))
    }

    /// The page `report.html` without its playback.
    fn page(&self) -> String {
        report::report(&self.case, &self.run, &self.summary, &Animation::new(&self.case))
    }
}
