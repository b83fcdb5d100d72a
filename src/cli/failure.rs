//! Exit codes, and the one message that goes with each.

use std::fmt::Display;
use std::process::ExitCode;

use ripstop::case::CaseError;
use ripstop::gpu::DeviceError;
use ripstop::model::ModelError;
use ripstop::output::OutputError;
use ripstop::output::number::bytes;
use ripstop::run::RunError;
use ripstop::run::checkpoint::CheckpointError;

use super::screen;

/// A check failed or the run became unstable.
const CHECK: u8 = 1;
/// Bad input or usage, or results that cannot be written.
const INPUT: u8 = 2;
/// No device for what was asked.
const DEVICE: u8 = 3;
/// Stopped by the user.
pub(crate) const INTERRUPTED: u8 = 130;

/// What an exit code tells.
#[derive(Debug)]
pub(crate) struct Exit {
    pub(crate) code: u8,
    /// In a few words.
    pub(crate) name: &'static str,
    pub(crate) means: &'static str,
    /// What to do.
    pub(crate) help: &'static str,
}

/// Every exit code there is.
pub(crate) static EXITS: [Exit; 5] = [
    Exit {
        code: 0,
        name: "done",
        means: "The command did what was asked; of a run, every expectation of the case holds. Warnings do not change the code.",
        help: "Nothing. `summary.json` lists the warnings.",
    },
    Exit {
        code: CHECK,
        name: "an expectation failed or the run became unstable",
        means: "An `expect` of the case does not hold, a row of `verify` fails, or a run made numbers that cannot be: not finite, or energy that was never put in. The message \
                says which, with step, kernel and place. Results up to there are written.",
        help: "Expectation: compare what was expected with what was got. Unstable: lower /solver/courant; if that does not \
               help, something in the case is extreme, and the place in the message shows where to look.",
    },
    Exit {
        code: INPUT,
        name: "bad input or usage",
        means: "The command line, the case or one of its files cannot be used, or results cannot be written. Nothing was computed, \
                or nothing could be kept.",
        help: "Do what the `help:` line of the message says. `ripstop check CASE` shows every field, `ripstop schema` every key.",
    },
    Exit {
        code: DEVICE,
        name: "no device for what was asked, or one that failed",
        means: "No graphics adapter suits, the case does not fit its memory, or the device was lost on the way; then results up \
                to there are written.",
        help: "Take --backend cpu. `ripstop info CASE` lists adapters and what the case needs.",
    },
    Exit {
        code: INTERRUPTED,
        name: "interrupted",
        means: "Ctrl-C, or a request to terminate, ended the command. After the first one results up to there are written.",
        help: "Run it again; an interrupted result is marked `interrupted` in `summary.json`.",
    },
];

/// Why a command ends with another code than 0.
#[derive(Clone, Debug)]
pub(crate) struct CommandFailure {
    code: u8,
    message: String,
}

impl CommandFailure {
    /// What is said of it on standard error.
    pub(crate) fn message(&self) -> &str {
        &self.message
    }

    /// Exit code 1.
    pub(crate) fn check(message: impl Into<String>) -> Self {
        Self { code: CHECK, message: message.into() }
    }

    /// Exit code 2.
    pub(crate) fn input(message: impl Into<String>) -> Self {
        Self { code: INPUT, message: message.into() }
    }

    /// Exit code 2, with what may stand at a place and what stands there.
    pub(crate) fn expected(place: impl Display, expected: impl Display, found: impl Display) -> Self {
        Self::input(format!("error: {place}\n  expected: {expected}\n  found: {found}"))
    }

    /// The same, with what to do.
    pub(crate) fn help(mut self, help: impl Display) -> Self {
        self.message += &format!("\n  help: {help}");
        self
    }

    /// Exit code 3: no device, or one that cannot hold the case or was lost.
    pub(crate) fn device(error: &DeviceError) -> Self {
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
            DeviceError::TooLarge { adapter, buffer, needed, limit, total } => {
                let [needed, limit, total] = [needed, limit, total].map(|size| bytes(*size as f64));
                (
                    format!("a buffer `{buffer}` of {needed}; the case needs {total} in all"),
                    format!("{adapter}, which holds {limit} in one buffer"),
                    "take --backend cpu or a smaller pack",
                )
            }
            DeviceError::OutOfMemory { adapter, total, reason } => (
                format!("{} of device memory", bytes(*total as f64)),
                format!("{adapter}: {reason}"),
                "take --backend cpu or a smaller pack",
            ),
            // A batch that the device has no room for, and whatever fails on the way.
            _ => ("a device that stays".to_owned(), error.to_string(), "take --backend cpu"),
        };
        Self { code: DEVICE, ..Self::expected("--backend gpu", expected, found).help(help) }
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
            screen::complain(&self.message);
        }
        ExitCode::from(self.code)
    }

    /// A case that cannot become a model.
    pub(crate) fn model(file: &str, error: &ModelError) -> Self {
        in_case(file, error).into()
    }

    /// A run that did not start.
    pub(crate) fn start(file: &str, error: &RunError) -> Self {
        match error {
            RunError::Model(error) => Self::model(file, error),
            RunError::Device(error) => Self::device(error),
            RunError::Checkpoint(error) => error.clone().into(),
            RunError::Threads { .. } => Self::input(format!("error: {error}\n  help: ask for fewer with --threads N")),
            other => Self::input(format!("error: {other}")),
        }
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

/// What only geometry and equilibrium can judge, said like any other error of the case.
fn in_case(file: &str, error: &ModelError) -> CaseError {
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
