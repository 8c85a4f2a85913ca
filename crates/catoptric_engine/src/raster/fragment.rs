//! The rasteriser's input to shaders.

use catoptric_core::scene::shade::Barycentrics;
use glam::{Vec2, Vec3};

/// The surface of a pixel in one layer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerSurface {
    /// The list that drew it.
    pub list: u32,
    /// [`DrawTriangle::source`](super::DrawTriangle::source).
    pub source: u32,
    /// [`DrawTriangle::group`](super::DrawTriangle::group).
    pub group: u32,
    /// Perspective-correct barycentric coordinates at `Fragment::position` in the source triangle (not in the piece of
    /// it that was drawn or left by clipping), and their true screen derivatives.
    pub barycentrics: Barycentrics,
}

/// A part of a pixel that shows one chain of surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment<'a> {
    /// The shaded position, in pixels: the pixel's centre, or the centroid of its samples where it is covered in part.
    pub position: Vec2,
    /// The surfaces, layer 0 first; a chain ends where a layer shows nothing. Empty: the background.
    pub chain: &'a [LayerSurface],
    /// Bit k is set where the chain goes on from the surface of layer k by its second [`Branch`](super::Branch). All
    /// fragments of a sample that differ in this are added: light that several of them pass by counts in one alone.
    pub second_branches: u64,
}

/// The fragments of a tile.
#[derive(Clone, Copy, Debug)]
pub struct FragmentBatch<'a> {
    pub(super) positions: &'a [Vec2],
    /// The end of each fragment's chain in `surfaces`; the next one begins there.
    pub(super) chain_ends: &'a [u32],
    pub(super) surfaces: &'a [LayerSurface],
    /// The same for all.
    pub(super) second_branches: u64,
}

impl<'a> FragmentBatch<'a> {
    /// The number of fragments.
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    /// Returns true if there are no fragments.
    pub fn is_empty(&self) -> bool {
        self.positions.is_empty()
    }

    /// All fragments, pixel after pixel.
    #[inline]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Fragment<'a>> + use<'a> {
        let (surfaces, second_branches) = (self.surfaces, self.second_branches);
        let mut start = 0;
        self.positions.iter().zip(self.chain_ends).map(move |(&position, &end)| {
            let chain = &surfaces[start..end as usize];
            start = end as usize;
            Fragment { position, chain, second_branches }
        })
    }
}

/// Gives colours to fragments.
pub trait FragmentShader: Sync {
    /// The linear radiance of a fragment.
    fn shade(&self, fragment: &Fragment<'_>) -> Vec3;

    /// The linear radiance of every fragment of a tile; `colors` is as long as the batch.
    ///
    /// Compiled with [`Self::shade`], as far as it can be inlined, for the instructions that the machine has.
    fn shade_batch(&self, batch: &FragmentBatch<'_>, colors: &mut [Vec3]) {
        shade_all(self, batch, colors);
    }

    /// Returns true if a surface is there at all at a sample. Called only for triangles that are
    /// [`alpha_tested`](super::DrawTriangle::alpha_tested); `position` is the sample's, in pixels.
    fn is_present(&self, surface: &LayerSurface, position: Vec2) -> bool {
        let _ = (surface, position);
        true
    }
}

#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
fn shade_all<S: FragmentShader + ?Sized>(shader: &S, batch: &FragmentBatch<'_>, colors: &mut [Vec3]) {
    for (fragment, color) in batch.iter().zip(colors) {
        *color = shader.shade(&fragment);
    }
}
