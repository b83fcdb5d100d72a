//! Many shots of a case, a limit from a table of shots, and the unit cell. Studies leave their results in a folder.

use std::path::PathBuf;

use clap::ValueEnum;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use ripstop::case::with_velocity;
use ripstop::model::unit_cell::{self, CurveLaw};
use ripstop::output::Folder;
use ripstop::study::batch::{BatchError, BatchOptions, StudyProgress};
use ripstop::study::fit::{self as fits, ColumnKind, VelocityUnit};
use ripstop::study::shots::{self, ShotsRequest};
use ripstop::study::sweep::{self, Factor, SweepOf, SweepRequest, grid};
use ripstop::study::v50::{self, V50Request};
use serde::Deserialize;
use serde_json::json;

use crate::run::Case;
use crate::{WantedBackend, arguments, bytes, forget_devices, no_device, refused, watched, wrong};

/// Points of a unit cell at most.
const MAX_POINTS: usize = 1_000_000;

/// A study that is asked for, with the options of its command.
#[derive(Deserialize)]
struct Request {
    out: PathBuf,
    /// Whether a V50 is sought; else shots are fired.
    v50: bool,
    /// Values by pointer; none of a study of the case alone.
    over: Vec<(String, Vec<String>)>,
    count: u32,
    velocity: Option<[f64; 2]>,
    until_width: Option<f64>,
    bracket: f64,
    refined: u32,
    level: f64,
    seed: Option<u32>,
    resume: bool,
    #[serde(flatten)]
    backend: WantedBackend,
}

impl Request {
    /// Study of the case at each point of the grid.
    fn sweep(&self, case: &Case) -> PyResult<SweepRequest> {
        let factor =
            |(pointer, values): &(String, Vec<String>)| Factor { pointer: pointer.clone(), values: values.clone() };
        let factors: Vec<Factor> = self.over.iter().map(factor).collect();
        let mut points = Vec::new();
        for values in grid(&factors).map_err(refused)? {
            let set = |(factor, value): (&Factor, &String)| format!("{}={value}", factor.pointer);
            let sets: Vec<String> = factors.iter().zip(&values).map(set).collect();
            points.push((values, case.changed(&sets)?.case));
        }
        let of = if self.v50 { SweepOf::V50(self.limit()) } else { SweepOf::Shots(self.shots()) };
        Ok(SweepRequest { factors, level: self.level, of, points })
    }

    fn shots(&self) -> ShotsRequest {
        ShotsRequest { count: self.count, velocity: self.velocity, level: self.level }
    }

    fn limit(&self) -> V50Request {
        let Self { count, until_width, bracket, refined, level, .. } = *self;
        V50Request { count, until_width, bracket, refined, level }
    }
}

/// Runs a study into its folder: the reason why there is no limit where one was sought in vain, and the exception that ended it early.
#[pyfunction]
pub(crate) fn study(
    py: Python<'_>,
    case: &Case,
    request: &str,
    show: Option<Py<PyAny>>,
) -> PyResult<(Option<String>, Option<PyErr>)> {
    let (request, file): (Request, String) = (arguments(request)?, case.file());
    let mut nominal = case.case.clone();
    // Velocities are those of the shots.
    nominal.title = with_velocity(&nominal.title, None);
    if nominal.projectile.is_none() {
        return Err(wrong(&file, "a projectile, to be shot", "none in the case", "add /projectile"));
    }
    let sweep = if request.over.is_empty() { None } else { Some(request.sweep(case)?) };
    let chosen = py.detach(|| request.backend.open())?;
    let files = if sweep.is_some() { sweep::FILES } else { [shots::FILES, v50::FILES][usize::from(request.v50)] };
    let folder = Folder::prepare_for(&request.out, files, &[nominal.path.as_path()]).map_err(refused)?;
    let usual = nominal.variability.as_ref().map_or(1, |variability| variability.seed);
    let cores = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let (done, raised) = watched(py, show, |watch| {
        let options = BatchOptions {
            seed: request.seed.unwrap_or(usual),
            threads: chosen.threads.unwrap_or_else(cores),
            threads_per_shot: 1,
            precision: chosen.precision,
            device: chosen.device.as_deref(),
            interrupt: &watch.interrupt,
            resume: request.resume,
            progress: &|StudyProgress { done, of, shots, limit: [low, high] }| {
                watch.progress(json!({ "done": done, "of": of, "shots": shots, "low_m_s": low, "high_m_s": high }));
            },
        };
        match &sweep {
            Some(sweep) => sweep::run(sweep, &options, &folder, &nominal.title).map(|_| None),
            None if request.v50 => v50::run(&nominal, &request.limit(), &options, &folder).map(|found| found.missing()),
            None => shots::run(&nominal, &request.shots(), &options, &folder).map(|_| None),
        }
    })?;
    match done {
        Ok(missing) => Ok((missing.map(|why| format!("error: {file}: {why}")), raised)),
        Err(BatchError::Interrupted) => Ok((None, raised)),
        Err(BatchError::Refused(error)) => Err(refused(error)),
        Err(BatchError::Device(error)) => {
            forget_devices();
            Err(no_device(&error))
        }
    }
}

/// Names of the numbers of the unit cell, and those of every pair of stretches as float64, number after number.
#[pyfunction]
pub(crate) fn crossover<'py>(
    py: Python<'py>,
    case: &Case,
    warp: Vec<f64>,
    weft: Vec<f64>,
    law: Option<&str>,
) -> PyResult<(Vec<&'static str>, Bound<'py, PyBytes>)> {
    let fabric = &case.case.fabric;
    let law = law.map_or(Ok(fabric.crossover.law.into()), |name| named::<CurveLaw>("law", name))?;
    if warp.len().saturating_mul(weft.len()) > MAX_POINTS {
        let (expected, found) = (format!("at most {MAX_POINTS} points"), format!("{} × {}", warp.len(), weft.len()));
        return Err(wrong("warp_stretch, weft_stretch", &expected, &found, "take fewer stretches"));
    }
    let points = py.detach(|| unit_cell::solve_with(fabric, law, &warp, &weft));
    let names = points.first().map(|point| point.numbers().map(|(name, _)| name).to_vec()).unwrap_or_default();
    let column = |at: usize| points.iter().map(move |point| point.numbers()[at].1);
    let numbers: Vec<f64> = (0..names.len()).flat_map(column).collect();
    Ok((names, bytes(py, &numbers)))
}

/// Limit from a table of shots, which is called `name`: `fit.json` and its page.
#[pyfunction]
pub(crate) fn fit(
    data: PathBuf,
    name: &str,
    unit: Option<&str>,
    columns: Vec<(String, String)>,
    spread: Option<f64>,
    level: f64,
) -> PyResult<(String, String)> {
    let unit = unit.map(|unit| named::<VelocityUnit>("unit", unit)).transpose()?;
    let kind = |(kind, heading): (String, String)| Ok((named::<ColumnKind>("columns", &kind)?, heading));
    let columns = columns.into_iter().map(kind).collect::<PyResult<Vec<_>>>()?;
    let data = fits::read(&data, unit, &columns).map_err(refused)?;
    let found = fits::fit(&data, level, spread);
    Ok((found.json().to_string(), found.report(name).html(&format!("Ballistic limit: {name}"), "fit.json")))
}

/// A choice by its name on the command line.
fn named<T: ValueEnum>(place: &str, name: &str) -> PyResult<T> {
    T::from_str(name, true).map_err(|_| {
        let known = T::value_variants().iter().filter_map(ValueEnum::to_possible_value);
        let known: Vec<String> = known.map(|value| value.get_name().to_owned()).collect();
        wrong(place, &known.join(", "), &format!("{name:?}"), "leave it out")
    })
}
