//! ripstop computes the ballistic impact of woven fabrics with the method of Shahkarami & Vaziri (2006): one shell
//! element per yarn crossover, a Newton solve for the warp–weft interaction in every element, trellis shear with
//! locking, yarn failure and erosion, explicit time integration.
//!
//! # From a case to a verdict
//!
//! Ten rooms. Each uses those above it, never one below; a test holds that.
//!
//! ```text
//! math      numbers, several at once, sums in fixed order, random numbers, distributions
//! case      JSON, checked, in SI: what the user asks
//! kernels   the arithmetic of a step, each with its twin in shaders/
//! model     what stays constant: plies, mesh, unit-cell constants, masses, critical step
//! solver    what varies, and one step of it on the processor: state, order of the kernels, energy balance
//! gpu       the same step on a graphics processor
//! run       the host loop of both, outcome, history, frames, checkpoints
//! output    files: results, report, pictures, frames for ParaView, quality of a result
//! study     many runs: benchmark, verification, validation, comparison, ballistic limits
//! cli       the commands
//! ```
//!
//! - Only [`case`] knows keys and textile units.
//! - [`kernels`] are generic over [`math::scalar::Real`], one kernel or piece of point physics per file, by name and by binding order
//!   like the shaders; tests hold the twins together.
//! - [`solver`] is the only place that knows the order of the kernels on the CPU, [`gpu`] on a graphics processor.
//!   State lies in rows (ply, row, column), each ply in its own axes; [`solver::active_region`] is what may have moved.
//! - [`run::run`] is the host loop. Whoever wants to follow a run implements [`run::Observer`] and gets progress and [`run::frame`]s.
//!   [`run::outcome`] decides what became of the projectile.
//! - [`output::trust`] and [`output::warnings`] say what makes a result less certain than it looks.
//!
//! # What always holds
//!
//! - Kernels never touch files, threads or devices; the model never sees a backend; only [`gpu`] knows wgpu.
//! - Nothing allocates inside the step loop but records (failures, history rows).
//! - Sums run in fixed order: same case, same bits, whatever the number of threads.
//! - Of a scene that is its own mirror image a part is computed ([`kernels::mirror_planes`]); the run makes results whole again.
//! - What nothing has reached is exactly at rest, to the last bit, and is left out.
//! - A number that is not finite, or energy that was never put in, stops the run with step, kernel and place.
//!
//! # Example
//!
//! ```
//! use std::sync::atomic::AtomicBool;
//! use ripstop::{case, run::{self, Options}};
//!
//! let text = r#"{
//!   "title": "small ply",
//!   "fabric": { "file": "fabrics/s-720.json" },
//!   "pack": { "width_mm": 25, "height_mm": 25, "edges": "clamped" },
//!   "projectile": { "shape": "sphere", "diameter_mm": 6, "mass_g": 1, "velocity_m_s": 50 },
//!   "solver": { "end_time_us": 5 }
//! }"#;
//! let case = case::from_str("small", text, &[])?;
//! let run = run::run(&case, Options::default(), &AtomicBool::new(false), &mut ())?;
//! assert!(run.energy_error < 1e-9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// What only the commands and their studies use is not used where they are left out.
#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports, reason = "used by the commands and their studies"))]

pub mod case;
pub mod output;
pub mod run;

pub use case::{BuiltInFabric, Case, CaseBuilder, CaseError, Edge};
pub use gpu::{Adapter, Device, DeviceError, adapters};
pub use run::frame::{Frame, FrameCollector};
pub use run::{Observer, Options, Outcome, Run, RunError, Sample};

// Public for the program, the tests and the benchmarks of this crate alone, which are crates of their own. Not covered by
// semantic versioning: any of it may change or go with any release.
#[cfg(feature = "gpu")]
#[doc(hidden)]
pub mod gpu;
#[cfg(not(feature = "gpu"))]
#[doc(hidden)]
#[path = "gpu/absent.rs"]
pub mod gpu;
#[doc(hidden)]
pub mod kernels;
// Tables of the documentation. The one file outside the rooms: every room may print such a table, and it uses none.
#[doc(hidden)]
pub mod markdown;
#[doc(hidden)]
pub mod math;
#[doc(hidden)]
pub mod model;
#[doc(hidden)]
pub mod solver;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod study;
