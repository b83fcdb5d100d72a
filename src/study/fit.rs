//! `ripstop fit`: from shots to a ballistic limit, in the unit of their velocities.

use serde_json::{Value, json};

use super::binary_response::{self, Estimate, Group, Outcomes};
use super::interval::interval;
use super::limit::{Limit, Passed, QUANTILES, Quantile, arithmetic_v50};
use super::range_data::{FitRow, RangeData};
use super::report::{Report, chance_panel, headline, residual_panel};
use crate::output::number::short;

/// Ballistic limit fitted to shots.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Two-sided confidence of intervals.
    pub level: f64,
    /// Outcomes of the shots.
    pub outcomes: Outcomes,
    /// μ and σ, or why there are none.
    pub estimate: Result<Estimate, &'static str>,
    /// Limit by every method.
    pub limit: Limit,
    /// Number of lines without a velocity or an outcome.
    left_out: usize,
}

/// Shots that perforated with a known residual velocity.
pub(super) fn passed(rows: &[FitRow]) -> Vec<Passed> {
    let of = |row: &FitRow| row.residual.map(|residual| Passed { impact: row.velocity, residual, count: row.count });
    rows.iter().filter(|row| row.perforated && row.count > 0).filter_map(of).collect()
}

/// Fit of all that shots allow. `level`: two-sided confidence of intervals; `spread`: another one for the arithmetic V50, in the unit of the
/// velocities.
pub fn fit(data: &RangeData, level: f64, spread: Option<f64>) -> Fit {
    let outcomes = Outcomes::new(data.rows.iter().map(|row| {
        let [perforated, stopped] = if row.perforated { [row.count, 0] } else { [0, row.count] };
        Group { velocity: row.velocity, perforated, stopped }
    }));
    let estimate = binary_response::fit(&outcomes);
    let found = estimate.as_ref().ok();
    let quantile = |p: f64| {
        let bounds = interval(&outcomes, found, p, level);
        Quantile { p, value: found.map(|found| found.velocity(p)), bounds }
    };
    let mut limit = Limit::new(data.unit, QUANTILES.map(quantile).to_vec(), passed(&data.rows), level);
    limit.arithmetic = arithmetic_v50(&outcomes, data.unit, spread);
    Fit { level, estimate, limit, outcomes, left_out: data.left_out }
}

impl Fit {
    /// Fit in JSON.
    pub fn json(&self) -> Value {
        let estimate = self.estimate.as_ref().ok();
        let [perforated, stopped] = self.outcomes.counts();
        let [quantiles, arithmetic, residual] = self.limit.json();
        json!({
            "unit": self.limit.unit.symbol(),
            "mu": estimate.map(|found| found.mu),
            "sigma": estimate.map(|found| found.sigma),
            "deviance": estimate.map(Estimate::deviance),
            "quantiles": quantiles,
            "overlap": self.outcomes.overlap(),
            "method": estimate.map(|found| if found.firth { "Firth's penalised likelihood" } else { "maximum likelihood" }),
            "no_estimate": self.estimate.err(),
            "level": self.level,
            "shots": perforated + stopped,
            "perforated": perforated,
            "stopped": stopped,
            "slowest_perforation": self.outcomes.slowest_perforation(),
            "fastest_stop": self.outcomes.fastest_stop(),
            "arithmetic": arithmetic,
            "residual": residual,
            "notes": self.notes(),
        })
    }

    /// Notes that a reader should know before the numbers are used.
    fn notes(&self) -> Vec<String> {
        let mut notes = match &self.estimate {
            Err(why) => vec![format!("no estimate: {why}")],
            Ok(found) if found.firth => vec![
                "no overlap: no stop was faster than a perforation. The likelihood then has no maximum; the estimate is the one with \
                 Firth's penalty. Shoot where both outcomes are likely"
                    .to_owned(),
            ],
            Ok(_) => Vec::new(),
        };
        let open = |of: &Quantile| of.value.is_some() && (of.bounds.low.is_none() || of.bounds.high.is_none());
        if self.limit.quantiles.iter().any(open) {
            notes.push(
                "an interval without an end: a chance that does not depend on velocity explains the shots well enough. Shoot more"
                    .to_owned(),
            );
        }
        if self.left_out > 0 {
            notes.push(format!("lines without a velocity or an outcome: {}, left out", self.left_out));
        }
        notes
    }

    /// Fit in words, tables and drawings. `name`: of its shots.
    pub fn report(&self, name: &str) -> Report {
        let [perforated, stopped] = self.outcomes.counts();
        let (count, unit) = (perforated + stopped, self.limit.unit.symbol());
        let zone = match (self.outcomes.slowest_perforation(), self.outcomes.fastest_stop()) {
            (Some(perforation), Some(stop)) => {
                let mixed = if self.outcomes.overlap() { "mixed results" } else { "no mixed results" };
                let [perforation, stop] = [perforation, stop].map(|velocity| short(velocity, 4));
                format!("slowest perforation: {perforation} {unit}, fastest stop {stop} {unit}: {mixed}")
            }
            _ => "one outcome only".to_owned(),
        };
        Report {
            title: String::new(),
            counts: vec![format!("{name}: {count} shots, {perforated} perforated, {stopped} stopped"), zone],
            answer: self.answer(),
            notes: self.notes(),
            tables: self.limit.tables(self.level),
            panels: (count > 0).then(|| chance_panel(self)).into_iter().chain(residual_panel(&self.limit)).collect(),
        }
    }

    /// V50 and σ; nothing without an estimate.
    fn answer(&self) -> Vec<String> {
        let (Ok(found), Some((_, bounds))) = (&self.estimate, self.limit.v50()) else { return Vec::new() };
        let by = if found.firth { ", with Firth's penalty" } else { "" };
        let (sigma, deviance, unit) = (short(found.sigma, 3), short(found.deviance(), 4), self.limit.unit);
        let headline = headline(found.mu, unit, self.level, bounds.words());
        vec![headline, format!("σ {sigma} {}{by}, deviance {deviance}", unit.symbol())]
    }
}
