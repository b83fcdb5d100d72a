//! The arguments of every command.

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum, builder::RangedU64ValueParser};

use clap_complete::Shell;
use ripstop::model::unit_cell_curve::CurveLaw;
use ripstop::run::{Precision, Skips};

use super::campaign_arguments::{FitArguments, ShotsArguments, SweepArguments, V50Arguments};
use super::choice::{LAWS, PRECISIONS, one_of};
use super::range::{StretchRange, interval};
use super::study_arguments::{BenchArguments, VerifyArguments};

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
    /// What to do.
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
    /// The velocity at which half of all shots perforate, with its interval, from a case
    V50(V50Arguments),
    /// Shots or a V50 at every point of a grid over any keys of a case
    Sweep(SweepArguments),
    /// What this machine offers and what `--backend auto` would choose
    Info(InfoArguments),
    /// JSON Schema of the case file
    Schema(SchemaArguments),
    /// What an exit code or a warning means and what to do
    Explain(ExplainArguments),
    /// Completion script for a shell
    Completions(CompletionsArguments),
}

/// `ripstop run`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop run cases/s720-1ply-155.json
  ripstop run shot.json --set /projectile/velocity_m_s=200 -o out/shot-200
  ripstop run cases/s728-*.json
  jq '.pack.plies = 2' shot.json | ripstop run -
  ripstop run shot.json --frames 60
  ripstop run shot.json --checkpoint-every 10     # then, after a crash: ripstop resume out/shot
  ripstop run shot.json --set '/pack/edges={\"left\":\"free\"}' --json | jq .residual_velocity_m_s

DIR gets report.html (open it in a browser: verdict, trust, figures, playback), summary.json, \
history.csv, events.csv, case.json (the case as run), shot.svg (a picture), plies.csv of a pack, \
profiles.csv where the case asks for profiles, and frames.pvd where there are frames. \
The first Ctrl-C writes them up to that moment, the second ends at once.")]
pub(crate) struct RunArguments {
    /// Case files, run one after the other; - is standard input
    #[arg(value_name = "CASE.json", required = true)]
    pub(crate) cases: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    /// Folder for the results; of several cases each gets a folder in it [default: out/<case name>, with what --set changed]
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Change of the case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Worker threads [default: all cores]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub(crate) threads: Option<usize>,
    /// Compute also what cannot change the result: what nothing has reached, what comes after the outcome, mirror images
    /// [default: all]
    #[arg(
        long,
        value_enum,
        value_name = "KIND,…",
        num_args = 0..,
        require_equals = true,
        value_delimiter = ',',
        default_missing_value = "all"
    )]
    pub(crate) no_skip: Vec<Skip>,
    /// Write no report.html
    #[arg(long)]
    pub(crate) no_report: bool,
    /// Frames for ParaView, evenly from impact to the end of the run, in frames.pvd [default: /output/frames of the case]
    #[arg(long, value_name = "N")]
    pub(crate) frames: Option<u32>,
    /// Leave a checkpoint in DIR every so many simulated µs, and at Ctrl-C, for `ripstop resume DIR`; it goes when the run ends
    #[arg(long, value_name = "US", value_parser = interval)]
    pub(crate) checkpoint_every: Option<f64>,
    /// Print nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Print summary.json instead of the table
    #[arg(long)]
    pub(crate) json: bool,
}

impl RunArguments {
    /// Changes of the case.
    pub(crate) fn sets(&self) -> Vec<String> {
        let frames = self.frames.map(|count| format!("/output/frames={count}"));
        self.sets.iter().cloned().chain(frames).collect()
    }

    /// What is left out.
    pub(crate) fn skips(&self) -> Skips {
        let on = |kind: Skip| !self.no_skip.iter().any(|off| [kind, Skip::All].contains(off));
        Skips { wavefront: on(Skip::Wavefront), outcome: on(Skip::Outcome), symmetry: on(Skip::Symmetry) }
    }
}

/// `ripstop new`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop new shot.json                          # asks for what is not given, on a terminal
  ripstop new shot.json --fabric twaron-ct709 --plies 4 --projectile fsp-22 --velocity 350
  ripstop new shot.json --fabric my-fabric.json --projectile sphere:6.35 --velocity 300

FILE holds every value with its source, and names ripstop.schema.json, written beside it: editors that know JSON Schema complete \
and check as you type. --fabric and --projectile without a known name list what there is.")]
pub(crate) struct NewArguments {
    /// Case file to write
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Fabric: a name, or a file with the keys of a fabric [default: s-720]
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) fabric: Option<String>,
    /// Plies [default: 1]
    #[arg(long, value_name = "N")]
    pub(crate) plies: Option<String>,
    /// Projectile: a name, or sphere:D, ball:D, rcc:D, cylinder:DxL with sizes in mm, of solid steel [default: rcc-paper]
    #[arg(long, value_name = "NAME")]
    pub(crate) projectile: Option<String>,
    /// Velocity [m/s] [default: 200]
    #[arg(long, value_name = "M_S", allow_negative_numbers = true)]
    pub(crate) velocity: Option<String>,
    /// Write over FILE where there is one
    #[arg(long)]
    pub(crate) force: bool,
}

/// `ripstop resume`
#[derive(Args, Debug)]
#[command(after_help = "Example:
  ripstop run shot.json --checkpoint-every 10
  ripstop resume out/shot

The case, what computes, its number type and what is left out are those of the run; so are all files, to the last bit, but
for the time it took. Frames of the run so far lie in DIR/checkpoint.frames until it ends. The case in DIR must be the one that the run began with. A run that has ended is let be.")]
pub(crate) struct ResumeArguments {
    /// Folder of the run
    #[arg(value_name = "DIR")]
    pub(crate) folder: PathBuf,
    /// Simulated µs between further checkpoints [default: as the run began]
    #[arg(long, value_name = "US", value_parser = interval)]
    pub(crate) checkpoint_every: Option<f64>,
    /// Worker threads [default: as the run began]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub(crate) threads: Option<usize>,
    /// Write no report.html
    #[arg(long)]
    pub(crate) no_report: bool,
    /// Print nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Print summary.json instead of the table
    #[arg(long)]
    pub(crate) json: bool,
}

/// What is left out unless asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Skip {
    /// What nothing has reached
    Wavefront,
    /// What comes after the outcome
    Outcome,
    /// What is a mirror image of something else
    Symmetry,
    /// Every one
    All,
}

/// What computes, and in which numbers.
#[derive(Args, Debug)]
pub(crate) struct BackendArguments {
    /// What computes
    #[arg(long, value_enum, default_value = "auto")]
    pub(crate) backend: BackendChoice,
    /// Graphics adapter, by part of its name or its number in `ripstop info` [default: the best]
    #[arg(long, value_name = "NAME|INDEX")]
    pub(crate) adapter: Option<String>,
    /// Number type of the state [default: f64 on the CPU, f32 on a GPU, which has no other]
    #[arg(long, value_parser = one_of(PRECISIONS))]
    pub(crate) precision: Option<Precision>,
}

/// What computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BackendChoice {
    /// A real GPU if there is one, else the CPU
    Auto,
    /// All cores of the processor
    Cpu,
    /// A graphics processor, software that acts as one included
    Gpu,
}

/// `ripstop info`
#[derive(Args, Debug)]
pub(crate) struct InfoArguments {
    /// Also say which terms this case has, which kernels run and what memory a GPU needs
    #[arg(value_name = "CASE.json")]
    pub(crate) case: Option<PathBuf>,
}

/// `ripstop schema`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop schema > ripstop.schema.json
  ripstop schema --markdown > keys.md")]
pub(crate) struct SchemaArguments {
    /// Print tables of every key in Markdown instead, for people
    #[arg(long)]
    pub(crate) markdown: bool,
}

/// `ripstop explain`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop explain
  ripstop explain W3
  ripstop explain 130")]
pub(crate) struct ExplainArguments {
    /// Exit code (0, 1, 2, 3, 130), or code or name of a warning (W1, energy) [default: all, in a list]
    #[arg(value_name = "EXIT|WARNING")]
    pub(crate) code: Option<String>,
    /// Print all of them in Markdown
    #[arg(long, conflicts_with = "code")]
    pub(crate) markdown: bool,
}

/// `ripstop completions`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop completions bash > ~/.local/share/bash-completion/completions/ripstop
  ripstop completions zsh > ~/.zfunc/_ripstop
  ripstop completions fish > ~/.config/fish/completions/ripstop.fish")]
pub(crate) struct CompletionsArguments {
    /// Shell
    #[arg(value_enum)]
    pub(crate) shell: Shell,
}

/// `ripstop check`
#[derive(Args, Debug)]
pub(crate) struct CheckArguments {
    /// Case files
    #[arg(value_name = "CASE.json", required = true)]
    pub(crate) cases: Vec<PathBuf>,
    /// Change of every case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    pub(crate) sets: Vec<String>,
}

/// `ripstop crossover`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop crossover cases/s720-1ply-155.json --warp-stretch 1:1.05:26 --weft-stretch 1
  ripstop crossover shot.json --warp-stretch 1.01 --weft-stretch 1 --law kawabata --json")]
pub(crate) struct CrossoverArguments {
    /// Case file; only its fabric matters
    #[arg(value_name = "CASE.json")]
    pub(crate) case: PathBuf,
    /// Fabric stretch along warp: one value, or first:last:count
    #[arg(long, value_name = "A[:B:N]")]
    pub(crate) warp_stretch: StretchRange,
    /// Fabric stretch along weft: one value, or first:last:count
    #[arg(long, value_name = "C[:D:N]")]
    pub(crate) weft_stretch: StretchRange,
    /// Unit-cell law [default: the case's]
    #[arg(long, value_parser = one_of(LAWS))]
    pub(crate) law: Option<CurveLaw>,
    /// Change of the case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Print JSON, every digit
    #[arg(long, conflicts_with = "csv")]
    pub(crate) json: bool,
    /// Print CSV, every digit
    #[arg(long)]
    pub(crate) csv: bool,
}
