//! Light fields about regions of reflectors, as tables and pictures.

use super::maps::{MapTables, map_tables};
use crate::error::GpuError;
use crate::hierarchy::Hierarchy;
use crate::layout::{FieldRegion, FieldSlab, NONE, ReflectorMap};
use catoptric::methods::lookup::light_field::{LightFields, SlabTables, Slabs};
use catoptric::scene::Scene;

/// Slabs of a region.
const SLABS: usize = 6;

/// A scene's light fields as shaders read them, beside the pictures of slabs.
#[derive(Clone, Debug)]
pub struct FieldTables {
    /// The environment maps of objects that lie in no region, and the regions of the others.
    pub maps: MapTables,
    /// The regions.
    pub regions: Vec<FieldRegion>,
    /// The scene's hierarchy, and behind it one a region whose paths are traced, over its reflectors and lenses.
    pub hierarchy: Hierarchy,
}

/// The tables of a scene's light fields; `traces`: paths are followed among a region's reflectors and lenses.
///
/// # Errors
/// As [`map_tables`] and [`slab_tables`].
pub fn field_tables(
    scene: &Scene,
    fields: &LightFields,
    traces: bool,
    whole: &Hierarchy,
) -> Result<FieldTables, GpuError> {
    let mut hierarchy = whole.clone();
    let mut maps = map_tables(fields.maps())?;
    maps.records.resize(scene.objects.len(), ReflectorMap::default());
    let region_of = fields.region_of();
    let mut regions = Vec::new();
    for (number, slabs) in fields.slabs().enumerate() {
        let tables = slab_tables(slabs)?;
        let is_inside = |object: u32| region_of[object as usize] == Some(number as u32);
        let root = if traces { hierarchy.append(Hierarchy::of(scene, is_inside)) } else { NONE };
        regions.push(FieldRegion {
            root,
            views: tables.views(),
            pixels: tables.pixels(),
            first_layer: (number * SLABS) as u32,
            has_depth: tables.has_depth().into(),
            by_one_event: (!traces).into(),
            unused: [0; 2],
            slabs: tables.planes().map(|slab| FieldSlab {
                low: slab.low.to_array(),
                plane: slab.plane,
                focal: slab.focal,
                spacing: slab.spacing.to_array(),
                unused: [0; 2],
            }),
        });
    }
    for (map, region) in maps.records.iter_mut().zip(region_of) {
        // There are few.
        map.shape += region.map_or(0, |region| (region + 1).min(255));
    }
    Ok(FieldTables { maps, regions, hierarchy })
}

/// The tables of the slabs about a region.
///
/// # Errors
/// [`GpuError::Unsupported`] where rays are kept by the region's box.
pub fn slab_tables(slabs: &Slabs) -> Result<SlabTables<'_>, GpuError> {
    let unsupported = || GpuError::Unsupported { what: "light fields of layout = \"box\"".into() };
    slabs.tables().ok_or_else(unsupported)
}

/// The sizes of slabs' pictures: those of radiance, and of parallax.
pub fn slab_sizes(slabs: &SlabTables<'_>) -> [[u32; 2]; 2] {
    let (views, pixels) = (slabs.views(), slabs.pixels());
    let side = views.saturating_mul(pixels);
    [[side.saturating_add(views.saturating_mul(pixels / 2)), side], [side; 2]]
}

/// The pictures of a slab: all views side by side, levels of radiance but the finest to the right of that, one below
/// the other. Sizes are [`slab_sizes`]; they fit into memory.
pub fn slab_pictures(slabs: &SlabTables<'_>, slab: usize) -> (Vec<u32>, Vec<i16>) {
    let [[width, height], [side, _]] = slab_sizes(slabs).map(|size| size.map(|side| side as usize));
    let (views, count) = (slabs.views() as usize, slabs.texels_a_view() as usize);
    let mut radiances = vec![0; width * height];
    let mut parallaxes = vec![0; side * side];
    for row in 0..views {
        let number = slab * views + row;
        for (view, texels) in slabs.radiance(number).chunks_exact(count).enumerate() {
            let (mut column, mut line) = (0, 0);
            for (level, &(first, pixels)) in slabs.levels().iter().enumerate() {
                let pixels = pixels as usize;
                let of_level = &texels[first as usize..first as usize + pixels * pixels];
                for (y, of_row) in of_level.chunks_exact(pixels).enumerate() {
                    let start = (line + row * pixels + y) * width + column + view * pixels;
                    radiances[start..start + pixels].copy_from_slice(of_row);
                }
                // The second level lies beside the first, the others below it.
                (column, line) = (side, if level == 0 { 0 } else { line + views * pixels });
            }
        }
        let pixels = slabs.pixels() as usize;
        for (view, of_view) in slabs.parallax(number).chunks_exact(pixels * pixels).enumerate() {
            for (y, of_row) in of_view.chunks_exact(pixels).enumerate() {
                let start = (row * pixels + y) * side + view * pixels;
                parallaxes[start..start + pixels].copy_from_slice(of_row);
            }
        }
    }
    (radiances, parallaxes)
}
