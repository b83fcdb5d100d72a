//! Velocities at which the outcome changes, found by bisection.

use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::{Value, json};

use super::shots::{SHOTS, shot};
use super::{Expected, Prediction};
use crate::case;
use crate::run::outcome::Outcome;
use crate::run::{Options, Progress, Run};
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
pub(super) fn add(
    options: Options<'_>,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&str, &Progress) + Send),
    rows: &mut Vec<Prediction>,
) {
    let mut find = |limit: &Limit<'_>| find(limit, options, interrupt, progress);
    let found = strip(&mut find);
    if !interrupt.load(Ordering::Relaxed) {
        rows.push(found);
    }
    let found = one_ply(&mut find);
    if !interrupt.load(Ordering::Relaxed) {
        rows.extend(found);
    }
}

type Find<'a> = dyn FnMut(&Limit<'_>) -> Result<Option<f64>, String> + 'a;

/// The strip whose yarns break by a wave alone.
fn strip(find: &mut Find<'_>) -> Prediction {
    const BASE: &str = "strip-compressible-155";
    const GROUP: &str = "S-720 strip with its compressible crossovers, struck by a bar along the weft";
    let limit = Limit {
        case: (BASE, scenes::text(BASE)),
        sets: &["/pack/width_mm=508", "/projectile/offset_mm=[-254,0]", "/solver/end_time_us=80"],
        happens: |run| !run.events.is_empty(),
        range: [400.0, 900.0],
        width: WIDTH,
    };
    let expected = Expected::Number {
        text: "701".to_owned(),
        value: 701.0,
        tolerance: 0.01 * 701.0,
        because: "as the speeds of its waves",
    };
    let name = "velocity at which its yarns break [m/s]";
    let source = "closed form: the strip's relation at a yarn strain of 3.5 %";
    let row = match find(&limit) {
        Ok(found) => Prediction::judged(GROUP, name, expected, number(found), source),
        Err(why) => return Prediction::failed(GROUP, why),
    };
    let why = "tension overshoots behind the first elements of a shock, in spite of the shock viscosity";
    Prediction { known_difference: why.to_owned(), ..row }
}

/// The limit of the paper's ply, and what becomes of it with other fibres.
fn one_ply(find: &mut Find<'_>) -> Vec<Prediction> {
    const GROUP: &str = "Kevlar 129 S-720, 1 ply, RCC";
    let limit = match find(&ONE_PLY) {
        Ok(limit) => limit,
        Err(why) => return vec![Prediction::failed(GROUP, why)],
    };
    let open = |name: &str, expected: &str, got: Option<f64>, source: &str| {
        Prediction::judged(GROUP, name, Expected::CurveOnly(expected.to_owned()), number(got), source)
    };
    let mut rows = vec![
        open("ballistic limit, hit at the centre [m/s]", "below 155", limit, "paper, Figure 6"),
        open(
            "limit in percent of Cunniff's scale",
            "a curve over the areal density",
            limit.map(|limit| 100.0 * limit / SCALE),
            CUNNIFF,
        ),
    ];
    for scaled in SCALED {
        let other = Limit { sets: scaled.sets, range: [150.0, 450.0], ..ONE_PLY };
        let found = match find(&other) {
            Ok(found) => found.zip(limit).map(|(found, limit)| found / limit),
            Err(why) => {
                rows.push(Prediction::failed(GROUP, why));
                continue;
            }
        };
        rows.extend(scaled.expected.iter().map(|(expected, source)| {
            let value: f64 = expected.parse().unwrap_or(f64::NAN);
            let expected = Expected::Number {
                text: (*expected).to_owned(),
                value,
                tolerance: 0.05 * value,
                because: "lines of nodes elsewhere under the hit move a limit by 5 %",
            };
            let row = Prediction::judged(GROUP, scaled.name, expected, number(found), source);
            Prediction { known_difference: scaled.known_difference.to_owned(), ..row }
        }));
    }
    rows
}

fn number(found: Option<f64>) -> Value {
    found.map_or(Value::Null, |found| json!(found))
}

/// The middle of an interval at whose upper end it happens and at whose lower end it does not; `None`: not within the
/// range.
pub(super) fn find(
    limit: &Limit<'_>,
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
    while above - below > limit.width && !interrupt.load(Ordering::Relaxed) {
        let middle = 0.5 * (below + above);
        if happens(middle)? { above = middle } else { below = middle }
    }
    Ok(Some(0.5 * (below + above)))
}
