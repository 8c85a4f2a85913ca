//! Places where scene points appear, as geometry that is drawn there.

use super::{{type}}Settings;
use catoptric_engine::error::RenderError;
use crate::draw::PathGeometry;
use catoptric_core::progress::Progress;
use catoptric_core::scene::{Scene, View};

/// Flat arrays that scene points are projected by.
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

    /// None, until they are the scene's triangles where a view shows them by specular paths of up to `order` bounces.
    pub(super) fn paths(&self, scene: &Scene, view: &View, order: u32) -> Vec<PathGeometry> {
        let _ = (self.size, scene, view, order);
        Vec::new()
    }
}
