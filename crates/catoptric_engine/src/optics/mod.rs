//! Reflection and refraction of light at a surface: directions, Fresnel factors, attenuation.

pub mod path;
pub mod step;

pub use step::{
    fresnel_dielectric, fresnel_schlick, reflect, reflected_change, refract, refracted_change, transmittance,
};
