//! ripstop computes what happens when a projectile strikes woven fabric: Kevlar and its kin, one ply or a pack. It says whether the
//! projectile is stopped, how fast it leaves, where the energy went, and how far to trust the numbers.
//!
//! It is an explicit finite-element solver after Shahkarami & Vaziri (2006): one shell element per yarn crossover, a Newton solve for
//! the warp–weft interaction in every element, trellis shear with locking, yarn failure and erosion. It computes on the processor or
//! on a graphics processor. The program `ripstop` does the same from case files, and its book says what the numbers mean.
//!
//! # A shot
//!
//! ```
//! use ripstop::{BuiltInFabric, Case, Edge, FrameCollector, Options};
//!
//! let case = Case::builder("a small ply").fabric(BuiltInFabric::S720).size_mm(25.0, 25.0).edges(Edge::Clamped)
//!     .sphere_mm(6.0).mass_g(1.0).velocity_m_s(50.0).end_time_us(5.0).build()?;
//! let mut collector = FrameCollector::new(&case, 3);
//! let run = Options::default().observe(&case, &mut collector)?;
//! for row in &run.history {
//!     println!("{:4.1} µs  {:6.2} m/s", row.time * 1e6, row.projectile_velocity);
//! }
//! for frame in collector.frames() {
//!     println!("{:4.1} µs  {} nodes", frame.time * 1e6, frame.displacement.len());
//! }
//! println!("{}", run.outcome.word());
//! # assert!(run.energy_error < 1e-9 && run.history.len() > 5 && collector.frames().len() == 3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`Case::builder`] writes a case in Rust, [`case::read`] reads a file, [`case::from_str`] takes JSON. All go through the same checks.
//! - [`Case::run`] runs it. [`Options`] choose threads, precision and device; [`run::run`] also takes a flag that ends the run, and
//!   [`run::run_here`] runs it in a page of a browser (`web/`).
//! - [`Run`] has the history, the failures and the outcome. [`output::summary`] sums it up, [`output::checks`] judges it.
//! - An [`Observer`] follows a run. [`FrameCollector`] is one that keeps frames.
//! - [`output::Folder`] writes the files that the program writes.
//!
//! # Features
//!
//! All are on by default, but the last.
//!
//! | feature | what it adds | without it |
//! |---|---|---|
//! | `gpu` | runs on a graphics processor, by wgpu | [`Device::find`] is an error |
//! | `frames` | files of frames for ParaView: `output::frames::Recorder` | frames in memory stay |
//! | `report` | the page `report.html`: `output::report` | `shot.svg` stays |
//! | `cli` | the program `ripstop`, with its studies; needs the three above | a library alone |
//! | `quick-build` | nothing: kernels are compiled for fewer processors | |
//!
//! ```toml
//! ripstop = { version = "0.1", default-features = false, features = ["gpu"] }
//! ```
//!
//! Semantic versioning covers what this documentation shows. Other public items are for the program and the tests of this crate.
//!
//! # Architecture
//!
//! Ten rooms. Each uses those above it, never one below; a test holds that.
//!
//! ```text
//! num       numbers, several at once, sums in fixed order, random numbers, distributions
//! case      JSON, checked, in SI: what the user asks
//! physics   what a yarn, a crossover, an element and a point of contact do, without a mesh
//! model     what stays constant: plies, mesh, unit-cell constants, masses, critical step
//! solver    what varies, and one step of it on the processor: state, kernels and their order, contact, energy balance
//! gpu       the same step on a graphics processor
//! run       the host loop of both, outcome, history, frames, checkpoints
//! output    files: results, checks, plots, report, frames for ParaView
//! study     many runs: benchmark, sweeps, ballistic limits
//! cli       the commands, in the program alone
//! ```
//!
//! - Only [`case`] knows keys and textile units.
//! - `physics` and the kernels of `solver` are generic over `num::scalar::Real`. A shader has the name of its twin; tests hold both
//!   together.
//! - `solver` is the only place that knows the order of the kernels on the CPU, `gpu` on a graphics processor.
//!   State lies in rows (ply, row, column), each ply in its own axes; `solver::state::ActiveRegion` is what may have moved.
//! - [`run::run`] is the host loop. A [`run::Observer`] gets progress and [`run::frame`]s.
//!   `run::outcome` decides what became of the projectile.
//! - [`output::checks`] says what makes a result less certain than it looks.
//!
//! # What always holds
//!
//! - Physics and kernels never touch files, threads or devices; the model never sees a backend; only `gpu` knows wgpu.
//! - The step loop allocates no fields: only records (failures, contacts, history rows) and lists of the work that threads share.
//! - Sums run in fixed order: same case, same bits, whatever the number of threads.
//! - Of a scene that is its own mirror image a part is computed (`physics::rigid_body::MirrorPlanes`); the run makes results whole again.
//! - What nothing has reached is exactly at rest, to the last bit, and is left out.
//! - A number that is not finite, or energy that was never put in, stops the run with step, kernel and place.

// What only the commands and their studies use is not used where they are left out.
#![cfg_attr(not(feature = "cli"), allow(dead_code, unused_imports, reason = "used by the commands and their studies"))]

pub mod case;
pub mod output;
pub mod run;

/// The unit cell alone: tensions of warp and weft over their stretches.
pub mod unit_cell {
    pub use crate::model::unit_cell::{CurvePoint, solve};
}

pub use case::{BuiltInFabric, Case, CaseBuilder, CaseError, Edge};
pub use gpu::{Adapter, Device, DeviceError, adapters};
pub use run::frame::{Frame, FrameCollector};
pub use run::{Observer, Options, Outcome, Run, RunError, Sample};

// Public for the program, the tests and the benchmarks of this crate alone, which are crates of their own. Not covered by
// semantic versioning: any of it may change or vanish with any release.
#[doc(hidden)]
pub mod gpu;
#[doc(hidden)]
pub mod model;
#[doc(hidden)]
pub mod num {
    //! Numbers: what the kernels are generic over, several at once, sums in fixed order; random numbers, distributions, solids.

    pub mod random;
    pub mod scalar;
    pub mod simd;
    pub(crate) mod solid;
}
#[doc(hidden)]
pub mod physics {
    //! Point physics: what a yarn, a crossover, an element or a point of contact does, without a mesh.
    //!
    //! Generic over [`Real`](crate::num::scalar::Real), of numbers and constants alone: no files, threads or devices. A file has the name of its
    //! twin in `shaders/`.

    pub mod coupled_newton;
    pub mod crossover;
    pub mod kinematics;
    pub mod membrane;
    pub mod ply_contact;
    pub mod projectile_body;
    pub mod projectile_shape;
    pub mod rigid_body;
    pub mod unit_cell_parameters;
    pub mod viscous_force;
    pub mod yarn_law;
}
#[doc(hidden)]
pub mod solver;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod study;
