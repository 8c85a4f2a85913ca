//! Light along rays: hierarchies, tracers, maps of light, and stand-ins for surroundings.

mod cube_map;
mod parallax_proxy;
mod path_tracer;
mod tracer;
mod two_path_tracer;
mod wide_hierarchy;
