//! Arguments of the commands that compute many runs, or compare them.

use std::path::PathBuf;

use clap::{Args, builder::RangedU64ValueParser};

use super::arguments::{BackendArguments, BackendChoice};

/// `ripstop bench`
#[derive(Args, Debug)]
#[command(
    after_help = "Every case is run once as a reference (CPU, f64, Courant 0.25, bracketed unit cell, one crossover per
element), then as a user may choose to run it: precision, Courant number, mesh, unit cell, skips, GPU. The error is
that of the velocity history against the reference, over the velocity the projectile loses.

Examples:
  ripstop bench
  ripstop bench shot.json --tolerance 0.5% --repeat 3 --json | jq '.cases[].cheapest_within_tolerance'

DIR gets bench.json and bench.svg."
)]
pub(crate) struct BenchArguments {
    /// Case files [default: the paper's shot, cases/s720-1ply-155.json, built in]
    #[arg(value_name = "CASE.json")]
    pub(crate) cases: Vec<PathBuf>,
    /// Largest error of the velocity history, and of what is left or the stop time, that is good enough: 1% or 0.01
    #[arg(long, value_name = "ERROR", default_value = "1%", allow_hyphen_values = true)]
    pub(crate) tolerance: String,
    /// Change of every case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Whether the GPU is among the choices: auto takes real ones only
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) backend: BackendChoice,
    /// Graphics adapter, by part of its name or its number in `ripstop info` [default: the best]
    #[arg(long, value_name = "NAME|INDEX")]
    pub(crate) adapter: Option<String>,
    /// Worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub(crate) threads: Option<usize>,
    /// Run every choice so many times and take the shortest
    #[arg(
        long,
        value_name = "N",
        default_value = "1",
        value_parser = RangedU64ValueParser::<usize>::new().range(1..=1000)
    )]
    pub(crate) repeat: usize,
    /// Folder for the results
    #[arg(long, value_name = "DIR", default_value = "out/bench")]
    pub(crate) out: PathBuf,
    /// Print nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Print bench.json instead of the tables
    #[arg(long)]
    pub(crate) json: bool,
}

/// `ripstop verify`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop verify
  ripstop verify --backend gpu --json | jq '.rows[] | select(.pass | not)'

The cases are those of cases/verify (closed forms, an independent prototype) and cases/stress (hard scenes), built in. \
The exit code is 1 if an expectation fails.")]
pub(crate) struct VerifyArguments {
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    /// Worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub(crate) threads: Option<usize>,
    /// Print JSON instead of the table
    #[arg(long)]
    pub(crate) json: bool,
}
