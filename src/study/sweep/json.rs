//! `sweep.json`: the points, and what each key does.

use serde_json::{Map, Value, json};

use super::indices::Index;
use super::{PointResult, SweepRequest, key_effects};

/// The sweep in JSON.
pub fn json(request: &SweepRequest, results: &[PointResult]) -> Value {
    let columns = request.columns();
    let rows = request.points.iter().zip(results).map(|(values, result)| {
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
        "effects": effects(request, results),
    })
}

/// By key: the part of the variance from its main effect, and Sobol's indices where the points are those that they need.
fn effects(request: &SweepRequest, results: &[PointResult]) -> Vec<Value> {
    let of = |(factor, effect): (&super::factor::Factor, super::KeyEffect)| {
        let mut keys = Map::new();
        keys.insert("key".to_owned(), factor.pointer.as_str().into());
        keys.insert("main_effect_part".to_owned(), effect.main.map(|main| main.part).into());
        let mut put = |name: &str, index: Index| {
            keys.insert(name.to_owned(), index.value.into());
            keys.insert(format!("{name}_low"), index.bounds.map(|[low, _]| low).into());
            keys.insert(format!("{name}_high"), index.bounds.map(|[_, high]| high).into());
        };
        if let Some(indices) = effect.indices {
            put("first_index", indices.first);
            put("total_index", indices.total);
        }
        Value::Object(keys)
    };
    request.factors.iter().zip(key_effects(request, results)).map(of).collect()
}
