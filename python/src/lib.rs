//! `ripstop._ripstop`: the library behind the Python package. Cases, tables and results cross as JSON text or as bytes of numbers;
//! `python/ripstop` makes them pleasant.

mod backend;
mod case;
mod run;
mod study;
mod watch;

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use ripstop::run::RunError as StartError;

create_exception!(
    ripstop,
    CaseError,
    PyValueError,
    "Refusal of a case, of an argument, or of a file or folder: where, expected, found, help; `result` of one that comes after a run."
);
create_exception!(
    ripstop,
    RunError,
    PyRuntimeError,
    "A run or study without a result; `result` holds what there is of it, or None."
);
create_exception!(
    ripstop,
    DeviceError,
    RunError,
    "No graphics device for what was asked, or one that was lost on the way."
);

/// Refusal of a case or of a file.
pub(crate) fn refused(error: ripstop::CaseError) -> PyErr {
    CaseError::new_err(error.to_string())
}

/// Refusal of an argument.
pub(crate) fn wrong(place: &str, expected: &str, found: &str, help: &str) -> PyErr {
    refused(ripstop::CaseError::new(place, "", expected, found, help))
}

/// Arguments out of JSON, whose values Python has checked.
pub(crate) fn arguments<'a, T: serde::Deserialize<'a>>(text: &'a str) -> PyResult<T> {
    serde_json::from_str(text).map_err(|error| {
        wrong("arguments", "values of the kinds that they have", &error.to_string(), "look at their types")
    })
}

/// Failure of a device, in the words of the command line.
pub(crate) fn no_device(error: &ripstop::DeviceError) -> PyErr {
    DeviceError::new_err(error.refusal().to_string())
}

/// Failure of a run that did not start.
pub(crate) fn not_started(file: &str, error: StartError) -> PyErr {
    match error {
        StartError::Model(error) | StartError::Checkpoint(error) => refused(error.in_file(file)),
        StartError::Device(error) => no_device(&error),
        other => RunError::new_err(format!("error: {other}")),
    }
}

/// Numbers as bytes, for `numpy.frombuffer`.
pub(crate) fn bytes<'py, T: bytemuck::NoUninit>(py: Python<'py>, numbers: &[T]) -> Bound<'py, PyBytes> {
    PyBytes::new(py, bytemuck::cast_slice(numbers))
}

#[pymodule]
fn _ripstop(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    let errors = [("CaseError", py.get_type::<CaseError>()), ("RunError", py.get_type::<RunError>())];
    for (name, error) in errors {
        error.setattr("result", py.None())?;
        module.add(name, error)?;
    }
    module.add("DeviceError", py.get_type::<DeviceError>())?;
    module.add_class::<case::Case>()?;
    module.add_class::<run::Run>()?;
    module.add_function(wrap_pyfunction!(case::schema, module)?)?;
    module.add_function(wrap_pyfunction!(run::run, module)?)?;
    module.add_function(wrap_pyfunction!(study::study, module)?)?;
    module.add_function(wrap_pyfunction!(study::crossover, module)?)?;
    module.add_function(wrap_pyfunction!(study::fit, module)?)
}
