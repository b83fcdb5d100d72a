//! The examples run.
//!
//! Goes red when one of them ends with an error. It cannot see what they print.

#[path = "../examples/one_shot.rs"]
mod one_shot;
#[path = "../examples/unit_cell.rs"]
mod unit_cell;
#[path = "../examples/velocity_sweep.rs"]
mod velocity_sweep;

#[test]
fn one_shot_runs() {
    one_shot::main().unwrap();
}

#[test]
fn the_velocity_sweep_runs() {
    velocity_sweep::main().unwrap();
}

#[test]
fn the_unit_cell_runs() {
    unit_cell::main().unwrap();
}
