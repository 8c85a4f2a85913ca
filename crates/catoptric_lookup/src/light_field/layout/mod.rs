//! The coordinates of rays in a light field.

pub(crate) mod hemi_octahedron;
pub(crate) mod region_box;
pub(crate) mod slabs;

use super::settings::{Layout, LightFieldSettings};
use catoptric_core::math::Aabb;
pub(crate) use region_box::BoxLayout;
pub(crate) use slabs::{SLABS, STEEPEST, Slab, SlabLayout, SlabRays, across, along, bits};

/// The layout of the rays that leave a region, in rows of views.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldLayout {
    /// Two planes for each slab.
    Slabs(SlabLayout),
    /// The place where rays leave the region's box, and their direction.
    Box(BoxLayout),
}

impl FieldLayout {
    /// About a region with a size along all axes; the settings are allowed.
    pub fn new(settings: &LightFieldSettings, region: Aabb) -> Self {
        let LightFieldSettings { layout, st, uv, .. } = *settings;
        match layout {
            Layout::Slabs => Self::Slabs(SlabLayout::new(region, st, uv)),
            Layout::Box => Self::Box(BoxLayout::new(region, st, uv)),
        }
    }

    pub(crate) fn region(&self) -> &Aabb {
        match self {
            Self::Slabs(layout) => &layout.region,
            Self::Box(layout) => &layout.region,
        }
    }

    /// Pixels a side of a view.
    pub(crate) fn uv(&self) -> u32 {
        match self {
            Self::Slabs(layout) => layout.uv,
            Self::Box(layout) => layout.uv,
        }
    }

    /// Rows of views, of all slabs or sides.
    pub fn row_count(&self) -> usize {
        match self {
            Self::Slabs(layout) => SLABS * layout.st as usize,
            Self::Box(layout) => layout.row_count() as usize,
        }
    }

    /// Views in a row, which is one of the layout's.
    pub fn views_in_row(&self, row: usize) -> u32 {
        match self {
            Self::Slabs(layout) => layout.st,
            Self::Box(layout) => layout.sides[self.place_of_row(row).0].counts[0],
        }
    }

    /// The slab or side of a row, and the row's number there.
    pub(crate) fn place_of_row(&self, row: usize) -> (usize, u32) {
        match self {
            Self::Slabs(layout) => (row / layout.st as usize, (row % layout.st as usize) as u32),
            Self::Box(layout) => {
                let side = layout.sides.iter().rposition(|side| side.first_row as usize <= row).unwrap_or_default();
                (side, row as u32 - layout.sides[side].first_row)
            }
        }
    }

    /// Views of all rows.
    pub(crate) fn view_count(&self) -> u64 {
        match self {
            Self::Slabs(layout) => SLABS as u64 * u64::from(layout.st) * u64::from(layout.st),
            Self::Box(layout) => layout.view_count(),
        }
    }
}
