//! What a command ends with: a failure, with its exit code and message, or the result of a run as people read it on a screen: the verdict,
//! how far it can be trusted, its margins, where the energy went, what it cost, what was expected, and where the files are.

use std::fmt::Display;
use std::path::Path;
use std::process::ExitCode;

use ripstop::case::{Case, CaseError};
use ripstop::gpu::DeviceError;
use ripstop::output::checks::{self, Check, Level};
use ripstop::output::expect::{Judgement, expected, got, judgement, note, quantity};
use ripstop::output::warnings::Warning;
use ripstop::output::{Energies, costs, margins, verdict};
use ripstop::run::outcome::Outcome;
use ripstop::run::{Run, RunError};
use serde_json::Value;

use super::terminal::{self, Align, TextTable, part};

/// Stopped by the user.
pub(crate) const INTERRUPTED: u8 = 130;
/// Least share of the largest energy that has a line [-].
const LEAST_SHARE: f64 = 0.005;

/// Reason why a command ends with another code than 0.
#[derive(Clone, Debug)]
pub(crate) struct CommandFailure {
    code: u8,
    message: String,
}

impl CommandFailure {
    /// Exit code 1: a check failed or the run became unstable.
    pub(crate) fn check(message: impl Into<String>) -> Self {
        Self { code: 1, message: message.into() }
    }

    /// Exit code 2: bad input or usage, or results that cannot be written.
    pub(crate) fn input(message: impl Into<String>) -> Self {
        Self { code: 2, message: message.into() }
    }

    /// Exit code 2, with the place, what may stand there and what stands there.
    pub(crate) fn expected(place: impl Display, expected: impl Display, found: impl Display) -> Self {
        Self::input(format!("error: {place}\n  expected: {expected}\n  found: {found}"))
    }

    /// This failure, with advice.
    pub(crate) fn help(mut self, help: impl Display) -> Self {
        self.message += &format!("\n  help: {help}");
        self
    }

    /// Exit code 3: no device for what was asked, or one that was lost on the way.
    pub(crate) fn lost(message: impl Into<String>) -> Self {
        Self { code: 3, message: message.into() }
    }

    /// Exit code 130.
    pub(crate) fn interrupted(message: impl Into<String>) -> Self {
        Self { code: INTERRUPTED, message: message.into() }
    }

    /// Both, with the code of the first.
    pub(crate) fn and(self, other: Self) -> Self {
        Self { message: format!("{}\n{}", self.message, other.message), ..self }
    }

    /// Prints the message and gives the exit code.
    pub(crate) fn report(self) -> ExitCode {
        terminal::complain(&self.message);
        ExitCode::from(self.code)
    }

    /// Failure of a run that did not start.
    pub(crate) fn start(file: &str, error: &RunError) -> Self {
        match error {
            RunError::Model(error) | RunError::Checkpoint(error) => error.clone().in_file(file).into(),
            RunError::Device(error) => error.clone().into(),
            other => Self::input(format!("error: {other}")),
        }
    }
}

impl From<CaseError> for CommandFailure {
    fn from(error: CaseError) -> Self {
        Self::input(error.to_string())
    }
}

impl From<DeviceError> for CommandFailure {
    /// Exit code 3: no device, or one that cannot hold the case or was lost.
    fn from(error: DeviceError) -> Self {
        Self { code: 3, ..error.refusal().into() }
    }
}

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
