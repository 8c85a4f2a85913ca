//! A scene's tables on a device, for shaders that tests run.

use catoptric::scene::Scene;
use catoptric::scene::microfacets::{CELLS, ReflectanceTable};
use catoptric_gpu::Context;
use catoptric_gpu::layout::{Frame, TEXEL_ROW};
use catoptric_gpu::tables::{SceneFeatures, SceneTables, environment_texels, light_records, texture_tables};
use libtest_mimic::Failed;
use wgpu::util::DeviceExt;
use wgpu::{BindGroupEntry, BindingResource, Buffer, BufferUsages, TextureFormat, TextureView};

/// The resources that the first two groups of a scene's shaders read.
pub(crate) struct SceneResources {
    /// At bindings 1 to 8.
    views: Vec<TextureView>,
    hierarchy: [TextureView; 2],
    frame: Buffer,
    lights: Buffer,
    /// The names and values of the shaders' constants.
    pub(crate) constants: Vec<(&'static str, f64)>,
}

impl SceneResources {
    pub(crate) fn new(context: &Context, scene: &Scene) -> Result<Self, Failed> {
        let (device, queue) = (context.device(), context.queue());
        let picture = |format: TextureFormat, [width, height]: [u32; 2], texels: &[u8]| {
            let mut texels = texels.to_vec();
            let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
            texels.resize((width * height * format.block_copy_size(None).expect("no depth")) as usize, 0);
            let descriptor = wgpu::TextureDescriptor {
                label: None,
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            };
            let order = wgpu::util::TextureDataOrder::LayerMajor;
            device.create_texture_with_data(queue, &descriptor, order, &texels).create_view(&Default::default())
        };
        let rows = |count: usize| [count.clamp(1, TEXEL_ROW) as u32, count.div_ceil(TEXEL_ROW).max(1) as u32];
        let table = |bytes: &[u8]| picture(TextureFormat::Rgba32Uint, rows(bytes.len() / 16), bytes);
        let tables = SceneTables::new(scene, None, |_| true, false);
        let environment = environment_texels(scene, true);
        let textures = texture_tables(scene)?;
        let cells: Vec<[f32; 4]> =
            ReflectanceTable::get().rows().iter().flatten().map(|cell| cell.to_array()).collect();
        let numbers = TextureFormat::Rgba32Float;
        let mut surfaces: Vec<[u32; 4]> = bytemuck::cast_slice(&tables.surfaces).to_vec();
        surfaces.extend(&tables.behind_surfaces);
        let views = vec![
            table(bytemuck::cast_slice(&tables.vertices)),
            table(bytemuck::cast_slice(&tables.triangles)),
            table(bytemuck::cast_slice(&surfaces)),
            table(bytemuck::cast_slice(&textures.records)),
            picture(TextureFormat::Rgba16Uint, rows(textures.texels.len()), bytemuck::cast_slice(&textures.texels)),
            picture(numbers, environment.size, bytemuck::cast_slice(&environment.picture)),
            picture(numbers, environment.maps_size, bytemuck::cast_slice(&environment.maps)),
            picture(numbers, [CELLS as u32 + 1; 2], bytemuck::cast_slice(&cells)),
        ];
        let hierarchy = [
            table(bytemuck::cast_slice(&tables.hierarchy.nodes)),
            table(bytemuck::cast_slice(&tables.hierarchy.triangles)),
        ];
        let lights = light_records(scene)?;
        let frame = Frame {
            light_count: scene.lights.len() as u32,
            root: tables.hierarchy.root,
            extent: scene.bounds.diagonal(),
            maps: environment.places.maps,
            reductions: environment.places.reductions,
            ..bytemuck::Zeroable::zeroed()
        };
        let uniform = |contents: &[u8]| {
            let usage = BufferUsages::UNIFORM;
            device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
        };
        let (frame, lights) = (uniform(bytemuck::bytes_of(&frame)), uniform(bytemuck::cast_slice(&lights)));
        let constants = SceneFeatures::of(scene, &tables.surfaces).constants();
        Ok(Self { views, hierarchy, frame, lights, constants })
    }

    /// The entries of the first group at some bindings: tests' pipelines have no others than they read.
    pub(crate) fn of_scene(&self, bindings: &[u32]) -> Vec<BindGroupEntry<'_>> {
        let resource = |binding: u32| match binding {
            0 => self.frame.as_entire_binding(),
            9 => self.lights.as_entire_binding(),
            _ => BindingResource::TextureView(&self.views[binding as usize - 1]),
        };
        bindings.iter().map(|&binding| BindGroupEntry { binding, resource: resource(binding) }).collect()
    }

    /// Nodes and triangles of the hierarchy, the second group's.
    pub(crate) fn of_hierarchy(&self) -> Vec<BindGroupEntry<'_>> {
        let entry = |(binding, view)| BindGroupEntry { binding, resource: BindingResource::TextureView(view) };
        (0..).zip(&self.hierarchy).map(entry).collect()
    }
}
