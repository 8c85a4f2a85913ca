//! Stereolithography files (`.stl`), binary and as text: triangles alone.

use super::model::Mesh;
use catoptric_core::error::SceneError;
use catoptric_core::scene::model::Model;
use glam::Vec3;
use std::collections::HashMap;

/// The header and the number of triangles of a binary file.
const HEADER_BYTES: usize = 84;
/// A triangle of a binary file: its normal and corners in single precision, and two bytes more.
const TRIANGLE_BYTES: usize = 50;

/// Reads a mesh from memory; `name` is for messages.
///
/// # Errors
/// [`SceneError`] when the file is neither binary STL of the length that it promises nor text with whole triangles.
pub(in super::super) fn from_slice(name: &str, bytes: &[u8]) -> Result<Model, SceneError> {
    let count = bytes.get(HEADER_BYTES - 4..).and_then(|rest| rest.first_chunk::<4>());
    let count = count.map_or(0, |count| u32::from_le_bytes(*count) as usize);
    let expected = HEADER_BYTES + count * TRIANGLE_BYTES;
    // Binary files may begin with the word of those that are text: their length and further words decide.
    let has_facets = || bytes.windows(5).any(|word| word.eq_ignore_ascii_case(b"facet"));
    let is_text = bytes.trim_ascii_start().starts_with(b"solid") && bytes.len() != expected && has_facets();
    let corners = if is_text {
        text_corners(bytes).map_err(|problem| SceneError::invalid(name, "text", problem))?
    } else if bytes.len() < expected || bytes.len() < HEADER_BYTES {
        let problem = format!("{} bytes; a file of {count} triangles has {expected}", bytes.len());
        return Err(SceneError::invalid(name, "binary STL", problem));
    } else {
        let triangles = bytes[HEADER_BYTES..expected].chunks_exact(TRIANGLE_BYTES);
        let number = |bytes: &[u8]| bytes.first_chunk().map_or(f32::NAN, |bytes| f32::from_le_bytes(*bytes));
        let vertex = |bytes: &[u8]| Vec3::new(number(bytes), number(&bytes[4..]), number(&bytes[8..]));
        triangles.flat_map(|bytes| [12, 24, 36].map(|begin| vertex(&bytes[begin..]))).collect()
    };
    let mut numbers: HashMap<[u32; 3], u32> = HashMap::new();
    let mut positions = Vec::new();
    let corners: Vec<u32> = corners
        .into_iter()
        .map(|corner| {
            // Zeros of both signs are one place.
            let corner = corner + Vec3::ZERO;
            *numbers.entry(corner.to_array().map(f32::to_bits)).or_insert_with(|| {
                positions.push(corner.as_dvec3());
                positions.len() as u32 - 1
            })
        })
        .collect();
    let triangles = corners.as_chunks::<3>().0.to_vec();
    Ok(Mesh { positions, triangles, ..Mesh::default() }.into_model(name))
}

/// The corners in the lines that begin with `vertex`.
fn text_corners(bytes: &[u8]) -> Result<Vec<Vec3>, String> {
    let text = String::from_utf8_lossy(bytes);
    let mut corners = Vec::new();
    for (index, line) in text.split(['\n', '\r']).enumerate() {
        let mut words = line.split_ascii_whitespace();
        if !words.next().is_some_and(|word| word.eq_ignore_ascii_case("vertex")) {
            continue;
        }
        let mut number = || words.next().and_then(|word| word.parse::<f32>().ok());
        let corner = number().zip(number()).zip(number()).map(|((x, y), z)| Vec3::new(x, y, z));
        corners.push(corner.ok_or_else(|| format!("line {}: a vertex has three numbers", index + 1))?);
    }
    if corners.len().is_multiple_of(3) {
        Ok(corners)
    } else {
        Err(format!("{} corners: the last triangle is not whole", corners.len()))
    }
}
