//! A case, with the changes that it was made with.

use std::path::PathBuf;

use pyo3::prelude::*;
use ripstop::case::{self as cases, Case as Nominal};
use ripstop::output::{self, warnings};
use ripstop::run::{Simulation, Skips};

use crate::refused;

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
