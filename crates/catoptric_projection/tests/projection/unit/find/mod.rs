//! Paths, ray maps, virtual objects, and forms over a tetrahedron.

mod path_visibility;
mod projected_paths;
mod ray_map;
mod tetrahedron_form;
mod virtual_objects;
