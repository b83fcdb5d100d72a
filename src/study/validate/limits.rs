//! Velocities at which the outcome changes, found by bisection.

use serde_json::json;

use super::shots::SHOTS;
use super::{Expected, Prediction, PredictionRun};
use crate::run::Run;
use crate::run::outcome::Outcome;
use crate::study::verify::scenes;

/// A velocity of a single ply or a strip is known to this [m/s].
const WIDTH: f64 = 2.0;

/// A velocity that is looked for.
#[derive(Clone, Copy)]
pub(super) struct Limit<'a> {
    /// Name and text of the case.
    pub(super) case: (&'a str, &'a str),
    /// What is changed in it.
    pub(super) sets: &'a [&'a str],
    /// What happens above the velocity and not below it.
    pub(super) happens: fn(&Run) -> bool,
    /// Between these [m/s].
    pub(super) range: [f64; 2],
    /// Width of the interval that is found [m/s].
    pub(super) width: f64,
}

/// The projectile is through.
pub(super) fn perforates(run: &Run) -> bool {
    run.outcome == Outcome::Perforated
}

/// The paper's single ply, hit at its centre.
const ONE_PLY: Limit<'static> =
    Limit { case: SHOTS[0], sets: &[], happens: perforates, range: [100.0, 300.0], width: WIDTH };

/// What a scale says of the limit of the paper's ply when its fibres are others.
struct Scaled {
    name: &'static str,
    sets: &'static [&'static str],
    /// Limit expected over that of the ply as it is, and who says so.
    expected: &'static [(&'static str, &'static str)],
    /// Why a row may fail.
    known_difference: &'static str,
}

const SCALED: [Scaled; 2] = [
    Scaled {
        name: "limit with twice the modulus over limit",
        sets: &["/fabric/warp/modulus_gpa=192", "/fabric/weft/modulus_gpa=192"],
        expected: &[("1.414", CUNNIFF)],
        known_difference: "",
    },
    Scaled {
        name: "limit with twice the failure strain over limit",
        sets: &["/fabric/warp/failure_strain=0.07", "/fabric/weft/failure_strain=0.07"],
        expected: &[("1.587", CUNNIFF), ("1.682", MEMBRANE)],
        known_difference: "an exponent of 2/3 is fitted to measured limits of packs; the membrane theory of one ply has 3/4",
    },
];

const CUNNIFF: &str = "published: Cunniff's scale (U*)^(1/3), U* = (strength x failure strain)/(2 rho) sqrt(E/rho): the limit goes as \
                       sqrt(E) and as (failure strain)^(2/3)";
const MEMBRANE: &str =
    "published: membrane theory of Phoenix and Porwal, read second-hand: the limit goes as (failure strain)^(3/4)";

/// The paper's fibre: 96 GPa, 3.5 %, 1440 kg/m³ [m/s].
const SCALE: f64 = 693.0;

/// Adds a row for each; none of an interrupted one.
pub(super) fn add(table: &mut PredictionRun<'_>) {
    strip(table);
    one_ply(table);
}

/// The strip whose yarns break by a wave alone.
fn strip(table: &mut PredictionRun<'_>) {
    const BASE: &str = "strip-compressible-155";
    const GROUP: &str = "S-720 strip with its compressible crossovers, struck by a bar along the weft";
    let limit = Limit {
        case: (BASE, scenes::text(BASE)),
        sets: &["/pack/width_mm=508", "/projectile/offset_mm=[-254,0]", "/solver/end_time_us=80"],
        happens: |run| !run.events.is_empty(),
        range: [400.0, 900.0],
        width: WIDTH,
    };
    let expected = Expected::number("701", 0.01 * 701.0, "as the speeds of its waves");
    let name = "velocity at which its yarns break [m/s]";
    let source = "closed form: the strip's relation at a yarn strain of 3.5 %";
    let why = "the bar starts at once: its kink sends a pulse that overshoots in the first elements, in spite of the shock viscosity";
    let found = limit.find(table);
    let row = |found| Prediction::judged(GROUP, name, expected, json!(found), source).known(why);
    table.take(GROUP, found.map(|found: Option<f64>| vec![row(found)]));
}

/// The limit of the paper's ply, and what becomes of it with other fibres.
fn one_ply(table: &mut PredictionRun<'_>) {
    const GROUP: &str = "Kevlar 129 S-720, 1 ply, RCC";
    let limit = match ONE_PLY.find(table) {
        Ok(limit) => limit,
        Err(why) => return table.take(GROUP, Err(why)),
    };
    let open = |name: &str, expected: &str, got: Option<f64>, source: &str| {
        Prediction::judged(GROUP, name, Expected::CurveOnly(expected.to_owned()), json!(got), source)
    };
    let of_scale = limit.map(|limit| 100.0 * limit / SCALE);
    let rows = vec![
        open("ballistic limit, hit at the centre [m/s]", "below 155", limit, "paper, Figure 6"),
        open("limit in percent of Cunniff's scale", "a curve over the areal density", of_scale, CUNNIFF),
    ];
    table.take(GROUP, Ok(rows));
    for scaled in SCALED {
        let found = Limit { sets: scaled.sets, range: [150.0, 450.0], ..ONE_PLY }.find(table);
        let row = |found: Option<f64>, (text, source): &(&str, &str)| {
            let because = "lines of nodes elsewhere under the hit move a limit by 5 %";
            let expected = Expected::number(*text, 0.05 * text.parse().unwrap_or(f64::NAN), because);
            let ratio = found.zip(limit).map(|(found, limit)| found / limit);
            Prediction::judged(GROUP, scaled.name, expected, json!(ratio), source).known(scaled.known_difference)
        };
        let rows = found.map(|found| scaled.expected.iter().map(|expected| row(found, expected)).collect());
        table.take(GROUP, rows);
    }
}

impl Limit<'_> {
    /// The middle of an interval at whose upper end it happens and at whose lower end it does not; `None`: not within the
    /// range.
    pub(super) fn find(&self, table: &mut PredictionRun<'_>) -> Result<Option<f64>, String> {
        let mut happens = |velocity: f64| {
            let sets = self.sets.iter().map(ToString::to_string);
            let run = table.changed(self.case, sets.chain([format!("/projectile/velocity_m_s={velocity}")]));
            run.map(|run| (self.happens)(&run))
        };
        let [mut below, mut above] = self.range;
        if happens(below)? || !happens(above)? {
            return Ok(None);
        }
        while above - below > self.width {
            let middle = 0.5 * (below + above);
            if happens(middle)? { above = middle } else { below = middle }
        }
        Ok(Some(0.5 * (below + above)))
    }
}
