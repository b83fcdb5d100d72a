//! Clay behind the pack.
//!
//! Promises: a sheet thrown against clay stops where the closed form says, and what the clay takes of energy and momentum is booked; it
//! pushes nothing back; a part, a scene without skips and one that goes on from a checkpoint (`checkpoint`) are the whole; the verdict
//! says what the crater is worth. The drop test itself is `cases/verify/clay-drop.json`.
//! Red when: clay acts in front of its surface, in a crater that is there, or beyond its pressure; its energy or impulse is in no sum.

use ripstop::case::Case;
use ripstop::output::{behind, margins, summary};
use ripstop::run::outcome::Outcome;
use ripstop::run::{Precision, Run, Simulation, Skips};

use crate::support::{builtin, finish, run, run_as};

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
        assert!(end.kinetic.abs() < 1e-12 && run.energy_error < exact, "{} {}", end.kinetic, run.energy_error);
        assert!(
            run.momentum_error < exact && run.energy_gained.abs() < exact,
            "{} {}",
            run.momentum_error,
            run.energy_gained
        );
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
    assert!(
        stack.energy_error < 1e-9 && stack.momentum_error < 1e-9,
        "{} {}",
        stack.energy_error,
        stack.momentum_error
    );
}

/// A ball that four plies and clay bring to rest.
fn struck(sets: &[&str]) -> Case {
    let pack = ["/pack/width_mm=30.48", "/pack/height_mm=25.4", "/pack/edges=free", "/pack/plies=2", "/expect=[]"];
    let ball = r#"/projectile={"shape":"sphere","diameter_mm":8,"mass_g":1,"velocity_m_s":60}"#;
    let run = ["/output/profile_times_us=[]", "/solver/end_time_us=400", ball, "/backing={\"pressure_mpa\":5}"];
    builtin("cases/s720-1ply-155.json", &[&pack[..], &run, sets].concat())
}

#[test]
fn a_part_and_a_scene_without_rest_left_out_are_the_whole() {
    let of = |skips: Skips| {
        let case = struck(&["/solver/end_time_us=60"]);
        finish(Simulation::<f64>::with_skips(&case, skips).unwrap(), &case)
    };
    let [part, resting, whole] = [Skips::default(), Skips::WHOLE, Skips { wavefront: false, ..Skips::WHOLE }].map(of);
    assert_eq!((part.planes.copies(), resting.planes.copies()), (4, 1));
    assert!(resting.history == whole.history && resting.element_steps_computed < whole.element_steps_computed);
    for (p, w) in part.history.iter().zip(&whole.history) {
        let [p, w] = [p, w].map(|row| [row.balance.backing, row.balance.crater * 1e3, row.projectile_velocity / 60.0]);
        assert!(p.iter().zip(w).all(|(p, w)| (p - w).abs() < 1e-8), "{p:?} for {w:?}");
    }
    assert!(whole.history.last().unwrap().balance.backing > 0.1 && whole.energy_error < 1e-10);
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

#[test]
fn check_and_report_say_what_stands_behind_the_pack() {
    assert_eq!(behind(&struck(&["/backing=null"])), "nothing");
    assert_eq!(behind(&struck(&["/backing={}"])), "clay that resists with 0.71 MPa");
    assert_eq!(behind(&thrown(&[])), "0.5 mm of air, then clay that resists with 0.5 MPa");
    let deeper = struck(&["/backing={\"doubling_depth_mm\":20}"]);
    assert_eq!(behind(&deeper), "clay that resists with 0.53 MPa, twice that 20 mm deep");
}
