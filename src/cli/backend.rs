//! What computes: the choice between processor and graphics processor, and why.

use ripstop::gpu::{self, Adapter, Device, DeviceError};
use ripstop::run::checkpoint;
use ripstop::run::{self, Precision};
use tracing::info;

use super::arguments::{BackendArguments, BackendChoice};
use super::failure::CommandFailure;

/// What was chosen.
pub(crate) struct Chosen {
    /// The graphics processor; none for the processor.
    pub(crate) device: Option<Device>,
    /// Number type: f32 on a device, which has no other.
    pub(crate) precision: Precision,
    /// What `auto` took and why.
    pub(crate) note: Option<String>,
}

impl Chosen {
    fn on(device: Device, note: Option<String>) -> Self {
        Self { device: Some(device), precision: Precision::F32, note }
    }

    /// To run on what was chosen, all that may be left out left out.
    pub(crate) fn options(&self, threads: Option<usize>) -> run::Options<'_> {
        run::Options::default().threads(threads).precision(self.precision).device(self.device.as_ref())
    }
}

/// What `auto` takes of these adapters: the number of one, or why none.
pub(crate) fn automatic(adapters: &[Adapter]) -> Result<&Adapter, &'static str> {
    match adapters.first() {
        Some(best) if best.is_hardware() => Ok(best),
        Some(_) => Err("only software adapters were found"),
        None => Err("no graphics adapter was found"),
    }
}

/// Opens what the arguments ask for.
pub(crate) fn choose(arguments: &BackendArguments) -> Result<Chosen, CommandFailure> {
    let chosen = open(arguments)?;
    let backend = if chosen.device.is_some() { "gpu" } else { "cpu" };
    info!(backend, adapter = chosen.device.as_ref().map(Device::name), note = chosen.note, "backend chosen");
    Ok(chosen)
}

fn open(arguments: &BackendArguments) -> Result<Chosen, CommandFailure> {
    let precision = arguments.precision.unwrap_or(Precision::F64);
    let cpu = |note: Option<String>| Ok(Chosen { device: None, precision, note });
    let asked_f64 = arguments.precision == Some(Precision::F64);
    match arguments.backend {
        BackendChoice::Cpu if arguments.adapter.is_some() => {
            Err(CommandFailure::expected("--adapter", "--backend gpu or auto", "--backend cpu"))
        }
        BackendChoice::Gpu if asked_f64 => {
            let failure = CommandFailure::expected("--precision f64", "f32, the number type of the GPU backend", "f64");
            Err(failure.help("leave it out, or take --backend cpu"))
        }
        BackendChoice::Cpu => cpu(None),
        BackendChoice::Gpu => Ok(Chosen::on(named(arguments.adapter.as_deref())?, None)),
        BackendChoice::Auto if asked_f64 => {
            cpu(Some("note: --backend auto takes the CPU: f64 was asked for".to_owned()))
        }
        BackendChoice::Auto => {
            let adapters = gpu::adapters();
            let wanted = match &arguments.adapter {
                // An adapter asked for by name is taken, whatever it is.
                Some(name) => Ok(gpu::device::choose(&adapters, Some(name)).map_err(|e| CommandFailure::device(&e))?),
                None => automatic(&adapters).cloned(),
            };
            match wanted {
                Ok(adapter) => match Device::open(&adapter) {
                    Ok(device) => {
                        let note =
                            format!("note: --backend auto takes the GPU: {} ({})", adapter.name(), adapter.kind());
                        Ok(Chosen::on(device, Some(note)))
                    }
                    Err(error) => cpu(Some(took_cpu(&error))),
                },
                Err(why) => cpu(Some(format!("note: --backend auto takes the CPU: {why}"))),
            }
        }
    }
}

/// Opens the graphics processor of a name or number, or the best.
pub(crate) fn named(wanted: Option<&str>) -> Result<Device, CommandFailure> {
    let adapter = gpu::device::choose(&gpu::adapters(), wanted);
    adapter.and_then(|adapter| Device::open(&adapter)).map_err(|error| CommandFailure::device(&error))
}

/// Opens what a run began with.
pub(crate) fn again(backend: &checkpoint::BackendId) -> Result<Chosen, CommandFailure> {
    match backend {
        checkpoint::BackendId::Cpu(precision) => Ok(Chosen { device: None, precision: *precision, note: None }),
        checkpoint::BackendId::Gpu(name) => {
            // The one of this very name, not just the first that has it as a part.
            let index = gpu::adapters().iter().position(|adapter| adapter.name() == name).map(|at| at.to_string());
            let device = named(Some(index.as_ref().unwrap_or(name)))?;
            Ok(Chosen::on(device, None))
        }
    }
}

/// What is said when `auto` takes the processor because of the device.
pub(crate) fn took_cpu(error: &DeviceError) -> String {
    format!("note: --backend auto takes the CPU: {error}")
}
