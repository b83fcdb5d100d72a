//! Time of each stage of a step in packs of several plies, on the processor. `cargo bench --bench packs`.

#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark prints, and stops where it cannot go on")]

use std::path::Path;
use std::time::{Duration, Instant};

use ripstop::case;
use ripstop::model::Model;
use ripstop::solver::energy_balance::EnergyBalance;
use ripstop::solver::state::State;
use ripstop::solver::{Context, Stepper};

/// Plies, elements per side, steps before the clock starts.
const PACKS: [(u32, f64, u64); 4] = [(1, 203.0, 300), (4, 203.0, 300), (16, 120.0, 250), (50, 120.0, 250)];

fn main() {
    let test = std::env::args().any(|argument| argument == "--test");
    println!("S-728, RCC at 91 m/s, f64, {} threads; every other step sampled", rayon::current_num_threads());
    println!("plies  elements  reached  ns per element reached: elements  nodes  plies  projectile  all; plies' share");
    for (plies, size, warm) in PACKS {
        let (size, warm) = if test { (30.0, 3) } else { (size, warm) };
        pack(plies, size, warm, if test { 2 } else { 20 });
    }
}

fn pack(plies: u32, size: f64, warm: u64, steps: u64) {
    let sets = [format!("/pack/plies={plies}"), format!("/pack/width_mm={size}"), format!("/pack/height_mm={size}")];
    let case = case::read(Path::new("cases/s728-4ply-91.json"), &sets).unwrap();
    let model = Model::<f64>::new(&case).unwrap();
    let mut state = State::new(&case, &model);
    let mut ledger = EnergyBalance::default();
    let mut stepper = Stepper::new(&model);
    for step in 0..warm {
        stepper.step(&model, &mut state, &mut ledger, step.is_multiple_of(2));
    }
    let mut spent = [Duration::ZERO; 4];
    let mut computed = 0;
    for step in 0..steps {
        let mut context = Context::new(&model, &mut state, &mut ledger, step.is_multiple_of(2));
        let mut last = Instant::now();
        let mut lap = |stage: usize| {
            let now = Instant::now();
            spent[stage] += now - last;
            last = now;
        };
        stepper.elements(&mut context);
        lap(0);
        stepper.nodes(&mut context);
        lap(1);
        stepper.plies(&mut context);
        lap(2);
        stepper.projectile(&mut context);
        lap(3);
        computed += context.totals.computed;
        state.step += 1;
    }
    let each = spent.map(|time| time.as_secs_f64() * 1e9 / computed as f64);
    let all: f64 = each.iter().sum();
    println!(
        "{plies:5}  {:8}  {:6.0} %  {:31.1}  {:5.1}  {:5.1}  {:10.2}  {all:5.1}; {:.0} %",
        model.elements(),
        100.0 * computed as f64 / (steps as f64 * model.elements() as f64),
        each[0],
        each[1],
        each[2],
        each[3],
        100.0 * each[2] / all
    );
}
