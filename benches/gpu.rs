//! The GPU backend by size: `cargo bench --bench gpu [-- --test] [-- --adapter NAME]`.
//!
//! For each pack: device time of every kernel, element-steps per second of whole steps, bytes moved, and what a step costs
//! the host (measured on a device that does nothing). Then the shot.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    missing_docs,
    reason = "a benchmark prints, and stops when it cannot go on"
)]

use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use ripstop::case::{self, Case};
use ripstop::gpu::buffers::Sizes;
use ripstop::gpu::layout::StepInfo;
use ripstop::gpu::stepper::DeviceStepper;
use ripstop::gpu::{self, Device};
use ripstop::model::Model;
use ripstop::run::{self, Options};
use ripstop::solver::state::State;

/// Packs: name, plies, edge [mm].
const PACKS: [(&str, u32, u32); 5] = [
    ("1 ply 160 x 160", 1, 203),
    ("4 plies 160 x 160", 4, 203),
    ("16 plies 160 x 160", 16, 203),
    ("50 plies 160 x 160", 50, 203),
    ("1 ply of 1 m2", 1, 1000),
];

/// Bytes that a kernel moves per element and step (docs/decisions/15).
const BYTES: [(&str, u64); 3] = [
    // With the ring around a tile.
    ("sweep", 106),
    // The few nodes near the projectile.
    ("projectile_contact", 0),
    // Velocities 12, yarns alive 4. Only in sampled steps.
    ("energy_balance", 12 + 4),
];
/// Steps of a batch: every third is sampled, and a submission has room for 64 samples.
const STEPS: u64 = 3 * 64;

fn shot(plies: u32, edge: u32, sets: &[&str]) -> Case {
    let mut all = vec![format!("/pack/width_mm={edge}"), format!("/pack/height_mm={edge}")];
    all.push("/output/profile_times_us=[]".to_owned());
    all.extend(sets.iter().map(ToString::to_string));
    let mut case = case::read(Path::new("cases/s720-1ply-155.json"), &all).unwrap();
    // The plies lie in one plane: a pack's load on the kernels, without contact between plies.
    case.pack.plies = plies;
    case
}

/// Steps from `first`, every third sampled, as in a shot with the default history.
fn steps(stepper: &DeviceStepper<'_>, first: u64, count: u64) -> Vec<StepInfo> {
    let slot = |at: u64| (at.is_multiple_of(3)).then_some((at / 3) as u32);
    (0..count).map(|at| stepper.whole_step(first + at, slot(at), 3)).collect()
}

fn pack(device: &Device, name: &str, case: &Case, test: bool) {
    let model = Model::<f32>::new(case).unwrap();
    let state = State::new(case, &model);
    let elements = model.elements() as u64;
    let mut stepper = match DeviceStepper::new(device, &model) {
        Ok(stepper) => stepper,
        Err(error) => return println!("{name}: {error}"),
    };
    stepper.upload(&model, &state);
    // Into the shot, so that unit cells have work to do.
    let mut at = 0;
    let warm = if test { 3 } else { 90 };
    let start = Instant::now();
    while at < warm && start.elapsed().as_secs_f64() < 10.0 {
        let sent = stepper.submit(&steps(&stepper, at, 3));
        stepper.collect(&sent).unwrap();
        at += 3;
    }
    let per_step = start.elapsed().as_secs_f64() / at as f64;
    let count = if test { 3 } else { ((3.0 / per_step) as u64).clamp(3, STEPS) };
    let batch = steps(&stepper, at, count);
    let start = Instant::now();
    let sent = stepper.submit(&batch);
    stepper.collect(&sent).unwrap();
    let seconds = start.elapsed().as_secs_f64() / count as f64;
    at += count;
    let rate = elements as f64 / seconds;
    println!("{name}: {elements} elements, {:.1} MB", Sizes::new(&model).total() as f64 * 1e-6);
    println!("  step                {:10.1} µs  {:10.2} M element-steps/s", seconds * 1e6, rate * 1e-6);
    let times = stepper.kernel_seconds();
    if times.is_empty() {
        println!("  the device has no clock for kernels");
    }
    // Totals by the timed steps; a third of the steps is sampled.
    for (kernel, bytes) in BYTES {
        let Some((_, total)) = times.iter().find(|(name, _)| *name == kernel) else { continue };
        let time = total / if kernel == "energy_balance" { at as f64 / 3.0 } else { at as f64 };
        let moved = (bytes * elements) as f64 / time;
        println!("  {kernel:19} {:10.1} µs  {bytes:4} bytes per element  {:8.1} GB/s", time * 1e6, moved * 1e-9);
    }
}

/// Time of the host for recording and submitting a step.
fn host(case: &Case, test: bool) {
    let model = Model::<f32>::new(case).unwrap();
    let device = Device::noop();
    let mut stepper = DeviceStepper::new(&device, &model).unwrap();
    stepper.upload(&model, &State::new(case, &model));
    let batches = if test { 1 } else { 20 };
    let batch = steps(&stepper, 0, STEPS);
    stepper.submit(&batch);
    let start = Instant::now();
    for _ in 0..batches {
        stepper.submit(&batch);
    }
    let each = start.elapsed().as_secs_f64() / (batches * STEPS) as f64;
    println!("host: {:.2} µs per step to record and submit", each * 1e6);
}

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let test = arguments.iter().any(|a| a == "--test");
    let wanted = arguments.iter().position(|a| a == "--adapter").and_then(|at| arguments.get(at + 1));
    host(&shot(1, 203, &[]), test);
    let device = match gpu::device::choose(&gpu::adapters(), wanted.map(String::as_str)) {
        Ok(adapter) => Device::open(&adapter).unwrap(),
        Err(error) => return println!("{error}: nothing else to measure"),
    };
    println!("adapter: {}", device.name());
    for (name, plies, edge) in &PACKS[..if test { 1 } else { PACKS.len() }] {
        pack(&device, name, &shot(*plies, *edge, &[]), test);
    }
    let until = if test { "/solver/end_time_us=5" } else { "/solver/end_time_us=400" };
    let case = shot(1, 203, &[until]);
    let options = Options::default().device(&device);
    let run = run::run(&case, options, &AtomicBool::new(false), &mut ()).unwrap();
    println!("s720-1ply-155: {} steps, loop {:.3} s, {}", run.steps, run.loop_seconds, run.outcome.word());
}
