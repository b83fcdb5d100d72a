//! JSON, and the sentences that the terminal and the page share.

use serde_json::{Value, json};

use super::{Fit, Quantile};
use crate::output::number::short;
use crate::study::arithmetic_v50::{Arithmetic, Refusal, Rule};
use crate::study::binary_response::{Estimate, Method};
use crate::study::interval::Interval;
use crate::study::residual_fit::{ResidualFit, ResidualModel, TooFew};

/// The whole fit. Velocities in m/s.
pub fn json(fit: &Fit) -> Value {
    let estimate = fit.estimate.as_ref().ok();
    let [perforated, stopped] = fit.outcomes.counts();
    let errors = |found: &Estimate| {
        let [[mu, _], [_, sigma]] = found.covariance;
        json!({ "mu": mu.sqrt(), "sigma": sigma.sqrt(), "information": "expected" })
    };
    json!({
        "mu": estimate.map(|found| found.mu),
        "sigma": estimate.map(|found| found.sigma),
        "deviance": estimate.map(Estimate::deviance),
        "quantiles": fit.quantiles.iter().map(quantile_json).collect::<Vec<_>>(),
        "overlap": fit.outcomes.overlap(),
        "method": estimate.map(|found| found.method.words()),
        "no_estimate": fit.estimate.as_ref().err().map(ToString::to_string),
        "standard_errors": estimate.map(errors),
        "link": fit.request.link.word(),
        "level": fit.request.level,
        "interval": fit.request.interval.word(),
        "shots": perforated + stopped,
        "perforated": perforated,
        "stopped": stopped,
        "slowest_perforation": fit.outcomes.slowest_perforation(),
        "fastest_stop": fit.outcomes.fastest_stop(),
        "arithmetic": fit.arithmetic.iter().map(arithmetic_json).collect::<Vec<_>>(),
        "residual": fit.residual.iter().map(residual_json).collect::<Vec<_>>(),
        "computed": fit.computed.map(|found| json!({
            "v50_m_s": found.v50, "low_m_s": found.bounds.low, "high_m_s": found.bounds.high, "sigma_m_s": found.sigma,
        })),
        "notes": notes(fit),
    })
}

pub(in crate::study) fn quantile_json(quantile: &Quantile) -> Value {
    json!({ "p": quantile.p, "value": quantile.value, "low": quantile.bounds.low, "high": quantile.bounds.high })
}

pub(in crate::study) fn arithmetic_json((of, found): &(Rule, Result<Arithmetic, Refusal>)) -> Value {
    let spread = match found {
        Ok(found) | Err(Refusal::TooWide(found)) => Some(found.spread),
        Err(Refusal::TooFew { .. }) => None,
    };
    json!({
        "rule": rule(of),
        "standard": of.standard,
        "value": found.as_ref().ok().map(|found| found.mean),
        "spread": spread,
        "refused": found.as_ref().err().map(refusal),
    })
}

pub(in crate::study) fn residual_json((curve, found): &(ResidualModel, Result<ResidualFit, TooFew>)) -> Value {
    match found {
        Ok(found) => json!({
            "curve": curve.words(), "limit": found.limit, "low": found.bounds.low, "high": found.bounds.high,
            "a": found.factor, "p": found.exponent, "scatter": found.scatter, "shots": found.count, "refused": null,
        }),
        Err(few) => json!({ "curve": curve.words(), "limit": null, "refused": too_few(few) }),
    }
}

/// Why a curve was not fitted.
pub fn too_few(few: &TooFew) -> String {
    format!("needs {} different velocities of shots that passed, there are {}", few.need, few.have)
}

/// A rule in a few words.
pub fn rule(rule: &Rule) -> String {
    format!("{0} + {0} within {1} m/s", rule.pairs, rule.spread)
}

/// Why a rule gives no V50.
pub fn refusal(why: &Refusal) -> String {
    match why {
        Refusal::TooFew { counts: [perforated, stopped] } => {
            format!("perforations: {perforated}, stops: {stopped}")
        }
        Refusal::TooWide(found) => {
            format!("spread {} m/s, mean {} m/s", short(found.spread, 4), short(found.mean, 4))
        }
    }
}

/// What a reader should know before the numbers are used.
pub fn notes(fit: &Fit) -> Vec<String> {
    let mut notes = Vec::new();
    notes.extend(fit.computed.iter().map(|computed| computed.words(fit)));
    match &fit.estimate {
        Err(why) => notes.push(format!("no estimate: {why}")),
        Ok(found) if found.method == Method::Firth => notes.push(
            "no overlap: no stop was faster than a perforation. The likelihood then has no maximum; the estimate is the one with Firth's \
             penalty. Shoot where both outcomes are likely"
                .to_owned(),
        ),
        Ok(_) => {}
    }
    let open = fit
        .quantiles
        .iter()
        .any(|quantile| quantile.value.is_some() && (quantile.bounds.low.is_none() || quantile.bounds.high.is_none()));
    if open {
        notes.push(
            "an interval without an end: a chance that does not depend on velocity explains the shots well enough. Shoot more".to_owned(),
        );
    }
    if fit.request.interval == Interval::Wald && fit.estimate.is_ok() {
        notes.push("Wald intervals are too short for few shots".to_owned());
    }
    let fitted = fit.residual.iter().filter_map(|(_, found)| found.as_ref().ok());
    let at_end =
        |found: &&ResidualFit| found.curve == ResidualModel::LambertJonas && !(1.001..9.99).contains(&found.exponent);
    notes.extend(
        fitted
            .filter(at_end)
            .map(|found| format!("Lambert-Jonas: p = {} is an end of what is tried", short(found.exponent, 3))),
    );
    notes
}
