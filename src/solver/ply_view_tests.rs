use super::*;
use crate::solver;
use crate::solver::state::State;
use crate::{case, model::Model};

/// Two plies of S-720, the second laid across the first, between two clamps and two rollers.
fn scene(symmetry: bool) -> (Model<f64>, State<f64>) {
    let text = r#"{"title": "t", "fabric": {"file": "fabrics/s-720.json"}, "solver": {"end_time_us": 1},
        "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 10, "mass_g": 1, "velocity_m_s": 100},
        "pack": {"width_mm": 25.4, "height_mm": 25.4, "elements_per_crossover": 2, "mesh_grading": "none",
        "layup": [{"plies": 1, "orientation_deg": 0}, {"plies": 1, "orientation_deg": 90}],
        "edges": {"left": "roller", "right": "roller", "bottom": "clamped", "top": "clamped"}}}"#;
    let case = case::from_str("pack", text, &[]).unwrap_or_else(|error| unreachable!("{error}"));
    solver::state::set_up::<f64>(&case, symmetry).unwrap_or_else(|error| unreachable!("{error}"))
}

#[test]
fn a_node_is_as_easy_to_move_in_a_part_as_in_the_whole() {
    let (whole, part) = (scene(false), scene(true));
    assert_eq!((whole.0.planes.copies(), part.0.planes.copies()), (1, 4));
    let [x, y, z] = [Vector3::x(), Vector3::y(), Vector3::z()];
    let along = [x, y, z, Vector3::new(0.6, 0.0, 0.8), Vector3::new(0.48, -0.6, 0.64), Vector3::new(0.0, 0.8, -0.6)];
    // Of an element, half a crossover long and wide [kg].
    let mass = 0.2552 * 0.635e-3 * 0.635e-3;
    let mut kinds = [0; 4];
    for ply in 0..2 {
        let [of_whole, of_part] = [&whole, &part].map(|(model, state)| PlyView::new(model, state, ply));
        let (rows, columns) = (of_part.mesh.rows, of_part.mesh.columns);
        for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
            let place = of_part.position(row, column);
            let same = (0..=of_whole.mesh.rows)
                .flat_map(|row| (0..=of_whole.mesh.columns).map(move |column| (row, column)))
                .find(|(row, column)| (of_whole.position(*row, *column) - place).norm() < 1e-9);
            let Some((whole_row, whole_column)) = same else { unreachable!("{place}") };
            // What holds a node, and what of a cell is its own, from where it lies.
            let far = |x: f64| (x.abs() - 12.7e-3).abs() < 1e-9;
            let [px, py, _] = of_part.mesh.to_ply(place.into());
            let (roller, clamped) = (far(px), far(py));
            let own = mass * if roller { 0.5 } else { 1.0 };
            for along in &along {
                let [of_whole, of_part] =
                    [of_whole.inverse(whole_row, whole_column, along), of_part.inverse(row, column, along)];
                let across = of_part_axis(&part.0, ply, along);
                let expected = match (clamped, roller) {
                    (true, _) => 0.0,
                    (false, true) => (1.0 - across * across) / own,
                    (false, false) => 1.0 / own,
                };
                assert!((of_part - expected).abs() < 1e-9 / own, "{ply} {place} {along}: {of_part} {expected}");
                assert!((of_whole - expected).abs() < 1e-9 / own, "{ply} {place} {along}: {of_whole} {expected}");
            }
            kinds[usize::from(roller) + 2 * usize::from(clamped)] += 1;
        }
    }
    assert!(kinds.iter().all(|count| *count > 0), "{kinds:?}");
}

/// Component of a direction along the X axis of a ply.
fn of_part_axis(model: &Model<f64>, ply: usize, along: &Vector3<f64>) -> f64 {
    model.ply_type(ply).mesh.to_ply((*along).into())[0]
}
