//! The drawing of paths by hardware: of what mirrors and glass show, where the path before shows these.

mod lists;
mod mirrors;
mod records;
mod virtual_mesh;

pub(crate) use lists::DeviceLists;
pub(crate) use mirrors::DeviceMirrors;
pub(crate) use virtual_mesh::{OnDevice, Search, VirtualCounts, VirtualTables};
