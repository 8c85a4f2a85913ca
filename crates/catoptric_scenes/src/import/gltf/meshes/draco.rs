//! KHR_draco_mesh_compression: triangles and attributes of a primitive in one compressed stream.

use super::super::schema::Draco;
use super::super::source::Source;
use catoptric_core::error::SceneError;
use draco_core::{DecodeLimits, DecoderBuffer, FaceIndex, Mesh, MeshDecoder};
use std::collections::BTreeMap;

pub(super) const EXTENSION: &str = "KHR_draco_mesh_compression";

/// Ceilings for one stream: a few hundred bytes may stand for millions of points.
const MAX_POINTS: u64 = 16 << 20;
const MAX_DECODED_BYTES: u64 = 512 << 20;

/// A decompressed mesh.
pub(super) struct DecodedMesh {
    /// By name in glTF: numbers a vertex, and the numbers.
    pub(super) attributes: BTreeMap<String, (usize, Vec<f32>)>,
    pub(super) indices: Vec<u32>,
}

pub(super) fn decode(source: &Source<'_>, compressed: &Draco, owner: &str) -> Result<DecodedMesh, SceneError> {
    let field = || format!("{owner}.extensions.{EXTENSION}");
    let view = compressed.buffer_view.ok_or_else(|| source.invalid(field(), "bufferView is missing"))?;
    let bytes = source.view(view, &|| format!("{}.bufferView", field()))?;
    let limits = DecodeLimits::default()
        .with_max_points(MAX_POINTS)
        .with_max_faces(MAX_POINTS * 2)
        .with_max_decoded_bytes(MAX_DECODED_BYTES);
    let mut buffer = DecoderBuffer::new(bytes).with_limits(limits);
    let mut mesh = Mesh::new();
    MeshDecoder::new()
        .decode(&mut buffer, &mut mesh)
        .map_err(|error| source.invalid(field(), format!("cannot be decompressed: {error}")))?;
    source.spend(mesh.num_faces() as u64 * 12, &field)?;
    let indices =
        (0..mesh.num_faces()).flat_map(|face| mesh.face(FaceIndex(face as u32)).map(|point| point.0)).collect();
    let mut attributes = BTreeMap::new();
    for (name, &id) in &compressed.attributes {
        let Some(attribute) = mesh.attribute_by_unique_id(id) else {
            let problem = format!("{id}; there is no such attribute in the stream");
            return Err(source.invalid(format!("{}.attributes.{name}", field()), problem));
        };
        let width = usize::from(attribute.num_components());
        source.spend(mesh.num_points() as u64 * width as u64 * 4, &field)?;
        let mut numbers = attribute.read_f32s(mesh.num_points(), width);
        if let Some(scale) = fraction_scale(name, attribute) {
            numbers.iter_mut().for_each(|number| *number = (*number * scale).max(-1.0));
        }
        attributes.insert(name.clone(), (width, numbers));
    }
    Ok(DecodedMesh { attributes, indices })
}

/// The factor from an attribute's integers to fractions; `None` for floats and plain integers.
fn fraction_scale(name: &str, attribute: &draco_core::PointAttribute) -> Option<f32> {
    use draco_core::DataType;
    let always = name.starts_with("COLOR_") || name.starts_with("WEIGHTS_");
    if !(always || attribute.normalized()) {
        return None;
    }
    match attribute.data_type() {
        DataType::Int8 => Some(1.0 / 127.0),
        DataType::Uint8 => Some(1.0 / 255.0),
        DataType::Int16 => Some(1.0 / 32767.0),
        DataType::Uint16 => Some(1.0 / 65535.0),
        _ => None,
    }
}
