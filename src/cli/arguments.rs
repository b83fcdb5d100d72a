//! The command line: its commands, arguments that several of them have with the backend that they ask for, values of options, and cases
//! from files.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::builder::RangedU64ValueParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use ripstop::case::{self, Case, CaseError};
use ripstop::gpu::device::Adapter;
use ripstop::gpu::{self, Device};
use ripstop::output::warnings;
use ripstop::run::checkpoint::BackendId;
use ripstop::run::{Options, Precision};
use ripstop::study::fit::ColumnKind;

use super::bench::{BenchArguments, VerifyArguments};
use super::check::{CheckArguments, CrossoverArguments};
use super::new::NewArguments;
use super::run::RunArguments;
use super::studies::{FitArguments, ShotsArguments, SweepArguments, V50Arguments};
use super::terminal::{self, CommandFailure};

/// Largest stretch that is solved.
const MAX_STRETCH: f64 = 2.0;
/// Values in a range at most.
const MAX_COUNT: usize = 10_000;

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
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Run a case: verdict, energies, files
    Run(RunArguments),
    /// Write a case to start from: fabric, plies, projectile, velocity
    New(NewArguments),
    /// Check cases without running them: what follows from their numbers, and what is assumed
    Check(CheckArguments),
    /// Go on with a run from its last checkpoint, to the same results as if it had never stopped
    #[command(after_help = "Example:
  ripstop run shot.json --checkpoint-every 10
  ripstop resume out/shot

All files are those of an uninterrupted run, to the last bit, but for the time it took.")]
    Resume {
        /// Folder of the run
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        #[command(flatten)]
        print: PrintArguments,
    },
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
    Info {
        /// Also say which terms this case has, which kernels run and what memory a GPU needs
        #[arg(value_name = "CASE.json")]
        case: Option<PathBuf>,
    },
    /// JSON Schema of the case file
    #[command(after_help = "Examples:
  ripstop schema > ripstop.schema.json
  ripstop schema --markdown > keys.md")]
    Schema {
        /// Print tables of every key in Markdown instead, for people
        #[arg(long)]
        markdown: bool,
    },
    /// Meaning of an exit code or a warning, and what to do
    #[command(after_help = "Examples:
  ripstop explain
  ripstop explain W3
  ripstop explain 130")]
    Explain {
        /// Exit code (0, 1, 2, 3, 130), or code or name of a warning (W1, energy) [default: all, in a list]
        #[arg(value_name = "EXIT|WARNING")]
        code: Option<String>,
    },
    /// Completion script for a shell
    #[command(after_help = "Examples:
  ripstop completions bash > ~/.local/share/bash-completion/completions/ripstop
  ripstop completions zsh > ~/.zfunc/_ripstop
  ripstop completions fish > ~/.config/fish/completions/ripstop.fish")]
    Completions {
        /// Shell
        #[arg(value_enum)]
        shell: Shell,
    },
}

impl Command {
    /// Whether it may look for graphics adapters.
    #[cfg(target_os = "linux")]
    pub(crate) fn looks_for_adapters(&self) -> bool {
        use Command::{Bench, Info, Resume, Run, Shots, Sweep, V50, Verify};
        matches!(self, Run(_) | Resume { .. } | Bench(_) | Verify(_) | Shots(_) | V50(_) | Sweep(_) | Info { .. })
    }
}

/// Backend and threads.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct BackendArguments {
    /// Backend that computes [default: auto; of shots, v50 and sweep: cpu]
    #[arg(long, value_enum)]
    pub(crate) backend: Option<BackendChoice>,
    /// Graphics adapter, by part of its name or its number in `ripstop info` [default: the best]
    #[arg(long, value_name = "NAME|INDEX")]
    pub(crate) adapter: Option<String>,
    /// Worker threads [default: all cores]; results do not depend on it
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub(crate) threads: Option<usize>,
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

/// Form of what is printed.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct PrintArguments {
    /// Print nothing but errors
    #[arg(long, short)]
    pub(crate) quiet: bool,
    /// Print JSON instead of text
    #[arg(long)]
    pub(crate) json: bool,
}

/// Arguments that all commands for many shots have.
#[derive(Args, Debug)]
pub(crate) struct BatchArguments {
    /// Case file
    #[arg(value_name = "CASE.json")]
    pub(crate) case: PathBuf,
    /// Change of the case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    pub(crate) sets: Vec<String>,
    /// Number that all draws come from [default: /variability/seed of the case]
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u32>,
    #[command(flatten)]
    pub(crate) backend: BackendArguments,
    /// Number type [default: f64; f32 on a GPU, which has no other]
    #[arg(long, value_enum)]
    pub(crate) precision: Option<Precision>,
    /// Two-sided confidence of the intervals, such as 0.9 or 95%
    #[arg(long, value_name = "LEVEL", value_parser = level, default_value = "0.9", allow_hyphen_values = true)]
    pub(crate) level: f64,
    /// Folder for the results [default: out/<case name>-<command>]
    #[arg(long, short, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Only go on with what lies in the folder, which the same command does anyway; never begin
    #[arg(long)]
    pub(crate) resume: bool,
    #[command(flatten)]
    pub(crate) print: PrintArguments,
}

/// Backend of a run.
pub(crate) struct Backend {
    /// The graphics processor; none for the processor.
    pub(crate) device: Option<Device>,
    /// Number type: f32 on a device, which has no other.
    pub(crate) precision: Precision,
}

impl Backend {
    fn on(device: Device) -> Self {
        Self { device: Some(device), precision: Precision::F32 }
    }

    /// Backend that the arguments ask for, else `usual`; says what `auto` takes.
    pub(crate) fn choose(
        arguments: &BackendArguments,
        usual: BackendChoice,
        asked: Option<Precision>,
        print: &PrintArguments,
    ) -> Result<Self, CommandFailure> {
        let (name, in_double) = (arguments.adapter.as_deref(), asked == Some(Precision::F64));
        let cpu = Self { device: None, precision: asked.unwrap_or_default() };
        let why = match arguments.backend.unwrap_or(usual) {
            BackendChoice::Cpu if name.is_some() => {
                return Err(CommandFailure::expected("--adapter", "--backend gpu or auto", "--backend cpu"));
            }
            BackendChoice::Cpu => return Ok(cpu),
            BackendChoice::Gpu if in_double => {
                let expected = "f32, the number type of the GPU backend";
                let failure = CommandFailure::expected("--precision f64", expected, "f64");
                return Err(failure.help("leave it out, or take --backend cpu"));
            }
            BackendChoice::Gpu => return Ok(Self::on(Device::find(name)?)),
            BackendChoice::Auto if in_double => "f64 was asked for".to_owned(),
            BackendChoice::Auto => {
                let adapters = gpu::adapters();
                // An adapter asked for by name is taken, whatever it is.
                let by_name = name.map(|name| gpu::device::choose(&adapters, Some(name))).transpose()?;
                let adapter = by_name.as_ref().map_or_else(|| gpu::device::automatic(&adapters), Ok);
                let open = |adapter: &Adapter| Device::open(adapter).map_err(|error| error.to_string());
                match adapter.map_err(str::to_owned).and_then(|adapter| Ok((adapter, open(adapter)?))) {
                    Err(why) => why,
                    Ok((adapter, device)) => {
                        let what = format!("{} ({})", adapter.name(), adapter.kind());
                        terminal::say(print, &format!("note: --backend auto takes the GPU: {what}"));
                        return Ok(Self::on(device));
                    }
                }
            }
        };
        took_cpu(print, &why);
        Ok(cpu)
    }

    /// Backend that a run began with.
    pub(crate) fn again(backend: &BackendId) -> Result<Self, CommandFailure> {
        match backend {
            BackendId::Cpu(precision) => Ok(Self { device: None, precision: *precision }),
            BackendId::Gpu(name) => {
                // The one of this very name, not just the first that has it as a part.
                let index = gpu::adapters().iter().position(|adapter| adapter.name() == name).map(|at| at.to_string());
                Ok(Self::on(Device::find(Some(index.as_ref().unwrap_or(name)))?))
            }
        }
    }

    /// Options of a run on it.
    pub(crate) fn options(&self, threads: Option<usize>) -> Options<'_> {
        Options::default().threads(threads).precision(self.precision).device(self.device.as_ref())
    }
}

/// Says that `auto` takes the processor.
pub(crate) fn took_cpu(print: &PrintArguments, why: &str) {
    terminal::say(print, &format!("note: --backend auto takes the CPU: {why}"));
}

/// The case of a file with changes, named after them, unless its result would say nothing.
pub(crate) fn read(path: &Path, sets: &[String]) -> Result<Case, CaseError> {
    let mut case = case::read(path, sets)?;
    warnings::refuse(&case)?;
    case.name_changes(sets);
    Ok(case)
}

/// A number that fits.
fn number(text: &str, expected: &str, fits: impl Fn(f64) -> bool) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number| fits(*number));
    number.ok_or_else(|| format!("expected {expected}, found {text:?}"))
}

/// A two-sided confidence: a number above 0, or a percentage with its sign.
pub(crate) fn level(text: &str) -> Result<f64, String> {
    let (digits, scale) = text.trim().strip_suffix('%').map_or((text, 1.0), |digits| (digits, 100.0));
    let expected = "a confidence above 0 and at most 0.9999, such as 0.9 or 90%";
    number(digits, expected, |number| number > 0.0 && number / scale <= 0.9999).map(|number| number / scale)
}

/// A difference above 0 in percent, as a fraction.
pub(crate) fn percent(text: &str) -> Result<f64, String> {
    let expected = "a difference above 0 in percent, such as 2 or 0.5%";
    let fits = |percent: f64| percent > 0.0 && percent.is_finite();
    number(text.trim().trim_end_matches('%'), expected, fits).map(|percent| percent / 100.0)
}

/// Kind of a column, and its heading.
pub(crate) fn column(text: &str) -> Result<(ColumnKind, String), String> {
    let parts =
        text.split_once('=').and_then(|(kind, name)| Some((ColumnKind::from_str(kind, true).ok()?, name.into())));
    parts.ok_or_else(|| format!("expected velocity, perforated, count or residual, =, and a heading, found {text:?}"))
}

/// A time above 0 [µs], in s.
pub(crate) fn interval(text: &str) -> Result<f64, String> {
    number(text, "a time above 0 in µs", |time| time > 0.0 && time.is_finite()).map(|time| time * 1e-6)
}

/// A number above 0.
pub(crate) fn above_zero(text: &str) -> Result<f64, String> {
    number(text, "a number above 0", |number| number > 0.0 && number.is_finite())
}

/// A range of velocities `A..B` [m/s].
pub(crate) fn velocities(text: &str) -> Result<[f64; 2], String> {
    let ends = text.split_once("..").map(|(low, high)| [low, high].map(|end| end.trim().parse().unwrap_or(f64::NAN)));
    ends.filter(|[low, high]| *low > 0.0 && high > low && *high <= 5000.0)
        .ok_or_else(|| format!("expected two velocities in m/s, the lower first, such as 150..250, found {text:?}"))
}

/// Stretches Λ: one, or `first:last:count` with both ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Stretches(pub(crate) Vec<f64>);

impl FromStr for Stretches {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let stretch = |text: &str| {
            let expected = format!("a stretch above 0 and at most {MAX_STRETCH}; unstretched is 1");
            number(text, &expected, |stretch| stretch > 0.0 && stretch <= MAX_STRETCH)
        };
        match text.split(':').collect::<Vec<_>>()[..] {
            [value] => Ok(Self(vec![stretch(value)?])),
            [first, last, count] => {
                let (first, last) = (stretch(first)?, stretch(last)?);
                let fits = |count: f64| count.fract() == 0.0 && (2.0..=MAX_COUNT as f64).contains(&count);
                let end = number(count, &format!("a count between 2 and {MAX_COUNT}"), fits)? as usize - 1;
                let inner = (0..end).map(|n| first + (last - first) * n as f64 / end as f64);
                Ok(Self(inner.chain([last]).collect()))
            }
            _ => Err("expected one stretch, or first:last:count like 1:1.05:26".to_owned()),
        }
    }
}
