//! The library: one shot, a sweep of velocities, and one unit cell.
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::error::Error;

use rayon::prelude::*;
use ripstop::{BuiltInFabric, Case, Edge, Options, output, unit_cell};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    one_shot()?;
    velocity_sweep()?;
    warp_tension()
}

/// One shot: from a case to its outcome and its history.
fn one_shot() -> Result<(), Box<dyn Error>> {
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

/// A velocity sweep: shots side by side, a thread each.
fn velocity_sweep() -> Result<(), Box<dyn Error>> {
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

/// One unit cell: tension of the warp as it is stretched, while the weft is held or free to straighten.
fn warp_tension() -> Result<(), Box<dyn Error>> {
    // Only the fabric matters here.
    let case = Case::builder("a unit cell").fabric(BuiltInFabric::S720).size_mm(10.0, 10.0).end_time_us(1.0).build()?;
    let warp: Vec<f64> = (0..=6).map(|step| 1.0 + 0.005 * f64::from(step)).collect();
    println!("warp stretch  weft stretch  warp tension [N]  weft tension [N]");
    for point in unit_cell::solve(&case.fabric, &warp, &[0.99, 1.0]) {
        let [warp, weft, warp_tension, weft_tension, ..] = point.numbers().map(|(_, number)| number);
        println!("{warp:12.3}  {weft:12.3}  {warp_tension:16.2}  {weft_tension:16.2}");
    }
    Ok(())
}
