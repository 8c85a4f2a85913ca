//! The drawing of a frame on a device.

use crate::context::Context;
use crate::error::GpuError;
use crate::layout::{Frame, LightRecord, MAX_LIGHTS, frame_flags};
use crate::pipelines::{DEPTH_FORMAT, ID_FORMAT, SAMPLE_COUNTS};
use crate::upload::{DeviceScene, group};
use catoptric::methods::Quality;
use catoptric::scene::{Projection, Scene, View};
use glam::{Mat4, Vec3, Vec4};
use wgpu::{BufferUsages, LoadOp, Operations, StoreOp, TextureFormat, TextureUsages};

/// The most pixels of a piece of work: longer ones would let a screen freeze.
const PIXELS_AT_ONCE: u32 = 1 << 20;
/// Pixels along a side of a workgroup.
const WORKGROUP: u32 = 8;

/// Draws a view of a scene; pixels are linear colours with alpha 1, rows from the top.
pub(crate) fn draw(
    context: &Context,
    resident: &DeviceScene,
    scene: &Scene,
    view: &View,
    quality: Quality,
    pixels: &mut [[f32; 4]],
) -> Result<(), GpuError> {
    let Context { device, queue, pipelines, .. } = context;
    if view.width == 0 || view.height == 0 {
        return Ok(());
    }
    let index = SAMPLE_COUNTS.iter().position(|count| *count == quality.samples).unwrap_or_default();
    let shade = pipelines.shade(device, index, resident.features);
    let targets = Targets::new(context, view, quality.samples)?;
    let mut record = frame_record(scene, view, quality, resident);
    let rows = (PIXELS_AT_ONCE / view.width).clamp(1, view.height);
    let band_bytes = u64::from(rows * view.width) * 16;
    let buffer = |label, usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: band_bytes,
            usage,
            mapped_at_creation: false,
        })
    };
    let colors = buffer("colours", BufferUsages::STORAGE | BufferUsages::COPY_SRC);
    let read = buffer("colours to be read", BufferUsages::COPY_DST | BufferUsages::MAP_READ);
    let ids = wgpu::BindingResource::TextureView(&targets.ids);
    let picture = match index {
        0 => group(device, &pipelines.picture[0], [(0, ids), (1, colors.as_entire_binding())]),
        _ => group(device, &pipelines.picture[1], [(1, colors.as_entire_binding()), (2, ids)]),
    };
    for first_row in (0..view.height).step_by(rows as usize) {
        record.first_row = first_row;
        queue.write_buffer(&resident.frame, 0, bytemuck::bytes_of(&record));
        let mut encoder = device.create_command_encoder(&Default::default());
        if first_row == 0 {
            targets.draw_ids(&mut encoder, context, resident, index);
        }
        let band = rows.min(view.height - first_row);
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&shade);
        pass.set_bind_group(0, &resident.scene, &[]);
        pass.set_bind_group(1, &resident.hierarchy, &[]);
        pass.set_bind_group(2, &picture, &[]);
        pass.dispatch_workgroups(view.width.div_ceil(WORKGROUP), band.div_ceil(WORKGROUP), 1);
        drop(pass);
        let bytes = u64::from(band * view.width) * 16;
        encoder.copy_buffer_to_buffer(&colors, 0, &read, 0, bytes);
        queue.submit([encoder.finish()]);
        read.map_async(wgpu::MapMode::Read, ..bytes, |_| {});
        context.wait()?;
        let first = (first_row * view.width) as usize;
        let part = &mut pixels[first..first + (band * view.width) as usize];
        let mapped = read.get_mapped_range(..bytes);
        let mapped = mapped.map_err(|error| GpuError::Device { problem: error.to_string() })?;
        part.copy_from_slice(bytemuck::cast_slice(&mapped));
        drop(mapped);
        read.unmap();
    }
    Ok(())
}

/// The textures that a view's triangles are drawn to.
struct Targets {
    ids: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl Targets {
    fn new(context: &Context, view: &View, samples: u32) -> Result<Self, GpuError> {
        let allowed = context.device.limits().max_texture_dimension_2d;
        if view.width > allowed || view.height > allowed {
            return Err(GpuError::Limit {
                what: "the picture".into(),
                needed: format!("{} x {} pixels", view.width, view.height),
                allowed: format!("{allowed} a side"),
                remedy: "make it smaller, or use the CPU backend",
            });
        }
        let target = |label, format: TextureFormat, usage| {
            let texture = context.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: view.width, height: view.height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: samples,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: TextureUsages::RENDER_ATTACHMENT | usage,
                view_formats: &[],
            });
            texture.create_view(&Default::default())
        };
        let ids = target("triangles seen", ID_FORMAT, TextureUsages::TEXTURE_BINDING);
        let depth = target("depth", DEPTH_FORMAT, TextureUsages::empty());
        context.check()?;
        Ok(Self { ids, depth })
    }

    fn draw_ids(&self, encoder: &mut wgpu::CommandEncoder, context: &Context, scene: &DeviceScene, index: usize) {
        let pipelines = &context.pipelines.samples[index];
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("triangles seen"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.ids,
                depth_slice: None,
                resolve_target: None,
                ops: Operations { load: LoadOp::Clear(wgpu::Color::TRANSPARENT), store: StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                depth_ops: Some(Operations { load: LoadOp::Clear(0.0), store: StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        pass.set_bind_group(0, &scene.scene, &[]);
        pass.set_bind_group(1, &scene.order, &[]);
        let solid = scene.solid_count * 3;
        pass.set_pipeline(&pipelines.solid);
        pass.draw(0..solid, 0..1);
        if scene.triangle_count > scene.solid_count {
            pass.set_pipeline(&pipelines.with_holes);
            pass.draw(solid..scene.triangle_count * 3, 0..1);
        }
    }
}

fn frame_record(scene: &Scene, view: &View, quality: Quality, resident: &DeviceScene) -> Frame {
    let (is_perspective, half) = match view.projection {
        Projection::Perspective { fov_y } => (true, (fov_y * 0.5).tan()),
        Projection::Orthographic { half_height } => (false, half_height),
    };
    let pixel_size = 2.0 * half / view.height as f32;
    let axes = view.world_from_view.matrix3;
    let [right, down] = [axes.x_axis * pixel_size, axes.y_axis * -pixel_size].map(Vec3::from);
    let forward = -Vec3::from(axes.z_axis);
    let corner = right * (-0.5 * view.width as f32) + down * (-0.5 * view.height as f32);
    let (origin, direction) = match is_perspective {
        true => (view.eye(), forward + corner),
        false => (view.eye() + corner, forward.normalize()),
    };
    let mut lights = [LightRecord::default(); MAX_LIGHTS];
    lights[..resident.lights.len()].copy_from_slice(&resident.lights);
    Frame {
        clip_from_world: clip_from_world(scene, view, pixel_size, is_perspective).to_cols_array_2d(),
        origin: origin.to_array(),
        flags: if is_perspective { frame_flags::PERSPECTIVE } else { 0 },
        direction: direction.to_array(),
        near: view.near,
        right: right.to_array(),
        width: view.width,
        down: down.to_array(),
        height: view.height,
        forward: forward.to_array(),
        samples: quality.samples,
        order: quality.order,
        light_count: resident.lights.len() as u32,
        root: resident.boxes.root,
        first_row: 0,
        maps: resident.pictures.maps,
        lights,
    }
}

/// Depth in clip space is reversed: 1 at the near plane, and 0 infinitely far away (perspective) or behind the scene.
fn clip_from_world(scene: &Scene, view: &View, pixel_size: f32, is_perspective: bool) -> Mat4 {
    let view_from_world = Mat4::from(view.world_from_view.inverse());
    let across = 2.0 / (pixel_size * view.width as f32);
    let along = 2.0 / (pixel_size * view.height as f32);
    let (depth, last) = match is_perspective {
        true => (Vec4::new(0.0, 0.0, 0.0, view.near), Vec4::new(0.0, 0.0, -1.0, 0.0)),
        false => {
            let forward = -Vec3::from(view.world_from_view.matrix3.z_axis);
            let middle = (scene.bounds.center() - view.eye()).dot(forward);
            let far = (middle + scene.bounds.diagonal()).max(view.near * 2.0);
            let scale = 1.0 / (far - view.near);
            (Vec4::new(0.0, 0.0, scale, far * scale), Vec4::W)
        }
    };
    let rows = [Vec4::X * across, Vec4::Y * along, depth, last];
    Mat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose() * view_from_world
}
