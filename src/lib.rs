//! ripstop

pub mod case;
pub mod kernels;
pub mod ledger;
pub mod model;
pub mod number;
pub mod outcome;
pub mod output;
pub mod profile;
pub mod simulation;
pub mod state;
pub mod step;
mod tally;
