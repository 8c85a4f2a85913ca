//! The methods of the projection family and their shared parts, against closed forms, the reference and round trips.

mod auto;
mod drawing;
mod exact_search;
mod exact_search_round_trips;
mod explosion_map;
mod extrusions;
mod far_objects;
mod multiperspective;
mod panoramic_cameras;
mod path_perturbation;
mod planar_mirror;
mod reflector_search;
mod sample_based_camera;
mod virtual_objects;
