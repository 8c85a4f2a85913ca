//! Cube maps as OpenEXR lays them out: six square faces, one below the other.

use super::canvas::{self, Radiance};
use catoptric_core::scene::Environment;
use glam::Vec3;

/// The largest side of a face.
const MAX_FACE: u64 = 2048;

/// The faces +X, -X, +Y, -Y, +Z and -Z, each of rows from the top.
pub(super) struct Faces {
    side: usize,
    radiance: Vec<[f32; 3]>,
}

impl Faces {
    /// Black faces for a data window of so many pixels.
    pub(super) fn new(width: u64, height: u64) -> Result<Self, String> {
        if width == 0 || height != 6 * width || width > MAX_FACE {
            return Err(format!(
                "is a cube map of {width} x {height} pixels; six faces of up to {MAX_FACE} x {MAX_FACE} must stand one \
                 below the other: save it so, or as a latitude-longitude map"
            ));
        }
        Ok(Self { side: width as usize, radiance: vec![[0.0; 3]; (width * height) as usize] })
    }

    /// Sets a pixel of the file.
    pub(super) fn set(&mut self, x: usize, y: usize, radiance: [f32; 3]) {
        if let Some(pixel) = self.radiance.get_mut(y * self.side + x) {
            *pixel = radiance.map(Environment::kept);
        }
    }

    /// The cube as a latitude-longitude picture of about the same density, placed as OpenEXR's latitude-longitude
    /// maps are: their middle, +Z, is where environments' is, +x.
    pub(super) fn into_radiance(self, warnings: &mut Vec<String>) -> Result<Radiance, String> {
        canvas::of_cube(self.side, |towards| self.at(Vec3::new(-towards.z, towards.y, towards.x)), warnings)
    }

    /// The radiance from a direction in the cube's axes. Pixels on a face's border lie on the cube's edges.
    fn at(&self, towards: Vec3) -> Vec3 {
        let Vec3 { x, y, z } = towards;
        let size = towards.abs();
        // Columns to the right and rows down, from -1 to 1 (ImfEnvmap.h of OpenEXR).
        let (face, right, down) = if size.x >= size.y && size.x >= size.z {
            if x > 0.0 { (0, z, -y) } else { (1, -z, -y) }
        } else if size.y >= size.z {
            if y > 0.0 { (2, x, -z) } else { (3, x, z) }
        } else if z > 0.0 {
            (4, -x, -y)
        } else {
            (5, x, -y)
        };
        let last = (self.side - 1) as f32;
        let place = |along: f32| (0.5 * (along / size.max_element() + 1.0) * last).clamp(0.0, last);
        let (column, row) = (place(right), place(down));
        canvas::between(column, row, |x, y| {
            let (x, y) = (x.min(self.side - 1), face * self.side + y.min(self.side - 1));
            Vec3::from(self.radiance[y * self.side + x])
        })
    }
}
