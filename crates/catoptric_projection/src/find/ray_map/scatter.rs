//! Scattering of a ray by a specular object: the rules that rays with and without derivatives share.

use catoptric_core::scene::{Role, Scene};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use catoptric_engine::optics::path::manifold::SpecularSurfaces;
use catoptric_engine::optics::step::{crossed_medium, medium_after};
use glam::{DVec3, Vec3};

/// The scene that a ray map's rays are traced through.
#[derive(Clone, Copy)]
pub struct Specular<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The hierarchy over its reflectors and lenses alone.
    pub tracer: &'a Tracer,
    /// Their exact surfaces.
    pub surfaces: &'a SpecularSurfaces<'a>,
    /// The maximum number of bounces of a path.
    pub order: u32,
}

/// A ray's arrival at a specular object.
#[derive(Clone, Copy, Debug)]
pub struct Scattering {
    /// True if it comes from the outer side.
    pub outside: bool,
    /// Index of refraction of the object over that of its surroundings.
    pub index: f64,
    /// Index of refraction of the medium that the ray has run through.
    pub crossed: f64,
    lens: bool,
}

impl Scattering {
    /// Scattering of a ray at this cosine between its direction and the outer normal, which was taken to run through
    /// `medium`. None on the blind side of mirrors with one side.
    #[inline]
    pub fn new(specular: &Specular<'_>, object: u32, cosine: f64, medium: f64) -> Option<Self> {
        let outside = cosine <= 0.0;
        if outside && specular.scene.objects[object as usize].inside {
            return None;
        }
        let lens = specular.scene.role_of(object) == Role::Lens;
        let index = specular.surfaces.index_of(object);
        let crossed = crossed_medium(lens, outside, index, medium);
        Some(Self { outside, index, crossed, lens })
    }

    /// Index of refraction of the medium after the bounce; returns `None` if the ray cannot go on like that.
    #[inline]
    pub fn medium_after(&self, kind: BounceKind) -> Option<f64> {
        let goes_on = self.lens || kind == BounceKind::Reflect;
        goes_on.then(|| medium_after(kind, self.outside, self.index, self.crossed, 1.0))
    }
}

/// True if a ray cannot meet an object after its last bounce: none leaves a convex mirror and comes back. Between the
/// corners of a mesh shading normals send rays where the flat triangles are.
#[inline]
pub fn is_spurious(surfaces: &SpecularSurfaces<'_>, last: Bounce, outside: bool, object: u32) -> bool {
    object == last.object && outside && last.kind == BounceKind::Reflect && surfaces.is_convex(object)
}

/// A point off a flat surface on the side that `direction` leaves to, as far as positions are rounded.
#[inline]
pub fn departure(position: DVec3, geometric_normal: DVec3, direction: DVec3) -> Vec3 {
    let offset = 16.0 * f64::from(f32::EPSILON) * position.abs().max_element();
    (position + geometric_normal * offset.copysign(direction.dot(geometric_normal))).as_vec3()
}
