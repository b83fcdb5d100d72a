//! Numbered warnings, `W1` to `W8`. A code and a name, once given, stay. [`super::checks`] decides which of them a run calls for.

use serde::Serialize;

use super::number::short;
use crate::case::{Case, Field, Layer, Motion, Shape};

/// Mean densities a projectile may have [kg/m³]: from light plastics to osmium.
const DENSITY_LIMITS: [f64; 2] = [900.0, 22_600.0];
/// Areal density over that of the yarns, or the reverse, that no coating makes [-].
const AREAL_FACTOR: f64 = 3.0;
/// Difference of a given mass from that of the given density, over the latter [-].
const DENSITY_TOLERANCE: f64 = 0.05;

/// A warning that a case or a run calls for: the number found and the one it is held against.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Warning {
    /// Kind.
    #[serde(flatten)]
    pub kind: &'static WarningKind,
    /// Message of one line.
    pub message: String,
    /// Value measured; counts and fractions [-], depths [mm].
    pub value: f64,
    /// Limit in the same unit.
    pub limit: f64,
}

pub(super) fn warning(number: usize, value: f64, limit: f64, message: String) -> Warning {
    Warning { kind: &KINDS[number - 1], message, value, limit }
}

/// Fields without a published value.
pub fn assumed_fields(case: &Case) -> impl Iterator<Item = &Field> {
    case.fields.iter().filter(|field| field.assumed)
}

pub(super) fn assumed(case: &Case) -> Option<Warning> {
    let count = assumed_fields(case).count();
    let what = if count == 1 { "1 parameter is".to_owned() } else { format!("{count} parameters are") };
    (count > 0).then(|| warning(1, count as f64, 0.0, format!("{what} assumed, not published")))
}

/// Warning of a mass that no solid of this size has.
pub(super) fn mass(case: &Case) -> Option<Warning> {
    let projectile = case.projectile.as_ref()?;
    if matches!(projectile.shape, Shape::Bar { .. }) || projectile.motion == Motion::Prescribed {
        return None;
    }
    let volume = projectile.shape.volume();
    let found = projectile.mass / volume;
    let body = format!("{} g in {} cm³ are {found:.0} kg/m³", short(projectile.mass * 1e3, 3), short(volume * 1e6, 3));
    let [lightest, densest] = DENSITY_LIMITS;
    let (limit, words) = match projectile.density {
        Some(given) if (found / given - 1.0).abs() > DENSITY_TOLERANCE => {
            (given, format!(", not the {given:.0} of /projectile/density_kg_m3"))
        }
        _ if found > densest => (densest, ", more than the densest metal has".to_owned()),
        _ if found < lightest => (lightest, ": hollow, or a slip of a unit".to_owned()),
        _ => return None,
    };
    Some(warning(7, found, limit, body + &words))
}

/// Warning of a fabric that weighs other than its yarns.
pub(super) fn areal_density(case: &Case) -> Option<Warning> {
    let found = |layer: &Layer| [layer.fabric.areal_density, layer.fabric.areal_density_of_yarns()];
    let is_slip = |[given, yarns]: &[f64; 2]| !(yarns / AREAL_FACTOR..=yarns * AREAL_FACTOR).contains(given);
    let [given, yarns] = case.layers().iter().map(found).find(is_slip)?.map(|density| density * 1e3);
    let words = format!("a ply of {} g/m² has yarns of {} g/m²: a slip of a unit", short(given, 3), short(yarns, 3));
    Some(warning(7, given, yarns, words))
}

/// Kind of warning; `ripstop explain` says more.
#[derive(Debug, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct WarningKind {
    /// `W1`, `W2`, …
    pub code: &'static str,
    /// Name of a word or two, for scripts and people.
    pub name: &'static str,
}

/// All kinds of warnings, in order of their codes.
pub static KINDS: [WarningKind; 8] = [
    WarningKind { code: "W1", name: "assumed-parameters" },
    WarningKind { code: "W2", name: "energy" },
    WarningKind { code: "W3", name: "hourglass" },
    WarningKind { code: "W4", name: "penetration" },
    WarningKind { code: "W5", name: "coarse-mesh" },
    WarningKind { code: "W6", name: "small-projectile" },
    WarningKind { code: "W7", name: "mass" },
    WarningKind { code: "W8", name: "torn-off" },
];
