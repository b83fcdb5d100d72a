//! Numbers of a data sheet in the place of those that the model needs: a curve of stress over strain for the modulus, strength for failure
//! strain, areal density for crimp.

use std::iter::once;

use serde_json::{Value, json};

use super::super::error::short_number_text;
use super::super::keys::split_unit;
use super::super::pack::LAYUP;
use super::place::COMMON;
use super::{CaseError, Provenance};

/// Keys that give a strength, and what the failure strain is then.
const STRENGTHS: [(&str, &str); 4] = [
    ("tenacity_g_den", "tenacity_g_den × fibre density / modulus"),
    ("tenacity_cn_tex", "tenacity_cn_tex × fibre density / modulus"),
    ("strength_mpa", "strength_mpa / modulus"),
    ("strength_gpa", "strength_gpa / modulus"),
];
/// Difference from the chord, over the last stress, of a curve that is straight [-].
const STRAIGHT: f64 = 1e-12;
/// Largest crimp that follows from an areal density [-]: more is a slip of a unit.
const MAX_CRIMP: f64 = 0.25;

/// The number [SI] of an object whose key has this name before its unit, and the key.
fn number<'a>(object: &'a Value, name: &str) -> Option<(&'a str, f64)> {
    object.as_object()?.iter().find_map(|(key, value)| {
        let (own, unit) = split_unit(key);
        let number = value.as_f64().filter(|_| own == name)?;
        Some((key.as_str(), unit.map_or(number, |unit| unit.to_si(number))))
    })
}

fn si(object: &Value, name: &str) -> f64 {
    number(object, name).map_or(0.0, |(_, number)| number)
}

/// Puts failure strains and crimps into a document that has been checked and completed, where a fabric has other numbers for them.
///
/// # Errors
/// A strength above what the modulus reaches, an areal density that leaves no crimp, or none where a crimp is left out.
pub(in crate::case) fn derive(document: &mut Value, record: &Provenance) -> Result<(), CaseError> {
    let groups = document.pointer(LAYUP).and_then(Value::as_array).map_or(0, Vec::len);
    let own = (0..groups).map(|group| format!("{LAYUP}/{group}{COMMON}"));
    for place in once(COMMON.to_owned()).chain(own) {
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
    let Some((key, how)) = STRENGTHS.into_iter().find(|(key, _)| yarn.get(key).is_some()) else { return Ok(()) };
    let (name, _) = split_unit(key);
    let is_tenacity = name == "tenacity";
    let strength = si(yarn, name) * if is_tenacity { fibre_density } else { 1.0 };
    let on_curve = |ends: &[[f64; 2]]| {
        let [[strain, stress], [next, above]] = [ends[0], ends[1]];
        (strength <= above).then(|| strain + (strength - stress) * (next - strain) / (above - stress))
    };
    let (strain, how) = match curve {
        [] => (strength / si(yarn, "modulus"), how.to_owned()),
        points => (points.windows(2).find_map(on_curve).unwrap_or(1.0), how.replace("/ modulus", "on the curve")),
    };
    let at = format!("{place}/{key}");
    if strain >= 1.0 {
        let most = curve.last().map_or(si(yarn, "modulus"), |[_, stress]| *stress);
        let of = if curve.is_empty() { "below the modulus" } else { "at most the last stress of the curve" };
        let expected = format!("a strength {of}, {} GPa", short_number_text(1e-9 * most));
        let is_beyond = if curve.is_empty() {
            format!(", a failure strain of {}", short_number_text(strain))
        } else {
            String::new()
        };
        let found = record.value(&at) + &is_beyond;
        return Err(CaseError::at(at, expected, found).help("look at the units of both"));
    }
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
    let Some((_, density)) = number(fabric, "areal_density") else {
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
