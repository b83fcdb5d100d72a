//! `ripstop bench`, run time against error, and `ripstop verify`, the shipped cases on this machine: closed forms, hard scenes, a run of an
//! independent prototype.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use clap::Args;
use ripstop::case;
use ripstop::model::Model;
use ripstop::num::simd::Vectors;
use ripstop::output::expect::{expected, got, quantity};
use ripstop::output::number::{fixed, fraction, short};
use ripstop::output::{self, Folder};
use ripstop::run::{self, Options, Precision, Progress};
use ripstop::study::bench;
use serde_json::{Value, json};

use super::arguments::{Backend, BackendArguments, BackendChoice, PrintArguments};
use super::terminal::{self, Align, CommandFailure, TextTable};

/// Name of the file that `bench` writes.
const FILE: &str = "bench.json";
/// Name of the file that `bench --gpu` writes.
const GPU_FILE: &str = "gpu.json";
/// Changes of every case: parts that take time or are checked but say nothing here, and would refuse a shorter run.
const LEFT_OUT: [&str; 2] = ["/expect=[]", "/output/profile_times_us=[]"];

macro_rules! cases {
    ($($name:literal)*) => { [$(($name, include_str!(concat!("../../cases/", $name, ".json")))),*] };
}

/// Name and text of every case that `verify` runs.
const CASES: [(&str, &str); 36] = cases! {
    "verify/smith-yarn-155" "verify/smith-yarn-sheet" "verify/smith-yarn-curve" "verify/rate-of-strain"
    "verify/strip-uncrimped-155" "verify/strip-crimped-155" "verify/strip-compressible-155"
    "verify/strip-compressible-250" "verify/strip-pulled-weft-free" "verify/strip-pulled-weft-held"
    "verify/membrane-frequency" "verify/cone-on-membrane" "verify/mass-on-strip" "verify/first-drop" "verify/free-flight"
    "verify/free-impact" "verify/mirror" "verify/s720-prototype" "verify/mass-on-drum" "verify/corner-clamps" "verify/standoff"
    "verify/clay-drop" "verify/turned-in-window" "verify/turned-swap"
    "stress/light-projectile" "stress/heavy-courant-0.99" "stress/oblique-tip" "stress/spinning-fragment" "stress/thick-pack"
    "stress/pretension-free-edges" "stress/no-crimp" "stress/large-crimp" "stress/rigid-crossovers" "stress/one-yarn-absent"
    "stress/one-element" "stress/everything-erodes"
};

/// `ripstop bench`
#[derive(Args, Debug)]
#[command(after_help = "Example:
  ripstop bench shot.json --json | jq '.cases[].choices[] | {name, loop_s, velocity_error_percent}'

The error is that of the velocity history against a reference (CPU, f64, Courant 0.25, one crossover per element), over the velocity that \
the projectile loses. DIR gets bench.json.

With --gpu the case is packed 1 to 50 plies deep, on an even mesh, and shot 64 and 1000 times at once; a short run of each gives the time of \
a step. Nothing is skipped. DIR gets gpu.json.")]
pub(crate) struct BenchArguments {
    /// Case files
    #[arg(value_name = "CASE.json", required = true)]
    cases: Vec<PathBuf>,
    /// Time of a step on the graphics adapter, beside the processor
    #[arg(long)]
    gpu: bool,
    #[command(flatten)]
    backend: BackendArguments,
    /// Folder for the results
    #[arg(long, value_name = "DIR", default_value = "out/bench")]
    out: PathBuf,
    #[command(flatten)]
    print: PrintArguments,
}

/// `ripstop verify`
#[derive(Args, Debug)]
#[command(after_help = "Example:
  ripstop verify --backend gpu --json | jq '.rows[] | select(.pass | not)'

The cases are those of cases/verify and cases/stress, built in. The exit code is 1 if an expectation fails.")]
pub(crate) struct VerifyArguments {
    #[command(flatten)]
    backend: BackendArguments,
    /// Number type of the state [default: f64 on the CPU, f32 on a GPU, which has no other]
    #[arg(long, value_enum)]
    precision: Option<Precision>,
    #[command(flatten)]
    print: PrintArguments,
}

/// Measures every case and writes `bench.json`.
pub(crate) fn bench(arguments: &BenchArguments) -> Result<(), CommandFailure> {
    let start = Instant::now();
    let interrupted = terminal::watch_interrupts()?;
    let paths: Vec<&Path> = arguments.cases.iter().map(PathBuf::as_path).collect();
    let read = |path: &Path, changes: &[String]| case::read(path, &[&LEFT_OUT.map(str::to_owned), changes].concat());
    let usual = if arguments.gpu { BackendChoice::Gpu } else { BackendChoice::Auto };
    let chosen = Backend::choose(&arguments.backend, usual, None, &arguments.print)?;
    if arguments.gpu {
        for path in &paths {
            read(path, &[])?;
        }
        if chosen.device.is_none() {
            return Err(CommandFailure::expected("--gpu", "a graphics adapter", "--backend cpu or none found"));
        }
    } else {
        let (mut runs, mut seconds) = (0, 0.0);
        for path in &paths {
            for (case, skips) in bench::plan(&|changes| read(path, changes), chosen.device.is_some())? {
                let model = Model::<f64>::part(&case).map_err(|error| error.in_file(&path.display().to_string()))?;
                let elements = if skips.symmetry { model.elements() } else { model.whole_elements() };
                runs += 1;
                seconds += output::run_time(model.plies.len(), elements, case.solver.end_time / model.dt);
            }
        }
        terminal::say(&arguments.print, &format!("note: {runs} runs, {} at most", terminal::duration(seconds)));
    }
    let (file, text): (_, fn(&Value) -> String) = if arguments.gpu { (GPU_FILE, device_text) } else { (FILE, text) };
    let folder = Folder::prepare_for(&arguments.out, &[file], &paths)?;
    let options = chosen.options(arguments.backend.threads);
    let mut measured: Vec<Value> = Vec::new();
    terminal::begin_bar(&arguments.print);
    for path in paths {
        let read = |changes: &[String]| read(path, changes);
        let one = match &chosen.device {
            Some(device) if arguments.gpu => {
                bench::measure_device(&read, device, arguments.backend.threads, &interrupted, &mut terminal::show_run)
            }
            _ => bench::measure(&read, options, &interrupted, &mut terminal::show_run),
        };
        measured.push(one.map_err(|error| CommandFailure::start(&path.display().to_string(), error))?);
        if interrupted.load(Ordering::Relaxed) {
            break;
        }
    }
    terminal::end_bar();
    let report = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "threads": arguments.backend.threads,
        "vectors": Vectors::widest().name(),
        "adapter": chosen.device.as_ref().map(|device| device.name()),
        "wall_s": start.elapsed().as_secs_f64(),
        "interrupted": interrupted.load(Ordering::Relaxed),
        "cases": measured,
    });
    folder.put(&[(file, format!("{report:#}\n"))], &[])?;
    let files = || format!("files  {}: {file}\n", folder.path().display());
    let texts = || measured.iter().map(text).collect::<String>() + &files();
    terminal::show(&arguments.print, &report, texts)?;
    if interrupted.load(Ordering::Relaxed) {
        let words = format!("interrupted; what was measured until then: {}", folder.path().display());
        return Err(CommandFailure::interrupted(words));
    }
    let failed = measured.iter().find_map(|one| Some((&one["case"], one["reference"]["failed"].as_str()?)));
    failed.map_or(Ok(()), |(case, why)| {
        Err(CommandFailure::check(format!("error: {}: the reference did not end\n  found: {why}", word(case))))
    })
}

/// Word of a cell of `bench.json`.
fn word(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// Lines of what was left out, each with its reason.
fn left_out(rows: &Value) -> String {
    let line = |row: &Value| format!("left out: {}: {}\n", word(&row["name"]), word(&row["reason"]));
    rows.as_array().into_iter().flatten().map(line).collect()
}

fn percent(error: &Value) -> String {
    error.as_f64().map_or_else(|| "-".to_owned(), |error| format!("{} %", short(error, 3)))
}

/// Table of one case, scatter of its reference, and configurations left out.
fn text(measured: &Value) -> String {
    use Align::{Left, Right};
    let mut table = TextTable::plain(&[Left, Right, Right, Right, Right, Left]);
    table.row(["choice", "loop s", "M el.-steps/s", "velocity", "energy error", "outcome"]);
    for row in measured["choices"].as_array().into_iter().flatten() {
        let other = if row["same_outcome"] == true { "" } else { " !" };
        let outcome = row["failed"].as_str().map_or_else(|| format!("{}{other}", word(&row["outcome"])), str::to_owned);
        table.row([
            word(&row["name"]).to_owned(),
            short(number(&row["loop_s"]), 3),
            fixed(number(&row["element_steps_per_s"]) / 1e6, 1),
            percent(&row["velocity_error_percent"]),
            fraction(number(&row["energy_error"])),
            outcome,
        ]);
    }
    let reference = &measured["reference"];
    let [title, name, outcome] = [&measured["title"], &reference["name"], &reference["outcome"]].map(word);
    let seconds = short(number(&reference["loop_s"]), 3);
    let scatter = percent(&reference["scatter_percent"]);
    format!(
        "{title}\n\nreference: {name}\n  {outcome}, {seconds} s of loop\n\n{table}\n\
         errors against the reference; !: another outcome\n\
         a second reference, with a time step a fifth longer, differs by {scatter}: errors below it rank nothing\n{}\n",
        left_out(&measured["skipped"])
    )
}

/// Table of the scenes on a device, and its floors.
fn device_text(measured: &Value) -> String {
    use Align::{Left, Right};
    let millions = |rate: &Value| rate.as_f64().map_or_else(|| "-".to_owned(), |rate| fixed(rate / 1e6, 1));
    let mut table = TextTable::plain(&[Left, Right, Right, Right, Right, Left]);
    table.row(["scene", "elements", "step µs", "M el.-steps/s", "on the CPU", "kernels µs"]);
    for scene in measured["scenes"].as_array().into_iter().flatten() {
        let kernels = scene["kernels"].as_array().into_iter().flatten();
        let kernels = kernels.map(|kernel| format!("{} {}", word(&kernel["name"]), short(number(&kernel["us"]), 3)));
        table.row([
            word(&scene["name"]).to_owned(),
            fixed(number(&scene["elements"]), 0),
            short(number(&scene["step_us"]), 3),
            millions(&scene["element_steps_per_s"]),
            millions(&scene["cpu"]["element_steps_per_s"]),
            kernels.collect::<Vec<_>>().join(", "),
        ]);
    }
    let floors = [
        "copy_gb_per_s",
        "dispatch_us",
        "storage_barrier_us",
        "workgroup_barrier_us",
        "dependent_read_us",
        "host_us_per_step",
    ];
    let [copy, dispatch, storage, workgroup, read, host] = floors.map(|name| short(number(&measured[name]), 3));
    format!(
        "{}\n\n{table}\na kernel copies {copy} GB/s; a dispatch takes {dispatch} µs at least, a barrier of storage {storage} µs, of a workgroup \
         {workgroup} µs, a read that waits for another {read} µs; the host records a step in {host} µs\n{}\n",
        word(&measured["device"]),
        left_out(&measured["left_out"])
    )
}

/// Runs every case and prints a line for each expectation; exit code 1 if one fails.
pub(crate) fn verify(arguments: &VerifyArguments) -> Result<(), CommandFailure> {
    let interrupted = terminal::watch_interrupts()?;
    let chosen = Backend::choose(&arguments.backend, BackendChoice::Auto, arguments.precision, &arguments.print)?;
    terminal::begin_bar(&arguments.print);
    let mut rows: Vec<Value> = Vec::new();
    for (name, text) in CASES {
        let checks = expectations(name, text, chosen.options(arguments.backend.threads), &interrupted);
        let failed = |why| vec![json!({"quantity": "outcome", "expected": "a result", "got": why, "pass": false})];
        rows.extend(checks.unwrap_or_else(failed).into_iter().map(|mut check| {
            check["name"] = name.into();
            check
        }));
        if interrupted.load(Ordering::Relaxed) {
            break;
        }
    }
    terminal::end_bar();
    let failed = rows.iter().filter(|row| row["pass"] != true).count();
    let counts = format!("{} of {} rows pass", rows.len() - failed, rows.len());
    let report = json!({ "pass": failed == 0, "rows": rows });
    terminal::show(&arguments.print, &report, || {
        use Align::{Left, Right};
        let mut table = TextTable::plain(&[Left, Left, Left, Right, Right]);
        table.row(["", "case", "quantity", "expected", "got"]);
        for row in &rows {
            let name = row["name"].as_str().unwrap_or_default().to_owned();
            table.row([terminal::mark(row["pass"] == true), name, quantity(row), expected(row), got(row)]);
        }
        format!("{table}\n{counts}\n")
    })?;
    if interrupted.load(Ordering::Relaxed) {
        return Err(CommandFailure::interrupted("interrupted; rows after this are missing"));
    }
    if failed > 0 { Err(CommandFailure::check(format!("error: verification: {counts}"))) } else { Ok(()) }
}

/// Expectations of a case, each with what its run gave, as `summary.json` has them; none of an interrupted run. Or why there is no result.
fn expectations(name: &str, text: &str, options: Options<'_>, interrupt: &AtomicBool) -> Result<Vec<Value>, String> {
    let case = case::from_str(name, text, &[]).map_err(|error| error.to_string())?;
    let mut show = |at: &Progress| terminal::show_run(name, at);
    let run = run::run(&case, options, interrupt, &mut show).map_err(|error| error.to_string())?;
    if let Some(divergence) = &run.divergence {
        return Err(format!("unstable at {}: {}", output::place(divergence), divergence.quantity));
    }
    if let Some(reason) = &run.lost {
        return Err(format!("device lost at {}: {reason}", output::reached(&run)));
    }
    let checked = output::check(&case, &run, &output::summary(&case, &run, 0.0));
    Ok(if run.interrupted { Vec::new() } else { checked })
}
