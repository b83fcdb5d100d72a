//! Measured V50 of packs, from few plies to many, beside computed limits.
//!
//! The fabric's count, linear density and crimp were not found, nor were the edges of the target: they are assumed, as the case says.
//! Nothing was changed to come nearer. Rows are computed only where they are asked for: together they take a long time.

use serde_json::json;

use super::limits::{Limit, perforates};
use super::{Expected, Prediction, PredictionRun};
use crate::run::Precision;

const CASE: (&str, &str) = ("twaron-ct612-4ply-200", include_str!("../../../cases/twaron-ct612-4ply-200.json"));
const GROUP: &str = "Twaron CT612 WRT, fragment simulator of 1.10 g";
const SOURCE: &str = "published: Kosla et al., Materials 2022, 15, 2314, Table 5, read second-hand";
const KNOWN: &str = "the yarns' constants, count and crimp are assumed, and the pack that was shot at was sewn; as for the paper's \
                     ply, the computed limit is too high";

/// Plies, and the V50 that was measured [m/s].
const MEASURED: [(u32, f64); 5] = [(21, 438.0), (38, 585.0), (42, 620.0), (48, 645.0), (62, 700.0)];

/// Limits are looked for between these parts of the measured ones.
const RANGE: [f64; 2] = [0.75, 2.0];
/// Width of the interval that is found, over the measured limit.
const WIDTH: f64 = 0.03;

/// Adds a row for each pack; none of an interrupted one.
pub(super) fn add(table: &mut PredictionRun<'_>) {
    // Half the time, and less than the width of the interval.
    table.options.precision = Precision::F32;
    for (plies, measured) in MEASURED {
        let sets = [format!("/pack/plies={plies}")];
        let limit = Limit {
            case: CASE,
            sets: &sets.each_ref().map(String::as_str),
            happens: perforates,
            range: RANGE.map(|part| part * measured),
            width: WIDTH * measured,
        };
        let found = limit.find(table);
        table.take(GROUP, found.map(|found| vec![row(plies, measured, found)]));
    }
}

fn row(plies: u32, measured: f64, found: Option<f64>) -> Prediction {
    let because = "the six shots that make a V50 of STANAG 2920 lie within 40 m/s";
    let expected = Expected::number(measured.to_string(), 20.0, because);
    let name = format!("V50 of {plies} plies, hit at the centre [m/s]");
    Prediction::judged(GROUP, &name, expected, json!(found), SOURCE).known(KNOWN)
}
