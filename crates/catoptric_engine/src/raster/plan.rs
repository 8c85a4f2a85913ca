//! The order of a call's drawing: layers, their pieces of work, and the labels of their stencils.

use super::attributes::{barycentrics, in_source};
use super::bin::ListPart;
use super::fragment::LayerSurface;
use super::ids::FOUND;
use super::lists::{Branch, DrawList, DrawTriangle};
use crate::error::RenderError;
use catoptric_core::scene::PicturePoint;
use glam::Vec2;
use std::ops::Range;

/// The most layers of a picture.
const MAX_LAYERS: u32 = 64;

/// Properties of a list beside its geometry.
#[derive(Clone, Copy, Debug)]
pub(super) struct ListPlan {
    /// The id of its first triangle; ids go on through all lists.
    first_id: u32,
    /// The label of those samples of the layer below where it may be drawn; 0 in layer 0.
    pub(super) label: u32,
    /// True if the list shows the second branch of light.
    pub(super) second: bool,
    /// True if any of the list's triangles is alpha-tested.
    pub(super) alpha_tested: bool,
}

/// A layer of the picture.
#[derive(Clone, Debug, Default)]
pub(super) struct LayerPlan {
    /// The layer's pieces, in drawing order.
    pub(super) pieces: Range<usize>,
    /// The surfaces its stencils name, sorted: list and group. The label of an entry is its place, plus 1.
    stencils: Vec<(u32, u32)>,
    /// For every stencil, true if a list lies in its second branch; empty: no list does.
    divided: Vec<bool>,
    /// The lists that leave out blocks of the picture.
    holed_lists: Vec<u32>,
}

impl LayerPlan {
    /// The label of samples that show a triangle of this list and group; 0 if no stencil names them.
    pub(super) fn label(&self, list: u32, group: u32) -> u32 {
        self.stencils.binary_search(&(list, group)).map_or(0, |place| place as u32 + 1)
    }

    /// True if a list leaves out any blocks.
    pub(super) fn has_holes(&self) -> bool {
        !self.holed_lists.is_empty()
    }

    /// Returns true if light divides at the surfaces of a label.
    pub(super) fn divides(&self, label: u32) -> bool {
        label != 0 && self.divided.get(label as usize - 1).copied().unwrap_or(false)
    }
}

/// The work of a call.
#[derive(Debug)]
pub(super) struct Plan<'a> {
    pub(super) lists: &'a [DrawList],
    pub(super) list_plans: Vec<ListPlan>,
    pub(super) layers: Vec<LayerPlan>,
    pub(super) pieces: Vec<ListPart>,
}

impl<'a> Plan<'a> {
    /// True if the list of a layer's label and branch leaves out a block of the picture.
    pub(super) fn has_hole(&self, layer: &LayerPlan, (label, second): (u32, bool), [column, row]: [usize; 2]) -> bool {
        layer.holed_lists.iter().any(|&list| {
            let plan = &self.list_plans[list as usize];
            (plan.label, plan.second) == (label, second) && self.lists[list as usize].holes.has(column, row)
        })
    }

    /// `piece_size` is the number of triangles that are worked on at once; results do not depend on it.
    pub(super) fn new(lists: &'a [DrawList], piece_size: u32) -> Result<Self, RenderError> {
        let limit = |problem: String| RenderError::Limit { method: "raster", problem };
        let mut layers =
            vec![LayerPlan::default(); lists.iter().map(|list| list.layer as usize + 1).max().unwrap_or(0)];
        let mut list_plans = Vec::with_capacity(lists.len());
        let mut ids = 0u64;
        for (index, list) in lists.iter().enumerate() {
            if list.layer >= MAX_LAYERS {
                let layer = list.layer;
                return Err(limit(format!("list {index} is in layer {layer}; the last layer is {}", MAX_LAYERS - 1)));
            }
            match list.stencil {
                None if list.layer > 0 => {
                    let problem = "a list above layer 0 needs a stencil that says where it is seen";
                    return Err(limit(format!("list {index}: {problem}")));
                }
                Some(_) if list.layer == 0 => {
                    return Err(limit(format!("list {index}: a stencil needs a layer below; layer 0 has none")));
                }
                Some(stencil) => {
                    let below = lists.get(stencil.list as usize).map(|list| list.layer);
                    if below != Some(list.layer - 1) {
                        let problem = "its stencil must name a list of the layer below";
                        return Err(limit(format!("list {index}: {problem}")));
                    }
                    layers[list.layer as usize].stencils.push((stencil.list, stencil.group));
                }
                None => {}
            }
            let alpha_tested = list.triangles.iter().any(|triangle| triangle.alpha_tested);
            let second = list.stencil.is_some_and(|stencil| stencil.branch == Branch::Second);
            list_plans.push(ListPlan { first_id: ids as u32, label: 0, second, alpha_tested });
            ids += list.triangles.len() as u64;
        }
        if ids >= FOUND as u64 {
            return Err(limit(format!("{ids} triangles; a picture can have {}", FOUND - 1)));
        }
        for layer in &mut layers {
            layer.stencils.sort_unstable();
            layer.stencils.dedup();
        }
        for (list, plan) in lists.iter().zip(&mut list_plans) {
            if let Some(stencil) = list.stencil {
                let layer = &mut layers[list.layer as usize];
                plan.label = layer.label(stencil.list, stencil.group);
                if plan.second {
                    layer.divided.resize(layer.stencils.len(), false);
                    layer.divided[plan.label as usize - 1] = true;
                }
            }
        }
        for (index, list) in lists.iter().enumerate().filter(|(_, list)| !list.holes.is_empty()) {
            layers[list.layer as usize].holed_lists.push(index as u32);
        }
        let mut pieces = Vec::new();
        for (layer, plan) in layers.iter_mut().enumerate() {
            let start = pieces.len();
            for (index, list) in lists.iter().enumerate().filter(|(_, list)| list.layer as usize == layer) {
                let count = list.triangles.len() as u32;
                for first in (0..count).step_by(piece_size.max(1) as usize) {
                    let triangles = first..first.saturating_add(piece_size).min(count);
                    pieces.push(ListPart { list: index as u32, triangles, first_id: list_plans[index].first_id });
                }
            }
            plan.pieces = start..pieces.len();
        }
        Ok(Self { lists, list_plans, layers, pieces })
    }

    /// The list of a triangle, and the triangle.
    #[inline]
    pub(super) fn triangle(&self, id: u32) -> (u32, &DrawTriangle) {
        let list = if self.list_plans.len() == 1 {
            0
        } else {
            self.list_plans.partition_point(|plan| plan.first_id <= id) - 1
        };
        (list as u32, &self.lists[list].triangles[(id - self.list_plans[list].first_id) as usize])
    }

    /// Returns true if light divides at a triangle that shows in a layer.
    pub(super) fn divides(&self, layer: usize, id: u32) -> bool {
        let (list, triangle) = self.triangle(id);
        self.layers.get(layer + 1).is_some_and(|above| above.divides(above.label(list, triangle.group)))
    }

    /// The corners of a triangle of a list.
    #[inline]
    pub(super) fn corners(&self, list: u32, triangle: &DrawTriangle) -> [&PicturePoint; 3] {
        let vertices = &self.lists[list as usize].vertices;
        triangle.vertices.map(|vertex| &vertices[vertex as usize])
    }

    /// The places of a triangle's corners in its source; `None` if they are the source's own.
    #[inline]
    pub(super) fn corners_in_source(&self, list: u32, id: u32) -> Option<&[Vec2; 3]> {
        let list = list as usize;
        self.lists[list].corners.get((id - self.list_plans[list].first_id) as usize)
    }
}

/// A surface as passed to the shader at a position in the picture.
#[inline(always)] // for the instructions of its caller
pub(super) fn surface_at(plan: &Plan<'_>, id: u32, position: Vec2, leeway: f32) -> LayerSurface {
    let (list, triangle) = plan.triangle(id);
    let mut barycentrics = barycentrics(plan.corners(list, triangle), position, leeway);
    if let Some(corners) = plan.corners_in_source(list, id) {
        barycentrics = in_source(&barycentrics, corners);
    }
    LayerSurface { list, source: triangle.source, group: triangle.group, barycentrics }
}
