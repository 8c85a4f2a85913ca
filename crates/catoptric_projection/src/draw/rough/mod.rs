//! Rough mirrors: what they would reflect sharply, blurred by each place's own lobe.
//!
//! A grid of rays, some pixels apart, finds what smooth mirrors would show: radiance, and how far away it is. The light
//! of a rough place is a mean over its lobe. Every direction of the lobe is looked for in the same grid: which ray
//! passes where it goes? Near things are found from the place's own point of view, so that what touches the mirror
//! stays sharp and blur grows with distance. Where lobes are narrow there are grids of smaller cells; where they are
//! narrower than the smallest ones, the sharp reflection is drawn.
//!
//! Where a normal map has bumps smaller than a pixel, a smooth mirror is a rough one, too, and a lens spreads what it
//! reflects and refracts; with bumps, lobes are traced by rays.

mod blur;
mod grid;
mod lobe;
mod passage;
mod pyramid;
mod trace;

use catoptric_core::math::Aabb;
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Ray, RayDifferential, Scene};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::path_tracer::{PathModel, PathTracer};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::Job;
use glam::{Vec2, Vec3};
use grid::{Layout, Part, ReflectedGrid};
use pyramid::Pyramid;
use trace::Cells;

/// Rays from a rough place that the grids do not know: seen in another mirror, or too small. Chosen between noise and
/// time.
const RAYS: u32 = 16;

/// Cells of the finest grid along the shorter side of a picture, at least.
const CELLS: u32 = 480;

/// The longest side of such a cell, in pixels.
const LARGEST_CELL_PX: u32 = 2;

/// Grids, each of cells of half the side of the one before.
const GRIDS: usize = 3;

/// Rays go through a finer grid where lobes cover fewer cells across: so many at least make up what a lobe sees.
const CELLS_OF_LOBE: f32 = 4.0;

/// Of all grids but the finest: lobes that cover more of its cells across than the second number are blurred in it, and
/// those that cover less than the first one in a finer one: what is blurred changes slowly. Chosen between error and
/// time.
const BLURRED_CELLS: [[f32; 2]; GRIDS - 1] = [[3.0, 5.0], [1.75, 3.0]];

/// Distances beyond are none.
const FAR: f32 = 1e12;

/// The rough mirrors of a scene, and lenses with bumps.
pub(crate) struct RoughMirrors {
    /// For rays to and from them.
    tracer: Tracer,
    /// Whether each object is one, or may be by its normal map.
    is_rough: Vec<bool>,
    /// Boxes around them.
    boxes: Vec<Aabb>,
}

impl RoughMirrors {
    /// Those of a scene, by those of another moment of it if these are given; `None` if there are none.
    pub(crate) fn new(scene: &Scene, old: Option<&Self>) -> Option<Self> {
        let is_rough: Vec<bool> =
            (0..scene.objects.len() as u32).map(|object| scene.material_of(object).may_spread_light()).collect();
        let objects = scene.objects.iter().zip(&is_rough).filter(|(_, is_rough)| **is_rough);
        let boxes: Vec<Aabb> = objects.map(|(object, _)| object.bounds).collect();
        if boxes.is_empty() {
            return None;
        }
        let tracer = old.and_then(|old| old.tracer.refitted(scene)).unwrap_or_else(|| Tracer::build(scene, |_| true));
        Some(Self { tracer, is_rough, boxes })
    }

    /// What follows rays in the whole scene.
    pub(crate) fn tracer(&self) -> &Tracer {
        &self.tracer
    }

    /// Memory of the hierarchy.
    pub(crate) fn byte_count(&self) -> u64 {
        self.tracer.byte_count()
    }

    /// False if a ray meets none of them.
    fn may_be_met_by(&self, ray: &Ray) -> bool {
        let inverse = ray.direction.recip();
        let is_met = |bounds: &Aabb| {
            let (low, high) = ((bounds.min - ray.origin) * inverse, (bounds.max - ray.origin) * inverse);
            let margin = 1e-5 * (low.abs() + high.abs());
            let enter = (low.min(high) - margin).max_element();
            let leave = (low.max(high) + margin).min_element();
            // Not a number, where a ray lies in a side's plane: met.
            !(enter > leave || leave < 0.0)
        };
        self.boxes.iter().any(is_met)
    }
}

/// What a place of a rough mirror reflects, before tint and Fresnel's share.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RoughLight {
    /// The mean radiance over the lobe, times its weight.
    pub(super) radiance: Vec3,
    /// The same of refracted light, at a lens.
    pub(super) refracted: Vec3,
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
            refracted: self.refracted + other.refracted * weight,
            weight: self.weight + other.weight * weight,
            sharp: self.sharp + other.sharp * weight,
            share: self.share + other.share * weight,
            distance: self.distance + other.distance.min(FAR) * weight,
            width_px: self.width_px + other.width_px * weight,
        }
    }
}

/// Light that rough mirrors reflect in a view.
pub(crate) struct RoughReflections<'a> {
    scene: &'a Scene,
    mirrors: &'a RoughMirrors,
    order: u32,
    /// The grids, each finer than the one before; the first one covers the picture, others parts of it.
    grids: Vec<ReflectedGrid>,
    /// Of each grid, the cells at which what is reflected sharply is seen.
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

    /// Whether an object is rough itself, not only where its normal map has bumps smaller than a pixel.
    pub(super) fn is_rough(&self, object: u32) -> bool {
        self.scene.material_of(object).reflection_roughness() > 0.0
    }

    /// Whether an object's light in a rectangle of the picture is known without what it reflects sharply.
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

    /// All the light of a rough place that is met after some bounces, by rays.
    #[inline(never)] // rare, and as long as a path
    pub(super) fn traced(&self, bounces: u32, ray: Ray, change: RayDifferential, at: &SurfaceInteraction) -> Vec3 {
        let order = self.order.saturating_sub(bounces);
        let mut paths =
            PathTracer::new(self.scene, &self.mirrors.tracer, PathModel::Tree, order).with_rough_rays(RAYS, 0, 1.0);
        paths.radiance_from(ray, Some(change), at)
    }
}
