//! `ripstop bench`: run time against error.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, builder::RangedU64ValueParser};
use ripstop::case;
use ripstop::output::number::{fixed, fraction, short};
use ripstop::output::{self, Folder};
use ripstop::run::Progress;
use ripstop::run::outcome::Outcome;
use ripstop::study::bench::{self, BenchError, BenchPlan, BenchResult, BenchRow};

use super::arguments::{BackendArguments, BackendChoice};
use super::backend;
use super::failure::CommandFailure;
use super::input::tolerance;
use super::terminal::{self, Align, Bar, TextTable};

/// Name of the file written.
const FILE: &str = "bench.json";
/// The case that is built in: name and text.
const PAPER: (&str, &str) = ("s720-1ply-155", include_str!("../../cases/s720-1ply-155.json"));
/// Changes of every case: parts that take time or are checked but say nothing here, and would refuse a shorter run.
const LEFT_OUT: [&str; 2] = ["/expect=[]", "/output/profile_times_us=[]"];

/// `ripstop bench`
#[derive(Args, Debug)]
#[command(
    after_help = "Every case is run once as a reference (CPU, f64, Courant 0.25, one crossover per element), then as a user may
choose to run it: precision, Courant number, mesh, skips, GPU. The error is that of the velocity history against the
reference, over the velocity the projectile loses.

Examples:
  ripstop bench
  ripstop bench shot.json --tolerance 0.5% --repeat 3 --json | jq '.cases[].cheapest_within_tolerance'

DIR gets bench.json."
)]
pub(crate) struct BenchArguments {
    /// Case files [default: the paper's shot, cases/s720-1ply-155.json, built in]
    #[arg(value_name = "CASE.json")]
    cases: Vec<PathBuf>,
    /// Largest error of the velocity history, and of what is left or the stop time, that is good enough: 1% or 0.01
    #[arg(long, value_name = "ERROR", value_parser = tolerance, default_value = "1%", allow_hyphen_values = true)]
    tolerance: f64,
    /// Change of every case, checked like the file; may be given again
    #[arg(long = "set", value_name = "/POINTER=VALUE")]
    sets: Vec<String>,
    /// Whether the GPU is among the choices: auto takes real ones only
    #[arg(long, value_enum, default_value = "auto")]
    backend: BackendChoice,
    /// Graphics adapter, by part of its name or its number in `ripstop info` [default: the best]
    #[arg(long, value_name = "NAME|INDEX")]
    adapter: Option<String>,
    /// Worker threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    threads: Option<usize>,
    /// Runs of every choice, of which the shortest counts
    #[arg(long, value_name = "N", default_value = "1", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1000))]
    repeat: usize,
    /// Folder for the results
    #[arg(long, value_name = "DIR", default_value = "out/bench")]
    out: PathBuf,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
    /// Print bench.json instead of the tables
    #[arg(long)]
    json: bool,
}

/// Measures every case, writes `bench.json` and says which choice is the cheapest.
pub(crate) fn bench(arguments: &BenchArguments) -> Result<(), CommandFailure> {
    let start = Instant::now();
    let tolerance = arguments.tolerance;
    let interrupted = terminal::watch_interrupts()?;
    let paths: Vec<Option<&Path>> = match &arguments.cases[..] {
        [] => vec![None],
        cases => cases.iter().map(|path| Some(path.as_path())).collect(),
    };
    let read = |path: Option<&Path>, changes: &[String]| {
        let sets = LEFT_OUT.iter().map(ToString::to_string).chain([&arguments.sets, changes].concat());
        let sets: Vec<String> = sets.collect();
        path.map_or_else(|| case::from_str(PAPER.0, PAPER.1, &sets), |path| case::read(path, &sets))
    };
    for path in &paths {
        measurable(&read(*path, &[])?)?;
    }
    let (backend, adapter) = (arguments.backend, arguments.adapter.clone());
    let chosen = backend::choose(&BackendArguments { backend, adapter, precision: None })?;
    chosen.note.iter().filter(|_| !arguments.quiet).for_each(|note| terminal::complain(note));
    let folder = Folder::prepare_for(&arguments.out, &[FILE], &paths.iter().flatten().copied().collect::<Vec<_>>())?;
    let plan =
        BenchPlan { threads: arguments.threads, device: chosen.device.as_ref(), repeat: arguments.repeat, tolerance };
    let mut measured: Vec<BenchResult> = Vec::new();
    let mut failure = None;
    for path in paths {
        let bar = Bar::new(!arguments.quiet);
        let mut show = |name: &str, at: &Progress| bar.show_named(name, at);
        let one = bench::measure(&|changes| read(path, changes), plan, &interrupted, &mut show);
        bar.clear();
        match one {
            Ok(one) => measured.push(one),
            Err(BenchError::Case(error)) => failure = Some(error.into()),
            Err(BenchError::Run(error)) => {
                let name = path.map_or(PAPER.0.to_owned(), |path| path.display().to_string());
                failure = Some(CommandFailure::start(&name, &error));
            }
        }
        if failure.is_some() || measured.iter().any(|one| one.interrupted) {
            break;
        }
    }
    // Cases measured before are worth keeping.
    if let Some(failure) = failure.take_if(|_| measured.is_empty()) {
        folder.abandon();
        return Err(failure);
    }
    let report = bench::json(&measured, plan, start.elapsed().as_secs_f64());
    let written = folder.put(&[(FILE, format!("{report:#}\n"))], &[FILE]);
    let file = if written.is_ok() { format!("files  {}: {FILE}\n", folder.path().display()) } else { String::new() };
    let text = || measured.iter().map(|one| text(one, tolerance)).collect::<String>() + &file;
    terminal::show(arguments.json, arguments.quiet, || report.clone(), text)?;
    written?;
    failure.map_or_else(|| verdict(&measured, folder.path()), Err)
}

/// Refuses a case whose velocity history says nothing.
fn measurable(case: &case::Case) -> Result<(), CommandFailure> {
    if output::flies_freely(case) {
        return Ok(());
    }
    let place = format!("{}: /projectile", case.path.display());
    let expected = "a projectile that flies freely, whose velocity can be compared";
    let found = if case.projectile.is_some() { "one that is driven" } else { "none" };
    Err(CommandFailure::expected(place, expected, found).help("take a case with \"motion\": \"free\""))
}

fn percent(error: Option<f64>) -> String {
    error.map_or_else(|| "-".to_owned(), |error| format!("{} %", short(error * 100.0, 3)))
}

fn seconds(time: f64) -> String {
    format!("{} s", short(time, 3))
}

/// A number with its sign, zero without.
fn signed(value: f64) -> String {
    let sign = if value > 0.0 { "+" } else { "" };
    format!("{sign}{}", short(value, 3))
}

/// Table of one case, scatter of its reference, configurations left out, and the choice to take.
fn text(measured: &BenchResult, tolerance: f64) -> String {
    let run = &measured.reference;
    let end = if run.stop_time.is_some() { "stop time" } else { "velocity left" };
    let columns = ["", "choice", "loop s", "M el.-steps/s", "velocity", end, "energy error", "outcome"];
    let align = |name: &str| if ["", "choice", "outcome"].contains(&name) { Align::Left } else { Align::Right };
    let mut table = TextTable::new(&columns.map(|name| (name, align(name))));
    for row in &measured.rows {
        table.row(cells(row));
    }
    let reached = match (run.outcome, run.stop_time) {
        (Outcome::Stopped | Outcome::Rebounded, Some(time)) => format!("at {} µs", fixed(time * 1e6, 1)),
        _ => format!("{} m/s left", short(output::residual_velocity(&measured.case, run).unwrap_or(0.0), 6)),
    };
    let mut out = format!(
        "{}\n\nreference: {}\n  {}, {reached}, {} of loop\n\n{table}\n\
         errors against the reference; !: another outcome\n",
        measured.case.title,
        bench::REFERENCE,
        run.outcome.word(),
        seconds(run.loop_seconds),
    );
    if let Some(scatter) = measured.scatter {
        let meaning = match scatter > tolerance {
            true => "more than asked for: below it the shot itself scatters, and errors rank nothing",
            false => "errors below it rank nothing",
        };
        let scatter = percent(Some(scatter));
        out += &format!("a second reference, with a time step a fifth longer, differs by {scatter}: {meaning}\n");
    }
    for (name, reason) in &measured.skipped {
        out += &format!("left out: {name}: {reason}\n");
    }
    let asked = format!("velocities and end within {} %", short(tolerance * 100.0, 3));
    match measured.cheapest.map(|at| &measured.rows[at]) {
        Some(row) => {
            let (name, time, error) = (&row.configuration.name, seconds(row.time()), percent(row.velocity_error()));
            out + &format!("cheapest with {asked}: {name} ({time}, {error})\n\n")
        }
        None => out + &format!("no choice has the reference's outcome and {asked}\n\n"),
    }
}

fn cells(row: &BenchRow) -> [String; 8] {
    let end = match row.errors.map(|errors| (errors.stop_time, errors.residual_velocity)) {
        Some((Some(time), _)) => format!("{} µs", signed(time * 1e6)),
        Some((None, velocity)) => format!("{} m/s", signed(velocity)),
        None => "-".to_owned(),
    };
    let outcome = match (&row.run.divergence, &row.run.lost) {
        (Some(_), _) => "unstable",
        (_, Some(_)) => "device lost",
        _ => row.run.outcome.word(),
    };
    [
        if row.same_outcome { "" } else { "!" }.to_owned(),
        row.configuration.name.clone(),
        short(row.time(), 3),
        fixed(row.rate() / 1e6, 1),
        percent(row.velocity_error()),
        end,
        fraction(row.run.energy_error),
        outcome.to_owned(),
    ]
}

/// Exit code of what was measured.
fn verdict(measured: &[BenchResult], folder: &Path) -> Result<(), CommandFailure> {
    if measured.iter().any(|one| one.interrupted) {
        let folder = folder.display();
        return Err(CommandFailure::interrupted(format!("interrupted; what was measured until then: {folder}")));
    }
    let unstable = measured.iter().find_map(|one| Some((one, one.reference.divergence.as_ref()?)));
    unstable.map_or(Ok(()), |(one, divergence)| {
        Err(CommandFailure::check(format!(
            "error: {}: the reference became unstable\n  where: {}\n  found: {}",
            one.case.name,
            output::place(divergence),
            divergence.quantity
        )))
    })
}
