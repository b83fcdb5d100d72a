//! `ripstop._ripstop`: the library behind the Python package. Cases, tables and results cross as JSON text or as bytes of numbers;
//! `python/ripstop` makes them pleasant.
//!
//! Work runs on a thread of its own without the interpreter's lock, while the caller's thread looks for Ctrl-C and shows progress.

mod run;
mod study;

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use pyo3::create_exception;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use ripstop::gpu::{self, Device};
use ripstop::run::{Options, Precision, RunError as StartError};
use serde::Deserialize;
use serde_json::Value;

/// Time between two looks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(100);

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
pub(crate) fn arguments<'a, T: Deserialize<'a>>(text: &'a str) -> PyResult<T> {
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

/// Devices by whether the processor may take over and by name; `None`: the processor does.
type Devices = HashMap<(bool, Option<String>), Option<Arc<Device>>>;

static DEVICES: Mutex<Option<Devices>> = Mutex::new(None);

/// Backend that is asked for: `auto`, `cpu` or `gpu`, `f32` or `f64`.
#[derive(Deserialize)]
pub(crate) struct WantedBackend {
    backend: String,
    adapter: Option<String>,
    precision: Option<String>,
    threads: Option<usize>,
}

/// Backend, number type and threads of a run.
pub(crate) struct Backend {
    pub(crate) device: Option<Arc<Device>>,
    pub(crate) precision: Precision,
    pub(crate) threads: Option<usize>,
    /// Whether the processor may take over.
    pub(crate) auto: bool,
}

impl WantedBackend {
    pub(crate) fn open(&self) -> PyResult<Backend> {
        let (auto, in_double) = (self.backend == "auto", self.precision.as_deref() == Some("f64"));
        let device = match self.backend.as_str() {
            "cpu" if self.adapter.is_some() => {
                return Err(wrong("--adapter", "--backend gpu or auto", "--backend cpu", "leave one out"));
            }
            "gpu" if in_double => {
                let help = "leave it out, or take --backend cpu";
                return Err(wrong("--precision f64", "f32, the number type of the GPU backend", "f64", help));
            }
            "gpu" | "auto" if !in_double => opened(auto, self.adapter.as_deref())?,
            _ => None,
        };
        let in_single = device.is_some() || self.precision.as_deref() == Some("f32");
        let precision = if in_single { Precision::F32 } else { Precision::F64 };
        Ok(Backend { device, precision, threads: self.threads, auto })
    }
}

impl Backend {
    /// Options of a run on it.
    pub(crate) fn options(&self) -> Options<'_> {
        Options::default().threads(self.threads).precision(self.precision).device(self.device.as_deref())
    }
}

/// Forgets the devices: one was lost.
pub(crate) fn forget_devices() {
    *DEVICES.lock().unwrap_or_else(PoisonError::into_inner) = None;
}

/// The device of a name or number, or the best; `auto` takes a real one alone, unless it is named.
fn opened(auto: bool, name: Option<&str>) -> PyResult<Option<Arc<Device>>> {
    let mut devices = DEVICES.lock().unwrap_or_else(PoisonError::into_inner);
    let known = devices.get_or_insert_default();
    let key = (auto, name.map(str::to_owned));
    if let Some(found) = known.get(&key) {
        return Ok(found.clone());
    }
    let adapters = gpu::adapters();
    let adapter = match name {
        None if auto => Ok(gpu::device::automatic(&adapters).ok().cloned()),
        _ => gpu::device::choose(&adapters, name).map(Some),
    };
    let found = adapter.and_then(|adapter| match adapter.map(|adapter| Device::open(&adapter)).transpose() {
        Err(_) if auto => Ok(None),
        opened => opened.map(|device| device.map(Arc::new)),
    });
    let found = found.map_err(|error| no_device(&error))?;
    known.insert(key, found.clone());
    Ok(found)
}

/// Progress and interrupt of work under way.
#[derive(Default)]
pub(crate) struct Watch {
    latest: Mutex<Option<Value>>,
    /// Raised: the work ends as soon as it can.
    pub(crate) interrupt: AtomicBool,
}

impl Watch {
    /// Takes note of progress, an object of numbers.
    pub(crate) fn progress(&self, at: Value) {
        *self.latest.lock().unwrap_or_else(PoisonError::into_inner) = Some(at);
    }

    fn look(&self, py: Python<'_>, show: Option<&Py<PyAny>>) -> PyResult<()> {
        py.check_signals()?;
        let latest = self.latest.lock().unwrap_or_else(PoisonError::into_inner).take();
        let (Some(show), Some(Value::Object(numbers))) = (show, latest) else { return Ok(()) };
        let at = PyDict::new(py);
        numbers.iter().try_for_each(|(name, number)| at.set_item(name, number.as_f64()))?;
        show.call1(py, (at,)).map(drop)
    }
}

/// Result of the work, and the exception that a signal or `show` raised meanwhile, which ended it early.
///
/// # Errors
/// When the work panics.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    show: Option<Py<PyAny>>,
    work: impl FnOnce(&Watch) -> T + Send,
) -> PyResult<(T, Option<PyErr>)> {
    let (done, raised) = py.detach(|| {
        let watch = Watch::default();
        let (ended, wait) = channel::<()>();
        thread::scope(|scope| {
            let worker = scope.spawn(|| {
                let _ended = ended; // dropped with the end of the work, by a panic too
                work(&watch)
            });
            let mut raised = None;
            while wait.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                if raised.is_none() {
                    raised = Python::attach(|py| watch.look(py, show.as_ref())).err();
                }
                if raised.is_some() {
                    watch.interrupt.store(true, Ordering::Relaxed);
                }
            }
            (worker.join(), raised)
        })
    });
    let done = done
        .map_err(|_| RunError::new_err("error: a defect in ripstop ended the work; its words are on standard error"));
    Ok((done?, raised))
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
    module.add_class::<run::Case>()?;
    module.add_class::<run::Run>()?;
    module.add_function(wrap_pyfunction!(run::schema, module)?)?;
    module.add_function(wrap_pyfunction!(run::run, module)?)?;
    module.add_function(wrap_pyfunction!(study::study, module)?)?;
    module.add_function(wrap_pyfunction!(study::crossover, module)?)?;
    module.add_function(wrap_pyfunction!(study::fit, module)?)
}
