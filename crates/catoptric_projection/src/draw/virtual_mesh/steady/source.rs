//! Who finds out how points appear wherever the eye is, and where the eye is on a path.

use super::meshes::SteadyMeshes;
use crate::draw::virtual_mesh::picture_scale::PictureScale;
use crate::find::node_sightings::{MOST_NODES, NodeSightings};
use crate::find::tetrahedron_form::{FormWeights, TetrahedronForm};
use crate::find::work::SharedWork;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_core::scene::PreciseView;
use catoptric_engine::method::projector::Projection;
use glam::Vec3;

/// How a point appears wherever the eye is.
pub enum Steadiness {
    /// Once; with its appearance from the middle.
    Shown(TetrahedronForm, Projection),
    /// It appears nowhere.
    Nowhere,
    /// It may come and go, or appear several times; with what is known of its appearances from the middle.
    Unsteady(Vec<Projection>),
}

/// Who finds out how points appear.
pub trait SteadySource: Sync {
    /// Where the eye is on a path; `None` where nothing is known to be steady.
    fn on_path(&self, path: u32) -> Option<SteadyPath<'_>>;

    /// What is known of all places at once where an object's points lie densely; nothing if there is too much work.
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

    /// How a point appears on a path.
    fn steadiness(&self, at: &SteadyPath<'_>, point: Vec3) -> Steadiness;

    /// What the nodes see of a point that appears once, wherever the eye is.
    fn sightings(&self, at: &SteadyPath<'_>, point: Vec3) -> Option<NodeSightings>;

    /// The same of the point half-way between two such points; `None` where these do not tell.
    fn half_way(&self, at: &SteadyPath<'_>, ends: [(Vec3, &NodeSightings); 2]) -> Option<NodeSightings>;

    /// How a point appears of which the nodes see this.
    fn steadiness_of(&self, at: &SteadyPath<'_>, sightings: &NodeSightings) -> Steadiness;

    /// The appearance from the eye of a point that appears once, to the bit where its polynomial has it.
    fn seen(&self, at: &SteadyPath<'_>, sightings: &NodeSightings) -> Option<Projection>;
}

/// What the nodes see at places of a path, not only at single points.
pub trait SteadyField: Sync {
    /// What they see of a point; `None` where the field does not reach.
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
