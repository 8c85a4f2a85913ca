//! A scene's textures and environment in a device's memory.

use super::upload::{Upload, size_in_rows};
use crate::device::context::Context;
use crate::error::GpuError;
use crate::tables::{EnvironmentPlaces, environment_texels, has_pictures, texture_tables};
use catoptric::scene::microfacets::{CELLS, ReflectanceTable};
use catoptric::scene::{Environment, Scene, Texture};
use std::sync::Arc;
use wgpu::TextureFormat;

/// A scene's textures and environment on a device.
#[derive(Debug)]
pub(crate) struct DevicePictures {
    textures: Vec<Arc<Texture>>,
    environment: Option<Arc<Environment>>,
    /// The irradiance is that beside suns.
    has_sky: bool,
    /// The table of textures, the texels, and three of the environment.
    pub(super) views: [wgpu::TextureView; 5],
    /// Where the environment's maps are, with its picture's reductions where mirrors spread light.
    pub(crate) places: EnvironmentPlaces,
    has_reductions: bool,
    pub(super) byte_count: u64,
}

impl DevicePictures {
    pub(super) fn new(context: &Context, scene: &Scene, has_reductions: bool) -> Result<Self, GpuError> {
        let environment = environment_texels(scene, has_reductions);
        let textures = texture_tables(scene)?;
        let texels = textures.texels;
        let numbers = TextureFormat::Rgba32Float;
        let cells = [CELLS as u32 + 1; 2];
        let mut upload = Upload { context, byte_count: 0 };
        let views = [
            upload.table("the scene's textures", &textures.records)?,
            upload.picture(
                "the texels of all textures",
                TextureFormat::Rgba16Uint,
                size_in_rows(texels.len()),
                &texels,
            )?,
            upload.picture("the environment", numbers, environment.size, &environment.picture)?,
            upload.picture("the environment's maps", numbers, environment.maps_size, &environment.maps)?,
            upload.picture("the reflectance table", numbers, cells, &reflectances())?,
        ];
        let (textures, environment_of) = (scene.textures.clone(), scene.environment.clone());
        let has_sky = scene.sky.is_some();
        let byte_count = upload.byte_count;
        let places = environment.places;
        Ok(Self { textures, environment: environment_of, has_sky, views, places, has_reductions, byte_count })
    }

    /// True if they are a scene's, with reductions where it needs these.
    pub(super) fn serve(&self, scene: &Scene, spreads_light: bool) -> bool {
        has_pictures(scene, &self.textures, self.environment.as_ref())
            && self.has_sky == scene.sky.is_some()
            && (self.has_reductions || !spreads_light)
    }
}

fn reflectances() -> Vec<[f32; 4]> {
    ReflectanceTable::get().rows().iter().flatten().map(|cell| cell.to_array()).collect()
}
