//! Appearances of scene points: path searches, ray maps and virtual objects, shared by the methods of the family, and
//! the counting of their work.

pub mod exact_search;
pub(super) mod lens_check;
pub(super) mod node_sightings;
pub mod path_visibility;
pub(super) mod polish;
pub mod projected_paths;
pub mod ray_map;
pub(super) mod tetrahedron_form;
pub(super) mod virtual_objects;
pub(super) mod work;
