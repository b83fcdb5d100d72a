//! Device of a build without the feature `gpu`: there is none, and opening one is an error.

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
