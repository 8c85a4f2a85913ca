//! Cubes that are unfolded in a picture without saying so: strips and crosses of six square faces.

use super::canvas::{self, Radiance};
use glam::Vec3;

/// Panoramas are twice as wide as high, but for a pixel or a trimmed border.
const PANORAMA_RATIOS: std::ops::RangeInclusive<f64> = 1.9..=2.1;

/// A way of unfolding: columns and rows of faces, and where the faces +X, -X, +Y, -Y, +Z and -Z stand.
struct Layout {
    columns: usize,
    rows: usize,
    faces: [[usize; 2]; 6],
    /// The last face stands on its head, as in light probes' upright crosses (Debevec 1998).
    turns_last: bool,
}

const LAYOUTS: [Layout; 4] = [
    Layout { columns: 6, rows: 1, faces: [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [5, 0]], turns_last: false },
    Layout { columns: 1, rows: 6, faces: [[0, 0], [0, 1], [0, 2], [0, 3], [0, 4], [0, 5]], turns_last: false },
    Layout { columns: 4, rows: 3, faces: [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]], turns_last: false },
    Layout { columns: 3, rows: 4, faces: [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [1, 3]], turns_last: true },
];

/// The panorama of a picture that is an unfolded cube; other pictures as they are, with a warning where they are no
/// panorama.
pub(super) fn unfolded(picture: Radiance, warnings: &mut Vec<String>) -> Result<Radiance, String> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let fits = |layout: &&Layout| {
        let side = width / layout.columns;
        side > 0 && width == side * layout.columns && height == side * layout.rows
    };
    if let Some(layout) = LAYOUTS.iter().find(|layout| fits(layout) && has_empty_corners(&picture, layout)) {
        let name = if layout.columns * layout.rows == 6 { "strip" } else { "cross" };
        warnings.push(format!("{width} x {height} pixels are read as a cube of six faces, unfolded to a {name}"));
        return panorama(&picture, layout, warnings);
    }
    if !PANORAMA_RATIOS.contains(&(width as f64 / height as f64)) {
        warnings.push(format!(
            "{width} x {height} pixels are stretched over the sphere: a panorama is twice as wide as high (a cube may \
             be a strip of 6:1 or 1:6, or a cross of 4:3 or 3:4)"
        ));
    }
    Ok(picture)
}

/// Returns true if the squares without a face are all of one colour, as far as compression leaves them: a photograph
/// of these proportions is no cross.
fn has_empty_corners(picture: &Radiance, layout: &Layout) -> bool {
    const SAME: f32 = 0.02;
    let (width, side) = (picture.width as usize, picture.width as usize / layout.columns);
    let is_face = |x: usize, y: usize| layout.faces.contains(&[x / side, y / side]);
    // The upper left square has a face in strips alone, which have no others.
    let first = Vec3::from(picture.radiance[0]);
    picture.radiance.iter().enumerate().all(|(index, radiance)| {
        is_face(index % width, index / width) || (Vec3::from(*radiance) - first).abs().max_element() <= SAME
    })
}

/// The cube as a panorama of about the same density. Faces show what is seen from the middle, upright, +X to the right
/// of +Z; +Z is towards z and +X towards -x, as web renderers place them.
fn panorama(picture: &Radiance, layout: &Layout, warnings: &mut Vec<String>) -> Result<Radiance, String> {
    let side = picture.width as usize / layout.columns;
    canvas::of_cube(side, |towards| at(picture, layout, side, towards), warnings)
}

/// The radiance from a direction, between the middles of a face's pixels.
fn at(picture: &Radiance, layout: &Layout, side: usize, towards: Vec3) -> Vec3 {
    let Vec3 { x, y, z } = Vec3::new(-towards.x, towards.y, towards.z);
    let size = towards.abs();
    // Columns to the right and rows down, from -1 to 1 (OpenGL 4.6, table 8.19).
    let (face, right, down) = if size.x >= size.y && size.x >= size.z {
        if x > 0.0 { (0, -z, -y) } else { (1, z, -y) }
    } else if size.y >= size.z {
        if y > 0.0 { (2, x, z) } else { (3, x, -z) }
    } else if z > 0.0 {
        (4, x, -y)
    } else {
        (5, -x, -y)
    };
    let turn = if face == 5 && layout.turns_last { -1.0 } else { 1.0 };
    let last = (side - 1) as f32;
    let place = |along: f32| (0.5 * (turn * along / size.max_element() + 1.0) * side as f32 - 0.5).clamp(0.0, last);
    let (column, row) = (place(right), place(down));
    let [first_column, first_row] = layout.faces[face].map(|square| square * side);
    canvas::between(column, row, |x, y| {
        let (x, y) = (first_column + x.min(side - 1), first_row + y.min(side - 1));
        Vec3::from(picture.radiance[y * picture.width as usize + x])
    })
}
