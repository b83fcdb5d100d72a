//! Many shots of a case, a limit from a table of shots, and the unit cell. Studies leave their results in a folder.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use ripstop::case::{CaseError as Refusal, with_velocity};
use ripstop::model::unit_cell_curve::{self, CurveLaw};
use ripstop::output::Folder;
use ripstop::study::batch::{BatchError, BatchOptions, StudyProgress};
use ripstop::study::range_data::{self, ColumnKind, VelocityUnit};
use ripstop::study::shots::{self, ShotsRequest};
use ripstop::study::sweep::{self, Factor, SweepOf, SweepRequest, grid};
use ripstop::study::v50::{self, V50Request};
use serde_json::{Value, json};

use crate::backend::{self, Backend};
use crate::case::Case;
use crate::watch::watched;
use crate::{bytes, no_device, refused, wrong};

/// Points of a unit cell at most.
const MAX_POINTS: usize = 1_000_000;

/// A number of a request.
fn number<T: serde::de::DeserializeOwned>(request: &Value, name: &str) -> PyResult<T> {
    serde_json::from_value(request[name].clone())
        .map_err(|error| wrong(name, "a number of this kind", &request[name].to_string(), &error.to_string()))
}

/// A study that is asked for.
enum Study {
    Shots(ShotsRequest),
    V50(V50Request),
    Sweep(SweepRequest),
}

impl Study {
    /// The study of a request: `kind`, and the options of its command.
    fn read(case: &Case, request: &Value) -> PyResult<Self> {
        let level = number(request, "level")?;
        let shots = || {
            Ok::<_, PyErr>(ShotsRequest {
                count: number(request, "count")?,
                velocity: number(request, "velocity")?,
                level,
            })
        };
        let v50 = || {
            let [count, refined] = [number(request, "count")?, number(request, "refined")?];
            let [until_width, bracket] = [number(request, "until_width")?, number::<Option<f64>>(request, "bracket")?];
            Ok::<_, PyErr>(V50Request { count, until_width, bracket: bracket.unwrap_or_default(), refined, level })
        };
        let factors: Vec<Factor> = number::<Vec<(String, Vec<String>)>>(request, "over")?
            .into_iter()
            .map(|(pointer, values)| Factor { pointer, values })
            .collect();
        let is_v50 = request["kind"] == "v50";
        if factors.is_empty() {
            return if is_v50 { v50().map(Self::V50) } else { shots().map(Self::Shots) };
        }
        let mut points = Vec::new();
        for values in grid(&factors).map_err(refused)? {
            let set = |(factor, value): (&Factor, &String)| format!("{}={value}", factor.pointer);
            let sets: Vec<String> = factors.iter().zip(&values).map(set).collect();
            points.push((values, case.changed(&sets)?.case));
        }
        let of = if is_v50 { SweepOf::V50(v50()?) } else { SweepOf::Shots(shots()?) };
        Ok(Self::Sweep(SweepRequest { factors, level, of, points }))
    }

    /// Names of its files.
    fn files(&self) -> &'static [&'static str] {
        match self {
            Self::Shots(_) => shots::FILES,
            Self::V50(_) => v50::FILES,
            Self::Sweep(_) => sweep::FILES,
        }
    }

    /// Computes it: the reason why there is no limit, where one was sought in vain.
    fn run(
        &self,
        case: &ripstop::Case,
        options: &BatchOptions<'_>,
        folder: &Folder,
    ) -> Result<Option<String>, BatchError> {
        match self {
            Self::Shots(request) => shots::run(case, request, options, folder).map(|_| None),
            Self::V50(request) => v50::run(case, request, options, folder).map(|found| found.missing()),
            Self::Sweep(request) => sweep::run(request, options, folder, &case.title).map(|_| None),
        }
    }
}

/// Runs a study into a folder: the reason why there is no limit, the exception that ended it early, and whether it ended early.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "the arguments of the commands")]
pub(crate) fn study(
    py: Python<'_>,
    case: &Case,
    request: &str,
    out: PathBuf,
    backend: &str,
    adapter: Option<&str>,
    precision: Option<&str>,
    threads: Option<usize>,
    show: Option<Py<PyAny>>,
) -> PyResult<(Option<String>, Option<PyErr>, bool)> {
    let request: Value = serde_json::from_str(request)
        .map_err(|error| wrong("arguments", "numbers", &error.to_string(), "give finite numbers"))?;
    let (file, given) = (case.file(), case);
    let mut case = given.case.clone();
    case.title = with_velocity(&case.title, None);
    if case.projectile.is_none() {
        return Err(wrong(&file, "a projectile, to be shot", "none in the case", "add /projectile"));
    }
    let study = Study::read(given, &request)?;
    let chosen = Backend::choose(backend, adapter, precision, threads)?;
    let seed = number::<Option<u32>>(&request, "seed")?;
    let usual = case.variability.as_ref().map_or(1, |variability| variability.seed);
    let cores = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let folder = Folder::prepare_for(&out, study.files(), &[case.path.as_path()]).map_err(refused)?;
    let (done, raised) = watched(py, show, |watch| {
        let options = BatchOptions {
            seed: seed.unwrap_or(usual),
            threads: chosen.threads.unwrap_or_else(cores),
            threads_per_shot: 1,
            precision: chosen.precision,
            device: chosen.device.as_deref(),
            interrupt: &watch.interrupt,
            resume: request["resume"] == true,
            progress: &|StudyProgress { done, of, shots, limit: [low, high] }| {
                watch.progress(json!({ "done": done, "of": of, "shots": shots, "low_m_s": low, "high_m_s": high }));
            },
        };
        study.run(&case, &options, &folder)
    })?;
    match done {
        Ok(missing) => Ok((missing.map(|why| format!("error: {file}: {why}")), raised, false)),
        Err(BatchError::Interrupted) => Ok((None, raised, true)),
        Err(BatchError::Refused(error)) => Err(refused(error)),
        Err(BatchError::Device(error)) => {
            backend::forget();
            Err(no_device(&error))
        }
    }
}

/// Names of the numbers of the unit cell, and those of every pair of stretches as float64.
#[pyfunction]
pub(crate) fn crossover<'py>(
    py: Python<'py>,
    case: &Case,
    warp: Vec<f64>,
    weft: Vec<f64>,
    law: Option<&str>,
) -> PyResult<(Vec<&'static str>, Bound<'py, PyBytes>)> {
    let fabric = &case.case.fabric;
    let law = match law {
        None => fabric.crossover.law.into(),
        Some(name) => CurveLaw::from_str(name, true).map_err(|_| {
            wrong(
                "law",
                "\"published\", \"variational\" or \"kawabata\"",
                &format!("{name:?}"),
                "leave it out: the case's",
            )
        })?,
    };
    if warp.len().saturating_mul(weft.len()) > MAX_POINTS {
        let found = format!("{} × {}", warp.len(), weft.len());
        return Err(wrong("warp_stretch, weft_stretch", &format!("at most {MAX_POINTS} points"), &found, "take fewer"));
    }
    let points = py.detach(|| unit_cell_curve::solve_with(fabric, law, &warp, &weft));
    let names = points.first().map(|point| point.numbers().map(|(name, _)| name).to_vec()).unwrap_or_default();
    let numbers: Vec<f64> = points.iter().flat_map(|point| point.numbers().map(|(_, number)| number)).collect();
    Ok((names, bytes(py, &numbers)))
}

/// Limit from a table of shots: `fit.json` and its page.
#[pyfunction]
pub(crate) fn fit(
    data: PathBuf,
    name: Option<String>,
    unit: Option<&str>,
    columns: Vec<(String, String)>,
    spread: Option<f64>,
    level: f64,
) -> PyResult<(String, String)> {
    let unknown =
        |place: &str, found: &str, expected: &str| wrong(place, expected, &format!("{found:?}"), "leave it out");
    let unit =
        unit.map(|unit| VelocityUnit::from_str(unit, true).map_err(|_| unknown("unit", unit, "\"m/s\" or \"ft/s\"")));
    let kind = |(kind, name): (String, String)| {
        let found = ColumnKind::from_str(&kind, true);
        let found = found.map_err(|_| unknown("columns", &kind, "velocity, perforated, count or residual"));
        found.map(|kind| (kind, name))
    };
    let columns = columns.into_iter().map(kind).collect::<PyResult<Vec<_>>>()?;
    let read =
        |data: &Path| range_data::read(data, unit.transpose()?, &columns).map_err(|error: Refusal| refused(error));
    let found = ripstop::study::fit::fit(&read(&data)?, level, spread);
    let title = name.unwrap_or_else(|| data.display().to_string());
    Ok((found.json().to_string(), found.report(&title).html(&format!("Ballistic limit: {title}"), "fit.json")))
}
