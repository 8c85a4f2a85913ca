//! Scenes: models, their pose at a moment, materials, textures, shading and views.

mod animation;
mod blend;
pub mod edits;
pub mod enclosure;
pub mod hit;
mod identity;
mod light;
mod material;
pub mod model;
mod name_pattern;
mod pose;
pub mod roles;
mod shading;
mod shadows;
mod view;

pub use blend::{Attenuation, Blend};
pub use light::{Light, LightKind};
pub use material::{
    AlphaMode, Film, LobeTexture, Lobes, Material, Microfacets, NormalMap, OcclusionMap, Role, SHARP_ROUGHNESS,
    TextureBinding,
};
pub use model::Model;
pub use pose::{MAX_TRIANGLES, PoseMemory, PoseOptions};
pub use shading::batch::{ShadingQueue, SurfaceQuery};
pub use shading::bumps::TurnedEncounter;
pub use shading::environment::{Environment, Lamp, Lamps, LightMap};
#[doc(hidden)]
pub use shading::filter::{TextureLookUps, floor, index, log2, sample};
pub use shading::lobes::LobesAt;
pub use shading::microfacets;
pub use shading::sample_patterns::SAMPLE_PATTERNS;
pub use shading::shade;
#[doc(hidden)]
pub use shading::sheen::{SheenLobe, albedo as sheen_albedo};
pub use shading::sky::{Emitters, Sky};
pub use shading::texture::{MipFilter, MipLevel, Sampler, Texture, UvFootprint, Wrap};
pub use shading::thin_film::{FilmAt, FilmReflectance};
pub use view::{Camera, PicturePoint, PictureTransform, PreciseView, Projection, Ray, RayDifferential, View, ViewRays};

use crate::error::SceneError;
use crate::math::Aabb;
use crate::surface::{PlacedSurface, SurfaceHit};
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::any::Any;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

/// A scene at one moment, in world space: one set of flat arrays that every method reads.
///
/// Triangles of an object, and their vertices, are contiguous. Objects with an analytic surface carry triangles
/// too (for rasterisation); rays meet the exact surface instead.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The file or built-in scene it came from.
    pub name: String,
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Unit shading normals, one a vertex, on the outer side.
    pub normals: Vec<Vec3>,
    /// Two sets of texture coordinates a vertex.
    pub uvs: Vec<[Vec2; 2]>,
    /// Linear vertex colours; empty when the whole scene has none.
    pub colors: Vec<[f32; 4]>,
    /// Tangents of normal maps, along the texture's u: unit vectors, then the sign of the bitangent `normal x tangent`;
    /// empty when the whole scene has no normal map.
    pub tangents: Vec<Vec4>,
    /// Where the scene's origin lies in the coordinates of its file: what is far from the file's origin is moved to the
    /// scene's before it is rounded to single precision.
    pub origin: DVec3,
    /// Vertex indices of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// The object of each triangle.
    pub triangle_objects: Vec<u32>,
    /// For each triangle a number (not 0) that is equal in triangles connected by common vertices: parts of one smooth
    /// surface. Where it is missing a triangle is a surface of its own.
    pub triangle_parts: Vec<u32>,
    /// The objects of the scene.
    pub objects: Vec<Object>,
    /// Materials with their final roles.
    pub materials: Vec<Material>,
    /// Textures of the materials.
    pub textures: Vec<Arc<Texture>>,
    /// Lights of the file.
    pub lights: Vec<Light>,
    /// The means to tell what stands between points and lights; `None`: lights cast no shadows.
    pub light_visibility: Option<Arc<dyn LightVisibility>>,
    /// Light from infinity.
    pub environment: Option<Arc<Environment>>,
    /// The parts of the environment that surfaces see, for the light that they scatter; `None`: all of it.
    pub sky: Option<Arc<Sky>>,
    /// True if a mirror or lens shows light from infinity at the last event that a path may have, as if nothing stood
    /// before it; otherwise it shows nothing there. Look-ups show nothing.
    pub ends_in_environment: bool,
    /// The radiance that the eye sees where nothing stands before it, in place of the light from infinity, which
    /// mirrors, glass and surfaces see still.
    pub backdrop: Option<Vec3>,
    /// Cameras; the first is the default.
    pub cameras: Vec<Camera>,
    /// The box around everything.
    pub bounds: Aabb,
    /// The region in which reflectors or views may move.
    pub region: Option<Aabb>,
}

/// The means of a scene to tell what stands between two points, for shadows of lights.
pub trait LightVisibility: Debug + Send + Sync {
    /// The share of light of each colour that goes straight on along a ray to a distance: 0 behind what is opaque, 1
    /// where nothing stands. The scene is the one that the means were made for.
    fn passing(&self, scene: &Scene, ray: &Ray, distance: f32) -> Vec3;

    /// Sets the shares of a light that arrive at several points, above the surfaces that they belong to: as many as
    /// there are points. The same as one after the other, but faster where they are near each other.
    fn find_passing(&self, scene: &Scene, light: &Light, points: &[Vec3], passing: &mut [Vec3]) {
        for (point, passing) in points.iter().zip(passing) {
            let way = light.way_from(*point);
            *passing = way.map_or(Vec3::ONE, |(ray, distance)| self.passing(scene, &ray, distance));
        }
    }

    /// The first surface along a ray that stops light, if any does.
    fn first_stop(&self, scene: &Scene, ray: &Ray) -> Option<LightStop>;

    /// The hierarchy of what stands in the way, which rays of sight use as well if it is of the same objects.
    fn hierarchy(&self) -> &dyn Any;

    /// The means for another moment of the scene, in which the same triangles are elsewhere; `None` if they have to be
    /// made anew.
    fn moved_to(&self, _scene: &Scene) -> Option<Arc<dyn LightVisibility>> {
        None
    }
}

/// A place where light is stopped.
#[derive(Clone, Copy, Debug)]
pub struct LightStop {
    /// Distance along the ray.
    pub distance: f32,
    /// The surface.
    pub surface: StoppingSurface,
    /// The share of light of each colour that passes what lies before it.
    pub passing: Vec3,
}

/// A surface that stops light, at a place.
#[derive(Clone, Copy, Debug)]
pub enum StoppingSurface {
    /// A triangle, by its number and the barycentric coordinates of its second and third vertex.
    Triangle(u32, Vec2),
    /// The exact surface of an object.
    Exact(u32, SurfaceHit),
}

/// One primitive at one place.
#[derive(Clone, Debug)]
pub struct Object {
    /// Name of the node, else of the mesh.
    pub name: String,
    /// Index of the material; its role is the object's.
    pub material: u32,
    /// The object's triangles, by their numbers in the scene.
    pub triangles: Range<u32>,
    /// Their vertices.
    pub vertices: Range<u32>,
    /// The exact surface that rays meet in place of the triangles.
    pub surface: Option<PlacedSurface>,
    /// The inner side is the mirror and the outer side is opaque and black (analytic reflectors).
    pub inside: bool,
    /// The box around it.
    pub bounds: Aabb,
}

impl Scene {
    /// The material of an object.
    #[inline]
    pub fn material_of(&self, object: u32) -> &Material {
        &self.materials[self.objects[object as usize].material as usize]
    }

    /// The role of an object.
    #[inline]
    pub fn role_of(&self, object: u32) -> Role {
        self.material_of(object).role
    }

    /// The indices of all objects that reflect or refract.
    pub fn specular_objects(&self) -> Vec<u32> {
        (0..self.objects.len() as u32).filter(|&object| self.role_of(object).is_specular()).collect()
    }

    /// The camera of that name or index; if no name is given the first, or one that [frames](Self::framing) the scene
    /// in a picture of this shape (width by height).
    pub fn camera(&self, wanted: Option<&str>, aspect_ratio: f32) -> Result<Camera, SceneError> {
        let Some(wanted) = wanted else {
            return Ok(self.cameras.first().cloned().unwrap_or_else(|| self.framing(aspect_ratio)));
        };
        let by_name = |camera: &&Camera| camera.name == wanted;
        let by_other_name = |camera: &&Camera| camera.other_name == wanted;
        let named = self.cameras.iter().find(by_name).or_else(|| self.cameras.iter().find(by_other_name));
        if let Some(camera) = named.filter(|_| !wanted.is_empty()) {
            return Ok(camera.clone());
        }
        if let Some(camera) = wanted.parse::<usize>().ok().and_then(|index| self.cameras.get(index)) {
            return Ok(camera.clone());
        }
        let listed: Vec<String> = self.cameras.iter().enumerate().map(|(i, c)| format!("{i} `{}`", c.name)).collect();
        let listed = if listed.is_empty() { "none in this scene".into() } else { listed.join(", ") };
        let known = self.cameras.iter().map(|camera| camera.name.as_str());
        Err(SceneError::unknown("camera", wanted, known, listed))
    }

    /// The view of `camera`, with a near plane that suits the scene's size.
    pub fn view(&self, camera: &Camera, width: u32, height: u32) -> View {
        View::new(camera, width, height, self.near())
    }

    /// The view of the default camera.
    pub fn default_view(&self, width: u32, height: u32) -> View {
        let aspect_ratio = width as f32 / height.max(1) as f32;
        let camera = self.cameras.first().cloned().unwrap_or_else(|| self.framing(aspect_ratio));
        self.view(&camera, width, height)
    }

    /// The order that the scene needs: light passes a glass by four surfaces, and what stands behind another one by
    /// eight. Mirrors show mirrors, and most paths end before they have met eight. Rough and coated surfaces, whose
    /// every reflection branches, weaken light at each of them.
    pub fn order_needed(&self) -> u32 {
        let materials = || self.objects.iter().map(|object| &self.materials[object.material as usize]);
        let passes = |material: &Material| material.lobes().is_some_and(|lobes| lobes.transmission > 0.0);
        let has_glass = materials().any(|material| material.role == Role::Lens || passes(material));
        if !has_glass && materials().any(|material| material.lobes().is_some()) { 4 } else { 8 }
    }

    /// The distance within which nothing is drawn: a hundred millionth of the scene's size, for rays and triangles
    /// alike.
    #[inline]
    pub fn near(&self) -> f32 {
        (self.bounds.diagonal() * 1e-8).max(1e-12)
    }
}
