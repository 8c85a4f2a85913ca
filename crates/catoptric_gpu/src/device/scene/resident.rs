//! A scene in a device's memory.

use super::pictures::DevicePictures;
use super::upload::Upload;
use crate::device::context::Context;
use crate::device::pipelines::group;
use crate::error::GpuError;
use crate::hierarchy::{Hierarchy, WideHierarchy};
use crate::tables::{Earlier, SceneFeatures, SceneTables, light_records};
use catoptric::scene::Scene;
use std::num::NonZeroU64;
use std::sync::Arc;
use wgpu::util::DeviceExt;
use wgpu::{BindGroup, BindingResource, Buffer, BufferUsages, Texture};

/// The most bands that a picture is drawn in, each with a record of its own.
pub(crate) const MAX_BANDS: u32 = 128;
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
    pub(crate) sun_count: u32,
    pub(crate) features: SceneFeatures,
    pub(crate) pictures: Arc<DevicePictures>,
    /// On the processor, for the next moment of the scene: what it is now, and its tables.
    pub(super) source: Arc<Scene>,
    pub(crate) tables: SceneTables,
    pub(super) wide_hierarchy: WideHierarchy,
    pub(super) stored: StoredTables,
    /// The hierarchy's root.
    pub(crate) root: u32,
    /// True if something reflects or refracts.
    pub(crate) has_specular: bool,
    /// Memory that it takes on the device.
    pub(crate) byte_count: u64,
}

/// The tables that change when something moves.
#[derive(Debug)]
pub(super) struct StoredTables {
    pub(super) vertices: Texture,
    pub(super) objects: Texture,
    pub(super) nodes: Texture,
    pub(super) leaves: Texture,
    pub(super) wide: Texture,
    pub(super) lights: Buffer,
}

impl DeviceScene {
    /// The tables of a scene, of which the triangles of reflectors and lenses that `shows` is true for show anything
    /// but their own light, and the features are `narrowed`; lobes are followed if `follows_lobes`. Of those of another
    /// moment of it, if these are given, what holds is kept.
    pub(crate) fn new(
        context: &Context,
        scene: &Arc<Scene>,
        old: Option<&Self>,
        (shows, follows_lobes): (impl Fn(u32) -> bool, bool),
        narrowed: impl Fn(SceneFeatures) -> SceneFeatures,
    ) -> Result<Self, GpuError> {
        let earlier =
            old.map(|old| Earlier { scene: &old.source, hierarchy: &old.tables.hierarchy, shapes: &old.tables.shapes });
        let tables = SceneTables::new(scene, earlier, shows, follows_lobes);
        let lights = light_records(scene)?;
        let features = narrowed(SceneFeatures::of(scene, &tables.surfaces));
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
        Ok(Self {
            scene: group(device, &pipelines.scene, resources),
            hierarchy,
            wide,
            order: group(device, &pipelines.order, [(0, order.as_entire_binding())]),
            frame,
            solid_count: tables.solid_count,
            triangle_count: scene.triangles.len() as u32,
            light_count: scene.lights.len() as u32,
            sun_count: sun_count(scene),
            features,
            pictures,
            source: scene.clone(),
            tables,
            wide_hierarchy,
            stored: StoredTables { vertices, objects, nodes, leaves, wide: wide_nodes, lights },
            root,
            has_specular: !scene.specular_objects().is_empty() || features.has_lobes(),
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

/// Suns of a scene's sky.
pub(super) fn sun_count(scene: &Scene) -> u32 {
    scene.sky.as_ref().map_or(0, |sky| sky.suns().len() as u32)
}

/// The objects with what lies behind them.
pub(super) fn object_texels(tables: &SceneTables) -> Vec<[u32; 4]> {
    let mut texels: Vec<[u32; 4]> = bytemuck::cast_slice(&tables.surfaces).to_vec();
    texels.extend(&tables.behind_surfaces);
    texels
}
