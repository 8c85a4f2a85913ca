//! Virtual meshes: as a whole, while the eye moves, and the order of their points.

mod closed_forms;
mod points;
mod steady;
