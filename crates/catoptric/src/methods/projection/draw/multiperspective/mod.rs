//! Multiperspective rasterisation: every piece of a reflector's picture asks which triangles its rays meet.
//!
//! See the method's [README](../../multiperspective/README.md).

mod bundles;
mod counts;
mod shapes;
mod source;
mod tiles;

pub use shapes::{ObjectShape, object_shapes};

use super::rough::{RoughMirrors, RoughReflections};
use super::{MapsInView, PathShader};
use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::light::wide_hierarchy::WideHierarchy;
use crate::methods::{Job, Report};
use crate::optics::path::manifold::MeshTopologies;
use crate::progress::{Progress, Stage};
use crate::raster::{self, DrawList};
use crate::scene::Scene;
use counts::Counts;
use glam::Vec3;
use shapes::SceneShapes;
use source::{Reflections, outermost};
use std::sync::Arc;
use tiles::follow::MAX_BOUNCES;

/// How tiles draw.
#[derive(Clone, Copy, Debug)]
pub(in crate::methods::projection) struct TileModel {
    /// The most that bundles may miss their rays by.
    pub(in crate::methods::projection) accuracy_px: f32,
    /// Every pixel has its own ray: bundles tell candidates alone.
    pub(in crate::methods::projection) by_rays: bool,
    /// Normal maps turn rays, and pixels that show such surfaces have their own.
    pub(in crate::methods::projection) turns_normals: bool,
}

/// What tiles need of a scene: it depends on no view.
pub(in crate::methods::projection) struct TiledScene {
    scene: Arc<Scene>,
    hierarchy: WideHierarchy,
    shapes: SceneShapes,
    /// If there are any.
    rough: Option<RoughMirrors>,
}

impl TiledScene {
    /// The tables of a scene, by those of another moment of it if these are given.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    pub(in crate::methods::projection) fn new(
        scene: &Arc<Scene>,
        old: Option<&Self>,
        report: &mut Report,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let stage = Stage::begin(progress, "building the hierarchy", 2)?;
        let mut watch = Stopwatch::new();
        let old = old.filter(|old| old.scene.triangles == scene.triangles);
        let refitted = old.and_then(|old| {
            let mut hierarchy = old.hierarchy.clone();
            hierarchy.refit(scene).then_some(hierarchy)
        });
        let hierarchy = refitted.unwrap_or_else(|| WideHierarchy::build(scene, |_| true));
        let rough = RoughMirrors::new(scene, old.and_then(|old| old.rough.as_ref()));
        stage.advance(1)?;
        report.stages_ms.push(("bvh", watch.lap_ms()));
        let shapes = SceneShapes::new(scene, &MeshTopologies::of(scene));
        report.stages_ms.push(("topology", watch.lap_ms()));
        let of_rough = rough.as_ref().map_or(0, RoughMirrors::byte_count);
        report.bytes.insert("bvh", hierarchy.byte_count() + of_rough);
        stage.advance(1)?;
        Ok(Self { scene: scene.clone(), hierarchy, shapes, rough })
    }

    /// Draws lists, and what is seen in reflectors and through lenses at which no list goes on. Reflectors with
    /// environment maps show these.
    ///
    /// # Errors
    /// As [`raster::draw`].
    pub(in crate::methods::projection) fn draw(
        &self,
        job: &Job<'_>,
        lists: &[DrawList],
        model: TileModel,
        maps: MapsInView<'_>,
        target: &mut Framebuffer,
    ) -> Result<Report, RenderError> {
        let Job { scene, view, quality, progress } = *job;
        let positions = raster::sample_positions(quality.samples)?;
        let mut watch = Stopwatch::new();
        let rough = match &self.rough {
            Some(mirrors) => RoughReflections::new(job, mirrors)?,
            None => None,
        };
        let mut report = Report::default();
        if rough.is_some() {
            report.stages_ms.push(("rough", watch.lap_ms()));
        }
        let source = Reflections {
            scene,
            rays: view.rays(),
            forward: -Vec3::from(view.world_from_view.matrix3.z_axis),
            positions,
            outermost: outermost(positions),
            hierarchy: &self.hierarchy,
            shapes: &self.shapes,
            order: (quality.order as usize).min(MAX_BOUNCES),
            model,
            maps: maps.whole,
            rough: rough.as_ref(),
            counts: Counts::default(),
        };
        let shader = PathShader::new(scene, view, quality.samples)
            .with_rough(rough.as_ref())
            .with_turned_normals(model.turns_normals)
            .with_maps(maps, quality.order)
            .with_neighbours(&self.shapes.neighbours);
        let drawn = raster::draw_with(view, quality.samples, lists, &source, &shader, target, progress)?;
        report.add_raster(&drawn);
        source.counts.describe(&mut report);
        Ok(report)
    }
}
