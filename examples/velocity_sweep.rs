//! A velocity sweep: shots side by side, a thread each.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;
use ripstop::run::{self, Options};
use ripstop::{case, output};

/// A small ply and a blunt cylinder; the velocity is set for each shot.
const CASE: &str = r#"{
  "title": "a small ply",
  "fabric": { "file": "fabrics/s-720.json" },
  "pack": { "width_mm": 30, "height_mm": 30, "edges": "clamped" },
  "projectile": { "shape": "rcc", "diameter_mm": 5.5, "length_mm": 10, "mass_g": 1, "velocity_m_s": 200 },
  "solver": { "end_time_us": 200 }
}"#;

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let velocities = [150.0, 250.0, 350.0, 400.0];
    let shot = |velocity: f64| {
        let case = case::from_str("sweep", CASE, &[format!("/projectile/velocity_m_s={velocity}")])?;
        // Each shot has one thread: shots side by side take less time than threads inside a shot.
        let options = Options::default().threads(1);
        let run = run::run(&case, options, &AtomicBool::new(false), &mut ())?;
        Ok((velocity, run.outcome, output::residual_velocity(&case, &run)))
    };
    let shots: Result<Vec<_>, Box<dyn Error + Send + Sync>> =
        velocities.par_iter().map(|velocity| shot(*velocity)).collect();
    for (velocity, outcome, left) in shots.map_err(|error| error.to_string())? {
        println!("{velocity:5.0} m/s  {:10}  residual {left:?} m/s", outcome.word());
    }
    Ok(())
}
