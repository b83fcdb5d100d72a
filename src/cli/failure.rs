//! Exit codes, and the message that comes with each.

use std::fmt::Display;
use std::process::ExitCode;

use ripstop::case::CaseError;
use ripstop::gpu::DeviceError;
use ripstop::run::RunError;

use super::terminal;

/// A check failed or the run became unstable.
pub(crate) const FAILED: u8 = 1;
/// Bad input or usage, or results that cannot be written.
pub(crate) const INPUT: u8 = 2;
/// No device for what was asked, or one that was lost on the way.
pub(crate) const LOST: u8 = 3;
/// Stopped by the user.
pub(crate) const INTERRUPTED: u8 = 130;

/// Reason why a command ends with another code than 0.
#[derive(Clone, Debug)]
pub(crate) struct CommandFailure {
    code: u8,
    message: String,
}

impl CommandFailure {
    /// Failure with an exit code.
    pub(crate) fn new(code: u8, message: impl Into<String>) -> Self {
        Self { code, message: message.into() }
    }

    /// Exit code 2, with the place, what may stand there and what stands there.
    pub(crate) fn expected(place: impl Display, expected: impl Display, found: impl Display) -> Self {
        Self::new(INPUT, format!("error: {place}\n  expected: {expected}\n  found: {found}"))
    }

    /// This failure, with advice.
    pub(crate) fn help(mut self, help: impl Display) -> Self {
        self.message += &format!("\n  help: {help}");
        self
    }

    /// Both, with the code of the first.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { message: format!("{}\n{}", self.message, other.message), ..self }
    }

    /// Prints the message and gives the exit code.
    pub(crate) fn report(self) -> ExitCode {
        terminal::complain(&self.message);
        ExitCode::from(self.code)
    }

    /// Failure of a run that did not start.
    pub(crate) fn start(file: &str, error: &RunError) -> Self {
        match error {
            RunError::Model(error) | RunError::Checkpoint(error) => error.clone().in_file(file).into(),
            RunError::Device(error) => Self::device(error),
            other => Self::new(INPUT, format!("error: {other}")),
        }
    }

    /// Exit code 3: no device, or one that cannot hold the case or was lost.
    pub(crate) fn device(error: &DeviceError) -> Self {
        let known = match error {
            DeviceError::NoSuchAdapter { found, .. } => format!("; there are: {}", found.join(", ")),
            _ => String::new(),
        };
        let expected = "a graphics adapter with Vulkan, Metal or DirectX 12 that can compute this";
        let failure = Self::expected("--backend gpu", expected, format!("{error}{known}"));
        let help = "take --backend cpu; `ripstop info CASE` lists adapters, and the memory that a case needs";
        Self { code: LOST, ..failure.help(help) }
    }
}

impl From<CaseError> for CommandFailure {
    fn from(error: CaseError) -> Self {
        Self::new(INPUT, error.to_string())
    }
}
