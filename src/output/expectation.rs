//! An expectation of `summary.json` in words.

use serde_json::Value;

use super::number::short;

/// What it is about, with the time or interval.
pub fn quantity(check: &Value) -> String {
    let name = check["quantity"].as_str().unwrap_or_default();
    if let Some(at) = check["at_us"].as_f64() {
        return format!("{name} at {} µs", short(at, 7));
    }
    match (check["between_us"][0].as_f64(), check["between_us"][1].as_f64()) {
        (Some(from), Some(to)) => format!("{name} between {} and {} µs", short(from, 7), short(to, 7)),
        _ => name.to_owned(),
    }
}

/// The bound.
pub fn expected(check: &Value) -> String {
    let expected = &check["expected"];
    let number = |key: &str| expected[key].as_f64();
    if let Some(word) = expected.as_str() {
        return word.to_owned();
    }
    match (number("value"), number("tolerance"), number("min"), number("max")) {
        (Some(value), Some(tolerance), ..) => format!("{value} ± {}", short(tolerance, 6)),
        (.., Some(min), Some(max)) => format!("{min} to {max}"),
        (.., Some(min), None) => format!("≥ {min}"),
        (.., None, Some(max)) => format!("≤ {max}"),
        _ => "-".to_owned(),
    }
}

/// What the run gave.
pub fn got(check: &Value) -> String {
    match &check["got"] {
        Value::Number(number) => number.as_f64().map_or_else(String::new, |number| short(number, 6)),
        Value::String(word) => word.clone(),
        Value::Null => "nothing".to_owned(),
        other => other.to_string(),
    }
}

/// Why there is nothing to compare, how the number was read, or why it is known to differ.
pub fn note(check: &Value) -> String {
    let notes = ["note", "known_difference"].into_iter().filter_map(|key| check[key].as_str());
    notes.map(|note| format!("({note})")).collect::<Vec<_>>().join(" ")
}

/// How an expectation came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judgement {
    /// It holds.
    Holds,
    /// It does not, and the case says why.
    Known,
    /// It does not.
    Fails,
}

/// Of an expectation.
pub fn judgement(check: &Value) -> Judgement {
    match (check["pass"] == true, check["known_difference"].is_string()) {
        (true, _) => Judgement::Holds,
        (false, true) => Judgement::Known,
        (false, false) => Judgement::Fails,
    }
}
