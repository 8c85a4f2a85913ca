//! Failures of devices, as methods report them.

use crate::error::GpuError;
use catoptric::error::RenderError;
use catoptric::methods::MethodInfo;

/// A failure of the device as that of a method.
pub(crate) fn failed(info: &'static MethodInfo, error: &GpuError) -> RenderError {
    RenderError::Limit { method: info.id, problem: error.to_string() }
}
