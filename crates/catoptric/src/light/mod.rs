//! Light along rays: the hierarchy over a scene, the first hit in it, specular paths and the radiance at their ends.

pub mod bodies;
pub(crate) mod bumps;
pub(crate) mod cube_map;
mod light_through;
pub(crate) mod parallax_proxy;
pub mod path_tracer;
pub mod radiance_field;
pub(crate) mod reflector_shader;
mod sides;
pub mod tracer;
pub(crate) mod two_path_tracer;
pub mod visibility;
pub(crate) mod wide_hierarchy;
