//! `v50.json`, and the sentences that the terminal and the page share.

use serde_json::{Value, json};

use super::{V50Request, V50Result};
use crate::case::Case;
use crate::case::case_hash;
use crate::output::number::short;
use crate::study::fit;
use crate::study::residual_fit::{ResidualFit, ResidualModel, TooFew};
use crate::study::shots;

/// The whole result. Velocities in m/s.
pub fn json(case: &Case, request: &V50Request, seed: u32, result: &V50Result) -> Value {
    let quantile =
        |p: f64| result.quantiles.iter().find(|quantile| quantile.p == p).and_then(|quantile| quantile.value);
    let threshold = |(realisation, found): (usize, &Result<[f64; 2], String>)| match found {
        Ok([low, high]) => json!({ "realisation": realisation, "low_m_s": low, "high_m_s": high }),
        Err(reason) => json!({ "realisation": realisation, "low_m_s": null, "high_m_s": null, "reason": reason }),
    };
    let range = result.sample.map(|sample| sample.range);
    let assumed: Vec<&str> =
        case.fields.iter().filter(|field| field.assumed).map(|field| field.pointer.as_str()).collect();
    json!({
        "v50_m_s": result.v50,
        "low_m_s": result.bounds.low,
        "high_m_s": result.bounds.high,
        "level": request.level,
        "sigma_m_s": result.sigma,
        "v10_m_s": quantile(0.1),
        "v90_m_s": quantile(0.9),
        "half_width_m_s": {
            "sampling": result.width.sampling, "numerical": result.width.numerical, "bracket": result.width.bracket,
        },
        "refinement": result.refinement.map(|found| json!({
            "realisations": found.count, "ratio": found.ratio, "factor": found.factor(), "sigma": found.sigma, "shots": result.refined_shots,
        })),
        "realisations": result.thresholds.len(),
        "shots": result.shots,
        "failed": result.failed,
        "non_monotone": result.non_monotone.len(),
        "non_monotone_realisations": result.non_monotone,
        "slowest_threshold_m_s": range.map(|range| range[0]),
        "fastest_threshold_m_s": range.map(|range| range[1]),
        "quantiles": result.quantiles.iter().map(fit::quantile_json).collect::<Vec<_>>(),
        "arithmetic_of": ARITHMETIC_OF,
        "arithmetic": result.arithmetic.iter().map(fit::arithmetic_json).collect::<Vec<_>>(),
        "residual": result.residual.iter().map(fit::residual_json).collect::<Vec<_>>(),
        "residual_by_impact": result.bands.iter().map(|band| json!({
            "impact_m_s": band.impact, "shots": band.count, "mean_m_s": band.mean, "range_m_s": band.range,
        })).collect::<Vec<_>>(),
        "thresholds": result.thresholds.iter().enumerate().map(threshold).collect::<Vec<_>>(),
        "bracket": request.bracket,
        "seed": seed,
        "version": env!("CARGO_PKG_VERSION"),
        "case": case.name,
        "case_hash": case_hash(&case.as_run),
        "assumed": assumed,
        "notes": notes(case, result),
    })
}

/// Shots that the arithmetic V50 is of.
pub(super) const ARITHMETIC_OF: &str =
    "an up-and-down of one shot at each realisation, its outcome known from the threshold";

/// What a reader should know before the numbers are used.
pub fn notes(case: &Case, result: &V50Result) -> Vec<String> {
    let mut notes = Vec::new();
    if case.varies() {
        notes.extend(shots::notes(case));
        let lines_follow = case
            .layers()
            .iter()
            .all(|layer| layer.grading.is_some_and(|grading| grading.lines_from == crate::case::LinesFrom::Hit));
        if lines_follow && case.variability.as_ref().is_some_and(|v| v.hit == crate::case::HitPlace::UnitCell) {
            notes.push(
                "the mesh follows the hit: its place in a cell changes which yarns are struck, not the mesh".to_owned(),
            );
        }
    } else {
        notes.push(
            "nothing varies from shot to shot: this is one threshold, and its interval holds mesh, time step and bracket alone. \
             Give the case a variability for V10, V90 and an interval of many shots"
                .to_owned(),
        );
    }
    notes.push(match result.refinement {
        Some(found) => format!(
            "elements half as long move the limit by {} %, measured on {} realisation{}; V50 holds one and a half times that, \
             thresholds and residual velocities in the tables do not",
            short(100.0 * (found.ratio - 1.0), 2),
            found.count,
            if found.count == 1 { "" } else { "s" }
        ),
        None => "the part of mesh and time step was measured on S-720 and is assumed for other fabrics".to_owned(),
    });
    if !result.non_monotone.is_empty() {
        let numbers: Vec<String> = result.non_monotone.iter().map(ToString::to_string).collect();
        notes.push(format!(
            "{} of {} realisations are not monotone, a faster shot was stopped: {}",
            numbers.len(),
            result.thresholds.len(),
            numbers.join(", ")
        ));
    }
    if result.failed > 0 {
        notes.push(format!("{} of {} shots have no outcome: see v50.csv", result.failed, result.shots));
    }
    let steep = |(curve, found): &(ResidualModel, Result<ResidualFit, TooFew>)| {
        let limit = found.as_ref().ok()?.limit;
        let v50 = result.v50?;
        let off = (limit / v50 - 1.0).abs();
        (off > 0.05).then(|| format!("{}: its limit is {} % off V50", curve.words(), short(100.0 * off, 2)))
    };
    notes.extend(result.residual.iter().filter_map(steep));
    notes
}
