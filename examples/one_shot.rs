//! One shot: from a case to its outcome and its history.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use std::sync::atomic::AtomicBool;

use ripstop::run::{self, Options};
use ripstop::{case, output};

/// A small ply of a fabric that comes with ripstop, and a steel ball.
const CASE: &str = r#"{
  "title": "a small ply",
  "fabric": { "file": "fabrics/s-720.json" },
  "pack": { "width_mm": 40, "height_mm": 40, "edges": "clamped" },
  "projectile": { "shape": "sphere", "diameter_mm": 6, "density_kg_m3": 7850, "velocity_m_s": 120 },
  "solver": { "end_time_us": 60 }
}"#;

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let case = case::from_str("small ply", CASE, &[])?;
    let run = run::run(&case, Options::default(), &AtomicBool::new(false), &mut ())?;
    println!("time [µs]  velocity [m/s]  broken yarns");
    for row in run.history.iter().step_by(run.history.len().div_ceil(10).max(1)) {
        println!("{:9.1}  {:14.2}  {:12}", row.time * 1e6, row.projectile_velocity, row.failed[0] + row.failed[1]);
    }
    let left = output::residual_velocity(&case, &run);
    println!("{}, residual velocity {left:?} m/s, energy error {:.1e}", run.outcome.word(), run.energy_error);
    Ok(())
}
