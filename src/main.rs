//! `ripstop`: ballistic impact of woven fabrics, from a case file to a verdict.

use std::process::ExitCode;

use clap::Parser;

/// The command line: arguments, text for people, exit codes. All physics is in the library.
mod cli {
    pub(crate) mod arguments;
    pub(crate) mod bench;
    pub(crate) mod check;
    pub(crate) mod new;
    pub(crate) mod run;
    pub(crate) mod studies;
    pub(crate) mod terminal;
}

use cli::arguments::{Arguments, Command};
use cli::terminal::CommandFailure;

/// Starts this program again without a Wayland display where none can be found. A layer of Vulkan drivers looks for one, a library below it
/// writes to standard error that there is none, and a process cannot safely change its own environment.
#[cfg(target_os = "linux")]
fn leave_wayland_alone() {
    use std::os::unix::process::CommandExt;
    use std::{env, path::Path, process};

    let is_path = |name: &str| env::var_os(name).is_some_and(|value| Path::new(&value).is_absolute());
    if let (false, Ok(program)) = (is_path("XDG_RUNTIME_DIR") || is_path("WAYLAND_DISPLAY"), env::current_exe()) {
        // It only returns where the system refuses; then the library is heard.
        drop(process::Command::new(program).args(env::args_os().skip(1)).env("WAYLAND_DISPLAY", "/nonexistent").exec());
    }
}

fn main() -> ExitCode {
    let command = Arguments::parse().command;
    #[cfg(target_os = "linux")]
    if command.looks_for_adapters() {
        leave_wayland_alone();
    }
    let done = match command {
        Command::Run(arguments) => cli::run::run(&arguments),
        Command::Resume { folder, print } => cli::run::resume(&folder, &print),
        Command::New(arguments) => cli::new::new(&arguments),
        Command::Check(arguments) => cli::check::check(&arguments),
        Command::Crossover(arguments) => cli::check::crossover(&arguments),
        Command::Bench(arguments) => cli::bench::bench(&arguments),
        Command::Verify(arguments) => cli::bench::verify(&arguments),
        Command::Fit(arguments) => cli::studies::fit(&arguments),
        Command::Shots(arguments) => cli::studies::shots(&arguments),
        Command::V50(arguments) => cli::studies::v50(&arguments),
        Command::Sweep(arguments) => cli::studies::sweep(&arguments),
        Command::Info { case } => cli::check::info(case.as_deref()),
        Command::Schema { markdown } => cli::check::schema(markdown),
        Command::Explain { code } => cli::check::explain(code.as_deref()),
        Command::Completions { shell } => cli::check::completions(shell),
    };
    done.map_or_else(CommandFailure::report, |()| ExitCode::SUCCESS)
}
