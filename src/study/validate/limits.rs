//! Velocities at which the outcome changes, found by bisection.

use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::{Value, json};

use super::shots::{SHOTS, shot};
use super::{Expected, Prediction};
use crate::case;
use crate::run::outcome::Outcome;
use crate::run::{Options, Progress, Run};
use crate::study::verify::scenes;

/// A velocity is known to this [m/s].
const WIDTH: f64 = 2.0;

/// What is looked for, and what is known of it.
struct LimitPrediction {
    /// Name and text of the case.
    case: (&'static str, &'static str),
    sets: &'static [&'static str],
    group: &'static str,
    name: &'static str,
    /// What happens above the velocity and not below it.
    happens: fn(&Run) -> bool,
    /// Between these [m/s].
    range: [f64; 2],
    expected: fn() -> Expected,
    source: &'static str,
    known_difference: &'static str,
}

/// The velocities that something is known of.
fn limits() -> [LimitPrediction; 2] {
    let strip = ("strip-compressible-155", scenes::text("strip-compressible-155"));
    [
        LimitPrediction {
            case: strip,
            sets: &["/pack/width_mm=508", "/projectile/offset_mm=[-254,0]", "/solver/end_time_us=80"],
            group: "S-720 strip with its compressible crossovers, struck by a bar along the weft",
            name: "velocity at which its yarns break [m/s]",
            happens: |run| !run.events.is_empty(),
            range: [400.0, 900.0],
            expected: || Expected::Number {
                text: "701".to_owned(),
                value: 701.0,
                tolerance: 0.01 * 701.0,
                because: "as the speeds of its waves",
            },
            source: "closed form: the strip's relation at a yarn strain of 3.5 %",
            known_difference: "tension overshoots behind the first elements of a shock, in spite of the shock viscosity",
        },
        LimitPrediction {
            case: SHOTS[0],
            sets: &[],
            group: "Kevlar 129 S-720, 1 ply, RCC",
            name: "ballistic limit, hit at the centre [m/s]",
            happens: |run| run.outcome == Outcome::Perforated,
            range: [100.0, 300.0],
            expected: || Expected::CurveOnly("below 155".to_owned()),
            source: "paper, Figure 6",
            known_difference: "",
        },
    ]
}

/// Adds a row for each; none of an interrupted one.
pub(super) fn add(
    options: Options<'_>,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&str, &Progress) + Send),
    rows: &mut Vec<Prediction>,
) {
    for limit in limits() {
        let found = bisect(&limit, options, interrupt, progress);
        if interrupt.load(Ordering::Relaxed) {
            return;
        }
        rows.push(match found {
            Ok(found) => {
                let (expected, got) = ((limit.expected)(), found.map_or(Value::Null, |found| json!(found)));
                let row = Prediction::judged(limit.group, limit.name, expected, got, limit.source);
                Prediction { known_difference: limit.known_difference.to_owned(), ..row }
            }
            Err(why) => Prediction::failed(limit.group, why),
        });
    }
}

/// The middle of an interval of `WIDTH` at whose upper end it happens and at whose lower end it does not; `None`: not within the
/// range.
fn bisect(
    limit: &LimitPrediction,
    options: Options<'_>,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&str, &Progress) + Send),
) -> Result<Option<f64>, String> {
    let (name, text) = limit.case;
    let mut happens = |velocity: f64| {
        let own = ["/expect=[]", "/output/profile_times_us=[]"].iter().chain(limit.sets).map(ToString::to_string);
        let sets: Vec<String> = own.chain([format!("/projectile/velocity_m_s={velocity}")]).collect();
        let case = case::from_str(name, text, &sets).map_err(|error| error.to_string())?;
        shot(&case, options, interrupt, progress).map(|run| (limit.happens)(&run))
    };
    let [mut below, mut above] = limit.range;
    if happens(below)? || !happens(above)? {
        return Ok(None);
    }
    while above - below > WIDTH && !interrupt.load(Ordering::Relaxed) {
        let middle = 0.5 * (below + above);
        if happens(middle)? { above = middle } else { below = middle }
    }
    Ok(Some(0.5 * (below + above)))
}
