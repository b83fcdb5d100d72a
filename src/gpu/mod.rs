//! The GPU backend: the same kernels in WGSL on wgpu, in single precision.
//!
//! - [`device`] chooses an adapter and opens it; [`buffers`] says what a run needs of it.
//! - [`shader`] holds the kernels and what each binds, [`layout`] the words they share with the host.
//! - [`stepper`] records the stages of a step, of many shots in one dispatch; [`submission`] sends steps off and reads back what they left;
//!   [`timing`] asks the device how long kernels take; the host loop is in [`run`](crate::run).
//!
//! A step is four dispatches: `element_force` | `node_update` | `projectile_points` | `projectile_contact`, and `ledger` after those
//! that the history takes note of. The barriers between them are needed because a node gathers the forces of elements
//! that other workgroups wrote; because contact is one solve over all touched nodes, whose velocities must be final; and
//! because elements read the positions contact has corrected. The search for points is a kernel of its own because one kernel may bind
//! eight buffers. Within a batch nothing is read back.

pub mod buffers;
mod common;
pub mod device;
mod error;
pub mod layout;
mod program;
pub mod shader;
pub mod stepper;
pub mod submission;
pub mod timing;
mod transfer;

pub use device::{Adapter, Device, adapters};
pub use error::DeviceError;
