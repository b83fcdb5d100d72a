use super::*;
use crate::model::layup::{SIDES, neighbour};
use crate::model::{Model, layup};
use crate::num::simd::Vectors;
use crate::solver::node_update::field as node;
use crate::solver::state::State;
use crate::{case, solver};

/// Three plies of S-720 laid at these angles, small enough to be looked at node by node.
fn pack(angles: [f64; 3], more: &[&str]) -> case::Case {
    let [a, b, c] = angles;
    let text = format!(
        r#"{{"title": "t", "fabric": {{"file": "fabrics/s-720.json"}}, "solver": {{"end_time_us": 1}},
        "projectile": {{"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 10, "mass_g": 1, "velocity_m_s": 100}},
        "pack": {{"width_mm": 41, "height_mm": 41, "elements_per_crossover": 2,
        "mesh_grading": {{"fine_radius_mm": 11, "growth_ratio": 1.15, "max_crossovers": 2}}, "layup": [{{"plies": 1, "orientation_deg": {a}}},
        {{"plies": 1, "orientation_deg": {b}}}, {{"plies": 1, "orientation_deg": {c}}}]}}}}"#
    );
    let sets: Vec<String> = more.iter().map(|set| (*set).to_owned()).collect();
    case::from_str("pack", &text, &sets).unwrap_or_else(|error| unreachable!("{error}"))
}

/// Numbers between −1 and 1.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Plies that bulge to a ridge, two of them so alike that they touch here and there; some nodes are over the wrong cells, and some
/// had been inside.
fn bulge<S: solver::KernelScalar>(model: &Model<S>, state: &mut State<S>, noise: &mut Noise) {
    let thickness = model.plies[0].thickness;
    let apart = [0.01, 0.02, 2.0].map(|part| part * thickness);
    for (ply, apart) in apart.into_iter().enumerate() {
        let mesh = &model.ply_type(ply).mesh;
        let height = 3e-3 + thickness * (0.1 * ply as f64 + 0.06 * noise.next());
        for row in 0..=mesh.rows {
            for column in 0..=mesh.columns {
                let [x, y, _] = model.reference(ply, row, column);
                let far = (x.abs() + y.abs()) / 8e-3;
                let rough = [2e-4, 2e-4, 0.01 * thickness * noise.next().powi(2)]
                    .map(|size| size * noise.next() * (-far).exp());
                let smooth = [-0.1 * height * x / 1e-2, -0.1 * height * y / 1e-2, apart + height * (-far).exp()];
                let smooth = mesh.to_ply(smooth);
                let at = model.grid.first_node_row(ply) + row;
                for a in 0..3 {
                    state.nodes.set(at, node::DISPLACEMENT + a, column, S::splat(smooth[a] + rough[a]));
                    state.nodes.set(at, node::VELOCITY + a, column, S::splat(50.0 * noise.next()));
                }
            }
        }
    }
    settle(model, state);
    let mesh = &model.ply_type(0).mesh;
    for over in &mut state.over {
        let columns = mesh.columns as u32;
        let wrong = match (200.0 * noise.next()) as i32 {
            0 => *over + 1,
            1 => over.saturating_sub(1),
            2 => *over + columns,
            3 => over.saturating_sub(columns),
            4..8 => *over | PENETRATING,
            _ => *over,
        };
        if (layup::element(wrong) as u32) < columns * mesh.rows as u32 {
            *over = wrong;
        }
    }
}

/// Lets every node find the cell it is over.
fn settle<S: solver::KernelScalar>(model: &Model<S>, state: &mut State<S>) {
    let mut over = std::mem::take(&mut state.over);
    for (at, over) in over.chunks_mut(model.nodes_per_ply()).enumerate() {
        let (ply, side) = (at / SIDES, at % SIDES);
        let Some(other) = neighbour(ply, side, model.plies.len()) else { continue };
        let search = PlySearch::new(model, state, ply, side, other);
        let mesh = &model.ply_type(ply).mesh;
        for row in 0..=mesh.rows {
            for column in 0..=mesh.columns {
                search.node(row, column, &mut over[row * search.across() + column]);
            }
        }
    }
    state.over = over;
}

/// Nodes let through, and all, once every node that is kept has been found to be left alone.
fn checked<S: solver::KernelScalar>(case: &case::Case, symmetry: bool, seed: u64) -> [usize; 2] {
    let (model, mut state) = solver::state::set_up::<S>(case, symmetry).unwrap_or_else(|error| unreachable!("{error}"));
    assert_eq!(model.planes != crate::physics::mirror_planes::MirrorPlanes::NONE, symmetry, "{:?}", model.planes);
    bulge(&model, &mut state, &mut Noise(seed));
    let per_side = model.nodes_per_ply();
    let mut counts = [0; 2];
    for (at, over) in state.over.chunks(per_side).enumerate() {
        let (ply, side) = (at / SIDES, at % SIDES);
        let Some(other) = neighbour(ply, side, model.plies.len()) else { continue };
        let search = PlySearch::new(&model, &state, ply, side, other);
        let mesh = &model.ply_type(ply).mesh;
        let across = search.across();
        // Not all columns, and a last part with fewer rows.
        let columns = 1..mesh.columns + 1;
        for first in (0..=mesh.rows).step_by(ROWS) {
            let rows = first..(first + ROWS).min(mesh.rows + 1);
            let over = &over[rows.start * across..rows.end * across];
            let mut candidates: Option<Candidates> = None;
            for vectors in Vectors::all() {
                let mut found = Candidates::new();
                S::broad_phase(vectors).pass(&search, rows.clone(), columns.clone(), over, &mut found);
                let first = candidates.get_or_insert_with(|| found.clone());
                assert_eq!(*first, found, "{}", vectors.name());
            }
            let candidates = candidates.unwrap_or_default();
            assert!(candidates.is_sorted() && candidates.windows(2).all(|pair| pair[0] != pair[1]));
            counts[0] += candidates.len();
            for row in rows.clone() {
                for column in columns.clone() {
                    counts[1] += 1;
                    let before = over[(row - rows.start) * across + column];
                    let mut after = before;
                    let found = search.node(row, column, &mut after).is_some();
                    if candidates.binary_search(&[row as u32, column as u32]).is_err() {
                        let place = [ply, side, row, column];
                        assert!(!found, "ply, side, row, column {place:?} touches");
                        assert_eq!(after, before, "{place:?} goes from {} on", layup::element(before));
                    }
                }
            }
        }
    }
    counts
}

/// Part of the nodes let through, over several bulges.
fn part<S: solver::KernelScalar>(case: &case::Case, symmetry: bool) -> f64 {
    let counts: Vec<[usize; 2]> = (1..=16).map(|seed| checked::<S>(case, symmetry, seed)).collect();
    let [candidates, all] = [0, 1].map(|i| counts.iter().map(|count| count[i]).sum::<usize>() as f64);
    candidates / all
}

#[test]
fn what_is_kept_would_be_left_alone() {
    let layups = [[0.0; 3], [0.0, 90.0, 0.0], [90.0, 0.0, -90.0], [90.0; 3]];
    for angles in layups {
        for (more, symmetry) in [(&[][..], false), (&[], true), (&["/pack/mesh_grading/fine_radius_mm=5"], false)] {
            let case = pack(angles, more);
            let parts = [part::<f64>(&case, symmetry), part::<f32>(&case, symmetry)];
            assert!(parts.iter().all(|part| (0.02..0.3).contains(part)), "{angles:?} {more:?} {symmetry} {parts:?}");
        }
    }
    let odd = pack([0.0, 30.0, 30.0], &[]);
    let parts = [part::<f64>(&odd, false), part::<f32>(&odd, false)];
    assert!(parts.iter().all(|part| (0.5..0.9).contains(part)), "half of the pairs lie alike: {parts:?}");
}
