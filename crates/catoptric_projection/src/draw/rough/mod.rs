//! Rough mirrors: their sharp reflections, blurred by each place's own lobe.
//!
//! A grid of rays, some pixels apart, finds the radiance that smooth mirrors would show, and its distance. The light of
//! a rough place is a mean over its lobe. Every direction of the lobe is searched in the same grid, for the ray that
//! passes through the same points. Near things are found from the place's own point of view, so that what touches the
//! mirror stays sharp and blur grows with distance. Where lobes are narrow there are grids of smaller cells; where they
//! are narrower than the smallest ones, the sharp reflection is drawn.
//!
//! Where a normal map has bumps smaller than a pixel, a smooth mirror is a rough one, too, and a lens spreads what it
//! reflects and refracts; with bumps, lobes are traced by rays.

mod blur;
mod grid;
mod light;
mod lobe;
mod mirrors;
mod passage;
mod pyramid;
mod trace;

pub(super) use light::RoughLight;
pub(crate) use mirrors::RoughMirrors;

use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Ray, RayDifferential, Scene};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::path_tracer::{PathModel, PathTracer};
use catoptric_engine::method::Job;
use glam::{Vec2, Vec3};
use grid::{BLURRED_CELLS, GRIDS, Layout, Part, ReflectedGrid};
use pyramid::Pyramid;
use trace::Cells;

/// Rays from a rough place that the grids do not know: seen in another mirror, or too small. Chosen between noise and
/// time.
const RAYS: u32 = 16;

/// Cells of the finest grid along the shorter side of a picture, at least.
const CELLS: u32 = 480;

/// The longest side of such a cell, in pixels.
const LARGEST_CELL_PX: u32 = 2;

/// The number of cells across a lobe below which rays go through a finer grid.
const CELLS_OF_LOBE: f32 = 4.0;

/// Light that rough mirrors reflect in a view.
pub(crate) struct RoughReflections<'a> {
    scene: &'a Scene,
    mirrors: &'a RoughMirrors,
    order: u32,
    /// The grids, each finer than the one before; the first one covers the picture, others parts of it.
    grids: Vec<ReflectedGrid>,
    /// The cells of each grid at which the sharp reflection is seen.
    sharp: Vec<Vec<bool>>,
}

impl<'a> RoughReflections<'a> {
    /// The light of a view's rough mirrors; `None` if the view's order shows none.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub(crate) fn new(job: &Job<'a>, mirrors: &'a RoughMirrors) -> Result<Option<Self>, RenderError> {
        if job.quality.order == 0 {
            return Ok(None);
        }
        let finest_px = (job.view.width.min(job.view.height) / CELLS).clamp(1, LARGEST_CELL_PX);
        let mut layout = Layout::new(job.view, finest_px);
        let mut part = Part::Whole;
        let mut grids: Vec<ReflectedGrid> = Vec::new();
        loop {
            let grid = Cells { job, mirrors, layout, part }.trace()?;
            let narrow = grid.narrow(CELLS_OF_LOBE);
            grids.push(grid);
            match narrow {
                Some(narrow) if grids.len() < GRIDS => (layout, part) = (layout.halved(), narrow),
                _ => break,
            }
        }
        let Some(pyramid) = Pyramid::new(&grids) else { return Ok(None) };
        let blurred: Vec<_> = (0..grids.len()).map(|grid| blur::blurred(&grids, grid, &pyramid)).collect();
        for (grid, blurred) in grids.iter_mut().zip(blurred) {
            for (place, light) in blurred {
                grid.light[place] = light;
            }
        }
        let sharp = grids.iter().map(ReflectedGrid::cells_of_sharp_light).collect();
        Ok(Some(Self { mirrors, scene: job.scene, order: job.quality.order, grids, sharp }))
    }

    /// True if an object is rough itself, not only where its normal map has bumps smaller than a pixel.
    pub(super) fn is_rough(&self, object: u32) -> bool {
        self.scene.material_of(object).reflection_roughness() > 0.0
    }

    /// True if an object's light in a rectangle of the picture is known without its sharp reflection.
    pub(super) fn is_all_of(&self, object: u32, low_px: Vec2, high_px: Vec2) -> bool {
        if self.is_rough(object) {
            return !self.grids.iter().zip(&self.sharp).any(|(grid, cells)| grid.has_any(cells, low_px, high_px));
        }
        // Bumps are for the finest grid. A smooth mirror's edge may show where no cell around it does.
        self.grids.last().is_some_and(|finest| finest.is_full_of(object, low_px, high_px))
    }

    /// The light at a position of the picture, where an object is seen; `None` where the grids do not know it, or it
    /// reflects sharply.
    #[inline]
    pub(super) fn at(&self, object: u32, position: Vec2) -> Option<RoughLight> {
        let mut light = None;
        for (level, grid) in self.grids.iter().enumerate() {
            let share = match (&light, level) {
                (Some(light), 1..) => self.grids[level - 1].finer_share(light, BLURRED_CELLS[level - 1]),
                _ => 1.0,
            };
            if share <= 0.0 {
                break;
            }
            light = match (light, grid.at(object, position)) {
                (Some(coarse), Some(fine)) => Some(RoughLight::default().plus(&coarse, 1.0 - share).plus(&fine, share)),
                (coarse, fine) => fine.or(coarse),
            };
        }
        light.filter(|light| light.weight > 0.0 || self.is_rough(object))
    }

    /// The whole light of a rough place that is met after some bounces, by rays.
    #[inline(never)] // rare, and as long as a path
    pub(super) fn traced(&self, bounces: u32, ray: Ray, change: RayDifferential, at: &SurfaceInteraction) -> Vec3 {
        let order = self.order.saturating_sub(bounces);
        let mut paths =
            PathTracer::new(self.scene, &self.mirrors.tracer, PathModel::Tree, order).with_rough_rays(RAYS, 0, 1.0);
        paths.radiance_from(ray, Some(change), at)
    }
}
