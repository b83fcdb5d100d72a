//! Regression: what ripstop itself computed of small scenes, number by number. No proof that a number is right; a proof that it has changed.
//!
//! Where it should change, `RIPSTOP_UPDATE_REGRESSION=1 cargo test --release --test suite -- regression` writes the numbers anew. It
//! refuses a scene that multiplies a rounding until its numbers are not held to [`TOLERANCE`] any more.

use std::fs;
use std::path::Path;

use ripstop::case::{self, Case};
use ripstop::output;
use ripstop::run::Run;
use serde_json::{Map, Value, json};

use crate::support;

const FOLDER: &str = "tests/regression";
/// Allowed difference over the number.
const TOLERANCE: f64 = 1e-7;
/// Allowed difference of numbers near zero, in the units of `summary.json`.
const FLOOR: f64 = 1e-9;
/// Relative change of what a scene starts with that stands for a rounding.
const NUDGE: f64 = 1e-12;
/// Rows of the history that are kept.
const ROWS: usize = 6;
/// Parts of `summary.json` that are not results: cost, origin, and words that a later version may say otherwise.
const LEFT_OUT: &str = "title timings wall_s loop_s element_steps_per_s host_overhead_s backend adapter threads version case \
    case_hash assumed warnings notes trust expect terms skipped precision";

fn read(name: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(Path::new(FOLDER).join(name)).unwrap()).unwrap()
}

/// A scene, its impact velocity and initial deflection times a factor.
fn case(name: &str, factor: f64) -> Case {
    let mut document = read("scenes.json")[name].clone();
    let sets = document.as_object_mut().unwrap().remove("sets").unwrap_or_else(|| json!([]));
    let sets: Vec<String> = serde_json::from_value(sets).unwrap();
    document["title"] = json!(name);
    for start in ["/projectile/velocity_m_s", "/pack/initial_deflection/amplitude_mm"] {
        if let Some(value) = document.pointer_mut(start) {
            *value = json!(value.as_f64().unwrap() * factor);
        }
    }
    case::from_str(name, &document.to_string(), &sets).unwrap_or_else(|e| panic!("{e}"))
}

/// Numbers of a run that are compared.
fn compared(case: &Case, run: &Run) -> Value {
    let mut summary = output::summary(case, run, 0.0);
    summary.as_object_mut().unwrap().retain(|name, _| !LEFT_OUT.split_whitespace().any(|left_out| left_out == name));
    let rows = |count: usize| (1..=ROWS).map(move |row| (count - 1) * row / ROWS);
    let history: Vec<Value> = rows(run.history.len()).map(|row| json!(run.history[row])).collect();
    let plies: Vec<Value> = match run.ply_history.len() {
        0 => Vec::new(),
        count => rows(count).map(|row| json!(run.ply_history[row])).collect(),
    };
    let places = run.events.iter().fold([0; 5], |[step, ply, row, column, yarn], event| {
        let [at_ply, at_row, at_column] = [event.ply, event.j, event.i].map(u64::from);
        [step + event.step, ply + at_ply, row + at_row, column + at_column, yarn + u64::from(event.yarn)]
    });
    json!({ "summary": summary, "history": history, "plies": plies, "failures": run.events.len(), "sums_of_failures": places })
}

/// Numbers and words by their place.
fn flat(place: &str, value: &Value, out: &mut Map<String, Value>) {
    match value {
        Value::Object(map) => map.iter().for_each(|(name, value)| flat(&format!("{place}/{name}"), value, out)),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(at, value)| flat(&format!("{place}/{at}"), value, out));
        }
        _ => {
            out.insert(place.to_owned(), value.clone());
        }
    }
}

/// Places whose numbers differ by more than `part` of what is allowed, and the numbers.
fn differences(got: &Value, expected: &Value, part: f64) -> Vec<String> {
    let [got, expected] = [got, expected].map(|value| {
        let mut all = Map::new();
        flat("", value, &mut all);
        all
    });
    let mut found: Vec<String> = expected.keys().filter(|place| !got.contains_key(*place)).cloned().collect();
    for (place, value) in &got {
        let other = expected.get(place).unwrap_or(&Value::Null);
        let same = match (value.as_f64(), other.as_f64()) {
            (Some(a), Some(b)) => (a - b).abs() <= part * (TOLERANCE * a.abs().max(b.abs()) + FLOOR),
            _ => value == other,
        };
        if !same {
            found.push(format!("{place}: {value}, expected {other}"));
        }
    }
    found
}

#[test]
fn every_scene_gives_the_numbers_that_it_gave() {
    let (scenes, expected) = (read("scenes.json"), read("expected.json"));
    let (mut new, mut changed) = (Map::new(), Vec::new());
    for name in scenes.as_object().unwrap().keys() {
        let case = case(name, 1.0);
        let got = compared(&case, &support::run(&case));
        if std::env::var_os("RIPSTOP_UPDATE_REGRESSION").is_some() {
            let nudged = self::case(name, 1.0 + NUDGE);
            let found = differences(&compared(&nudged, &support::run(&nudged)), &got, 0.1);
            assert!(found.is_empty(), "{name} multiplies roundings:\n{}", found[..found.len().min(12)].join("\n"));
            new.insert(name.clone(), got);
            continue;
        }
        let found = differences(&got, &expected[name], 1.0);
        if !found.is_empty() {
            let some = found[..found.len().min(12)].join("\n");
            changed.push(format!("{name}: {} numbers have changed, among them\n{some}", found.len()));
        }
    }
    if !new.is_empty() {
        fs::write(Path::new(FOLDER).join("expected.json"), format!("{:#}\n", Value::Object(new))).unwrap();
    }
    assert!(changed.is_empty(), "{}", changed.join("\n"));
}
