//! Layered environment maps about groups of reflectors, as tables.

use crate::error::GpuError;
use crate::layout::{Layer, LayerGroup, MAX_VIEWPOINTS, NONE};
use catoptric::methods::lookup::environment_map::ParallaxProxy;
use catoptric::methods::lookup::layered_environment_map::{LayerTables, ShellShape, ViewpointLayers};

/// More than any share of a shell.
const FAR: f32 = 3e38;

/// The layers of a view as shaders read them.
#[derive(Clone, Debug, Default)]
pub struct LayerMaps {
    /// The groups; their first layers count from the first of `layers`, until [`Self::table`] puts them together.
    pub groups: Vec<LayerGroup>,
    /// The layers of all groups.
    pub layers: Vec<Layer>,
    /// Four half floats each.
    pub texels: Vec<[u16; 4]>,
    /// Depths, and bounds of depths.
    pub words: Vec<u32>,
}

/// The tables of the layers that groups look up in a view; `roots` are those of the hierarchies over the groups.
///
/// # Errors
/// [`GpuError::Limit`] for more texels than 32 bits count.
pub fn layer_maps(groups: &[Vec<ViewpointLayers<'_>>], roots: &[u32]) -> Result<LayerMaps, GpuError> {
    let mut maps = LayerMaps::default();
    for (viewpoints, root) in groups.iter().zip(roots) {
        let viewpoints = &viewpoints[..viewpoints.len().min(MAX_VIEWPOINTS)];
        let first_layer = maps.layers.len() as u32;
        let first = viewpoints.first().map(|viewpoint| viewpoint.layers().collect::<Vec<_>>()).unwrap_or_default();
        for (number, layer) in first.iter().enumerate() {
            let mut record = record(layer, &mut maps.words);
            for (texels, viewpoint) in record.first_texels.iter_mut().zip(viewpoints) {
                *texels = u32::try_from(maps.texels.len()).map_err(|_| too_many())?;
                // All viewpoints have the same shells, and textures of one size.
                maps.texels.extend(viewpoint.layers().nth(number).into_iter().flat_map(|layer| layer.texels()));
            }
            maps.layers.push(record);
        }
        let mut shares = [0.0; MAX_VIEWPOINTS];
        shares.iter_mut().zip(viewpoints).for_each(|(share, viewpoint)| *share = viewpoint.share);
        let (layers, viewpoints) = (first.len() as u32, viewpoints.len() as u32);
        maps.groups.push(LayerGroup { root: *root, first_layer, layers, viewpoints, shares });
    }
    Ok(maps)
}

impl LayerMaps {
    /// Groups and layers in one table, with other shares of viewpoints.
    pub fn table(&self, shares: &[Vec<f32>]) -> Vec<[u32; 4]> {
        let texels_a_group = (size_of::<LayerGroup>() / 16) as u32;
        let texels_a_layer = (size_of::<Layer>() / 16) as u32;
        let behind = self.groups.len() as u32 * texels_a_group;
        let mut groups = self.groups.clone();
        for (group, shares) in groups.iter_mut().zip(shares) {
            group.first_layer = behind + group.first_layer * texels_a_layer;
            group.shares.iter_mut().zip(shares).for_each(|(share, of_view)| *share = *of_view);
        }
        let mut table: Vec<[u32; 4]> = bytemuck::cast_slice(&groups).to_vec();
        table.extend_from_slice(bytemuck::cast_slice(&self.layers));
        table
    }
}

fn too_many() -> GpuError {
    GpuError::Limit {
        what: "the textures of layers".into(),
        needed: "more texels".into(),
        allowed: "2^32".into(),
        remedy: "use smaller ones (`size`) or fewer layers",
    }
}

/// A layer's record; its depths are appended to words.
fn record(layer: &LayerTables<'_>, words: &mut Vec<u32>) -> Layer {
    let mut record = Layer {
        center: layer.center().to_array(),
        size: layer.size(),
        faces: layer.faces(),
        first_bound: NONE,
        ..Layer::default()
    };
    match layer.shape() {
        ShellShape::Around(ParallaxProxy::Infinite) => {}
        ShellShape::Around(ParallaxProxy::Box(bounds)) => {
            (record.shape, record.low, record.high) = (1, bounds.min.to_array(), bounds.max.to_array());
        }
        ShellShape::Around(ParallaxProxy::Sphere(radius)) => (record.shape, record.low[0]) = (2, radius),
        ShellShape::Around(ParallaxProxy::Cylinder { radius, bottom, top }) => {
            (record.shape, record.low) = (3, [radius, bottom, top]);
        }
        ShellShape::Quad { middle, normal, right, up } => {
            (record.shape, record.low, record.high) = (4, middle.to_array(), normal.to_array());
            let over_square = |side: glam::Vec3| (side / side.length_squared()).to_array();
            (record.right, record.up) = (over_square(right), over_square(up));
        }
    }
    if let Some(depths) = layer.depths() {
        record.has_depths = 1;
        // Nothing at all is shown: from infinity to 0.
        [record.least, record.most] = depths.range.map(|share| share.min(FAR));
        (record.first_depth, record.depth_base, record.depth_shift) = (words.len() as u32, depths.base, depths.shift);
        words.extend_from_slice(depths.words);
        if depths.bound_levels > 0 {
            (record.first_bound, record.bound_levels) = (words.len() as u32, depths.bound_levels);
            words.extend(depths.bounds().flatten().map(|share| share.min(FAR).to_bits()));
        }
    }
    record
}
