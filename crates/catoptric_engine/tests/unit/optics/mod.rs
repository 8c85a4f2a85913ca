//! Reflection and refraction, and specular paths.

mod path;
mod step;
