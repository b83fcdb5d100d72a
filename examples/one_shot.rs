//! One shot: from a case to its outcome and its history.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use ripstop::{BuiltInFabric, Case, Edge, output};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    // A small ply of a fabric that comes with ripstop, and a steel ball.
    let case = Case::builder("a small ply")
        .fabric(BuiltInFabric::S720)
        .size_mm(40.0, 40.0)
        .edges(Edge::Clamped)
        .sphere_mm(6.0)
        .density_kg_m3(7850.0)
        .velocity_m_s(120.0)
        .end_time_us(60.0)
        .build()?;
    let run = case.run()?;
    println!("time [µs]  velocity [m/s]  broken yarns");
    for row in run.history.iter().step_by(run.history.len().div_ceil(10).max(1)) {
        println!("{:9.1}  {:14.2}  {:12}", row.time * 1e6, row.projectile_velocity, row.failed[0] + row.failed[1]);
    }
    let left = output::residual_velocity(&case, &run);
    println!("{}, residual velocity {left:?} m/s, energy error {:.1e}", run.outcome.word(), run.energy_error);
    Ok(())
}
