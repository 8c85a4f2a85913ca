//! Sums over the faces of objects, which tell whether they enclose something.

use super::Scene;
use glam::{DVec3, Vec3};

/// The sum of the areas of an open object's faces, as vectors, is larger than this share of the sum of their sizes.
const OPEN: f64 = 1e-3;

/// The same of a sheet, as a pane or a dome, beside which nothing closes it.
const SHEET: f64 = 0.5;

/// Sums over faces, turned as their normals say.
#[derive(Clone, Copy, Debug, Default)]
pub struct FaceSums {
    /// The sum of their areas, doubled, as vectors: nothing where they enclose something.
    pub area: DVec3,
    /// The sum of the lengths of these vectors.
    pub size: f64,
    /// Six times the volume within them; negative where they are turned inside out.
    pub volume: f64,
}

impl FaceSums {
    /// With those of an object, too.
    #[must_use]
    pub fn with(mut self, scene: &Scene, object: u32) -> Self {
        let of = &scene.objects[object as usize];
        let middle = scene.bounds.center().as_dvec3();
        for triangle in of.triangles.clone() {
            let corners = scene.triangles[triangle as usize];
            let [a, b, c] = corners.map(|vertex| scene.positions[vertex as usize].as_dvec3() - middle);
            let outwards: Vec3 = corners.iter().map(|vertex| scene.normals[*vertex as usize]).sum();
            let area = (b - a).cross(c - a);
            let area = if area.dot(outwards.as_dvec3()) < 0.0 { -area } else { area };
            self.area += area;
            self.size += area.length();
            self.volume += a.dot(area);
        }
        self
    }

    /// With other ones, too.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self { area: self.area + other.area, size: self.size + other.size, volume: self.volume + other.volume }
    }

    /// The thickness of a slab of as much volume and surface; 0 where they do not enclose anything.
    pub fn thickness(&self) -> f64 {
        if self.are_open() || self.size == 0.0 { 0.0 } else { 2.0 * self.volume.abs() / (3.0 * self.size) }
    }

    /// Returns true if they do not enclose anything.
    pub fn are_open(&self) -> bool {
        self.area.length() > OPEN * self.size
    }

    /// Returns true if they are a sheet, flat or bent less than half round.
    pub fn are_sheet(&self) -> bool {
        self.area.length() > SHEET * self.size
    }
}
