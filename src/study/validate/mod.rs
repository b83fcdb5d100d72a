//! Predictions against what others have found: closed forms with published constants, and the paper's shots.
//!
//! No row gives an input back. Closed forms are scenes of `cases/verify` whose source says so, the same scenes driven otherwise, and
//! tests of shear whose frame or grips no case has. Limits are held against scales and, where asked for, against measured V50. What was published as a curve
//! only is shown without a judgement: there is no number to hold it against. A row that fails stays, with the reason where it
//! is known. Tables of the unit cell, conservation and stability are the affair of [`crate::study::verify`].

mod driven;
mod ladder;
mod limits;
mod shear;
mod shots;
mod text;

use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::{Value, json};

use crate::case::{self, Case};
use crate::run::{self, Options, Progress, Run};
use crate::study::verify::scenes::SCENES;
pub use shots::{SHOTS, has_published, is_published};
pub use text::{html, markdown};

/// What the sources call the paper.
pub const PAPER: &str = "Shahkarami, A., Vaziri, R. (2006). An efficient shell element based approach to modeling the impact \
                         response of fabrics.";

/// One published number or statement.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// The fabric or the shot.
    pub group: String,
    /// What was published of it, with its unit.
    pub name: String,
    /// What it is.
    pub expected: Expected,
    /// What was computed: a number in the unit of the name, or a word. Null where there is nothing.
    pub got: Value,
    /// Where it was published.
    pub source: String,
    /// Whether it holds; `None`: not judged.
    pub pass: Option<bool>,
    /// Why it does not, where that is known; else empty.
    pub known_difference: String,
}

/// What was published.
#[derive(Clone, Debug, PartialEq)]
pub enum Expected {
    /// A number as printed, how far off is as good, and why that far.
    Number {
        /// As printed.
        text: String,
        /// The same.
        value: f64,
        /// Largest difference that is no contradiction.
        tolerance: f64,
        /// Why.
        because: &'static str,
    },
    /// A statement in words.
    Statement(String),
    /// A curve without numbers, or another finding that decides nothing.
    CurveOnly(String),
}

impl Expected {
    /// A number from its text.
    fn number(text: impl Into<String>, tolerance: f64, because: &'static str) -> Self {
        let text = text.into();
        Self::Number { value: text.parse().unwrap_or(f64::NAN), text, tolerance, because }
    }
}

impl Prediction {
    /// A row, judged where a number is expected.
    fn judged(group: &str, name: &str, expected: Expected, got: Value, source: &str) -> Self {
        let pass = match &expected {
            Expected::Number { value, tolerance, .. } => {
                Some(got.as_f64().is_some_and(|got| (got - value).abs() <= *tolerance))
            }
            _ => None,
        };
        let [group, name, source] = [group, name, source].map(str::to_owned);
        Self { group, name, expected, got, source, pass, known_difference: String::new() }
    }

    /// A row that could not be computed, and why.
    fn failed(group: &str, why: String) -> Self {
        let expected = Expected::Statement("something computed".to_owned());
        Self { pass: Some(false), ..Self::judged(group, "", expected, json!(why), "") }
    }

    /// The same, with the reason for which it is known to fail.
    fn known(self, why: &str) -> Self {
        Self { known_difference: why.to_owned(), ..self }
    }

    /// Expected, as people read it.
    pub fn expected_text(&self) -> String {
        match &self.expected {
            Expected::Number { text, .. } | Expected::Statement(text) | Expected::CurveOnly(text) => text.clone(),
        }
    }

    /// Got, as people read it: as many digits as expected.
    pub fn got_text(&self) -> String {
        let decimals = match &self.expected {
            Expected::Number { text, .. } => text.split_once('.').map_or(0, |(_, fraction)| fraction.len()),
            _ => 1,
        };
        match &self.got {
            Value::Number(number) => number.as_f64().map_or_else(String::new, |got| format!("{got:.decimals$}")),
            Value::String(word) => word.clone(),
            _ => "nothing".to_owned(),
        }
    }

    /// Got over expected, minus one; `None` where one of them is no number, or nothing is expected.
    pub fn difference(&self) -> Option<f64> {
        match &self.expected {
            Expected::Number { value, .. } if *value != 0.0 => self.got.as_f64().map(|got| got / value - 1.0),
            _ => None,
        }
    }

    /// The same in percent.
    pub fn difference_text(&self) -> String {
        self.difference().map_or_else(String::new, |difference| match format!("{:+.2} %", 100.0 * difference) {
            zero if zero.starts_with("+0.00") || zero.starts_with("-0.00") => "0 %".to_owned(),
            text => text,
        })
    }

    /// Source, and why the row is known to fail.
    pub fn source_text(&self) -> String {
        match (self.pass, self.known_difference.as_str()) {
            (_, "") | (Some(true) | None, _) => self.source.clone(),
            (Some(false), why) => format!("{}; {why}", self.source),
        }
    }

    /// `pass`, `FAIL`, or nothing where there is no judgement.
    pub fn mark(&self) -> &'static str {
        match self.pass {
            Some(true) => "pass",
            Some(false) => "FAIL",
            None => "",
        }
    }

    /// As scripts read it.
    pub fn to_json(&self) -> Value {
        let (expected, tolerance, because) = match &self.expected {
            Expected::Number { value, tolerance, because, .. } => (json!(value), json!(tolerance), json!(because)),
            Expected::Statement(text) | Expected::CurveOnly(text) => (json!(text), Value::Null, Value::Null),
        };
        json!({
            "group": self.group,
            "name": self.name,
            "expected": expected,
            "tolerance": tolerance,
            "tolerance_because": because,
            "got": self.got,
            "difference": self.difference(),
            "source": self.source,
            "judged": self.pass.is_some(),
            "pass": self.pass,
            "known_difference": self.known_difference,
        })
    }
}

/// What happened to the rows in numbers: passed, failed, not judged.
pub fn counts(rows: &[Prediction]) -> [usize; 3] {
    [Some(true), Some(false), None].map(|pass| rows.iter().filter(|row| row.pass == pass).count())
}

/// Rows that fail without a reason that is known.
pub fn unexplained(rows: &[Prediction]) -> usize {
    rows.iter().filter(|row| row.pass == Some(false) && row.known_difference.is_empty()).count()
}

/// The table in the making: how its rows are computed, and those that there are.
struct PredictionRun<'a> {
    options: Options<'a>,
    interrupt: &'a AtomicBool,
    progress: &'a mut (dyn FnMut(&str, &Progress) + Send),
    rows: Vec<Prediction>,
}

impl PredictionRun<'_> {
    fn interrupted(&self) -> bool {
        self.interrupt.load(Ordering::Relaxed)
    }

    /// Adds rows, or one that says why there are none. After an interrupt neither is added.
    fn take(&mut self, group: &str, found: Result<Vec<Prediction>, String>) {
        if !self.interrupted() {
            self.rows.extend(found.unwrap_or_else(|why| vec![Prediction::failed(group, why)]));
        }
    }

    /// A run that came to its end; after an interrupt none.
    fn run(&mut self, case: &Case) -> Result<Run, String> {
        if self.interrupted() {
            return Err("interrupted".to_owned());
        }
        let mut progress = |at: &Progress| (self.progress)(&case.name, at);
        let run = run::run(case, self.options, self.interrupt, &mut progress).map_err(|error| error.to_string())?;
        match (&run.divergence, &run.lost) {
            (Some(trouble), _) => Err(format!("unstable at step {}: {}", trouble.step, trouble.quantity)),
            (None, Some(reason)) => Err(reason.clone()),
            (None, None) => Ok(run),
        }
    }

    /// The run of a case with changes, without what the case itself expects.
    fn changed(&mut self, (name, text): (&str, &str), sets: impl IntoIterator<Item = String>) -> Result<Run, String> {
        let own = ["/expect=[]", "/output/profile_times_us=[]"].map(str::to_owned);
        let sets: Vec<String> = own.into_iter().chain(sets).collect();
        let case = case::from_str(name, text, &sets).map_err(|error| error.to_string())?;
        self.run(&case)
    }
}

/// Computes every row, those of measured V50 only where they are asked for. Rows after an interrupt are left out.
pub fn run(
    with_ladder: bool,
    options: Options<'_>,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&str, &Progress) + Send),
) -> Vec<Prediction> {
    let mut table = PredictionRun { options, interrupt, progress, rows: Vec::new() };
    for (name, text) in SCENES {
        match case::from_str(name, text, &[]) {
            Ok(case) if !has_published(&case) => {}
            Ok(case) => drop(shots::add(&case, &mut table)),
            Err(error) => table.rows.push(Prediction::failed(name, error.to_string())),
        }
    }
    driven::add(&mut table);
    shear::add(&mut table);
    shots::paper(&mut table);
    limits::add(&mut table);
    if with_ladder {
        ladder::add(&mut table);
    }
    table.rows
}

/// Computes the rows of these cases alone: what they state with a published source.
pub fn run_cases(
    cases: &[Case],
    options: Options<'_>,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&str, &Progress) + Send),
) -> Vec<Prediction> {
    let mut table = PredictionRun { options, interrupt, progress, rows: Vec::new() };
    for case in cases {
        shots::add(case, &mut table);
    }
    table.rows
}

#[cfg(test)]
#[path = "validate_tests.rs"]
mod tests;
