//! `ripstop bench`: run time against error.

use std::path::Path;
use std::time::Instant;

use ripstop::gpu::{self, Device};
use ripstop::output::number::{fixed, fraction, short};
use ripstop::output::{self, Folder};
use ripstop::run::Progress;
use ripstop::run::outcome::Outcome;
use ripstop::study::bench::{self, BenchError, BenchPlan, BenchResult, BenchRow, CaseSource};

use super::arguments::{BackendArguments, BackendChoice};
use super::failure::CommandFailure;
use super::progress::Bar;
use super::study_arguments::BenchArguments;
use super::table::{Align, TextTable};
use super::{backend, interrupt, screen};

/// What is written.
const FILES: [&str; 2] = ["bench.json", "bench.svg"];

/// Measures every case, writes `bench.json` and `bench.svg` and says which choice is the cheapest.
pub(crate) fn bench(arguments: &BenchArguments) -> Result<(), CommandFailure> {
    let start = Instant::now();
    let tolerance = tolerance(&arguments.tolerance)?;
    let interrupted = interrupt::watch()?;
    let subjects = subjects(arguments)?;
    let (device, note) = device(arguments)?;
    let read: Vec<&Path> = arguments.cases.iter().map(|path| path.as_path()).collect();
    let folder = Folder::prepare_for(&arguments.out, &FILES, &read)?;
    if let Some(note) = note.filter(|_| !arguments.quiet) {
        screen::complain(&note);
    }
    let plan = BenchPlan { threads: arguments.threads, device: device.as_ref(), repeat: arguments.repeat, tolerance };
    let mut measured: Vec<BenchResult> = Vec::new();
    let mut failure = None;
    for subject in &subjects {
        if measured.iter().any(|one| one.interrupted) {
            break;
        }
        let bar = Bar::new(!arguments.quiet);
        let mut show = |name: &str, at: &Progress| bar.show_named(name, at);
        let one = bench::measure(subject, plan, &interrupted, &mut show);
        bar.clear();
        match one {
            Ok(one) => measured.push(one),
            Err(error) => {
                failure = Some(failed(subject, error));
                break;
            }
        }
    }
    // What was measured before is worth keeping.
    if let Some(failure) = failure.take_if(|_| measured.is_empty()) {
        folder.abandon();
        return Err(failure);
    }
    let report = bench::report::json(&measured, plan, start.elapsed().as_secs_f64());
    let texts = [(FILES[0], format!("{report:#}\n")), (FILES[1], bench::plot::plot(&measured, tolerance))];
    let written = folder.put(&texts, &FILES);
    if arguments.json {
        screen::print(&format!("{report:#}\n"))?;
    } else if !arguments.quiet {
        for one in &measured {
            screen::print(&text(one, tolerance))?;
        }
        if let Ok(names) = &written {
            screen::print(&format!("files  {}: {}\n", folder.path().display(), names.join(", ")))?;
        }
    }
    written?;
    failure.map_or_else(|| verdict(&measured, folder.path()), Err)
}

/// The cases, all of them read before anything is run.
fn subjects(arguments: &BenchArguments) -> Result<Vec<CaseSource>, CommandFailure> {
    let sets = &arguments.sets;
    let files = arguments.cases.iter().map(|path| CaseSource::file(path.clone(), sets));
    let subjects: Vec<CaseSource> =
        if arguments.cases.is_empty() { vec![CaseSource::paper(sets)] } else { files.collect() };
    for subject in &subjects {
        let case = subject.case(&[])?;
        if !bench::is_measurable(&case) {
            let place = format!("{}: /projectile", subject.name());
            let expected = "a projectile that flies freely, whose velocity can be compared";
            let found = if case.projectile.is_some() { "one that is driven" } else { "none" };
            let help = "take a case with \"motion\": \"free\"";
            return Err(CommandFailure::expected(place, expected, found).help(help));
        }
    }
    Ok(subjects)
}

/// The graphics processor among the choices, and why there is none where one might be expected.
fn device(arguments: &BenchArguments) -> Result<(Option<Device>, Option<String>), CommandFailure> {
    if arguments.backend != BackendChoice::Auto || arguments.adapter.is_some() {
        let asked =
            BackendArguments { backend: arguments.backend, adapter: arguments.adapter.clone(), precision: None };
        return Ok((backend::choose(&asked)?.device, None));
    }
    let adapters = gpu::adapters();
    let opened = backend::automatic(&adapters).map_err(str::to_owned);
    let opened = opened.and_then(|adapter| Device::open(adapter).map_err(|error| error.to_string()));
    Ok(match opened {
        Ok(device) => (Some(device), None),
        Err(why) => (None, Some(format!("note: the GPU is not among the choices: {why}"))),
    })
}

fn failed(subject: &CaseSource, error: BenchError) -> CommandFailure {
    match error {
        BenchError::Case(error) => error.into(),
        BenchError::Run(error) => CommandFailure::start(&subject.name(), &error),
    }
}

/// `1%` or `0.01`, as a fraction.
fn tolerance(text: &str) -> Result<f64, CommandFailure> {
    let (number, scale) = match text.trim().strip_suffix('%') {
        Some(number) => (number.trim_end(), 100.0),
        None => (text.trim(), 1.0),
    };
    let value = number.parse::<f64>().map(|number| number / scale);
    value.ok().filter(|value| *value > 0.0 && *value <= 1.0).ok_or_else(|| {
        let expected = "an error above 0 and at most 100%, as a percentage or a fraction";
        let help = "for example --tolerance 1% or --tolerance 0.01";
        CommandFailure::expected("--tolerance", expected, format!("{text:?}")).help(help)
    })
}

fn percent(error: Option<f64>) -> String {
    error.map_or_else(|| "-".to_owned(), |error| format!("{} %", short(error * 100.0, 3)))
}

/// The table of one case and what follows from it.
fn text(measured: &BenchResult, tolerance: f64) -> String {
    use Align::{Left, Right};
    let end = if measured.reference.stop_time.is_some() { "stop time" } else { "velocity left" };
    let mut table = TextTable::new(&[
        ("", Left),
        ("choice", Left),
        ("loop s", Right),
        ("M el.-steps/s", Right),
        ("velocity", Right),
        (end, Right),
        ("deflection", Right),
        ("tension", Right),
        ("energy error", Right),
        ("outcome", Left),
    ]);
    for row in &measured.rows {
        table.row(cells(row));
    }
    let run = &measured.reference;
    let reached = match (run.outcome, run.stop_time) {
        (Outcome::Stopped | Outcome::Rebounded, Some(time)) => format!("at {} µs", fixed(time * 1e6, 1)),
        _ => format!("{} m/s left", short(output::residual_velocity(&measured.case, run).unwrap_or(0.0), 6)),
    };
    let mut out = format!(
        "{}\n\nreference: {}\n  {}, {reached}, {} of loop\n\n{table}\n\
         errors against the reference; *: nothing is both faster and more accurate; !: another outcome\n",
        measured.case.title,
        bench::REFERENCE,
        run.outcome.word(),
        seconds(run.loop_seconds),
    );
    out += &conclusion(measured, tolerance);
    out
}

/// How far the errors can be told apart, what was not run, and the choice to take.
fn conclusion(measured: &BenchResult, tolerance: f64) -> String {
    let mut out = String::new();
    if let Some(scatter) = measured.scatter() {
        let meaning = if scatter > tolerance {
            "more than asked for: below it the shot itself scatters, and errors rank nothing"
        } else {
            "errors below it rank nothing"
        };
        let scatter = percent(Some(scatter));
        out += &format!("a second reference, with a time step a fifth longer, differs by {scatter}: {meaning}\n");
    }
    for skipped in &measured.skipped {
        out += &format!("left out: {}: {}\n", skipped.name, skipped.reason);
    }
    let asked = format!("velocities and end within {} %", short(tolerance * 100.0, 3));
    match measured.cheapest.map(|at| &measured.rows[at]) {
        Some(row) => {
            let (name, time, error) = (&row.choice.name, seconds(row.time()), percent(row.velocity_error()));
            out += &format!("cheapest with {asked}: {name} ({time}, {error})\n");
            out.push('\n');
        }
        None => out += &format!("no choice has the reference's outcome and {asked}\n\n"),
    }
    out
}

fn seconds(time: f64) -> String {
    format!("{} s", short(time, 3))
}

fn cells(row: &BenchRow) -> [String; 10] {
    let errors = row.errors.as_ref();
    let end = match errors.and_then(|errors| errors.stop_time) {
        Some(time) => format!("{} µs", signed(time * 1e6)),
        None => errors.map_or_else(|| "-".to_owned(), |errors| format!("{} m/s", signed(errors.residual_velocity))),
    };
    let outcome = match (&row.run.divergence, &row.run.lost) {
        (Some(_), _) => "unstable",
        (_, Some(_)) => "device lost",
        _ => row.run.outcome.word(),
    };
    let mark = match (row.on_front, row.same_outcome) {
        (true, true) => "*",
        (true, false) => "*!",
        (false, true) => "",
        (false, false) => "!",
    };
    [
        mark.to_owned(),
        row.choice.name.clone(),
        short(row.time(), 3),
        fixed(row.rate() / 1e6, 1),
        percent(row.velocity_error()),
        end,
        percent(errors.and_then(|errors| errors.deflection)),
        percent(errors.and_then(|errors| errors.tension)),
        fraction(row.run.energy_error),
        outcome.to_owned(),
    ]
}

/// With its sign, zero without.
fn signed(value: f64) -> String {
    let sign = if value > 0.0 { "+" } else { "" };
    format!("{sign}{}", short(value, 3))
}

/// What the exit code says.
fn verdict(measured: &[BenchResult], folder: &Path) -> Result<(), CommandFailure> {
    if measured.iter().any(|one| one.interrupted) {
        return Err(CommandFailure::interrupted(format!(
            "interrupted; what was measured until then: {}",
            folder.display()
        )));
    }
    match measured.iter().find_map(|one| Some((one, one.reference.divergence.as_ref()?))) {
        Some((one, trouble)) => Err(CommandFailure::check(format!(
            "error: {}: the reference became unstable\n  where: {}\n  found: {}",
            one.case.name,
            output::place(trouble),
            trouble.quantity
        ))),
        None => Ok(()),
    }
}
