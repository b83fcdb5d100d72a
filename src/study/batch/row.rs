//! A row of `shots.csv`: what was drawn for a shot, and what became of it.

use std::collections::HashMap;

use super::ShotOrder;
use crate::case::{Case, Drawn};
use crate::output::checks::{Level, advice, checks};
use crate::output::csv::{number, quoted};
use crate::output::{absorbed_energy, residual_velocity};
use crate::run::Run;
use crate::run::outcome::Outcome;
use crate::study::fit::FitRow;
use crate::study::outcomes::Shot;

/// Columns before those of what was drawn.
const FIRST: [&str; 3] = ["shot", "asked_velocity_m_s", "velocity_m_s"];
/// Columns behind them.
const LAST: [&str; 14] = [
    "outcome",
    "perforated",
    "count",
    "residual_velocity_m_s",
    "impact_energy_j",
    "absorbed_energy_j",
    "energy_gained",
    "energy_error",
    "max_deflection_mm",
    "failed_warp",
    "failed_weft",
    "steps",
    "trust",
    "reason",
];

/// Every column, given those of what is drawn.
pub fn columns(drawn: &[String]) -> Vec<String> {
    let first = FIRST.iter().map(|name| (*name).to_owned());
    first.chain(drawn.iter().cloned()).chain(LAST.iter().map(|name| (*name).to_owned())).collect()
}

/// One shot.
#[derive(Clone, Debug, PartialEq)]
pub struct ShotRow {
    /// What was asked for.
    pub order: ShotOrder,
    /// Impact velocity [m/s]; that asked for where the shot could not be set up.
    pub velocity: f64,
    /// Values that were drawn.
    pub drawn: Vec<Drawn>,
    /// What became of the projectile; `None`: the shot failed.
    pub outcome: Option<Outcome>,
    /// Velocity that is left [m/s].
    pub residual: Option<f64>,
    /// Numbers of the columns from `impact_energy_j` to `steps`, as far as there are any.
    numbers: Vec<f64>,
    /// What to do with the result, in a word.
    pub trust: String,
    /// Why there is no outcome, else empty.
    pub reason: String,
}

impl ShotRow {
    /// A shot that ran.
    pub(super) fn of_run(order: ShotOrder, case: &Case, run: &Run) -> Self {
        let last = run.history.last().copied().unwrap_or_default();
        let reason = match (&run.divergence, &run.lost, run.outcome) {
            (Some(trouble), ..) => {
                format!("unstable: {} in {} at step {}", trouble.quantity, trouble.kernel, trouble.step)
            }
            (None, Some(lost), _) => lost.split_whitespace().collect::<Vec<_>>().join(" "),
            (None, None, Outcome::Running) => "undecided at the end of the run".to_owned(),
            _ => String::new(),
        };
        let decided = reason.is_empty();
        Self {
            order,
            velocity: case.projectile.as_ref().map_or(0.0, |projectile| projectile.velocity),
            drawn: case.drawn.clone(),
            outcome: (run.divergence.is_none() && run.lost.is_none()).then_some(run.outcome),
            residual: residual_velocity(case, run).filter(|_| decided),
            numbers: vec![
                run.impact_energy,
                absorbed_energy(run),
                run.energy_gained,
                run.energy_error,
                run.deflection() * 1e3,
                last.failed[0] as f64,
                last.failed[1] as f64,
                run.steps as f64,
            ],
            trust: advice(&checks(case, run)).0.advice().to_owned(),
            reason,
        }
    }

    /// A shot that did not run, and why.
    pub(super) fn of_failure(order: ShotOrder, velocity: f64, drawn: Vec<Drawn>, reason: &str) -> Self {
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        let trust = Level::Bad.advice().to_owned();
        Self { order, velocity, drawn, outcome: None, residual: None, numbers: Vec::new(), trust, reason }
    }

    /// Whether the projectile passed; `None` without a decision.
    pub fn perforated(&self) -> Option<bool> {
        match self.outcome? {
            Outcome::Perforated => Some(true),
            Outcome::Stopped | Outcome::Rebounded => Some(false),
            Outcome::Running => None,
        }
    }

    /// Kinetic energy that the projectile has lost [J].
    pub fn absorbed_energy(&self) -> Option<f64> {
        self.numbers.get(1).copied()
    }

    /// As estimators take it.
    pub(crate) fn as_shot(&self) -> Option<Shot> {
        self.perforated().map(|perforated| Shot { velocity: self.velocity, perforated })
    }

    /// As `ripstop fit` reads it.
    pub(crate) fn as_fit_row(&self) -> Option<FitRow> {
        let perforated = self.perforated()?;
        let passed = |residual: &f64| perforated && (0.0..=self.velocity).contains(residual);
        Some(FitRow { velocity: self.velocity, perforated, count: 1, residual: self.residual.filter(passed) })
    }

    /// A line of the table with these drawn columns.
    pub(super) fn line(&self, drawn: &[String]) -> String {
        let mut cells = vec![
            self.order.shot.to_string(),
            self.order.velocity.map(number).unwrap_or_default(),
            number(self.velocity),
        ];
        let value =
            |name: &String| self.drawn.iter().find(|drawn| drawn.column == *name).map(|drawn| number(drawn.value));
        cells.extend(drawn.iter().map(|name| value(name).unwrap_or_default()));
        cells.push(self.outcome.map_or("failed", Outcome::word).to_owned());
        let passed = self.perforated() == Some(true);
        cells.push(u8::from(passed).to_string());
        cells.push(u8::from(self.perforated().is_some()).to_string());
        // A shot that was stopped has no residual velocity in the table that `ripstop fit` reads.
        cells.push(self.residual.filter(|_| passed).map(number).unwrap_or_default());
        cells.extend((0..8).map(|n| self.numbers.get(n).copied().map(number).unwrap_or_default()));
        cells.push(self.trust.clone());
        cells.push(quoted(&self.reason));
        cells.join(",")
    }

    /// The row of a record of the table; `None` where it is none.
    pub(super) fn parse(header: &csv::StringRecord, record: &csv::StringRecord) -> Option<Self> {
        let cells: HashMap<&str, &str> = header.iter().zip(record).collect();
        let value = |name: &str| cells.get(name).and_then(|cell| cell.parse::<f64>().ok());
        let first_last = LAST.first().and_then(|name| header.iter().position(|head| head == *name))?;
        let drawn = header.iter().take(first_last).skip(FIRST.len());
        let drawn = drawn.filter_map(|name| Some(Drawn { column: name.to_owned(), value: value(name)? })).collect();
        let outcomes = [Outcome::Perforated, Outcome::Stopped, Outcome::Rebounded, Outcome::Running];
        let outcome = outcomes.into_iter().find(|outcome| Some(&outcome.word()) == cells.get("outcome"));
        let numbers = LAST[4..12].iter().map_while(|name| value(name)).collect();
        let text = |name: &str| cells.get(name).map(|cell| (*cell).to_owned());
        let mut row = Self {
            order: ShotOrder { shot: cells.get("shot")?.parse().ok()?, velocity: value("asked_velocity_m_s") },
            velocity: value("velocity_m_s")?,
            drawn,
            outcome,
            residual: value("residual_velocity_m_s"),
            numbers,
            trust: text("trust")?,
            reason: text("reason")?,
        };
        if row.perforated() == Some(false) {
            row.residual = Some(0.0);
        }
        Some(row)
    }
}
