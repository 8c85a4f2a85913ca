//! Scenes in a device's memory.

mod moving;
mod pictures;
mod resident;
mod upload;

pub(crate) use resident::{DeviceScene, FRAME_STRIDE, MAX_BANDS};
pub(crate) use upload::{Upload, size_in_rows};
