//! Files of a run: `summary.json`, `history.csv`, `events.csv`, `profiles.csv`, `shot.svg`, `report.html`, the case as run and, on
//! request, frames for ParaView.
//!
//! Every file is written beside its place, flushed to the disk and renamed, and nothing is renamed before all files
//! are complete: a folder holds the whole result of one run, never half of one.

mod breakage;
mod checkpoint;
pub mod checks;
pub mod csv;
pub mod expect;
mod folder;
#[cfg(feature = "frames")]
pub mod frames;
#[doc(hidden)]
pub mod number;
pub mod report;
mod sheet;
mod summary;
pub mod warnings;

pub use breakage::Breakage;
pub use checkpoint::CheckpointWriter;
pub use expect::check;
pub use folder::{CHECKPOINT, Folder, StagedFrames, write_whole};
pub use report::animation::{AnimatedPly, Animation, Keyframe};
#[doc(hidden)]
pub use sheet::{element_step, run_time, sheet};
pub use summary::{
    Energies, Verdict, absorbed_energy, areal_density, costs, margins, residual_velocity, summary, verdict,
};
#[doc(hidden)]
pub use summary::{place, reached, symmetry};
