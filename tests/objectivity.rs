//! Objectivity: `ripstop bench --objectivity` and the tables that the book shows of it.
//!
//! Promises: the table is that of the files in `benches/`; those are what this code computes (the reference's limit and
//! residual velocity are shot again); what a cone loses to a ply hangs on no step and no place. Red when: a change of contact,
//! failure or time stepping moves the limit, the book does not show those of the files, or yarns that are broken hold on.

use std::fs;

use ripstop::output;
use ripstop::run::outcome::Outcome;
use ripstop::study::bench::objectivity::report;
use serde_json::Value;

use crate::scene::{run, shipped};

/// What `bench --objectivity --json` wrote, and how the case was set: the default, converged, and the paper's numerics.
const FILES: [(&str, &str); 3] = [
    ("benches/objectivity.json", "/solver/numerics=default"),
    ("benches/objectivity-converged.json", "/solver/accuracy=converged"),
    ("benches/objectivity-paper.json", "/solver/numerics=paper"),
];

fn report_of(file: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap()
}

#[test]
fn the_book_shows_what_was_measured() {
    for (file, _) in FILES {
        let made = report::markdown(&report_of(file));
        crate::docs::hold(&format!("ripstop bench --objectivity --markdown, from {file}"), &made);
    }
}

#[test]
fn the_limit_and_the_velocity_left_above_it_are_those_measured() {
    for (file, set) in FILES {
        let report = report_of(file);
        let reference = &report["settings"][0];
        let shot = |velocity: f64| {
            let sets = [
                "/expect=[]".to_owned(),
                "/output/profile_times_us=[]".to_owned(),
                "/solver/end_time_us=1600".to_owned(),
                set.to_owned(),
                format!("/projectile/velocity_m_s={velocity:?}"),
            ];
            let file = format!("cases/{}.json", report["case"].as_str().unwrap());
            let case = shipped(&file, &sets.each_ref().map(String::as_str));
            let run = run(&case);
            (run.outcome, output::residual_velocity(&case, &run).unwrap())
        };
        let number = |key: &str| reference[key].as_f64().unwrap();
        assert_eq!(shot(number("stopped_m_s")).0, Outcome::Stopped, "{file}");
        assert_eq!(shot(number("perforated_m_s")).0, Outcome::Perforated, "{file}");
        let left = shot(report["above_limit"].as_f64().unwrap() * number("limit_m_s")).1;
        assert!((left - number("residual_velocity_m_s")).abs() < 1e-9 * left, "{file}: {left}");
    }
}

#[test]
fn broken_yarns_do_not_hold_a_cone_by_chance() {
    let absorbed = |velocity: f64, set: &str| -> f64 {
        let projectile = r#"/projectile={"shape": "cone", "diameter_mm": 5.5, "length_mm": 42.1, "nose_length_mm": 6, "mass_g": 3, "friction": 0.2}"#;
        let speed = format!("/projectile/velocity_m_s={velocity}");
        let sets = ["/expect=[]", "/output/profile_times_us=[]", "/solver/end_time_us=2000", projectile, &speed, set];
        let case = shipped("cases/s720-1ply-155.json", &sets);
        let run = run(&case);
        assert_eq!(run.outcome, Outcome::Perforated, "{set}");
        0.5 * 3e-3 * (velocity.powi(2) - output::residual_velocity(&case, &run).unwrap().powi(2))
    };
    // Where one row of elements broke alone, 9.2 and 7.2 J, and 7.7 and 5.0 J, of 9.4 J at the limit.
    let steps = ["/solver/courant=0.9", "/solver/courant=0.95"].map(|set| absorbed(83.0, set));
    assert!((steps[0] - steps[1]).abs() < 0.4, "{steps:?}");
    let places = ["[0, 0]", "[0.4, 0.2]"].map(|place| absorbed(119.0, &format!("/projectile/offset_mm={place}")));
    assert!((places[0] - places[1]).abs() < 0.4, "{places:?}");
}
