//! Regression: what ripstop itself computed of small scenes, number by number. No proof that a number is right; a proof that it has changed.
//!
//! Where it should change, `RIPSTOP_UPDATE_REGRESSION=1 cargo test --release --test suite -- regression` writes the numbers anew. It
//! refuses a scene that multiplies a rounding until its numbers are not held to [`TOLERANCE`] any more.

use std::fs;

use ripstop::case::{self, Case};
use ripstop::output;
use ripstop::run::Run;
use serde_json::{Map, Value, json};

use crate::support;

const EXPECTED: &str = "tests/regression/expected.json";
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

fn scenes() -> Value {
    serde_json::from_str(SCENES).unwrap()
}

/// A scene, its impact velocity and initial deflection times a factor.
fn case(name: &str, factor: f64) -> Case {
    let mut document = scenes()[name].clone();
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
    let scenes = scenes();
    let expected: Value = serde_json::from_str(&fs::read_to_string(EXPECTED).unwrap()).unwrap();
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
        fs::write(EXPECTED, format!("{:#}\n", Value::Object(new))).unwrap();
    }
    assert!(changed.is_empty(), "{}", changed.join("\n"));
}

/// Cases by name; `sets`: changes of them.
const SCENES: &str = r#"{
  "cylinder": {
    "fabric": {"file": "fabrics/s-720.json"}, "pack": {"width_mm": 18, "height_mm": 18, "elements_per_crossover": 2, "mesh_grading": {"fine_radius_mm": 11, "growth_ratio": 1.15, "max_crossovers": 2}},
    "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 8, "mass_g": 0.5, "velocity_m_s": 260},
    "solver": {"end_time_us": 21, "run_until": "end_time"}
  },
  "sphere_on_free_sides": {
    "fabric": {"file": "fabrics/s-728.json"}, "pack": {"width_mm": 12, "height_mm": 10, "edges": {"left": "free", "right": "free"}},
    "projectile": {"shape": "sphere", "diameter_mm": 4, "mass_g": 0.3, "velocity_m_s": 40, "offset_mm": [1.3, -0.7]},
    "solver": {"end_time_us": 40, "run_until": "end_time"}
  },
  "oblique_cone_three_plies": {
    "fabric": {"file": "fabrics/s-728.json"},
    "pack": {"plies": 3, "width_mm": 13, "height_mm": 12, "friction": 0.3, "elements_per_crossover": 2},
    "projectile": {
      "shape": "cone", "diameter_mm": 5, "length_mm": 8, "nose_length_mm": 3, "edge_radius_mm": 0, "mass_g": 0.6, "velocity_m_s": 220,
      "obliquity_deg": 30, "azimuth_deg": 20, "yaw_deg": 8, "angular_velocity_rad_s": [2000, -1000, 500], "offset_mm": [0.4, 0.9]
    },
    "solver": {"end_time_us": 35, "run_until": "end_time"}
  },
  "turned_layup": {
    "fabric": {"file": "fabrics/s-720.json"},
    "pack": {
      "width_mm": 12, "height_mm": 11,
      "elements_per_crossover": 2, "mesh_grading": {"fine_radius_mm": 11, "growth_ratio": 1.15, "max_crossovers": 2},
      "layup": [{"orientation_deg": 0}, {"orientation_deg": 30, "fabric": {"file": "fabrics/s-728.json"}}, {"orientation_deg": 90}]
    },
    "projectile": {"shape": "sphere", "diameter_mm": 5.5, "mass_g": 0.7, "velocity_m_s": 200, "offset_mm": [0.6, 0.2]},
    "solver": {"end_time_us": 30, "run_until": "end_time"}
  },
  "paper_numerics": {
    "fabric": {"file": "fabrics/s-720.json"}, "pack": {"width_mm": 30, "height_mm": 26},
    "projectile": {
      "shape": "cylinder", "diameter_mm": 5.5, "length_mm": 10, "mass_g": 0.8, "velocity_m_s": 240, "obliquity_deg": 20, "azimuth_deg": 35,
      "offset_mm": [0.9, -1.1]
    },
    "solver": {"numerics": "paper", "end_time_us": 25, "run_until": "end_time"}
  },
  "pretension_ogive": {
    "fabric": {"file": "fabrics/s-720.json"},
    "pack": {"width_mm": 24, "height_mm": 24, "elements_per_crossover": 2, "mesh_grading": {"fine_radius_mm": 11, "growth_ratio": 1.15, "max_crossovers": 2}, "pretension": {"warp_n_per_m": 800, "weft_n_per_m": 300}},
    "projectile": {"shape": "ogive", "diameter_mm": 5, "length_mm": 9, "mass_g": 0.6, "velocity_m_s": 150, "edge_radius_mm": 0.2},
    "solver": {"end_time_us": 66, "run_until": "end_time"}
  },
  "variational_free_plies": {
    "sets": ["/fabric/crossover/law=variational"],
    "fabric": {"file": "fabrics/s-728.json"},
    "pack": {"plies": 2, "width_mm": 13, "height_mm": 13, "edges": "free"},
    "projectile": {"shape": "fragment", "diameter_mm": 5.5, "length_mm": 6.2, "mass_g": 1.1, "velocity_m_s": 420, "roll_deg": 30, "yaw_deg": 5},
    "solver": {"end_time_us": 15, "run_until": "end_time"}
  },
  "bar_on_strip": {
    "sets": ["/fabric/crossover/gap_mm=0.01"],
    "fabric": {"file": "fabrics/s-720.json"},
    "pack": {"width_mm": 40, "height_mm": 4, "edges": {"top": "free", "bottom": "free"}, "pretension": {"warp_n_per_m": 500}},
    "projectile": {"shape": "bar", "diameter_mm": 4, "mass_g": 0.5, "velocity_m_s": 700, "offset_mm": [-5, 0]},
    "solver": {"end_time_us": 12, "run_until": "end_time"}
  },
  "drum": {
    "fabric": {"file": "fabrics/s-728.json"},
    "pack": {
      "width_mm": 40, "height_mm": 30, "crossovers_per_element": 2, "pretension": {"warp_n_per_m": 1000, "weft_n_per_m": 1500},
      "initial_deflection": {"amplitude_mm": 0.4, "warp_half_waves": 1, "weft_half_waves": 2}
    },
    "solver": {"end_time_us": 200, "shock_viscosity": 0.1, "failure_length_mm": 0}
  },
  "rigid_crossovers_one_yarn_absent": {
    "sets": ["/fabric/weft={\"absent\": true, \"count_per_inch\": 20}", "/fabric/crossover/compression=rigid"],
    "fabric": {"file": "fabrics/s-720.json"},
    "pack": {"width_mm": 30, "height_mm": 8, "edges": {"top": "free", "bottom": "free"}},
    "projectile": {"shape": "sphere", "diameter_mm": 4, "mass_g": 0.3, "velocity_m_s": 120},
    "solver": {"end_time_us": 20, "run_until": "end_time"}
  },
  "weak_yarns": {
    "fabric": {"file": "fabrics/s-720.json"}, "pack": {"width_mm": 14, "height_mm": 14, "elements_per_crossover": 2, "mesh_grading": {"fine_radius_mm": 11, "growth_ratio": 1.15, "max_crossovers": 2}},
    "projectile": {"shape": "sphere", "diameter_mm": 5, "mass_g": 0.5, "velocity_m_s": 180},
    "solver": {"symmetry": "none", "end_time_us": 30, "run_until": "end_time"},
    "variability": {"seed": 5, "shot": 3, "hit": "unit_cell", "yarn_strength": {"shape": 8, "gauge_length_mm": 60, "yarn_shape": 15}}
  },
  "prescribed_rim": {
    "fabric": {"file": "fabrics/s-720.json"}, "pack": {"plies": 2, "width_mm": 12, "height_mm": 12, "spacing_mm": 0.5, "elements_per_crossover": 2, "mesh_grading": {"fine_radius_mm": 11, "growth_ratio": 1.15, "max_crossovers": 2}},
    "projectile": {
      "shape": "cylinder", "diameter_mm": 5.5, "length_mm": 6, "mass_g": 1, "velocity_m_s": 200, "edge_radius_mm": 0.6, "yaw_deg": 12,
      "motion": "prescribed", "friction": 0.4, "standoff_mm": 0.3
    },
    "solver": {"end_time_us": 25, "run_until": "end_time"}
  },
  "coarse_far_field": {
    "fabric": {"file": "fabrics/s-728.json"},
    "pack": {"width_mm": 40, "height_mm": 36, "mesh_grading": {"fine_radius_mm": 3.5, "growth_ratio": 1.4, "max_crossovers": 6, "lines_from": "edges"}},
    "projectile": {"shape": "sphere", "diameter_mm": 5, "mass_g": 0.5, "velocity_m_s": 200, "offset_mm": [4, 3]},
    "solver": {"end_time_us": 40, "run_until": "end_time", "courant": 0.5, "hourglass": 0.02}
  }
}"#;
