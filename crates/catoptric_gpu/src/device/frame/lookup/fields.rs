//! Light fields about regions of reflectors in a device's memory.

use super::maps::map_views;
use crate::device::context::Context;
use crate::device::pipelines::group;
use crate::device::scene::{DeviceScene, Upload};
use crate::error::GpuError;
use crate::tables::{field_tables, slab_pictures, slab_sizes, slab_tables};
use catoptric::methods::lookup::light_field::{LightFields, SlabTables, Slabs};
use catoptric::scene::Scene;
use std::sync::Arc;
use wgpu::{BindGroup, BindingResource, TextureFormat, TextureView};

/// Slabs of a region.
const SLABS: usize = 6;

/// The light fields of a scene on a device.
#[derive(Debug)]
pub(crate) struct DeviceFields {
    /// Light fields, and environment maps.
    pub(crate) group: BindGroup,
    /// The scene's hierarchy with those of regions.
    pub(crate) hierarchy: BindGroup,
    pictures: Arc<SlabPictures>,
    /// Memory that they take on the device.
    pub(crate) byte_count: u64,
}

/// The pictures of all slabs on a device.
#[derive(Debug)]
struct SlabPictures {
    slabs: Vec<Arc<Slabs>>,
    /// The pictures of radiance, and those of parallax.
    views: [TextureView; 2],
    byte_count: u64,
}

impl DeviceFields {
    /// Loads the light fields of a scene; what holds of another moment's is kept.
    pub(crate) fn new(
        context: &Context,
        scene: &Scene,
        resident: &DeviceScene,
        (fields, traces): (&LightFields, bool),
        old: Option<&Self>,
    ) -> Result<Self, GpuError> {
        let device = &context.device;
        let pictures = match old.filter(|old| old.pictures.are_of(fields)) {
            Some(old) => old.pictures.clone(),
            None => Arc::new(SlabPictures::new(context, fields)?),
        };
        let tables = field_tables(scene, fields, traces, resident.boxes())?;
        let mut upload = Upload { context, byte_count: pictures.byte_count };
        let [maps, map_texels] = map_views(&mut upload, &tables.maps)?;
        let regions = upload.table("the regions of light fields", &tables.regions)?;
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("light fields"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let views = [&maps, &map_texels, &regions, &pictures.views[0], &pictures.views[1]];
        let views = (0..).zip(views.map(BindingResource::TextureView));
        let resources = views.chain([(5, BindingResource::Sampler(&sampler))]);
        let group = group(device, &context.pipelines.fields, resources);
        let hierarchy = upload.hierarchy(&tables.hierarchy, &resident.wide)?;
        context.check()?;
        Ok(Self { group, hierarchy, pictures, byte_count: upload.byte_count })
    }
}

impl SlabPictures {
    fn new(context: &Context, fields: &LightFields) -> Result<Self, GpuError> {
        let slabs: Vec<Arc<Slabs>> = fields.slabs().cloned().collect();
        // Without regions there is one picture of nothing.
        let tables: Vec<SlabTables<'_>> = slabs.iter().map(|slabs| slab_tables(slabs)).collect::<Result<_, _>>()?;
        let sizes = tables.first().map_or([[1; 2]; 2], slab_sizes);
        let layers = (slabs.len() * SLABS).max(1) as u32;
        let mut upload = Upload { context, byte_count: 0 };
        let formats = [TextureFormat::Rgb9e5Ufloat, TextureFormat::R16Sint];
        let [radiances, parallaxes] = [0, 1].map(|index| {
            let (label, remedy) = ("the pictures of light-field slabs", "use fewer views (`st`) or pixels (`uv`)");
            upload.layers(label, remedy, formats[index], sizes[index], layers)
        });
        let [radiances, parallaxes] = [radiances?, parallaxes?];
        for (region, tables) in tables.iter().enumerate() {
            for slab in 0..SLABS {
                let (of_light, of_parallax) = slab_pictures(tables, slab);
                let layer = (region * SLABS + slab) as u32;
                upload.layer(&radiances, layer, &of_light);
                upload.layer(&parallaxes, layer, &of_parallax);
            }
        }
        context.check()?;
        let views = [radiances, parallaxes].map(|texture| {
            let dimension = Some(wgpu::TextureViewDimension::D2Array);
            texture.create_view(&wgpu::TextureViewDescriptor { dimension, ..Default::default() })
        });
        Ok(Self { slabs, views, byte_count: upload.byte_count })
    }

    /// True if they show a scene's fields.
    fn are_of(&self, fields: &LightFields) -> bool {
        self.slabs.len() == fields.slabs().len()
            && self.slabs.iter().zip(fields.slabs()).all(|(a, b)| Arc::ptr_eq(a, b))
    }
}
