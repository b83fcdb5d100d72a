//! Yarns of a fabric: their keys, and numbers of a data sheet in the place of those that the model needs: a curve of stress over strain for
//! the modulus, strength for failure strain, areal density for crimp.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer};
use serde_json::{Value, json};

use super::CaseError;
use super::error::short_number_text;
use super::fabric::places;
use super::provenance::Provenance;
use super::units::split_unit;

/// Keys that give a strength.
const STRENGTHS: [&str; 4] = ["tenacity_g_den", "tenacity_cn_tex", "strength_mpa", "strength_gpa"];
/// Difference from the chord, over the last stress, of a curve that is straight [-].
const STRAIGHT: f64 = 1e-12;
/// Largest crimp that follows from an areal density [-]: more is a slip of a unit.
const MAX_CRIMP: f64 = 0.25;

/// One yarn system.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default)]
pub struct Yarn {
    /// False when this yarn direction is absent (`"absent": true`): no tension, no crimp, only its count.
    #[serde(rename = "absent", deserialize_with = "not")]
    pub present: bool,
    /// Mass per length of the straight yarn [kg/m].
    pub linear_density: f64,
    /// Fibre elastic modulus; of a yarn with a curve, its steepest slope [Pa].
    pub modulus: f64,
    /// Strain [-] and stress [Pa] of points of a curve from nothing to break, both rising; none: stress is modulus times strain.
    pub curve: Vec<[f64; 2]>,
    /// Axial strain at which the virgin yarn breaks [-].
    pub failure_strain: f64,
    /// Part of that strain, and so of the strength, that is left in the fabric [-].
    pub strength_retention: f64,
    /// Crossovers per metre along this yarn, m in (12): undeformed cell length 2·w0 = 1/count [1/m].
    pub count: f64,
    /// Crimp (14): yarn length over fabric length minus one [-].
    pub crimp: f64,
}

impl Default for Yarn {
    /// A yarn that carries nothing, weighs nothing and never breaks.
    fn default() -> Self {
        let [linear_density, modulus, count, crimp] = [0.0; 4];
        let [failure_strain, strength_retention] = [1.0; 2];
        let curve = Vec::new();
        Self { present: false, linear_density, modulus, curve, failure_strain, strength_retention, count, crimp }
    }
}

fn not<'de, D: Deserializer<'de>>(deserializer: D) -> Result<bool, D::Error> {
    bool::deserialize(deserializer).map(|flag| !flag)
}

/// Keys of a yarn.
#[derive(JsonSchema)]
#[allow(dead_code, reason = "for their schema")]
pub(super) struct YarnKeys {
    /// True: no yarn in this direction, its count still sets the element size.
    ///
    /// Default: a woven fabric has both yarns.
    #[schemars(extend("default" = false))]
    absent: bool,
    /// Mass of 9000 m of yarn.
    #[schemars(range(min = 0.01, max = 1e6), extend("group" = "linear density", "only" = {"absent": "false"}))]
    linear_density_denier: Option<f64>,
    /// Mass of 1000 m of yarn.
    #[schemars(range(min = 0.001, max = 1e5), extend("group" = "linear density", "only" = {"absent": "false"}))]
    linear_density_tex: Option<f64>,
    /// Mass of 10 000 m of yarn.
    #[schemars(range(min = 0.01, max = 1e6), extend("group" = "linear density", "only" = {"absent": "false"}))]
    linear_density_dtex: Option<f64>,
    /// Axial modulus of the fibre.
    #[schemars(range(min = 1e-6, max = 1e4), extend("group" = "modulus or curve", "only" = {"absent": "false"}))]
    modulus_gpa: Option<f64>,
    /// Strain and stress [GPa] of points from [0, 0] on, both rising, straight in between: in place of the modulus.
    #[schemars(length(min = 2, max = 16), inner(inner(range(min = 0, max = 1e4))))]
    #[schemars(extend("group" = "modulus or curve", "only" = {"absent": "false"}))]
    curve: Option<Vec<[f64; 2]>>,
    /// Axial strain at which the yarn breaks; 1: never.
    #[schemars(range(max = 1), extend("help" = "a part of one: 0.035, or \"3.5 %\"", "exclusiveMinimum" = 0, "group" = "failure strain or strength", "only" = {"absent": "false"}))]
    failure_strain: Option<f64>,
    /// Strength over linear density, in its place.
    #[schemars(range(min = 1e-3, max = 1e3), extend("group" = "failure strain or strength", "only" = {"absent": "false"}))]
    tenacity_g_den: Option<f64>,
    /// Strength over linear density, in its place.
    #[schemars(range(min = 1e-2, max = 1e4), extend("group" = "failure strain or strength", "only" = {"absent": "false"}))]
    tenacity_cn_tex: Option<f64>,
    /// Strength of the fibre, in its place.
    #[schemars(range(min = 1e-2, max = 1e6), extend("group" = "failure strain or strength", "only" = {"absent": "false"}))]
    strength_mpa: Option<f64>,
    /// Strength of the fibre, in its place.
    #[schemars(range(min = 1e-5, max = 1e3), extend("group" = "failure strain or strength", "only" = {"absent": "false"}))]
    strength_gpa: Option<f64>,
    /// Part of failure_strain, and so of strength, that a woven yarn keeps; assumed unless `sources` has this very key.
    ///
    /// Default: virgin yarn, as published.
    #[schemars(range(max = 1), extend("exclusiveMinimum" = 0, "default" = 1, "only" = {"absent": "false"}, "own_source" = true))]
    strength_retention: f64,
    /// Crossovers along this yarn per inch: along the warp, the picks of a data sheet.
    #[schemars(range(min = 0.1, max = 1000), extend("group" = "count"))]
    count_per_inch: Option<f64>,
    /// Crossovers along this yarn per cm: along the warp, the picks of a data sheet.
    #[schemars(range(min = 0.04, max = 400), extend("group" = "count"))]
    count_per_cm: Option<f64>,
    /// Yarn length over fabric length, minus one.
    ///
    /// Otherwise: areal density over that of straight yarns, minus one; the same in both where both are left out.
    #[schemars(range(min = 0, max = 0.5), extend("only" = {"absent": "false"}))]
    crimp: Option<f64>,
}

impl Yarn {
    /// Fibre cross-section A = linear density / fibre density [m²].
    pub fn area(&self, fibre_density: f64) -> f64 {
        self.linear_density / fibre_density
    }

    /// Axial strain at which the yarn breaks as woven; `None`: never [-].
    pub fn breaking_strain(&self) -> Option<f64> {
        (self.failure_strain < 1.0).then_some(self.failure_strain * self.strength_retention)
    }

    /// Undeformed half-span w0 = 1/(2·count) (12) [m].
    pub fn half_span(&self) -> f64 {
        0.5 / self.count
    }
}

/// The number [SI] of an object whose key has this name before its unit.
fn number(object: &Value, name: &str) -> Option<f64> {
    object.as_object()?.iter().find_map(|(key, value)| {
        let (own, unit) = split_unit(key);
        let number = value.as_f64().filter(|_| own == name)?;
        Some(unit.map_or(number, |unit| unit.to_si(number)))
    })
}

fn si(object: &Value, name: &str) -> f64 {
    number(object, name).unwrap_or(0.0)
}

/// Puts failure strains and crimps into a document that has been checked and completed, where a fabric has other numbers for them.
///
/// # Errors
/// A strength above what the modulus reaches, an areal density that leaves no crimp, or none where a crimp is left out.
pub(super) fn derive(document: &mut Value, record: &Provenance) -> Result<(), CaseError> {
    for place in places(document) {
        let Some(fabric) = document.pointer_mut(&place) else { continue };
        let present = ["warp", "weft"].into_iter().filter(|yarn| fabric[*yarn]["absent"] != true).collect::<Vec<_>>();
        let fibre_density = si(fabric, "fibre_density");
        for yarn in &present {
            let (place, yarn) = (format!("{place}/{yarn}"), &mut fabric[*yarn]);
            let curve = curve(&place, yarn, record)?;
            failure_strain(&place, yarn, &curve, fibre_density, record)?;
        }
        crimp(&place, fabric, &present, record)?;
    }
    Ok(())
}

/// Points of the curve of a yarn at `place` [-], [Pa], none of one without; puts the modulus into the yarn, and in place of a straight curve.
fn curve(place: &str, yarn: &mut Value, record: &Provenance) -> Result<Vec<[f64; 2]>, CaseError> {
    let points = yarn.get("curve").and_then(|points| serde_json::from_value::<Vec<[f64; 2]>>(points.clone()).ok());
    let (Some(points), Some(yarn)) = (points, yarn.as_object_mut()) else { return Ok(Vec::new()) };
    let mut steepest: f64 = 0.0;
    for (index, point) in points.iter().enumerate() {
        let before = index.checked_sub(1).map_or([0.0; 2], |before| points[before]);
        let [strain, stress] = [0, 1].map(|i: usize| point[i] - before[i]);
        let is_first = index == 0;
        if if is_first { *point != [0.0; 2] } else { strain <= 0.0 || stress <= 0.0 || point[0] > 1.0 } {
            let [strain, stress] = before.map(short_number_text);
            let expected = match is_first {
                true => "[0, 0], a yarn without load".to_owned(),
                false => format!("a strain above {strain}, at most 1, and a stress above {stress} GPa"),
            };
            let found = format!("[{}, {}]", short_number_text(point[0]), short_number_text(point[1]));
            let error = CaseError::at(format!("{place}/curve/{index}"), expected, found);
            return Err(
                error.help("points of strain [-], 0.035 for 3.5 %, and stress [GPa], both rising, from [0, 0] to where the yarn breaks")
            );
        }
        steepest = if is_first { 0.0 } else { steepest.max(stress / strain) };
    }
    let [end, top] = points[points.len() - 1];
    let is_straight = points.iter().all(|[strain, stress]| (stress - strain * top / end).abs() <= STRAIGHT * top);
    let (modulus, how) = match is_straight {
        // Without the dust of decimal points.
        true => (format!("{:.11e}", top / end).parse().unwrap_or(top / end), "slope of the curve, which is straight"),
        false => (steepest, "steepest slope of the curve; sets the time step"),
    };
    record.derive(&format!("{place}/modulus_gpa"), 1e9 * modulus, how, record.is_assumed(&format!("{place}/curve")));
    yarn.insert("modulus_gpa".to_owned(), json!(modulus));
    let points: Vec<[f64; 2]> = points.into_iter().map(|[strain, stress]| [strain, 1e9 * stress]).collect();
    yarn.insert("curve".to_owned(), if is_straight { json!([]) } else { json!(points) });
    let failure = yarn.get("failure_strain").and_then(Value::as_f64).filter(|strain| end < *strain && *strain < 1.0);
    if let Some(strain) = failure {
        let expected = format!("at most the last strain of the curve, {}, or 1: never", short_number_text(end));
        let error = CaseError::at(format!("{place}/failure_strain"), expected, short_number_text(strain));
        return Err(error.help("the curve has to reach to where the yarn breaks"));
    }
    Ok(points)
}

/// Failure strain of a yarn at `place`, from its strength, and from its curve where it has one.
fn failure_strain(
    place: &str,
    yarn: &mut Value,
    curve: &[[f64; 2]],
    fibre_density: f64,
    record: &Provenance,
) -> Result<(), CaseError> {
    let Some(key) = STRENGTHS.into_iter().find(|key| yarn.get(key).is_some()) else { return Ok(()) };
    let (name, modulus) = (split_unit(key).0, si(yarn, "modulus"));
    let (factor, times) = if name == "tenacity" { (fibre_density, " × fibre density") } else { (1.0, "") };
    let strength = si(yarn, name) * factor;
    let on_curve = |ends: &[[f64; 2]]| {
        let [[strain, stress], [next, above]] = [ends[0], ends[1]];
        (strength <= above).then(|| strain + (strength - stress) * (next - strain) / (above - stress))
    };
    let (strain, over) = match curve {
        [] => (strength / modulus, "/ modulus"),
        points => (points.windows(2).find_map(on_curve).unwrap_or(1.0), "on the curve"),
    };
    let at = format!("{place}/{key}");
    if strain >= 1.0 {
        let (of, most, beyond) = match curve.last() {
            None => ("below the modulus", modulus, format!(", a failure strain of {}", short_number_text(strain))),
            Some([_, stress]) => ("at most the last stress of the curve", *stress, String::new()),
        };
        let expected = format!("a strength {of}, {} GPa", short_number_text(1e-9 * most));
        let found = record.value(&at) + &beyond;
        return Err(CaseError::at(at, expected, found).help("look at the units of both"));
    }
    let how = format!("{key}{times} {over}");
    let assumed = [at.clone(), format!("{place}/modulus_gpa")].iter().any(|at| record.is_assumed(at));
    record.derive(&format!("{place}/failure_strain"), strain, &how, assumed);
    if let Some(yarn) = yarn.as_object_mut() {
        yarn.shift_remove(key);
        yarn.insert("failure_strain".to_owned(), json!(strain));
    }
    Ok(())
}

/// Crimps of the yarns that have none, from the areal density of the fabric at `place`.
fn crimp(place: &str, fabric: &mut Value, present: &[&str], record: &Provenance) -> Result<(), CaseError> {
    let unknown: Vec<&str> = present.iter().copied().filter(|yarn| fabric[*yarn].get("crimp").is_none()).collect();
    let Some(first) = unknown.first() else { return Ok(()) };
    let areal = format!("{place}/areal_density_g_m2");
    let Some(density) = number(fabric, "areal_density") else {
        let error = CaseError::at(format!("{place}/{first}/crimp"), "a crimp, or areal_density_g_m2", "neither");
        return Err(error.help("from the areal density follows the crimp: how much more than straight yarns it weighs"));
    };
    let other = |yarn: &str| if yarn == "warp" { "weft" } else { "warp" };
    let straight = |yarn: &str| si(&fabric[yarn], "linear_density") * si(&fabric[other(yarn)], "count");
    let known: f64 = present.iter().map(|yarn| straight(yarn) * (1.0 + si(&fabric[*yarn], "crimp"))).sum();
    let share: f64 = unknown.iter().map(|yarn| straight(yarn)).sum();
    let crimp = (density - known) / share;
    if !(0.0..=MAX_CRIMP).contains(&crimp) {
        let [least, most] = [0.0, MAX_CRIMP].map(|crimp| short_number_text(1e3 * (known + crimp * share)));
        let expected = format!("{least} to {most} g/m²: straight yarns, and a crimp of {MAX_CRIMP}");
        let error = CaseError::at(&areal, expected, format!("{} g/m²", record.value(&areal)));
        return Err(error.help("look at units, linear density and count, or give \"crimp\""));
    }
    let assumed = unknown.len() == 2 || record.is_assumed(&areal);
    for yarn in unknown {
        record.derive(&format!("{place}/{yarn}/crimp"), crimp, "", assumed);
        fabric[yarn]["crimp"] = json!(crimp);
    }
    Ok(())
}
