//! Plies that meet, slide, and are pressed together, without yarns having much to say.

use ripstop::case::Case;
use ripstop::model::layup;
use ripstop::run::{Precision, Simulation};
use ripstop::solver::element_totals::field as element;

use super::{advance, motion, pack};
use crate::scene::run_as;

/// Energy error where the work of moving nodes out of penetrations, counted to first order against the hourglass stiffness, is all
/// that rounding does not explain: twice the largest seen, 8.9e-8. Without that stiffness the same scenes close to 2e-15.
const FIRST_ORDER: f64 = 2e-7;
/// Energy error of rounding alone: hundreds of steps, of 1.1e-16 each.
const ROUNDING: f64 = 1e-12;

/// Free plies half a millimetre apart, the first flying at `velocity` [m/s].
fn flying(velocity: [f64; 3], friction: f64, second: &str) -> Case {
    let layup = format!(
        r#"{{"width_mm": 15, "height_mm": 12, "edges": "free", "spacing_mm": 0.8, "friction": {friction},
        "layup": [{{"initial_velocity_m_s": {velocity:?}}}, {{{second}}}]}}"#
    );
    pack(&layup, "", &["/output/history_interval_us=0.1"])
}

#[test]
fn two_plies_that_meet_share_their_momentum_and_lose_what_an_inelastic_impact_loses() {
    let case = flying([0.0, 0.0, 100.0], 0.3, "");
    let mut simulation = Simulation::<f64>::new(&case).unwrap();
    let (mass, _) = motion(&simulation, 0);
    advance(&mut simulation, &case, 10e-6);
    for ply in 0..2 {
        let (_, [x, y, z]) = motion(&simulation, ply);
        // A gap that rounds leaves the rest of it to the next step.
        assert!((z - 50.0).abs() < 1e-9 && x.abs() + y.abs() < 1e-9, "ply {ply}: {x} {y} {z}");
    }
    let run = simulation.into_run(1.0);
    let last = run.history.last().unwrap();
    let lost = 0.25 * mass * 100.0 * 100.0;
    assert!((last.balance.contact / lost - 1.0).abs() < 1e-9, "{} of {lost}", last.balance.contact);
    assert!(last.balance.friction.abs() < 1e-12 * lost);
    assert!(run.energy_error < 1e-12 && run.momentum_error < 1e-12, "{} {}", run.energy_error, run.momentum_error);
    assert!(run.max_ply_penetration < 1e-9, "{}", run.max_ply_penetration);
}

#[test]
fn plies_of_different_fabrics_and_orientations_meet_too() {
    for second in [
        r#""fabric": {"file": "fabrics/s-728.json"}"#,
        r#""orientation_deg": 90"#,
        r#""orientation_deg": 30"#,
        r#""orientation_deg": 57, "fabric": {"file": "fabrics/s-728.json"}"#,
    ] {
        let mut case = flying([0.0, 0.0, 100.0], 0.3, second);
        let mut simulation = Simulation::<f64>::new(&case).unwrap();
        let [(first, _), (other, _)] = [0, 1].map(|ply| motion(&simulation, ply));
        advance(&mut simulation, &case, 15e-6);
        let [(_, a), (_, b)] = [0, 1].map(|ply| motion(&simulation, ply));
        let momentum = first * a[2] + other * b[2];
        assert!((momentum / (first * 100.0) - 1.0).abs() < 1e-12, "{second}: {momentum}");
        // Edges that overhang fly on: the plies are as large, but not of the same shape.
        let common = 100.0 * first / (first + other);
        assert!((a[2] / common - 1.0).abs() < 0.15 && (b[2] / common - 1.0).abs() < 0.15, "{second}: {a:?} {b:?}");
        let run = simulation.into_run(1.0);
        assert!(
            run.energy_error < FIRST_ORDER && run.momentum_error < 1e-12,
            "{second}: {} {}",
            run.energy_error,
            run.momentum_error
        );
        case.solver.hourglass = 0.0;
        let soft = run_as(&case, Precision::F64, 2);
        assert!(soft.energy_error < ROUNDING, "{second}, no hourglass: {}", soft.energy_error);
        assert!(run.max_ply_penetration < 0.1 * 0.3e-3, "{second}: {}", run.max_ply_penetration);
    }
}

#[test]
fn friction_slows_by_coulomb_and_stops_sliding_at_most() {
    // The normal impulse on each ply is m·50 m/s, so friction may change a ply's speed by μ·50 m/s.
    for (friction, first, second) in [(0.2, 30.0, 10.0), (0.0, 40.0, 0.0), (2.0, 20.0, 20.0)] {
        let case = flying([40.0, 0.0, 100.0], friction, "");
        let mut simulation = Simulation::<f64>::new(&case).unwrap();
        advance(&mut simulation, &case, 8e-6);
        let [(mass, a), (_, b)] = [0, 1].map(|ply| motion(&simulation, ply));
        // A ply that slides overhangs by a few nodes, which have nothing to rub against.
        let allowed = 0.08 * 50.0 * friction.min(1.0) + 0.1;
        assert!((a[0] - first).abs() < allowed && (b[0] - second).abs() < allowed, "μ {friction}: {a:?} {b:?}");
        let run = simulation.into_run(1.0);
        let last = run.history.last().unwrap();
        assert!(
            run.energy_error < ROUNDING && run.momentum_error < 1e-12,
            "{} {}",
            run.energy_error,
            run.momentum_error
        );
        assert_eq!(last.balance.friction > 1e-6 * mass, friction > 0.0, "{}", last.balance.friction);
        assert!(last.balance.friction >= 0.0 && last.balance.contact > 0.0);
    }
}

#[test]
fn friction_takes_what_sliding_loses_and_contact_what_closing_does() {
    // So rough that the plies stick where they meet.
    let slid = |slide: f64| {
        let case = flying([slide, 0.0, 100.0], 2.0, "");
        let mut simulation = Simulation::<f64>::new(&case).unwrap();
        let (mass, _) = motion(&simulation, 0);
        advance(&mut simulation, &case, 10e-6);
        let run = simulation.into_run(1.0);
        let last = run.history.last().unwrap().balance;
        assert!((1.0..5.0).contains(&run.newton.mean_iterations), "{}", run.newton.mean_iterations);
        let lost = |speed: f64| 0.25 * mass * speed * speed;
        (last.contact / lost(100.0), last.friction / lost(20.0))
    };
    let (contact, friction) = slid(20.0);
    assert!((slid(0.0).0 - contact).abs() < 0.01, "{contact}");
    assert!((friction - 1.0).abs() < 0.01, "{friction}");
}

#[test]
fn a_ply_laid_across_another_that_is_alike_both_ways_is_as_one_laid_along_it() {
    let alike = ["/fabric/warp/crimp=0.02", "/fabric/weft/crimp=0.02"];
    let met = |second: &str| {
        let layup = format!(
            r#"{{"width_mm": 12.7, "height_mm": 12.7, "edges": "free", "spacing_mm": 0.8, "friction": 0.3,
            "layup": [{{"initial_velocity_m_s": [300, 120, 100]}}, {{{second}}}]}}"#
        );
        let case = pack(&layup, "", &alike);
        let mut simulation = Simulation::<f64>::new(&case).unwrap();
        advance(&mut simulation, &case, 14e-6);
        let motions = [0, 1].map(|ply| motion(&simulation, ply).1);
        let balance = simulation.into_run(1.0).history.last().unwrap().balance;
        (motions, [balance.contact, balance.friction])
    };
    let (along, across) = (met(""), met(r#""orientation_deg": 90"#));
    assert!(along.1[1] > 0.0, "they slide");
    for (a, b) in along.0.iter().zip(&across.0) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} {b:?}");
    }
    for (a, b) in along.1.iter().zip(&across.1) {
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }
}

#[test]
fn a_ply_slides_over_many_cells_of_another_and_never_through_it() {
    let case = flying([400.0, 150.0, 60.0], 0.0, "");
    let mut simulation = Simulation::<f64>::new(&case).unwrap();
    advance(&mut simulation, &case, 12e-6);
    let model = &simulation.model;
    let mesh = &model.ply_type(0).mesh;
    // 4.8 mm and 1.8 mm are 3.8 and 1.4 cells.
    let (row, column) = (2, 2);
    let behind = model.nodes_per_ply() + row * (model.grid.columns + 1) + column;
    let over = layup::element(simulation.state.over[behind]);
    let [r, c] = [over / mesh.columns, over % mesh.columns];
    assert!((r, c) == (3, 5), "{r} {c}");
    let run = simulation.into_run(1.0);
    assert!(run.max_ply_penetration < 0.05 * 0.3e-3, "{}", run.max_ply_penetration);
    assert!(run.history.last().unwrap().balance.contact > 0.0);
}

#[test]
fn nothing_tunnels_at_a_thousand_metres_a_second() {
    let case = flying([0.0, 0.0, 1000.0], 0.2, r#""plies": 3"#);
    let mut simulation = Simulation::<f64>::new(&case).unwrap();
    advance(&mut simulation, &case, 10e-6);
    let model = &simulation.model;
    for ply in 0..3 {
        let z = |ply: usize, row, column| {
            let [_, _, z] = model.reference(ply, row, column);
            z + simulation.state.displacement(model.grid.first_node_row(ply) + row, column)[2]
        };
        for row in 0..=model.grid.rows {
            for column in 0..=model.grid.columns {
                let apart = z(ply + 1, row, column) - z(ply, row, column);
                assert!(apart > 0.0, "plies {ply} and {}: {apart}", ply + 1);
            }
        }
        assert!(motion(&simulation, ply).1[2] > 100.0, "every ply was struck");
    }
}

#[test]
fn holes_are_holes() {
    // The second ply has lost the elements in its middle; the first is a small one that flies at the hole.
    let layup = r#"{"width_mm": 30, "height_mm": 30, "edges": "free", "spacing_mm": 0.5,
        "layup": [{"initial_velocity_m_s": [0, 0, 50]}, {}]}"#;
    let case = pack(layup, "", &[]);
    let mut simulation = Simulation::<f64>::new(&case).unwrap();
    let (rows, columns) = (simulation.model.grid.rows, simulation.model.grid.columns);
    let first = simulation.model.grid.first_element_row(1);
    let hole = |n: usize, count: usize| (count / 4..3 * count / 4).contains(&n);
    for row in (0..rows).filter(|row| hole(*row, rows)) {
        for column in (0..columns).filter(|column| hole(*column, columns)) {
            for yarn in 0..2 {
                simulation.state.elements.set(first + row, element::ALIVE + yarn, column + 1, 0.0);
            }
        }
    }
    advance(&mut simulation, &case, 6e-6);
    let speed = |row: usize, column: usize| simulation.state.velocity(row, column)[2];
    // Nothing has come in from the rim of the hole yet.
    assert!((speed(rows / 2, columns / 2) - 50.0).abs() < 1e-6, "{}", speed(rows / 2, columns / 2));
    assert!((speed(2, 2) - 25.0).abs() < 5.0, "{}", speed(2, 2));
}

#[test]
fn a_stack_under_a_plate_moves_as_one_and_every_interface_carries_its_load() {
    // A plate wider than the plies, and as heavy as three of them, strikes five free plies that touch each other.
    let layup = r#"{"plies": 5, "width_mm": 15, "height_mm": 12, "edges": "free", "friction": 0.2}"#;
    let plate = r#""projectile": {"shape": "cylinder", "diameter_mm": 60, "length_mm": 5, "mass_g": 0.1, "velocity_m_s": 30,
        "rotation": "locked"},"#;
    let case = pack(layup, plate, &["/solver/run_until=end_time"]);
    let mut simulation = Simulation::<f64>::new(&case).unwrap();
    advance(&mut simulation, &case, 5e-6);
    let (mass, _) = motion(&simulation, 0);
    let common = 30.0 * 1e-4 / (1e-4 + 5.0 * mass);
    for ply in 0..5 {
        let (_, [_, _, z]) = motion(&simulation, ply);
        assert!((z / common - 1.0).abs() < 1e-6, "ply {ply}: {z}, not {common}");
    }
    let run = simulation.into_run(1.0);
    assert!(run.max_ply_penetration < 1e-3 * 0.3e-3 && run.momentum_error < 1e-12, "{}", run.max_ply_penetration);
}

#[test]
fn a_heavy_ply_drives_a_stack_through_contact_between_plies_alone() {
    // The first ply weighs as much as forty others, and what it drives has to pass its load on, ply by ply.
    let heavy = r#"{"title": "heavy", "fabric": {"file": "fabrics/s-720.json"}, "pack": {"width_mm": 15, "height_mm": 12,
        "edges": "free", "layup": [{"initial_velocity_m_s": [0, 0, 20]}, {"plies": 4}]},
        "solver": {"end_time_us": 60}}"#;
    let sets = ["/pack/layup/0/fabric/areal_density_g_m2=10208".to_owned()];
    let case = ripstop::case::from_str("heavy", heavy, &sets).unwrap();
    let mut simulation = Simulation::<f64>::new(&case).unwrap();
    advance(&mut simulation, &case, 50e-6);
    for ply in 1..5 {
        let (_, [_, _, z]) = motion(&simulation, ply);
        assert!((z / (20.0 * 40.0 / 44.0) - 1.0).abs() < 0.05, "ply {ply}: {z}");
    }
    let run = simulation.into_run(1.0);
    assert!(run.max_ply_penetration < 0.25 * 0.3e-3, "{}", run.max_ply_penetration);
    assert!(run.energy_error < ROUNDING && run.momentum_error < 1e-12, "{} {}", run.energy_error, run.momentum_error);
}

#[test]
fn rollers_hold_only_plies_laid_along_the_axes() {
    let model = |angle: u32| {
        let layup = format!(
            r#"{{"width_mm": 15, "height_mm": 12, "layup": [{{}}, {{"orientation_deg": {angle}, "edges": "roller"}}]}}"#
        );
        ripstop::model::Model::<f64>::new(&pack(&layup, "", &[])).map(|_| ())
    };
    assert!(model(90).is_ok() && model(180).is_ok());
    assert!(model(30).unwrap_err().to_string().contains("a ply at 30.000000°"));
}
