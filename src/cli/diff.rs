//! `ripstop diff`: runs and measured curves, held against the first.

use std::path::{Path, PathBuf};

use ripstop::output::Folder;
use ripstop::output::number::{fraction, short};
use ripstop::study::diff::{
    self, CurveRow, Diff, DiffOptions, DiffRequest, Input, InputKind, KeyDifference, RunPair, SummaryRow,
};

use super::failure::CommandFailure;
use super::result::{files, part};
use super::run::Print;
use super::study_arguments::DiffArguments;
use super::table::{Align, TextTable};
use super::{paint, screen};

/// What is written.
const FILES: [&str; 3] = ["diff.csv", "diff.svg", "diff.html"];
/// Keys of cases shown on the terminal at most.
const KEYS: usize = 30;
/// Letters of a value on the terminal at most.
const VALUE: usize = 24;

/// Compares, prints and writes; exit code 1 where something judged differs by more than it may.
pub(crate) fn diff(arguments: &DiffArguments) -> Result<(), CommandFailure> {
    let options = DiffOptions { within: arguments.within, shift_us: arguments.shift };
    let request = DiffRequest::new(options, &arguments.columns)?;
    let inputs =
        arguments.inputs.iter().map(|path| diff::input::read(path, &request)).collect::<Result<Vec<_>, _>>()?;
    let read: Vec<PathBuf> = inputs.iter().flat_map(Input::files).collect();
    let found = diff::diff(inputs, &request)?;
    let notes = found.inputs.iter().flat_map(|input| &input.notes);
    if !arguments.quiet {
        notes.for_each(|note| screen::complain(&format!("note: {note}")));
    }
    let written = arguments.out.as_deref().map(|out| write(out, &read, &found)).transpose()?;
    Print::of(arguments.json, arguments.quiet).show(|| diff::json(&found), || text(&found, written.as_ref()))?;
    verdict(&found)
}

fn write(out: &Path, read: &[PathBuf], found: &Diff) -> Result<Folder, CommandFailure> {
    let folder = Folder::share(out, &FILES, &read.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
    let texts = [diff::csv(found), diff::svg(found), diff::html(found)];
    let texts: Vec<(&str, String)> = FILES.into_iter().zip(texts).collect();
    folder.put(&texts, &FILES)?;
    Ok(folder)
}

/// What the exit code says.
fn verdict(found: &Diff) -> Result<(), CommandFailure> {
    let Some(within) = found.options.within else { return Ok(()) };
    let lines = found.pairs.iter().enumerate().flat_map(|(n, pair)| {
        let letter = diff::letter(n + 1);
        pair.failures().map(move |line| format!("\n  {letter}: {line}"))
    });
    let lines: Vec<String> = lines.collect();
    if lines.is_empty() {
        return Ok(());
    }
    let (a, within) =
        (found.inputs.first().map(|a| a.path.display().to_string()).unwrap_or_default(), fraction(within));
    Err(CommandFailure::check(format!("error: {a}: others differ by more than {within}{}", lines.concat())))
}

/// The whole text.
fn text(found: &Diff, folder: Option<&Folder>) -> String {
    let mut out = String::new();
    for (n, input) in found.inputs.iter().enumerate() {
        let letter = diff::letter(n).to_string();
        let lines = screen::wrapped(&named(input), 3);
        out += &format!("{}  {}\n", paint::heading(&letter), lines.join("\n   "));
    }
    if found.options.shift_us != 0.0 {
        out += &format!("times of all but A are moved by {} µs\n", found.options.shift_us);
    }
    for (n, pair) in found.pairs.iter().enumerate() {
        out += &compared(diff::letter(n + 1), pair, found);
    }
    out + &folder.map_or_else(String::new, |folder| files(folder.path(), &FILES))
}

/// What an input is.
fn named(input: &Input) -> String {
    let path = input.path.display();
    let [from, to] = input.table.span().map(|time| short(time, 4));
    let rows = input.table.times.len();
    match input.kind {
        InputKind::Run => format!("{path}: {}", input.title().unwrap_or("a run")),
        InputKind::Curve => {
            let columns: Vec<&str> = input.table.columns.iter().map(|column| column.name.as_str()).collect();
            let columns = match columns.as_slice() {
                few @ ([] | [_] | [_, _] | [_, _, _]) => few.join(", "),
                many => format!("{} columns", many.len()),
            };
            format!("{path}: a table of {rows} rows, {from} to {to} µs: {columns}")
        }
    }
}

/// What differs between the first and another.
fn compared(b: char, pair: &RunPair, found: &Diff) -> String {
    let mut out = part(&format!("results, {b} against A"), &results(b, &pair.summary));
    if let Some(keys) = &pair.keys {
        let text = if keys.is_empty() { "the same\n".to_owned() } else { self::keys(b, keys) };
        out += &part("case", &text);
    }
    if !pair.machine.is_empty() {
        out += &part("computed by", &keys(b, &pair.machine));
    }
    out += &part(&format!("curves, {b} against A{}", span(pair)), &curves(pair));
    out + &screen::indent(&conclusion(pair, found))
}

/// The time that most curves are compared over.
fn span(pair: &RunPair) -> String {
    pair.spans().first().map_or_else(String::new, |(span, _)| format!(", {}", times(*span)))
}

fn times(span: [f64; 2]) -> String {
    let [from, to] = span.map(|time| short(time, 5));
    format!("{from} to {to} µs")
}

/// Quantities side by side.
fn results(b: char, rows: &[SummaryRow]) -> String {
    use Align::{Left, Right};
    if rows.is_empty() {
        return String::new();
    }
    let (b, difference) = (b.to_string(), format!("{b} - A"));
    let heads = [("", Left), ("A", Right), (b.as_str(), Right), (&difference, Right), ("", Right), ("", Left)];
    let mut table = TextTable::new(&heads);
    for row in rows {
        let [a, b] =
            [&row.a, &row.b].map(|value| value.as_f64().map_or_else(|| diff::word(Some(value)), |v| short(v, 5)));
        let difference = row.difference.map_or_else(String::new, |difference| short(difference, 3));
        let relative = if row.difference.is_some() { percent(row.relative) } else { String::new() };
        table.row([row.name.to_owned(), a, b, difference, relative, mark(row.pass)]);
    }
    format!("{table}energies at the end of each run\n")
}

fn mark(pass: Option<bool>) -> String {
    pass.map_or_else(String::new, paint::mark)
}

/// A share in percent; `-` where there is none.
fn percent(share: Option<f64>) -> String {
    match share {
        None => "-".to_owned(),
        Some(share) if share >= 10.0 => ">1000 %".to_owned(),
        Some(share) if share <= -10.0 => "<-1000 %".to_owned(),
        Some(share) => fraction(share),
    }
}

/// Keys and their values.
fn keys(b: char, keys: &[KeyDifference]) -> String {
    let mut table = TextTable::new(&[("", Align::Left), ("A", Align::Left), (&b.to_string(), Align::Left)]);
    for key in keys.iter().take(KEYS) {
        let [a, b] = [&key.a, &key.b].map(|value| cut(&diff::word(value.as_ref())));
        table.row([key.pointer.clone(), a, b]);
    }
    let more = match keys.len().saturating_sub(KEYS) {
        0 => String::new(),
        more => format!("and {more} more: --json has them all\n"),
    };
    format!("{table}{more}")
}

fn cut(text: &str) -> String {
    let short: String = text.chars().take(VALUE).collect();
    if short.len() < text.len() { short + "…" } else { short }
}

/// Curves that differ, and the names of those that do not.
fn curves(pair: &RunPair) -> String {
    use Align::{Left, Right};
    let heads = [
        ("", Left),
        ("largest", Right),
        ("at µs", Right),
        ("rms", Right),
        ("of peak", Right),
        ("parts", Right),
        ("", Left),
    ];
    let mut table = TextTable::new(&heads);
    let (same, differ): (Vec<&CurveRow>, Vec<&CurveRow>) = pair.curves.iter().partition(|row| row.difference.is_zero());
    for row in &differ {
        let found = &row.difference;
        let parts = found.parts_at.map_or_else(|| "-".to_owned(), |time| short(time, 3));
        let numbers = [short(found.largest, 3), short(found.at, 3), short(found.rms, 3)];
        let [largest, at, rms] = numbers;
        table.row([row.name.clone(), largest, at, rms, percent(found.share()), parts, mark(row.pass)]);
    }
    let mut out = if differ.is_empty() { String::new() } else { table.to_string() };
    if !same.is_empty() {
        let names: Vec<&str> = same.iter().map(|row| row.name.as_str()).collect();
        let which = if differ.is_empty() { format!("all {}", names.len()) } else { names.join(", ") };
        out += &(screen::wrapped(&format!("the same to the last digit: {which}"), 2).join("\n") + "\n");
    }
    out
}

/// Where they part, and what the numbers are.
fn conclusion(pair: &RunPair, found: &Diff) -> String {
    let part = fraction(found.options.part());
    let mut out = match pair.parts() {
        Some((row, time)) => {
            vec![format!("they part first at {} µs, in {}, by more than {part}", short(time, 4), row.name)]
        }
        None => vec![format!("no judged curve differs by more than {part}")],
    };
    let meaning =
        "of peak: largest difference over the largest magnitude of A in the common time; parts: when it first exceeds";
    out.push(format!("{meaning} {part} of that, in µs"));
    out.extend(pair.spans().iter().skip(1).map(|(span, names)| format!("{} for {}", times(*span), names.join(", "))));
    out.iter().flat_map(|line| screen::wrapped(line, 2)).map(|line| line + "\n").collect()
}
