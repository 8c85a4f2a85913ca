//! Outgoing rays as lines with neighbours, in single precision, for nearest-ray searches.

use glam::Vec3;

/// Rays of one path, and which are neighbours in the ray map.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    origins: Vec<Vec3>,
    directions: Vec<Vec3>,
    /// The end of each ray's neighbours in `neighbours`.
    neighbour_ends: Vec<u32>,
    neighbours: Vec<u32>,
}

/// Offset of a point from a ray.
#[derive(Clone, Copy, Debug)]
pub struct Offset {
    /// Distance along the ray, negative behind its origin.
    pub along: f32,
    /// Vector from the nearest point of the line to the point.
    pub across: Vec3,
}

impl Lines {
    /// Rays with their neighbours.
    pub fn new(rays: impl Iterator<Item = (Vec3, Vec3)>, neighbours: &[Vec<u32>]) -> Self {
        let mut lines = Self::default();
        for (origin, direction) in rays {
            lines.origins.push(origin);
            lines.directions.push(direction);
        }
        for list in neighbours {
            lines.neighbours.extend(list);
            lines.neighbour_ends.push(lines.neighbours.len() as u32);
        }
        lines
    }

    /// Number of rays.
    pub fn len(&self) -> usize {
        self.origins.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.origins.is_empty()
    }

    /// The neighbours of a ray.
    #[inline]
    pub fn neighbours(&self, ray: u32) -> &[u32] {
        let start = if ray == 0 { 0 } else { self.neighbour_ends[ray as usize - 1] };
        &self.neighbours[start as usize..self.neighbour_ends[ray as usize] as usize]
    }

    /// Offset of a point from a ray.
    #[inline]
    pub fn offset(&self, ray: u32, point: Vec3) -> Offset {
        let direction = self.directions[ray as usize];
        let relative = point - self.origins[ray as usize];
        let along = relative.dot(direction);
        Offset { along, across: relative - direction * along }
    }

    /// Memory of the arrays.
    pub fn byte_count(&self) -> usize {
        self.len() * (2 * size_of::<Vec3>() + 4) + self.neighbours.len() * 4
    }
}
