//! The environment map's settings.

use catoptric_core::math::Aabb;
use catoptric_engine::method::reflector_maps::{MapSource, ProxyShape, ReflectorMapSettings};
use catoptric_engine::method::{declare_choices, declare_settings};

declare_choices! {
    /// The shape of the surround, by which a reflected ray becomes a direction of the map.
    pub enum Parallax {
        /// Infinitely far: the ray's direction is looked up.
        None = "none",
        /// A box.
        Box = "box",
        /// A sphere about the reflector.
        Sphere = "sphere",
    }
}

declare_choices! {
    /// The source of the map.
    pub enum Source {
        /// Captured from the scene at each reflector's centre.
        Capture = "capture",
        /// The scene's own environment; nearer things are not reflected.
        Environment = "environment",
    }
}

declare_settings! {
    /// Settings of the environment map.
    pub struct EnvironmentMapSettings of "environment_map" {
        /// The shape of the surround, by which a reflected ray becomes a direction of the map.
        parallax: Parallax = Parallax::None;
        /// The source of the map.
        source: Source = Source::Capture;
        /// Side of a face of the cube map.
        size: u32 = 512, range(4.0, 4096.0), unit("texels");
        /// Samples a texel when capturing.
        capture_samples: u32 = 4, one_of(&[1, 2, 4, 8, 16]);
        /// The smallest corner of the parallax box; with an empty box that of everything diffuse.
        box_min: [f32; 3] = [0.0; 3], unit("scene units");
        /// The largest corner of the parallax box.
        box_max: [f32; 3] = [0.0; 3], unit("scene units");
        /// Radius of the parallax sphere; 0: half the mean side of the box around everything diffuse.
        radius: f32 = 0.0, at_least(0.0), unit("scene units");
    }
}

impl From<&EnvironmentMapSettings> for ReflectorMapSettings {
    fn from(settings: &EnvironmentMapSettings) -> Self {
        let bounds = Aabb { min: settings.box_min.into(), max: settings.box_max.into() };
        Self {
            proxy: match settings.parallax {
                Parallax::None => ProxyShape::Infinite,
                Parallax::Box => ProxyShape::Box(Some(bounds).filter(|bounds| bounds.size().min_element() > 0.0)),
                Parallax::Sphere => ProxyShape::Sphere(Some(settings.radius).filter(|&radius| radius > 0.0)),
            },
            source: match settings.source {
                Source::Capture => MapSource::Capture,
                Source::Environment => MapSource::Background,
            },
            size: settings.size,
            capture_samples: settings.capture_samples,
        }
    }
}
