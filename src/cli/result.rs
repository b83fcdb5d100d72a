//! The result of a run as people read it, on a screen: the verdict, how far it can be trusted, its margins, where the energy went, what it
//! cost, what was expected, and where the files are.

use std::path::Path;

use ripstop::case::Case;
use ripstop::output::checks::{self, Check, Level};
use ripstop::output::expect::{Judgement, expected, got, judgement, note, quantity};
use ripstop::output::warnings::Warning;
use ripstop::output::{Energies, costs, margins, verdict};
use ripstop::run::Run;
use ripstop::run::outcome::Outcome;
use serde_json::Value;

use super::terminal::{self, Align, TextTable, part};

/// Least share of the largest energy that has a line [-].
const LEAST_SHARE: f64 = 0.005;

/// The whole text. `written`: folder and names of the files, where there are some.
pub(crate) fn text(case: &Case, run: &Run, summary: &Value, written: Option<(&Path, &[&str])>) -> String {
    let checks = checks::checks(case, run);
    let mut weighed = TextTable::plain(&[Align::Left; 3]);
    margins(case, run).into_iter().for_each(|(name, number, more)| weighed.row([name.to_owned(), number, more]));
    let parts = [
        format!("{}\n\n{}\n{}\n", case.title, headline(case, run), advice(&checks)),
        warnings(&checks::warnings(case, &checks)),
        format!("\n{weighed}"),
        energy(run),
        part("cost", &TextTable::pairs(costs(case, run, summary)).to_string()),
        expectations(summary),
        written.map_or_else(String::new, |(folder, names)| files(folder, names)),
    ];
    parts.concat()
}

/// Verdict in its colour, and what belongs to it.
fn headline(case: &Case, run: &Run) -> String {
    let verdict = verdict(case, run);
    let paint = match (verdict.complete, run.outcome) {
        (false, _) | (_, Outcome::Perforated) => terminal::bad,
        (_, Outcome::Stopped | Outcome::Rebounded) => terminal::good,
        _ => terminal::caution,
    };
    let word = terminal::heading(&paint(&verdict.word.to_uppercase()));
    format!("{word}{} {}", terminal::heading(verdict.mark()), terminal::heading(&verdict.detail))
}

/// Sentences to look at, each after a word.
pub(crate) fn notes(sentences: &[String]) -> String {
    sentences.iter().map(|text| format!("{}  {text}\n", terminal::caution("look"))).collect()
}

/// Folder and names of the files written.
pub(crate) fn files(folder: &Path, names: &[&str]) -> String {
    format!("\n{}  {}\n  {}\n", terminal::heading("files"), folder.display(), names.join(", "))
}

/// One line each, with its code.
pub(crate) fn warnings(warnings: &[Warning]) -> String {
    let Some(first) = warnings.first() else { return String::new() };
    let rows = warnings.iter().map(|warning| (terminal::caution(warning.kind.code), warning.message.clone()));
    format!("{}`ripstop explain {}` says what it means and what to do\n", TextTable::pairs(rows), first.kind.code)
}

/// What to do with the result, and why, a line for each reason.
fn advice(checks: &[Check]) -> String {
    let (level, why) = checks::advice(checks);
    let why: Vec<String> = why.iter().map(|check| format!("{}: {}", check.name, check.reason)).collect();
    let (word, why) = (level.advice(), why.join("\n      "));
    match level {
        Level::Fine => format!("{}: all {} checks are fine", terminal::good(word), checks.len()),
        Level::Look => format!("{}: {why}", terminal::caution(word)),
        Level::Bad => format!("{}: {why}", terminal::bad(word)),
    }
}

/// Energy given to the fabric, and its shares at the end.
fn energy(run: &Run) -> String {
    let Some(energies) = Energies::of(run) else { return String::new() };
    let mut table = TextTable::plain(&[Align::Left, Align::Right, Align::Right]);
    for (name, energy) in &energies.sources {
        let of = if name.ends_with("projectile") {
            format!("of {}", energies.text(run.impact_energy))
        } else {
            String::new()
        };
        table.row([(*name).to_owned(), energies.text(*energy), of]);
    }
    // Small ones are left to the report.
    let is_shown =
        |(name, energy): &&(&str, f64)| energy.abs() >= LEAST_SHARE * energies.scale || *name == "unaccounted";
    for (name, energy) in energies.shares.iter().filter(is_shown) {
        table.row([format!("  {name}"), energies.text(*energy), energies.percent(*energy)]);
    }
    part("energy", &table.to_string())
}

fn expectations(summary: &Value) -> String {
    let mut text = String::new();
    for check in summary["expect"].as_array().into_iter().flatten() {
        let pass = match judgement(check) {
            Judgement::Known => terminal::caution("known"),
            other => terminal::mark(other == Judgement::Holds),
        };
        text += &format!("{pass}  {} {}, got {}", quantity(check), expected(check), got(check));
        text.extend(check["source"].as_str().map(|source| format!(" ({source})")));
        text += format!(" {}", note(check)).trim_end();
        text.push('\n');
    }
    part("expected", &text)
}

/// One line about an expectation that does not hold.
pub(crate) fn broken(check: &Value) -> String {
    let line = format!("{}: expected {}, got {} {}", quantity(check), expected(check), got(check), note(check));
    line.trim_end().to_owned()
}
