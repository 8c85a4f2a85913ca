//! Errors of input and environment; a bug panics instead, an expected numerical miss is a counted value.

pub use catoptric_core::error::{SceneError, did_you_mean};
use catoptric_core::progress::Cancelled;

/// A picture that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// No method has this id.
    #[error("there is no method `{id}`{hint}; the methods are: {known}")]
    UnknownMethod {
        /// The id asked for.
        id: String,
        /// The id that was probably meant, as [`did_you_mean`] says it.
        hint: String,
        /// The ids that exist.
        known: String,
    },
    /// A setting of a method is unknown or has a value that is not allowed.
    #[error("method `{method}`: {problem}")]
    Setting {
        /// The method's id.
        method: &'static str,
        /// The fault, and which settings or values there are.
        problem: String,
    },
    /// The number of samples a pixel is not one that the rasteriser can take.
    #[error("samples = {samples}: methods that rasterise take 1, 2, 4, 8 and 16 samples a pixel")]
    Samples {
        /// The number asked for.
        samples: u32,
    },
    /// The picture asked for is outside what the method can draw.
    #[error("method `{method}` cannot do this: {problem}")]
    Limit {
        /// The method's id.
        method: &'static str,
        /// Which limit is passed and what is allowed.
        problem: String,
    },
    /// The caller cancelled the work.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
