//! Parts of the methods one by one.

mod draw;
mod explosion_map;
mod find;
mod planar_mirror;
mod reflector_search;
mod round_trip;
mod sample_based_camera;
