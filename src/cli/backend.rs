//! Choice between processor and graphics processor.

use ripstop::gpu::device::automatic;
use ripstop::gpu::{self, Device, DeviceError};
use ripstop::run::checkpoint::BackendId;
use ripstop::run::{self, Precision};

use super::arguments::{BackendArguments, BackendChoice, PrintArguments};
use super::failure::CommandFailure;
use super::terminal;

/// The choice.
pub(crate) struct Chosen {
    /// The graphics processor; none for the processor.
    pub(crate) device: Option<Device>,
    /// Number type: f32 on a device, which has no other.
    pub(crate) precision: Precision,
}

impl Chosen {
    fn on(device: Device) -> Self {
        Self { device: Some(device), precision: Precision::F32 }
    }

    /// Options of a run on it.
    pub(crate) fn options(&self, threads: Option<usize>) -> run::Options<'_> {
        run::Options::default().threads(threads).precision(self.precision).device(self.device.as_ref())
    }
}

/// Opens the backend that the arguments ask for, else `usual`, and says what `auto` took.
pub(crate) fn choose(
    arguments: &BackendArguments,
    usual: BackendChoice,
    asked: Option<Precision>,
    print: &PrintArguments,
) -> Result<Chosen, CommandFailure> {
    let cpu = || Ok(Chosen { device: None, precision: asked.unwrap_or_default() });
    let cpu_because = |why: &str| {
        took_cpu(print, why);
        cpu()
    };
    let in_double = asked == Some(Precision::F64);
    match (arguments.backend.unwrap_or(usual), arguments.adapter.as_deref()) {
        (BackendChoice::Cpu, Some(_)) => {
            Err(CommandFailure::expected("--adapter", "--backend gpu or auto", "--backend cpu"))
        }
        (BackendChoice::Cpu, None) => cpu(),
        (BackendChoice::Gpu, _) if in_double => {
            let failure = CommandFailure::expected("--precision f64", "f32, the number type of the GPU backend", "f64");
            Err(failure.help("leave it out, or take --backend cpu"))
        }
        (BackendChoice::Gpu, name) => Ok(Chosen::on(named(name)?)),
        (BackendChoice::Auto, _) if in_double => cpu_because("f64 was asked for"),
        (BackendChoice::Auto, name) => {
            let adapters = gpu::adapters();
            // An adapter asked for by name is taken, whatever it is.
            let by_name = name.map(|name| gpu::device::choose(&adapters, Some(name))).transpose().map_err(refused)?;
            match by_name.as_ref().map_or_else(|| automatic(&adapters), Ok) {
                Err(why) => cpu_because(why),
                Ok(adapter) => match Device::open(adapter) {
                    Err(error) => cpu_because(&error.to_string()),
                    Ok(device) => {
                        let what = format!("{} ({})", adapter.name(), adapter.kind());
                        terminal::say(print, &format!("note: --backend auto takes the GPU: {what}"));
                        Ok(Chosen::on(device))
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
        BackendId::Cpu(precision) => Ok(Chosen { device: None, precision: *precision }),
        BackendId::Gpu(name) => {
            // The one of this very name, not just the first that has it as a part.
            let index = gpu::adapters().iter().position(|adapter| adapter.name() == name).map(|at| at.to_string());
            Ok(Chosen::on(named(Some(index.as_ref().unwrap_or(name)))?))
        }
    }
}

/// Says that `auto` takes the processor.
pub(crate) fn took_cpu(print: &PrintArguments, why: &str) {
    terminal::say(print, &format!("note: --backend auto takes the CPU: {why}"));
}
