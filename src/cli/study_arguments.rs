//! Arguments of the commands that compute many runs, or compare them.

use std::path::PathBuf;

use clap::{Args, builder::RangedU64ValueParser};
use ripstop::num::link::Link;
use ripstop::study::interval::Interval;

use super::arguments::{BackendArguments, BackendChoice};
use super::choice::{INTERVALS, LINKS, one_of};
use super::range::level;

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

/// `ripstop fit`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop fit shots.csv
  ripstop fit shots.csv --link logit --level 95% -o out/limit
  ripstop fit range.csv --computed out/limit/v50.json -o out/beside    # measured beside computed
  ripstop fit shots.csv --json | jq '.quantiles[] | select(.p == 0.5)'

DATA.csv has a heading and the columns velocity_m_s and perforated (1 where the projectile passed, 0 where it was \
stopped), and if wanted count (shots that were alike) and residual_velocity_m_s. Other columns are left alone.

Without a stop that was faster than a perforation the likelihood has no maximum: the estimate is then the one with Firth's \
penalty, and says so. DIR gets fit.json, fit.svg and fit.html.")]
pub(crate) struct FitArguments {
    /// CSV of shots
    #[arg(value_name = "DATA.csv")]
    pub(crate) data: PathBuf,
    /// Distribution of the thresholds
    #[arg(long, value_parser = one_of(LINKS), default_value = "probit")]
    pub(crate) link: Link,
    /// Two-sided confidence of the intervals, such as 0.9 or 95%
    #[arg(long, value_name = "LEVEL", value_parser = level, default_value = "0.9", allow_hyphen_values = true)]
    pub(crate) level: f64,
    /// How intervals are made
    #[arg(long, value_parser = one_of(INTERVALS), default_value = "likelihood")]
    pub(crate) interval: Interval,
    /// v50.json of a `ripstop v50`, to lay over the shots
    #[arg(long, value_name = "V50.json")]
    pub(crate) computed: Option<PathBuf>,
    /// Folder for fit.json, fit.svg and fit.html [default: none is written]
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}
