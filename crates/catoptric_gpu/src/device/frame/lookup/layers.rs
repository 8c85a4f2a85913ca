//! Layered environment maps about groups of reflectors in a device's memory.

use crate::device::context::Context;
use crate::device::pipelines::group;
use crate::device::scene::{DeviceScene, Upload, size_in_rows};
use crate::error::GpuError;
use crate::hierarchy::Hierarchy;
use crate::tables::{LayerMaps, layer_maps};
use catoptric::methods::lookup::layered_environment_map::{LayeredMaps, ViewpointLayers};
use catoptric::scene::{Scene, View};
use wgpu::{BindGroup, BindingResource, TextureFormat, TextureView};

/// The layers of a scene on a device.
#[derive(Debug)]
pub(crate) struct DeviceLayers {
    /// The bindings of the layers of the last view.
    pub(crate) group: BindGroup,
    /// The scene's hierarchy with those of groups.
    pub(crate) hierarchy: BindGroup,
    /// The roots of these.
    roots: Vec<u32>,
    numbers: TextureView,
    /// The layers of a view, and by which viewpoints and sizes of textures they are known.
    maps: LayerMaps,
    viewpoints: Vec<Vec<(u32, Vec<u32>)>>,
    /// Texels and words.
    views: [TextureView; 2],
    /// Memory that all of it takes on the device.
    pub(crate) byte_count: u64,
}

/// The viewpoints whose layers groups look up, with the sizes of these.
fn viewpoints_of(groups: &[Vec<ViewpointLayers<'_>>]) -> Vec<Vec<(u32, Vec<u32>)>> {
    let of =
        |viewpoint: &ViewpointLayers<'_>| (viewpoint.number, viewpoint.layers().map(|layer| layer.size()).collect());
    groups.iter().map(|viewpoints| viewpoints.iter().map(of).collect()).collect()
}

impl DeviceLayers {
    /// Loads the layers that a view looks up. They must have been inferred.
    pub(crate) fn new(
        context: &Context,
        scene: &Scene,
        resident: &DeviceScene,
        layers: &LayeredMaps,
        view: &View,
    ) -> Result<Self, GpuError> {
        let mut upload = Upload { context, byte_count: 0 };
        let group_of = layers.group_of();
        let groups = layers.layers_of_groups(view);
        let mut hierarchy = resident.boxes().clone();
        let roots: Vec<u32> = (0..groups.len() as u32)
            .map(|number| hierarchy.append(Hierarchy::of(scene, |object| group_of[object as usize] == Some(number))))
            .collect();
        let hierarchy = upload.hierarchy(&hierarchy, &resident.wide)?;
        let numbers: Vec<u32> = group_of.iter().map(|number| number.map_or(0, |number| number + 1)).collect();
        let numbers = upload.numbers("the groups of objects", &numbers)?;
        let viewpoints = viewpoints_of(&groups);
        let (maps, views) = loaded(&mut upload, &groups, &roots)?;
        let group = grouped(&mut upload, &maps, &groups, &numbers, &views)?;
        context.check()?;
        let byte_count = upload.byte_count;
        Ok(Self { group, hierarchy, roots, numbers, maps, viewpoints, views, byte_count })
    }

    /// Loads what another view of the same scene looks up.
    pub(crate) fn update(&mut self, context: &Context, layers: &LayeredMaps, view: &View) -> Result<(), GpuError> {
        let mut upload = Upload { context, byte_count: 0 };
        let groups = layers.layers_of_groups(view);
        let viewpoints = viewpoints_of(&groups);
        if viewpoints != self.viewpoints {
            (self.maps, self.views) = loaded(&mut upload, &groups, &self.roots)?;
            self.viewpoints = viewpoints;
        }
        self.group = grouped(&mut upload, &self.maps, &groups, &self.numbers, &self.views)?;
        context.check()
    }
}

/// The layers as tables, with texels and words on the device alone.
fn loaded(
    upload: &mut Upload<'_>,
    groups: &[Vec<ViewpointLayers<'_>>],
    roots: &[u32],
) -> Result<(LayerMaps, [TextureView; 2]), GpuError> {
    let mut maps = layer_maps(groups, roots)?;
    let (texels, words) = (std::mem::take(&mut maps.texels), std::mem::take(&mut maps.words));
    let (of_texels, of_words) = (size_in_rows(texels.len()), size_in_rows(words.len()));
    let texels = upload.picture("the textures of layers", TextureFormat::Rgba16Float, of_texels, &texels)?;
    let words = upload.picture("the depths of layers", TextureFormat::R32Uint, of_words, &words)?;
    Ok((maps, [texels, words]))
}

fn grouped(
    upload: &mut Upload<'_>,
    maps: &LayerMaps,
    groups: &[Vec<ViewpointLayers<'_>>],
    numbers: &TextureView,
    views: &[TextureView; 2],
) -> Result<BindGroup, GpuError> {
    let shares: Vec<Vec<f32>> =
        groups.iter().map(|viewpoints| viewpoints.iter().map(|viewpoint| viewpoint.share).collect()).collect();
    let table = upload.table("layers", &maps.table(&shares))?;
    let Context { device, pipelines, .. } = upload.context;
    let resources = (0..).zip([numbers, &table, &views[0], &views[1]].map(BindingResource::TextureView));
    Ok(group(device, &pipelines.layers, resources))
}
