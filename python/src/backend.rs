//! Choice of backend, as the command line makes it. A device is opened once.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use ripstop::gpu::{self, Device};
use ripstop::run::{Options, Precision};

use crate::{no_device, wrong};

/// Devices so far by what was asked for: `auto` and a name; `None`: no real one.
static DEVICES: Mutex<Option<HashMap<(bool, Option<String>), Option<Arc<Device>>>>> = Mutex::new(None);

/// Threads of a run at most.
const MAX_THREADS: usize = 1024;

/// Backend, number type and threads of a run.
pub(crate) struct Backend {
    pub(crate) device: Option<Arc<Device>>,
    pub(crate) precision: Precision,
    pub(crate) threads: Option<usize>,
    /// Whether the processor may take over.
    pub(crate) auto: bool,
}

impl Backend {
    /// The backend of these arguments.
    pub(crate) fn choose(
        backend: &str,
        adapter: Option<&str>,
        precision: Option<&str>,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let asked = match precision {
            None => None,
            Some("f64") => Some(Precision::F64),
            Some("f32") => Some(Precision::F32),
            Some(other) => return Err(wrong("precision", "\"f64\" or \"f32\"", &format!("{other:?}"), "leave it out")),
        };
        if let Some(threads) = threads.filter(|threads| !(1..=MAX_THREADS).contains(threads)) {
            return Err(wrong("threads", "1 to 1024", &threads.to_string(), "leave it out for all cores"));
        }
        let in_double = asked == Some(Precision::F64);
        let device = match (backend, adapter) {
            ("cpu", Some(_)) => {
                return Err(wrong("--adapter", "--backend gpu or auto", "--backend cpu", "leave one out"));
            }
            ("gpu", _) if in_double => {
                let help = "leave it out, or take --backend cpu";
                return Err(wrong("--precision f64", "f32, the number type of the GPU backend", "f64", help));
            }
            ("cpu", _) => None,
            ("auto", _) if in_double => None,
            ("auto" | "gpu", name) => opened(backend == "auto", name)?,
            (other, _) => {
                return Err(wrong("backend", "\"auto\", \"cpu\" or \"gpu\"", &format!("{other:?}"), "leave it out"));
            }
        };
        let precision = if device.is_some() { Precision::F32 } else { asked.unwrap_or_default() };
        Ok(Self { device, precision, threads, auto: backend == "auto" })
    }

    /// Options of a run on it.
    pub(crate) fn options(&self) -> Options<'_> {
        Options::default().threads(self.threads).precision(self.precision).device(self.device.as_deref())
    }
}

/// Forgets devices: one was lost.
pub(crate) fn forget() {
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
    let chosen = gpu::device::choose(&gpu::adapters(), name);
    let found = match chosen {
        Ok(adapter) if auto && name.is_none() && !adapter.is_hardware() => None,
        Ok(adapter) => match Device::open(&adapter) {
            Err(_) if auto => None,
            opened => Some(Arc::new(opened.map_err(|error| no_device(&error))?)),
        },
        Err(_) if auto && name.is_none() => None,
        Err(error) => return Err(no_device(&error)),
    };
    known.insert(key, found.clone());
    Ok(found)
}
