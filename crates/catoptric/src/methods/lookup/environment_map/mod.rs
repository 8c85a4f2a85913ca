//! Environment maps: what engines use today.
//!
//! See this folder's `README.md`.

mod cube_map;
mod parallax;
mod settings;
mod shader;

pub use settings::{EnvironmentMapSettings, Parallax, Source};

use crate::clock::Stopwatch;
use crate::error::RenderError;
use crate::framebuffer::Framebuffer;
use crate::math::Aabb;
use crate::methods::{Family, Job, MethodInfo, Quality, ReflectionMethod, Report, Settings};
use crate::progress::Progress;
use crate::raster;
use crate::scene::Scene;
use cube_map::CubeMap;
use parallax::Surround;
use shader::{MapShader, ReflectorMap};

/// What environment maps are.
pub static INFO: MethodInfo = MethodInfo {
    id: "environment_map",
    family: Family::Lookup,
    summary: "a cube map captured at each reflector's centre; at infinity, or corrected for a box or sphere",
    paper: "Blinn, Newell 1976, Texture and reflection in computer generated images; Greene 1986; \
            parallax correction: Lagarde, Zanuttini 2012",
    assumptions: "the surround is infinitely far, or lies on a box or sphere; one reflection, one refraction",
    cpu: true,
    gpu: false,
    bake: false,
    settings: EnvironmentMapSettings::describe,
    create: |table| {
        Ok(Box::new(EnvironmentMap { settings: EnvironmentMapSettings::from_table(table)?, maps: Vec::new() }))
    },
};

struct EnvironmentMap {
    settings: EnvironmentMapSettings,
    /// For every object of the scene; none for diffuse ones and, with order 0, for all.
    maps: Vec<Option<ReflectorMap>>,
}

impl ReflectionMethod for EnvironmentMap {
    fn info(&self) -> &'static MethodInfo {
        &INFO
    }

    fn prepare(&mut self, scene: &Scene, quality: Quality, progress: &dyn Progress) -> Result<Report, RenderError> {
        let mut watch = Stopwatch::new();
        self.maps = vec![None; scene.objects.len()];
        let reflectors = scene.specular_objects();
        let mut report = Report::default();
        if quality.order > 0 {
            let rounds = match self.settings.source {
                Source::Capture => quality.order,
                Source::Environment => 1,
            };
            progress.begin("capturing environment maps", u64::from(rounds) * reflectors.len() as u64);
            for _ in 0..rounds {
                // The reflectors of one round all show the maps of the round before.
                let mut captured = vec![None; scene.objects.len()];
                for &object in &reflectors {
                    captured[object as usize] = Some(self.map(scene, object, &mut report)?);
                    progress.advance(1);
                }
                self.maps = captured;
            }
            progress.end();
        }
        let bytes = self.maps.iter().flatten().filter_map(|map| map.cube.as_ref()).map(CubeMap::byte_count).sum();
        report.stages_ms = vec![("capture", watch.lap_ms())];
        report.bytes.insert("environment_maps", bytes);
        Ok(report)
    }

    fn render(&mut self, job: &Job<'_>, target: &mut Framebuffer) -> Result<Report, RenderError> {
        if self.maps.len() != job.scene.objects.len() {
            let problem = "it has not been prepared for the scene".into();
            return Err(RenderError::Limit { method: INFO.id, problem });
        }
        let mut report = Report::default();
        let mut watch = Stopwatch::new();
        let list = raster::scene_draw_list(job.scene, job.view, |_| Some(0));
        report.stages_ms.push(("project", watch.lap_ms()));
        report.counts.insert("vertices_projected", list.vertices.len() as u64);
        let shader = MapShader { scene: job.scene, rays: job.view.rays(), maps: &self.maps };
        report.add_raster(&raster::draw(job.view, job.quality.samples, &[list], &shader, target)?);
        Ok(report)
    }
}

impl EnvironmentMap {
    /// The map of one reflector, with the other reflectors as they look so far.
    fn map(&self, scene: &Scene, object: u32, report: &mut Report) -> Result<ReflectorMap, RenderError> {
        let center = scene.objects[object as usize].bounds.center();
        let surround = Surround::new(&self.settings, &diffuse_bounds(scene));
        let cube = match self.settings.source {
            Source::Environment => None,
            Source::Capture => Some(self.capture(scene, object, center, report)?),
        };
        Ok(ReflectorMap { center, cube, surround })
    }

    fn capture(
        &self,
        scene: &Scene,
        object: u32,
        center: glam::Vec3,
        report: &mut Report,
    ) -> Result<CubeMap, RenderError> {
        let mut pictures = Vec::with_capacity(6);
        for face in 0..6 {
            let view = CubeMap::face_view(face, center, self.settings.size, scene.near());
            let list = raster::scene_draw_list(scene, &view, |other| (other != object).then_some(0));
            let shader = MapShader { scene, rays: view.rays(), maps: &self.maps };
            let mut picture = Framebuffer::new(view.width, view.height);
            raster::draw(&view, self.settings.capture_samples, &[list], &shader, &mut picture)?;
            pictures.push(picture.pixels);
        }
        *report.counts.entry("captured_faces").or_default() += 6;
        Ok(CubeMap::new(self.settings.size, pictures))
    }
}

/// The box around everything that does not reflect.
fn diffuse_bounds(scene: &Scene) -> Aabb {
    let diffuse = (0..scene.objects.len()).filter(|&object| !scene.role_of(object as u32).is_specular());
    diffuse.map(|object| scene.objects[object].bounds).fold(Aabb::EMPTY, Aabb::union)
}
