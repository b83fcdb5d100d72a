//! Kernels and whole shots on the processor: `cargo bench --bench kernels [-- --test]`.
//!
//! `unit_cell` times the crossover solve from a warm start, `step` one step of a ply in mid-shot with everything on,
//! `shot` the whole S-720 shot to its outcome.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    missing_docs,
    reason = "a benchmark prints, and stops when it cannot go on"
)]

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use ripstop::case::{self, Case};
use ripstop::physics::crossover;
use ripstop::physics::unit_cell_parameters::UnitCellParameters;
use ripstop::physics::yarn_law::Sinusoidal;
use ripstop::run::{Options, RunScalar, Simulation};

/// Samples of each time, of which the median and the least are printed.
const SAMPLES: usize = 15;

fn shot(sets: &[&str]) -> Case {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    case::read(Path::new("cases/s720-1ply-155.json"), &sets).unwrap()
}

/// Times `repeats` calls, again and again, and prints the time of one.
fn time(name: &str, repeats: u32, mut call: impl FnMut()) {
    let (repeats, samples) = if std::env::args().any(|word| word == "--test") { (1, 1) } else { (repeats, SAMPLES) };
    let sample = |_| {
        let start = Instant::now();
        (0..repeats).for_each(|_| call());
        start.elapsed().as_secs_f64() / f64::from(repeats)
    };
    let mut seconds: Vec<f64> = (0..samples).map(sample).collect();
    seconds.sort_by(f64::total_cmp);
    println!("{name:24} median {:12.3} µs, least {:12.3} µs", 1e6 * seconds[samples / 2], 1e6 * seconds[0]);
}

fn unit_cell() {
    let case = shot(&[]);
    let cell = UnitCellParameters::<f64>::cast::<Sinusoidal>(&UnitCellParameters::new(&case.fabric));
    let rest = [cell.yarn[0].height, cell.yarn[1].height];
    for (name, stretch) in [("slack", [-1e-3, -1e-3]), ("onset", [1e-4, 0.0]), ("taut", [0.03, 0.02])] {
        let warm = crossover::solve::<f64, Sinusoidal>(&cell, stretch, rest, true).height;
        let moved = [stretch[0] + 2e-5, stretch[1] - 1e-5];
        time(&format!("unit_cell/{name}"), 100_000, || {
            black_box(crossover::solve::<f64, Sinusoidal>(&cell, black_box(moved), black_box(warm), true));
        });
    }
}

fn steps<S: RunScalar>(name: &str) {
    let case = shot(&["/solver/run_until=end_time", "/solver/end_time_us=1000"]);
    let mut simulation = Simulation::<S>::new(&case).unwrap();
    while simulation.time() < 60e-6 {
        simulation.advance(&case);
    }
    time(&format!("step/{name}, {} elements", simulation.model.elements()), 20, || {
        simulation.advance(&case);
    });
}

fn main() {
    unit_cell();
    steps::<f64>("f64");
    steps::<f32>("f32");
    let case = shot(&[]);
    time("shot/s720-1ply-155", 1, || drop(Options::default().run(&case).unwrap()));
}
