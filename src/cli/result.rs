//! The result of a run as people read it: verdict first, then where the energy went, how far the numbers can be
//! trusted, what they cost, what was expected, and where the files are.

use std::path::Path;

use ripstop::case::Case;
use ripstop::output::checks::{self, Check, Level};
use ripstop::output::expect::{Judgement, expected, got, judgement, note, quantity};
use ripstop::output::number::grouped;
use ripstop::output::warnings::Warning;
use ripstop::output::{Breakage, Energies, costs, verdict};
use ripstop::run::Run;
use serde_json::Value;

use super::terminal::{self, Align, TextTable, part};

/// The whole text. `written`: folder and names of the files, where there are some.
pub(crate) fn text(case: &Case, run: &Run, summary: &Value, written: Option<(&Path, &[&str])>) -> String {
    let verdict = verdict(case, run);
    let verdict = format!("{}{} {}", verdict.word.to_uppercase(), verdict.mark(), verdict.detail);
    let checks = checks::checks(case, run);
    let parts = [
        format!("{}\n\n{}\n{}\n", case.title, terminal::heading(&verdict), advice(&checks)),
        energy(run),
        damage(case, run),
        trust(&checks, summary),
        part("cost", &TextTable::pairs(costs(case, run, summary)).to_string()),
        part("warnings", &warnings(&checks::warnings(case, &checks))),
        expectations(summary),
        written.map_or_else(String::new, |(folder, names)| files(folder, names)),
    ];
    parts.concat()
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

/// Broken yarns and their places; empty where none broke.
fn damage(case: &Case, run: &Run) -> String {
    let found = Breakage::of(case, run);
    if found.pieces() == 0 {
        return String::new();
    }
    let [warp, weft, total] = [found.yarns[0], found.yarns[1], found.yarns.iter().sum()].map(|n| grouped(n as u64));
    let [pieces, hit, edges, elsewhere] =
        [found.pieces(), found.at_hit, found.at_edges, found.elsewhere].map(|count| grouped(count as u64));
    let places = format!("{pieces}: {hit} at the hit, {edges} at edges, {elsewhere} elsewhere");
    let rows = [("yarns", format!("{total}: {warp} warp, {weft} weft")), ("places", places)];
    part("broken", &TextTable::pairs(rows).to_string())
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
    for (name, energy) in &energies.shares {
        table.row([format!("  {name}"), energies.text(*energy), energies.percent(*energy)]);
    }
    part("energy", &table.to_string())
}

/// Every check with its number, and assumed parameters.
fn trust(checks: &[Check], summary: &Value) -> String {
    let assumed: Vec<&str> = summary["assumed"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    let rows = checks.iter().map(|check| (check.name, check.value.clone()));
    let table = TextTable::pairs(rows.chain([("assumed parameters", assumed.len().to_string())]));
    let pointers: String = assumed.chunks(3).map(|some| format!("  {}\n", some.join(", "))).collect();
    part("trust", &format!("{table}{pointers}"))
}

fn expectations(summary: &Value) -> String {
    let mut text = String::new();
    for check in summary["expect"].as_array().into_iter().flatten() {
        let pass = match judgement(check) {
            Judgement::Known => terminal::caution("known"),
            other => terminal::mark(other == Judgement::Holds),
        };
        text += &format!("{pass}  {} {}, got {}\n", quantity(check), expected(check), got(check));
        let lines = [check["source"].as_str().unwrap_or_default(), &note(check)].map(str::to_owned);
        text.extend(lines.into_iter().filter(|line| !line.is_empty()).map(|line| format!("      {line}\n")));
    }
    part("expected", &text)
}

/// One line about an expectation that does not hold.
pub(crate) fn broken(check: &Value) -> String {
    let line = format!("{}: expected {}, got {} {}", quantity(check), expected(check), got(check), note(check));
    line.trim_end().to_owned()
}
