//! A case, with the changes that it was made with, and one shot of it: its run, its results and its frames.

use std::path::PathBuf;
use std::time::Instant;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use ripstop::case as cases;
use ripstop::output::{self, Animation, Folder, StagedFrames, csv, report, warnings};
use ripstop::run::{
    self as runs, Observer, Progress, Run as Finished, RunError as StartError, Simulation, Skips, View,
};
use ripstop::{Case as Nominal, Frame, FrameCollector};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::{
    DeviceError, RunError, WantedBackend, Watch, arguments, bytes, forget_devices, not_started, refused, watched, wrong,
};

/// Bytes of the frames in memory at most, and of a node with an element in one.
const FRAME_MEMORY: usize = 4 << 30;
const FRAME_BYTES: usize = 64;

/// A checked case. Changes are kept apart, so that a case changed twice is named as the command line names it.
#[pyclass(frozen, module = "ripstop._ripstop")]
pub(crate) struct Case {
    /// The case without the changes.
    base: Nominal,
    sets: Vec<String>,
    /// The case with them.
    pub(crate) case: Nominal,
}

impl Case {
    fn of(base: Nominal, sets: Vec<String>) -> PyResult<Self> {
        let case = if sets.is_empty() { Ok(base.clone()) } else { base.with_sets(&sets) };
        let case = case.and_then(|case| warnings::refuse(&case).map(|()| case)).map_err(refused)?;
        Ok(Self { base, sets, case })
    }

    /// The case with further changes.
    pub(crate) fn changed(&self, sets: &[String]) -> PyResult<Self> {
        Self::of(self.base.clone(), [&self.sets[..], sets].concat())
    }

    /// File of the case, or its name.
    pub(crate) fn file(&self) -> String {
        let path = self.case.path.display().to_string();
        if path.is_empty() { self.case.name.clone() } else { path }
    }
}

#[pymethods]
impl Case {
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        Self::of(cases::read(&path, &[]).map_err(refused)?, Vec::new())
    }

    #[staticmethod]
    fn parse(name: &str, text: &str, path: PathBuf, sets: Vec<String>) -> PyResult<Self> {
        let mut base = cases::from_str(name, text, &[]).map_err(refused)?;
        base.path = path;
        Self::of(base, sets)
    }

    fn with_sets(&self, sets: Vec<String>) -> PyResult<Self> {
        self.changed(&sets)
    }

    /// Arguments of [`Case::parse`] that give this case again.
    fn parts(&self) -> (String, String, PathBuf, Vec<String>) {
        (self.base.name.clone(), self.base.as_run.to_string(), self.base.path.clone(), self.sets.clone())
    }

    #[getter]
    fn title(&self) -> &str {
        &self.case.title
    }

    #[getter]
    fn name(&self) -> &str {
        &self.case.name
    }

    /// Whether anything varies from shot to shot.
    #[getter]
    fn varies(&self) -> bool {
        self.case.varies()
    }

    /// JSON of `ripstop check`.
    fn check(&self, py: Python<'_>) -> PyResult<String> {
        let simulation = py.detach(|| Simulation::<f64>::with_skips(&self.case, Skips::default()));
        let simulation = simulation.map_err(|error| refused(error.in_file(&self.file())))?;
        Ok(output::sheet(&self.case, &simulation).to_string())
    }

    /// The case as run, as JSON.
    fn json(&self) -> String {
        self.case.as_run.to_string()
    }
}

/// JSON Schema of a case.
#[pyfunction]
pub(crate) fn schema() -> String {
    cases::schema().to_string()
}

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
    backend: WantedBackend,
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
            forget_devices();
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
