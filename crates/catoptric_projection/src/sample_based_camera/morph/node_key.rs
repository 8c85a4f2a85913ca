//! Nodes by their reflectors and places, and the settings of their cameras.

use crate::sample_based_camera::panorama::PanoramaSettings;
use crate::sample_based_camera::settings::{Blend, SampleBasedCameraSettings, node_counts};
use catoptric_engine::error::RenderError;
use catoptric_engine::method::Settings;
use glam::{UVec3, Vec3};

/// Work for the rays of a face that are traced between those of its map: the building of a node takes about as long
/// again. Chosen, not measured.
const FACE_WORK: u64 = 2_000_000;

/// The accuracy of a node's cameras in a single mirror, in pixels: they only tell where the solver starts. A pixel is
/// enough, takes a twelfth of the bytes of a tenth of a pixel on `two_spheres`, and leads to the same appearances.
const MIRROR_ACCURACY_PX: f32 = 1.0;

/// A node: of which reflector's grid, and where in it; the highest order of its paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct NodeKey {
    /// The object around which the grid lies.
    pub reflector: u32,
    /// The place in the grid.
    pub node: UVec3,
    /// The highest order.
    pub order: u32,
}

/// A node that a view needs, and its place when the grids were laid out.
pub(super) type WantedNode = (NodeKey, Vec3);

/// The settings of a node's cameras, by those of all nodes.
pub(super) fn of_node(all: &PanoramaSettings, NodeKey { reflector, order, .. }: NodeKey) -> PanoramaSettings {
    PanoramaSettings { order, first: Some(vec![reflector]), ..all.clone() }
}

/// Nodes along each axis of a grid.
///
/// # Errors
/// [`RenderError::Setting`] for a grid that is none.
pub(super) fn counts_of(settings: &SampleBasedCameraSettings) -> Result<UVec3, RenderError> {
    let wrong = |problem| RenderError::Setting { method: SampleBasedCameraSettings::METHOD, problem };
    node_counts(&settings.grid).map_err(wrong)
}

/// The settings of the cameras at nodes.
pub(super) fn cameras_of(settings: &SampleBasedCameraSettings) -> PanoramaSettings {
    let SampleBasedCameraSettings { downsampling, camera, accuracy_px, max_shared, finest_ray_px, .. } = *settings;
    let size_px = settings.node_size;
    let polish = 0;
    let of_mirror = match settings.blend {
        Blend::Solved => accuracy_px.max(MIRROR_ACCURACY_PX),
        Blend::Mean => accuracy_px,
    };
    let [accuracy_px, mirror_accuracy_px] = [accuracy_px, of_mirror].map(|accuracy| accuracy.min(downsampling as f32));
    PanoramaSettings {
        size_px,
        downsampling,
        camera,
        accuracy_px,
        mirror_accuracy_px,
        max_shared,
        finest_ray_px,
        polish,
        work: FACE_WORK,
        ..PanoramaSettings::default()
    }
}
