//! Arguments of the commands for many shots and the limit they give.

use std::path::PathBuf;

use clap::{Args, ValueEnum, builder::RangedU64ValueParser};
use ripstop::num::link::Link;
use ripstop::run::Precision;

use super::arguments::{BackendArguments, BackendChoice};
use super::input::{LINKS, PRECISIONS, Velocities, level, one_of, percent};

/// Confidence, and form of what is printed.
#[derive(Args, Debug)]
pub(crate) struct PrintArguments {
    /// Two-sided confidence of the intervals, such as 0.9 or 95%
    #[arg(long, value_name = "LEVEL", value_parser = level, default_value = "0.9", allow_hyphen_values = true)]
    pub(crate) level: f64,
    /// Print nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments that all commands for many shots have.
#[derive(Args, Debug)]
pub(crate) struct BatchArguments {
    /// Case file; - is standard input
    #[arg(value_name = "CASE.json")]
    pub(crate) case: PathBuf,
    /// Change of the case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Number that all draws come from [default: /variability/seed of the case]
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u32>,
    /// Shots at a time, a thread each [default: all cores]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub(crate) threads: Option<usize>,
    /// Backend; a GPU computes many shots at a time
    #[arg(long, value_enum, default_value = "cpu")]
    pub(crate) backend: BackendChoice,
    /// Graphics adapter, by part of its name or its number in `ripstop info` [default: the best]
    #[arg(long, value_name = "NAME|INDEX")]
    pub(crate) adapter: Option<String>,
    /// Number type [default: f64; f32 on a GPU, which has no other]
    #[arg(long, value_parser = one_of(PRECISIONS))]
    pub(crate) precision: Option<Precision>,
    /// Stop once half the interval of V50 is at most this part of V50
    #[arg(long, value_name = "PERCENT", value_parser = percent, allow_hyphen_values = true)]
    pub(crate) until_width: Option<f64>,
    /// Folder for the results [default: out/<case name>-<command>]
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Go on with what lies in the folder; the results are the same, byte for byte
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) print: PrintArguments,
}

impl BatchArguments {
    /// Backend with adapter and precision.
    pub(crate) fn backend(&self) -> BackendArguments {
        BackendArguments { backend: self.backend, adapter: self.adapter.clone(), precision: self.precision }
    }
}

/// `ripstop shots`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop shots cases/s720-1ply-155.json --count 40 --velocity 150..220
  ripstop shots shot.json --count 1000 --velocity 150..250 --until-width 2% -o out/limit
  ripstop shots shot.json --count 1000 --velocity 150..250 -o out/limit --resume     # after Ctrl-C, kill or a full disk
  ripstop shots shot.json --velocity 150..250 -o out/limit --only 17                 # shot 17 alone, with its report

What varies from shot to shot stands in /variability of the case; without it only the velocity does. A shot is a function of \
case, seed and number: it does not depend on the others.

DIR gets shots.csv (a row for each shot, appended as shots end; `ripstop fit` reads it), shots.json (the fit), shots.html and \
plan.json.")]
pub(crate) struct ShotsArguments {
    /// Shots
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000), required_unless_present = "only")]
    pub(crate) count: Option<u32>,
    /// Velocities spread evenly over a range [m/s] [default: that of the case]
    #[arg(long, value_name = "A..B")]
    pub(crate) velocity: Option<Velocities>,
    /// Run this shot alone, with everything that `ripstop run` writes, in DIR/shot-N
    #[arg(long, value_name = "N")]
    pub(crate) only: Option<u32>,
    #[command(flatten)]
    pub(crate) batch: BatchArguments,
}

/// Number of realisations, and width of their brackets.
#[derive(Args, Debug)]
pub(crate) struct ThresholdArguments {
    /// Realisations of a V50 at most [default: 64]; of a sweep of shots, shots at each point [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) count: Option<u32>,
    /// Width of the bracket of a threshold
    #[arg(long, value_name = "PERCENT", value_parser = percent, default_value = "0.5%", allow_hyphen_values = true)]
    pub(crate) bracket: f64,
}

/// `ripstop v50`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop v50 cases/s720-1ply-155.json
  ripstop v50 cases/s720-1ply-scatter.json --until-width 3% -o out/limit
  ripstop v50 shot.json --backend gpu               # the next shot of each realisation in one batch
  ripstop v50 shot.json --json | jq .v50_m_s

Every realisation of the case (same fabric, same hit) is shot at other velocities until its own threshold is known. What varies \
stands in /variability; in a case without it there is one threshold. The interval holds sampling, mesh and time step, and says \
what part each has.

DIR gets v50.json, v50.csv (a row for each shot), v50-refined.csv (those on the converged mesh), v50.html and plan.json.")]
pub(crate) struct V50Arguments {
    #[command(flatten)]
    pub(crate) thresholds: ThresholdArguments,
    /// Realisations whose threshold is also found on the converged mesh, which corrects V50; 0 leaves V50 to the case's own mesh
    /// [default: 1 where nothing varies, 4 otherwise]
    #[arg(long, value_name = "N")]
    pub(crate) refined: Option<u32>,
    #[command(flatten)]
    pub(crate) batch: BatchArguments,
}

/// `ripstop sweep`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop sweep shot.json --over /pack/plies=1,2,4,8 --over /projectile/velocity_m_s=100..300:20
  ripstop sweep shot.json --over /pack/plies=1,2,4,8 --run v50 -o out/limits

Values are a list or a range with a step (A..B:STEP). Every case is read and checked before the first is computed.

DIR gets sweep.csv (a row for each point), sweep.html (lines over the first key), sweep.json, plan.json, and in points/ what \
`ripstop shots` or `ripstop v50` writes.")]
pub(crate) struct SweepArguments {
    /// A key and its values; may be given again
    #[arg(long, value_name = "/POINTER=VALUES", required = true)]
    pub(crate) over: Vec<String>,
    /// Study of each point
    #[arg(long, value_enum, default_value = "shots")]
    pub(crate) run: SweepKind,
    #[command(flatten)]
    pub(crate) thresholds: ThresholdArguments,
    #[command(flatten)]
    pub(crate) batch: BatchArguments,
}

/// Study of each point of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SweepKind {
    /// Shots of the case
    Shots,
    /// V50 of the case
    V50,
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
    /// v50.json of a `ripstop v50`, to lay over the shots
    #[arg(long, value_name = "V50.json")]
    pub(crate) computed: Option<PathBuf>,
    /// Folder for fit.json, fit.svg and fit.html [default: none is written]
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) print: PrintArguments,
}
