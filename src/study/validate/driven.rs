//! Scenes of `cases/verify` driven otherwise: a crimped strip pulled until it breaks, a membrane pushed by a cone.

use serde_json::json;

use super::{Expected, Prediction, PredictionRun};
use crate::output::history;
use crate::run::Run;
use crate::study::verify::scenes;

/// A scene, and what is read from it.
struct Driven {
    base: &'static str,
    sets: &'static [&'static str],
    group: &'static str,
    source: &'static str,
    because: &'static str,
    /// Half the length of what is pulled [m].
    half: f64,
    /// What is read, and what is expected of it.
    readings: &'static [(Reading, &'static str)],
}

/// What is read from a run.
#[derive(Clone, Copy, Debug)]
enum Reading {
    /// Largest yarn tension at this stretch [N].
    Tension(&'static str),
    /// Stretch when the first yarn breaks.
    Break,
    /// Contact force, mean of the microsecond that ends then [N]; time [µs].
    Force(u32),
    /// Work of the projectile's motion until then [mJ]; time [µs].
    Work(u32),
}

impl Reading {
    fn name(self) -> String {
        match self {
            Self::Tension(stretch) => format!("warp tension at a stretch of {stretch} [N]"),
            Self::Break => "stretch at which the warp breaks".to_owned(),
            Self::Force(time) => format!("contact force, mean of {} to {time} µs [N]", time - 1),
            Self::Work(time) => format!("work of the cone until {time} µs [mJ]"),
        }
    }

    /// Allowed difference: 1 % of what breaks a yarn, 370 N at a strain of 3.5 % of its crimped length, or of what is expected.
    fn tolerance(self, expected: f64) -> f64 {
        match self {
            Self::Tension(_) => 3.7,
            Self::Break => 3.6e-4,
            Self::Force(_) | Self::Work(_) => 0.01 * expected,
        }
    }

    /// The number in the unit of the name.
    fn of(self, run: &Run, half: f64) -> Option<f64> {
        match self {
            Self::Tension(stretch) => tension(run, half, stretch.parse().ok()?),
            Self::Break => breaks(run, half),
            Self::Force(time) => at(run, "contact_force_n", f64::from(time) * 1e-6),
            Self::Work(time) => at(run, "external_work_j", f64::from(time) * 1e-6).map(|work| work * 1e3),
        }
    }
}

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
    half: 101.6e-3,
    readings: &[
        (Reading::Tension("1.02"), "0"),
        (Reading::Tension("1.04"), "187.353"),
        (Reading::Tension("1.05"), "290.294"),
        (Reading::Break, "1.057563"),
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
    half: 50.8e-3,
    readings: &[
        (Reading::Tension("1.01"), "50.0251"),
        (Reading::Tension("1.04"), "277.5448"),
        (Reading::Break, "1.050185"),
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
        r#"/projectile={"shape":"cone","diameter_mm":80,"length_mm":1,"nose_length_mm":0.2,"edge_radius_mm":0,"velocity_m_s":1.18268,"friction":0,
            "motion":"prescribed","rotation":"locked"}"#,
        "/solver/end_time_us=200",
        "/output/history_interval_us=1",
    ],
    group: "Pre-tensioned membrane pushed by a blunt cone at 1.18268 m/s",
    source: "closed form: wave equation outside a growing circle of contact, V/(k c) = b arcosh(1/b)/sqrt(1 - b^2), here b = 0.25; \
             F = 2 pi N k b c t for slope k, tension N, wave speed c in the stretched membrane",
    because: "the circle of contact grows by whole nodes, 1.27 mm of 22 mm",
    half: 101.6e-3,
    readings: &[(Reading::Force(100), "17.243"), (Reading::Force(200), "34.573"), (Reading::Work(200), "4.0992")],
};

/// Adds the rows of each scene; none of an interrupted one.
pub(super) fn add(table: &mut PredictionRun<'_>) {
    for driven in [WEFT_FREE, WEFT_HELD, CONE] {
        let sets = driven.sets.iter().map(ToString::to_string);
        let run = table.changed((driven.base, scenes::text(driven.base)), sets);
        let rows = |run: Run| {
            driven.readings.iter().map(|(reading, expected)| row(&driven, *reading, expected, &run)).collect()
        };
        table.take(driven.group, run.map(rows));
    }
}

fn row(driven: &Driven, reading: Reading, expected: &str, run: &Run) -> Prediction {
    let tolerance = reading.tolerance(expected.parse().unwrap_or(f64::NAN));
    let expected = Expected::number(expected, tolerance, driven.because);
    Prediction::judged(driven.group, &reading.name(), expected, json!(reading.of(run, driven.half)), driven.source)
}
