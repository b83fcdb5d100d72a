//! Choice between processor and graphics processor.

use ripstop::gpu::{self, Adapter, Device, DeviceError};
use ripstop::run::checkpoint::BackendId;
use ripstop::run::{self, Precision};
use tracing::info;

use super::arguments::{BackendArguments, BackendChoice};
use super::failure::CommandFailure;

/// The choice.
pub(crate) struct Chosen {
    /// The graphics processor; none for the processor.
    pub(crate) device: Option<Device>,
    /// Number type: f32 on a device, which has no other.
    pub(crate) precision: Precision,
    /// Choice of `auto`, and its reason.
    pub(crate) note: Option<String>,
}

impl Chosen {
    fn on(device: Device, note: Option<String>) -> Self {
        Self { device: Some(device), precision: Precision::F32, note }
    }

    /// Options of a run on it.
    pub(crate) fn options(&self, threads: Option<usize>) -> run::Options<'_> {
        run::Options::default().threads(threads).precision(self.precision).device(self.device.as_ref())
    }
}

/// Adapter that `auto` takes, or why none.
pub(crate) fn automatic(adapters: &[Adapter]) -> Result<&Adapter, &'static str> {
    match adapters.first() {
        Some(best) if best.is_hardware() => Ok(best),
        Some(_) => Err("only software adapters were found"),
        None => Err("no graphics adapter was found"),
    }
}

/// Opens the backend that the arguments ask for, else `usual`.
pub(crate) fn choose(
    arguments: &BackendArguments,
    usual: BackendChoice,
    precision: Option<Precision>,
) -> Result<Chosen, CommandFailure> {
    let choice = arguments.backend.unwrap_or(usual);
    let chosen = open(choice, arguments.adapter.as_deref(), precision)?;
    let backend = if chosen.device.is_some() { "gpu" } else { "cpu" };
    info!(backend, adapter = chosen.device.as_ref().map(Device::name), note = chosen.note, "backend chosen");
    Ok(chosen)
}

fn open(choice: BackendChoice, name: Option<&str>, asked: Option<Precision>) -> Result<Chosen, CommandFailure> {
    let cpu = |note: Option<String>| Ok(Chosen { device: None, precision: asked.unwrap_or_default(), note });
    let in_double = asked == Some(Precision::F64);
    match (choice, name) {
        (BackendChoice::Cpu, Some(_)) => {
            Err(CommandFailure::expected("--adapter", "--backend gpu or auto", "--backend cpu"))
        }
        (BackendChoice::Cpu, None) => cpu(None),
        (BackendChoice::Gpu, _) if in_double => {
            let failure = CommandFailure::expected("--precision f64", "f32, the number type of the GPU backend", "f64");
            Err(failure.help("leave it out, or take --backend cpu"))
        }
        (BackendChoice::Gpu, name) => Ok(Chosen::on(named(name)?, None)),
        (BackendChoice::Auto, _) if in_double => cpu(Some(took_cpu("f64 was asked for"))),
        (BackendChoice::Auto, name) => {
            let adapters = gpu::adapters();
            // An adapter asked for by name is taken, whatever it is.
            let by_name = name.map(|name| gpu::device::choose(&adapters, Some(name))).transpose().map_err(refused)?;
            match by_name.as_ref().map_or_else(|| automatic(&adapters), Ok) {
                Err(why) => cpu(Some(took_cpu(why))),
                Ok(adapter) => match Device::open(adapter) {
                    Err(error) => cpu(Some(took_cpu(&error.to_string()))),
                    Ok(device) => {
                        let note =
                            format!("note: --backend auto takes the GPU: {} ({})", adapter.name(), adapter.kind());
                        Ok(Chosen::on(device, Some(note)))
                    }
                },
            }
        }
    }
}

fn refused(error: DeviceError) -> CommandFailure {
    CommandFailure::device(&error)
}

/// Opens the graphics processor of a name or number, or the best.
fn named(wanted: Option<&str>) -> Result<Device, CommandFailure> {
    gpu::device::choose(&gpu::adapters(), wanted).and_then(|adapter| Device::open(&adapter)).map_err(refused)
}

/// Opens the backend that a run began with.
pub(crate) fn again(backend: &BackendId) -> Result<Chosen, CommandFailure> {
    match backend {
        BackendId::Cpu(precision) => Ok(Chosen { device: None, precision: *precision, note: None }),
        BackendId::Gpu(name) => {
            // The one of this very name, not just the first that has it as a part.
            let index = gpu::adapters().iter().position(|adapter| adapter.name() == name).map(|at| at.to_string());
            Ok(Chosen::on(named(Some(index.as_ref().unwrap_or(name)))?, None))
        }
    }
}

/// Note that `auto` takes the processor.
pub(crate) fn took_cpu(why: &str) -> String {
    format!("note: --backend auto takes the CPU: {why}")
}
