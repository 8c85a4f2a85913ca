//! Tables, records and pictures as shaders read and write them, and groups of them.

use super::formats::COLOR_FORMAT;
use wgpu::{BindGroup, BindingResource, BindingType, BufferBindingType, ShaderStages};
use wgpu::{TextureSampleType, TextureViewDimension};

/// A table, as it is read.
pub(crate) const fn table(binding: u32) -> (u32, BindingType) {
    texture(binding, TextureSampleType::Uint, false)
}

/// The colours, as they are written.
pub(crate) fn written(binding: u32) -> (u32, BindingType) {
    let access = wgpu::StorageTextureAccess::WriteOnly;
    (binding, BindingType::StorageTexture { access, format: COLOR_FORMAT, view_dimension: TextureViewDimension::D2 })
}

/// A record.
pub(crate) const fn uniform(has_dynamic_offset: bool) -> BindingType {
    BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset, min_binding_size: None }
}

pub(crate) const fn storage(binding: u32) -> (u32, BindingType) {
    buffer(binding, true)
}

/// A storage buffer that is written, too.
pub(crate) fn written_storage(binding: u32) -> (u32, BindingType) {
    buffer(binding, false)
}

const fn buffer(binding: u32, read_only: bool) -> (u32, BindingType) {
    let ty = BufferBindingType::Storage { read_only };
    (binding, BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None })
}

pub(crate) const fn texture(binding: u32, sample_type: TextureSampleType, multisampled: bool) -> (u32, BindingType) {
    (binding, BindingType::Texture { sample_type, view_dimension: TextureViewDimension::D2, multisampled })
}

/// Several pictures of one size.
pub(crate) const fn array_texture(binding: u32, sample_type: TextureSampleType) -> (u32, BindingType) {
    let view_dimension = TextureViewDimension::D2Array;
    (binding, BindingType::Texture { sample_type, view_dimension, multisampled: false })
}

pub(crate) fn layout(
    device: &wgpu::Device,
    label: &str,
    visibility: ShaderStages,
    bindings: &[(u32, BindingType)],
) -> wgpu::BindGroupLayout {
    let entry =
        |&(binding, ty): &(u32, BindingType)| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    let entries: Vec<_> = bindings.iter().map(entry).collect();
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
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
