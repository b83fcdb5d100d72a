//! The largest deflection is that of fabric that hangs on something.
//!
//! Promise: until a piece comes loose it is that of every sample, and no row of the history has more; debris that flies ahead does not count, what hangs on an edge does. What hangs is
//! told here by a flood from the edges over frames, which knows nothing of the solver's forest of pieces.
//! Red when: debris counts, samples before the first loose piece are lost, mirror images are forgotten.

use std::sync::atomic::AtomicBool;

use ripstop::FrameCollector;
use ripstop::case::{self, Case};
use ripstop::run::frame::{Frame, PlyMesh};
use ripstop::run::{self, Options, Run, Skips};

/// Looks over the end time, both included.
const LOOKS: usize = 81;

fn shot(velocity: f64) -> Case {
    let text = format!(
        r#"{{"title": "shot", "fabric": {{"file": "fabrics/s-720.json"}},
        "pack": {{"width_mm": 50, "height_mm": 45, "elements_per_crossover": 2,
            "mesh_grading": {{"fine_radius_mm": 11, "growth_ratio": 1.15, "max_crossovers": 2}}}},
        "projectile": {{"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 20, "mass_g": 3, "velocity_m_s": {velocity}}},
        "solver": {{"end_time_us": 60, "run_until": "end_time"}}, "output": {{"history_interval_us": 0.01}}}}"#
    );
    case::from_str("shot", &text, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// Largest deflection of what a flood from the edges over unbroken yarns reaches, and of elements that it leaves out and that still have a
/// yarn, 0 if there are none [m].
fn flooded(frame: &Frame, ply: &PlyMesh) -> (f64, f64) {
    let (columns, rows) = (ply.columns, ply.rows);
    let node = |row: usize, column: usize| ply.first_node + row * (columns + 1) + column;
    let whole = |yarn: usize, row: usize, column: usize| {
        row < rows && column < columns && frame.alive[yarn][ply.first_element + row * columns + column] == 1
    };
    let edge = |row: usize, column: usize| row == 0 || column == 0 || row == rows || column == columns;
    let all = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column)));
    let mut waiting: Vec<(usize, usize)> = all.filter(|(row, column)| edge(*row, *column)).collect();
    let mut reached = vec![false; (rows + 1) * (columns + 1)];
    while let Some((row, column)) = waiting.pop() {
        if std::mem::replace(&mut reached[row * (columns + 1) + column], true) {
            continue;
        }
        // Along the warp, which an element below or above the line carries; then along the weft.
        let below = row.wrapping_sub(1);
        let left = column.wrapping_sub(1);
        let warp = |column: usize| whole(0, row, column) || whole(0, below, column);
        let weft = |row: usize| whole(1, row, column) || whole(1, row, left);
        let next = [
            (warp(column), (row, column + 1)),
            (warp(left), (row, left)),
            (weft(row), (row + 1, column)),
            (weft(below), (below, column)),
        ];
        waiting.extend(next.into_iter().filter(|(linked, _)| *linked).map(|(_, at)| at));
    }
    let (mut largest, mut loose) = (0.0_f64, 0.0_f64);
    for row in 0..rows {
        for column in (0..columns).filter(|column| whole(0, row, *column) || whole(1, row, *column)) {
            for (row, column) in [(row, column), (row, column + 1), (row + 1, column), (row + 1, column + 1)] {
                let deflection = f64::from(frame.displacement[node(row, column)][2].abs());
                let of = if reached[row * (columns + 1) + column] { &mut largest } else { &mut loose };
                *of = of.max(deflection);
            }
        }
    }
    (largest, loose)
}

/// A run, the largest deflection that it should have, and the largest of debris [m].
fn flooded_run(case: &Case, skips: Skips) -> (Run, f64, f64) {
    let mut collector = FrameCollector::new(case, LOOKS);
    let run = run::run(case, Options::default().skips(skips), &AtomicBool::new(false), &mut collector).unwrap();
    let (frames, ply) = (collector.frames(), &collector.scene().unwrap().plies[0]);
    assert_eq!(frames.len(), LOOKS);
    let looks: Vec<(f64, f64)> = frames.iter().map(|frame| flooded(frame, ply)).collect();
    let whole = looks.iter().position(|(_, loose)| *loose > 0.0);
    let until = whole.map_or(f64::INFINITY, |first| frames[first - 1].time - 1e-12);
    let samples = run.history.iter().filter(|row| row.time < until).map(|row| row.deflection);
    let expected = samples.chain(looks.iter().map(|(largest, _)| *largest)).fold(0.0, f64::max);
    (run, expected, looks.iter().map(|(_, loose)| *loose).fold(0.0, f64::max))
}

#[test]
fn debris_does_not_count_and_what_hangs_does() {
    // At 220 m/s what the projectile pushes out still hangs on a yarn. (At 340 and 350 m/s what is torn folds, and the quarter and the whole
    // differ by 7e-6 and 2e-6.)
    for (velocity, debris) in [(220.0, false), (260.0, true), (280.0, true), (345.0, true), (420.0, true)] {
        let case = shot(velocity);
        let (part, expected, loose) = flooded_run(&case, Skips::default());
        let largest = part.deflections[0];
        assert_eq!(largest < 0.97 * loose, debris, "{velocity} m/s: {largest} {loose}");
        let rows = part.history.iter().map(|row| row.deflection).fold(0.0, f64::max);
        assert_eq!(rows, largest, "{velocity} m/s: the history");
        assert!((largest / expected - 1.0).abs() < 1e-6, "{velocity} m/s: {largest}, expected {expected}");
        let (whole, ..) = flooded_run(&case, Skips::NONE);
        assert!(
            (largest / whole.deflections[0] - 1.0).abs() < 1e-6,
            "{velocity} m/s: {largest} {:?}",
            whole.deflections
        );
    }
}

#[test]
fn while_nothing_is_loose_every_sample_counts() {
    let case = shot(60.0);
    let (run, ..) = flooded_run(&case, Skips::default());
    let samples = run.history.iter().map(|row| row.deflection).fold(0.0, f64::max);
    assert!(run.events.is_empty() && run.deflections == [samples] && samples > 1e-3);
}
