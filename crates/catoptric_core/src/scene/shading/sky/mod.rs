//! Light from infinity, and of surfaces that emit it, on surfaces before which other things stand.

mod corners;
mod emitters;
mod emitting;
mod find;
mod gather;
mod neighbours;
mod refine;
mod scattered;
mod shares;
mod suns;

use super::environment::LightMap;
use super::environment::map::Irradiance;
use crate::scene::Light;
pub use emitters::Emitters;
use glam::{Vec2, Vec3};
use shares::{Arriving, Node, SurfaceShares};

/// The environment and the emitters of a scene as its surfaces see them, for the light that they scatter.
///
/// Suns, which are small and bright, are seen or not from each point that is shaded, as lights are: their shadows have
/// edges. Of the rest of the sky each surface sees a share of each colour, which is known about its corners and, where
/// it changes most, at points between them (after the adaptive meshes of Ward, Rubinstein, Clear 1988 and of Yuksel,
/// Keyser, House 2010, Mesh colors); the light of emitters is known at the same points. Corners of fine meshes share
/// their rays with their neighbours. Light that surfaces scatter onto each other is found at the same points
/// afterwards.
#[derive(Debug)]
pub struct Sky {
    suns: Vec<Light>,
    rest: Irradiance,
    shares: SurfaceShares,
    emitters: Option<Emitters>,
    is_scattered: bool,
}

impl Sky {
    /// The surfaces that emit light, if there are any.
    pub fn emitters(&self) -> Option<&Emitters> {
        self.emitters.as_ref()
    }

    /// The brightest parts of it, as lights without a place.
    pub fn suns(&self) -> &[Light] {
        &self.suns
    }

    /// The irradiance by normals of surfaces that see all of it beside its suns, in directions of the environment's
    /// picture.
    pub fn rest(&self) -> LightMap<'_> {
        self.rest.map()
    }

    /// The scene's triangles, then parts of those that are divided into four: for each the places of its corners' light
    /// in [`Self::arriving`], and the first of its parts, those at its corners before the middle one; 0: it has none.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = [u32; 4]> + '_ {
        self.shares.nodes.iter().map(|&Node { corners: [a, b, c], parts }| [a, b, c, parts])
    }

    /// The share of the light from infinity that arrives at a place, and the irradiance by surfaces: each on the side
    /// of the normals, and on the other.
    pub fn arriving(&self) -> impl ExactSizeIterator<Item = [[Vec3; 2]; 2]> + '_ {
        self.shares.arriving.iter().map(|&Arriving { sky, by_surfaces }| [sky, by_surfaces])
    }

    /// The irradiance of a surface at a position of the environment's picture, without that of suns, if it saw all of
    /// the sky.
    #[inline(always)]
    pub(in super::super) fn irradiance_at(&self, position: Vec2) -> Vec3 {
        self.rest.at(position)
    }

    /// The share of the sky's light, for each colour, that arrives at a place of a triangle, on the side of its normals
    /// or, for -1, on the other.
    #[inline]
    pub(in super::super) fn share(&self, triangle: u32, barycentrics: Vec2, side: f32) -> Vec3 {
        self.shares.sky(triangle, barycentrics, usize::from(side < 0.0))
    }

    /// Returns true if it has the light that surfaces scatter onto each other.
    pub(in super::super::super) fn is_scattered(&self) -> bool {
        self.is_scattered
    }

    /// Returns true if surfaces light others.
    #[inline(always)]
    pub(in super::super) fn has_light_of_surfaces(&self) -> bool {
        self.is_scattered || self.emitters.is_some()
    }

    /// The irradiance there by surfaces that emit light or scatter it.
    #[inline]
    pub(in super::super) fn by_surfaces(&self, triangle: u32, barycentrics: Vec2, side: f32) -> Vec3 {
        match self.has_light_of_surfaces() {
            true => self.shares.by_surfaces(triangle, barycentrics, usize::from(side < 0.0)),
            false => Vec3::ZERO,
        }
    }
}
