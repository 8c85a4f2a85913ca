//! The trait of projectors that find how points appear wherever the eye is, and where the eye is on a path.

use super::meshes::SteadyMeshes;
use crate::draw::virtual_mesh::picture_scale::PictureScale;
use crate::find::node_sightings::{MOST_NODES, NodeSightings};
use crate::find::tetrahedron_form::{FormWeights, TetrahedronForm};
use crate::find::work::SharedWork;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_core::scene::PreciseView;
use catoptric_engine::method::projector::Projection;
use glam::Vec3;

/// How a point appears while the eye moves among its nodes.
pub enum Steadiness {
    /// Once; with its appearance from the middle.
    Shown(TetrahedronForm, Projection),
    /// The point does not appear.
    Nowhere,
    /// The point may come and go, or appear several times; with the known appearances from the middle.
    Unsteady(Vec<Projection>),
}

/// A source of the appearances of points that stay the same while the eye moves among its nodes.
pub trait SteadySource: Sync {
    /// The eye among the nodes of a path; `None` where nothing is known to be steady.
    fn on_path(&self, path: u32) -> Option<SteadyPath<'_>>;

    /// The sightings for all places at once where an object's points lie densely; `None` if that takes too much work.
    ///
    /// # Errors
    /// [`Cancelled`].
    fn field(
        &self,
        at: &SteadyPath<'_>,
        points: &[Vec3],
        work: &SharedWork,
        stage: &Stage<'_>,
    ) -> Result<Option<Box<dyn SteadyField>>, Cancelled>;

    /// Finds how a point appears on a path.
    fn steadiness(&self, at: &SteadyPath<'_>, point: Vec3) -> Steadiness;

    /// The nodes' sightings of a point that appears exactly once, wherever the eye is.
    fn sightings(&self, at: &SteadyPath<'_>, point: Vec3) -> Option<NodeSightings>;

    /// The nodes' sightings of the point half-way between two such points; `None` where these two do not determine
    /// them.
    fn half_way(&self, at: &SteadyPath<'_>, ends: [(Vec3, &NodeSightings); 2]) -> Option<NodeSightings>;

    /// Finds how a point appears from the nodes' sightings of it.
    fn steadiness_of(&self, at: &SteadyPath<'_>, sightings: &NodeSightings) -> Steadiness;

    /// The appearance from the eye of a point that appears once, to the bit where its polynomial has it.
    fn seen(&self, at: &SteadyPath<'_>, sightings: &NodeSightings) -> Option<Projection>;
}

/// The nodes' sightings as a function of the place, on one path.
pub trait SteadyField: Sync {
    /// The sightings of a point; `None` where the field does not reach.
    fn sightings(&self, point: Vec3) -> Option<NodeSightings>;
}

/// A path while the eye stays among some nodes.
pub struct SteadyPath<'a> {
    /// The path's number now.
    pub path: u32,
    /// Meshes that were made while the eye did.
    pub meshes: &'a SteadyMeshes,
    /// The path's number there.
    pub kept_path: u32,
    /// A place in the middle of the nodes.
    pub middle: Vec3,
    /// A picture from there that holds all of the mirror.
    pub view_from_middle: PreciseView,
    /// The scale of that picture.
    pub scale_from_middle: PictureScale,
    /// The nodes.
    pub nodes: [Vec3; MOST_NODES],
    /// The middle and the size of the mirror.
    pub mirror: (Vec3, f32),
    /// The eye's place among the nodes.
    pub weights: FormWeights,
    /// The picture that the eye sees.
    pub view: PreciseView,
    /// The scale of that picture.
    pub scale: PictureScale,
}
