//! Outcome of a shot.
//!
//! Promise: yarns that run on unbroken cover it, plugs and flaps do not; a ply that covers it holds it only where it ends at an edge
//! that is clamped, or is most of a free ply that does not outrun it, of the whole as of a quarter of a scene; a pack that nothing
//! holds stops it at their common velocity; past an edge it has passed; a shot that stopped flies back with no more energy than the
//! fabric had.
//! The largest deflection is that of fabric that is held: debris that flies ahead does not count. A flood from the edges over frames finds it.
//! Red when: a yarn is counted across a cut, an edge holds what it does not touch, or a run ends before its outcome is known.

use ripstop::case::Case;
use ripstop::model::Model;
use ripstop::output;
use ripstop::physics::rigid_body::RigidBody;
use ripstop::run::frame::{Frame, PlyMesh};
use ripstop::run::outcome::{self, Outcome};
use ripstop::run::{Options, Run, Simulation, Skips};
use ripstop::solver::node_update::field as node;
use ripstop::solver::state::State;
use ripstop::{BuiltInFabric, Edge, FrameCollector};

use crate::support::torn::{self, SEAM, ring};
use crate::support::{builtin, close, finish, read, run as run_case};

/// A ply struck in the middle, whose yarns a test cuts by hand.
struct Ply {
    case: Case,
    model: Model<f64>,
    body: RigidBody,
    state: State<f64>,
}

impl Ply {
    /// A ply held so; of it a quarter where `quarter` says so.
    fn new(edges: &str, quarter: bool) -> Self {
        let edges = format!("/pack/edges={edges}");
        let case = builtin("cases/s720-1ply-155.json", &[torn::PLY, &[&edges]].concat());
        let model = if quarter { Model::part(&case) } else { Model::new(&case) }.unwrap();
        assert_eq!(model.planes.copies(), if quarter { 4 } else { 1 });
        let (body, state) = (model.projectile.clone().unwrap(), State::new(&case, &model));
        Self { case, model, body, state }
    }

    /// Sews the ply up again, then cuts the yarns that `cut` names by row, column from the pack's centre, and yarn.
    fn cut(&mut self, cut: impl Fn(isize, isize, usize) -> bool) -> &mut Self {
        self.state = State::new(&self.case, &self.model);
        torn::cut(&self.model, &mut self.state, cut);
        self
    }

    /// Lets the nodes in the middle, up to `ring` from the centre, move at `speed` along the normal [m/s].
    fn moves(&mut self, ring: isize, speed: f64) -> &mut Self {
        let moved = |r: isize, c: isize| (r.abs().max(c.abs()) <= ring).then_some(speed);
        torn::put(&self.model, &mut self.state, node::VELOCITY + 2, moved);
        self
    }

    fn covered(&self) -> bool {
        outcome::covered(&self.model, &self.state, &self.body, 0)
    }

    /// Covered, and by what can hold the projectile.
    fn held(&self) -> bool {
        let [held, held_by_any] =
            [self.body.velocity.z, f64::INFINITY].map(|v| outcome::is_held(&self.model, &self.state, &self.body, 0, v));
        assert!(!held || held_by_any, "what holds is something");
        assert!(!held || self.covered(), "what holds covers");
        held
    }
}

#[test]
fn a_yarn_covers_that_runs_on_unbroken_on_both_sides() {
    let mut ply = Ply::new("clamped", false);
    let mut covered = |cut: &dyn Fn(isize, isize, usize) -> bool| ply.cut(cut).covered();
    assert!(covered(&|_, _, _| false));
    assert!(!covered(&|r, c, _| ring(r, c) <= 4), "a hole");
    assert!(!covered(&|r, c, _| ring(r, c) == 4), "a plug");
    assert!(!covered(&|r, c, yarn| [c, r][yarn] == 4), "a flap");
    assert!(!covered(&|r, c, yarn| [c, r][yarn] == -5), "a flap on the other side");
    assert!(covered(&|r, c, yarn| ring(r, c) <= 4 && (yarn, r) != (0, 1)), "one warp is left");
    assert!(covered(&|r, c, yarn| ring(r, c) <= 4 && (yarn, c) != (1, -1)), "one weft is left");
    assert!(covered(&|r, c, _| ring(r, c) == 12), "cut far away");
    assert!(covered(&|r, c, _| ring(r, c) <= 1), "a hole smaller than the projectile");
}

#[test]
fn a_patch_that_is_torn_out_covers_and_does_not_hold() {
    for quarter in [false, true] {
        let mut ply = Ply::new("clamped", quarter);
        assert!(ply.held(), "quarter {quarter}");
        let seam = |r: isize, c: isize| ring(r, c) == SEAM;
        ply.cut(|r, c, _| seam(r, c));
        assert!(ply.covered() && !ply.held(), "quarter {quarter}: torn out all round");
        // In columns of the seam only warps are cut, in rows only wefts: the others resist nothing across the seam.
        ply.cut(|r, c, yarn| ring([c, r][yarn], 0) == SEAM && seam(r, c));
        assert!(ply.covered() && !ply.held(), "quarter {quarter}: cut yarn by yarn");
        ply.cut(|r, c, yarn| seam(r, c) && (yarn, r) != (0, 7));
        assert!(ply.held(), "quarter {quarter}: one warp still holds the patch");
        ply.cut(|r, c, yarn| seam(r, c) && (yarn, c) != (1, 3));
        assert!(ply.held(), "quarter {quarter}: one weft still holds the patch");
        ply.cut(|r, c, yarn| seam(r, c) && (yarn, r) != (1, 7));
        assert!(!ply.held(), "quarter {quarter}: wefts in the seam link nothing across it");
    }
}

#[test]
fn a_piece_hangs_on_the_sides_that_are_held() {
    for quarter in [false, true] {
        // Cut off from left and right, and there reaching both free sides.
        let strip = |_: isize, c: isize, _: usize| ring(0, c) == SEAM;
        for (edges, held) in [
            (r#"{"left": "clamped", "right": "clamped", "bottom": "free", "top": "free"}"#, false),
            (r#"{"left": "free", "right": "free", "bottom": "clamped", "top": "clamped"}"#, true),
            // A roller is a symmetry plane: it lets the ply move along its normal.
            (r#"{"left": "clamped", "right": "clamped", "bottom": "roller", "top": "roller"}"#, false),
            (r#"{"left": "roller", "right": "roller", "bottom": "clamped", "top": "clamped"}"#, true),
        ] {
            let mut ply = Ply::new(edges, quarter);
            assert!(ply.held(), "{edges}");
            ply.cut(strip);
            assert!(ply.covered());
            assert_eq!(ply.held(), held, "quarter {quarter}, {edges}");
        }
    }
    // One side is enough, and only that one.
    for (side, inside) in [("left", -1), ("right", 1), ("bottom", -1), ("top", 1)] {
        let mut edges: serde_json::Map<_, _> =
            ["left", "right", "bottom", "top"].map(|name| (name.to_owned(), "free".into())).into_iter().collect();
        edges[side] = "clamped".into();
        let mut ply = Ply::new(&serde_json::Value::Object(edges).to_string(), false);
        let along = |r: isize, c: isize| if ["left", "right"].contains(&side) { c } else { r };
        assert!(ply.held(), "{side}");
        ply.cut(|r, c, _| along(r, c) == inside * SEAM);
        assert!(!ply.held(), "cut off from the {side}");
        ply.cut(|r, c, _| along(r, c) == -inside * SEAM);
        assert!(ply.held(), "cut on the side away from the {side}");
    }
}

#[test]
fn beside_a_break_only_what_lies_ahead_can_hold() {
    let right = r#"{"left": "free", "right": "clamped", "bottom": "free", "top": "free"}"#;
    for (ahead_of_the_break, held) in [(true, false), (false, true)] {
        let mut ply = Ply::new(right, false);
        // Warps are cut in the second column beside the middle: the rest of it has no support, and the wefts in it run on.
        ply.cut(|_, c, yarn| yarn == 0 && c == 1);
        let height = |_, c| Some(if (c <= 1) == ahead_of_the_break { 80e-3 } else { -20e-3 });
        torn::put(&ply.model, &mut ply.state, node::DISPLACEMENT + 2, height);
        assert!(ply.covered());
        assert_eq!(ply.held(), held, "debris ahead {ahead_of_the_break}");
    }
}

#[test]
fn a_free_ply_holds_as_long_as_it_is_the_ply_and_is_pushed() {
    for quarter in [false, true] {
        let mut ply = Ply::new("free", quarter);
        let speed = ply.body.velocity.z;
        assert!(ply.held(), "a whole ply at rest");
        assert!(ply.moves(isize::MAX, 0.9 * speed).held(), "pushed along");
        assert!(!ply.moves(isize::MAX, 1.1 * speed).held(), "faster than the projectile");
        assert!(ply.moves(isize::MAX, 0.0).moves(5, 3.0 * speed).held(), "only its middle is faster");
        // The ply has 80 elements across; 57 across are half of it.
        ply.cut(|r, c, _| ring(r, c) == 26);
        assert!(ply.covered() && !ply.held(), "quarter {quarter}: a patch of less than half the ply");
        ply.cut(|r, c, _| ring(r, c) == 30);
        assert!(ply.held(), "quarter {quarter}: what is left is most of the ply");
        ply.moves(29, 1.1 * speed);
        assert!(!ply.held(), "quarter {quarter}: what is left flies ahead, a rim stays behind");
    }
}

#[test]
fn debris_ahead_does_not_keep_a_shot_undecided() {
    let case = torn::case(&[]);
    let shot = |loose: bool| {
        let mut simulation = Simulation::<f64>::new(&case).unwrap();
        torn::tear(&simulation.model, &mut simulation.state, loose);
        let run = finish(simulation, &case);
        let last = run.history.last().unwrap();
        assert!(run.divergence.is_none() && last.contact_force == 0.0 && last.failed != [0; 2], "{last:?}");
        (run.outcome, last.time, last.perforated_plies)
    };
    let (through, time, plies) = shot(true);
    assert_eq!((through, plies), (Outcome::Perforated, 1));
    assert!((20e-6..45e-6).contains(&time), "known {time} s after impact: quiet, and looked at every 10 µs");
    let (running, time, plies) = shot(false);
    assert_eq!((running, plies), (Outcome::Running, 0));
    assert!(time >= 70e-6, "{time}");
}

/// The cylinder flies 42.1 mm and what the ply can be stretched, 27.1 mm, twice; a wave takes 25 µs to the clamps and back.
#[test]
fn a_shot_that_names_no_end_has_the_time_that_its_velocity_asks_for() {
    let ply = |velocity: f64| {
        let ply = Case::builder("slow").fabric(BuiltInFabric::S720).size_mm(203.0, 203.0);
        ply.cylinder_mm(5.5, 42.1).mass_g(3.0).velocity_m_s(velocity)
    };
    for (builder, end_us) in [
        (ply(155.0), 1000.0),
        (ply(140.0), 2000.0),
        (ply(20.0), 8000.0),
        (ply(0.01), 256_000.0),
        (ply(155.0).set("/projectile/obliquity_deg", 60), 2000.0),
        (ply(155.0).set("/projectile/standoff_mm", 100), 4000.0),
        // What nothing holds goes along as far as it is wide.
        (ply(155.0).edges(Edge::Free), 8000.0),
        (ply(20.0).end_time_us(700.0), 700.0),
    ] {
        let case = builder.build().unwrap();
        let end = case.solver.end_time * 1e6;
        assert!((end - end_us).abs() < 1e-6, "{end} instead of {end_us}: {:?}", case.projectile);
    }
    // At 1000 µs this one is not decided yet.
    let drop =
        Case::builder("drop").fabric(BuiltInFabric::S720).size_mm(25.0, 25.0).set("/pack/elements_per_crossover", 1);
    let run = run_case(&drop.sphere_mm(5.0).mass_g(20.0).velocity_m_s(3.0).build().unwrap());
    assert!(run.outcome == Outcome::Stopped && run.stop_time.is_some_and(|time| time > 1e-3), "{:?}", run.stop_time);
}

#[test]
fn a_shot_that_stopped_is_carried_on_until_it_flies_back() {
    let shot = |until: &str| {
        let until = format!("/solver/run_until={until}");
        let straight = ["/projectile/obliquity_deg=0", "/projectile/offset_mm=[0,0]", "/projectile/velocity_m_s=60"];
        let case =
            builtin("cases/verify/mirror.json", &[&straight[..], &[&until, "/solver/end_time_us=1500"]].concat());
        let run = run_case(&case);
        (case, run)
    };
    let [(_, stopped), (case, separated), (_, longest)] = ["outcome", "separation", "end_time"].map(shot);
    assert_eq!((stopped.outcome, stopped.rebound_velocity), (Outcome::Stopped, None));
    assert_eq!((separated.outcome, separated.stop_time), (Outcome::Rebounded, stopped.stop_time));
    let rebound = separated.rebound_velocity.unwrap();
    let last = separated.history.last().unwrap();
    // Free of the fabric for 20 µs, so that a run that goes on changes nothing before it is struck again.
    let end = last.time;
    assert!(separated.stop_time.unwrap() + 20e-6 < end && end < 1400e-6, "separated at {end} s");
    let free = separated.history.iter().filter(|row| row.time > end - 19e-6);
    assert!(free.clone().count() > 10);
    for row in free {
        assert!(row.contact_force == 0.0 && (row.projectile_velocity + rebound).abs() < 1e-9 * rebound, "{row:?}");
    }
    assert!(separated.history.iter().any(|row| row.time < end - 20e-6 && row.contact_force > 0.0));
    // What drives it back is what it gave the fabric, less what that keeps.
    assert!((0.05..0.95).contains(&(rebound / 60.0)), "{rebound} m/s");
    assert!(separated.energy_error < 1e-3, "{}", separated.energy_error);
    assert!(longest.history.len() > separated.history.len());
    for (one, other) in separated.history.iter().zip(&longest.history) {
        assert_eq!(format!("{one:?}"), format!("{other:?}"));
    }
    assert_eq!(longest.outcome, Outcome::Rebounded);
    let summary = output::summary(&case, &separated, 0.0);
    assert_eq!(summary["rebound_velocity_m_s"].as_f64(), Some(rebound));
    assert!(output::summary(&case, &stopped, 0.0)["rebound_velocity_m_s"].is_null());
}

/// A ply of 60 mm or so that nothing holds, struck in the middle.
fn free_ply(sets: &[&str]) -> Case {
    let free =
        ["/pack/width_mm=60", "/pack/height_mm=60", "/pack/edges=free", "/expect=[]", "/output/profile_times_us=[]"];
    let coarse = ["/pack/elements_per_crossover=1", "/solver/end_time_us=2000", "/projectile/velocity_m_s=60"];
    builtin("cases/s720-1ply-155.json", &[&free[..], &coarse[..], sets].concat())
}

#[test]
fn a_pack_that_nothing_holds_stops_a_shot_at_their_common_velocity() {
    for (edges, moving, symmetry) in [
        ("free", 0.0, "auto"),
        ("free", 0.0, "none"),
        ("free", 10.0, "auto"),
        // Rollers are symmetry planes: the pack moves along its normal.
        ("roller", 0.0, "auto"),
    ] {
        let (sides, drift) = (format!("/pack/edges={edges}"), format!("/pack/initial_velocity_m_s=[0,0,{moving}]"));
        let symmetry = format!("/solver/symmetry={symmetry}");
        let case = free_ply(&[&sides, &drift, &symmetry]);
        let run = run_case(&case);
        let place = format!("{edges} {moving} m/s {symmetry}");
        // Momentum alone: of the projectile, and of as much fabric as the pack is large.
        let (mass, fabric) =
            (3.0e-3, case.fabric.areal_density * case.pack.mesh.count[0] as f64 * case.pack.mesh.length[0]);
        let fabric = fabric * case.pack.mesh.count[1] as f64 * case.pack.mesh.length[1];
        let common = (mass * 60.0 + fabric * moving) / (mass + fabric);
        assert!(common < 50.0, "the pack takes part: {common} m/s");
        assert_eq!((run.outcome, run.rebound_velocity), (Outcome::Stopped, None), "{place}");
        let [before, after] = [run.history.len() - 2, run.history.len() - 1].map(|at| &run.history[at]);
        let stop = run.stop_time.unwrap();
        assert!(before.time - 1e-6 < stop && stop <= after.time, "{place}: {stop} s, {before:?} {after:?}");
        let carried = run.carried_velocity.unwrap();
        assert!((carried / common - 1.0).abs() < 0.01, "{place}: {carried} for {common} m/s");
        assert_eq!(after.failed, [0; 2]);
        let summary = output::summary(&case, &run, 0.0);
        let told = ["carried_velocity_m_s", "residual_velocity_m_s"].map(|key| summary[key].as_f64());
        assert_eq!(told, [Some(carried), Some(0.0)]);
    }
}

#[test]
fn a_projectile_past_a_free_edge_has_passed_without_breaking_a_yarn() {
    let beside = ["/pack/height_mm=12", "/projectile/offset_mm=[0,7]", "/projectile/velocity_m_s=100"];
    for edges in [r#"/pack/edges={"bottom":"free","top":"free"}"#, "/pack/edges=free"] {
        let case = free_ply(&[&beside[..], &[edges]].concat());
        let run = run_case(&case);
        let last = run.history.last().unwrap();
        assert_eq!((run.outcome, last.failed, last.perforated_plies), (Outcome::Perforated, [0; 2], 0), "{edges}");
        assert!(run.history.iter().any(|row| row.contact_force > 0.0) && last.projectile_velocity < 100.0, "{edges}");
        assert!(last.time < 400e-6, "known at {} s", last.time);
    }
    // What has not met the fabric yet, or never does, has not passed it.
    let case = free_ply(&["/projectile/standoff_mm=8", "/solver/end_time_us=100"]);
    assert_eq!(run_case(&case).outcome, Outcome::Running);
}

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
    read("shot", &text, &[])
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
    let run = Options::default().skips(skips).observe(case, &mut collector).unwrap();
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
    // At 60 m/s nothing breaks and every sample counts. At 198 m/s what the projectile pushes out still hangs on a yarn. (At 340 and 350 m/s what is torn folds, and the quarter and the whole
    // differ by 7e-6 and 2e-6.)
    for (velocity, debris) in
        [(60.0, false), (198.0, false), (260.0, true), (280.0, true), (345.0, true), (420.0, true)]
    {
        let case = shot(velocity);
        let (part, expected, loose) = flooded_run(&case, Skips::default());
        let largest = part.deflections[0];
        assert_eq!(largest < 0.97 * loose, debris, "{velocity} m/s: {largest} {loose}");
        let rows = part.history.iter().map(|row| row.deflection).fold(0.0, f64::max);
        assert_eq!(rows, largest, "{velocity} m/s: the history");
        close(largest, expected, 1e-6);
        let (whole, ..) = flooded_run(&case, Skips::NONE);
        close(largest, whole.deflections[0], 1e-6);
    }
}
