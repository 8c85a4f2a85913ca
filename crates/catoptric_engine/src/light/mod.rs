//! Light along rays: the hierarchy over a scene, the first hit in it, specular paths and the radiance at their ends.

pub mod bodies;
pub mod bumps;
pub mod cube_map;
pub mod first_surfaces;
mod light_through;
pub mod parallax_proxy;
pub mod path_tracer;
pub mod radiance_field;
pub mod reflector_shader;
mod sides;
pub mod tracer;
pub mod two_path_tracer;
pub mod visibility;
pub mod wide_hierarchy;
