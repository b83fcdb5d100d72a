//! A velocity sweep: shots side by side, a thread each.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use rayon::prelude::*;
use ripstop::{BuiltInFabric, Case, Edge, Options, output};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    // A small ply and a blunt cylinder; the velocity is set for each shot.
    let case = Case::builder("a small ply")
        .fabric(BuiltInFabric::S720)
        .size_mm(30.0, 30.0)
        .edges(Edge::Clamped)
        .cylinder_mm(5.5, 10.0)
        .mass_g(1.0)
        .velocity_m_s(200.0)
        .end_time_us(200.0)
        .build()?;
    let shot = |velocity: f64| {
        let case = case.with("/projectile/velocity_m_s", velocity)?;
        // Each shot has one thread: shots side by side take less time than threads inside a shot.
        let run = Options::default().threads(1).run(&case)?;
        Ok((velocity, run.outcome, output::residual_velocity(&case, &run)))
    };
    let shots: Result<Vec<_>, Box<dyn Error + Send + Sync>> =
        [150.0, 250.0, 350.0, 400.0].par_iter().map(|v| shot(*v)).collect();
    for (velocity, outcome, left) in shots.map_err(|error| error.to_string())? {
        println!("{velocity:5.0} m/s  {:10}  residual {left:?} m/s", outcome.word());
    }
    Ok(())
}
