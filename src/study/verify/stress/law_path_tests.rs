#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
use super::*;
use crate::case;

const PATCH: &str = r#"{
    "title": "patch",
    "fabric": {"file": "fabrics/s-720.json"},
    "pack": {"width_mm": 3.81, "height_mm": 2.54, "edges": "free", "crossovers_per_element": 1},
    "solver": {"end_time_us": 1}
}"#;

/// Stretches a patch evenly.
fn stretch_to(model: &Model<f64>, state: &mut State<f64>, excess: [f64; 2]) {
    for [ply, row, column] in solver::nodes(model) {
        let x = model.ply_type(ply).mesh.reference(row, column);
        for a in 0..2 {
            state.nodes.set(row, node::DISPLACEMENT + a, column, excess[a] * x[a]);
        }
    }
}

#[test]
fn a_straight_way_makes_what_the_table_says_and_the_way_back_takes_it() {
    let case = case::from_str("patch", PATCH, &[]).unwrap();
    let model = Model::<f64>::new(&case).unwrap();
    let mut state = State::new(&case, &model);
    let mut path = LawPath::new(&model, &state);
    let end = [0.03, 0.02];
    let mut go = |part: f64| {
        stretch_to(&model, &mut state, end.map(|excess| part * excess));
        path.follow(&model, &state)
    };
    let there = (1..=100).map(|step| go(f64::from(step) / 100.0)).last().unwrap();
    let back = (0..100).rev().map(|step| go(f64::from(step) / 100.0)).last().unwrap();
    stretch_to(&model, &mut state, end);
    path.follow(&model, &state);
    let held: f64 = path.cells.iter().flatten().map(|cell| cell.held).sum();
    let told = model.ply_type(0).law_energy.as_ref().unwrap().at(end) * held;
    assert!(told.abs() > 1e-3 * held && (there - told).abs() < 0.02 * held, "{there} {told} {held}");
    assert!(back.abs() < 1e-6 * held, "{back} {held}");
}

#[test]
fn another_way_to_the_same_place_makes_another_energy() {
    let case = case::from_str("patch", PATCH, &[]).unwrap();
    let model = Model::<f64>::new(&case).unwrap();
    let made = |corner: [f64; 2]| {
        let mut state = State::new(&case, &model);
        let mut path = LawPath::new(&model, &state);
        let mut last = 0.0;
        for (from, to) in [([0.0; 2], corner), (corner, [0.03, 0.02])] {
            for step in 1..=100 {
                let part = f64::from(step) / 100.0;
                stretch_to(&model, &mut state, [0, 1].map(|i| from[i] + part * (to[i] - from[i])));
                last = path.follow(&model, &state);
            }
        }
        last
    };
    let [straight, round] = [made([0.015, 0.01]), made([0.03, 0.0])];
    assert!((straight / round - 1.0).abs() > 1e-3, "{straight} {round}");
}
