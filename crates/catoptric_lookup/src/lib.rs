//! Methods that look up the radiance of reflected rays.

pub mod environment_map;
pub mod layered_environment_map;
pub mod light_field;
mod shared;

/// Parts for the tests of single parts only: they may change at any time.
#[doc(hidden)]
pub mod parts {
    pub use crate::layered_environment_map::bake::stored::{face_texels, shells_of_bytes, shells_to_bytes, texels_of};
    pub use crate::layered_environment_map::bake::table::{LayersBatch, UnitTable};
    pub use crate::layered_environment_map::inference::direct::Missing;
    pub use crate::layered_environment_map::inference::least_squares::{Equations, Residual, Stop, solve};
    pub use crate::layered_environment_map::inference::observations::{
        Observation, Observations, Observer, confidence,
    };
    pub use crate::layered_environment_map::inference::{HIDDEN_WEIGHT, Inference, STOP, equations};
    pub use crate::layered_environment_map::mesh::welds::Welds;
    pub use crate::layered_environment_map::mesh::{AdaptiveMesh, Criteria, PatchLeaf, drawn};
    pub use crate::layered_environment_map::shell::{Quad, RayLanes, Shell};
    pub use crate::layered_environment_map::shells::group_layers::GroupLayers;
    pub use crate::layered_environment_map::shells::groups::LensGroup;
    pub use crate::layered_environment_map::shells::layer_geometry::{LayerGeometry, PartShells};
    pub use crate::layered_environment_map::shells::layers::{LayerHit, LayerSpec, clusters, strata};
    pub use crate::layered_environment_map::shells::merging::merged_by_shape;
    pub use crate::layered_environment_map::shells::viewpoints::{Viewspace, picture_of};
    pub use crate::layered_environment_map::texels::{Footprints, InTexels, TexelLayout, TexelTaps};
    pub use crate::layered_environment_map::textures::bounds::{DepthBounds, Range};
    pub use crate::layered_environment_map::textures::depths::{Depth, Depths};
    pub use crate::layered_environment_map::textures::distances::{Distances, HitLanes};
    pub use crate::layered_environment_map::textures::maps::{Layer, radiance};
    pub use crate::layered_environment_map::textures::texture::{LayerTexel, LayerTexture};
    pub use crate::light_field::layout::FieldLayout;
    pub use crate::light_field::layout::region_box::{BoxLayout, BoxRay, BoxSide};
    pub use crate::light_field::layout::slabs::{SLABS, Slab, SlabLayout, SlabRays, across, along};
    pub use crate::light_field::slabs::form::{RowView, ViewForm};
    pub use crate::light_field::slabs::rows::{Rows, ViewRow};
    pub use crate::light_field::slabs::texels::{
        LARGEST, MAX_PARALLAX, ViewLevels, packed, restored, stored, unpacked,
    };
    pub use crate::light_field::transfer::{Leaving, RayTransfer};
    pub use crate::shared::regions::{MAX_REGIONS, Regions, few, merged};

    /// Directions of a half space as places on a square.
    pub mod hemi_octahedron {
        pub use crate::light_field::layout::hemi_octahedron::{direction, place};
    }

    /// Blocks of compressed light.
    pub mod blocks {
        pub use crate::light_field::slabs::blocks::{BRIGHTEST, bits8, byte_count, compress, decompress, from_bits8};
    }

    /// Blocks of compressed depths.
    pub mod depth_blocks {
        pub use crate::light_field::slabs::depth_blocks::{at, byte_count, compress};
    }
}
