//! The resumed run and the one that was never interrupted.

use rayon::ThreadPoolBuilder;
use ripstop::case::Case;
use ripstop::run::RunScalar;
use ripstop::run::checkpoint::Checkpoint;
use ripstop::run::{Run, Simulation};

use super::*;
use crate::kept::{pack, quarter, result};
use crate::support::Random;

/// The end of a run: what it gives, and the bytes of its last state.
struct End {
    run: Run,
    state: Vec<u8>,
}

/// Runs to the end on so many threads; a checkpoint before each of these steps.
fn finish<S: RunScalar>(
    case: &Case,
    mut simulation: Simulation<S>,
    threads: usize,
    at: &[u64],
    shelf: &Shelf,
) -> (End, Vec<Checkpoint>) {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut kept = Vec::new();
        while !simulation.finished(case) {
            if at.contains(&simulation.state.step) {
                kept.push(shelf.save(case, &simulation));
            }
            simulation.advance(case);
        }
        let mut state = bytemuck_bytes(&simulation);
        state.extend(format!("{:?}", simulation.state.body).bytes());
        (End { run: simulation.into_run(1.0), state }, kept)
    })
}

fn bytemuck_bytes<S: RunScalar>(simulation: &Simulation<S>) -> Vec<u8> {
    let state = &simulation.state;
    let numbers = state.nodes.data.iter().chain(state.elements.data.iter());
    let mut bytes: Vec<u8> = numbers.flat_map(|x| x.to_f64().to_bits().to_le_bytes()).collect();
    bytes.extend(state.over.iter().flat_map(|over| over.to_le_bytes()));
    bytes.extend(format!("{:?}", state.active).bytes());
    bytes
}

/// From 20 random steps between `first` and the last, the same end.
fn resumes_equal<S: RunScalar>(case: &Case, steps: u64, seed: u64) -> Run {
    let shelf = Shelf::new();
    let mut random = Random(seed);
    let at: Vec<u64> = (0..20).map(|_| random.between(1.0, steps as f64) as u64).collect();
    let (whole, kept) = finish(case, start::<S>(case), 2, &at, &shelf);
    assert!(kept.len() >= 15 && whole.run.steps > steps, "{} of {}", kept.len(), whole.run.steps);
    for (checkpoint, threads) in kept.iter().zip([1, 2, 3].into_iter().cycle()) {
        let resumed = Simulation::<S>::resume(case, checkpoint).unwrap_or_else(|e| panic!("{e}"));
        let (end, _) = finish(case, resumed, threads, &[], &shelf);
        let [one, two] = [&whole.run, &end.run].map(|run| result(case, run));
        let step = checkpoint.head().step;
        for (one, two) in one.iter().zip(&two) {
            assert_eq!(one, two, "from step {step} on {threads} threads");
        }
        assert_eq!(one.len(), two.len(), "from step {step}");
        assert!(whole.state == end.state, "the last state, from step {step}");
    }
    whole.run
}

#[test]
fn one_ply_in_f64_goes_on_bit_by_bit_from_20_random_steps() {
    let run = resumes_equal::<f64>(&ply(), 160, 1);
    assert!(run.events.len() > 20 && run.profiles.len() == 3, "{} {}", run.events.len(), run.profiles.len());
}

#[test]
fn a_ply_with_shock_viscosity_goes_on_bit_by_bit_from_20_random_steps() {
    let mut case = ply();
    case.solver.shock_viscosity = 0.3;
    let run = resumes_equal::<f64>(&case, 160, 6);
    assert!(run.events.len() > 20, "{}", run.events.len());
}

#[test]
fn one_ply_in_f32_goes_on_bit_by_bit_from_20_random_steps() {
    let run = resumes_equal::<f32>(&ply(), 160, 2);
    assert!(run.events.len() > 20, "{}", run.events.len());
}

#[test]
fn a_pack_in_f64_goes_on_bit_by_bit_from_20_random_steps() {
    let run = resumes_equal::<f64>(&pack(), 110, 3);
    let last = run.history.last().unwrap();
    assert!(run.events.len() > 20 && last.eroded > 0, "{} {}", run.events.len(), last.eroded);
    assert!(last.balance.friction > 0.0 && run.max_ply_penetration > 0.0);
}

#[test]
fn a_pack_in_f32_goes_on_bit_by_bit_from_20_random_steps() {
    let run = resumes_equal::<f32>(&pack(), 110, 4);
    assert!(run.events.len() > 20, "{}", run.events.len());
}

#[test]
fn a_quarter_of_a_scene_goes_on_to_its_outcome() {
    let run = resumes_equal::<f64>(&quarter(), 100, 5);
    assert_eq!((run.planes.copies(), run.stop_time.is_some()), (4, true));
}

#[test]
fn what_each_kernel_took_so_far_is_kept() {
    let (case, shelf) = (pack(), Shelf::new());
    let mut simulation = start::<f32>(&case);
    for _ in 0..20 {
        simulation.advance(&case);
    }
    let checkpoint = shelf.save(&case, &simulation);
    let before = simulation.into_run(1.0).kernel_seconds;
    assert!(before.len() == 5 && before.iter().all(|(_, seconds)| *seconds > 0.0), "{before:?}");
    let resumed = Simulation::<f32>::resume(&case, &checkpoint).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(resumed.into_run(1.0).kernel_seconds, before);
}
