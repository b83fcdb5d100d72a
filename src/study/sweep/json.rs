//! `sweep.json`: the points, and what each key does.

use serde_json::{Map, Value, json};

use super::factor::Factor;
use super::indices::Index;
use super::{KeyEffect, SweepRequest, SweepResult};

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
        "effects": request.factors.iter().zip(&results.effects).map(effect).collect::<Vec<_>>(),
    })
}

/// Of a key: the part of the variance from its main effect, and Sobol's indices where the points are those that they need.
fn effect((factor, effect): (&Factor, &KeyEffect)) -> Value {
    let mut keys = Map::new();
    keys.insert("key".to_owned(), factor.pointer.as_str().into());
    keys.insert("main_effect_part".to_owned(), effect.main.as_ref().map(|main| main.part).into());
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
}
