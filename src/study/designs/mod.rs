//! Designs: which velocity the next shot should have, from what became of the shots before it.
//!
//! Every design is a function of the shots so far: a campaign that was broken off goes on where it stood. Velocities that were fired
//! may differ from those asked for; the designs go on from what was fired.

mod d_optimal;
mod langlie;
mod neyer;
mod replay;
mod robbins_monro;
mod three_pod;
mod up_down;

pub use d_optimal::d_optimal;
pub use langlie::Langlie;
pub use neyer::Neyer;
pub use robbins_monro::RobbinsMonro;
pub use three_pod::ThreePod;
pub use up_down::{Staircase, UpDown};
