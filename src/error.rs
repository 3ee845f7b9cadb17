//! What can go wrong in the engine: each error carries the cause and the numbers.

use ash::vk;

/// An error of the engine or of the thin Vulkan layer below it.
#[derive(Debug, Clone, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The device, or the feature set of the caller, lacks something the engine needs.
    #[error("unsupported: {what}")]
    Unsupported {
        /// The missing feature, format or limit, in one phrase.
        what: String,
    },
    /// A value is outside what is allowed.
    #[error("{field} is {given}, allowed is {limit}")]
    Limit {
        /// Name of the configuration field or input.
        field: &'static str,
        /// The value that was given.
        given: String,
        /// What is allowed.
        limit: String,
    },
    /// The device has no memory left for this resource.
    #[error("out of device memory for {what} ({bytes} bytes)")]
    OutOfMemory {
        /// The resource that was to be made.
        what: String,
        /// Its size.
        bytes: u64,
    },
    /// A Vulkan call failed.
    #[error("{call} failed: {result}")]
    Vulkan {
        /// The call.
        call: &'static str,
        /// What it returned.
        result: vk::Result,
    },
}

/// Attaches the name of the call to a raw Vulkan result.
pub(crate) trait Context<T> {
    fn context(self, call: &'static str) -> Result<T, Error>;
}

impl<T> Context<T> for Result<T, vk::Result> {
    fn context(self, call: &'static str) -> Result<T, Error> {
        self.map_err(|result| Error::Vulkan { call, result })
    }
}
