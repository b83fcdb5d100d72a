//! `ripstop shots`, `v50`, `sweep` and `fit`: many shots, and the limit they give.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;

use clap::{Args, ValueEnum};
use ripstop::case::{Case, CaseError, with_velocity};
use ripstop::output::Folder;
use ripstop::output::number::short;
use ripstop::study::batch::{BatchError, BatchOptions, StudyProgress, order_case};
use ripstop::study::fit::{self, ColumnKind, VelocityUnit};
use ripstop::study::report::{Report, ReportTable};
use ripstop::study::shots::{self, ShotsRequest};
use ripstop::study::sweep::{self, Factor, SweepOf, SweepRequest, grid};
use ripstop::study::v50::{self, V50Request};
use serde_json::Value;

use super::arguments::{
    Backend, BackendChoice, BatchArguments, PrintArguments, above_zero, column, level, percent, read, velocities,
};
use super::run::{RunArguments, shoot};
use super::terminal::{self, Align, CommandFailure, TextTable, files, notes, part, say};

/// Half the width of the interval over V50 at which thresholds end, and realisations at most, where nothing is asked for.
const WIDTH: f64 = 0.02;
const COUNT: u32 = 64;
/// Realisations that are shot on the converged mesh too: of a case in which nothing varies, and of others.
const REFINED: [u32; 2] = [1, 4];
/// Files of `ripstop fit`.
const FIT_FILES: [&str; 2] = ["fit.json", "fit.html"];
/// Rows of a table at most.
const MAX_ROWS: usize = 60;

/// `ripstop shots`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop shots cases/s720-1ply-155.json --count 40 --velocity 150..220
  ripstop shots shot.json --count 1000 --velocity 150..250 -o out/limit     # again after Ctrl-C, kill or a full disk: it goes on
  ripstop shots shot.json --velocity 150..250 -o out/limit --only 17                 # shot 17 alone, with its report

What varies from shot to shot stands in /variability of the case. DIR gets shots.csv, which `ripstop fit` reads, shots.json and shots.html.")]
pub(crate) struct ShotsArguments {
    /// Shots
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000), required_unless_present = "only")]
    count: Option<u32>,
    /// Velocities spread evenly over a range [m/s] [default: that of the case]
    #[arg(long, value_name = "A..B", value_parser = velocities)]
    velocity: Option<[f64; 2]>,
    /// Run this shot alone, with everything that `ripstop run` writes, in DIR/shot-N
    #[arg(long, value_name = "N")]
    only: Option<u32>,
    #[command(flatten)]
    batch: BatchArguments,
}

/// Number of realisations, and width of their brackets.
#[derive(Args, Debug)]
struct ThresholdArguments {
    /// Realisations of a V50 at most [default: 64]; of a sweep of shots, shots at each point [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    count: Option<u32>,
    /// Width of the bracket of a threshold
    #[arg(long, value_name = "PERCENT", value_parser = percent, default_value = "0.5%", allow_hyphen_values = true)]
    bracket: f64,
    /// Stop once half the interval of V50 is at most this part of V50 [default: 2% without --count]
    #[arg(long, value_name = "PERCENT", value_parser = percent, allow_hyphen_values = true)]
    until_width: Option<f64>,
}

/// `ripstop v50`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop v50 cases/s720-1ply-scatter.json --until-width 3% -o out/limit
  ripstop v50 shot.json --json | jq .v50_m_s

What varies from shot to shot stands in /variability of the case. DIR gets v50.json, v50.csv, v50-refined.csv and v50.html.")]
pub(crate) struct V50Arguments {
    #[command(flatten)]
    thresholds: ThresholdArguments,
    /// Realisations whose threshold is also found on the converged mesh, which corrects V50; 0 leaves V50 to the case's own mesh
    /// [default: 1 where nothing varies, 4 otherwise]
    #[arg(long, value_name = "N")]
    refined: Option<u32>,
    #[command(flatten)]
    batch: BatchArguments,
}

/// `ripstop sweep`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop sweep shot.json --over /pack/plies=1,2,4,8 --over /projectile/velocity_m_s=100..300:20
  ripstop sweep shot.json --over /pack/plies=1,2,4,8 --run v50 -o out/limits

DIR gets sweep.csv, sweep.html, sweep.json, and in points/ what `ripstop shots` or `ripstop v50` writes.")]
pub(crate) struct SweepArguments {
    /// A key and its values; may be given again
    #[arg(long, value_name = "/POINTER=VALUES", required = true)]
    over: Vec<String>,
    /// Study of each point
    #[arg(long, value_enum, default_value = "shots")]
    run: SweepKind,
    #[command(flatten)]
    thresholds: ThresholdArguments,
    #[command(flatten)]
    batch: BatchArguments,
}

/// Study of each point of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SweepKind {
    /// Shots of the case
    Shots,
    /// V50 of the case
    V50,
}

/// `ripstop fit`
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  ripstop fit shots.csv --level 95% -o out/limit
  ripstop fit shots.csv --json | jq '.quantiles[] | select(.p == 0.5)'
  ripstop fit range.csv --column velocity=Speed --unit ft/s --spread 90

DATA.csv has the columns velocity_m_s and perforated (1, CP, yes or perforated where the projectile passed, 0, PP, no or stopped where it \
was stopped), and if wanted count (shots that were alike) and residual_velocity_m_s. Other units: velocity_ft_s, Vs (ft/s). Without a column \
perforated, shots with a residual velocity above 0 have perforated. Numbers of the results are in the unit of the velocities.")]
pub(crate) struct FitArguments {
    /// CSV of shots
    #[arg(value_name = "DATA.csv")]
    data: PathBuf,
    /// Unit of velocities whose heading has none
    #[arg(long, value_enum)]
    unit: Option<VelocityUnit>,
    /// Column by its heading: velocity, perforated, count or residual; may be given again
    #[arg(long = "column", value_name = "KIND=NAME", value_parser = column)]
    columns: Vec<(ColumnKind, String)>,
    /// Largest spread of a further arithmetic V50, in the unit of the velocities [default: those of standards alone]
    #[arg(long, value_name = "VELOCITY", value_parser = above_zero, allow_hyphen_values = true)]
    spread: Option<f64>,
    /// Two-sided confidence of the intervals, such as 0.9 or 95%
    #[arg(long, value_name = "LEVEL", value_parser = level, default_value = "0.9", allow_hyphen_values = true)]
    level: f64,
    /// Folder for fit.json and fit.html [default: none is written]
    #[arg(long, short, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    print: PrintArguments,
}

/// `ripstop shots`: shots of a case, or one of them alone.
pub(crate) fn shots(arguments: &ShotsArguments) -> Result<(), CommandFailure> {
    let study = Study::new(&arguments.batch, "shots", shots::FILES)?;
    let request = ShotsRequest { velocity: arguments.velocity, ..shots_request(&arguments.batch, arguments.count) };
    let case = &study.case;
    if let Some(number) = arguments.only {
        let mut shot = order_case(case, study.seed(), shots::order(&request, study.seed(), number))?;
        // The case expects that of its nominal shot.
        shot.expect.clear();
        let velocity = shot.projectile.as_ref().map_or(0.0, |projectile| projectile.velocity);
        shot.title = format!("{}, shot {number} at {} m/s", case.title, short(velocity, 4));
        let BatchArguments { precision, backend, print, .. } = &arguments.batch;
        let (backend, print) = (backend.clone(), print.clone());
        let mut as_run = RunArguments { precision: *precision, backend, print, ..Default::default() };
        as_run.backend.backend.get_or_insert(BackendChoice::Cpu);
        return shoot(&as_run, &shot, &study.out().join(format!("shot-{number}")), &study.interrupted);
    }
    study.compute("shots", |options, folder| {
        let found = shots::run(case, &request, options, folder)?;
        Ok((found.fit.json(), found.report(case)))
    })
}

/// `ripstop v50`: the V50 of a case.
pub(crate) fn v50(arguments: &V50Arguments) -> Result<(), CommandFailure> {
    let study = Study::new(&arguments.batch, "v50", v50::FILES)?;
    let case = &study.case;
    let refined = arguments.refined.unwrap_or(REFINED[usize::from(case.varies())]);
    let request = V50Request { refined, ..v50_request(&arguments.batch, &arguments.thresholds) };
    let mut missing = None;
    study.compute("thresholds", |options, folder| {
        let found = v50::run(case, &request, options, folder)?;
        missing = found.missing();
        Ok((found.json(case, &request, options.seed), found.report(case, &request)))
    })?;
    missing
        .map_or(Ok(()), |why| Err(CommandFailure::check(format!("error: {}: {why}", arguments.batch.case.display()))))
}

/// `ripstop sweep`: shots or a V50 at every point of a grid.
pub(crate) fn sweep(arguments: &SweepArguments) -> Result<(), CommandFailure> {
    let study = Study::new(&arguments.batch, "sweep", sweep::FILES)?;
    let factors = arguments.over.iter().map(|text| Factor::parse(text)).collect::<Result<Vec<_>, CaseError>>()?;
    let mut points = Vec::new();
    for values in grid(&factors)? {
        let over = factors.iter().zip(&values).map(|(factor, value)| format!("{}={value}", factor.pointer));
        let sets: Vec<String> = arguments.batch.sets.iter().cloned().chain(over).collect();
        points.push((values, read(&arguments.batch.case, &sets)?));
    }
    // Points are compared with each other, all on the mesh of their case.
    let of = match arguments.run {
        SweepKind::V50 => SweepOf::V50(v50_request(&arguments.batch, &arguments.thresholds)),
        SweepKind::Shots => SweepOf::Shots(shots_request(&arguments.batch, arguments.thresholds.count)),
    };
    let request = SweepRequest { factors, level: arguments.batch.level, of, points };
    let title = &study.case.title;
    study.compute("points", |options, folder| {
        let found = sweep::run(&request, options, folder, title)?;
        Ok((found.json(&request), found.report(&request, title)))
    })
}

/// `ripstop fit`: a limit from a table of shots.
pub(crate) fn fit(arguments: &FitArguments) -> Result<(), CommandFailure> {
    let data = fit::read(&arguments.data, arguments.unit, &arguments.columns)?;
    let found = fit::fit(&data, arguments.level, arguments.spread);
    let title = arguments.data.display().to_string();
    let (json, report) = (found.json(), found.report(&title));
    let mut printed = text(&report);
    if let Some(out) = &arguments.out {
        let folder = Folder::prepare_for(out, &FIT_FILES, &[&arguments.data])?;
        let page = report.html(&format!("Ballistic limit: {title}"), "fit.json");
        let texts = [format!("{json:#}\n"), page];
        folder.put(&FIT_FILES.into_iter().zip(texts).collect::<Vec<_>>(), &[])?;
        printed += &files(out, &FIT_FILES);
    }
    terminal::show(&arguments.print, &json, || printed)
}

fn shots_request(arguments: &BatchArguments, count: Option<u32>) -> ShotsRequest {
    ShotsRequest { count: count.unwrap_or(1), velocity: None, level: arguments.level }
}

fn v50_request(arguments: &BatchArguments, thresholds: &ThresholdArguments) -> V50Request {
    V50Request {
        count: thresholds.count.unwrap_or(COUNT),
        until_width: thresholds.until_width.or(thresholds.count.is_none().then_some(WIDTH)),
        bracket: thresholds.bracket,
        refined: 0,
        level: arguments.level,
    }
}

/// Study of a case that is about to be computed.
struct Study<'a> {
    arguments: &'a BatchArguments,
    command: &'static str,
    /// Names of its files.
    files: &'static [&'static str],
    /// Nominal case, whatever shot it names.
    case: Case,
    interrupted: Arc<AtomicBool>,
}

impl<'a> Study<'a> {
    fn new(
        arguments: &'a BatchArguments,
        command: &'static str,
        files: &'static [&'static str],
    ) -> Result<Self, CommandFailure> {
        let interrupted = terminal::watch_interrupts()?;
        let mut case = read(&arguments.case, &arguments.sets)?;
        // Velocities are those of the shots.
        case.title = with_velocity(&case.title, None);
        if case.projectile.is_none() {
            let place = arguments.case.display();
            return Err(CommandFailure::expected(place, "a projectile, to be shot", "none in the case"));
        }
        Ok(Self { arguments, command, files, case, interrupted })
    }

    /// Seed of all draws.
    fn seed(&self) -> u32 {
        self.arguments.seed.unwrap_or(self.case.variability.as_ref().map_or(1, |variability| variability.seed))
    }

    /// Folder of the results.
    fn out(&self) -> PathBuf {
        let usual = || Path::new("out").join(format!("{}-{}", self.case.name, self.command));
        self.arguments.out.clone().unwrap_or_else(usual)
    }

    /// Computes, shows progress counted in `units`, and prints JSON or report.
    fn compute(
        &self,
        units: &str,
        work: impl FnOnce(&BatchOptions<'_>, &Folder) -> Result<(Value, Report), BatchError>,
    ) -> Result<(), CommandFailure> {
        let (arguments, out) = (self.arguments, self.out());
        let chosen = Backend::choose(&arguments.backend, BackendChoice::Cpu, arguments.precision, &arguments.print)?;
        let folder = Folder::prepare_for(&out, self.files, &[self.case.path.as_path()])?;
        let goes_on = out.join(self.files[0]).exists();
        terminal::begin_bar(&arguments.print);
        let show = |at: StudyProgress| terminal::show_count(at, units);
        let options = BatchOptions {
            seed: self.seed(),
            threads: arguments
                .backend
                .threads
                .unwrap_or_else(|| thread::available_parallelism().map_or(1, NonZero::get)),
            threads_per_shot: 1,
            precision: chosen.precision,
            device: chosen.device.as_ref(),
            interrupt: &self.interrupted,
            resume: arguments.resume,
            progress: &show,
        };
        let done = work(&options, &folder);
        terminal::end_bar();
        let (json, report) = done.map_err(|error| failure(error, &out))?;
        if goes_on {
            say(&arguments.print, &format!("note: {}: shots that were there are not fired again", out.display()));
        }
        let mut names: Vec<&str> = self.files.iter().copied().chain(["points/"]).collect();
        names.retain(|name| out.join(name).exists());
        terminal::show(&arguments.print, &json, || text(&report) + &files(&out, &names))
    }
}

/// Message of a batch that did not end; `folder`: of its rows.
fn failure(error: BatchError, folder: &Path) -> CommandFailure {
    match error {
        BatchError::Refused(error) => error.into(),
        BatchError::Device(error) => error.into(),
        BatchError::Interrupted => CommandFailure::interrupted(format!(
            "interrupted; rows so far: {}\n  help: the same command goes on",
            folder.display()
        )),
    }
}

/// Report for the terminal.
fn text(report: &Report) -> String {
    let lines = |lines: &[String]| lines.iter().map(|line| format!("{line}\n")).collect::<String>();
    let mut out = if report.title.is_empty() { String::new() } else { format!("{}\n", report.title) };
    out += &lines(&report.counts);
    if let Some((first, others)) = report.answer.split_first() {
        let (v50, rest) = first.split_at(first.find(',').unwrap_or(first.len()));
        out += &format!("\n{}{rest}\n{}", terminal::heading(v50), lines(others));
    }
    out += &notes(&report.notes);
    out.extend(report.tables.iter().filter(|table| !table.is_folded).map(table));
    out
}

/// Table of a report under its title.
fn table(of: &ReportTable) -> String {
    let columns = of.rows.first().map_or(0, Vec::len);
    let align = |column: usize| if of.is_text(column) { Align::Left } else { Align::Right };
    let mut table = TextTable::plain(&(0..columns).map(align).collect::<Vec<_>>());
    if columns > 0 && !of.heads.is_empty() {
        table.row(of.heads.iter().map(String::as_str));
    }
    of.rows.iter().take(MAX_ROWS).for_each(|row| table.row(row.iter().map(String::as_str)));
    let mut text = table.to_string();
    let more = of.rows.len().saturating_sub(MAX_ROWS);
    text.extend((more > 0).then(|| format!("… and {more} more\n")));
    text.extend(of.foot.lines().map(|line| format!("{line}\n")));
    if of.title.is_empty() { format!("\n{text}") } else { part(of.title, &text) }
}
