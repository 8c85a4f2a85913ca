//! Errors on built-in scenes. The registry's test prints the rows that are missing.

use catoptric_engine::method::limits::ErrorLimits;

/// The limits.
pub(super) static LIMITS: ErrorLimits = ErrorLimits { settings: "", scenes: &[] };
