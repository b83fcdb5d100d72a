//! `ripstop fit`: from shots to a ballistic limit.

use std::path::Path;

use ripstop::output::Folder;
use ripstop::output::number::short;
use ripstop::study::StudyError;
use ripstop::study::arithmetic_v50::{Arithmetic, Refusal, Rule};
use ripstop::study::binary_response::Method;
use ripstop::study::fit::{self, ComputedLimit, Fit, FitRequest, Quantile};
use ripstop::study::interval::{Bounds, Interval};
use ripstop::study::outcomes::Group;
use ripstop::study::residual_fit::{ResidualFit, ResidualModel, TooFew};

use super::campaign_arguments::FitArguments;
use super::failure::CommandFailure;
use super::result::{files, part, remarks};
use super::run::Print;
use super::terminal::{self, Align, TextTable};

/// What is written.
const FILES: [&str; 3] = ["fit.json", "fit.svg", "fit.html"];
/// Columns and rows of the curve on the terminal.
const COLUMNS: usize = 61;
const ROWS: usize = 9;

/// Fits, prints and writes.
pub(crate) fn fit(arguments: &FitArguments) -> Result<(), CommandFailure> {
    let rows = fit::read(&arguments.data)?;
    let request = FitRequest { link: arguments.link, level: arguments.level, interval: arguments.interval };
    let computed = arguments.computed.as_deref().map(ComputedLimit::read).transpose()?;
    let found = Fit { computed, ..fit::fit(&rows, request) };
    let written = arguments.out.as_deref().map(|out| write(out, &arguments.data, &found)).transpose()?;
    let print = Print::of(arguments.json, arguments.quiet);
    print.show(|| fit::json(&found), || text(&arguments.data, &found, written.as_ref()))
}

impl From<StudyError> for CommandFailure {
    fn from(error: StudyError) -> Self {
        Self::input(error.to_string())
    }
}

fn write(out: &Path, data: &Path, found: &Fit) -> Result<Folder, CommandFailure> {
    let folder = Folder::prepare_for(out, &FILES, &[data])?;
    let title = data.display().to_string();
    let texts = [format!("{:#}\n", fit::json(found)), fit::svg(found, &title), fit::html(found, &title)];
    let texts: Vec<(&str, String)> = FILES.into_iter().zip(texts).collect();
    folder.put(&texts, &FILES)?;
    Ok(folder)
}

/// The whole text.
pub(crate) fn text(data: &Path, found: &Fit, folder: Option<&Folder>) -> String {
    let [perforated, stopped] = found.outcomes.counts();
    let shots = perforated + stopped;
    let mut out = format!("{}: {shots} shots, {perforated} perforated, {stopped} stopped\n", data.display());
    out += &format!("{}\n", terminal::wrapped(&zone(found), 0).join("\n"));
    out += &answer(found);
    out += &remarks("look", &fit::notes(found));
    out += &part("velocity by chance of a perforation", &quantiles(found));
    if found.estimate.is_ok() {
        // No blanks on a line where nothing is drawn.
        out += &part("chance of a perforation", &curve(found)).replace("\n  \n", "\n\n");
    }
    out += &part("arithmetic V50", &arithmetic_table(&found.arithmetic));
    out += &part("residual velocity", &residual_table(&found.residual));
    out + &folder.map_or_else(String::new, |folder| files(folder.path(), &FILES))
}

/// Where results are mixed, or how far apart they are.
fn zone(found: &Fit) -> String {
    match (found.outcomes.slowest_perforation(), found.outcomes.fastest_stop()) {
        (Some(perforation), Some(stop)) => {
            let [perforation, stop] = [perforation, stop].map(|velocity| short(velocity, 4));
            let mixed = if found.outcomes.overlap() { "mixed results" } else { "no mixed results" };
            format!("{mixed}: slowest perforation {perforation} m/s, fastest stop {stop} m/s")
        }
        _ => "one outcome only".to_owned(),
    }
}

/// V50 and σ.
fn answer(found: &Fit) -> String {
    let (Ok(estimate), Some(v50)) = (&found.estimate, found.v50()) else { return String::new() };
    let [low, high] = ends(v50.bounds);
    let level = short(100.0 * found.request.level, 3);
    let by = match estimate.method {
        Method::MaximumLikelihood => "",
        Method::Firth => ", with Firth's penalty",
    };
    let v50 = terminal::heading(&format!("V50 {} m/s", short(estimate.mu, 4)));
    let (sigma, link) = (short(estimate.sigma, 3), found.request.link.word());
    format!(
        "\n{v50}, {level} % interval {low} to {high} m/s\nσ {sigma} m/s, {link}{by}, deviance {}\n",
        short(estimate.deviance(), 4)
    )
}

/// The velocity of a chance and its interval, under a name.
pub(super) fn quantile_cells(name: String, quantile: &Quantile) -> [String; 4] {
    let value = quantile.value.map_or_else(|| "-".to_owned(), |value| short(value, 4));
    let [low, high] = ends(quantile.bounds);
    [name, value, low, high]
}

/// Ends of an interval in words.
pub(super) fn ends(bounds: Bounds) -> [String; 2] {
    [bounds.low, bounds.high].map(end)
}

fn end(end: Option<f64>) -> String {
    end.map_or_else(|| "none".to_owned(), |end| short(end, 4))
}

fn quantiles(found: &Fit) -> String {
    use Align::Right;
    let mut table = TextTable::new(&[("chance", Right), ("m/s", Right), ("low", Right), ("high", Right)]);
    for quantile in &found.quantiles {
        table.row(quantile_cells(format!("{} %", short(100.0 * quantile.p, 3)), quantile));
    }
    let kind = match found.request.interval {
        Interval::Likelihood => "likelihood ratio",
        Interval::Wald => "Wald",
    };
    format!("{table}{} % intervals, {kind}\n", short(100.0 * found.request.level, 3))
}

/// The chance over velocity, perforations above it, stops below.
fn curve(found: &Fit) -> String {
    let Ok(estimate) = &found.estimate else { return String::new() };
    let of = |count: fn(&Group) -> u64| -> Vec<f64> {
        found.outcomes.groups().iter().filter(|group| count(group) > 0).map(|group| group.velocity).collect()
    };
    let marks = [("perforated", of(|group| group.perforated)), ("stopped", of(|group| group.stopped))];
    plot(found.outcomes.range(), |velocity| estimate.probability(velocity), marks)
}

/// A chance over a range of velocities in letters, with marks above and below it.
pub(super) fn plot(
    [low, high]: [f64; 2],
    chance: impl Fn(f64) -> f64,
    [(above, above_at), (below, below_at)]: [(&str, Vec<f64>); 2],
) -> String {
    let column = |velocity: f64| ((velocity - low) / (high - low) * (COLUMNS - 1) as f64).round() as usize;
    let marked = |velocities: &[f64]| {
        let mut marks = vec![' '; COLUMNS];
        for velocity in velocities {
            marks[column(*velocity).min(COLUMNS - 1)] = '|';
        }
        marks
    };
    let mut rows = vec![vec![' '; COLUMNS]; ROWS];
    let mut last = None;
    for n in 0..COLUMNS {
        let chance = chance(low + (high - low) * n as f64 / (COLUMNS - 1) as f64);
        let row = ((1.0 - chance) * (ROWS - 1) as f64).round() as usize;
        // A steep curve is drawn through, so that it stays one line.
        for row in &mut rows[row..last.unwrap_or(row + 1).max(row + 1)] {
            row[n] = '*';
        }
        last = Some(row);
    }
    let line = |name: &str, cells: &[char]| {
        let text = format!("{name:>10} {}", cells.iter().collect::<String>());
        text.trim_end().to_owned() + "\n"
    };
    let mut out = if above.is_empty() { String::new() } else { line(above, &marked(&above_at)) };
    for (n, row) in rows.iter().enumerate() {
        let name = if n % 2 == 0 { format!("{} %", 100 - 100 * n / (ROWS - 1)) } else { String::new() };
        out += &line(&name, row);
    }
    out += &line(below, &marked(&below_at));
    let [low, high] = [low, high].map(|velocity| short(velocity, 4));
    let axis = format!("{low}{high:>width$} m/s", width = COLUMNS.saturating_sub(low.chars().count()));
    out + &line("", &axis.chars().collect::<Vec<_>>())
}

/// The arithmetic V50 of each rule.
pub(super) fn arithmetic_table(rules: &[(Rule, Result<Arithmetic, Refusal>)]) -> String {
    let mut table = TextTable::plain(&[Align::Left, Align::Left, Align::Left]);
    for (rule, result) in rules {
        let words = match result {
            Ok(mean) => format!("{} m/s, spread {} m/s", short(mean.mean, 4), short(mean.spread, 3)),
            Err(why) => format!("none: {}", fit::refusal(why)),
        };
        table.row([rule.standard.to_owned(), fit::rule(rule), words]);
    }
    table.to_string()
}

/// The curves through residual velocities.
pub(super) fn residual_table(curves: &[(ResidualModel, Result<ResidualFit, TooFew>)]) -> String {
    use Align::{Left, Right};
    if curves.is_empty() {
        return String::new();
    }
    let heads = [
        ("", Left),
        ("limit m/s", Right),
        ("low", Right),
        ("high", Right),
        ("a", Right),
        ("p", Right),
        ("scatter m/s", Right),
    ];
    let mut table = TextTable::new(&heads);
    let mut refused = String::new();
    for (curve, result) in curves {
        match result {
            Ok(fit) => {
                let [low, high] = ends(fit.bounds);
                let [factor, exponent, scatter] = [short(fit.factor, 3), short(fit.exponent, 3), short(fit.scatter, 2)];
                table.row([curve.words().to_owned(), short(fit.limit, 4), low, high, factor, exponent, scatter]);
            }
            Err(few) => refused += &format!("{}: {}\n", curve.words(), fit::too_few(few)),
        }
    }
    format!("{table}{refused}Vr = a (Vs^p - V0^p)^(1/p)\n")
}
