//! Methods that find where scene points appear, and draw moved geometry there.

pub mod planar_mirror;
