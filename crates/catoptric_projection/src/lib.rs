//! Methods that find where scene points appear, and draw moved geometry there.

pub mod auto;
pub mod draw;
pub mod explosion_map;
pub mod find;
pub mod measure;
pub mod multiperspective;
pub mod path_perturbation;
pub mod planar_mirror;
pub mod reflector_search;
pub mod sample_based_camera;
mod virtual_object_method;

/// Parts for the tests of single parts only: they may change at any time.
#[doc(hidden)]
pub mod parts {
    pub use crate::draw::flat_mirrors::Mirrors;
    pub use crate::draw::multiperspective::bundles::beam::{Beam, CandidateList};
    pub use crate::draw::multiperspective::bundles::bundle::{BundleFit, RayBundle, TileRay};
    pub use crate::draw::multiperspective::bundles::coverage::{
        DrawnTriangle, NOTHING, ROOT, RayModel, TileArea, TileSamples,
    };
    pub use crate::draw::multiperspective::bundles::edges::EdgeFunctions;
    pub use crate::draw::multiperspective::bundles::least_squares::TERMS;
    pub use crate::draw::multiperspective::bundles::model::{PixelLines, Quadratic, value_at};
    pub use crate::draw::virtual_mesh::points::spread_order;
    pub use crate::draw::virtual_mesh::{
        MAX_APPEARANCES, Steadiness, SteadyField, SteadyMeshes, SteadyPath, SteadySource, virtual_mesh,
    };
    pub use crate::draw::virtual_scene::rigid_motion::rigid_motion;
    pub use crate::draw::work_limit::in_steps;
    pub use crate::explosion_map::cell_tree::{CellLeaf, NEAR, gather};
    pub use crate::explosion_map::profile::SegmentBlock;
    pub use crate::find::node_sightings::{MOST_NODES, NodeSightings, Sighting};
    pub use crate::find::tetrahedron_form::{FormBlock, FormWeights, PlaceAndLength, TetrahedronForm};
    pub use crate::find::virtual_objects::mesh::facets::normal_errors;
    pub use crate::find::virtual_objects::path_tree::{PathLimits, PathTree};
    pub use crate::find::virtual_objects::rays::{focal_points, seen_through};
    pub use crate::find::virtual_objects::{
        CORNERS, Locator, ReflectionPoint, ReflectionPoints, Reflector, ReflectorMesh, VertexRays, in_front,
        interpolated, outer, weights_of,
    };
    pub use crate::measure::round_trip::Answers;
    pub use crate::planar_mirror::path_search::MirrorSearch;
    pub use crate::reflector_search::image::ReflectorImage;
    pub use crate::reflector_search::image::cube::{CubeFaces, ImagePlace};
    pub use crate::reflector_search::locator::ReflectorSearch;
    pub use crate::sample_based_camera::layout::words::{WordReader, WordWriter};
    pub use crate::sample_based_camera::morph::bake::NodeTable;
    pub use crate::sample_based_camera::morph::grid::{NodeGrid, Tetrahedron};
    pub use crate::sample_based_camera::morph::node_key::NodeKey;
    pub use crate::sample_based_camera::morph::places::may_hide;
    pub use crate::sample_based_camera::morph::sightings::around_eye::AroundEye;
    pub use crate::sample_based_camera::morph::sightings::between::half_way;
    pub use crate::sample_based_camera::morph::sightings::cache::PointCache;
    pub use crate::sample_based_camera::morph::sightings::field::SightingField;
    pub use crate::sample_based_camera::morph::sightings::lookout::Sightings;
    pub use crate::sample_based_camera::rays::primary_visibility::{PrimaryVisibility, VisibilityRow, polygon};
    pub use crate::sample_based_camera::settings::node_counts;

    /// Faces of a cube of pictures about a point.
    pub mod cube {
        pub use crate::sample_based_camera::panorama::cube::{FACES, beyond, owner, shows, view};
    }

    /// Cells of directions from which searches start.
    pub mod starts {
        pub use crate::reflector_search::locator::starts::{SIDE, around, cell_of, middle_of};
    }

    /// Counted work.
    pub mod work {
        pub use crate::find::work::{SharedWork, add, done, since};
    }
}
