//! Scenes of `cases/verify` driven otherwise: a crimped strip pulled until it breaks, a membrane pushed by a cone.

use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::{Value, json};

use super::shots::shot;
use super::{Expected, Prediction};
use crate::case;
use crate::output::history;
use crate::run::{Options, Progress, Run};
use crate::study::verify::scenes;

/// A scene, and what is read from it.
struct Driven {
    base: &'static str,
    sets: &'static [&'static str],
    group: &'static str,
    source: &'static str,
    because: &'static str,
    readings: &'static [DrivenReading],
}

/// One number of a run.
struct DrivenReading {
    name: &'static str,
    expected: &'static str,
    /// Allowed difference, in the unit of the name.
    tolerance: f64,
    read: fn(&Run) -> Option<f64>,
}

/// Half the length of the strip that is pulled, with its weft free and held [m].
const FREE: f64 = 101.6e-3;
const HELD: f64 = 50.8e-3;

/// Largest yarn tension when the halves of a strip, pulled apart by a bar in its middle, have this stretch [N].
fn tension(run: &Run, half: f64, stretch: f64) -> Option<f64> {
    let column = history::find("max_yarn_tension_n")?;
    let way = half * (stretch * stretch - 1.0).sqrt();
    let time = history::between(&run.history, way, |row| row.projectile_displacement, |row| row.time)?;
    history::at(&run.history, column, time)
}

/// Stretch of the halves of the strip when its first yarn breaks [-].
fn breaks(run: &Run, half: f64) -> Option<f64> {
    let first = run.events.first()?;
    let time = first.step as f64 * run.time_step;
    let way = history::between(&run.history, time, |row| row.time, |row| row.projectile_displacement)?;
    Some((1.0 + (way / half).powi(2)).sqrt())
}

/// A column of the history at a time [s].
fn at(run: &Run, column: &str, time: f64) -> Option<f64> {
    history::at(&run.history, history::find(column)?, time)
}

/// 1 % of the strain that breaks a yarn, as stretch of the strip.
const BREAKS: f64 = 3.6e-4;
/// 1 % of the load that breaks a yarn [N].
const TENSION: f64 = 3.7;

const PULL: &str = "a bar pulls at 5 m/s: the strip rings by 1 % of what breaks it";

const WEFT_FREE: Driven = Driven {
    base: "strip-crimped-155",
    sets: &[
        "/pack/width_mm=203.2",
        "/pack/height_mm=5.08",
        "/pack/crossovers_per_element=2",
        r#"/pack/edges={"left":"clamped","right":"clamped","bottom":"free","top":"free"}"#,
        r#"/projectile={"shape":"bar","diameter_mm":0.2,"velocity_m_s":5,"friction":0,"motion":"prescribed","along":"weft"}"#,
        "/solver/end_time_us=7100",
    ],
    group: "Crimped S-720 strip pulled along the warp, weft free",
    source: "closed form: T = EA (L/1.0218 - 1) at a stretch L beyond 1.0218: all crimp has gone into the weft",
    because: PULL,
    readings: &[
        DrivenReading {
            name: "warp tension at a stretch of 1.02 [N]",
            expected: "0",
            tolerance: TENSION,
            read: |run| tension(run, FREE, 1.02),
        },
        DrivenReading {
            name: "warp tension at a stretch of 1.04 [N]",
            expected: "187.353",
            tolerance: TENSION,
            read: |run| tension(run, FREE, 1.04),
        },
        DrivenReading {
            name: "warp tension at a stretch of 1.05 [N]",
            expected: "290.294",
            tolerance: TENSION,
            read: |run| tension(run, FREE, 1.05),
        },
        DrivenReading {
            name: "stretch at which the warp breaks",
            expected: "1.057563",
            tolerance: BREAKS,
            read: |run| breaks(run, FREE),
        },
    ],
};

const WEFT_HELD: Driven = Driven {
    base: "strip-crimped-155",
    sets: &[
        "/pack/width_mm=101.6",
        "/pack/height_mm=10.16",
        "/pack/crossovers_per_element=4",
        r#"/pack/edges={"left":"clamped","right":"clamped","bottom":"roller","top":"roller"}"#,
        r#"/projectile={"shape":"bar","diameter_mm":0.2,"velocity_m_s":5,"friction":0,"motion":"prescribed","along":"weft"}"#,
        "/solver/end_time_us=3350",
    ],
    group: "Crimped S-720 strip pulled along the warp, weft held",
    source: "closed form: the unit cell (11)-(24) solved to 40 digits, weft at its length",
    because: PULL,
    readings: &[
        DrivenReading {
            name: "warp tension at a stretch of 1.01 [N]",
            expected: "50.0251",
            tolerance: TENSION,
            read: |run| tension(run, HELD, 1.01),
        },
        DrivenReading {
            name: "warp tension at a stretch of 1.04 [N]",
            expected: "277.5448",
            tolerance: TENSION,
            read: |run| tension(run, HELD, 1.04),
        },
        DrivenReading {
            name: "stretch at which the warp breaks",
            expected: "1.050185",
            tolerance: BREAKS,
            read: |run| breaks(run, HELD),
        },
    ],
};

/// Tension 50 kN/m both ways stretches the fabric by 1.006037: waves run at c = 443.968 m/s in it. The cone is as high as 0.005 of its
/// radius. It touches the membrane up to a radius of b c t. Outside, the wave equation has the solution
/// w = A (t arcosh(ct/r) - sqrt(t² - r²/c²)), which depends on r/t alone. It meets the cone with the same height and slope.
const CONE: Driven = Driven {
    base: "membrane-frequency",
    sets: &[
        "/pack/width_mm=203.2",
        "/pack/height_mm=203.2",
        "/pack/crossovers_per_element=1",
        r#"/pack/pretension={"warp_n_per_m":50000,"weft_n_per_m":50000}"#,
        "/pack/initial_deflection=null",
        r#"/projectile={"shape":"cone","diameter_mm":80,"length_mm":1,"nose_length_mm":0.2,"velocity_m_s":1.18268,"friction":0,
            "motion":"prescribed","rotation":"locked"}"#,
        "/solver/end_time_us=200",
        "/output/history_interval_us=1",
    ],
    group: "Pre-tensioned membrane pushed by a blunt cone at 1.18268 m/s",
    source: "closed form: wave equation outside a growing circle of contact, V/(k c) = b arcosh(1/b)/sqrt(1 - b^2), here b = 0.25; \
             F = 2 pi N k b c t for slope k, tension N, wave speed c in the stretched membrane",
    because: "the circle of contact grows by whole nodes, 1.27 mm of 22 mm",
    readings: &[
        DrivenReading {
            name: "contact force, mean of 99 to 100 µs [N]",
            expected: "17.243",
            tolerance: 0.01 * 17.243,
            read: |run| at(run, "contact_force_n", 100e-6),
        },
        DrivenReading {
            name: "contact force, mean of 199 to 200 µs [N]",
            expected: "34.573",
            tolerance: 0.01 * 34.573,
            read: |run| at(run, "contact_force_n", 200e-6),
        },
        DrivenReading {
            name: "work of the cone until 200 µs [mJ]",
            expected: "4.0992",
            tolerance: 0.01 * 4.0992,
            read: |run| at(run, "external_work_j", 200e-6).map(|work| work * 1e3),
        },
    ],
};

/// Adds the rows of each scene; none of an interrupted one.
pub(super) fn add(
    options: Options<'_>,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&str, &Progress) + Send),
    rows: &mut Vec<Prediction>,
) {
    for driven in [WEFT_FREE, WEFT_HELD, CONE] {
        let run = run(&driven, options, interrupt, progress);
        if interrupt.load(Ordering::Relaxed) {
            return;
        }
        match run {
            Ok(run) => rows.extend(driven.readings.iter().map(|reading| row(&driven, reading, &run))),
            Err(why) => rows.push(Prediction::failed(driven.group, why)),
        }
    }
}

fn run(
    driven: &Driven,
    options: Options<'_>,
    interrupt: &AtomicBool,
    progress: &mut (dyn FnMut(&str, &Progress) + Send),
) -> Result<Run, String> {
    let own = ["/expect=[]", "/output/profile_times_us=[]"];
    let sets: Vec<String> = own.iter().chain(driven.sets).map(ToString::to_string).collect();
    let case = case::from_str(driven.base, scenes::text(driven.base), &sets).map_err(|error| error.to_string())?;
    shot(&case, options, interrupt, progress)
}

fn row(driven: &Driven, reading: &DrivenReading, run: &Run) -> Prediction {
    let expected = Expected::Number {
        text: reading.expected.to_owned(),
        value: reading.expected.parse().unwrap_or(f64::NAN),
        tolerance: reading.tolerance,
        because: driven.because,
    };
    let got = (reading.read)(run).map_or(Value::Null, |got| json!(got));
    Prediction::judged(driven.group, reading.name, expected, got, driven.source)
}
