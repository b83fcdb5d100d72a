//! `ripstop v50`: from a case to a ballistic limit.

use std::path::Path;

use ripstop::case::Case;
use ripstop::output::Folder;
use ripstop::output::number::short;
use ripstop::study::v50::{self, V50Progress, V50Request, V50Result};

use super::batch::{self, ShotBar};
use super::campaign_arguments::V50Arguments;
use super::failure::CommandFailure;
use super::fit::{arithmetic_table, ends, plot, quantile_cells, residual_table};
use super::input::Source;
use super::result::{self, part, remarks};
use super::run::Print;
use super::terminal::{self, Align, TextTable};

/// Half the width of the interval over V50 at which thresholds end where nothing else is asked for.
const WIDTH: f64 = 0.02;
/// Realisations where no count is asked for.
const COUNT: u32 = 64;
/// Realisations that are shot on the converged mesh too: of a case in which nothing varies, and of others.
const REFINED: [u32; 2] = [1, 4];

/// Fires, prints and writes.
pub(crate) fn v50(arguments: &V50Arguments) -> Result<(), CommandFailure> {
    let interrupted = terminal::watch_interrupts()?;
    let case = batch::case(&Source::open(&arguments.case)?, &arguments.batch)?;
    let chosen = batch::choose(&arguments.batch)?;
    let options = batch::options(&arguments.batch, &case, &chosen, &interrupted);
    let out = batch::out(arguments.out.as_deref(), &case, "v50");
    let request = request(arguments, &case);
    let folder = Folder::prepare_for(&out, v50::FILES, &[case.path.as_path()])?;
    let mut bar = ShotBar::new(!arguments.batch.quiet);
    let mut known = None;
    let mut show = |at: V50Progress<'_>| {
        known = at.last.and_then(|last| Some((last.v50?, last.bounds))).or(known);
        bar.show("v50", at.done, at.of, known);
    };
    let done = v50::run(&case, &request, &options, &folder, arguments.batch.resume, &mut show);
    bar.clear();
    let done = done.map_err(|error| batch::failure(error, &out))?;
    let print = Print::of(arguments.batch.json, arguments.batch.quiet);
    print.show(|| v50::json(&case, &request, options.seed, &done), || text(&case, &request, &done, folder.path()))
}

/// What the command line asks for.
pub(super) fn request(arguments: &V50Arguments, case: &Case) -> V50Request {
    V50Request {
        refined: arguments.refined.unwrap_or(REFINED[usize::from(case.varies())]),
        count: arguments.count.unwrap_or(COUNT),
        until_width: arguments.batch.until_width.or(arguments.count.is_none().then_some(WIDTH)),
        bracket: arguments.bracket,
        level: arguments.batch.level,
    }
}

/// The whole text.
fn text(case: &Case, request: &V50Request, found: &V50Result, folder: &Path) -> String {
    let mut out = format!("{}\n{}\n", case.title, counts(found));
    out += &answer(request, found);
    out += &remarks("look", &v50::notes(case, found));
    out += &part("velocity by chance of a perforation", &quantiles(request, found));
    out += &part("chance of a perforation", &curve(found)).replace("\n  \n", "\n\n");
    out += &part("arithmetic V50", &arithmetic(found));
    if !found.passed.is_empty() {
        out += &part("residual velocity", &residual_table(&found.residual));
    }
    let files: Vec<&str> = v50::FILES.iter().copied().filter(|name| folder.join(name).exists()).collect();
    out += &batch::device_text(found.device);
    out + &result::files(folder, &files)
}

/// How much was shot.
fn counts(found: &V50Result) -> String {
    let known = found.thresholds.iter().filter(|found| found.is_ok()).count();
    let of = found.thresholds.len();
    let [thresholds, realisations] = [(known, "threshold"), (of, "realisation")]
        .map(|(count, name)| format!("{count} {name}{}", if count == 1 { "" } else { "s" }));
    let finer = match found.refined_shots {
        0 => String::new(),
        count => format!(", {count} on the converged mesh"),
    };
    format!("{thresholds} of {realisations}, {} shots{finer}", found.shots)
}

/// V50 and σ, and what the interval is made of.
fn answer(request: &V50Request, found: &V50Result) -> String {
    let Some(v50) = found.v50 else { return format!("\n{}\n", terminal::heading("no V50")) };
    let level = short(100.0 * request.level, 3);
    let [low, high] = ends(found.bounds);
    let mut out = format!(
        "\n{}, {level} % interval {low} to {high} m/s\n",
        terminal::heading(&format!("V50 {} m/s", short(v50, 4)))
    );
    if let Some(sigma) = found.sigma {
        out += &format!("σ {} m/s\n", short(sigma, 3));
    }
    let metres = |width: f64| format!("± {} m/s", short(width, 2));
    let sampling = match found.width.sampling {
        Some(0.0) => "none".to_owned(),
        sampling => sampling.map_or_else(|| "no end".to_owned(), metres),
    };
    let (numerical, bracket) = (metres(found.width.numerical), metres(found.width.bracket));
    out + &format!("of that: sampling {sampling}, mesh and time step {numerical}, brackets {bracket}\n")
}

fn quantiles(request: &V50Request, found: &V50Result) -> String {
    use Align::{Left, Right};
    if found.quantiles.len() < 2 {
        return String::new();
    }
    let mut table = TextTable::new(&[("", Left), ("m/s", Right), ("low", Right), ("high", Right)]);
    let seen = |name: &str, velocity: Option<f64>, table: &mut TextTable| {
        if let Some(velocity) = velocity {
            table.row([name.to_owned(), short(velocity, 4), String::new(), String::new()]);
        }
    };
    let range = found.sample.map(|sample| sample.range);
    seen("V0, slowest seen", range.map(|range| range[0]), &mut table);
    for quantile in &found.quantiles {
        table.row(quantile_cells(format!("V{}", short(100.0 * quantile.p, 3)), quantile));
    }
    seen("V100, fastest seen", range.map(|range| range[1]), &mut table);
    format!("{table}{} % intervals of the sampling alone, likelihood ratio\n", short(100.0 * request.level, 3))
}

/// The curve, with the thresholds.
fn curve(found: &V50Result) -> String {
    let marks = [("", Vec::new()), ("thresholds", found.middles())];
    let all = || marks.iter().flat_map(|(_, at)| at.iter().copied());
    let range = [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)];
    let is_range = range[1] > range[0];
    if !is_range || found.probability(range[0]).is_none() {
        return String::new();
    }
    plot(range, |velocity| found.probability(velocity).unwrap_or(0.5), marks)
}

fn arithmetic(found: &V50Result) -> String {
    if found.ranged.len() < 2 {
        return String::new();
    }
    format!(
        "{}of an up-and-down of one shot at each realisation
",
        arithmetic_table(&found.arithmetic)
    )
}
