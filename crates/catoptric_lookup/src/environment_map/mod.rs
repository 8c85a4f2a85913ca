//! Environment maps, as engines use them today.
//!
//! See this folder's `README.md`.

mod limits;
mod project;
mod settings;

pub use catoptric_engine::light::cube_map::CubeMap;
pub use catoptric_engine::light::parallax_proxy::ParallaxProxy;
pub use catoptric_engine::method::reflector_maps::ReflectorCubeMap;
pub use project::MapPlaces;
pub use settings::{EnvironmentMapSettings, Parallax, Source};

use catoptric_core::clock::Stopwatch;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::progress::Progress;
use catoptric_core::scene::{Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::method::bake::Baked;
use catoptric_engine::method::lookup_shader::{draw, shown_paths};
use catoptric_engine::method::overlay::{Overlay, OverlayKind};
use catoptric_engine::method::reflector_maps::ReflectorMaps;
use catoptric_engine::method::{About, Family, Frame, Job, Method, MethodInfo, Prepared, Quality, Report, Settings};
use std::sync::Arc;

/// Description of the method in the registry.
pub static INFO: MethodInfo = MethodInfo {
    id: "environment_map",
    family: Family::Lookup,
    summary: "a cube map captured at each reflector's centre; at infinity, or corrected for a box or sphere",
    paper: "Blinn, Newell 1976, Texture and reflection in computer generated images; Greene 1986; \
            parallax correction: Lagarde, Zanuttini 2012",
    assumptions: "the surround is infinitely far, or lies on a box or sphere; one reflection, one refraction",
    about: About {
        readme: include_str!("README.md"),
        draws: "the scene by its triangles; mirrors and glass by one look-up a ray in a cube map of their surroundings",
        costs: "the surroundings of each reflector are captured beforehand, anew for each further order; frames are \
            cheap then, whatever the scene",
        cannot: "near things appear in the wrong place and size, no reflector shows itself, and glass refracts once, \
            as if filled to infinity",
        useful: &["parallax", "size", "source"],
    },
    cpu: true,
    gpu: true,
    bake: None,
    settings: EnvironmentMapSettings::describe,
    effective: EnvironmentMapSettings::effective,
    limits: &limits::LIMITS,
    create: |table| {
        let settings = EnvironmentMapSettings::from_table(table)?;
        Ok(Box::new(EnvironmentMap { settings }))
    },
};

struct EnvironmentMap {
    settings: EnvironmentMapSettings,
}

/// The maps of all reflectors and lenses of a scene; of none with order 0.
struct PreparedMaps {
    settings: EnvironmentMapSettings,
    scene: Arc<Scene>,
    quality: Quality,
    maps: ReflectorMaps,
    report: Report,
}

/// A frame: the prepared method for one view.
struct MapsFrame<'a> {
    prepared: &'a PreparedMaps,
    view: View,
}

impl Method for EnvironmentMap {
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
        INFO.refuse_bake(bake)?;
        Ok(Box::new(PreparedMaps::new(&self.settings, scene, quality, progress)?))
    }
}

fn capture_maps(
    settings: &EnvironmentMapSettings,
    scene: &Scene,
    order: u32,
    progress: &dyn Progress,
) -> Result<(ReflectorMaps, Report), RenderError> {
    let mut watch = Stopwatch::new();
    let maps = ReflectorMaps::capture(&settings.into(), scene, &scene.specular_objects(), order, progress)?;
    let mut report = Report { stages_ms: vec![("capture", watch.lap_ms())], ..Report::default() };
    report.counts.insert("captured_faces", maps.captured_faces());
    report.bytes.insert("environment_maps", maps.byte_count());
    maps.add_fallbacks(&mut report);
    Ok((maps, report))
}

/// The maps of a scene's objects (of those that reflect or refract, up to an order of reflections above 0), and how
/// they were made: for other processors to look up.
///
/// # Errors
/// [`RenderError::Limit`] where the rasteriser refuses a face, [`RenderError::Cancelled`].
pub fn capture(
    settings: &EnvironmentMapSettings,
    scene: &Scene,
    order: u32,
    progress: &dyn Progress,
) -> Result<(Vec<Option<ReflectorCubeMap>>, Report), RenderError> {
    capture_maps(settings, scene, order, progress).map(|(maps, report)| (maps.into_maps(), report))
}

impl PreparedMaps {
    fn new(
        settings: &EnvironmentMapSettings,
        scene: &Arc<Scene>,
        quality: Quality,
        progress: &dyn Progress,
    ) -> Result<Self, RenderError> {
        let (maps, report) = capture_maps(settings, scene, quality.order, progress)?;
        Ok(Self { settings: settings.clone(), scene: scene.clone(), quality, maps, report })
    }
}

impl Prepared for PreparedMaps {
    fn report(&self) -> &Report {
        &self.report
    }

    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError> {
        *self = Self::new(&self.settings, scene, quality, progress)?;
        Ok(())
    }

    fn frame<'a>(&'a mut self, view: &View, _progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError> {
        Ok(Box::new(MapsFrame { prepared: self, view: view.clone() }))
    }
}

impl Frame for MapsFrame<'_> {
    fn report(&self) -> &Report {
        Report::none()
    }

    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError> {
        let PreparedMaps { scene, quality, maps, .. } = self.prepared;
        draw(&Job { scene, view: &self.view, quality: *quality, progress }, maps, |_| true, target)
    }

    /// Paths have one bounce: the contents of a map are looked up as if they were infinitely far, or on the proxy.
    fn overlay(&self, kind: OverlayKind, progress: &dyn Progress) -> Result<Option<Overlay>, RenderError> {
        if kind != OverlayKind::Paths {
            return Ok(None);
        }
        let PreparedMaps { scene, quality, maps, .. } = self.prepared;
        let job = Job { scene, view: &self.view, quality: *quality, progress };
        shown_paths(&job, |encounter, ray, _| maps.bounces(scene, encounter, ray), |_| true).map(Some)
    }
}
