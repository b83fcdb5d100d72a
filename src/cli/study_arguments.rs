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

With --objectivity the ballistic limit is bisected, and the residual velocity at 1.5 times the limit read, for other meshes,
time steps, positions of the hit in a cell, contact samplings and hourglass coefficients: minutes on two cores. The exit
code is 1 if a spread is more than allowed, as those of the paper's own numerics are (cases/s720-1ply-155.json). DIR gets
objectivity.json.

Examples:
  ripstop bench
  ripstop bench --objectivity --quick
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
    /// How far ballistic limit and residual velocity depend on what is numerical, instead of run time against error
    #[arg(long, conflicts_with_all = ["tolerance", "backend", "adapter", "repeat"])]
    pub(crate) objectivity: bool,
    /// A part of the settings
    #[arg(long, requires = "objectivity")]
    pub(crate) quick: bool,
    /// Print the table of figures in Markdown
    #[arg(long, requires = "objectivity", conflicts_with = "json")]
    pub(crate) markdown: bool,
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
  ripstop verify --backend gpu
  ripstop verify --stress --scenes 10000 --seed 7 --out out/stress
  ripstop verify --stress --seed 7 --scene 1072 --backend cpu

--stress runs the list of hard scenes, a million steps of a vibrating ply, and random scenes: on the CPU in f64 and f32, and
on the GPU that --backend auto would take. A random scene that is not sound is shrunk to few changes of a plain shot
and shown as a complete case, which `ripstop run` takes; with --out it becomes a file there.")]
pub(crate) struct VerifyArguments {
    /// Hard scenes and random ones instead of the table, on every backend and precision
    #[arg(long)]
    pub(crate) stress: bool,
    /// Random scenes on the CPU, in each precision; on the GPU a fiftieth of them
    #[arg(long, value_name = "N", default_value = "1000", requires = "stress")]
    pub(crate) scenes: u32,
    /// One random scene alone, by its number: no list, no long run; may be given several times
    #[arg(long = "scene", value_name = "NUMBER", requires = "stress", conflicts_with_all = ["scenes", "steps"])]
    pub(crate) alone: Vec<u64>,
    /// Steps of the vibrating ply on the CPU; on the GPU a fiftieth of them
    #[arg(
        long,
        value_name = "N",
        default_value = "1000000",
        requires = "stress",
        value_parser = RangedU64ValueParser::<u64>::new().range(100..=1_000_000_000)
    )]
    pub(crate) steps: u64,
    /// Where the random scenes come from; the same seed gives the same scenes
    #[arg(long, value_name = "S", default_value = "1", requires = "stress")]
    pub(crate) seed: u64,
    /// Folder for the cases of random scenes that are not sound [default: they are printed]
    #[arg(long, value_name = "DIR", requires = "stress")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    /// Worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub(crate) threads: Option<usize>,
    /// Print the table as JSON
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the table in Markdown
    #[arg(long, conflicts_with_all = ["json", "stress"])]
    pub(crate) markdown: bool,
}

/// `ripstop validate`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop validate
  ripstop validate --html out/validation.html
  ripstop validate --json | jq '.rows[] | select(.judged)'

What was published as a curve only is shown, not judged. The exit code is 1 if a judged row fails for no known reason.")]
pub(crate) struct ValidateArguments {
    /// Case files whose published statements are checked [default: closed forms and the paper's shots, which are built in]
    #[arg(value_name = "CASE.json")]
    pub(crate) cases: Vec<PathBuf>,
    /// Also look for the limits of five packs whose V50 was measured; takes far longer than the rest
    #[arg(long, conflicts_with = "cases")]
    pub(crate) limits: bool,
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    /// Worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub(crate) threads: Option<usize>,
    /// Also write the table as a page of HTML
    #[arg(long, value_name = "FILE")]
    pub(crate) html: Option<PathBuf>,
    /// Print the table as JSON
    #[arg(long, conflicts_with = "markdown")]
    pub(crate) json: bool,
    /// Print the table in Markdown
    #[arg(long)]
    pub(crate) markdown: bool,
}

/// `ripstop compare`
#[derive(Args, Debug)]
#[command(
    after_help = "The CPU runs the case in f32. Before every compared step its state is put on the GPU and, widened, into an
f64 run; the three compute that step kernel by kernel. The exit code is 1 if a difference exceeds the tolerance.

Examples:
  ripstop compare cases/s720-1ply-155.json
  ripstop compare shot.json --steps 200 --every 1 --json"
)]
pub(crate) struct CompareArguments {
    /// Case file
    #[arg(value_name = "CASE.json")]
    pub(crate) case: PathBuf,
    /// Graphics adapter, by part of its name or its number in `ripstop info` [default: the best]
    #[arg(long, value_name = "NAME|INDEX")]
    pub(crate) adapter: Option<String>,
    /// Steps to follow [default: to the end of the case]
    #[arg(long, value_name = "N")]
    pub(crate) steps: Option<u64>,
    /// Compare every so many steps
    #[arg(long, value_name = "N", default_value = "10", value_parser = RangedU64ValueParser::<u64>::new().range(1..))]
    pub(crate) every: u64,
    /// Change of the case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}
