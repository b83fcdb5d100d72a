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

use crate::scene;

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
const LEFT_OUT: &[&str] = &[
    "title",
    "timings",
    "wall_s",
    "loop_s",
    "element_steps_per_s",
    "host_overhead_s",
    "backend",
    "adapter",
    "threads",
    "version",
    "case",
    "case_hash",
    "assumed",
    "warnings",
    "notes",
    "trust",
    "expect",
    "terms",
    "skipped",
    "precision",
];

macro_rules! scenes {
    ($($name:ident)*) => {
        $(#[test]
        fn $name() {
            check(stringify!($name));
        })*

        #[test]
        fn every_scene_is_a_test() {
            let scenes = read("scenes.json");
            let names: Vec<&str> = scenes.as_object().unwrap().keys().map(String::as_str).collect();
            assert_eq!(names, [$(stringify!($name)),*]);
            let expected = read("expected.json");
            assert!(expected.as_object().unwrap().keys().eq(scenes.as_object().unwrap().keys()));
        }
    };
}

scenes! {
    cylinder sphere_on_free_sides oblique_cone_three_plies turned_layup paper_numerics pretension_ogive variational_free_plies bar_on_strip
    drum rigid_crossovers_one_yarn_absent weak_yarns prescribed_rim coarse_far_field
}

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
fn kept(case: &Case, run: &Run) -> Value {
    let mut summary = output::summary(case, run, 0.0);
    summary.as_object_mut().unwrap().retain(|name, _| !LEFT_OUT.contains(&name.as_str()));
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

fn flattened(value: &Value) -> Map<String, Value> {
    let mut out = Map::new();
    flat("", value, &mut out);
    out
}

/// Places whose numbers differ by more than `part` of what is allowed, and the numbers.
fn differences(got: &Value, expected: &Value, part: f64) -> Vec<String> {
    let (got, expected) = (flattened(got), flattened(expected));
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

fn check(name: &str) {
    let case = case(name, 1.0);
    let got = kept(&case, &scene::run(&case));
    if std::env::var_os("RIPSTOP_UPDATE_REGRESSION").is_some() {
        return update(name, got);
    }
    let found = differences(&got, &read("expected.json")[name], 1.0);
    assert!(
        found.is_empty(),
        "{name}: {} numbers have changed, among them\n{}",
        found.len(),
        found[..found.len().min(12)].join("\n")
    );
}

/// Writes what was computed, where a rounding stays a rounding.
fn update(name: &str, got: Value) {
    static ONE_AT_A_TIME: std::sync::Mutex<()> = std::sync::Mutex::new(());
    let nudged = self::case(name, 1.0 + NUDGE);
    let found = differences(&kept(&nudged, &scene::run(&nudged)), &got, 0.1);
    assert!(found.is_empty(), "{name} multiplies roundings:\n{}", found[..found.len().min(12)].join("\n"));
    let _lock = ONE_AT_A_TIME.lock().unwrap();
    let mut expected = read("expected.json");
    expected[name] = got;
    let mut all = Map::new();
    for name in read("scenes.json").as_object().unwrap().keys() {
        all.insert(name.clone(), expected[name].clone());
    }
    fs::write(Path::new(FOLDER).join("expected.json"), format!("{:#}\n", Value::Object(all))).unwrap();
}
