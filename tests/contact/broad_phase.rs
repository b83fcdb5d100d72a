//! Broad phase between plies: what it keeps from the search would have been left alone, whatever the registers.

use std::ops::Range;

use ripstop::Case;
use ripstop::model::Model;
use ripstop::model::layup::{self, PENETRATING, SIDES, neighbour};
use ripstop::num::simd::Vectors;
use ripstop::solver::contact::ply_search::{FoundContacts, PlySearch, ROWS, SearchPart};
use ripstop::solver::node_update::field as node;
use ripstop::solver::state::State;
use ripstop::solver::sweep::{KernelScalar, RowKernels};

use crate::support::Random;
use crate::support::shipped;

/// Three plies of S-720 laid at these angles, small enough to be looked at node by node.
fn pack([a, b, c]: [f64; 3], more: &[&str]) -> Case {
    let layup =
        format!(r#"/pack/layup=[{{"orientation_deg": {a}}}, {{"orientation_deg": {b}}}, {{"orientation_deg": {c}}}]"#);
    let grading = r#"/pack/mesh_grading={"fine_radius_mm": 11, "growth_ratio": 1.15, "max_crossovers": 2}"#;
    let size = ["/pack/width_mm=41", "/pack/height_mm=41", "/pack/elements_per_crossover=2", "/pack/plies=3"];
    shipped(
        "cases/s720-1ply-155.json",
        &[&size[..], &[&layup, grading, "/expect=[]", "/solver/end_time_us=1"], more].concat(),
    )
}

/// Calls `see` with every search of a pack and the cells that its nodes are over.
fn searches<S: KernelScalar>(
    model: &Model<S>,
    state: &State<S>,
    over: &mut [u32],
    mut see: impl FnMut(&PlySearch<'_, S>, &mut [u32]),
) {
    for (at, over) in over.chunks_mut(model.nodes_per_ply()).enumerate() {
        let (ply, side) = (at / SIDES, at % SIDES);
        if let Some(other) = neighbour(ply, side, model.plies.len()) {
            see(&PlySearch::new(model, state, ply, side, other), over);
        }
    }
}

/// Plies that bulge to a ridge, two of them so alike that they touch here and there; some nodes are over the wrong cells, and some
/// had been inside.
fn bulge<S: KernelScalar>(model: &Model<S>, state: &mut State<S>, numbers: &mut Random) {
    let thickness = model.plies[0].thickness;
    let apart = [0.01, 0.02, 2.0].map(|part| part * thickness);
    let height = [0.0, 0.1, 0.2].map(|part| 3e-3 + thickness * (part + 0.06 * numbers.between(-1.0, 1.0)));
    for [ply, row, column] in model.node_places() {
        let [x, y, _] = model.reference(ply, row, column);
        let far = (-(x.abs() + y.abs()) / 8e-3).exp();
        let rough = [2e-4, 2e-4, 0.01 * thickness * numbers.between(-1.0, 1.0).powi(2)]
            .map(|size| size * numbers.between(-1.0, 1.0) * far);
        let smooth = [-0.1 * height[ply] * x / 1e-2, -0.1 * height[ply] * y / 1e-2, apart[ply] + height[ply] * far];
        let smooth = model.ply_type(ply).mesh.to_ply(smooth);
        for a in 0..3 {
            let (at, velocity) = (model.grid.first_node_row(ply) + row, S::splat(50.0 * numbers.between(-1.0, 1.0)));
            state.nodes.set(at, node::DISPLACEMENT + a, column, S::splat(smooth[a] + rough[a]));
            state.nodes.set(at, node::VELOCITY + a, column, velocity);
        }
    }
    let mut over = std::mem::take(&mut state.over);
    searches(model, state, &mut over, |search, over| {
        for (at, over) in over.iter_mut().enumerate() {
            let (row, column) = (at / search.across(), at % search.across());
            if row <= search.own.mesh.rows && column <= search.own.mesh.columns {
                search.node(row, column, over);
            }
        }
    });
    let mesh = &model.ply_type(0).mesh;
    for over in &mut over {
        let wrong = match (200.0 * numbers.between(-1.0, 1.0)) as i32 {
            0 => *over + 1,
            1 => over.saturating_sub(mesh.columns as u32),
            4..8 => *over | PENETRATING,
            _ => *over,
        };
        if layup::element(wrong) < mesh.elements() {
            *over = wrong;
        }
    }
    state.over = over;
}

/// Part of the nodes let through, once every node that is kept has been found to be left alone.
fn part<S: KernelScalar>(case: &Case, symmetry: bool) -> f64 {
    let mut counts = [0.0; 2];
    for seed in 1..=16 {
        let model = if symmetry { Model::<S>::part(case) } else { Model::new(case) }.unwrap();
        let mut state = State::new(case, &model);
        let kernels: Vec<_> = Vectors::all().into_iter().map(|kind| S::kernels(model.ply_type(0), kind)).collect();
        bulge(&model, &mut state, &mut Random(seed));
        searches(&model, &state, &mut state.over.clone(), |search, over| {
            // Not all columns, and a last part with fewer rows.
            let (mesh, across) = (search.own.mesh, search.across());
            for first in (0..=mesh.rows).step_by(ROWS) {
                let (rows, columns) = (first..(first + ROWS).min(mesh.rows + 1), 1..mesh.columns + 1);
                let over = &mut over[rows.start * across..rows.end * across];
                let mut pass = |kernels: &dyn RowKernels<S>| {
                    let (rows, columns, mut found) = (rows.clone(), columns.clone(), FoundContacts::default());
                    kernels.broad_phase(&mut SearchPart { search, rows, columns, over: &mut *over, found: &mut found });
                    found.candidates
                };
                let candidates = pass(&*kernels[0]);
                assert!(kernels.iter().all(|other| pass(&**other) == candidates), "registers differ");
                assert!(candidates.is_sorted() && candidates.windows(2).all(|pair| pair[0] != pair[1]));
                counts[0] += candidates.len() as f64;
                for (row, column) in rows.clone().flat_map(|row| columns.clone().map(move |column| (row, column))) {
                    counts[1] += 1.0;
                    let before = over[(row - rows.start) * across + column];
                    let mut after = before;
                    let found = search.node(row, column, &mut after).is_some();
                    if candidates.binary_search(&[row, column]).is_err() {
                        assert!(!found && after == before, "{row} {column} touches, or goes from {before} on");
                    }
                }
            }
        });
    }
    counts[0] / counts[1]
}

#[test]
fn what_is_kept_would_be_left_alone() {
    let within = |case: &Case, symmetry: bool, range: Range<f64>| {
        let parts = [part::<f64>(case, symmetry), part::<f32>(case, symmetry)];
        assert!(parts.iter().all(|part| range.contains(part)), "{}: {symmetry} {parts:?}", case.as_run);
    };
    for angles in [[0.0; 3], [0.0, 90.0, 0.0], [90.0, 0.0, -90.0], [90.0; 3]] {
        for (more, symmetry) in [(&[][..], false), (&[], true), (&["/pack/mesh_grading/fine_radius_mm=5"], false)] {
            within(&pack(angles, more), symmetry, 0.02..0.3);
        }
    }
    // Half of the pairs lie alike.
    within(&pack([0.0, 30.0, 30.0], &[]), false, 0.5..0.9);
}
