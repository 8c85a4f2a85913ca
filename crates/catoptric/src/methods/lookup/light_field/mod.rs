//! Environment light-field slabs: what arrives at a region, by all rays.
//!
//! See this folder's `README.md`.

mod bake;
mod blocks;
mod capture;
mod depth;
mod fetch;
mod layout;
mod rows;
mod settings;
mod slabs;
mod stored;
mod texels;
mod transfer;
#[cfg(feature = "files")]
mod views;

pub use settings::{Background, Compression, Disparity, LightFieldSettings, Preset, Transfer};

use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::methods::bake::Baked;
use crate::methods::lookup::environment_map::{EnvironmentMapSettings, ReflectorMaps};
use crate::methods::lookup::memory::fit_into_memory;
use crate::methods::lookup::reflector::{ArrivingLight, ReflectorLook, reflector_radiance};
use crate::methods::lookup::shader::draw;
use crate::methods::reference::{Beyond, PathModel, PathTracer};
use crate::methods::{Family, Job, MethodInfo, Quality, ReflectionMethod, Report, Settings};
use crate::progress::Progress;
use crate::scene::shade::Encounter;
use crate::scene::{Projection, Ray, RayDifferential, Role, Scene};
use crate::surface::tracer::Tracer;
use bake::SlabsWork;
use glam::Vec3;
pub use slabs::{SlabCoordinates, Slabs};
use std::sync::Arc;
use stored::stored_radiance;
use transfer::RayTransfer;

/// What light fields are.
pub static INFO: MethodInfo = MethodInfo {
    id: "light_field",
    family: Family::Lookup,
    summary: "six light-field slabs about each region of reflectors, fetched by the reflected ray",
    paper: "Yu, Yang, McMillan 2005, Real-time reflection mapping with parallax",
    assumptions: "nothing but reflectors and lenses is in a region",
    cpu: true,
    gpu: false,
    bake: Some(|table, scene, quality| {
        let settings = LightFieldSettings::from_table(table)?;
        Ok(Box::new(SlabsWork::for_baking(&settings, scene, quality)?))
    }),
    settings: LightFieldSettings::describe,
    in_force: LightFieldSettings::in_force,
    create: |table| {
        let settings = LightFieldSettings::from_table(table)?;
        Ok(Box::new(LightField { settings, baked: None, fields: None }))
    },
};

/// The manifest of views that another renderer is to make of a scene, with the camera of each: what the setting `views` names
/// once they are there.
///
/// # Errors
/// [`RenderError::Limit`] where the scene has no region and no reflector, [`RenderError::Setting`] where it has several regions.
#[cfg(feature = "files")]
pub fn views_manifest(settings: &LightFieldSettings, scene: &Scene) -> Result<String, RenderError> {
    let settings = LightFieldSettings { views: String::new(), ..settings.clone() };
    SlabsWork::for_baking(&settings, scene, Quality { samples: 1, order: 1 })?.manifest()
}

struct LightField {
    settings: LightFieldSettings,
    /// What slabs are taken from in place of capturing them.
    baked: Option<Arc<dyn Baked>>,
    fields: Option<Fields>,
}

/// What all reflectors and lenses look up.
struct Fields {
    /// What the slabs hold: [`SlabsWork::fingerprint`].
    fingerprint: u64,
    /// Of every object its region's number, if it lies in one.
    region_of: Vec<Option<u32>>,
    regions: Vec<Region>,
    /// Highest number of specular events of a path.
    order: u32,
    /// Of objects outside all regions.
    maps: ReflectorMaps,
}

/// A region with what is in it.
struct Region {
    slabs: Slabs,
    inside: Inside,
}

/// How rays get from a region's surfaces out of it.
enum Inside {
    /// By one event.
    First,
    /// By paths that are traced among its reflectors and lenses.
    Traced(Tracer),
    /// By rays that were traced and kept.
    Stored(RayTransfer),
}

impl ReflectionMethod for LightField {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn take_bake(&mut self, baked: Arc<dyn Baked>) -> Result<(), RenderError> {
        self.baked = Some(baked);
        self.fields = None;
        Ok(())
    }

    fn prepare(&mut self, scene: &Scene, quality: Quality, progress: &dyn Progress) -> Result<Report, RenderError> {
        let mut watch = Stopwatch::new();
        let mut report = Report::default();
        let work = SlabsWork::new(&self.settings, scene, quality)?;
        if self.settings.transfer == Transfer::Stored {
            let (st, uv) = (self.settings.transfer_st, self.settings.transfer_uv);
            let bytes = RayTransfer::most_bytes([st, uv]) * work.region_count() as u64;
            fit_into_memory(
                INFO.id,
                &format!("rays of transfer_st = {st} and transfer_uv = {uv}"),
                bytes,
                "transfer = traced",
            )?;
        }
        let fingerprint = work.fingerprint();
        let slabs = match (self.fields.take(), &self.baked) {
            // What moves, moves within the regions.
            (Some(known), _) if known.fingerprint == fingerprint => {
                known.regions.into_iter().map(|region| region.slabs).collect()
            }
            (Some(_), Some(_)) => {
                let problem = "the scene is no longer that of the baked file: without a [region] that reflectors stay in, \
                               a bake is of one moment";
                return Err(RenderError::Limit { method: INFO.id, problem: problem.into() });
            }
            (None, Some(baked)) => work.baked(baked)?,
            (_, None) => {
                let slabs = work.captured(progress)?;
                report.counts.insert("captured_rays", slabs.iter().map(Slabs::ray_count).sum());
                slabs
            }
        };
        report.stages_ms.push((if self.baked.is_some() { "bake_load" } else { "capture" }, watch.lap_ms()));
        let region_of = work.regions.region_of;
        let region = |(number, slabs): (usize, Slabs)| {
            let is_inside = |object: u32| region_of[object as usize] == Some(number as u32);
            let inside = match self.settings.transfer {
                Transfer::First => Inside::First,
                Transfer::Traced => Inside::Traced(Tracer::build(scene, is_inside)),
                Transfer::Stored => {
                    let tracer = Tracer::build(scene, is_inside);
                    let is_lens = |object: &u32| scene.material_of(*object).role == Role::Lens && is_inside(*object);
                    let has_lenses = scene.specular_objects().iter().any(is_lens);
                    let sizes = [self.settings.transfer_st, self.settings.transfer_uv];
                    let bounds = &work.regions.boxes[number];
                    let order = quality.order;
                    Inside::Stored(RayTransfer::capture(scene, &tracer, bounds, sizes, order, has_lenses, progress))
                }
            };
            Region { slabs, inside }
        };
        let regions: Vec<Region> = slabs.into_iter().enumerate().map(region).collect();
        let stored: Vec<&RayTransfer> = regions
            .iter()
            .filter_map(|region| match &region.inside {
                Inside::Stored(transfer) => Some(transfer),
                _ => None,
            })
            .collect();
        if !stored.is_empty() {
            report.stages_ms.push(("ray_transfer", watch.lap_ms()));
            report.bytes.insert("ray_transfer", stored.iter().map(|transfer| transfer.byte_count()).sum());
            report.counts.insert("transferred_rays", stored.iter().map(|transfer| transfer.ray_count()).sum());
        }
        let outside = |object: &u32| region_of[*object as usize].is_none();
        let others: Vec<u32> = scene.specular_objects().into_iter().filter(outside).collect();
        let maps = EnvironmentMapSettings::default();
        let maps = ReflectorMaps::capture(&maps, scene, &others, quality.order, progress)?;
        report.stages_ms.push(("environment_maps", watch.lap_ms()));
        report.counts.insert("regions", regions.len() as u64);
        report.bytes.insert("slabs", regions.iter().map(|region| region.slabs.byte_count()).sum());
        if !others.is_empty() {
            report.fallbacks.insert("reflectors_with_environment_maps", others.len() as u64);
            report.bytes.insert("environment_maps", maps.byte_count());
        }
        if !regions.is_empty() && self.baked.is_none() {
            let (st, uv) = (self.settings.st, self.settings.uv);
            report.warnings.push(format!(
                "light_field: captured {st} x {st} views of {uv} x {uv} a slab in memory; `catoptric bake` keeps larger ones"
            ));
        }
        self.fields = Some(Fields { fingerprint, region_of, regions, order: quality.order, maps });
        Ok(report)
    }

    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError> {
        let Some(fields) = self.fields.as_ref().filter(|fields| fields.region_of.len() == job.scene.objects.len())
        else {
            let problem = "it has not been prepared for the scene".into();
            return Err(RenderError::Limit { method: INFO.id, problem });
        };
        // Orthographic views have no eye that could be in a region.
        let eye = matches!(job.view.projection, Projection::Perspective { .. }).then(|| job.view.eye());
        let region = eye.and_then(|eye| fields.regions.iter().position(|region| region.slabs.holds(eye)));
        match (self.settings.background, region) {
            (Background::Scene, _) => draw(job, &Seen { fields, behind: None }, |_| true, target),
            (Background::Slabs, Some(region)) => {
                let seen = Seen { fields, behind: Some(&fields.regions[region].slabs) };
                let is_wanted = |object: u32| fields.region_of[object as usize] == Some(region as u32);
                draw(job, &seen, is_wanted, target)
            }
            (Background::Slabs, None) => {
                let mut report = draw(job, &Seen { fields, behind: None }, |_| true, target)?;
                report.fallbacks.insert("frames_with_a_drawn_background", 1);
                report.warnings.push(
                    "light_field: the eye is in no region, so the scene is drawn behind its reflectors; \
                     give the scene a [region] that holds the eye"
                        .into(),
                );
                Ok(report)
            }
        }
    }
}

/// All that a view shows.
struct Seen<'a> {
    fields: &'a Fields,
    /// What is seen behind reflectors, in place of the scene.
    behind: Option<&'a Slabs>,
}

impl ReflectorLook for Seen<'_> {
    fn radiance(&self, scene: &Scene, encounter: &Encounter, ray: &Ray, change: &RayDifferential) -> Vec3 {
        self.fields.radiance(scene, encounter, ray, change)
    }

    fn behind(&self, scene: &Scene, ray: &Ray, change: &RayDifferential) -> Vec3 {
        match self.behind {
            Some(slabs) => Beyond::radiance(&slabs, scene, ray, Some(change)),
            None => scene.background(ray.direction),
        }
    }
}

impl Fields {
    fn radiance(&self, scene: &Scene, encounter: &Encounter, ray: &Ray, change: &RayDifferential) -> Vec3 {
        let region = self.region_of[encounter.point.object as usize];
        let Some(Region { slabs, inside }) = region.and_then(|region| self.regions.get(region as usize)) else {
            return self.maps.radiance(scene, encounter, ray, change);
        };
        match inside {
            Inside::First => reflector_radiance(Some(slabs), scene, encounter, ray, change),
            Inside::Stored(transfer) => stored_radiance(slabs, transfer, scene, encounter, ray, change),
            Inside::Traced(tracer) => PathTracer::with_beyond(scene, tracer, PathModel::Tree, self.order, slabs)
                .radiance_from(*ray, Some(*change), encounter),
        }
    }
}

impl Beyond for &Slabs {
    fn radiance(&self, scene: &Scene, ray: &Ray, change: Option<&RayDifferential>) -> Vec3 {
        let none = RayDifferential::default();
        let RayDifferential { origin_dx, origin_dy, direction_dx, direction_dy } = change.unwrap_or(&none);
        Slabs::radiance(self, ray.origin, ray.direction, [*origin_dx, *origin_dy], [*direction_dx, *direction_dy])
            .unwrap_or_else(|| scene.background(ray.direction))
    }
}

impl ArrivingLight for Slabs {
    fn radiance(&self, scene: &Scene, encounter: &Encounter, direction: Vec3, change: [Vec3; 2]) -> Vec3 {
        Slabs::radiance(self, encounter.point.position, direction, encounter.position_change, change)
            .unwrap_or_else(|| scene.background(direction))
    }

    fn distance(&self, position: Vec3, direction: Vec3) -> f32 {
        Slabs::distance(self, position, direction)
    }
}
