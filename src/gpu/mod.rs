//! GPU backend: the kernels in WGSL on wgpu, in single precision.
//!
//! - [`device`] chooses an adapter and opens it; [`buffers`] has the sizes of a run on it.
//! - [`shader`] lists the kernels and their bindings, [`layout`] the structs they share with the host.
//! - [`stepper`] records the stages of a step, of many shots in one dispatch; [`submission`] sends steps off and reads their results back.
//!   The host loop is in [`run`](crate::run).
//!
//! A step of one ply is two dispatches, `sweep` and `projectile_contact`, with four more between them in packs, and `energy_balance` after
//! those that are sampled. A workgroup of `sweep` advances a tile of 15 × 15 elements and nodes; what it needs of its neighbours it computes too, so that
//! forces never leave it. So that no workgroup reads what another one writes, nodes and elements lie in two slots by turns: a step reads what
//! the last one left, and writes the other slot. Dispatches end where all must wait: contact is one solve over all touched nodes, whose
//! velocities must be final, and elements read the positions that contact has corrected. Within a batch nothing is read back.

#[cfg(feature = "gpu")]
pub mod buffers;
#[cfg(feature = "gpu")]
pub mod device;
#[cfg(feature = "gpu")]
pub mod layout;
#[cfg(feature = "gpu")]
pub mod shader;
#[cfg(feature = "gpu")]
pub mod stepper;
#[cfg(feature = "gpu")]
pub mod submission;
#[cfg(feature = "gpu")]
mod transfer;

pub use device::{Adapter, Device, adapters};

use crate::case::CaseError;

/// Device of a build without the feature `gpu`: there is none, and opening one is an error.
#[cfg(not(feature = "gpu"))]
pub mod device {
    use super::DeviceError;

    /// A graphics processor: there is none.
    #[derive(Clone, Copy, Debug)]
    pub enum Adapter {}

    impl Adapter {
        /// Name.
        pub fn name(&self) -> &str {
            match *self {}
        }
    }

    /// Every adapter: none.
    pub fn adapters() -> Vec<Adapter> {
        Vec::new()
    }

    /// An open device: there is none.
    #[derive(Clone, Copy, Debug)]
    pub enum Device {}

    impl Device {
        /// Opens an adapter: there is none to open.
        ///
        /// # Errors
        /// Always.
        pub fn find(_wanted: Option<&str>) -> Result<Self, DeviceError> {
            Err(DeviceError::NotBuilt)
        }

        /// Opens an adapter.
        ///
        /// # Errors
        /// Never: there is no adapter.
        pub fn open(adapter: &Adapter) -> Result<Self, DeviceError> {
            match *adapter {}
        }

        /// Name of the adapter.
        pub fn name(&self) -> &str {
            match *self {}
        }
    }
}

/// Reason why no device computes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// This build has no graphics backend.
    #[error("this build of ripstop has no graphics backend; its feature `gpu` is off")]
    NotBuilt,
    /// No adapter at all.
    #[error("no graphics adapter was found")]
    NoAdapter,
    /// None of that name or number.
    #[error("no adapter is called or numbered {wanted}")]
    NoSuchAdapter {
        /// Name or number asked for.
        wanted: String,
        /// Names found.
        found: Vec<String>,
    },
    /// The adapter gave no device.
    #[error("{adapter} cannot be opened: {reason}")]
    Refused {
        /// Name.
        adapter: String,
        /// Words of the driver.
        reason: String,
    },
    /// The scene does not fit.
    #[error("{adapter} cannot hold the case: {buffer} needs {needed} bytes")]
    TooLarge {
        /// Name.
        adapter: String,
        /// The first buffer that does not fit.
        buffer: &'static str,
        /// Size [bytes].
        needed: u64,
        /// Largest size of a buffer [bytes].
        limit: u64,
        /// All buffers together [bytes].
        total: u64,
    },
    /// The device ran out of memory.
    #[error("{adapter} has not the {total} bytes of memory the case needs")]
    OutOfMemory {
        /// Name.
        adapter: String,
        /// All buffers together [bytes].
        total: u64,
        /// Words of the driver.
        reason: String,
    },
    /// More met the projectile in one step than the device has room for.
    #[error("{found} {what} meet in one step; {adapter} has room for {room}")]
    Crowded {
        /// Name.
        adapter: String,
        /// Nodes and the projectile, or points of its edge and a ply.
        what: &'static str,
        /// Number of them.
        found: u32,
        /// Room.
        room: u64,
    },
    /// The device was lost or a command failed.
    #[error("{adapter} failed: {reason}")]
    Lost {
        /// Name.
        adapter: String,
        /// Words of the driver.
        reason: String,
    },
}

impl DeviceError {
    /// Refusal of a device that was asked for, with what to do.
    #[doc(hidden)]
    pub fn refusal(&self) -> CaseError {
        let known = match self {
            Self::NoSuchAdapter { found, .. } => format!("; there are: {}", found.join(", ")),
            _ => String::new(),
        };
        let expected = "a graphics adapter with Vulkan, Metal or DirectX 12 that can compute this";
        let help = "take --backend cpu; `ripstop info CASE` lists adapters, and the memory that a case needs";
        CaseError::new("--backend gpu", "", expected, format!("{self}{known}"), help)
    }
}
