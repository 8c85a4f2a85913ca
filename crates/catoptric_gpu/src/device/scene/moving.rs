//! Scenes whose objects move: what changes in their tables is written in place.

use super::resident::{DeviceScene, object_texels};
use super::upload::write_rows;
use crate::device::context::Context;
use crate::error::GpuError;
use crate::tables::{Moved, light_records};
use bytemuck::Pod;
use catoptric::scene::Scene;
use std::sync::Arc;
use wgpu::Texture;

impl DeviceScene {
    /// The objects that have moved since the scene was loaded; `None` if anything but places and lights has changed.
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
