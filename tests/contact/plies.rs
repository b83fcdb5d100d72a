//! Contact between plies: feet of points on cells, walks, impulses and the tests that spare them; and the broad phase, which keeps from the
//! search what would have been left alone, whatever the registers.

use std::ops::Range;

use nalgebra::Vector3;
use ripstop::Case;
use ripstop::model::Model;
use ripstop::model::layup::{self, PENETRATING, SIDES, neighbour};
use ripstop::num::simd::Vectors;
use ripstop::physics::ply_contact::*;
use ripstop::physics::rigid_body::Cut;
use ripstop::solver::contact::ply_search::{FoundContacts, PlySearch, ROWS, SearchPart};
use ripstop::solver::node_update::field as node;
use ripstop::solver::state::State;
use ripstop::solver::sweep::{KernelScalar, RowKernels};

use crate::support::{Random, shipped};

fn vector(random: &mut Random, size: f64) -> Vector3<f64> {
    random.vector(size).into()
}

fn unclamped([x, y]: [f64; 2]) -> [f64; 4] {
    [(0.5 - x) * (0.5 - y), (0.5 + x) * (0.5 - y), (0.5 + x) * (0.5 + y), (0.5 - x) * (0.5 + y)]
}

#[test]
fn a_folded_cell_has_no_surface() {
    let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.01, 0.0], [0.0, 0.01, 0.0]].map(Vector3::from);
    assert!(closest_point(&line, &Vector3::zeros(), 1.0, NO_PLANES).is_none());
    assert!(closest_point(&line, &Vector3::zeros(), 0.01, NO_PLANES).is_some());
}

#[test]
fn a_walk_stops_over_its_cell_and_at_the_edge() {
    assert_eq!(next_cell([3, 4], [0.2, -0.4], 8, 9), [3, 4]);
    assert_eq!(next_cell([3, 4], [1.2, -0.6], 8, 9), [2, 5]);
    assert_eq!(next_cell([7, 0], [-1.2, 3.0], 8, 9), [7, 0]);
    let whole = |at, cell| is_over(at, cell, 8, 9, [Cut::Nowhere; 2]);
    assert!(whole([0.5, -0.7], [0, 4]) && !whole([0.5, -0.8], [0, 4]));
    assert!(whole([0.7, 0.0], [3, 8]) && !whole([-0.7, 0.0], [3, 8]));
    assert!(!whole([0.0, 0.6], [6, 4]) && whole([0.0, 0.6], [7, 4]));
    let cut = |at, cell| is_over(at, cell, 8, 9, [Cut::Last, Cut::First]);
    assert!(!cut([0.5, -0.7], [0, 4]) && !cut([0.7, 0.0], [3, 8]), "the ply goes on beyond a mirror plane");
    assert!(cut([-0.7, 0.7], [7, 0]) && cut([0.5, -0.5], [0, 8]));
    // To the last bit: on an edge a node stays.
    let edge = 0.5 + EDGE;
    for (at, beyond) in [(0.5, 0), (edge, 0), (edge + 1e-9, 1)] {
        assert_eq!(next_cell([3, 4], [at, -at], 8, 9), [3 - beyond, 4 + beyond], "{at}");
        assert_eq!(next_cell([3, 4], [-at, at], 8, 9), [3 + beyond, 4 - beyond], "{at}");
        for at in [[at, 0.0], [-at, 0.0], [0.0, at], [0.0, -at]] {
            assert_eq!(whole(at, [3, 4]), beyond == 0, "{at:?}");
        }
    }
    let rim = 0.5 + SEGMENT_EXTENSION;
    assert!(whole([rim, rim], [7, 8]) && whole([-rim, -rim], [0, 0]));
    assert!(!whole([rim + 1e-9, 0.0], [7, 8]) && !whole([0.0, -rim - 1e-9], [0, 0]));
}

#[test]
fn corners_share_a_place_by_what_lies_across_and_what_is_beyond_an_edge_lies_on_it() {
    let mut random = Random(45);
    for _ in 0..200 {
        let place = [random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
        let inside = place.map(|x| x.clamp(-0.5, 0.5));
        let got = weights(place);
        let corners = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        for axis in 0..2 {
            let back: f64 = (0..4).map(|i| got[i] * corners[i][axis]).sum();
            assert!((back - inside[axis]).abs() < 1e-15, "{place:?}: {got:?}");
        }
        // With the product of both places, four numbers say what four weights are.
        let product: f64 = (0..4).map(|i| got[i] * corners[i][0] * corners[i][1]).sum();
        assert!((product - inside[0] * inside[1]).abs() < 1e-15 && (got.iter().sum::<f64>() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn an_impulse_stops_the_approach_and_rubs_at_most_by_coulomb() {
    let push = Vector3::z();
    let coming = Vector3::new(3.0, 4.0, -10.0);
    let (normal, drag) = impulse(&coming, &push, 0.0, 2.0, 0.1);
    assert_eq!(normal, 20.0);
    assert!((drag - Vector3::new(-1.2, -1.6, 0.0)).norm() < 1e-15);
    let (_, drag) = impulse(&coming, &push, 0.0, 2.0, 1.0);
    assert!((drag - Vector3::new(-6.0, -8.0, 0.0)).norm() < 1e-15, "sticks: {drag}");
    assert_eq!(impulse(&-coming, &push, 0.0, 2.0, 0.1), (0.0, Vector3::zeros()));
    assert_eq!(closing_limit(2.0, 0.5), -4.0);
    assert_eq!(closing_limit(-2.0, 0.5), 0.0);
    let full = (POSITION_CORRECTION * (1.0 - SLOP) + DEEP_RECOVERY * (1.0 - SLOP - DEEP)) * 2.0;
    assert!((recovery(-1.0, 1.0, -1.0, 0.5) - full).abs() < 1e-15);
    assert!((recovery(-1.0, 1.0, 0.1, 0.5) - (full - 0.1)).abs() < 1e-15);
    assert_eq!(recovery(-3.0, 1.0, 2.0, 1e-6), PASSED_SPEED - 2.0);
    // Short steps take a time, not a number of steps; of half a thickness of 1e-4 m here.
    let slow = 1e-4 * (DEEP - SLOP) / RECOVERY_TIME;
    assert!((recovery(-1e-4 * DEEP, 1e-4, 0.0, 1e-9) / slow - 1.0).abs() < 1e-12);
    assert!((recovery(-1e-4 * DEEP, 1e-4, 0.0, RECOVERY_TIME) / (slow * POSITION_CORRECTION) - 1.0).abs() < 1e-12);
    let near = recovery(-PASSED + 1e-9, 1.0, -1.0, 1e-6);
    assert!(near < FASTEST && (near / FASTEST - 1.0).abs() < 1e-3, "{near}");
    assert_eq!(recovery(-0.4, 1.0, 2.0, 1e-6), RECOVERY_SPEED - 2.0);
    assert_eq!((recovery(2.0, 0.5, -1.0, 0.5), recovery(-2.0, 0.5, 9.0, 0.5)), (0.0, 0.0));
}

#[test]
fn a_point_is_apart_above_a_flat_cell_alone() {
    let flat = |rise: f64| [[0.0, 0.0, 0.0], [1.0, 0.0, rise], [1.0, 1.0, rise], [0.0, 1.0, 0.0]].map(Vector3::from);
    let above = |z: f64| Vector3::new(0.5, 0.5, z);
    assert!(is_apart(&flat(0.0), &above(0.4), 1.0, 0.3, 1.0));
    assert!(is_apart(&flat(0.0), &above(-0.4), -1.0, 0.3, 1.0), "on the other side");
    assert!(!is_apart(&flat(0.0), &above(0.2), 1.0, 0.3, 1.0), "near");
    assert!(!is_apart(&flat(0.0), &Vector3::new(1.5, 0.5, 0.4), 1.0, 0.3, 1.0), "beside the cell");
    // A slope is flat to a twentieth of its length.
    assert!(is_apart(&flat(0.04), &above(0.5), 1.0, 0.3, 1.0));
    assert!(!is_apart(&flat(0.06), &above(0.9), 1.0, 0.3, 1.0), "steep");
    // Nearer than the cell's own rise.
    assert!(!is_apart(&flat(0.04), &above(0.37), 1.0, 0.3, 1.0));
}

/// A parallelogram with one corner at `first`.
fn parallelogram(first: Vector3<f64>, along: Vector3<f64>, across: Vector3<f64>) -> [Vector3<f64>; 4] {
    [first, first + along, first + along + across, first + across]
}

#[test]
fn the_foot_of_a_point_on_mirror_planes_lies_on_them() {
    let mut random = Random(43);
    for at in 0..4000 {
        // Across X, across Y, or both; the first edge of the cell lies on the plane, or the last.
        let on = [[true, false], [false, true], [true, true]][at % 3];
        let ends = [0, 1].map(|_| random.between(-1.0, 1.0) > 0.0);
        let mut edges = [Vector3::x() + vector(&mut random, 0.3), Vector3::y() + vector(&mut random, 0.3)];
        let mut first = vector(&mut random, 2.0);
        for axis in 0..2 {
            if on[axis] {
                edges[1 - axis][axis] = 0.0;
                first[axis] = if ends[axis] { -edges[axis][axis] } else { 0.0 };
            }
        }
        let [along, across] = edges;
        let corner = parallelogram(first, along, across);
        let mut normal = along.cross(&across);
        (0..2).filter(|axis| on[*axis]).for_each(|axis| normal[axis] = 0.0);
        let normal = normal.normalize();
        let place = [0, 1].map(|axis: usize| match (on[axis], ends[axis]) {
            (true, true) => 0.5,
            (true, false) => -0.5,
            _ => 0.7 * random.between(-1.0, 1.0),
        });
        let height = 0.2 * random.between(-1.0, 1.0);
        let point = first + along * (place[0] + 0.5) + across * (place[1] + 0.5) + normal * height;
        let planes = [0, 1].map(|axis| on[axis].then_some(axis));
        let Some(foot) = closest_point(&corner, &point, 1.0, planes) else { unreachable!("a sound cell") };
        assert!((foot.normal - normal).norm() < 1e-12 && (foot.height - height).abs() < 1e-12, "{foot:?}");
        assert!((0..2).all(|axis| (foot.at[axis] - place[axis]).abs() < 1e-12), "{foot:?} for {place:?}");
        assert!((0..2).all(|axis| !on[axis] || foot.at[axis].abs() == 0.5), "{foot:?}");
    }
    // A cell that stands almost upright on a plane has no surface there.
    for (up, sound) in [(0.04_f64, false), (0.06, true)] {
        let along = Vector3::new(up, 0.0, (1.0 - up * up).sqrt());
        let corner = parallelogram(Vector3::zeros(), along, Vector3::y());
        let point = Vector3::new(0.0, 0.5, 0.1);
        assert_eq!(closest_point(&corner, &point, 1.0, [Some(0), None]).is_some(), sound, "{up}");
        assert!(closest_point(&corner, &point, 1.0, NO_PLANES).is_some());
    }
}

#[test]
fn beyond_its_edges_a_cell_is_as_far_as_the_nearest_of_them() {
    let mut random = Random(44);
    let mut seen = 0;
    for _ in 0..5000 {
        let (along, across) = (Vector3::x() + vector(&mut random, 0.25), Vector3::y() + vector(&mut random, 0.25));
        let corner = parallelogram(vector(&mut random, 1.0), along, across);
        let point = corner[0] + (along + across) * 0.5 + vector(&mut random, 1.5);
        let Some(foot) = closest_point(&corner, &point, 1.0, NO_PLANES) else { unreachable!("a sound cell") };
        if foot.at.iter().all(|x| x.abs() <= 0.5) {
            continue;
        }
        seen += 1;
        let to_segment = |p: &Vector3<f64>, q: &Vector3<f64>| {
            let way = q - p;
            let part = ((point - p).dot(&way) / way.dot(&way)).clamp(0.0, 1.0);
            (point - p - way * part).norm()
        };
        let nearest = (0..4).map(|i| to_segment(&corner[i], &corner[(i + 1) % 4])).fold(f64::MAX, f64::min);
        let (arm, at) = on_edge(&corner, &point, foot.at);
        assert!((arm.norm() - nearest).abs() < 1e-12, "{corner:?} {point}: {arm} for {nearest}");
        let on: Vector3<f64> = corner.iter().zip(unclamped(at)).map(|(c, w)| c * w).sum();
        assert!((point - on - arm).norm() < 1e-12, "{at:?}");
    }
    assert!(seen > 3000, "{seen}");
    // An edge without length is one place.
    let triangle = [[0.0, 0.0, 0.0], [1.0, -0.5, 0.0], [1.0, 0.5, 0.0], [0.0, 0.0, 0.0]].map(Vector3::from);
    let (arm, _) = on_edge(&triangle, &Vector3::new(-2.0, 0.0, 0.0), [-2.5, 0.0]);
    assert_eq!(arm, Vector3::new(-2.0, 0.0, 0.0));
}

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
            see(&PlySearch::new(model, state, ply, side, other, false), over);
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
