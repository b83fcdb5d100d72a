//! Numbers of a data sheet in the place of those that the model needs: strength for failure strain, areal density for crimp.

use std::iter::once;

use serde_json::{Value, json};

use super::super::error::short_number_text;
use super::super::keys::split_unit;
use super::{CaseError, LAYUP, Provenance};

/// Keys that give a strength, and what the failure strain is then.
const STRENGTHS: [(&str, &str); 4] = [
    ("tenacity_g_den", "tenacity_g_den × fibre density / modulus"),
    ("tenacity_cn_tex", "tenacity_cn_tex × fibre density / modulus"),
    ("strength_mpa", "strength_mpa / modulus"),
    ("strength_gpa", "strength_gpa / modulus"),
];
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
    let own = (0..groups).map(|group| format!("{LAYUP}/{group}{}", super::COMMON));
    for place in once(super::COMMON.to_owned()).chain(own) {
        let Some(fabric) = document.pointer_mut(&place) else { continue };
        let present = ["warp", "weft"].into_iter().filter(|yarn| fabric[*yarn]["absent"] != true).collect::<Vec<_>>();
        let fibre_density = si(fabric, "fibre_density");
        for yarn in &present {
            failure_strain(&format!("{place}/{yarn}"), &mut fabric[*yarn], fibre_density, record)?;
        }
        crimp(&place, fabric, &present, record)?;
    }
    Ok(())
}

/// Failure strain of a yarn at `place`, from its strength.
fn failure_strain(place: &str, yarn: &mut Value, fibre_density: f64, record: &Provenance) -> Result<(), CaseError> {
    let Some((key, how)) = STRENGTHS.into_iter().find(|(key, _)| yarn.get(key).is_some()) else { return Ok(()) };
    let (name, _) = split_unit(key);
    let is_tenacity = name == "tenacity";
    let strength = si(yarn, name) * if is_tenacity { fibre_density } else { 1.0 };
    let strain = strength / si(yarn, "modulus");
    let at = format!("{place}/{key}");
    if strain >= 1.0 {
        let expected =
            format!("a strength below the modulus, {}", record.value(&format!("{place}/modulus_gpa")) + " GPa");
        let found = format!("{}, a failure strain of {}", record.value(&at), short_number_text(strain));
        return Err(CaseError::at(at, expected, found).help("look at the units of both"));
    }
    let assumed = [at.clone(), format!("{place}/modulus_gpa")].iter().any(|at| record.is_assumed(at));
    record.derive(&format!("{place}/failure_strain"), strain, how, assumed);
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
