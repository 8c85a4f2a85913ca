//! The light fields of a scene.

use super::bake::SlabsWork;
use super::settings::{LightFieldSettings, Transfer};
use super::slabs::Slabs;
use super::stored::stored_radiance;
use super::transfer::RayTransfer;
use crate::shared::memory::fit_into_memory;
use crate::shared::regions::Regions;
use catoptric_core::clock::Stopwatch;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Ray, RayDifferential, Role, Scene};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::path_tracer::{PathModel, PathTracer};
use catoptric_engine::light::radiance_field::RadianceField;
use catoptric_engine::light::reflector_shader::{ReflectorShader, reflector_radiance};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::bake::Baked;
use catoptric_engine::method::reflector_maps::{ReflectorCubeMap, ReflectorMapSettings, ReflectorMaps};
use catoptric_engine::method::{Quality, Report, Settings, report};
use glam::Vec3;
use std::sync::Arc;

/// Pixels a side that views have at least, unless fewer are wanted: a bound on automatic reduction. Chosen, not
/// measured.
const MIN_UV: u32 = 16;

/// The radiance that all reflectors and lenses of a scene look up.
pub struct LightFields {
    /// Identity of the slabs' contents: [`SlabsWork::fingerprint`].
    fingerprint: [u8; 32],
    /// Number of every object's region, if it lies in one.
    pub(super) region_of: Vec<Option<u32>>,
    pub(super) regions: Vec<FieldRegion>,
    /// Highest number of specular events of a path.
    pub(super) order: u32,
    /// Maps of objects outside all regions.
    pub(super) maps: ReflectorMaps,
}

/// A region's light field, and the ways of rays within the region.
pub(super) struct FieldRegion {
    pub(super) slabs: Arc<Slabs>,
    pub(super) inside: Inside,
}

/// The ways of rays from a region's surfaces out of it.
pub(super) enum Inside {
    /// One event.
    First,
    /// Paths that are traced among its reflectors and lenses.
    Traced(Tracer),
    /// Rays that were traced and kept.
    Stored(RayTransfer),
}

impl LightFields {
    /// Captures the fields of a scene, or loads a bake; keeps the slabs of `old` where these are of the same scene.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where a bake is of another scene or a table does not fit into memory,
    /// [`RenderError::Cancelled`].
    pub fn new(
        settings: &LightFieldSettings,
        scene: &Scene,
        quality: Quality,
        baked: Option<&Arc<dyn Baked>>,
        old: Option<&Self>,
        progress: &dyn Progress,
    ) -> Result<(Self, Report), RenderError> {
        let mut watch = Stopwatch::new();
        let mut report = Report::default();
        let settings = &captured_at_once(settings, scene, baked.is_some(), &mut report);
        let work = SlabsWork::new(settings, scene, quality)?;
        if settings.transfer == Transfer::Stored {
            let (st, uv) = (settings.transfer_st, settings.transfer_uv);
            let bytes = RayTransfer::most_bytes([st, uv]) * work.region_count() as u64;
            let table = format!("rays of transfer_st = {st} and transfer_uv = {uv}");
            fit_into_memory(LightFieldSettings::METHOD, &table, bytes, "transfer = traced")?;
        }
        let fingerprint = work.fingerprint();
        let slabs: Vec<Arc<Slabs>> = match (old, baked) {
            // Objects move within the regions.
            (Some(old), _) if old.fingerprint == fingerprint => {
                old.regions.iter().map(|region| region.slabs.clone()).collect()
            }
            (Some(_), Some(_)) => {
                let problem = "the scene is no longer that of the baked file: without a [region] that reflectors stay \
                    in, \
                               a bake is of one moment";
                return Err(RenderError::Limit { method: LightFieldSettings::METHOD, problem: problem.into() });
            }
            (None, Some(baked)) => work.baked(baked)?.into_iter().map(Arc::new).collect(),
            (_, None) => {
                let slabs = work.captured(progress)?;
                report.counts.insert("captured_rays", slabs.iter().map(Slabs::ray_count).sum());
                slabs.into_iter().map(Arc::new).collect()
            }
        };
        report.stages_ms.push((if baked.is_some() { "bake_load" } else { "capture" }, watch.lap_ms()));
        let region_of = work.regions.region_of.clone();
        let region = |(number, slabs): (usize, Arc<Slabs>)| -> Result<FieldRegion, Cancelled> {
            let inside = Inside::new(settings, scene, quality, &work.regions, number, progress)?;
            Ok(FieldRegion { slabs, inside })
        };
        let regions: Vec<FieldRegion> = slabs.into_iter().enumerate().map(region).collect::<Result<_, _>>()?;
        if settings.transfer == Transfer::Stored && !regions.is_empty() {
            report.stages_ms.push(("ray_transfer", watch.lap_ms()));
            report.warnings.extend(report::bumpy_surfaces(scene));
        }
        let outside = |object: &u32| region_of[*object as usize].is_none();
        let others: Vec<u32> = scene.specular_objects().into_iter().filter(outside).collect();
        let maps = ReflectorMapSettings::default();
        let maps = ReflectorMaps::capture(&maps, scene, &others, quality.order, progress)?;
        report.stages_ms.push(("environment_maps", watch.lap_ms()));
        if !others.is_empty() {
            report.fallbacks.insert("reflectors_with_environment_maps", others.len() as u64);
            report.bytes.insert("environment_maps", maps.byte_count());
            maps.add_fallbacks(&mut report);
        }
        if !regions.is_empty() && baked.is_none() {
            let (st, uv) = (settings.st, settings.uv);
            report.warnings.push(format!(
                "light_field: captured {st} x {st} views of {uv} x {uv} a slab in memory; `catoptric bake` keeps \
                larger ones"
            ));
        }
        let fields = Self { fingerprint, region_of, regions, order: quality.order, maps };
        fields.describe(&mut report);
        Ok((fields, report))
    }

    /// The slabs about each region of reflectors and lenses.
    pub fn slabs(&self) -> impl ExactSizeIterator<Item = &Arc<Slabs>> {
        self.regions.iter().map(|region| &region.slabs)
    }

    /// The number of every object's region, if it lies in one.
    pub fn region_of(&self) -> &[Option<u32>] {
        &self.region_of
    }

    /// Environment maps of objects outside all regions; empty without any.
    pub fn maps(&self) -> &[Option<ReflectorCubeMap>] {
        self.maps.all()
    }

    /// Counts and bytes.
    fn describe(&self, report: &mut Report) {
        let stored = || self.regions.iter().filter_map(|region| region.inside.stored());
        if stored().next().is_some() {
            report.bytes.insert("ray_transfer", stored().map(RayTransfer::byte_count).sum());
            report.counts.insert("transferred_rays", stored().map(RayTransfer::ray_count).sum());
        }
        report.counts.insert("regions", self.regions.len() as u64);
        report.bytes.insert("slabs", self.regions.iter().map(|region| region.slabs.byte_count()).sum());
    }
}

/// Settings for slabs about a scene's regions that are all captured now: views are smaller about many of them.
fn captured_at_once(
    settings: &LightFieldSettings,
    scene: &Scene,
    is_baked: bool,
    report: &mut Report,
) -> LightFieldSettings {
    let regions = Regions::of(scene, settings.region_margin);
    report.add_fallback("joined_regions", regions.joined);
    let share = regions.share_of_side();
    let mut settings = settings.clone();
    if share < 1.0 && !is_baked && settings.views.is_empty() {
        settings.uv = ((settings.uv as f32 * share) as u32).max(MIN_UV.min(settings.uv));
        report.add_fallback("regions_with_smaller_views", regions.boxes.len() as u64);
    }
    settings
}

impl Inside {
    /// The rays of a region, by its number.
    fn new(
        settings: &LightFieldSettings,
        scene: &Scene,
        quality: Quality,
        regions: &Regions,
        number: usize,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let is_inside = |object: u32| regions.region_of[object as usize] == Some(number as u32);
        Ok(match settings.transfer {
            Transfer::First => Self::First,
            Transfer::Traced => Self::Traced(Tracer::build(scene, is_inside)),
            Transfer::Stored => {
                let tracer = Tracer::build(scene, is_inside);
                let is_lens = |object: &u32| scene.material_of(*object).role == Role::Lens && is_inside(*object);
                let has_lenses = scene.specular_objects().iter().any(is_lens);
                let sizes = [settings.transfer_st, settings.transfer_uv];
                let (bounds, order) = (&regions.boxes[number], quality.order);
                Self::Stored(RayTransfer::capture(scene, &tracer, bounds, sizes, order, has_lenses, progress)?)
            }
        })
    }

    /// The rays, where they were kept.
    pub(super) fn stored(&self) -> Option<&RayTransfer> {
        match self {
            Self::Stored(transfer) => Some(transfer),
            _ => None,
        }
    }
}

impl LightFields {
    /// The radiance that a reflector or lens shows to a ray that meets it.
    pub(super) fn radiance(
        &self,
        scene: &Scene,
        encounter: &SurfaceInteraction,
        ray: &Ray,
        change: &RayDifferential,
    ) -> Vec3 {
        let region = self.region_of[encounter.point.object as usize];
        let Some(FieldRegion { slabs, inside }) = region.and_then(|region| self.regions.get(region as usize)) else {
            return self.maps.radiance(scene, encounter, ray, change);
        };
        match inside {
            Inside::First => reflector_radiance(Some(&**slabs), scene, encounter, ray, change),
            Inside::Stored(transfer) => stored_radiance(slabs, transfer, scene, encounter, ray, change),
            Inside::Traced(tracer) => PathTracer::with_field(scene, tracer, PathModel::Tree, self.order, &**slabs)
                .radiance_from(*ray, Some(*change), encounter),
        }
    }
}

impl RadianceField for Slabs {
    fn radiance(&self, scene: &Scene, ray: &Ray, change: Option<&RayDifferential>) -> Vec3 {
        let none = RayDifferential::default();
        let RayDifferential { origin_dx, origin_dy, direction_dx, direction_dy } = change.unwrap_or(&none);
        Slabs::radiance(self, ray.origin, ray.direction, [*origin_dx, *origin_dy], [*direction_dx, *direction_dy])
            .unwrap_or_else(|| scene.background(ray.direction))
    }

    fn distance(&self, ray: &Ray) -> f32 {
        Slabs::distance(self, ray.origin, ray.direction)
    }
}
