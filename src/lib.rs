//! ripstop computes the ballistic impact of woven fabrics with the method of Shahkarami & Vaziri (2006): one shell
//! element per yarn crossover, a Newton solve for the warp–weft interaction in every element, trellis shear with
//! locking, yarn failure and erosion, explicit time integration.
//!
//! # From a case to a verdict
//!
//! ```text
//! case ──► model ──► state ──► step ──► simulation ──► output
//! JSON     constant  varies    order    host loop      files
//! ```
//!
//! - [`case`] reads JSON, checks it and converts it to SI. Only it knows keys and textile units.
//! - [`model`] derives what stays constant: the plies, and for each sheet of alike plies mesh, unit-cell constants, masses,
//!   critical step.
//! - [`state`] is what varies, in rows laid out (ply, row, column), each ply in its own axes; [`reach`] is what may have moved.
//! - [`kernels`] hold the arithmetic, one kernel or piece of point physics per file, generic over [`number::Real`].
//! - [`step`] is the only place that knows the order of the kernels on the CPU, [`gpu`] on a graphics processor, where every
//!   kernel has a twin in `shaders/`, by name and by binding order, held to it by tests.
//! - [`simulation`] is the host loop: checks of the numbers, end of the run; `record` is what a run has produced (history, failure
//!   events), the same for both backends.
//!   [`ledger`] keeps energy and momentum, [`outcome`] decides what became of the projectile,
//!   `deflection` measures the largest of what hangs on something, [`profile`] deflection and waves. Whoever wants to follow a run implements [`simulation::Watch`] and gets
//!   progress and [`frame`]s, the whole scene at one time.
//! - [`checkpoint`] writes a run down between two steps, and lets it go on from there to the same bits.
//! - [`diff`] holds finished runs and measured curves against each other; [`study`] makes a ballistic limit of many shots, fired or
//!   computed.
//! - [`warnings`] says what makes a result less certain than it looks: numbered, each with its threshold.
//! - [`output`] writes files, [`output::report`] the page among them, and checks expectations; [`verify`] is the built-in verification
//!   table, [`validate`] holds published numbers against what is computed, [`bench`] measures run time against error.
//!
//! # What always holds
//!
//! - Kernels never touch files, threads or devices; the model never sees a backend; only [`gpu`] knows wgpu.
//! - Nothing allocates inside the step loop but records (failures, history rows).
//! - Sums run in fixed order: same case, same bits, whatever the number of threads.
//! - Of a scene that is its own mirror image a part is computed ([`model::symmetry`]); `record` makes results whole again.
//! - What nothing has reached is exactly at rest, to the last bit, and is left out.
//! - A number that is not finite, or energy nobody put in, stops the run with step, kernel and place.
//!
//! # Example
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//! use ripstop::{case, simulation::{self, Options}};
//!
//! let text = r#"{
//!   "title": "small ply",
//!   "fabric": { "file": "fabrics/s-720.json" },
//!   "pack": { "width_mm": 25, "height_mm": 25, "edges": "clamped" },
//!   "projectile": { "shape": "sphere", "diameter_mm": 6, "mass_g": 1, "velocity_m_s": 50 },
//!   "solver": { "end_time_us": 5 }
//! }"#;
//! let case = case::from_str("small", text, &[])?;
//! let run = simulation::run(&case, Options::default(), &AtomicBool::new(false), &mut ())?;
//! assert!(run.energy_error < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod aligned;
pub mod bench;
pub mod case;
pub mod checkpoint;
mod deflection;
pub mod diff;
pub mod frame;
pub mod gpu;
pub mod kernels;
pub mod lanes;
pub mod ledger;
pub mod markdown;
pub mod model;
pub mod number;
pub mod outcome;
pub mod output;
mod pieces;
pub mod profile;
pub mod reach;
mod record;
pub mod simulation;
pub mod state;
pub mod step;
pub mod study;
mod tally;
pub mod unit_cell;
pub mod validate;
pub mod verify;
pub mod warnings;
mod watch;
