//! Choice of backend, as the command line makes it. A device is opened once.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use ripstop::gpu::{self, Device};
use ripstop::run::{Options, Precision};
use serde::Deserialize;

use crate::{no_device, wrong};

/// Devices by whether the processor may take over and by name; `None`: the processor does.
type Devices = HashMap<(bool, Option<String>), Option<Arc<Device>>>;

static DEVICES: Mutex<Option<Devices>> = Mutex::new(None);

/// Backend that is asked for: `auto`, `cpu` or `gpu`, `f32` or `f64`.
#[derive(Deserialize)]
pub(crate) struct Wanted {
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

impl Wanted {
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
