//! Exit codes, and the message that comes with each.

use std::fmt::Display;
use std::process::ExitCode;

use ripstop::case::CaseError;
use ripstop::gpu::DeviceError;
use ripstop::run::RunError;

use super::terminal;

/// Stopped by the user.
pub(crate) const INTERRUPTED: u8 = 130;

/// Reason why a command ends with another code than 0.
#[derive(Clone, Debug)]
pub(crate) struct CommandFailure {
    code: u8,
    message: String,
}

impl CommandFailure {
    /// Exit code 1: a check failed or the run became unstable.
    pub(crate) fn check(message: impl Into<String>) -> Self {
        Self { code: 1, message: message.into() }
    }

    /// Exit code 2: bad input or usage, or results that cannot be written.
    pub(crate) fn input(message: impl Into<String>) -> Self {
        Self { code: 2, message: message.into() }
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

    /// Exit code 3: no device for what was asked, or one that was lost on the way.
    pub(crate) fn lost(message: impl Into<String>) -> Self {
        Self { code: 3, message: message.into() }
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
        terminal::complain(&self.message);
        ExitCode::from(self.code)
    }

    /// Failure of a run that did not start.
    pub(crate) fn start(file: &str, error: &RunError) -> Self {
        match error {
            RunError::Model(error) | RunError::Checkpoint(error) => error.clone().in_file(file).into(),
            RunError::Device(error) => Self::device(error),
            other => Self::input(format!("error: {other}")),
        }
    }

    /// Exit code 3: no device, or one that cannot hold the case or was lost.
    pub(crate) fn device(error: &DeviceError) -> Self {
        Self { code: 3, ..error.refusal().into() }
    }
}

impl From<CaseError> for CommandFailure {
    fn from(error: CaseError) -> Self {
        Self::input(error.to_string())
    }
}
