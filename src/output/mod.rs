//! What a run leaves behind: `summary.json`, `history.csv`, `events.csv`, `profiles.csv`, the picture
//! `shot.svg`, the case as run and, on request, frames for ParaView.
//!
//! Every file is written beside its place, flushed to the disk and renamed, and nothing is renamed before all files
//! are complete: a folder holds the whole result of one run, never half of one.

mod breakage;
pub(crate) mod chart;
mod checkpoint;
pub mod checks;
pub(crate) mod csv;
mod energies;
pub mod expect;
#[doc(hidden)]
pub mod expectation;
mod folder;
#[cfg(feature = "frames")]
pub mod frames;
pub mod history;
mod lock;
#[doc(hidden)]
pub mod number;
mod picture;
#[cfg(feature = "report")]
pub mod report;
mod summary;
mod surface;
mod verdict;
#[cfg(feature = "frames")]
mod vtu;
pub mod warnings;

pub use breakage::Breakage;
pub use checkpoint::{CheckpointWriteError, CheckpointWriter};
pub use energies::Energies;
pub use expect::{Checked, check};
#[doc(hidden)]
pub use folder::temporary;
pub use folder::{CHECKPOINT, Folder, OutputError, StagedFrames};
pub use picture::picture;
pub(crate) use summary::velocity_left;
pub use summary::{absorbed_energy, flies_freely, residual_velocity, summary};
pub use verdict::{Verdict, verdict};
#[doc(hidden)]
pub use verdict::{place, reached, symmetry};
