//! Environment light-field slabs: the light that arrives at a region, along all rays.
//!
//! See this folder's `README.md`.

mod bake;
mod capture;
mod fields;
pub(crate) mod layout;
mod limits;
mod paths;
mod settings;
pub(crate) mod slabs;
mod stored;
pub(crate) mod transfer;

pub use settings::{Background, Compression, Disparity, Layout, LightFieldSettings, Preset, Transfer};

use bake::SlabsWork;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::progress::Progress;
use catoptric_core::scene::shade::SurfaceInteraction;
use catoptric_core::scene::{Projection, Ray, RayDifferential, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::radiance_field::RadianceField;
use catoptric_engine::light::reflector_shader::ReflectorShader;
use catoptric_engine::method::bake::Baked;
use catoptric_engine::method::lookup_shader::{draw, shown_paths};
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::method::{About, Family, Frame, Job, Method, MethodInfo, Prepared, Quality, Report, Settings};
pub use fields::LightFields;
use glam::Vec3;
use paths::FieldPaths;
pub use slabs::tables::{SlabPlane, SlabTables};
pub use slabs::{SlabCoordinates, Slabs};
use std::sync::Arc;

/// Description of the method in the registry.
pub static INFO: MethodInfo = MethodInfo {
    id: "light_field",
    family: Family::Lookup,
    summary: "six light-field slabs about each region of reflectors, fetched by the reflected ray",
    paper: "Yu, Yang, McMillan 2005, Real-time reflection mapping with parallax",
    assumptions: "nothing but reflectors and lenses is in a region",
    about: About {
        readme: include_str!("README.md"),
        draws: "the scene by its triangles; reflected and refracted rays by look-ups between captured views around \
            the reflectors",
        costs: "a capture beforehand, a second or two and 46 MB a region (preset=full: 738 MB), or once by \
            `catoptric bake`; then a reflector's cost does not depend on the scene",
        cannot: "detail finer than the pixels of a view is blurred, and edges of near things are ragged with few views",
        useful: &["preset", "layout", "disparity", "transfer"],
    },
    cpu: true,
    gpu: true,
    bake: Some(|table, scene, quality| {
        let settings = LightFieldSettings::from_table(table)?;
        Ok(Box::new(SlabsWork::for_baking(&settings, scene, quality)?))
    }),
    settings: LightFieldSettings::describe,
    effective: LightFieldSettings::effective,
    limits: &limits::LIMITS,
    create: |table| {
        let settings = LightFieldSettings::from_table(table)?;
        Ok(Box::new(LightField { settings }))
    },
};

/// The manifest of views that another renderer is to make of a scene, with the camera of each: the file that the
/// setting `views` names once the views exist.
///
/// # Errors
/// [`RenderError::Limit`] where the scene has no region and no reflector, [`RenderError::Setting`] where it has
/// several regions.
#[cfg(feature = "files")]
pub fn views_manifest(settings: &LightFieldSettings, scene: &Scene) -> Result<String, RenderError> {
    let settings = LightFieldSettings { views: String::new(), ..settings.clone() };
    SlabsWork::for_baking(&settings, scene, Quality { samples: 1, order: 1 })?.manifest()
}

struct LightField {
    settings: LightFieldSettings,
}

/// The light fields of a scene.
struct PreparedFields {
    settings: LightFieldSettings,
    scene: Arc<Scene>,
    quality: Quality,
    /// The source of slabs, where they are not captured.
    baked: Option<Arc<dyn Baked>>,
    fields: LightFields,
    report: Report,
}

/// A frame: the prepared method for one view.
struct FieldsFrame<'a> {
    prepared: &'a PreparedFields,
    view: View,
}

impl Method for LightField {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn overlays(&self) -> &'static [OverlayKind] {
        &[OverlayKind::Paths]
    }

    fn prepare(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn Baked>>,
        progress: &dyn Progress,
    ) -> Result<Box<dyn Prepared>, RenderError> {
        let (fields, report) = LightFields::new(&self.settings, scene, quality, bake.as_ref(), None, progress)?;
        let (settings, scene) = (self.settings.clone(), scene.clone());
        Ok(Box::new(PreparedFields { settings, scene, quality, baked: bake, fields, report }))
    }
}

impl Prepared for PreparedFields {
    fn report(&self) -> &Report {
        &self.report
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        let (baked, old) = (self.baked.as_ref(), Some(&self.fields));
        let (fields, report) = LightFields::new(&self.settings, scene, quality, baked, old, progress)?;
        (self.fields, self.report, self.scene, self.quality) = (fields, report, scene.clone(), quality);
        Ok(())
    }

    fn frame<'a>(&'a mut self, view: &View, _progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError> {
        Ok(Box::new(FieldsFrame { prepared: self, view: view.clone() }))
    }
}

impl Frame for FieldsFrame<'_> {
    fn report(&self) -> &Report {
        Report::none()
    }

    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError> {
        let PreparedFields { settings, scene, quality, fields, .. } = self.prepared;
        let job = &Job { scene, view: &self.view, quality: *quality, progress };
        let region = self.region_of_eye();
        match (settings.background, region) {
            (Background::Scene, _) => draw(job, &FieldShader { fields, behind: None }, |_| true, target),
            (Background::Slabs, Some(region)) => {
                let seen = FieldShader { fields, behind: Some(&*fields.regions[region].slabs) };
                let is_wanted = |object: u32| fields.region_of[object as usize] == Some(region as u32);
                draw(job, &seen, is_wanted, target)
            }
            (Background::Slabs, None) => {
                let mut report = draw(job, &FieldShader { fields, behind: None }, |_| true, target)?;
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

    fn overlay(&self, kind: OverlayKind, progress: &dyn Progress) -> Result<Option<Overlay>, RenderError> {
        if kind != OverlayKind::Paths {
            return Ok(None);
        }
        let PreparedFields { settings, scene, quality, fields, .. } = self.prepared;
        let job = &Job { scene, view: &self.view, quality: *quality, progress };
        let region = self.region_of_eye().filter(|_| settings.background == Background::Slabs);
        let is_wanted = |object: u32| match region {
            Some(region) => fields.region_of[object as usize] == Some(region as u32),
            None => true,
        };
        let paths = FieldPaths::new(fields, scene, progress)?;
        shown_paths(job, |encounter, ray, change| paths.bounces(scene, encounter, ray, change), is_wanted).map(Some)
    }
}

impl FieldsFrame<'_> {
    /// The region that the eye is in; orthographic views have no eye that could be in one.
    fn region_of_eye(&self) -> Option<usize> {
        let is_perspective = matches!(self.view.projection, Projection::Perspective { .. });
        let eye = is_perspective.then(|| self.view.eye())?;
        self.prepared.fields.regions.iter().position(|region| region.slabs.holds(eye))
    }
}

/// The shader of a view.
struct FieldShader<'a> {
    fields: &'a LightFields,
    /// Slabs that replace the scene behind reflectors.
    behind: Option<&'a Slabs>,
}

impl ReflectorShader for FieldShader<'_> {
    fn radiance(&self, scene: &Scene, encounter: &SurfaceInteraction, ray: &Ray, change: &RayDifferential) -> Vec3 {
        self.fields.radiance(scene, encounter, ray, change)
    }

    fn behind(&self, scene: &Scene, ray: &Ray, change: &RayDifferential) -> Vec3 {
        match self.behind {
            Some(slabs) => RadianceField::radiance(slabs, scene, ray, Some(change)),
            None => scene.background(ray.direction),
        }
    }
}
