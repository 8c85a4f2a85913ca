//! The paper's search: uphill to where normal and half vector agree best.

use super::{ImagePlace, MAX_MOVES, ReflectorSearch, TexelCell};
use crate::find::virtual_objects::Reflector;
use crate::find::work;
use glam::{Vec2, Vec3};

/// Strides are halved down to this share of a texel: between texels positions and normals are interpolated, as graphics
/// hardware does where it reads textures. Chosen, not measured.
const FINEST: f32 = 1.0 / 16.0;

/// Work of the law at a place between four texels.
const WORK_A_PLACE: u64 = 2;

/// The ways to the eight places around one.
const AROUND: [Vec2; 8] = [
    Vec2::new(-1.0, -1.0),
    Vec2::new(0.0, -1.0),
    Vec2::new(1.0, -1.0),
    Vec2::new(-1.0, 0.0),
    Vec2::new(1.0, 0.0),
    Vec2::new(-1.0, 1.0),
    Vec2::new(0.0, 1.0),
    Vec2::new(1.0, 1.0),
];

impl ReflectorSearch {
    /// The cell of the place about a first guess where the product of normal and half vector is greatest, with that
    /// place as its zero.
    pub(super) fn at_maximum(&self, reflector: &Reflector<'_>, start: &TexelCell, point: Vec3) -> Option<TexelCell> {
        let mut place = ImagePlace { face: start.face, at: start.low + 0.5 };
        let mut least = self.miss_at(reflector, &place, point);
        let mut stride = 0.5 * self.candidates.stride as f32;
        while stride >= FINEST {
            // Each move makes the miss smaller, so this ends; a bound all the same.
            for _ in 0..MAX_MOVES {
                let mut best = (least, place);
                for way in AROUND {
                    let moved = self.image.settled(ImagePlace { face: place.face, at: place.at + way * stride });
                    let miss = self.miss_at(reflector, &moved, point);
                    if miss < best.0 {
                        best = (miss, moved);
                    }
                }
                if best.0 >= least {
                    break;
                }
                (least, place) = best;
            }
            stride *= 0.5;
        }
        let cell = self.cell(reflector, &place, point)?;
        Some(TexelCell { zero: place.at - cell.low, ..cell })
    }

    /// The squared distance between half vector and normal at a place between four texels, which is least where their
    /// product is greatest. Infinite where these are not one piece of surface.
    fn miss_at(&self, reflector: &Reflector<'_>, place: &ImagePlace, point: Vec3) -> f32 {
        work::add(WORK_A_PLACE);
        let Some(low) = self.whole_at(place) else { return f32::INFINITY };
        let at = place.at - place.at.floor();
        let weights = [(1.0 - at.x) * (1.0 - at.y), at.x * (1.0 - at.y), (1.0 - at.x) * at.y, at.x * at.y];
        let (mut position, mut normal, mut origin) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
        for (index, weight) in self.image.corners(low).into_iter().zip(weights) {
            let texel = &self.image.texels[index];
            position += texel.position * weight;
            normal += texel.normal * weight;
            origin += self.origin(reflector, index) * weight;
        }
        let half = self.law.half(position, (origin - position).normalize(), point);
        let miss = half.unit.distance_squared(normal.normalize() * self.law.side);
        if miss.is_nan() { f32::INFINITY } else { miss }
    }
}
