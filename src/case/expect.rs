//! The statements about the result that a case carries.

use serde_json::Value;

use super::error::{CaseError, describe, quote};
use super::scope::ObjectReader;
use super::value::{number_text, percent};
use super::{Bound, Expect};

/// Reads one item of `expect`.
pub(super) fn read(scope: &ObjectReader<'_>) -> Result<Expect, CaseError> {
    let quantity = scope.text("quantity")?;
    let bound = bound(scope)?;
    let at = scope.number_if_given("at_us")?;
    let between: Option<[f64; 2]> = scope.given("between_us").map(|_| scope.vector("between_us")).transpose()?;
    if let (Some([first, last]), Some(found)) = (between, scope.given("between_us"))
        && first >= last
    {
        let expected = "two times, the earlier one first";
        return Err(CaseError::at(scope.at("between_us"), expected, found.to_string()));
    }
    if at.is_some() && between.is_some() {
        let expected = "either \"at_us\" or \"between_us\"";
        return Err(CaseError::at(scope.at("between_us"), expected, "both"));
    }
    let source = scope.text("source")?;
    let known_difference = scope.given("known_difference").map(|_| scope.text("known_difference")).transpose()?;
    let known_difference = known_difference.unwrap_or_default();
    scope.summarise(format!("{quantity} {}", in_words(&bound)), &source);
    Ok(Expect { quantity, bound, at, between, source, known_difference })
}

fn bound(scope: &ObjectReader<'_>) -> Result<Bound, CaseError> {
    let (min, max) = (scope.number_if_given("min")?, scope.number_if_given("max")?);
    let Some(value) = scope.raw("value")? else {
        return range(scope, min, max);
    };
    if min.is_some() || max.is_some() {
        let expected = "either \"value\" or \"min\" and \"max\"";
        return Err(CaseError::at(scope.at("value"), expected, "both"));
    }
    let tolerance = scope.raw("tolerance")?;
    match (value, value.as_f64(), tolerance) {
        (Value::String(word), _, None) => Ok(Bound::Word(word.clone())),
        (_, Some(value), Some(tolerance)) => {
            let relative = percent(tolerance).map(|fraction| fraction * value.abs());
            let tolerance = relative.or(tolerance.as_f64()).unwrap_or_default();
            Ok(Bound::Value { value, tolerance })
        }
        (_, Some(_), None) => {
            let expected = "a tolerance with a number as value, absolute or like \"1%\"";
            Err(CaseError::at(scope.at("tolerance"), expected, "nothing"))
        }
        (_, None, tolerance) => {
            let found = tolerance.map(describe).unwrap_or_default();
            Err(CaseError::at(scope.at("tolerance"), "no tolerance with a word as value", found))
        }
    }
}

fn range(scope: &ObjectReader<'_>, min: Option<f64>, max: Option<f64>) -> Result<Bound, CaseError> {
    if let Some(found) = scope.given("tolerance") {
        let expected = "no tolerance without \"value\"";
        return Err(CaseError::at(scope.at("tolerance"), expected, describe(found)));
    }
    if min.is_none() && max.is_none() {
        return Err(CaseError::at(&scope.pointer, "\"value\", \"min\" or \"max\"", "none of them"));
    }
    let (min, max) = (min.unwrap_or(f64::NEG_INFINITY), max.unwrap_or(f64::INFINITY));
    if min > max {
        let expected = format!("at most max, which is {}", number_text(max));
        return Err(CaseError::at(scope.at("min"), expected, number_text(min)));
    }
    Ok(Bound::Range { min, max })
}

fn in_words(bound: &Bound) -> String {
    match bound {
        Bound::Word(word) => format!("= {}", quote(word)),
        Bound::Value { value, tolerance } => format!("= {} ± {}", number_text(*value), number_text(*tolerance)),
        Bound::Range { min, max } if *max == f64::INFINITY => format!("≥ {}", number_text(*min)),
        Bound::Range { min, max } if *min == f64::NEG_INFINITY => format!("≤ {}", number_text(*max)),
        Bound::Range { min, max } => format!("in [{}, {}]", number_text(*min), number_text(*max)),
    }
}
