//! The command line: its commands, and arguments that several of them have.

use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum};
use ripstop::run::Precision;

use super::bench::BenchArguments;
use super::campaign_arguments::{FitArguments, ShotsArguments, SweepArguments, V50Arguments};
use super::check::{CheckArguments, CompletionsArguments, InfoArguments, SchemaArguments};
use super::crossover::CrossoverArguments;
use super::explain::ExplainArguments;
use super::input::{PRECISIONS, one_of};
use super::new::NewArguments;
use super::resume::ResumeArguments;
use super::run::RunArguments;

use super::verify::VerifyArguments;

/// The whole command line.
#[derive(Debug, Parser)]
#[command(
    name = "ripstop",
    version,
    about = "Explicit finite elements for the ballistic impact of woven fabrics",
    after_help = "Exit codes: 0 done, 1 an expectation failed or the run became unstable, 2 bad input or usage, \
                  3 no device for what was asked, 130 interrupted. `ripstop explain` says more."
)]
pub(crate) struct Arguments {
    /// Command
    #[command(subcommand)]
    pub(crate) command: Command,
    /// Say on standard error what is done; -vv says more. RIPSTOP_LOG takes filters, such as ripstop::run::record=debug
    #[arg(long, short, global = true, action = ArgAction::Count)]
    pub(crate) verbose: u8,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a case: verdict, energies, files
    Run(RunArguments),
    /// Write a case to start from: fabric, plies, projectile, velocity
    New(NewArguments),
    /// Check cases without running them: every field with its value and source, time step, memory
    Check(CheckArguments),
    /// Go on with a run from its last checkpoint, to the same results as if it had never stopped
    Resume(ResumeArguments),
    /// Solve the unit cell over a grid of stretches
    Crossover(CrossoverArguments),
    /// Run time against error of what a user can choose: precision, time step, mesh, unit cell, GPU
    Bench(BenchArguments),
    /// Run the shipped cases and check what they state: closed forms, conservation, hard scenes
    Verify(VerifyArguments),
    /// Shots that perforated or were stopped: V50, scatter, intervals
    Fit(FitArguments),
    /// Many shots of a case: one table, one page
    Shots(ShotsArguments),
    /// Velocity at which half of all shots perforate, with its interval, from a case
    V50(V50Arguments),
    /// Shots or a V50 at every point of a grid over any keys of a case
    Sweep(SweepArguments),
    /// Processor, adapters and memory of this machine, and the choice of `--backend auto`
    Info(InfoArguments),
    /// JSON Schema of the case file
    Schema(SchemaArguments),
    /// Meaning of an exit code or a warning, and what to do
    Explain(ExplainArguments),
    /// Completion script for a shell
    Completions(CompletionsArguments),
}

/// Backend and number type.
#[derive(Args, Debug)]
pub(crate) struct BackendArguments {
    /// Backend that computes
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) backend: BackendChoice,
    /// Graphics adapter, by part of its name or its number in `ripstop info` [default: the best]
    #[arg(long, value_name = "NAME|INDEX")]
    pub(crate) adapter: Option<String>,
    /// Number type of the state [default: f64 on the CPU, f32 on a GPU, which has no other]
    #[arg(long, value_parser = one_of(PRECISIONS))]
    pub(crate) precision: Option<Precision>,
}

/// Choice of backend.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BackendChoice {
    /// A real GPU if there is one, else the CPU
    Auto,
    /// All cores of the processor
    Cpu,
    /// A graphics processor, software that acts as one included
    Gpu,
}
