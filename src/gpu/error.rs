//! What goes wrong with devices.

/// Why no device computes.
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
        /// What was asked for.
        wanted: String,
        /// What there is.
        found: Vec<String>,
    },
    /// The adapter gave no device.
    #[error("{adapter} cannot be opened: {reason}")]
    Refused {
        /// Name.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// The scene does not fit.
    #[error("{adapter} cannot hold the case: {buffer} needs {needed} bytes")]
    TooLarge {
        /// Name.
        adapter: String,
        /// The first buffer that does not fit.
        buffer: &'static str,
        /// Its size [bytes].
        needed: u64,
        /// What one buffer may have [bytes].
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
        /// What the driver said.
        reason: String,
    },
    /// More nodes met the projectile in one step than the device has room for.
    #[error("{found} nodes meet the projectile in one step; {adapter} has room for {room}")]
    Crowded {
        /// Name.
        adapter: String,
        /// Nodes.
        found: u32,
        /// Room.
        room: u64,
    },
    /// More points of the projectile's rim met a ply in one step than the device has room for.
    #[error("{found} points of the projectile's rim meet a ply in one step; {adapter} has room for {room}")]
    CrowdedRim {
        /// Name.
        adapter: String,
        /// Points of the rim.
        found: u32,
        /// Room.
        room: u64,
    },
    /// The device was lost or a command failed.
    #[error("{adapter} failed: {reason}")]
    Lost {
        /// Name.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
}
