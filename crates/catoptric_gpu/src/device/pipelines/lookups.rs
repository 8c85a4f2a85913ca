//! Tables in which light at mirrors and glass is looked up, as shaders read them.

use super::bindings::{array_texture, table, texture};
use wgpu::{BindingType, SamplerBindingType, TextureSampleType};

/// The bindings of light fields, behind those of the environment maps of objects that lie in no region.
pub(crate) const FIELDS: [(u32, BindingType); 4] = [
    table(2),
    array_texture(3, TextureSampleType::Float { filterable: true }),
    array_texture(4, TextureSampleType::Sint),
    (5, BindingType::Sampler(SamplerBindingType::Filtering)),
];

/// The bindings of layered environment maps.
pub(crate) const LAYERS: [(u32, BindingType); 4] =
    [table(0), table(1), texture(2, TextureSampleType::Float { filterable: false }, false), table(3)];
