//! The copying of tables and pictures to a device.

use crate::device::context::Context;
use crate::device::pipelines::group;
use crate::error::GpuError;
use crate::hierarchy::Hierarchy;
use crate::layout::TEXEL_ROW;
use bytemuck::Pod;
use wgpu::util::DeviceExt;
use wgpu::{BindGroup, BindingResource, Buffer, BufferUsages, TextureFormat, TextureUsages};

/// The most bytes that are sent at a time.
const BYTES_AT_ONCE: usize = 1 << 26;

/// The size of a picture that holds so many texels in rows of [`TEXEL_ROW`]; devices allow no empty ones.
pub(crate) fn size_in_rows(count: usize) -> [u32; 2] {
    [count.clamp(1, TEXEL_ROW) as u32, count.div_ceil(TEXEL_ROW).max(1) as u32]
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
    pub(super) fn buffer(&mut self, what: &str, numbers: &[u32]) -> Result<Buffer, GpuError> {
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

/// Writes texels row by row, from a row of a layer on.
pub(super) fn write_rows<T: Pod>(queue: &wgpu::Queue, texture: &wgpu::Texture, [first, layer]: [u32; 2], texels: &[T]) {
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
