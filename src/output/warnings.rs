//! Numbered warnings, `W1` to `W9`, and the sheet of a case before its run, the JSON of `ripstop check`.
//!
//! A code and a name, once given, stay. [`super::checks`] decides which of them a run calls for.

use std::num::NonZero;
use std::thread;

use serde::Serialize;
use serde_json::{Value, json};

use super::breakage::is_missed;
use super::checks::case_warnings;
use super::number::short;
use super::summary;
use crate::case::{Case, CaseError, Field, Layer, Motion, Yarn};
use crate::run::{Sample, Simulation};

/// Mean densities a projectile may have [kg/m³]: from light plastics to osmium.
const DENSITY_LIMITS: [f64; 2] = [900.0, 22_600.0];
/// Difference of a given areal density from that of the yarns, over the latter, that is pointed out, and that is refused [-].
const AREAL_LIMITS: [f64; 2] = [0.05, 0.25];
/// Densities of textile fibres [kg/m³]: polyethylene has 970, basalt 2800.
const FIBRE_DENSITIES: [f64; 2] = [900.0, 3000.0];
/// Stress at break that no fibre has [Pa]: the strongest, of PBO and of carbon, break at 6 to 7 GPa.
const STRONGEST: f64 = 8e9;
/// Difference of a given mass from that of the given density, over the latter [-].
const DENSITY_TOLERANCE: f64 = 0.05;

/// Time of an element-step of what symmetry leaves, on one thread [µs]: of one ply, twice what a core of a Zen 5 takes; of packs as twelve
/// plies that tear took on a slower core, two thirds of it for contact between them.
const ELEMENT_STEP: [f64; 2] = [0.1, 0.6];

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
    let projectile = case.projectile.as_ref().filter(|p| !p.shape.is_bar() && p.motion == Motion::Free)?;
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

/// The first of those groups of plies that weigh other than their yarns by so much [-], with both areal densities [g/m²].
fn off_weight(case: &Case, limit: f64, counts: impl Fn(usize, &Layer) -> bool) -> Option<(usize, [f64; 2])> {
    let weights = |layer: &Layer| [layer.fabric.areal_density, layer.fabric.areal_density_of_yarns()];
    let is_off = |[given, yarns]: [f64; 2]| (given / yarns - 1.0).abs() >= limit;
    let layers = case.layers();
    let (index, off) =
        layers.iter().enumerate().find(|(index, layer)| is_off(weights(layer)) && counts(*index, layer))?;
    Some((index, weights(off).map(|density| density * 1e3)))
}

/// Warning of a fabric that weighs other than its yarns.
pub(super) fn areal_density(case: &Case) -> Option<Warning> {
    let (_, [given, yarns]) = off_weight(case, AREAL_LIMITS[0], |_, _| true)?;
    Some(warning(7, given, yarns, format!("a ply of {} g/m² has yarns of {} g/m²", short(given, 4), short(yarns, 4))))
}

/// Warning of a fibre that there is not.
pub(super) fn fibre(case: &Case) -> Option<Warning> {
    let of_layer = |layer: &Layer| {
        let (density, [lightest, densest]) = (layer.fabric.fibre_density, FIBRE_DENSITIES);
        let limit = density.clamp(lightest, densest);
        let message = format!("a fibre of {density:.0} kg/m³: textile fibres have {lightest:.0} to {densest:.0}");
        let off_density = (density != limit).then(|| warning(9, density, limit, message));
        let stress = |yarn: &Yarn| {
            let linear = yarn.breaking_strain().map(|_| yarn.failure_strain * yarn.modulus);
            yarn.curve.last().map(|point| point[1]).or(linear).unwrap_or(0.0)
        };
        let stress = [&layer.fabric.warp, &layer.fabric.weft].map(stress).into_iter().fold(0.0, f64::max);
        let [found, most] = [stress, STRONGEST].map(|stress| stress * 1e-9);
        let message = format!("a yarn that breaks at {} GPa: no fibre does above {most}", short(found, 3));
        off_density.or_else(|| (found > most).then(|| warning(9, found, most, message)))
    };
    case.layers().iter().find_map(of_layer)
}

/// Refuses a case whose result would say nothing: a projectile that meets no fabric, a fabric that cannot weigh what it is said to.
///
/// # Errors
/// The first of them. An areal density marked as assumed, or of a fabric without yarns one way, which resin may hold, is [`KINDS`] W7 only.
pub fn refuse(case: &Case) -> Result<(), CaseError> {
    let file = case.path.display().to_string();
    if let Some(projectile) = case.projectile.as_ref().filter(|projectile| is_missed(case, projectile)) {
        let [x, y] = projectile.offset.map(|offset| short(offset * 1e3, 4));
        let expected = "a hit on free fabric, inside the frame and the sides of the pack";
        let help = "a body aimed at a clamped side strikes the frame, one that passes the sides strikes nothing";
        return Err(CaseError::new(&file, "/projectile/offset_mm", expected, format!("[{x}, {y}] mm"), help));
    }
    let field = |index: usize| {
        let own = format!("/pack/layup/{index}/fabric/areal_density_g_m2");
        let at = |pointer: &str| case.fields.iter().find(|field| field.pointer == pointer);
        at(&own).or_else(|| at("/fabric/areal_density_g_m2"))
    };
    let is_woven = |layer: &Layer| layer.fabric.warp.present && layer.fabric.weft.present;
    let counts = |index, layer: &Layer| is_woven(layer) && field(index).is_some_and(|field| !field.assumed);
    let Some((index, [given, yarns])) = off_weight(case, AREAL_LIMITS[1], counts) else { return Ok(()) };
    let place = field(index).map_or("/fabric", |field| &field.pointer);
    let expected = format!("about {} g/m², which the yarns weigh by linear density, crimp and count", short(yarns, 4));
    let help =
        "look at the units of both, or leave it out; of coated fabric let /sources say \"assumed: coated\" for it";
    Err(CaseError::new(&file, place, expected, format!("{} g/m²", short(given, 4)), help))
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
pub static KINDS: [WarningKind; 9] = [
    WarningKind { code: "W1", name: "assumed-parameters" },
    WarningKind { code: "W2", name: "energy" },
    WarningKind { code: "W3", name: "hourglass" },
    WarningKind { code: "W4", name: "penetration" },
    WarningKind { code: "W5", name: "coarse-mesh" },
    WarningKind { code: "W6", name: "small-projectile" },
    WarningKind { code: "W7", name: "mass" },
    WarningKind { code: "W8", name: "torn-off" },
    WarningKind { code: "W9", name: "fibre" },
];

/// Numbers of a case that are held against a data sheet, those of its run, and every field.
pub fn sheet(case: &Case, simulation: &Simulation<f64>) -> Value {
    let energy = case.projectile.as_ref().map(|p| 0.5 * p.mass * p.velocity * p.velocity);
    json!({
        "file": case.path.display().to_string(),
        "title": case.title,
        "fabrics": case.layers().iter().map(fabric).collect::<Vec<_>>(),
        "areal_density_kg_m2": summary::areal_density(case),
        "impact_energy_j": energy,
        "run": the_run(case, simulation),
        "fields": case.fields.iter().map(field).collect::<Vec<_>>(),
        "notes": case.notes,
        "warnings": case_warnings(case),
    })
}

fn fabric(layer: &Layer) -> Value {
    let fabric = &layer.fabric;
    let mut one = json!({
        "name": fabric.name, "plies": layer.plies, "areal_density_g_m2": 1e3 * fabric.areal_density,
    });
    for (name, yarn) in [("warp", &fabric.warp), ("weft", &fabric.weft)].into_iter().filter(|(_, yarn)| yarn.present) {
        let load = yarn.breaking_strain().map(|strain| strain * yarn.modulus * yarn.area(fabric.fibre_density));
        one[name] = json!({ "breaking_load_n": load, "wave_speed_m_s": (yarn.modulus / fabric.fibre_density).sqrt() });
    }
    one
}

fn field(field: &Field) -> Value {
    json!({
        "pointer": field.pointer, "value": field.value, "unit": field.unit, "origin": field.origin.word(),
        "source": field.source, "assumed": field.assumed,
    })
}

/// Time step, size and memory of the run.
fn the_run(case: &Case, simulation: &Simulation<f64>) -> Value {
    let (model, state) = (&simulation.model, &simulation.state);
    let steps = (case.solver.end_time / model.dt).ceil() as u64 + 1;
    let rows = (case.solver.end_time / case.output.history_interval).ceil() + 1.0;
    let numbers = (state.nodes.data.len() + state.elements.data.len()) * size_of::<f64>();
    json!({
        "critical_time_step_us": 1e6 * model.bound.critical_step, "set_by": model.bound.set_by,
        "time_step_us": 1e6 * model.dt, "steps": steps, "elements": model.whole_elements(),
        "run_time_s": run_time(model.plies.len(), model.elements(), steps as f64),
        "memory_bytes": numbers as f64 + rows * size_of::<Sample>() as f64,
    })
}

/// Time of an element-step of a pack of so many plies [µs].
pub fn element_step(plies: usize) -> f64 {
    ELEMENT_STEP[usize::from(plies > 1)]
}

/// Run time of so many steps of a pack on all threads, at most [s].
pub fn run_time(plies: usize, elements: usize, steps: f64) -> f64 {
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    1e-6 * element_step(plies) * elements as f64 * steps / threads as f64
}
