//! Scenes whose objects move: what changes in their tables is written in place.

use super::context::Context;
use super::upload::DeviceScene;
use crate::error::GpuError;
use crate::tables::{Moved, SceneTables, light_records};
use bytemuck::Pod;
use catoptric::scene::Scene;
use std::sync::Arc;
use wgpu::{Buffer, Texture};

impl DeviceScene {
    /// What has moved since the scene was loaded, if nothing but places and lights have changed.
    pub(crate) fn moved_to(&self, scene: &Scene) -> Option<Moved> {
        Moved::between(&self.source, scene, &self.tables.hierarchy)
    }

    /// Follows the scene to another moment, in which this has moved. What was drawn before must have been submitted:
    /// tables change in place.
    pub(crate) fn move_to(&mut self, context: &Context, scene: &Arc<Scene>, moved: &Moved) -> Result<(), GpuError> {
        let lights = light_records(scene)?;
        let places = self.tables.move_to(&self.source, scene, moved);
        let wide = self.wide_hierarchy.move_to(&self.tables.hierarchy, &places);
        self.light_count = scene.lights.len() as u32;
        let (queue, Self { tables, stored, .. }) = (&context.queue, &*self);
        queue.write_buffer(&stored.lights, 0, bytemuck::cast_slice(&lights));
        let mut vertices = vec![false; tables.vertices.len()];
        for object in moved.of(scene) {
            vertices[object.vertices.start as usize..object.vertices.end as usize].fill(true);
        }
        write_rows(queue, &stored.objects, [0; 2], &object_texels(tables));
        write_changed(queue, &stored.vertices, &tables.vertices, &vertices);
        write_changed(queue, &stored.leaves, &tables.hierarchy.triangles, &places.triangles);
        write_changed(queue, &stored.nodes, &tables.hierarchy.nodes, &places.nodes);
        write_changed(queue, &stored.wide, &self.wide_hierarchy.nodes, &wide);
        self.source = scene.clone();
        context.check()
    }
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

/// The objects with what lies behind them.
pub(super) fn object_texels(tables: &SceneTables) -> Vec<[u32; 4]> {
    let mut texels: Vec<[u32; 4]> = bytemuck::cast_slice(&tables.surfaces).to_vec();
    texels.extend(&tables.programs);
    texels
}

/// Writes the rows of a table that have a record which changes.
fn write_changed<T: Pod>(queue: &wgpu::Queue, texture: &Texture, records: &[T], changes: &[bool]) {
    let texels: &[[u32; 4]] = bytemuck::cast_slice(records);
    let of_record = size_of::<T>() / size_of::<[u32; 4]>();
    let width = texture.width() as usize;
    let mut rows = vec![false; texels.len().div_ceil(width)];
    for record in (0..records.len()).filter(|record| changes[*record]) {
        rows[record * of_record / width..=((record + 1) * of_record - 1) / width].fill(true);
    }
    let mut first = 0;
    while let Some(start) = rows[first..].iter().position(|changes| *changes).map(|place| first + place) {
        let end = rows[start..].iter().position(|changes| !changes).map_or(rows.len(), |place| start + place);
        let part = &texels[start * width..texels.len().min(end * width)];
        write_rows(queue, texture, [start as u32, 0], part);
        first = end;
    }
}

/// Writes texels row by row, from a row of a layer on.
pub(super) fn write_rows<T: Pod>(queue: &wgpu::Queue, texture: &Texture, [first, layer]: [u32; 2], texels: &[T]) {
    let row = texture.width() as usize;
    let (whole, rest) = texels.split_at(texels.len() / row * row);
    let whole_rows = (whole.len() / row) as u32;
    for (y, height, texels) in [(first, whole_rows, whole), (first + whole_rows, 1, rest)] {
        if texels.is_empty() {
            continue;
        }
        let width = (texels.len() / height as usize) as u32;
        let origin = wgpu::Origin3d { x: 0, y, z: layer };
        queue.write_texture(
            wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() },
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
