//! `sweep.json`: the points.

use serde_json::{Value, json};

use super::{SweepRequest, SweepResult};

/// The sweep in JSON.
pub fn json(request: &SweepRequest, results: &SweepResult) -> Value {
    let columns = request.columns();
    let rows = request.points.iter().zip(&results.points).map(|(values, result)| {
        let of = |name: &str, value: Value| (name.to_owned(), value);
        let factors = request.factors.iter().zip(values).map(|(factor, value)| {
            of(&factor.pointer, serde_json::from_str(value).unwrap_or_else(|_| value.as_str().into()))
        });
        let numbers = columns.iter().zip(&result.numbers).map(|(name, number)| of(name, (*number).into()));
        let reason = [of("reason", result.reason.as_str().into())];
        Value::Object(factors.chain(numbers).chain(reason).collect())
    });
    let rows: Vec<Value> = rows.collect();
    json!({
        "response": columns.first(),
        "level": request.level,
        "points": rows,
    })
}
