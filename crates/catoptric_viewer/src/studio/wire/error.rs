//! The error of messages that cannot be read.

/// A message that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("a message between window and worker cannot be read: {0}")]
pub struct WireError(String);

impl WireError {
    pub(super) fn new(problem: String) -> Self {
        Self(problem)
    }
}
