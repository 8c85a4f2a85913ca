//! Sample-based cameras: trees of small cameras, fitted to a dense map of reflected rays, project scene points.
//!
//! See this folder's `README.md`.

mod at_eye;
mod cameras;
mod fitting;
mod hybrid;
pub(crate) mod layout;
mod leaves;
mod limits;
pub(crate) mod morph;
pub(crate) mod panorama;
mod project;
pub(crate) mod rays;
pub(crate) mod settings;

pub use morph::nodes_around;
pub use panorama::{PanoramaSettings, PanoramicCameras, PanoramicMirrors, PanoramicProjection, PanoramicProjector};
pub use rays::visible_pieces::{PiecesOfPixels, visible_pieces};
pub use settings::{Ambiguous, Blend, CameraKind, Mode, Preset, SampleBasedCameraSettings};

use crate::draw::prepared::ProjectionMethod;
use at_eye::SampleBasedCamera;
use catoptric_engine::method::{About, Family, MethodInfo, Settings};
use morph::{Morphing, NodesWork};

/// Description of the method.
pub static INFO: MethodInfo = MethodInfo {
    id: "sample_based_camera",
    family: Family::Projection,
    summary: "trees of small cameras, fitted to a dense map of reflected rays within an accuracy, \
        show where vertices appear",
    paper: "Popescu, Sacks, Mei 2006, Sample-based cameras for fast accurate reflections",
    assumptions: "reflections smaller than the spacing of the ray map can be missed",
    about: About {
        readme: include_str!("README.md"),
        draws: "every object as a virtual mesh in each mirror or lens that shows it; what takes too much work by tiles",
        costs: "a dense map of rays and its cameras for every view (mode=morph: kept at the nodes of a grid, which \
            can be baked); around caustics first pictures take seconds",
        cannot: "reflections smaller than the spacing of the map, and narrow parts of large triangles in corners of \
            flat mirrors, can be missed",
        useful: &["preset", "accuracy_px", "mode", "downsampling"],
    },
    cpu: true,
    gpu: true,
    bake: Some(|table, scene, quality| {
        Ok(Box::new(NodesWork::new(SampleBasedCameraSettings::from_table(table)?, scene, quality)?))
    }),
    settings: SampleBasedCameraSettings::describe,
    effective: SampleBasedCameraSettings::effective,
    limits: &limits::LIMITS,
    create: |table| {
        let settings = SampleBasedCameraSettings::from_table(table)?;
        Ok(match settings.mode {
            Mode::Runtime => Box::new(ProjectionMethod(SampleBasedCamera { info: &INFO, settings })),
            Mode::Morph => Box::new(ProjectionMethod(Morphing::new(&INFO, settings)?)),
        })
    },
};
