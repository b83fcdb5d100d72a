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

use super::terminal::{self, Align, TextTable};

/// The whole text. `files`: folder and names, where they were written.
pub(crate) fn text(case: &Case, run: &Run, summary: &Value, files: Option<(&Path, &[&str])>) -> String {
    let verdict = verdict(case, run);
    let verdict = format!("{}{} {}", verdict.word.to_uppercase(), verdict.mark(), verdict.detail);
    let verdict: String =
        terminal::wrapped(&verdict, 0).iter().map(|line| format!("\n{}", terminal::heading(line))).collect();
    let checks = checks::checks(case, run);
    let mut parts =
        vec![case.title.clone(), verdict, advice(&checks), energy(run), damage(case, run), trust(&checks, summary)];
    parts.push(part("cost", &TextTable::pairs(costs(case, run, summary)).to_string()));
    parts.push(part("warnings", &warnings(&checks::warnings(case, &checks))));
    parts.push(expectations(summary));
    if let Some((folder, names)) = files {
        let names = terminal::wrapped(&names.join(", "), 2);
        parts.push(format!(
            "\n{}  {}\n{}",
            terminal::heading("files"),
            folder.display(),
            terminal::indent(&names.join("\n"))
        ));
    }
    parts.retain(|part| !part.is_empty());
    parts.iter().map(|part| format!("{}\n", part.trim_end())).collect()
}

/// A part of the text under its title; nothing where there is nothing to say.
pub(crate) fn part(title: &str, text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("\n{}\n{}", terminal::heading(title), terminal::indent(text)) }
}

/// Sentences to look at, each after a word.
pub(crate) fn notes(word: &str, sentences: &[String]) -> String {
    let one = |text: &String| format!("{}  {}\n", terminal::caution(word), terminal::wrapped(text, 6).join("\n      "));
    sentences.iter().map(one).collect()
}

/// Folder and names of the files written.
pub(crate) fn files(folder: &Path, names: &[&str]) -> String {
    format!("\n{}  {}\n  {}\n", terminal::heading("files"), folder.display(), names.join(", "))
}

/// One line each, with its code.
pub(crate) fn warnings(warnings: &[Warning]) -> String {
    let rows = warnings.iter().map(|warning| (terminal::caution(warning.kind.code), warning.message.clone()));
    let table = TextTable::pairs(rows);
    match warnings.first() {
        Some(first) => format!("{table}`ripstop explain {}` says what it means and what to do\n", first.kind.code),
        None => String::new(),
    }
}

/// One line: what to do with the result, and why.
fn advice(checks: &[Check]) -> String {
    let (level, why) = checks::advice(checks);
    let why: Vec<String> = why.iter().map(|check| format!("{}: {}", check.name, check.reason)).collect();
    let text = match level {
        Level::Fine => format!("trust: all {} checks are fine", checks.len()),
        _ => format!("{}: {}", level.advice(), why.join("; ")),
    };
    let mut lines = terminal::wrapped(&text, 0);
    if let Some(first) = lines.first_mut() {
        let word = level.advice();
        let painted = match level {
            Level::Fine => terminal::good(word),
            Level::Look => terminal::caution(word),
            Level::Bad => terminal::bad(word),
        };
        *first = first.replacen(word, &painted, 1);
    }
    lines.join("\n")
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
    let places = format!("{pieces}: {hit} within two diameters of the hit, {edges} at edges, {elsewhere} elsewhere");
    let rows = [("yarns", format!("{total}: {warp} warp, {weft} weft")), ("places", places)];
    part("broken", &TextTable::pairs(rows).to_string())
}

/// Energy given to the fabric, and its shares at the end.
fn energy(run: &Run) -> String {
    let Some(energies) = Energies::of(run) else { return String::new() };
    let mut table = TextTable::plain(&[Align::Left, Align::Right, Align::Right]);
    let absorbed = energies.text(energies.absorbed);
    if run.impact_energy > 0.0 && energies.given == energies.absorbed {
        let impact = format!("of {}", energies.text(run.impact_energy));
        table.row(["lost by the projectile".to_owned(), absorbed, impact]);
    } else if energies.given != 0.0 {
        table.row(["given to the fabric".to_owned(), energies.text(energies.given)]);
    } else {
        table.row(["change"]);
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
    let pointers: String = terminal::wrapped(&assumed.join(", "), 4).iter().map(|line| format!("  {line}\n")).collect();
    part("trust", &format!("{table}{pointers}"))
}

fn expectations(summary: &Value) -> String {
    let checks: Vec<&Value> = summary["expect"].as_array().into_iter().flatten().collect();
    if checks.is_empty() {
        return String::new();
    }
    let mut text = String::new();
    for check in checks {
        let pass = match judgement(check) {
            Judgement::Known => terminal::caution("known"),
            other => terminal::mark(other == Judgement::Holds),
        };
        let got = format!("got {}", got(check));
        text += &format!("{pass}  {} {}, {got}\n", quantity(check), expected(check));
        let source = check["source"].as_str().unwrap_or_default();
        for line in [source, &note(check)].into_iter().filter(|line| !line.is_empty()) {
            text.extend(terminal::wrapped(line, 8).iter().map(|line| format!("      {line}\n")));
        }
    }
    part("expected", &text)
}

/// One line about an expectation that does not hold.
pub(crate) fn broken(check: &Value) -> String {
    let line = format!("{}: expected {}, got {} {}", quantity(check), expected(check), got(check), note(check));
    line.trim_end().to_owned()
}
