//! Numerical choices, output, and statements about the result.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::error::{number_text, percent, quote, short_number_text, text_of};
use super::keys::choices;
use super::provenance::Provenance;
use super::{Along, Case, CaseError, Motion, Origin, Projectile, critical_step};

/// Coefficient of the shock viscosity.
const VISCOSITY: f64 = 0.3;
/// Coefficient of the shock viscosity where a bar strikes. The pulse that its kink sends out at the start runs on along the strip, where that
/// of a round body spreads over a ply: with 0.3 it stands 30 % above the exact tension. The step is a third shorter.
const VISCOSITY_ALONG_A_BAR: f64 = 0.8;
/// A shot whose case names no end and whose outcome is not known ends here at the earliest [s].
const EARLIEST: f64 = 1e-3;
/// The same where no ply spans between two clamped sides [s]. What nothing holds stops the projectile when all of it moves: 150 mm at
/// 50 m/s take 5.2 ms. What one side holds swings first: 100 mm at 120 m/s take 2.5 ms.
const EARLIEST_LOOSE: f64 = 8e-3;
/// And at the latest [s]: the history of longer runs would fill the memory.
const LATEST: f64 = 256e-3;
/// Length along a yarn over which its failure is judged [mm]; assumed.
const FAILURE_LENGTH: f64 = 0.9;

/// Time integration.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct Solver {
    /// End of the run. Needed where nothing flies freely into the pack, or run_until is "end_time" [s].
    ///
    /// Otherwise: when the outcome is known, at the latest after 1000, 2000, 4000 … 256000 µs (from 8000 on where no two opposite sides are
    /// clamped): twice the time that the impact velocity takes to where the pack breaks, and through it.
    #[serde(default)]
    #[schemars(rename = "end_time_us", range(min = 1e-6, max = 1e9))]
    pub end_time: f64,
    /// The scheme that keys left out take their values from: ripstop's own, or the paper's (one even element per crossover, contact
    /// at nodes, stretches at the centre, no viscosity).
    ///
    /// Default: measured: tension shocks neither ring nor make energy.
    #[schemars(extend("default" = "default"))]
    pub numerics: Numerics,
    /// Refinement of the mesh, where elements_per_crossover and max_crossovers are left out.
    ///
    /// Default: measured: a ballistic limit within 5 % of the converged one.
    #[schemars(extend("default" = "default"))]
    pub accuracy: Accuracy,
    /// Time step over the critical one.
    ///
    /// Default: model: margin for contact, shear and hourglass stiffness.
    #[schemars(range(max = 1), extend("exclusiveMinimum" = 0, "help" = UNSTABLE))]
    #[schemars(extend("default" = 0.9))]
    pub courant: f64,
    /// Hourglass stiffness over the full-integration stiffness.
    ///
    /// Default: model: keeps hourglass energy small without stiffening.
    #[schemars(range(min = 0, max = 1), extend("default" = 0.001))]
    pub hourglass: f64,
    /// Viscosity along the yarns over the stiffness, times length of an element over wave speed, for smooth waves one crossover at most;
    /// 0: none, as in the paper.
    ///
    /// Otherwise: 0.3, where a bar strikes 0.8, measured: tension behind a shock peaks at most a third above its plateau; 0 with
    /// "numerics": "paper".
    #[schemars(range(min = 0, max = 1))]
    pub shock_viscosity: f64,
    /// Length along a yarn over which the strain that breaks it is averaged, and which breaks; over its width the root mean square
    /// counts. 0: that of an element, as in the paper [m].
    ///
    /// Otherwise: 0.9, assumed: the order of a yarn's width; 0 with "numerics": "paper".
    #[schemars(rename = "failure_length_mm", range(min = 0, max = 100))]
    pub failure_length: f64,
    /// Whether mirror symmetry may be used.
    ///
    /// Default: same result, less work.
    #[schemars(extend("default" = "auto"))]
    pub symmetry: Symmetry,
    /// Where contact with the projectile is sampled: at nodes, or also where the rim of a flat face crosses the edges of elements.
    ///
    /// Otherwise: edges, measured: before failure nearer to a finer mesh than nodes; nodes with "numerics": "paper".
    pub contact_sampling: ContactSampling,
    /// Where an element's stretches are taken: at its centre, or as the root of the mean of their squares over the element.
    ///
    /// Otherwise: mean, measured: the ballistic limit is within 1 % of the converged one, not 4 %; centre with "numerics": "paper".
    pub stretch_sampling: StretchSampling,
    /// When the run ends: with the outcome, when a projectile that stopped is free of the fabric too, or at end_time_us.
    ///
    /// Default: nothing asked for happens after it.
    #[schemars(extend("default" = "outcome"))]
    pub run_until: RunUntil,
}

const UNSTABLE: &str = "above 1 the time step exceeds the critical step and leapfrog integration is unstable";

/// Output of a run, and its intervals.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct Output {
    /// Interval of history.csv, at most end_time_us [s].
    ///
    /// Default: a few hundred rows for a shot.
    #[schemars(rename = "history_interval_us", range(min = 1e-6, max = 1e9), extend("default" = 0.5))]
    pub history_interval: f64,
    /// Frames for ParaView, evenly from impact to the end of the run; up to twice as many where that comes before end_time_us.
    ///
    /// Default: none asked for.
    #[schemars(range(min = 0, max = 10_000), extend("default" = 0))]
    pub frames: u32,
    /// Times of deflection profiles, ascending [s].
    ///
    /// Default: none asked for.
    #[schemars(rename = "profile_times_us", length(min = 0, max = 1000), inner(range(min = 0, max = 1e9)))]
    #[schemars(extend("default" = []))]
    pub profile_times: Vec<f64>,
    /// Direction of the profiles, through the point of impact.
    ///
    /// Default: the first axis.
    #[schemars(extend("default" = "warp"))]
    pub profile_along: Along,
}

choices! {
    /// The scheme that keys left out of a case take their values from.
    pub enum Numerics {
        /// Shock viscosity, contact at the edges, a mesh that is fine around the hit.
        Default = "default",
        /// The paper's own: one even element per crossover, contact at nodes, stretches at the centre, no viscosity.
        Paper = "paper",
    }
    /// Refinement of the mesh around the hit.
    pub enum Accuracy {
        /// The cheapest mesh whose ballistic limit is near the converged one.
        Default = "default",
        /// The mesh from which on the limit stays.
        Converged = "converged",
    }
    /// Whether mirror symmetry may be used.
    pub enum Symmetry {
        /// Where the scene has it.
        Auto = "auto",
        /// Never.
        None = "none",
    }
    /// Where contact with the projectile is sampled.
    pub enum ContactSampling {
        /// At nodes.
        Nodes = "nodes",
        /// At nodes, and where the rim of a flat face crosses the edges of elements.
        Edges = "edges",
    }
    /// Where an element's stretches are taken.
    pub enum StretchSampling {
        /// At its centre.
        Centre = "centre",
        /// Over the element: the root of the mean of their squares.
        Mean = "mean",
    }
    /// When the run ends.
    pub enum RunUntil {
        /// As soon as the outcome is known (or at `end_time`).
        Outcome = "outcome",
        /// As soon as the projectile is through, or flies back free of the fabric (or at `end_time`).
        Separation = "separation",
        /// At `end_time`, whatever happened before.
        EndTime = "end_time",
    }
}

/// Puts what follows from the scheme into the place of keys of the solver that are left out.
pub(super) fn derive(document: &mut Value, record: &Provenance) {
    let bar = document["projectile"]["shape"] == "bar";
    let viscosity = if bar { VISCOSITY_ALONG_A_BAR } else { VISCOSITY };
    let paper = document["solver"]["numerics"] == "paper";
    for (key, own, papers, assumed) in [
        ("shock_viscosity", json!(viscosity), json!(0), false),
        ("failure_length_mm", json!(FAILURE_LENGTH), json!(0), true),
        ("contact_sampling", json!("edges"), json!("nodes"), false),
        ("stretch_sampling", json!("mean"), json!("centre"), false),
    ] {
        if document["solver"].get(key).is_none() {
            let value = if paper { papers } else { own };
            record.derive_text(&format!("/solver/{key}"), text_of(&value), "", assumed && !paper);
            document["solver"][key] = value;
        }
    }
}

impl Case {
    /// Completes the end of the run.
    pub(super) fn complete_end(&mut self, record: &Provenance) -> Result<(), CaseError> {
        let (at, until_end) = ("/solver/end_time_us", self.solver.run_until == RunUntil::EndTime);
        let has_outcome = self.projectile.as_ref().is_some_and(|p| p.motion == Motion::Free) && !until_end;
        if !has_outcome && !record.has(at) {
            let error = CaseError::at(at, "the end of the run", "nothing");
            return Err(error.help("no outcome ends this run: it has no free projectile, or run_until is \"end_time\""));
        }
        if let Some(projectile) = &self.projectile {
            let latest = self.latest_end(projectile);
            record.fill(at, &mut self.solver.end_time, latest, "", false);
        }
        Ok(())
    }

    /// Time by which a shot should be decided [s]: a power of two of the earliest, so that shots of a batch at about one velocity share it.
    fn latest_end(&self, projectile: &Projectile) -> f64 {
        let layers = self.layers();
        let spans = layers.iter().any(|layer| layer.edges.span());
        let half = self.pack.opening().into_iter().fold(0.0, f64::max) * 0.5;
        let yarns =
            layers.iter().flat_map(|layer| [&layer.fabric.warp, &layer.fabric.weft]).filter(|yarn| yarn.present);
        let strain = yarns.map(|yarn| yarn.failure_strain).fold(0.0, f64::max);
        // A pack that spans is a cone at its failure strain; another goes along as far as it is wide.
        let depth = if spans { half * (strain * (2.0 + strain)).sqrt() } else { 2.0 * half };
        // A wave goes through as many elements to the clamps and back.
        let wave =
            layers.iter().map(|layer| critical_step(layer) * layer.mesh.count[0].max(layer.mesh.count[1]) as f64);
        let wave = wave.fold(0.0, f64::max);
        let [diameter, length] = projectile.shape.sizes();
        let way = projectile.standoff + depth + diameter.max(length);
        let time = 2.0 * (way / (projectile.velocity * projectile.obliquity.cos()) + wave);
        let earliest = if spans { EARLIEST } else { EARLIEST_LOOSE };
        (earliest * (time / earliest).log2().ceil().max(0.0).exp2()).min(LATEST)
    }
}

impl Output {
    pub(super) fn check(&self) -> Result<(), CaseError> {
        let Some(index) = self.profile_times.windows(2).position(|pair| pair[0] >= pair[1]) else { return Ok(()) };
        let expected = format!("more than item {index} of \"profile_times_us\": ascending times");
        let found = short_number_text(self.profile_times[index + 1] * 1e6);
        Err(CaseError::at(format!("/output/profile_times_us/{}", index + 1), expected, found))
    }
}

/// A statement about the result, checked after the run.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct Expect {
    /// A name of summary.json, a column of history.csv, or a measured wave quantity.
    #[schemars(length(min = 1))]
    pub quantity: String,
    #[serde(flatten)]
    keys: BoundKeys,
    /// Expected word, value or range.
    #[serde(skip)]
    pub bound: Bound,
    /// Time at which the quantity is read [s].
    #[schemars(rename = "at_us", range(min = 0, max = 1e9))]
    pub at: Option<f64>,
    /// Interval of a measured speed or frequency [s].
    #[schemars(rename = "between_us", inner(range(min = 0, max = 1e9)))]
    pub between: Option<[f64; 2]>,
    /// Where the statement comes from.
    #[schemars(length(min = 1))]
    pub source: String,
    /// Why the statement is known not to hold: shown, and no failure.
    #[schemars(length(min = 1))]
    pub known_difference: Option<String>,
}

/// Expected word, value or range.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[non_exhaustive]
pub enum Bound {
    /// A word, e.g. an outcome.
    Word(String),
    /// |got − value| ≤ tolerance (already absolute, in the quantity's own unit).
    Value {
        /// Expected.
        value: f64,
        /// Allowed absolute difference.
        tolerance: f64,
    },
    /// min ≤ got ≤ max.
    Range {
        /// −∞ when absent.
        min: f64,
        /// +∞ when absent.
        max: f64,
    },
}

impl Default for Bound {
    fn default() -> Self {
        Self::Range { min: f64::NEG_INFINITY, max: f64::INFINITY }
    }
}

/// Keys of a [`Bound`].
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
struct BoundKeys {
    /// The expected number or word.
    value: Option<NumberOrWord>,
    /// Least value; instead of value.
    #[schemars(range(min = -1e15, max = 1e15), extend("at_most" = "max"))]
    min: Option<f64>,
    /// Largest value; instead of value.
    #[schemars(range(min = -1e15, max = 1e15))]
    max: Option<f64>,
    /// Allowed difference from a number, absolute or "1%".
    tolerance: Option<Tolerance>,
}

#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged)]
enum NumberOrWord {
    Number(#[schemars(range(min = -1e15, max = 1e15))] f64),
    Word(String),
}

#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged)]
enum Tolerance {
    Absolute(#[schemars(range(min = 0, max = 1e15))] f64),
    Percent(#[schemars(extend("pattern" = "%$"))] String),
}

impl BoundKeys {
    fn bound(&self, at: &str) -> Result<Bound, CaseError> {
        let is_ranged = self.min.is_some() || self.max.is_some();
        let given = match &self.tolerance {
            Some(Tolerance::Absolute(number)) => number_text(*number),
            Some(Tolerance::Percent(text)) => quote(text),
            None => "nothing".to_owned(),
        };
        let (key, expected, found) = match (&self.value, &self.tolerance) {
            (Some(_), _) if is_ranged => ("/value", "either \"value\" or \"min\" and \"max\"", "both"),
            (Some(NumberOrWord::Word(word)), None) => return Ok(Bound::Word(word.clone())),
            (Some(NumberOrWord::Word(_)), Some(_)) => ("/tolerance", "no tolerance with a word as value", &*given),
            (Some(NumberOrWord::Number(_)), None) => {
                ("/tolerance", "a tolerance with a number as value, absolute or like \"1%\"", &*given)
            }
            (&Some(NumberOrWord::Number(value)), Some(Tolerance::Absolute(tolerance))) => {
                return Ok(Bound::Value { value, tolerance: *tolerance });
            }
            (&Some(NumberOrWord::Number(value)), Some(Tolerance::Percent(text))) => {
                return Ok(Bound::Value { value, tolerance: percent(text).unwrap_or_default() * value.abs() });
            }
            (None, Some(_)) => ("/tolerance", "no tolerance without \"value\"", &*given),
            (None, None) if !is_ranged => ("", "\"value\", \"min\" or \"max\"", "none of them"),
            (None, None) => {
                let (min, max) = (self.min.unwrap_or(f64::NEG_INFINITY), self.max.unwrap_or(f64::INFINITY));
                return Ok(Bound::Range { min, max });
            }
        };
        Err(CaseError::at(format!("{at}{key}"), expected, found))
    }
}

impl Expect {
    /// Completes, checks and records the statement with this index.
    pub(super) fn complete(&mut self, index: usize, record: &Provenance) -> Result<(), CaseError> {
        let at = format!("/expect/{index}");
        self.bound = self.keys.bound(&at)?;
        let between = self.between.filter(|[first, last]| first >= last || self.at.is_some());
        if let Some([first, last]) = between {
            let us = |time: f64| short_number_text(time * 1e6);
            let (expected, found) = match first >= last {
                true => ("two times, the earlier one first", format!("[{},{}]", us(first), us(last))),
                false => ("either \"at_us\" or \"between_us\"", "both".to_owned()),
            };
            return Err(CaseError::at(format!("{at}/between_us"), expected, found));
        }
        let bound = match &self.bound {
            Bound::Word(word) => format!("= {}", quote(word)),
            Bound::Value { value, tolerance } => format!("= {} ± {}", number_text(*value), number_text(*tolerance)),
            Bound::Range { min, max } if *max == f64::INFINITY => format!("≥ {}", number_text(*min)),
            Bound::Range { min, max } if *min == f64::NEG_INFINITY => format!("≤ {}", number_text(*max)),
            Bound::Range { min, max } => format!("in [{}, {}]", number_text(*min), number_text(*max)),
        };
        record.note(&at, format!("{} {bound}", self.quantity), "", Origin::Read, &self.source);
        Ok(())
    }
}
