//! The methods of the projection family and their shared parts, against closed forms, the reference and round trips.

mod drawing;
mod exact_search;
mod explosion_map;
mod extrusions;
mod faithful;
mod far_objects;
mod handed_over;
mod path_perturbation;
mod planar_mirror;
mod reflector_search;
mod sample_based_camera;
mod surfaces;
mod tiles;
mod unit;
mod virtual_objects;
