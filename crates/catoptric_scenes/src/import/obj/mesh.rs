//! Triangles of the faces of `.obj` files.

use super::super::mesh_file::PolygonDivider;
use super::geometry::{Corner, Face, Geometry, NONE, Part};
use catoptric_core::framebuffer::linear_from_srgb;
use catoptric_core::scene::model::Primitive;
use glam::{DVec3, Vec2};
use std::collections::HashMap;

/// Leaves out corners' texture coordinates and normals, and faces, that point to what is not there.
pub(super) fn check_indices(geometry: &mut Geometry) {
    let Geometry { positions, uvs, normals, parts, warnings, .. } = geometry;
    let is_there = |corner: &Corner| positions.get(corner.position as usize).is_some_and(|place| place.is_finite());
    for part in parts {
        let (mut corners, mut faces) = (Vec::with_capacity(part.corners.len()), Vec::with_capacity(part.faces.len()));
        let mut begin = 0;
        for face in &part.faces {
            let of_face = &part.corners[begin..face.end as usize];
            begin = face.end as usize;
            if !of_face.iter().all(is_there) {
                warnings.add(face.line, || "a face is left out: it names a vertex that is not there".into());
                continue;
            }
            let known = |index: u32, count: usize| if (index as usize) < count { index } else { NONE };
            corners.extend(of_face.iter().map(|corner| Corner {
                uv: known(corner.uv, uvs.len()),
                normal: known(corner.normal, normals.len()),
                ..*corner
            }));
            faces.push(Face { end: corners.len() as u32, ..*face });
        }
        (part.corners, part.faces) = (corners, faces);
    }
}

/// Gives corners without a normal one, if any face is smooth or other corners of its part have one: the mean of the
/// faces of its smoothing group at its vertex, by their areas, or that of its face.
pub(super) fn complete_normals(geometry: &mut Geometry) {
    let Geometry { positions, normals, parts, .. } = geometry;
    let mut sums: HashMap<(u32, u32), DVec3> = HashMap::new();
    for (face, corners) in parts.iter().flat_map(faces).filter(|(face, _)| face.smoothing != 0) {
        let normal = area_normal(positions, corners);
        for corner in corners {
            *sums.entry((corner.position, face.smoothing)).or_default() += normal;
        }
    }
    let mut of_groups: HashMap<(u32, u32), u32> = HashMap::new();
    for part in parts {
        let has_normals = part.corners.iter().any(|corner| corner.normal != NONE);
        if !(has_normals || part.faces.iter().any(|face| face.smoothing != 0)) {
            continue;
        }
        let mut begin = 0;
        for face in &part.faces {
            let corners = &mut part.corners[begin..face.end as usize];
            begin = face.end as usize;
            let mut add = |normal: DVec3| {
                normals.push(normal.as_vec3());
                normals.len() as u32 - 1
            };
            let mut of_face = None;
            let flat = area_normal(positions, corners).normalize_or_zero();
            for corner in corners.iter_mut().filter(|corner| corner.normal == NONE) {
                let key = (corner.position, face.smoothing);
                corner.normal = match sums.get(&key).map(|sum| sum.normalize_or_zero()) {
                    Some(mean) if mean != DVec3::ZERO => *of_groups.entry(key).or_insert_with(|| add(mean)),
                    _ => *of_face.get_or_insert_with(|| add(flat)),
                };
            }
        }
    }
}

/// The faces of a part with their corners.
fn faces(part: &Part) -> impl Iterator<Item = (&Face, &[Corner])> {
    let mut begin = 0;
    part.faces.iter().map(move |face| {
        let corners = &part.corners[begin..face.end as usize];
        begin = face.end as usize;
        (face, corners)
    })
}

/// The normal of a polygon, as long as twice its area (Newell's).
fn area_normal(positions: &[DVec3], corners: &[Corner]) -> DVec3 {
    let place = |corner: &Corner| positions[corner.position as usize];
    let origin = corners.first().map(place).unwrap_or_default();
    corners.windows(2).map(|pair| (place(&pair[0]) - origin).cross(place(&pair[1]) - origin)).sum()
}

/// The triangles of a part, about a centre; without a material.
pub(super) fn primitive(geometry: &Geometry, part: &Part, center: DVec3, divider: &mut PolygonDivider) -> Primitive {
    let mut vertices: Vec<Corner> = Vec::new();
    let mut numbers: HashMap<Corner, u32> = HashMap::with_capacity(part.corners.len());
    let mut triangles = Vec::new();
    let mut polygon = Vec::new();
    for (_, corners) in faces(part) {
        polygon.clear();
        polygon.extend(corners.iter().map(|corner| geometry.positions[corner.position as usize]));
        for triangle in divider.divide(&polygon).chunks_exact(3) {
            triangles.push([triangle[0], triangle[1], triangle[2]].map(|corner| {
                let corner = corners[corner as usize];
                *numbers.entry(corner).or_insert_with(|| {
                    vertices.push(corner);
                    vertices.len() as u32 - 1
                })
            }));
        }
    }
    let of_each = |is_there: fn(&Corner) -> bool| vertices.iter().any(is_there).then_some(vertices.iter());
    // The origin of texture coordinates is the lower left corner of the picture.
    let uv = |corner: &Corner| geometry.uvs.get(corner.uv as usize).map_or(Vec2::Y, |uv| Vec2::new(uv.x, 1.0 - uv.y));
    let uvs = of_each(|corner| corner.uv != NONE).map(|corners| corners.map(uv).collect());
    let normal = |corner: &Corner| geometry.normals.get(corner.normal as usize).copied().unwrap_or_default();
    let normals = of_each(|corner| corner.normal != NONE).map(|corners| corners.map(normal).collect());
    let color = |corner: &Corner| geometry.colors.get(corner.position as usize).copied().unwrap_or([1.0; 3]);
    let has_colors = !geometry.colors.is_empty();
    let colors = vertices.iter().filter(|_| has_colors).map(|corner| {
        let [red, green, blue] = color(corner);
        [red, green, blue, 1.0]
    });
    Primitive {
        positions: vertices.iter().map(|v| (geometry.positions[v.position as usize] - center).as_vec3()).collect(),
        normals: normals.unwrap_or_default(),
        uvs: [uvs.unwrap_or_default(), Vec::new()],
        colors: colors.collect(),
        triangles,
        ..Primitive::default()
    }
}

/// Makes vertex colours linear: programs write what they show, from 0 to 1 or to 255.
pub(super) fn make_linear(colors: &mut [[f32; 3]]) {
    let is_byte = colors.iter().flatten().any(|value| *value > 1.0);
    let scale = if is_byte { 1.0 / 255.0 } else { 1.0 };
    for value in colors.iter_mut().flatten() {
        *value = if value.is_finite() { linear_from_srgb((*value * scale).clamp(0.0, 1.0)) } else { 1.0 };
    }
}
