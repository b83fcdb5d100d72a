//! Objectivity: `ripstop bench --objectivity` and the tables that the book shows of it.
//!
//! Promises: the table is that of the files in `benches/`; those are what this code computes (the reference's limit and
//! residual velocity are shot again). Red when: a change of contact, failure or time stepping moves the limit, or
//! the book does not show those of the files.

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
