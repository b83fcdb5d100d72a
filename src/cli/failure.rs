//! Exit codes, and the message that comes with each.

use std::fmt::Display;
use std::process::ExitCode;

use ripstop::case::CaseError;
use ripstop::gpu::DeviceError;
use ripstop::model::ModelError;
use ripstop::output::OutputError;
use ripstop::output::number::bytes;
use ripstop::run::RunError;
use ripstop::run::checkpoint::CheckpointError;

use super::terminal;

/// A check failed or the run became unstable.
const CHECK: u8 = 1;
/// Bad input or usage, or results that cannot be written.
const INPUT: u8 = 2;
/// No device for what was asked.
const DEVICE: u8 = 3;
/// Stopped by the user.
pub(crate) const INTERRUPTED: u8 = 130;

/// Reason why a command ends with another code than 0.
#[derive(Clone, Debug)]
pub(crate) struct CommandFailure {
    code: u8,
    message: String,
}

impl CommandFailure {
    /// Exit code 1.
    pub(crate) fn check(message: impl Into<String>) -> Self {
        Self { code: CHECK, message: message.into() }
    }

    /// Exit code 2.
    pub(crate) fn input(message: impl Into<String>) -> Self {
        Self { code: INPUT, message: message.into() }
    }

    /// Exit code 2, with the place, what may stand there and what stands there.
    pub(crate) fn expected(place: impl Display, expected: impl Display, found: impl Display) -> Self {
        Self::input(format!("error: {place}\n  expected: {expected}\n  found: {found}"))
    }

    /// This failure, with advice.
    pub(crate) fn help(mut self, help: impl Display) -> Self {
        self.message += &format!("\n  help: {help}");
        self
    }

    /// Exit code 3: a device that was lost on the way; results up to there are written.
    pub(crate) fn lost(message: impl Into<String>) -> Self {
        Self { code: DEVICE, message: message.into() }
    }

    /// Exit code 130.
    pub(crate) fn interrupted(message: impl Into<String>) -> Self {
        Self { code: INTERRUPTED, message: message.into() }
    }

    /// Both, with the code of the first.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { message: format!("{}\n{}", self.message, other.message), ..self }
    }

    /// Prints the message and gives the exit code.
    pub(crate) fn report(self) -> ExitCode {
        if !self.message.is_empty() {
            terminal::complain(&self.message);
        }
        ExitCode::from(self.code)
    }

    /// Failure of a case that cannot become a model.
    pub(crate) fn model(file: &str, error: &ModelError) -> Self {
        case_error(file, error).into()
    }

    /// Failure of a run that did not start.
    pub(crate) fn start(file: &str, error: &RunError) -> Self {
        match error {
            RunError::Model(error) => Self::model(file, error),
            RunError::Device(error) => Self::device(error),
            RunError::Checkpoint(error) => error.clone().into(),
            RunError::Threads { .. } => Self::input(format!("error: {error}\n  help: ask for fewer with --threads N")),
            other => Self::input(format!("error: {other}")),
        }
    }

    /// Exit code 3: no device, or one that cannot hold the case or was lost.
    pub(crate) fn device(error: &DeviceError) -> Self {
        let size = |count: &u64| bytes(*count as f64);
        let smaller = "take --backend cpu or a smaller pack";
        let (expected, found, help) = match error {
            DeviceError::NoAdapter => (
                "a graphics adapter with Vulkan, Metal or DirectX 12".to_owned(),
                "none".to_owned(),
                "take --backend cpu, or install a Vulkan driver (mesa-vulkan-drivers has one in software)",
            ),
            DeviceError::NoSuchAdapter { wanted, found } => {
                (format!("an adapter called or numbered {wanted}"), found.join(", "), "`ripstop info` lists them")
            }
            DeviceError::Refused { adapter, reason } => (
                "a device with the limits every WebGPU implementation grants".to_owned(),
                format!("{adapter}: {reason}"),
                "take --backend cpu or another --adapter",
            ),
            DeviceError::TooLarge { adapter, buffer, needed, limit, total } => (
                format!("a buffer `{buffer}` of {}; the case needs {} in all", size(needed), size(total)),
                format!("{adapter}, which holds {} in one buffer", size(limit)),
                smaller,
            ),
            DeviceError::OutOfMemory { adapter, total, reason } => {
                (format!("{} of device memory", size(total)), format!("{adapter}: {reason}"), smaller)
            }
            // A batch that the device has no room for, and failures on the way.
            _ => ("a device that stays".to_owned(), error.to_string(), "take --backend cpu"),
        };
        Self { code: DEVICE, ..Self::expected("--backend gpu", expected, found).help(help) }
    }
}

impl From<CaseError> for CommandFailure {
    fn from(error: CaseError) -> Self {
        Self::input(error.to_string())
    }
}

impl From<CheckpointError> for CommandFailure {
    fn from(error: CheckpointError) -> Self {
        Self::input(error.to_string())
    }
}

impl From<OutputError> for CommandFailure {
    fn from(error: OutputError) -> Self {
        Self::input(error.to_string())
    }
}

/// Refusal that only geometry and equilibrium can decide, in the words of any other error of the case.
fn case_error(file: &str, error: &ModelError) -> CaseError {
    let (location, expected, found, help): (&str, String, String, &str) = match error {
        ModelError::EdgeRadius => (
            "/projectile/edge_radius_mm",
            "a rounding that fits into the shape".to_owned(),
            "one that does not".to_owned(),
            "lower it, at most to half the diameter and half the length",
        ),
        ModelError::Pretension { yarn, asked } => (
            "/pack/pretension",
            format!("a force along {yarn} that a stretch between 0.5 and 1.5 gives"),
            format!("{asked} N/m"),
            "lower it",
        ),
        ModelError::PretensionBreaks { yarn, strain, limit } => (
            "/pack/pretension",
            format!("a force that keeps the {yarn} below its failure strain, {limit}"),
            format!("one that strains it to {strain:.4}"),
            "lower it",
        ),
        ModelError::TurnedRoller { degrees } => (
            "/pack/layup",
            "roller edges on plies laid at multiples of 90° only".to_owned(),
            format!("rollers on a ply at {degrees:.6}°"),
            "clamp or free the edges of plies laid at other angles",
        ),
        ModelError::InitialPenetration { depth_mm } => (
            "/projectile",
            "a projectile that starts outside the fabric".to_owned(),
            format!("one {depth_mm:.6} mm inside it"),
            "raise /projectile/standoff_mm or lower /pack/initial_deflection",
        ),
        other => ("", "a case that can become a model".to_owned(), other.to_string(), "change the case"),
    };
    CaseError::new(file, location, expected, found, help)
}
