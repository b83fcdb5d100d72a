//! Fixtures: round windows, turned plies cut to the frame, clamps at corners, gaps between plies, clay behind the pack.
//!
//! Promises: a drum has the frequency of the closed form; a round window has no direction; a ply turned by 90° is the ply with warp and
//! weft exchanged; a part of a window is the whole; what is clamped holds, and what is cut loose does not. A sheet thrown against clay stops
//! where the closed form says, and what the clay takes of energy and momentum is booked; it pushes nothing back; the verdict says what the
//! crater is worth. The drop test itself is `cases/verify/clay-drop.json`.
//! Red when: an element outside the opening pulls, a node at its edge is free or has a wrong mass, a clamp moves; clay acts in front of its
//! surface, in a crater that is there, or beyond its pressure; its energy or impulse is in no sum.

use ripstop::Sample;
use ripstop::case::{self, Case, Opening, Shape};
use ripstop::model::Model;
use ripstop::output::checks::{Level, checks};
use ripstop::output::expect::frequency;
use ripstop::output::{self, Breakage, margins, summary};
use ripstop::run::outcome::{Outcome, covered, is_held};
use ripstop::run::{Precision, Run, Simulation, Skips};
use ripstop::solver::FailureEvent;
use ripstop::solver::element_totals::field as element;
use ripstop::solver::node_update::field as node;

use crate::support::{builtin, closes, finish, run, run_as, shipped};

const ROUND: &str = "cases/verify/turned-in-window.json";
const PAPER: &str = "cases/s720-1ply-155.json";
const SWAP: &str = "cases/verify/turned-swap.json";

fn models(case: &Case) -> [Model<f64>; 2] {
    [Model::new(case).unwrap(), Model::part(case).unwrap()]
}

/// Largest difference of the velocities of the projectile, over that at the start [-].
fn apart(one: &Case, other: &Case) -> f64 {
    let [one, other] = [one, other].map(run);
    assert_eq!(one.history.len(), other.history.len());
    let pairs = one.history.iter().zip(&other.history);
    let most = pairs.map(|(a, b)| (a.projectile_velocity - b.projectile_velocity).abs()).fold(0.0, f64::max);
    most / one.history[0].projectile_velocity
}

#[test]
fn a_drum_has_the_frequency_of_the_closed_form() {
    let sets = ["/projectile=null", "/solver/end_time_us=900", "/output/history_interval_us=1", "/expect=[]"];
    for (refined, within) in [(1, 0.012), (2, 0.008)] {
        let mesh = format!("/pack/elements_per_crossover={refined}");
        let case = shipped("cases/verify/mass-on-drum.json", &[&sets[..], &[&mesh]].concat());
        let mut simulation = Simulation::<f64>::with_skips(&case, Skips::default()).unwrap();
        let (model, state) = (&simulation.model, &mut simulation.state);
        let [radius, first_zero] = [50.8e-3, 2.404_825_557_695_773];
        for [ply, row, column] in model.node_places() {
            let [x, y, _] = model.reference(ply, row, column);
            let r = first_zero * x.hypot(y) / radius;
            // J₀ by its series.
            let terms = (1..20).scan(1.0, |term, n| {
                *term *= -0.25 * r * r / f64::from(n * n);
                Some(*term)
            });
            let z = if model.ply_type(0).is_clamped(row, column) { 0.0 } else { 5e-5 * (1.0 + terms.sum::<f64>()) };
            state.nodes.set(row, node::DISPLACEMENT + 2, column, z);
        }
        let run = finish(simulation, &case);
        let found = frequency(&run.history, [0.0, 1.0]).unwrap();
        let expected = first_zero / (2.0 * std::f64::consts::PI * radius) * (5e4_f64 / 0.2552).sqrt();
        assert!((found / expected - 1.0).abs() < within, "{refined}: {found} for {expected} Hz");
        assert!(run.energy_error < 1e-6, "{}", run.energy_error);
    }
}

#[test]
fn an_opening_holds_what_lies_outside_and_weighs_what_lies_inside() {
    for (file, mass) in
        [(ROUND, 0.2552 * std::f64::consts::PI * 0.0254_f64.powi(2)), (SWAP, 0.2552 * 50.8e-3 * 40.64e-3)]
    {
        let [model, part] = models(&builtin(file, &["/expect=[]"]));
        let ply_type = model.ply_type(0);
        let mesh = &ply_type.mesh;
        assert_ne!(mesh.frame.opening, Opening::Mesh);
        let [whole, cut] = [&model, &part].map(|model| {
            let mass = |[_, row, column]: [usize; 3]| model.ply_type(0).row_mass(row).mass[column];
            model.node_places().map(mass).sum::<f64>() * model.planes.copies() as f64
        });
        assert!((whole / mass - 1.0).abs() < 0.01 && (cut / whole - 1.0).abs() < 1e-12, "{whole} {cut} {mass}");
        let mut free = 0;
        for [_, row, column] in model.node_places() {
            let [x, y, _] = model.reference(0, row, column);
            let from = mesh.frame.inwards([x, y]).into_iter().fold(f64::INFINITY, f64::min);
            let around = mesh.around(row, column).filter(|[r, c]| mesh.is_present(*r, *c)).count();
            let held = ply_type.is_clamped(row, column);
            assert!(around > 0 || (held && ply_type.row_mass(row).mass[column] == 0.0));
            // The rectangle is free at the bottom alone.
            let free_side = file == SWAP && mesh.frame.inwards([x, y])[2] == from;
            assert!(free_side || held == (around < 4), "{x} {y}");
            assert!(!free_side || held == (around == 0) || from > 0.0, "{x} {y}");
            assert!(held || from > -mesh.longest(), "{x} {y}");
            free += usize::from(!held);
        }
        assert!(free > 500);
    }
}

#[test]
fn a_round_window_has_no_direction() {
    let of = |angle: &str| {
        shipped(ROUND, &[&format!("/pack/layup/0/orientation_deg={angle}"), "/solver/symmetry=none", "/expect=[]"])
    };
    for angle in ["37", "-90", "213.7"] {
        let apart = apart(&of(angle), &of("0"));
        assert!(apart < 1e-9, "{angle}: {apart}");
    }
}

#[test]
fn a_ply_turned_by_ninety_degrees_is_the_ply_with_warp_and_weft_exchanged() {
    for file in [ROUND, SWAP] {
        let case = shipped(file, &["/pack/layup/0/orientation_deg=123", "/expect=[]"]);
        let yarn = |name: &str| case.as_run["fabric"][name].to_string();
        let exchanged = [format!("/fabric/warp={}", yarn("weft")), format!("/fabric/weft={}", yarn("warp"))];
        let sets = [&exchanged[0], &exchanged[1], "/pack/layup/0/orientation_deg=33", "/expect=[]"];
        let apart = apart(&case, &shipped(file, &sets));
        assert!(apart < 1e-9, "{file}: {apart}");
    }
}

#[test]
fn a_quarter_of_a_window_is_the_whole() {
    let of = |symmetry: &str, more: &[&str]| {
        let angle = ["/pack/layup/0/orientation_deg=90", "/expect=[]"];
        shipped(ROUND, &[&angle[..], &[&format!("/solver/symmetry={symmetry}")], more].concat())
    };
    assert_eq!(models(&of("auto", &[]))[1].planes.0, [true, true]);
    assert_eq!(models(&of("auto", &["/projectile/offset_mm=[3,0]"]))[1].planes.0, [false, true]);
    assert_eq!(models(&of("auto", &["/pack/layup/0/orientation_deg=45"]))[1].planes.0, [false, false]);
    assert!(apart(&of("auto", &[]), &of("none", &[])) < 1e-9);
    let clamps = ["/pack/window=null", "/pack/corner_clamps_mm=9", "/pack/edges=free"];
    assert_eq!(models(&of("auto", &clamps))[1].planes.0, [true, true]);
    assert!(apart(&of("auto", &clamps), &of("none", &clamps)) < 1e-9);
}

#[test]
fn clamps_at_corners_hold_squares_of_every_ply_and_nothing_else() {
    let layup = r#"/pack/layup=[{}, {"orientation_deg": 90}, {"orientation_deg": 30}]"#;
    let clamps = ["/pack/window=null", "/pack/corner_clamps_mm=9", "/pack/edges=free", "/expect=[]", layup];
    let model = Model::<f64>::new(&builtin(ROUND, &clamps)).unwrap();
    for ply in 0..3 {
        let ply_type = model.ply_type(ply);
        let half = ply_type.mesh.frame.half;
        let (mut held, mut all) = (0, 0);
        for (row, column) in (0..=ply_type.mesh.rows).flat_map(|r| (0..=ply_type.mesh.columns).map(move |c| (r, c))) {
            if ply_type.row_mass(row).mass[column] > 0.0 {
                let [x, y, _] = model.reference(ply, row, column);
                let under = half[0] - x.abs() <= 9.000_001e-3 && half[1] - y.abs() <= 9.000_001e-3;
                assert_eq!(ply_type.is_clamped(row, column), under, "{ply}: {x} {y}");
                (held, all) = (held + usize::from(under), all + 1);
            }
        }
        assert!(held > 4 * 36 && all > 10 * held, "{held} of {all}");
    }
}

#[test]
fn a_frame_leaves_a_node_free_and_clamps_hold_one() {
    let refused = |sets: &[&str]| Model::<f64>::new(&builtin(ROUND, &[sets, &["/expect=[]"]].concat())).unwrap_err();
    let error = refused(&["/pack/window/diameter_mm=0.01"]);
    assert_eq!((&*error.location, &*error.expected), ("/pack", "a frame that leaves a node free"));
    let clamps = ["/pack/window=null", "/pack/edges=free"];
    let error = refused(&[&clamps[..], &["/pack/corner_clamps_mm=30"]].concat());
    assert_eq!((&*error.location, &*error.expected), ("/pack", "a frame that leaves a node free"));
    let error = refused(&[&clamps[..], &["/pack/corner_clamps_mm=0.001"]].concat());
    assert_eq!((&*error.location, &*error.found), ("/pack/corner_clamps_mm", "none"));
}

#[test]
fn gaps_lie_where_they_are_asked_for() {
    let layup =
        r#"/pack/layup=[{"plies": 2}, {"plies": 2, "standoff_mm": 3}, {"orientation_deg": 30, "standoff_mm": 0.5}]"#;
    let model = Model::<f64>::new(&builtin(ROUND, &[layup, "/expect=[]"])).unwrap();
    let z: Vec<f64> = model.plies.iter().map(|ply| ply.z * 1e3).collect();
    assert!(z.iter().zip([0.0, 0.3, 3.6, 3.9, 4.7]).all(|(z, expected)| (z - expected).abs() < 1e-9), "{z:?}");
    assert_eq!(model.ply_types.len(), 2, "a gap makes no other ply");
    assert!(model.plies[..4].iter().all(|ply| (ply.touching - 0.3e-3).abs() < 1e-12));
}

#[test]
fn outcomes_see_the_window() {
    // Yarns that break first at the rim tear the ply off.
    let fast = ["/projectile/diameter_mm=24", "/projectile/mass_g=60", "/projectile/velocity_m_s=150", "/expect=[]"];
    let case = builtin(ROUND, &[&fast[..], &["/solver/end_time_us=300", "/solver/run_until=outcome"]].concat());
    let torn = run(&case);
    let broken = Breakage::of(&case, &torn);
    assert!(broken.at_edges > broken.at_hit && broken.is_torn_off(), "{broken:?}");
    let warnings = output::checks::warnings(&case, &checks(&case, &torn));
    assert!(warnings.iter().any(|warning| warning.kind.name == "torn-off"), "{warnings:?}");
    // A wide body, whose covering yarns end at the rim, is held.
    let slow = ["/projectile/diameter_mm=40", "/projectile/mass_g=60", "/projectile/velocity_m_s=5", "/expect=[]"];
    let case = builtin(ROUND, &[&slow[..], &["/solver/end_time_us=3000", "/solver/run_until=outcome"]].concat());
    let run = run(&case);
    assert!(matches!(run.outcome, Outcome::Stopped | Outcome::Rebounded), "{:?}", run.outcome);
    assert!(run.frame_share < 1.0);
}

#[test]
fn fabric_that_tears_off_its_frame_before_it_breaks_at_the_hit_is_warned_of() {
    let sets = ["/pack/width_mm=30", "/pack/height_mm=30", "/solver/end_time_us=1", "/expect=[]"];
    let case = builtin(PAPER, &sets);
    let run = run(&case);
    let middle = [case.pack.mesh.count[0] as u32 / 2, case.pack.mesh.count[1] as u32 / 2];
    // Yarns by the last digit of the step.
    let at = |i: u32, step: u64| {
        let mut event = FailureEvent::default();
        (event.step, event.i, event.j, event.strain) = (step, i, middle[1] - 4 + (step % 10) as u32, 0.04);
        event
    };
    let (hit, edge) = (|step| at(middle[0], step), |step| at(0, step));
    let struck = |diameter: f64, outcome: Outcome, events: &[FailureEvent]| {
        let (mut case, mut run) = (case.clone(), run.clone());
        (run.outcome, run.events) = (outcome, events.to_vec());
        // It loses half before the third step, the rest, but for a thousandth, by the end of the sixth.
        let lost = [(0, 0.0), (3, 0.5), (6, 0.999), (20, 1.0)];
        let row = |(step, share)| {
            let mut sample = Sample::default();
            sample.time = f64::from(step) * run.time_step;
            sample.balance.projectile = run.impact_energy * (1.0 - share);
            sample
        };
        run.history = lost.map(row).into();
        case.projectile.as_mut().unwrap().shape = Shape::Sphere { diameter };
        let check = checks(&case, &run).into_iter().find(|check| check.name == "broken at the edges").unwrap();
        let warned = check.warning.is_some_and(|warning| warning.kind.code == "W8");
        assert_eq!(check.level, if warned { Level::Look } else { Level::Fine });
        (warned, check.value)
    };
    for (outcome, events, warned, at_edges) in [
        (Outcome::Stopped, &[][..], false, "0"),
        (Outcome::Stopped, &[hit(1), edge(2)], false, "1"),
        (Outcome::Stopped, &[hit(1), edge(2), edge(3)], true, "2"),
        // What breaks behind a projectile that is through decides nothing.
        (Outcome::Perforated, &[hit(1), edge(7), edge(8)], false, "0"),
        (Outcome::Perforated, &[edge(2), edge(3), hit(4), edge(7)], true, "2"),
        // Cloth that broke only at the clamps, and first at the clamps.
        (Outcome::Perforated, &[edge(2), edge(3)], true, "2"),
        (Outcome::Perforated, &[edge(1), hit(2), hit(3)], true, "1"),
        // One yarn that broke in many places is one, and broke where it broke first.
        (Outcome::Stopped, &[hit(1), hit(2), edge(11), edge(12), edge(21)], false, "0"),
    ] {
        assert_eq!(struck(5.5e-3, outcome, events), (warned, at_edges.to_owned()), "{events:?}");
    }
    // Whatever the projectile's size, an edge is not at the hit, nor the hit at an edge.
    for diameter in [0.5e-3, 2e-3, 20e-3, 60e-3, 1.0] {
        assert!(struck(diameter, Outcome::Stopped, &[edge(1), hit(2)]).0, "{diameter}");
        assert_eq!(struck(diameter, Outcome::Stopped, &[hit(4), edge(1)]), (false, "1".to_owned()), "{diameter}");
    }
    // No frame is there to tear off where a side is free.
    let free = builtin(PAPER, &[&sets[..], &[r#"/pack/edges={"left": "free"}"#]].concat());
    let mut run = run;
    run.events = vec![hit(1), edge(2), edge(3)];
    let broken = Breakage::of(&free, &run);
    assert_eq!((broken.at_edges, broken.torn_first), (2, [0, 1]));
}

#[test]
fn a_disc_cut_out_of_a_window_holds_nothing() {
    let case = builtin(ROUND, &["/expect=[]", "/pack/layup/0/orientation_deg=0", "/projectile/diameter_mm=4"]);
    let mut simulation = Simulation::<f64>::with_skips(&case, Skips::WHOLE).unwrap();
    let (model, state) = (&simulation.model, &mut simulation.state);
    let body = state.body.clone().unwrap();
    assert!(is_held(model, state, &body, 0, f64::INFINITY));
    for [_, row, column] in model.element_places() {
        let [x, y, _] = model.reference(0, row, column);
        if (14e-3..18e-3).contains(&x.hypot(y)) {
            (0..2).for_each(|yarn| state.elements.set(row, element::ALIVE + yarn, column + 1, 0.0));
        }
    }
    assert!(covered(model, state, &body, 0) && !is_held(model, state, &body, 0, f64::INFINITY));
}

#[test]
fn check_and_report_say_what_is_held() {
    let held = |sets: &[&str]| output::held(&builtin(ROUND, &[sets, &["/expect=[]"]].concat()));
    assert_eq!(held(&[]), "all outside a round window of 50.8 mm");
    let none = "/pack/window=null";
    assert_eq!(held(&[none]), "all sides clamped, cut to the frame");
    assert_eq!(
        held(&[none, "/pack/edges=free", "/pack/corner_clamps_mm=9"]),
        "all sides free; 9 mm at each corner clamped, cut to the frame"
    );
    let layup = r#"/pack/layup=[{"edges": {"left": "free", "top": "roller"}}, {}]"#;
    assert_eq!(
        held(&[none, layup]),
        "/pack/layup/0: right, bottom clamped; top on rollers; left free; /pack/layup/1: all sides clamped"
    );
    assert!(case::report(&builtin(ROUND, &[])).contains("/pack/window/diameter_mm"));
}

/// A pack that flies freely against clay 0.5 mm behind it.
fn thrown(sets: &[&str]) -> Case {
    let pack = ["/pack/width_mm=12.7", "/pack/height_mm=10.16", "/pack/edges=free", "/projectile=null", "/expect=[]"];
    let flight = ["/pack/initial_velocity_m_s=[0,0,100]", "/solver/end_time_us=150", "/solver/run_until=end_time"];
    let clay = ["/output/profile_times_us=[]", "/backing={\"gap_mm\":0.5,\"pressure_mpa\":0.5}"];
    builtin("cases/s720-1ply-155.json", &[&pack[..], &flight, &clay, sets].concat())
}

#[test]
fn a_sheet_thrown_against_clay_stops_where_the_closed_form_says() {
    let even: f64 = 0.5 * 0.2552 * 1e4 / 0.5e6;
    // p (d + d²/2D) = ½ Ad V²
    let doubling = "/backing/doubling_depth_mm=2";
    let deeper = 2e-3 * ((1.0 + 2.0 * even / 2e-3).sqrt() - 1.0);
    let runs = [(Precision::F64, 1e-10, None, even), (Precision::F64, 1e-10, Some(doubling), deeper)];
    for (precision, exact, set, depth) in runs.into_iter().chain([(Precision::F32, 1e-4, None, even)]) {
        let run = run_as(&thrown(set.as_slice()), precision, 2);
        let end = run.history.last().unwrap().balance;
        let energy = 0.5 * 0.2552 * 12.7e-3 * 10.16e-3 * 1e4;
        assert!((end.crater / depth - 1.0).abs() < 0.01, "{} for {depth} m", end.crater);
        assert!((end.backing / energy - 1.0).abs() < exact, "{} for {energy} J", end.backing);
        closes(&run, [exact; 2]);
        assert!(end.kinetic.abs() < 1e-12 && run.energy_gained.abs() < exact, "{} {}", end.kinetic, run.energy_gained);
        // Not before its surface: 0.5 mm at 100 m/s.
        let first = run.history.iter().find(|row| row.balance.backing > 0.0).unwrap();
        assert!((4.9e-6..6e-6).contains(&first.time), "{}", first.time);
        assert!(run.history.windows(2).all(|rows| rows[0].balance.crater <= rows[1].balance.crater));
    }
}

#[test]
fn a_stack_goes_deeper_by_its_weight() {
    let one = run(&thrown(&["/backing/gap_mm=0"])).history.last().unwrap().balance.crater;
    let stack = run(&thrown(&["/backing/gap_mm=0", "/pack/plies=3", "/solver/end_time_us=300"]));
    let end = stack.history.last().unwrap().balance;
    assert!((end.crater / one / 3.0 - 1.0).abs() < 0.05, "{} for three times {one} m", end.crater);
    closes(&stack, [1e-9; 2]);
}

/// A ball that four plies and clay bring to rest.
fn struck(sets: &[&str]) -> Case {
    let pack = ["/pack/width_mm=30.48", "/pack/height_mm=25.4", "/pack/edges=free", "/pack/plies=2", "/expect=[]"];
    let ball = r#"/projectile={"shape":"sphere","diameter_mm":8,"mass_g":1,"velocity_m_s":60}"#;
    let run = ["/output/profile_times_us=[]", "/solver/end_time_us=400", ball, "/backing={\"pressure_mpa\":5}"];
    builtin("cases/s720-1ply-155.json", &[&pack[..], &run, sets].concat())
}

fn found(case: &Case, run: &Run) -> (Option<f64>, Option<String>) {
    let row = margins(case, run).into_iter().find(|row| row.0 == "back-face signature");
    (summary(case, run, 0.0)["backface_signature_mm"].as_f64(), row.map(|row| format!("{} {}", row.1, row.2)))
}

#[test]
fn a_stopped_shot_has_a_signature_and_no_other() {
    let case = struck(&[]);
    let stopped = run(&case);
    assert_eq!((stopped.outcome, stopped.carried_velocity), (Outcome::Stopped, None));
    let (depth, row) = found(&case, &stopped);
    let (depth, row) = (depth.unwrap(), row.unwrap());
    assert!((2.0..8.0).contains(&depth), "{depth} mm");
    assert!(row.ends_with("in an assumed clay; NIJ 0101.06 accepts 44 mm"), "{row}");
    assert!(stopped.energy_gained.abs() < 0.01, "{}", stopped.energy_gained);
    let bare = struck(&["/backing=null", "/solver/end_time_us=100"]);
    assert_eq!(found(&bare, &run(&bare)), (None, None));
    // A plug that the clay holds against the ball slows it, and does not stop it.
    let fast = struck(&["/projectile/velocity_m_s=900"]);
    let through = run(&fast);
    assert_eq!((through.outcome, found(&fast, &through)), (Outcome::Perforated, (None, None)));
    let end = through.history.last().unwrap();
    assert!(end.balance.crater > 0.0 && end.contact_force > 0.0 && end.projectile_velocity > 100.0, "{end:?}");
}

#[test]
fn steps_are_short_enough_for_clay_to_act_on_a_slow_body() {
    let model = |sets: &[&str]| Simulation::<f64>::with_skips(&struck(sets), Skips::default()).unwrap().model;
    let [fast, slow] = ["200", "1"].map(|speed| model(&[&format!("/projectile/velocity_m_s={speed}")]));
    assert_ne!(fast.bound.set_by, "clay behind the pack");
    assert_eq!(slow.bound.set_by, "clay behind the pack");
    let [_, rate, _] = slow.clay(1).unwrap();
    assert!((slow.bound.critical_step * rate - 0.05).abs() < 1e-12 && slow.clay(0).is_none());
}
