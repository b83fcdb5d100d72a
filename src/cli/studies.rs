//! `ripstop shots`, `v50`, `sweep` and `fit`: many shots, and the limit they give.

use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Instant;

use ripstop::case::{Case, CaseError};
use ripstop::num::link::Link;
use ripstop::output::Folder;
use ripstop::output::number::{bytes, duration, short};
use ripstop::run::batch::DeviceUse;
use ripstop::study::StudyError;
use ripstop::study::batch::{BatchError, BatchOptions, BatchProgress, order_case};
use ripstop::study::fit::{self, Fit, FitRequest};
use ripstop::study::interval::Bounds;
use ripstop::study::limit::ComputedLimit;
use ripstop::study::report::{Report, ReportTable};
use ripstop::study::shots::{self, ShotsRequest};
use ripstop::study::sweep::{self, Factor, SweepOf, SweepRequest, grid};
use ripstop::study::v50::{self, V50Request};
use serde_json::Value;

use super::backend;
use super::campaign_arguments::{
    BatchArguments, FitArguments, ShotsArguments, SweepArguments, SweepKind, ThresholdArguments, V50Arguments,
};
use super::failure::CommandFailure;
use super::input::Source;
use super::result::{files, notes, part};
use super::run::{RunArguments, shoot};
use super::terminal::{self, Align, Bar, TextTable};

/// Half the width of the interval over V50 at which thresholds end, and realisations at most, where nothing is asked for.
const WIDTH: f64 = 0.02;
const COUNT: u32 = 64;
/// Realisations that are shot on the converged mesh too: of a case in which nothing varies, and of others.
const REFINED: [u32; 2] = [1, 4];
/// Files of `ripstop fit`.
const FIT_FILES: [&str; 3] = ["fit.json", "fit.svg", "fit.html"];
/// Rows of a table at most, and letters of its last cell.
const MAX_ROWS: usize = 60;
const MAX_LETTERS: usize = 40;

/// `ripstop shots`: shots of a case, or one of them alone.
pub(crate) fn shots(arguments: &ShotsArguments) -> Result<(), CommandFailure> {
    let study = Study::new(&arguments.batch, "shots", shots::FILES)?;
    let request = ShotsRequest {
        count: arguments.count.unwrap_or(1),
        velocity: arguments.velocity.map(|velocities| velocities.0),
        until_width: arguments.batch.until_width,
        fit: fit_request(&arguments.batch),
    };
    let (case, seed) = (&study.case, study.seed());
    if let Some(number) = arguments.only {
        let mut shot = order_case(case, seed, shots::order(&request, seed, number))?;
        // The case expects that of its nominal shot.
        shot.expect.clear();
        shot.title = format!("{}, shot {number}", case.title);
        return shoot(
            &run_arguments(&arguments.batch),
            &shot,
            &study.out().join(format!("shot-{number}")),
            &study.interrupted,
        );
    }
    study.compute("shots", |options, folder| {
        let found = shots::run(case, &request, options, folder)?;
        Ok((found.fit.json(), found.report(case, &request), found.device))
    })
}

/// `ripstop v50`: the V50 of a case.
pub(crate) fn v50(arguments: &V50Arguments) -> Result<(), CommandFailure> {
    let study = Study::new(&arguments.batch, "v50", v50::FILES)?;
    let case = &study.case;
    let refined = arguments.refined.unwrap_or(REFINED[usize::from(case.varies())]);
    let request = V50Request { refined, ..v50_request(&arguments.batch, &arguments.thresholds) };
    study.compute("shots", |options, folder| {
        let found = v50::run(case, &request, options, folder)?;
        Ok((found.json(case, &request, options.seed), found.report(case, &request), found.device))
    })
}

/// `ripstop sweep`: shots or a V50 at every point of a grid.
pub(crate) fn sweep(arguments: &SweepArguments) -> Result<(), CommandFailure> {
    let study = Study::new(&arguments.batch, "sweep", sweep::FILES)?;
    let factors = arguments.over.iter().map(|text| Factor::parse(text)).collect::<Result<Vec<_>, StudyError>>()?;
    let mut points = Vec::new();
    for values in grid(&factors)? {
        let over = factors.iter().zip(&values).map(|(factor, value)| format!("{}={value}", factor.pointer));
        let sets: Vec<String> = arguments.batch.sets.iter().cloned().chain(over).collect();
        let case = study.source.case(&sets).map_err(|error| of_over(error, &factors))?;
        points.push((values, case));
    }
    // Points are compared with each other, all on the mesh of their case.
    let of = match arguments.run {
        SweepKind::V50 => SweepOf::V50(v50_request(&arguments.batch, &arguments.thresholds)),
        SweepKind::Shots => SweepOf::Shots(ShotsRequest {
            count: arguments.thresholds.count.unwrap_or(1),
            velocity: None,
            until_width: arguments.batch.until_width,
            fit: fit_request(&arguments.batch),
        }),
    };
    let request = SweepRequest { factors, level: arguments.batch.print.level, of, points };
    let title = &study.case.title;
    study.compute("points", |options, folder| {
        let found = sweep::run(&request, options, folder, title)?;
        Ok((found.json(&request), found.report(&request, title), found.device))
    })
}

/// `ripstop fit`: a limit from a table of shots.
pub(crate) fn fit(arguments: &FitArguments) -> Result<(), CommandFailure> {
    let rows = fit::read(&arguments.data)?;
    let request = FitRequest { link: arguments.link, level: arguments.print.level };
    let computed = arguments.computed.as_deref().map(ComputedLimit::read).transpose()?;
    let found = Fit { computed, ..fit::fit(&rows, request) };
    let title = arguments.data.display().to_string();
    let report = found.report(&title);
    let write = |out: &Path| -> Result<Folder, CommandFailure> {
        let folder = Folder::prepare_for(out, &FIT_FILES, &[&arguments.data])?;
        let texts = [
            format!("{:#}\n", found.json()),
            report.svg(&title),
            report.html(&format!("Ballistic limit: {title}"), "fit.json"),
        ];
        folder.put(&FIT_FILES.into_iter().zip(texts).collect::<Vec<_>>(), &FIT_FILES)?;
        Ok(folder)
    };
    let written = arguments.out.as_deref().map(write).transpose()?;
    let print = &arguments.print;
    let folder = written.as_ref().map_or_else(String::new, |folder| files(folder.path(), &FIT_FILES));
    terminal::show(print.json, print.quiet, || found.json(), || text(&report) + &folder)
}

impl From<StudyError> for CommandFailure {
    fn from(error: StudyError) -> Self {
        Self::input(error.to_string())
    }
}

fn fit_request(arguments: &BatchArguments) -> FitRequest {
    FitRequest { link: Link::Probit, level: arguments.print.level }
}

fn v50_request(arguments: &BatchArguments, thresholds: &ThresholdArguments) -> V50Request {
    V50Request {
        count: thresholds.count.unwrap_or(COUNT),
        until_width: arguments.until_width.or(thresholds.count.is_none().then_some(WIDTH)),
        bracket: thresholds.bracket,
        refined: 0,
        level: arguments.print.level,
    }
}

/// Arguments of `ripstop run` for one shot.
fn run_arguments(arguments: &BatchArguments) -> RunArguments {
    RunArguments {
        cases: vec![arguments.case.clone()],
        backend: arguments.backend(),
        out: None,
        sets: Vec::new(),
        threads: arguments.threads,
        no_skip: Vec::new(),
        no_report: false,
        frames: None,
        checkpoint_every: None,
        quiet: arguments.print.quiet,
        json: arguments.print.json,
    }
}

/// Error of a value of `--over`, which is a change of the case like those of `--set`.
fn of_over(mut error: CaseError, factors: &[Factor]) -> CaseError {
    let of_set = error.of_set();
    if let Some(Factor { pointer, .. }) = factors.iter().find(|factor| of_set == Some(&factor.pointer)) {
        error.location = format!("--over {pointer}");
        if error.found.starts_with("a list") {
            let help = format!("values stand without brackets: --over {pointer}=1,2");
            error.help.get_or_insert(help);
        }
    }
    error.next = error.next.map(|next| Box::new(of_over(*next, factors)));
    error
}

/// Study of a case that is about to be computed.
struct Study<'a> {
    arguments: &'a BatchArguments,
    command: &'static str,
    /// Names of its files.
    files: &'static [&'static str],
    source: Source<'a>,
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
        let source = Source::open(&arguments.case)?;
        let case = source.case(&arguments.sets)?;
        if case.projectile.is_none() {
            return Err(CommandFailure::expected(source.name(), "a projectile, to be shot", "none in the case"));
        }
        Ok(Self { arguments, command, files, source, case, interrupted })
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
        work: impl FnOnce(&BatchOptions<'_>, &Folder) -> Result<(Value, Report, DeviceUse), BatchError>,
    ) -> Result<(), CommandFailure> {
        let (arguments, out) = (self.arguments, self.out());
        let chosen = backend::choose(&arguments.backend())?;
        chosen.note.iter().filter(|_| !arguments.print.quiet).for_each(|note| terminal::complain(note));
        let folder = Folder::prepare_for(&out, self.files, &[self.case.path.as_path()])?;
        let bar = StudyBar {
            name: self.command,
            units,
            bar: Bar::new(!arguments.print.quiet),
            start: Instant::now(),
            known: Mutex::default(),
        };
        let options = BatchOptions {
            seed: self.seed(),
            threads: threads(arguments.threads),
            threads_per_shot: 1,
            precision: chosen.precision,
            device: chosen.device.as_ref(),
            interrupt: &self.interrupted,
            resume: arguments.resume,
            progress: &|at| bar.show(at),
        };
        let done = work(&options, &folder);
        bar.bar.clear();
        let (json, report, device) = done.map_err(|error| failure(error, &out))?;
        let names = self.files.iter().copied().chain(["points/"]).filter(|name| out.join(name).exists());
        let names: Vec<&str> = names.collect();
        let printed = || text(&report) + &device_text(device) + &files(&out, &names);
        terminal::show(arguments.print.json, arguments.print.quiet, || json, printed)
    }
}

/// Number of threads asked for, one for each core otherwise.
pub(crate) fn threads(asked: Option<usize>) -> usize {
    asked.unwrap_or_else(|| thread::available_parallelism().map_or(1, NonZero::get))
}

/// Message of a batch that did not end; `folder`: of its rows.
fn failure(error: BatchError, folder: &Path) -> CommandFailure {
    match error {
        BatchError::Output(error) => error.into(),
        BatchError::Study(error) => error.into(),
        BatchError::Device(error) => CommandFailure::device(&error),
        BatchError::Interrupted => CommandFailure::interrupted(format!(
            "interrupted; rows so far: {}\n  help: the same command with --resume goes on",
            folder.display()
        )),
    }
}

/// Progress bar with V50 and the time left.
struct StudyBar<'a> {
    name: &'static str,
    units: &'a str,
    bar: Bar,
    start: Instant,
    known: Mutex<Known>,
}

/// Number of shots that were there at the beginning, and V50 with its interval, as far as they are known.
#[derive(Default)]
struct Known {
    before: Option<u32>,
    v50: Option<(f64, Bounds)>,
}

impl StudyBar<'_> {
    fn show(&self, at: BatchProgress) {
        let BatchProgress { done, of, v50 } = at;
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let before = *known.before.get_or_insert(done.saturating_sub(1));
        known.v50 = v50.or(known.v50);
        let own = f64::from(done - before.min(done)).max(1.0);
        let left = duration(self.start.elapsed().as_secs_f64() / own * f64::from(of.saturating_sub(done)));
        let v50 = known.v50.map_or_else(String::new, |(value, bounds)| {
            let [low, high] = bounds.words();
            format!("  V50 {} m/s ({low} to {high})", short(value, 4))
        });
        self.bar.show_count(self.name, done as usize, of as usize, &format!("{}{v50}  ≤ {left} left", self.units));
    }
}

/// Report for the terminal.
fn text(report: &Report) -> String {
    let mut out = if report.title.is_empty() { String::new() } else { format!("{}\n", report.title) };
    report.counts.iter().for_each(|line| out += &format!("{}\n", terminal::wrapped(line, 0).join("\n")));
    for (n, line) in report.answer.iter().enumerate() {
        let at = if n == 0 { line.find(',').unwrap_or(line.len()) } else { 0 };
        let heading = if n == 0 { format!("\n{}", terminal::heading(&line[..at])) } else { String::new() };
        out += &format!("{heading}{}\n", &line[at..]);
    }
    out += &notes("look", &report.notes);
    out.extend(report.tables.iter().map(table));
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
    for row in of.rows.iter().take(MAX_ROWS) {
        let letters = |column: usize| if column + 1 == columns { MAX_LETTERS } else { usize::MAX };
        table.row(row.iter().enumerate().map(|(column, cell)| cell.chars().take(letters(column)).collect::<String>()));
    }
    let mut text = table.to_string();
    let more = of.rows.len().saturating_sub(MAX_ROWS);
    text.extend((more > 0).then(|| format!("… and {more} more\n")));
    text.extend(of.foot.lines().map(|line| format!("{line}\n")));
    if of.title.is_empty() { format!("\n{text}") } else { part(&of.title, &text) }
}

/// Use of the device; nothing where there was none.
fn device_text(used: DeviceUse) -> String {
    if used.shots == 0 {
        return String::new();
    }
    let each = |count: u64, of: u64| count as f64 / of as f64;
    format!(
        "GPU: {} shots, up to {} at a time; {} dispatches and {} a shot\n",
        used.shots,
        used.room,
        short(each(used.dispatches, used.shots), 4),
        bytes(each(used.bytes, used.room.max(1)))
    )
}
