//! Studies: a ballistic limit from many shots, fired at a range or computed.
//!
//! - [`outcomes`] counts what became of shots; [`link`](crate::num::link) is how the chance of a perforation grows with velocity.
//! - [`binary_response`] fits V50 and scatter, [`interval`] says how sure they are, [`arithmetic_v50`] is what standards ask for.
//! - [`residual_fit`] finds the limit from residual velocities.
//! - [`weibull`](crate::num::random) is for what varies between shots.
//! - [`batch`] computes many shots of a case; [`shots`] is `ripstop shots`, [`v50`] is `ripstop v50`, [`sweep`] runs either at many points.
//! - [`fit`] is `ripstop fit`: a table of shots in, all of that out.
//!
//! Velocities have the unit of the shots, but in [`fit`] and [`arithmetic_v50::RULES`], which are in m/s.

pub mod arithmetic_v50;
pub mod batch;
pub mod bench;
pub mod binary_response;
mod error;
pub mod fit;
pub mod interval;
pub mod outcomes;
mod page;
pub mod residual_fit;
mod search;
pub mod shots;
mod student_t;
pub mod sweep;
mod threads;
pub mod v50;
pub mod verify;

pub use error::StudyError;
