//! `ripstop completions`: what a shell needs to complete commands, options and their values.

use clap::CommandFactory;

use super::arguments::{Arguments, CompletionsArguments};
use super::failure::CommandFailure;
use super::screen;

/// Prints the script.
pub(crate) fn completions(arguments: &CompletionsArguments) -> Result<(), CommandFailure> {
    let mut script = Vec::new();
    let mut command = Arguments::command();
    let name = command.get_name().to_owned();
    clap_complete::generate(arguments.shell, &mut command, name, &mut script);
    screen::print(&String::from_utf8_lossy(&script))
}
