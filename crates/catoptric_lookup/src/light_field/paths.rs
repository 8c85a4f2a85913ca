//! The paths of light that reflectors and lenses show by their light fields.

use super::fields::{Inside, LightFields};
use catoptric_core::progress::{Cancelled, Progress, Stage};
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Ray, RayDifferential, Scene};
use catoptric_engine::light::path_tracer::{PathModel, PathTracer};
use catoptric_engine::light::reflector_shader::first_bounce;
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::optics::path::bundle::Bounce;

/// Paths from surfaces out of their regions.
pub(super) struct FieldPaths<'a> {
    fields: &'a LightFields,
    /// The reflectors and lenses of regions whose rays were stored without their bounces.
    stored: Vec<Option<Tracer>>,
}

impl<'a> FieldPaths<'a> {
    /// Paths of a scene's light fields.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn new(fields: &'a LightFields, scene: &Scene, progress: &dyn Progress) -> Result<Self, Cancelled> {
        let stage = Stage::begin(progress, "building the hierarchy", fields.regions.len())?;
        let mut stored = Vec::with_capacity(fields.regions.len());
        for (number, region) in (0..).zip(&fields.regions) {
            let is_inside = |object: u32| fields.region_of[object as usize] == Some(number);
            stored.push(region.inside.stored().map(|_| Tracer::build(scene, is_inside)));
            stage.advance(1)?;
        }
        Ok(Self { fields, stored })
    }

    /// The bounces of the light that a reflector or lens shows to a ray that meets it, up to where it is looked up. Of
    /// stored rays those of the one way that is followed behind the first glass.
    pub(super) fn bounces(
        &self,
        scene: &Scene,
        encounter: &SurfaceInteraction,
        ray: &Ray,
        change: &RayDifferential,
    ) -> Vec<Bounce> {
        let LightFields { region_of, regions, order, maps, .. } = self.fields;
        let number = region_of[encounter.point.object as usize].map(|number| number as usize);
        let Some((number, region)) = number.and_then(|number| Some((number, regions.get(number)?))) else {
            return maps.bounces(scene, encounter, ray);
        };
        let (tracer, model) = match (&region.inside, &self.stored[number]) {
            (Inside::Traced(tracer), _) => (tracer, PathModel::Tree),
            (_, Some(tracer)) => (tracer, PathModel::TwoPath),
            _ => return first_bounce(scene, encounter, ray).into_iter().collect(),
        };
        PathTracer::new(scene, tracer, model, *order).bounces_from(*ray, Some(*change), encounter)
    }
}
