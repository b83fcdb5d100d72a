use super::*;
use std::path::Path;

use crate::case;
use crate::solver::node_update::field as node;

/// A case of a smaller pack, its projectile changed, ready to run.
fn scene(file: &str, projectile: &str) -> (Model<f64>, State<f64>) {
    let sets = ["/expect=[]", "/sources={}", "/pack/width_mm=40", "/pack/height_mm=40"].map(str::to_owned);
    let sets = [&sets[..], &[format!("/projectile={projectile}")]].concat();
    let case = case::read(Path::new(file), &sets).unwrap_or_else(|error| unreachable!("{error}"));
    let model = Model::<f64>::new(&case).unwrap_or_else(|error| unreachable!("{error}"));
    let state = State::new(&case, &model);
    (model, state)
}

/// Every node that comes within the margin when it is moved through any part of the plies in front is listed, and few that
/// do not come within a margin more.
#[test]
fn all_nodes_near_the_body_are_listed() {
    let common =
        r#""mass_g": 3, "velocity_m_s": 155, "offset_mm": [7.3, -4.1], "obliquity_deg": 40, "azimuth_deg": 25"#;
    let shapes = [
        r#""shape": "cylinder", "diameter_mm": 5.5, "length_mm": 20, "yaw_deg": 20"#,
        r#""shape": "cylinder", "diameter_mm": 9, "length_mm": 3, "edge_radius_mm": 0.4, "yaw_deg": -25"#,
        r#""shape": "sphere", "diameter_mm": 8"#,
        r#""shape": "cone", "diameter_mm": 6, "length_mm": 30, "nose_length_mm": 30, "edge_radius_mm": 0"#,
        r#""shape": "ogive", "diameter_mm": 6, "length_mm": 14, "nose_length_mm": 9, "edge_radius_mm": 0"#,
        r#""shape": "fragment", "diameter_mm": 7, "length_mm": 8, "roll_deg": 30"#,
    ];
    for shape in shapes {
        for file in ["cases/s728-4ply-91.json", "cases/hybrid-8ply-200.json"] {
            let (model, mut state) = scene(file, &format!("{{{shape}, {common}}}"));
            for row in 0..model.grid.node_rows() {
                for column in 0..model.grid.columns {
                    let swell = 1e-3 * (0.3 * row as f64 + 0.7 * column as f64).sin();
                    (0..3).for_each(|a| state.nodes.set(row, node::DISPLACEMENT + a, column, swell * (1 + a) as f64));
                }
            }
            let Some(mut body) = state.body.clone() else { unreachable!() };
            body.position += body.flight * 4e-3;
            let margin = 1.5e-3;
            let listed = find_candidates(&model, &state, &body, margin);
            let within = |room: f64| {
                let mut all = crate::solver::divergence::nodes(&model).collect::<Vec<_>>();
                all.retain(|&[ply, row, column]| {
                    let position = node_position(&model, &state, ply, row, column);
                    let moved =
                        |part: u32| position - Vector3::new(0.0, 0.0, model.plies[ply].depth * f64::from(part) / 40.0);
                    (0..=40).any(|part| body.gap(&moved(part)).0 < room)
                });
                all.iter().map(|place| place.map(|at| at as u32)).collect::<Vec<_>>()
            };
            let (least, most) = (within(margin), within(2.0 * margin));
            assert!(least.len() > 20, "{shape} {file}: {}", least.len());
            assert!(least.iter().all(|place| listed.contains(place)), "{shape} {file}");
            assert!(listed.iter().all(|place| most.contains(place)), "{shape} {file}");
            assert!(listed.is_sorted(), "in storage order");
        }
    }
}
