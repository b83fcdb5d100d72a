//! `ripstop`: ballistic impact of woven fabrics, from a case file to a verdict.

use std::process::ExitCode;

use clap::Parser;

/// The command line: arguments, text for people, exit codes. All physics is in the library.
mod cli {
    pub(crate) mod arguments;
    pub(crate) mod backend;
    pub(crate) mod bench;
    pub(crate) mod check;
    pub(crate) mod failure;
    pub(crate) mod new;
    pub(crate) mod result;
    pub(crate) mod run;
    pub(crate) mod studies;
    pub(crate) mod terminal;
}

use cli::arguments::{Arguments, Command};
use cli::failure::CommandFailure;

fn main() -> ExitCode {
    let done = match Arguments::parse().command {
        Command::Run(arguments) => cli::run::run(&arguments),
        Command::Resume(arguments) => cli::run::resume(&arguments),
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
