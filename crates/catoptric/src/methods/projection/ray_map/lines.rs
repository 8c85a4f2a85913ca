//! Outgoing rays as lines with neighbours: what nearest-ray searches need, in single precision.

use glam::Vec3;

/// Rays of one path, and which are neighbours in the ray map.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    origins: Vec<Vec3>,
    directions: Vec<Vec3>,
    /// Where the neighbours of each ray end in `neighbours`.
    neighbour_ends: Vec<u32>,
    neighbours: Vec<u32>,
    /// The sine of the angle to each neighbour.
    sines: Vec<f32>,
}

/// Where a point lies as seen from a ray.
#[derive(Clone, Copy, Debug)]
pub struct Offset {
    /// Distance along the ray, negative behind its origin.
    pub along: f32,
    /// From the nearest point of the line to the point.
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
        for (ray, list) in neighbours.iter().enumerate() {
            let direction = lines.directions[ray];
            lines.sines.extend(list.iter().map(|&other| direction.cross(lines.directions[other as usize]).length()));
        }
        lines
    }

    /// How many rays there are.
    pub fn len(&self) -> usize {
        self.origins.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.origins.is_empty()
    }

    /// The neighbours of a ray.
    #[inline]
    pub fn neighbours(&self, ray: u32) -> &[u32] {
        let start = if ray == 0 { 0 } else { self.neighbour_ends[ray as usize - 1] };
        &self.neighbours[start as usize..self.neighbour_ends[ray as usize] as usize]
    }

    /// Where a point lies as seen from a ray.
    #[inline]
    pub fn offset(&self, ray: u32, point: Vec3) -> Offset {
        let direction = self.directions[ray as usize];
        let relative = point - self.origins[ray as usize];
        let along = relative.dot(direction);
        Offset { along, across: relative - direction * along }
    }

    /// The neighbours of a ray, each with the sine of the angle between the two.
    #[inline]
    pub fn neighbours_with_sines(&self, ray: u32) -> impl Iterator<Item = (u32, f32)> {
        let start = if ray == 0 { 0 } else { self.neighbour_ends[ray as usize - 1] as usize };
        let range = start..self.neighbour_ends[ray as usize] as usize;
        self.neighbours[range.clone()].iter().copied().zip(self.sines[range].iter().copied())
    }

    /// Whether no neighbour of a ray is nearer to the point: those that begin beyond the point do not count, and of
    /// two at the same distance the first wins.
    #[inline]
    pub fn is_local_minimum(&self, ray: u32, own: &Offset, point: Vec3) -> bool {
        let own2 = own.across.length_squared();
        !self.neighbours(ray).iter().any(|&neighbour| {
            let other = self.offset(neighbour, point);
            let other2 = other.across.length_squared();
            (other2 < own2 || (other2 == own2 && neighbour < ray)) && other.along > 0.0
        })
    }

    /// Memory of the arrays.
    pub fn byte_count(&self) -> usize {
        self.len() * (2 * size_of::<Vec3>() + 4) + self.neighbours.len() * 8
    }
}
