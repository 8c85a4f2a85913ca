//! A scene in a device's memory.

use super::context::Context;
use super::frame::fields::DeviceFields;
use super::frame::layers::DeviceLayers;
use super::frame::maps::DeviceMaps;
use super::frame::mirrors::DeviceMirrors;
use super::frame::targets::PictureTables;
use super::frame::virtual_mesh::{OnDevice, VirtualTables};
use super::moving::{StoredTables, object_texels, write_rows};
use crate::error::GpuError;
use crate::hierarchy::{Hierarchy, WideHierarchy};
use crate::layout::TEXEL_ROW;
use crate::tables::{Earlier, EnvironmentPlaces, SceneFeatures, SceneTables};
use crate::tables::{environment_texels, has_pictures, light_records, texture_tables};
use bytemuck::Pod;
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
    /// The hierarchy that tiles walk.
    pub(crate) wide: wgpu::TextureView,
    pub(crate) order: BindGroup,
    pub(crate) frame: Buffer,
    pub(crate) solid_count: u32,
    pub(crate) triangle_count: u32,
    pub(crate) light_count: u32,
    pub(crate) features: SceneFeatures,
    pub(crate) pictures: Arc<DevicePictures>,
    /// On the processor, for the next moment of the scene: what it is now, and its tables.
    pub(super) source: Arc<Scene>,
    pub(super) tables: SceneTables,
    pub(super) wide_hierarchy: WideHierarchy,
    pub(super) stored: StoredTables,
    /// The hierarchy's root.
    pub(crate) root: u32,
    pub(crate) reflections: Reflections,
    /// True if something reflects or refracts.
    pub(crate) has_specular: bool,
    /// Those of the size of the last picture.
    pub(crate) picture: Mutex<Option<Arc<PictureTables>>>,
    /// For virtual geometry that is found on the device.
    pub(crate) virtual_tables: Mutex<Option<Arc<VirtualTables>>>,
    /// Memory that it takes on the device.
    pub(crate) byte_count: u64,
}

/// What becomes of light at reflectors and lenses.
#[derive(Debug)]
pub(crate) enum Reflections {
    /// Rays are followed.
    Followed,
    /// Light is looked up in environment maps.
    LookedUp(DeviceMaps),
    /// The scene is mirrored in flat mirrors.
    Mirrored(DeviceMirrors),
    /// Light is looked up in light fields about regions.
    Fields(DeviceFields),
    /// Light is looked up in layers about groups.
    Layers(Box<DeviceLayers>),
    /// Each frame comes with geometry that appears on paths; where the device can find that, what it takes.
    Projected(Option<OnDevice>),
}

impl Reflections {
    /// The light fields.
    pub(crate) fn fields(&self) -> Option<&DeviceFields> {
        match self {
            Self::Fields(fields) => Some(fields),
            _ => None,
        }
    }

    /// What of a scene's features is drawn so.
    fn narrowed(&self, features: SceneFeatures) -> SceneFeatures {
        match self {
            Self::Mirrored(_) => features.of_smooth_mirrors(),
            Self::Projected(_) => features.with_lists(),
            _ => features,
        }
    }

    /// True for triangles of reflectors and lenses that show anything but their own light.
    fn show(&self, triangle: u32) -> bool {
        match self {
            Self::Mirrored(mirrors) => mirrors.shows(triangle),
            _ => true,
        }
    }
}

/// A scene's textures and environment on a device.
#[derive(Debug)]
pub(crate) struct DevicePictures {
    textures: Vec<Arc<Texture>>,
    environment: Option<Arc<Environment>>,
    /// The table of textures, the texels, and three of the environment.
    views: [wgpu::TextureView; 5],
    /// Where the environment's maps are, with its picture's reductions where mirrors spread light.
    pub(crate) places: EnvironmentPlaces,
    has_reductions: bool,
    byte_count: u64,
}

impl DeviceScene {
    /// The tables of a scene. Of those of another moment of it, if these are given, what holds is kept.
    pub(crate) fn new(
        context: &Context,
        scene: &Arc<Scene>,
        old: Option<&Self>,
        reflections: Reflections,
    ) -> Result<Self, GpuError> {
        let earlier =
            old.map(|old| Earlier { scene: &old.source, hierarchy: &old.tables.hierarchy, shapes: &old.tables.shapes });
        let tables = SceneTables::new(scene, earlier, |triangle| reflections.show(triangle));
        let features = SceneFeatures::of(scene, &tables.surfaces);
        let lights = light_records(scene)?;
        let features = reflections.narrowed(features);
        let spreads_light = features.spreads_light();
        let kept = old.map(|old| &old.pictures).filter(|pictures| pictures.serve(scene, spreads_light));
        let pictures = match kept {
            Some(pictures) => pictures.clone(),
            None => Arc::new(DevicePictures::new(context, scene, spreads_light)?),
        };
        let device = &context.device;
        let mut upload = Upload { context, byte_count: pictures.byte_count };
        let frame = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: FRAME_STRIDE * u64::from(MAX_BANDS),
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let wide_hierarchy = tables.hierarchy.wide();
        let vertices = upload.stored("the scene's vertices", &tables.vertices)?;
        let objects = upload.stored("the scene's objects", &object_texels(&tables))?;
        let view = |texture: &wgpu::Texture| texture.create_view(&Default::default());
        let triangles = upload.table("the scene's triangles", &tables.triangles)?;
        let views = [view(&vertices), triangles, view(&objects)];
        let record = wgpu::BufferBinding { buffer: &frame, offset: 0, size: NonZeroU64::new(FRAME_SIZE) };
        let mut resources = vec![(0, BindingResource::Buffer(record))];
        resources.extend((1..).zip(views.iter().chain(&pictures.views).map(BindingResource::TextureView)));
        let lights = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("lights"),
            contents: bytemuck::cast_slice(&lights),
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
        });
        resources.push((9, lights.as_entire_binding()));
        let pipelines = &context.pipelines;
        let nodes = upload.stored("the scene's hierarchy", &tables.hierarchy.nodes)?;
        let leaves = upload.stored("the hierarchy's triangles", &tables.hierarchy.triangles)?;
        let wide_nodes = upload.stored("the hierarchy of tiles", &wide_hierarchy.nodes)?;
        let [of_nodes, of_leaves, wide] = [&nodes, &leaves, &wide_nodes].map(view);
        let hierarchy = [&of_nodes, &of_leaves, &wide].map(BindingResource::TextureView);
        let hierarchy = group(device, &pipelines.hierarchy, (0..).zip(hierarchy));
        let order = upload.buffer("the order of triangles", &tables.draw_order)?;
        let byte_count = upload.byte_count;
        let root = tables.hierarchy.root;
        context.check()?;
        let picture = old.and_then(|old| old.picture.lock().unwrap_or_else(PoisonError::into_inner).clone());
        let virtual_tables =
            old.and_then(|old| old.virtual_tables.lock().unwrap_or_else(PoisonError::into_inner).clone());
        Ok(Self {
            scene: group(device, &pipelines.scene, resources),
            hierarchy,
            wide,
            order: group(device, &pipelines.order, [(0, order.as_entire_binding())]),
            frame,
            solid_count: tables.solid_count,
            triangle_count: tables.triangles.len() as u32,
            light_count: scene.lights.len() as u32,
            features,
            pictures,
            source: scene.clone(),
            tables,
            wide_hierarchy,
            stored: StoredTables { vertices, objects, nodes, leaves, wide: wide_nodes, lights },
            root,
            has_specular: !scene.specular_objects().is_empty(),
            reflections,
            picture: Mutex::new(picture),
            virtual_tables: Mutex::new(virtual_tables),
            byte_count,
        })
    }
}

impl DeviceScene {
    /// The hierarchy, on the processor.
    pub(crate) fn boxes(&self) -> &Hierarchy {
        &self.tables.hierarchy
    }
}

impl DevicePictures {
    fn new(context: &Context, scene: &Scene, has_reductions: bool) -> Result<Self, GpuError> {
        let environment = environment_texels(scene.environment.as_deref(), has_reductions);
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
        let places = environment.places;
        Ok(Self { textures, environment: environment_of, views, places, has_reductions, byte_count })
    }

    /// True if they are a scene's, with reductions where it needs these.
    fn serve(&self, scene: &Scene, spreads_light: bool) -> bool {
        has_pictures(scene, &self.textures, self.environment.as_ref()) && (self.has_reductions || !spreads_light)
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
pub(crate) fn size_in_rows(count: usize) -> [u32; 2] {
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
        Ok(self.stored(what, records)?.create_view(&Default::default()))
    }

    /// The same, to be changed later on.
    pub(super) fn stored<T: Pod>(&mut self, what: &str, records: &[T]) -> Result<wgpu::Texture, GpuError> {
        const { assert!(size_of::<T>().is_multiple_of(size_of::<[u32; 4]>())) };
        let texels: &[[u32; 4]] = bytemuck::cast_slice(records);
        let size = size_in_rows(texels.len());
        let texture =
            self.layers(what, "make it smaller, or use the CPU backend", TextureFormat::Rgba32Uint, size, 1)?;
        self.layer(&texture, 0, texels);
        Ok(texture)
    }

    /// The tables of a hierarchy, with that which tiles walk.
    pub(crate) fn hierarchy(&mut self, hierarchy: &Hierarchy, wide: &wgpu::TextureView) -> Result<BindGroup, GpuError> {
        let nodes = self.table("the scene's hierarchy", &hierarchy.nodes)?;
        let leaves = self.table("the hierarchy's triangles", &hierarchy.triangles)?;
        let Context { device, pipelines, .. } = self.context;
        let views = [&nodes, &leaves, wide].map(BindingResource::TextureView);
        Ok(group(device, &pipelines.hierarchy, (0..).zip(views)))
    }

    /// Numbers as a table, four a texel; what is missing in the last is 0.
    pub(crate) fn numbers(&mut self, what: &str, numbers: &[u32]) -> Result<wgpu::TextureView, GpuError> {
        let texels = numbers.chunks(4).map(|four| std::array::from_fn(|index| four.get(index).copied().unwrap_or(0)));
        self.table(what, &texels.collect::<Vec<[u32; 4]>>())
    }

    /// Refuses what has too many bytes.
    pub(crate) fn check(&self, what: &str, bytes: u64, allowed: u64) -> Result<(), GpuError> {
        if bytes > allowed { Err(too_large(what, bytes, allowed)) } else { Ok(()) }
    }

    /// Numbers as a storage buffer; without any it has one that is zero, as devices allow no empty buffers.
    fn buffer(&mut self, what: &str, numbers: &[u32]) -> Result<Buffer, GpuError> {
        let bytes: &[u8] = bytemuck::cast_slice(if numbers.is_empty() { &[0] } else { numbers });
        let limits = self.context.device.limits();
        let allowed = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        self.check(what, bytes.len() as u64, allowed)?;
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
    pub(crate) fn picture<T: Pod>(
        &mut self,
        what: &str,
        format: TextureFormat,
        size: [u32; 2],
        texels: &[T],
    ) -> Result<wgpu::TextureView, GpuError> {
        let texture = self.layers(what, "make it smaller, or use the CPU backend", format, size, 1)?;
        self.layer(&texture, 0, texels);
        Ok(texture.create_view(&Default::default()))
    }

    /// Pictures of one size that are still empty.
    pub(crate) fn layers(
        &self,
        what: &str,
        remedy: &'static str,
        format: TextureFormat,
        size: [u32; 2],
        layers: u32,
    ) -> Result<wgpu::Texture, GpuError> {
        let device = &self.context.device;
        let allowed = device.limits().max_texture_dimension_2d;
        if size.iter().any(|side| *side > allowed) {
            let needed = format!("{} x {} texels", size[0], size[1]);
            return Err(GpuError::Limit { what: what.into(), needed, allowed: format!("{allowed} a side"), remedy });
        }
        let descriptor = wgpu::TextureDescriptor {
            label: Some(what),
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
            view_formats: &[],
        };
        Ok(device.create_texture(&descriptor))
    }

    /// Fills one of several pictures, row by row; texels that are missing at its end are zero.
    pub(crate) fn layer<T: Pod>(&mut self, texture: &wgpu::Texture, layer: u32, texels: &[T]) {
        self.byte_count += size_of_val(texels) as u64;
        let queue = &self.context.queue;
        // In parts, with all whole rows of a part at once: copies on their way take memory, too.
        let row = texture.width() as usize;
        let rows = (BYTES_AT_ONCE / size_of_val(&texels[..row.min(texels.len())]).max(1)).max(1);
        for (part, texels) in texels.chunks(row * rows).enumerate() {
            write_rows(queue, texture, [(part * rows) as u32, layer], texels);
        }
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
