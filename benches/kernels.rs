//! Kernels and whole shots under criterion: `cargo bench`.
//!
//! `unit_cell` times the crossover solve from a warm start, `step` one step of a ply in mid-shot with everything on,
//! `shot` the whole S-720 shot to its outcome (slow; few samples).
#![allow(clippy::unwrap_used, missing_docs, reason = "a benchmark that cannot go on has failed")]

use std::hint::black_box;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use ripstop::case::{self, Case};
use ripstop::physics::crossover;
use ripstop::physics::unit_cell_parameters::UnitCellParameters;
use ripstop::physics::yarn_law::Sinusoidal;
use ripstop::run::RunScalar;
use ripstop::run::{self, Options, Simulation};

fn shot(sets: &[&str]) -> Case {
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    case::read(Path::new("cases/s720-1ply-155.json"), &sets).unwrap()
}

fn unit_cell(c: &mut Criterion) {
    let case = shot(&[]);
    let cell = UnitCellParameters::<f64>::cast::<Sinusoidal>(&UnitCellParameters::new(&case.fabric));
    let rest = [cell.yarn[0].height, cell.yarn[1].height];
    let mut group = c.benchmark_group("unit_cell");
    for (name, stretch) in [("slack", [-1e-3, -1e-3]), ("onset", [1e-4, 0.0]), ("taut", [0.03, 0.02])] {
        let warm = crossover::solve::<f64, Sinusoidal>(&cell, stretch, rest, true).height;
        let moved = [stretch[0] + 2e-5, stretch[1] - 1e-5];
        group.bench_function(name, |b| {
            b.iter(|| crossover::solve::<f64, Sinusoidal>(&cell, black_box(moved), black_box(warm), true));
        });
    }
}

fn steps<S: RunScalar>(c: &mut Criterion, name: &str) {
    let case = shot(&["/solver/run_until=end_time"]);
    let mut simulation = Simulation::<S>::new(&case).unwrap();
    while simulation.time() < 60e-6 {
        simulation.advance(&case);
    }
    let mut group = c.benchmark_group("step");
    group.throughput(Throughput::Elements(simulation.model.elements() as u64));
    group.measurement_time(Duration::from_secs(4)).sample_size(20);
    group.bench_function(name, |b| b.iter(|| simulation.advance(&case)));
}

fn step(c: &mut Criterion) {
    steps::<f64>(c, "f64");
    steps::<f32>(c, "f32");
}

fn whole_shot(c: &mut Criterion) {
    let case = shot(&[]);
    let mut group = c.benchmark_group("shot");
    group.sample_size(10).measurement_time(Duration::from_secs(40));
    group.bench_function("s720-1ply-155", |b| {
        b.iter(|| {
            let options = Options::default();
            run::run(&case, options, &AtomicBool::new(false), &mut ()).unwrap().steps
        });
    });
}

criterion_group!(benches, unit_cell, step, whole_shot);
criterion_main!(benches);
