//! The beginning of the window: its scene, view and method.

use crate::studio::news::SceneSummary;
use crate::studio::order::{Opening, Source};
use catoptric::scene::{Camera, Projection};
use catoptric::tone::{Display, ToneCurve};
use glam::{DVec3, Vec3};
use std::path::PathBuf;

/// Choices that the window begins with.
#[derive(Clone, Debug)]
pub struct Start {
    /// The scene.
    pub source: Source,
    /// How it is opened.
    pub opening: Opening,
    /// The method on the left.
    pub method: String,
    /// Settings of the method on the left, over the scene's.
    pub settings: toml::Table,
    /// The method on the right, if the view is split.
    pub against: Option<String>,
    /// Samples a pixel.
    pub samples: u32,
    /// The highest number of reflections and refractions on a path; `None`: what the scene needs.
    pub order: Option<u32>,
    /// The view of the scene.
    pub view: FirstView,
    /// The panels beside the picture are shown.
    pub panels: bool,
    /// Bakes for methods that use them.
    pub bakes: Vec<PathBuf>,
    /// The file of the program `catoptric`, which makes reports and bakes; `None` if there is none.
    pub program: Option<PathBuf>,
}

/// The first view of the first scene; what is `None` is as the scene has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FirstView {
    /// A camera of the scene, by name or index.
    pub camera: Option<String>,
    /// An eye in place of a camera, in the coordinates of the scene's file.
    pub eye: Option<FirstEye>,
    /// The camera's vertical field of view in degrees.
    pub fov_deg: Option<f32>,
    /// Time in the animations, in seconds.
    pub time: f32,
    /// The animation that plays alone, by name or index.
    pub animation: Option<String>,
    /// The exposure.
    pub exposure: FirstExposure,
    /// The tone curve.
    pub curve: Option<ToneCurve>,
}

/// An eye that looks at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct FirstEye {
    /// The place of the eye, in the world.
    pub position: DVec3,
    /// The point; `None`: the middle of the scene.
    pub target: Option<DVec3>,
    /// The upward direction.
    pub up: Vec3,
    /// The vertical field of view in degrees.
    pub fov_deg: f32,
}

/// The exposure at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum FirstExposure {
    /// Chosen so that the scene is seen well.
    #[default]
    Fitting,
    /// Chosen so that it is of middle brightness.
    Automatic,
    /// This one, in stops.
    Stops(f32),
}

impl FirstView {
    /// The camera and its index among the scene's own; a remark where that is not the one that is wanted.
    pub(in crate::app) fn camera(&self, scene: &SceneSummary) -> (Option<Camera>, Option<usize>, Option<String>) {
        if let Some(FirstEye { position, target, up, fov_deg }) = &self.eye {
            let about_origin = |point: &DVec3| (*point - scene.origin).as_vec3();
            let target = target.as_ref().map_or(scene.bounds.center(), about_origin);
            return (Some(Camera::look_at("", about_origin(position), target, *up, *fov_deg)), None, None);
        }
        let names =
            |wanted: &String| scene.cameras.iter().position(|it| it.name == *wanted || it.other_name == *wanted);
        let found = self.camera.as_ref().and_then(|wanted| names(wanted).or_else(|| wanted.parse().ok()));
        let found = found.filter(|index| *index < scene.cameras.len());
        let mut remark = match (&self.camera, found) {
            (Some(wanted), None) => Some(format!("there is no camera `{wanted}`; shown is the first one")),
            _ => None,
        };
        let mut index = Some(found.unwrap_or(0));
        let mut camera = scene.cameras.get(found.unwrap_or(0)).cloned();
        match (self.fov_deg, camera.as_mut().map(|camera| &mut camera.projection)) {
            (Some(degrees), Some(Projection::Perspective { fov_y })) => {
                (*fov_y, index) = (degrees.to_radians(), None);
            }
            (Some(_), _) => remark = Some("an orthographic camera has no field of view: --fov is left out".into()),
            (None, _) => {}
        }
        (camera, index, remark)
    }

    /// The exposure and tone curve of a scene.
    pub(in crate::app) fn display(&self, scene: &SceneSummary) -> Display {
        let mut display = match self.exposure {
            FirstExposure::Fitting => scene.display,
            FirstExposure::Automatic => Display { exposure_stops: scene.automatic_stops, curve: ToneCurve::Neutral },
            FirstExposure::Stops(exposure_stops) => Display { exposure_stops, curve: ToneCurve::default() },
        };
        display.curve = self.curve.unwrap_or(display.curve);
        display
    }
}
