//! Pictures of the parts of layered environment maps: the adaptive mesh, the picture of each layer, and the layers
//! inferred from that (Hakura, Snyder 2001, figures 5 and 7).

use super::inference::Inference;
use super::mesh::{self, AdaptiveMesh, Criteria};
use super::settings::LayeredEnvironmentMapSettings;
use super::shells::layer_geometry::LayerGeometry;
use super::textures::texture::LayerTexture;
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::progress::Progress;
use catoptric_core::scene::{Scene, ViewRays};
use catoptric_engine::error::RenderError;
use catoptric_engine::method::{Job, Quality, Settings};
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::raster::{self, Fragment, LookShader, ShadingRequest};
use glam::Vec3;

/// The factor by which each division of a triangle is shown darker.
const DARKER: f32 = 0.6;

/// A layer of one viewpoint, as inferred. Pictures have linear colours times opacity, and opacity.
#[derive(Clone, Debug)]
pub struct InferredLayer {
    /// The kind of its shell, as in reports.
    pub shell: &'static str,
    /// The group's traced picture of the layer by the path that is reflected first: a right-hand side of the equations.
    pub reflected: Framebuffer,
    /// The same picture by the path that is refracted first.
    pub refracted: Framebuffer,
    /// The finest level of the texture that is inferred from both: a square; or the faces of a cube, three above three
    /// (+x, -x, +y, then -y, +z, -z).
    pub texture: Framebuffer,
}

/// The layers about a group of reflectors and lenses, the nearest first, inferred for one of its viewpoints.
///
/// # Errors
/// [`RenderError::Setting`] for settings that are not allowed; [`RenderError::Limit`] where the scene has no such group
/// or the group no such viewpoint, and where textures do not fit into memory.
pub fn inferred_layers(
    settings: &LayeredEnvironmentMapSettings,
    scene: &Scene,
    quality: Quality,
    [group, viewpoint]: [u32; 2],
    progress: &dyn Progress,
) -> Result<Vec<InferredLayer>, RenderError> {
    let settings = &settings.sized();
    let known = known_by(settings, scene, quality)?;
    known.check_memory(settings, 2)?;
    let number = group as usize;
    let limit = |problem: String| RenderError::Limit { method: LayeredEnvironmentMapSettings::METHOD, problem };
    let Some(about) = known.groups.get(number) else {
        return Err(limit(format!("there is no group {group}; the scene has {}", known.groups.len())));
    };
    if viewpoint >= about.viewspace.count() {
        return Err(limit(format!("there is no viewpoint {viewpoint}; the group has {}", about.viewspace.count())));
    }
    let inference = Inference { scene, settings, known: &known };
    let seen = inference.seen(number, viewpoint)?;
    let mut layers = Vec::new();
    for part in [number].into_iter().chain(known.groups.len()..known.part_count()) {
        let projected = known.projected_part(settings, scene, part, progress)?;
        layers.extend(inference.infer(part, &projected, viewpoint, progress)?.0);
    }
    let size = settings.picture_size;
    let layer = |index: usize| {
        let mut pictures =
            BounceKind::BOTH.map(|_| Framebuffer { pixels: clear(size * size), ..Framebuffer::new(size, size) });
        for (number, observation) in seen.list.iter().enumerate() {
            let [x, y] = observation.pixel;
            let picture = &mut pictures[observation.first as usize];
            picture.pixels[(y * size + x) as usize] = seen.seen(number, index).to_array();
        }
        let [reflected, refracted] = pictures;
        let layer = &layers[index];
        InferredLayer { shell: layer.shell.name(), reflected, refracted, texture: unfolded(&layer.texture) }
    };
    Ok((0..layers.len()).map(layer).collect())
}

/// Checks settings against a scene.
fn known_by(
    settings: &LayeredEnvironmentMapSettings,
    scene: &Scene,
    quality: Quality,
) -> Result<LayerGeometry, RenderError> {
    settings
        .check()
        .map_err(|problem| RenderError::Setting { method: LayeredEnvironmentMapSettings::METHOD, problem })?;
    Ok(LayerGeometry::new(settings, scene, quality.order))
}

fn clear(pixels: u32) -> Vec<[f32; 4]> {
    vec![[0.0; 4]; pixels as usize]
}

/// The finest level of a texture as a picture.
fn unfolded(texture: &LayerTexture) -> Framebuffer {
    let (size, faces) = (texture.layout.size(), texture.layout.faces());
    let columns = faces.min(3);
    let mut picture = Framebuffer::new(columns * size, faces / columns * size);
    for face in 0..faces {
        for y in 0..size {
            let from = ((face * size + y) * size) as usize;
            let to = ((face / columns * size + y) * picture.width + face % columns * size) as usize;
            let row = texture.texels[from..][..size as usize].iter().map(|texel| texel.value().to_array());
            picture.pixels[to..][..size as usize].iter_mut().zip(row).for_each(|(pixel, texel)| *pixel = texel);
        }
    }
    picture
}

/// Draws reflectors and lenses lighter or darker by how often the triangle of the adaptive mesh that is seen was
/// divided, before the scene.
///
/// # Errors
/// [`RenderError::Setting`] for settings that are not allowed; those of [`raster::draw`].
pub fn subdivision(
    settings: &LayeredEnvironmentMapSettings,
    job: &Job<'_>,
    target: &mut Framebuffer,
) -> Result<(), RenderError> {
    let (scene, view, samples) = (job.scene, job.view, job.quality.samples);
    let known = known_by(settings, scene, job.quality)?;
    let paths = |object: u32| known.paths(scene, object);
    let (lists, mesh) = mesh::drawn(job, &known.welds, &paths, Criteria::of(settings), |_| true)?;
    let shader = LevelShader { scene, rays: view.rays(), mesh: &mesh };
    raster::draw(view, samples, &lists, &shader, target, job.progress)?;
    Ok(())
}

struct LevelShader<'a> {
    scene: &'a Scene,
    rays: ViewRays,
    mesh: &'a AdaptiveMesh,
}

impl LookShader for LevelShader<'_> {
    fn scene(&self) -> &Scene {
        self.scene
    }

    fn look(&self, fragment: &Fragment<'_>) -> ShadingRequest {
        let ray = self.rays.ray(fragment.position.x, fragment.position.y);
        let Some(surface) = fragment.chain.first() else {
            return ShadingRequest::Color(self.scene.background(ray.direction));
        };
        if !self.scene.role_of(self.scene.triangle_objects[surface.source as usize]).is_specular() {
            return ShadingRequest::of_diffuse(self.scene, surface, &ray, Vec3::ONE, Vec3::ZERO);
        }
        let level = self.mesh.leaves.get(surface.group as usize).map_or(0, |leaf| leaf.level);
        ShadingRequest::Color(Vec3::splat(DARKER.powi(level as i32)))
    }
}
