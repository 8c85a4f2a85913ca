//! Files of one mesh without materials: `.ply` and `.stl`.

mod model;
pub(super) mod ply;
mod polygons;
pub(super) mod stl;

pub(super) use model::{far_center, place};
pub(super) use polygons::PolygonDivider;
