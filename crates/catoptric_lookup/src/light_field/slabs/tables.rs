//! Slabs as plain tables: for other processors to look up.

use super::fetch::Fetch;
use super::rows::Rows;
use super::{Field, Slabs};
use crate::light_field::settings::Disparity;
use glam::Vec2;
use std::borrow::Cow;

/// The numbers of the slabs about a region.
///
/// Slabs are those of the directions +x, -x, +y, -y, +z, -z. Coordinates across an axis are the other two of x, y, z in
/// cyclic order: y and z across x, z and x across y.
#[derive(Clone, Copy, Debug)]
pub struct SlabTables<'a> {
    fetch: &'a Fetch,
    rows: &'a Rows,
}

/// The plane of a slab's views.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabPlane {
    /// The plane's coordinate along the slab's axis.
    pub plane: f32,
    /// The coordinates across the axis of the first view.
    pub low: Vec2,
    /// The steps from view to view.
    pub spacing: Vec2,
    /// The parallax of its focal plane: how far slopes change from view to view along the longer spacing.
    pub focal: f32,
}

impl Slabs {
    /// Their tables; `None` where rays are kept by the region's box (`layout = "box"`).
    pub fn tables(&self) -> Option<SlabTables<'_>> {
        match &self.field {
            Field::Slabs(fetch) => Some(SlabTables { fetch, rows: &self.rows }),
            Field::Box(_) => None,
        }
    }
}

impl<'a> SlabTables<'a> {
    /// Views a side of a slab.
    pub fn views(&self) -> u32 {
        self.fetch.layout.st
    }

    /// Pixels a side of a view. The middles of the outermost ones see the slopes -1.0625 and 1.0625.
    pub fn pixels(&self) -> u32 {
        self.fetch.layout.uv
    }

    /// True if each view finds the ray's surface by the parallax of its pixels; else the parallax is that of the focal
    /// planes.
    pub fn has_depth(&self) -> bool {
        self.fetch.disparity == Disparity::Depth
    }

    /// The planes of all slabs.
    pub fn planes(&self) -> [SlabPlane; 6] {
        self.fetch.layout.slabs.map(|slab| SlabPlane {
            plane: slab.plane,
            low: slab.low,
            spacing: slab.spacing,
            focal: slab.focal,
        })
    }

    /// The levels of a view: the first texel of each, from the finest, and its pixels a side.
    pub fn levels(&self) -> &'a [(u32, u32)] {
        &self.fetch.form.levels.levels
    }

    /// Texels of all levels of a view.
    pub fn texels_a_view(&self) -> u32 {
        self.fetch.form.levels.count
    }

    /// Radiance of a row of views, slab after slab: view after view, level after level, row after row; three mantissas
    /// of nine bits with one exponent (OpenGL's `RGB9_E5`). Views that are kept compressed are decompressed.
    pub fn radiance(&self, row: usize) -> Cow<'a, [u32]> {
        self.fetch.form.texels(&self.rows.row(row))
    }

    /// Parallax of the finest level of a row of views: 32,767 is 2. Compressed data is decompressed.
    pub fn parallax(&self, row: usize) -> Cow<'a, [i16]> {
        self.fetch.form.parallaxes(&self.rows.row(row))
    }
}
