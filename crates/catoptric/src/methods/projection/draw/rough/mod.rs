//! Rough mirrors: what they would reflect sharply, blurred by each place's own lobe.
//!
//! A grid of rays, some pixels apart, finds what smooth mirrors would show: radiance, and how far away it is. The light
//! of a rough place is a mean over its lobe. Every direction of the lobe is looked for in the same grid: which ray
//! passes where it goes? Near things are found from the place's own point of view, so that what touches the mirror
//! stays sharp and blur grows with distance. Where lobes are narrow the grid is finer; where they are narrower than its
//! cells, the sharp reflection is drawn.

mod blur;
mod grid;

use crate::error::RenderError;
use crate::light::path_tracer::{PathModel, PathTracer};
use crate::light::tracer::Tracer;
use crate::methods::Job;
use crate::scene::shade::SurfaceInteraction;
use crate::scene::{Ray, RayDifferential, Scene};
use glam::{Vec2, Vec3};
use grid::{Part, ReflectedGrid};

/// Rays from a rough place that the grid does not know: seen in another mirror, or too small. Chosen between noise and
/// time.
const RAYS: u32 = 16;

/// Cells along the shorter side of a picture, at least, where lobes are narrow.
const CELLS: u32 = 480;

/// The longest side of such a cell, in pixels. Other cells have twice the side.
const LARGEST_CELL_PX: u32 = 2;

/// Lobes that cover more cells of the coarse grid across than the second number are seen in that grid alone, and those
/// that cover less than the first one in the fine grid alone.
const NARROW_CELLS: [f32; 2] = [5.0, 8.0];

/// Distances beyond are none.
const FAR: f32 = 1e12;

/// Light that rough mirrors reflect in a view.
pub(in crate::methods::projection) struct RoughReflections<'a> {
    scene: &'a Scene,
    tracer: &'a Tracer,
    order: u32,
    coarse: ReflectedGrid,
    /// Where lobes are narrow.
    fine: Option<ReflectedGrid>,
}

/// Hierarchies for rays to and from rough mirrors.
pub(in crate::methods::projection) struct RoughTracers {
    everything: Tracer,
    mirrors: Tracer,
}

impl RoughTracers {
    /// Those of a scene; `None` if it has no mirrors whose reflections are blurred.
    pub(in crate::methods::projection) fn new(scene: &Scene) -> Option<Self> {
        let is_rough = |object: u32| scene.material_of(object).reflection_roughness() > 0.0;
        (0..scene.objects.len() as u32)
            .any(is_rough)
            .then(|| Self { everything: Tracer::build(scene, |_| true), mirrors: Tracer::build(scene, is_rough) })
    }
}

/// What a place of a rough mirror reflects, before tint and Fresnel's share.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RoughLight {
    /// The mean radiance over the lobe, times its weight.
    pub(super) radiance: Vec3,
    /// The weight of the mean against what the sharp ray shows: 0 where the lobe covers no more than a pixel.
    pub(super) weight: f32,
    /// What the sharp ray of a place shows.
    pub(super) sharp: Vec3,
    /// The share of light that facets neither mask nor shadow.
    pub(super) share: f32,
    /// The distance of what is reflected sharply.
    pub(super) distance: f32,
    /// The width of the lobe's bright part, in pixels of the sharp reflection.
    pub(super) width_px: f32,
}

impl RoughLight {
    /// The sum with so much of another one.
    #[inline]
    fn plus(&self, other: &Self, weight: f32) -> Self {
        Self {
            radiance: self.radiance + other.radiance * weight,
            weight: self.weight + other.weight * weight,
            sharp: self.sharp + other.sharp * weight,
            share: self.share + other.share * weight,
            distance: self.distance + other.distance.min(FAR) * weight,
            width_px: self.width_px + other.width_px * weight,
        }
    }
}

impl<'a> RoughReflections<'a> {
    /// The light of a view's rough mirrors; `None` if the view's order shows none.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub(in crate::methods::projection) fn new(
        job: &Job<'a>,
        tracers: &'a RoughTracers,
    ) -> Result<Option<Self>, RenderError> {
        if job.quality.order == 0 {
            return Ok(None);
        }
        let cell_px = (job.view.width.min(job.view.height) / CELLS).clamp(1, LARGEST_CELL_PX);
        let mut coarse = ReflectedGrid::trace(job, tracers, 2 * cell_px, &Part::Whole)?;
        blur::blur(job.scene, &mut coarse);
        let mut fine = None;
        if let Some(part) = Part::narrow(&coarse, NARROW_CELLS[1] * coarse.cell_px as f32) {
            let mut grid = ReflectedGrid::trace(job, tracers, cell_px, &part)?;
            blur::blur(job.scene, &mut grid);
            fine = Some(grid);
        }
        Ok(Some(Self { scene: job.scene, tracer: &tracers.everything, order: job.quality.order, coarse, fine }))
    }

    /// The light at a position of the picture, where an object is seen; `None` where the grid does not know it.
    #[inline]
    pub(super) fn at(&self, object: u32, position: Vec2) -> Option<RoughLight> {
        let coarse = self.coarse.at(object, position);
        let Some(grid) = &self.fine else { return coarse };
        let [narrow, wide] = NARROW_CELLS.map(|cells| cells * self.coarse.cell_px as f32);
        let share = coarse.map_or(1.0, |light| ((wide - light.width_px) / (wide - narrow)).clamp(0.0, 1.0));
        if share <= 0.0 {
            return coarse;
        }
        let fine = grid.at(object, position);
        match (coarse, fine) {
            (Some(coarse), Some(fine)) => Some(RoughLight::default().plus(&coarse, 1.0 - share).plus(&fine, share)),
            (coarse, fine) => fine.or(coarse),
        }
    }

    /// All the light of a rough place that is met after some bounces, by rays.
    #[inline(never)] // rare, and as long as a path
    pub(super) fn traced(&self, bounces: u32, ray: Ray, change: RayDifferential, at: &SurfaceInteraction) -> Vec3 {
        let order = self.order.saturating_sub(bounces);
        let mut paths = PathTracer::new(self.scene, self.tracer, PathModel::Tree, order).with_rough_rays(RAYS, 0, 1.0);
        paths.radiance_from(ray, Some(change), at)
    }
}
