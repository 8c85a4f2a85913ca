//! A scene in a device's memory.

use super::context::Context;
use super::frame::maps::DeviceMaps;
use super::frame::mirrors::DeviceMirrors;
use super::frame::targets::PictureTables;
use crate::error::GpuError;
use crate::hierarchy::Hierarchy;
use crate::layout::{ENVIRONMENT_MAPS, LightRecord, TEXEL_ROW};
use crate::tables::{Earlier, SceneFeatures, SceneTables, environment_texels, light_records, texture_tables};
use bytemuck::Pod;
use catoptric::methods::projection::multiperspective::ObjectShape;
use catoptric::scene::microfacets::{CELLS, ReflectanceTable};
use catoptric::scene::{Environment, Scene, Texture};
use std::num::NonZeroU64;
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::util::DeviceExt;
use wgpu::{BindGroup, BindingResource, Buffer, BufferUsages, TextureFormat, TextureUsages};

/// The most bands that a picture is drawn in, each with a record of its own.
pub(crate) const MAX_BANDS: u32 = 128;
/// The most bytes that are sent at a time.
const BYTES_AT_ONCE: usize = 1 << 26;
const FRAME_SIZE: u64 = size_of::<crate::layout::Frame>() as u64;
/// From record to record: offsets of uniform buffers are multiples of 256.
pub(crate) const FRAME_STRIDE: u64 = FRAME_SIZE.next_multiple_of(256);

/// A scene's tables on a device.
#[derive(Debug)]
pub(crate) struct DeviceScene {
    /// The frame's uniform buffer, the tables and the environment.
    pub(crate) scene: BindGroup,
    pub(crate) hierarchy: BindGroup,
    pub(crate) order: BindGroup,
    pub(crate) frame: Buffer,
    pub(crate) solid_count: u32,
    pub(crate) triangle_count: u32,
    pub(crate) lights: Vec<LightRecord>,
    pub(crate) features: SceneFeatures,
    pub(crate) pictures: Arc<DevicePictures>,
    /// On the processor, for the next moment of the scene: what it is now, and what may hold still then.
    source: Arc<Scene>,
    boxes: Hierarchy,
    shapes: Vec<ObjectShape>,
    /// The hierarchy's root.
    pub(crate) root: u32,
    /// Environment maps, of scenes whose reflectors and lenses look light up.
    pub(crate) maps: Option<DeviceMaps>,
    /// Flat mirrors, of scenes that are drawn by them.
    pub(crate) mirrors: Option<DeviceMirrors>,
    /// True if something reflects or refracts.
    pub(crate) has_specular: bool,
    /// Those of the size of the last picture.
    pub(crate) picture: Mutex<Option<Arc<PictureTables>>>,
    /// Memory that it takes on the device.
    pub(crate) byte_count: u64,
}

/// A scene's textures and environment on a device.
#[derive(Debug)]
pub(crate) struct DevicePictures {
    textures: Vec<Arc<Texture>>,
    environment: Option<Arc<Environment>>,
    /// The table of textures, the texels, and three of the environment.
    views: [wgpu::TextureView; 5],
    /// Of the environment's maps.
    pub(crate) maps: [[u32; 4]; ENVIRONMENT_MAPS],
    byte_count: u64,
}

impl DeviceScene {
    /// The tables of a scene. Of those of another moment of it, if these are given, what holds is kept.
    pub(crate) fn new(
        context: &Context,
        scene: &Arc<Scene>,
        old: Option<&Self>,
        mirrors: Option<DeviceMirrors>,
    ) -> Result<Self, GpuError> {
        let shows = |triangle: u32| mirrors.as_ref().is_none_or(|mirrors| mirrors.shows(triangle));
        let earlier = old.map(|old| Earlier { scene: &old.source, hierarchy: &old.boxes, shapes: &old.shapes });
        let tables = SceneTables::new(scene, earlier, shows)?;
        let features = SceneFeatures::of(scene, &tables.surfaces);
        let lights = light_records(scene)?;
        let kept = old.map(|old| &old.pictures).filter(|pictures| pictures.are_of(scene));
        let pictures = match kept {
            Some(pictures) => pictures.clone(),
            None => Arc::new(DevicePictures::new(context, scene)?),
        };
        let device = &context.device;
        let mut upload = Upload { context, byte_count: pictures.byte_count };
        let frame = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: FRAME_STRIDE * u64::from(MAX_BANDS),
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let views = [
            upload.table("the scene's vertices", &tables.vertices)?,
            upload.table("the scene's triangles", &tables.triangles)?,
            upload.table("the scene's objects", &tables.surfaces)?,
        ];
        let record = wgpu::BufferBinding { buffer: &frame, offset: 0, size: NonZeroU64::new(FRAME_SIZE) };
        let mut resources = vec![(0, BindingResource::Buffer(record))];
        resources.extend((1..).zip(views.iter().chain(&pictures.views).map(BindingResource::TextureView)));
        let pipelines = &context.pipelines;
        let [nodes, leaves, wide] = [
            upload.table("the scene's hierarchy", &tables.hierarchy.nodes)?,
            upload.table("the hierarchy's triangles", &tables.hierarchy.triangles)?,
            upload.table("the hierarchy of tiles", &tables.hierarchy.wide())?,
        ];
        let order = upload.buffer("the order of triangles", &tables.draw_order)?;
        let of_hierarchy = [
            (0, BindingResource::TextureView(&nodes)),
            (1, BindingResource::TextureView(&leaves)),
            (2, BindingResource::TextureView(&wide)),
        ];
        let byte_count = upload.byte_count;
        let root = tables.hierarchy.root;
        context.check()?;
        let picture = old.and_then(|old| old.picture.lock().unwrap_or_else(PoisonError::into_inner).clone());
        Ok(Self {
            scene: group(device, &pipelines.scene, resources),
            hierarchy: group(device, &pipelines.hierarchy, of_hierarchy),
            order: group(device, &pipelines.order, [(0, order.as_entire_binding())]),
            frame,
            solid_count: tables.solid_count,
            triangle_count: tables.triangles.len() as u32,
            lights,
            features: if mirrors.is_some() { features.without_lenses() } else { features },
            pictures,
            source: scene.clone(),
            boxes: tables.hierarchy,
            shapes: tables.shapes,
            root,
            has_specular: !scene.specular_objects().is_empty(),
            maps: None,
            mirrors,
            picture: Mutex::new(picture),
            byte_count,
        })
    }
}

impl DevicePictures {
    fn new(context: &Context, scene: &Scene) -> Result<Self, GpuError> {
        let environment = environment_texels(scene.environment.as_deref());
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
        let byte_count = upload.byte_count;
        Ok(Self { textures, environment: environment_of, views, maps: environment.places, byte_count })
    }

    /// True if they are a scene's.
    fn are_of(&self, scene: &Scene) -> bool {
        let is_same = |(a, b): (&Arc<Texture>, &Arc<Texture>)| Arc::ptr_eq(a, b);
        let of_textures =
            self.textures.len() == scene.textures.len() && self.textures.iter().zip(&scene.textures).all(is_same);
        let of_environment = match (&self.environment, &scene.environment) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        of_textures && of_environment
    }
}

/// A bind group of resources by their bindings.
pub(crate) fn group<'a>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = (u32, BindingResource<'a>)>,
) -> BindGroup {
    let entry = |(binding, resource)| wgpu::BindGroupEntry { binding, resource };
    let entries: Vec<_> = resources.into_iter().map(entry).collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

/// The size of a picture that holds so many texels in rows of [`TEXEL_ROW`]; devices allow no empty ones.
fn size_in_rows(count: usize) -> [u32; 2] {
    [count.clamp(1, TEXEL_ROW) as u32, count.div_ceil(TEXEL_ROW).max(1) as u32]
}

fn reflectances() -> Vec<[f32; 4]> {
    ReflectanceTable::get().rows().iter().flatten().map(|cell| cell.to_array()).collect()
}

/// Copies tables to a device.
pub(crate) struct Upload<'a> {
    pub(crate) context: &'a Context,
    pub(crate) byte_count: u64,
}

impl Upload<'_> {
    /// A table as a picture of four numbers a texel.
    pub(crate) fn table<T: Pod>(&mut self, what: &str, records: &[T]) -> Result<wgpu::TextureView, GpuError> {
        const { assert!(size_of::<T>().is_multiple_of(size_of::<[u32; 4]>())) };
        let texels: &[[u32; 4]] = bytemuck::cast_slice(records);
        self.picture(what, TextureFormat::Rgba32Uint, size_in_rows(texels.len()), texels)
    }

    /// Numbers as a storage buffer; without any it has one that is zero, as devices allow no empty buffers.
    fn buffer(&mut self, what: &str, numbers: &[u32]) -> Result<Buffer, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(if numbers.is_empty() { &[0] } else { numbers });
        let limits = self.context.device.limits();
        let allowed = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        if bytes.len() as u64 > allowed {
            return Err(too_large(what, bytes.len() as u64, allowed));
        }
        self.byte_count += bytes.len() as u64;
        let usage = BufferUsages::STORAGE;
        let descriptor = wgpu::util::BufferInitDescriptor { label: Some(what), contents: bytes, usage };
        Ok(self.context.device.create_buffer_init(&descriptor))
    }

    /// Colours as a picture in rows of [`TEXEL_ROW`].
    pub(crate) fn colors(&mut self, what: &str, colors: &[[f32; 4]]) -> Result<wgpu::TextureView, GpuError> {
        self.picture(what, TextureFormat::Rgba32Float, size_in_rows(colors.len()), colors)
    }

    /// A picture of a format, row by row; texels that are missing at its end are zero.
    fn picture<T: Pod>(
        &mut self,
        what: &str,
        format: TextureFormat,
        size: [u32; 2],
        texels: &[T],
    ) -> Result<wgpu::TextureView, GpuError> {
        let Context { device, queue, .. } = self.context;
        let allowed = device.limits().max_texture_dimension_2d;
        if size.iter().any(|side| *side > allowed) {
            return Err(GpuError::Limit {
                what: what.into(),
                needed: format!("{} x {} texels", size[0], size[1]),
                allowed: format!("{allowed} a side"),
                remedy: "make it smaller, or use the CPU backend",
            });
        }
        self.byte_count += size_of_val(texels) as u64;
        let descriptor = wgpu::TextureDescriptor {
            label: Some(what),
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
            view_formats: &[],
        };
        let texture = device.create_texture(&descriptor);
        // In parts, with all whole rows of a part at once: copies on their way take memory, too.
        let row = size[0] as usize;
        let rows = (BYTES_AT_ONCE / size_of_val(&texels[..row.min(texels.len())]).max(1)).max(1);
        for (part, texels) in texels.chunks(row * rows).enumerate() {
            let (whole, rest) = texels.split_at(texels.len() / row * row);
            let whole_rows = (whole.len() / row) as u32;
            let first = (part * rows) as u32;
            for (y, height, texels) in [(first, whole_rows, whole), (first + whole_rows, 1, rest)] {
                let width = (texels.len() as u32).min(size[0]);
                if texels.is_empty() {
                    continue;
                }
                queue.write_texture(
                    wgpu::TexelCopyTextureInfo { origin: wgpu::Origin3d { x: 0, y, z: 0 }, ..texture.as_image_copy() },
                    bytemuck::cast_slice(texels),
                    wgpu::TexelCopyBufferLayout {
                        offset: 0,
                        bytes_per_row: Some(width * size_of::<T>() as u32),
                        rows_per_image: None,
                    },
                    wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                );
            }
        }
        Ok(texture.create_view(&Default::default()))
    }
}

fn too_large(what: &str, needed: u64, allowed: u64) -> GpuError {
    let mib = |bytes: u64| format!("{:.1} MiB", bytes as f64 / f64::from(1 << 20));
    GpuError::Limit {
        what: what.into(),
        needed: mib(needed),
        allowed: mib(allowed),
        remedy: "use a scene with fewer triangles or smaller textures, or the CPU backend",
    }
}
