//! Parts of the methods one by one.

mod layered_environment_map;
mod light_field;
mod regions;
