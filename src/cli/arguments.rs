//! The arguments of every command.

use std::path::PathBuf;

use clap::{ArgAction, Args, Parser, Subcommand, ValueEnum, builder::RangedU64ValueParser};

use clap_complete::Shell;
use ripstop::run::{self, Skips};
use ripstop::study;

use super::campaign_arguments::{ShotsArguments, SweepArguments, V50Arguments};
use super::range::{StretchRange, interval, level, percent, shift};

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
    /// Run the built-in verification table: unit cell, waves, conservation, the paper's shot, hard scenes
    Verify(VerifyArguments),
    /// Predictions against closed forms and the paper's two shots
    Validate(ValidateArguments),
    /// CPU and GPU from the same state, kernel by kernel: the first difference
    Compare(CompareArguments),
    /// Runs and measured curves against the first of them: results, keys of the case, curves over each other
    Diff(DiffArguments),
    /// Shots that perforated or were stopped: V50, scatter, intervals
    Fit(FitArguments),
    /// Many shots of a case: one table, one page
    Shots(ShotsArguments),
    /// The velocity at which half of all shots perforate, with its interval, from a case
    V50(V50Arguments),
    /// Shots or a V50 at every point of a grid, or at Sobol's points, of any keys of a case
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
profiles.csv where the case asks for profiles, and frames.vtkhdf where there are frames. \
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
    /// Frames for ParaView, evenly from impact to the end of the run, in frames.vtkhdf [default: /output/frames of the case]
    #[arg(long, value_name = "N")]
    pub(crate) frames: Option<u32>,
    /// Frames also as frames.pvd with a series of .vtu files
    #[arg(long)]
    pub(crate) vtu: bool,
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
    /// Frames also as frames.pvd with a series of .vtu files, whatever the run began with
    #[arg(long)]
    pub(crate) vtu: bool,
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
    #[arg(long, value_enum)]
    pub(crate) precision: Option<PrecisionChoice>,
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

/// Number type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PrecisionChoice {
    /// Double, the reference
    F64,
    /// Single
    F32,
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

/// `ripstop diff`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop diff out/shot out/shot-f32
  ripstop diff out/shot camera.csv -o out/against-camera
  ripstop diff out/shot camera.csv --column 'Ch 1=velocity_km_s' --shift -12.5
  ripstop diff out/shot out/new --within 2 --json | jq .pass

A table is CSV with a heading and a column of times: time_us, time_ms, time_s. Headings are columns of history.csv, in its \
unit or another (velocity_m_s, velocity_ft_s, deflection_mm, force_kn); others are compared where both have them.

Curves are compared where both are known, straight between their rows, never extrapolated. The first contact \
force of a run, an impulse over one step, is left out. --within judges outcome, residual and \
rebound velocity, stop time, absorbed energy, largest deflection, and of the curves velocity, displacement and deflection (all \
common ones where there is none of these), by their largest difference over the largest magnitude of A. With --column NAME it \
judges the curves named and nothing else. The exit code is 1 if one differs by more.

DIR gets diff.csv (all curves at all times), diff.svg (curves over each other) and diff.html (tables and figures).")]
pub(crate) struct DiffArguments {
    /// Folder of a run, its history.csv, or a CSV of a measured curve; the first is what the others are held against
    #[arg(value_name = "RUN|CSV", required = true, num_args = 2..=ripstop::study::diff::MAX_INPUTS)]
    pub(crate) inputs: Vec<PathBuf>,
    /// Compare this column only; HEADING=NAME says what a heading of a table stands for; may be given again
    #[arg(long = "column", value_name = "NAME|HEADING=NAME")]
    pub(crate) columns: Vec<String>,
    /// Exit with 1 where something judged differs by more
    #[arg(long, value_name = "PERCENT", value_parser = percent, allow_hyphen_values = true)]
    pub(crate) within: Option<f64>,
    /// Add to the times of all but the first [µs], for a camera whose clock starts elsewhere
    #[arg(long, value_name = "US", value_parser = shift, default_value = "0", hide_default_value = true, allow_hyphen_values = true)]
    pub(crate) shift: f64,
    /// Folder for diff.csv, diff.svg and diff.html [default: none is written]
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Print JSON
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
    #[arg(long, value_enum, default_value = "probit")]
    pub(crate) link: LinkChoice,
    /// Two-sided confidence of the intervals, such as 0.9 or 95%
    #[arg(long, value_name = "LEVEL", value_parser = level, default_value = "0.9", allow_hyphen_values = true)]
    pub(crate) level: f64,
    /// How intervals are made
    #[arg(long, value_enum, default_value = "likelihood")]
    pub(crate) interval: IntervalKind,
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

/// Distribution of the thresholds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum LinkChoice {
    /// Normal
    Probit,
    /// Logistic
    Logit,
}

/// How intervals are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum IntervalKind {
    /// Likelihood ratio
    Likelihood,
    /// Estimate and standard error: too short for few shots
    Wald,
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
    #[arg(long, value_enum)]
    pub(crate) law: Option<LawChoice>,
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

/// Unit-cell law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum LawChoice {
    /// The paper's (13)-(24)
    Published,
    /// Sinusoidal yarns, forces conjugate to the arc length
    Variational,
    /// Saw-tooth cell
    Kawabata,
}

impl From<PrecisionChoice> for run::Precision {
    fn from(precision: PrecisionChoice) -> Self {
        match precision {
            PrecisionChoice::F64 => Self::F64,
            PrecisionChoice::F32 => Self::F32,
        }
    }
}

impl From<LinkChoice> for ripstop::math::link::Link {
    fn from(link: LinkChoice) -> Self {
        match link {
            LinkChoice::Probit => Self::Probit,
            LinkChoice::Logit => Self::Logit,
        }
    }
}

impl From<IntervalKind> for study::interval::Interval {
    fn from(kind: IntervalKind) -> Self {
        match kind {
            IntervalKind::Likelihood => Self::Likelihood,
            IntervalKind::Wald => Self::Wald,
        }
    }
}
