//! Radiance of reflected and refracted rays, looked up.

use super::{{type}}Settings;
use catoptric_engine::error::RenderError;
use catoptric_engine::light::reflector_shader::ReflectorShader;
use catoptric_core::progress::Progress;
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Ray, RayDifferential, Scene};
use glam::Vec3;

/// Flat arrays that rays are looked up in.
pub(super) struct {{type}}Tables {
    size: u32,
}

impl {{type}}Tables {
    /// The tables of a scene.
    pub(super) fn build(
        settings: &{{type}}Settings,
        _scene: &Scene,
        _progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        Ok(Self { size: settings.size })
    }
}

impl ReflectorShader for {{type}}Tables {
    /// Black, until it is the radiance of the ray that leaves `encounter`.
    fn radiance(&self, scene: &Scene, encounter: &SurfaceInteraction, ray: &Ray, change: &RayDifferential) -> Vec3 {
        let _ = (self.size, scene, encounter, ray, change);
        Vec3::ZERO
    }
}
