//! The appearance of a surface: its role, colours and textures.

mod binding;
mod lobes;

pub use binding::TextureBinding;
pub use lobes::{Film, LobeTexture, Lobes};

use super::Blend;
use glam::{Vec3, Vec4};

/// The role of a surface for the methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// Scatters light; visible in mirrors and through glass.
    Diffuse,
    /// A perfect mirror with a tint, perhaps [blended](Blend) with its own colour.
    Reflector,
    /// A clear dielectric body: reflects and refracts at its surface.
    Lens,
    /// A diffuse base under a clear, mirror-smooth coat.
    Coated,
}

impl Role {
    /// Returns true if paths go on at such a surface, so that it counts as a reflector or lens.
    #[inline]
    pub fn is_specular(self) -> bool {
        self != Self::Diffuse
    }

    /// The role's name in scene files and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::Reflector => "reflector",
            Self::Lens => "lens",
            Self::Coated => "coated",
        }
    }
}

/// The scattering of light by a rough surface's microscopic facets, beside the light that enters it: glTF's
/// metallic-roughness model (glTF 2.0, appendix B).
#[derive(Clone, Debug, PartialEq)]
pub struct Microfacets {
    /// 0 for dielectrics to 1 for metals.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1: the square root of the distribution's alpha.
    pub roughness: f32,
    /// A texture whose green channel multiplies `roughness`, and its blue one `metallic`.
    pub texture: Option<TextureBinding>,
    /// Reflectance of the dielectric at normal incidence.
    pub specular: Vec3,
    /// Reflectance of the dielectric at grazing angles.
    pub specular_at_grazing: f32,
    /// The share of a clear coat over all, 0 to 1, whose highlights are drawn, and no reflections.
    pub coat: f32,
    /// Perceptual roughness of the coat.
    pub coat_roughness: f32,
}

impl Default for Microfacets {
    /// glTF's defaults, but for its metal.
    fn default() -> Self {
        Self {
            metallic: 0.0,
            roughness: 1.0,
            texture: None,
            specular: Vec3::splat(0.04),
            specular_at_grazing: 1.0,
            coat: 0.0,
            coat_roughness: 0.0,
        }
    }
}

/// A texture of a surface's normals in its tangent frame.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalMap {
    /// The texture of normals: made by [`Texture::from_normals8`](super::Texture::from_normals8).
    pub binding: TextureBinding,
    /// The factor on slopes.
    pub scale: f32,
}

/// A texture of the share of light from all around that arrives at a surface: its red channel.
#[derive(Clone, Debug, PartialEq)]
pub struct OcclusionMap {
    /// The texture whose red channel is the share.
    pub binding: TextureBinding,
    /// How much of it counts, 0 to 1.
    pub strength: f32,
}

/// The use of the base colour's alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Ignored.
    Opaque,
    /// Below this value the surface is not there.
    Mask(f32),
    /// The share of the surface that is there; the rest of the light goes straight on (Porter and Duff's *over*, along
    /// rays). Where lobes are not followed, the surface is there wherever the value is above 0.
    Blend,
}

/// Mirrors up to this perceptual roughness reflect sharply.
pub const SHARP_ROUGHNESS: f32 = 0.08;

/// The look of a surface. All colours are linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the file; may be empty.
    pub name: String,
    /// The role of the surface for the methods.
    pub role: Role,
    /// Diffuse albedo, or the tint of a mirror, or of light through a lens surface; the fourth is alpha.
    pub base_color: Vec4,
    /// Multiplies `base_color`.
    pub base_texture: Option<TextureBinding>,
    /// Emitted radiance.
    pub emissive: Vec3,
    /// Multiplies `emissive`.
    pub emissive_texture: Option<TextureBinding>,
    /// The base colour is radiance as it stands: no lighting.
    pub unlit: bool,
    /// Reflection by microscopic facets; `None`: Lambert's law alone.
    pub microfacets: Option<Microfacets>,
    /// Lobes that rays follow at a diffuse surface, beside the light that it scatters.
    pub lobes: Option<Box<Lobes>>,
    /// Turns the normals of lit surfaces, mirrors and lenses, but not those of coats.
    pub normal_map: Option<NormalMap>,
    /// Turns the normals of a coat.
    pub coat_normal_map: Option<NormalMap>,
    /// A texture whose red channel multiplies `coat`.
    pub coat_texture: Option<TextureBinding>,
    /// Weakens light from the environment.
    pub occlusion_map: Option<OcclusionMap>,
    /// The use of the base colour's alpha.
    pub alpha_mode: AlphaMode,
    /// Index of refraction, of a lens or of a coat.
    pub ior: f32,
    /// Absorption inside a lens, a unit of length (Beer-Lambert).
    pub absorption: Vec3,
    /// The rank among bodies of glass or liquid in one place: the greatest one is there, of equals the smallest body
    /// (Schmidt, Budge 2002).
    pub priority: i32,
    /// A reflector whose reflectance rises to 1 at grazing angles (Schlick), not a perfect mirror of constant tint.
    pub schlick: bool,
    /// The weights of a reflector's reflection against its own colour; `None`: a mirror all over ([`Role::Reflector`]
    /// alone).
    pub blend: Option<Blend>,
    /// The share of the clear coat, 0 to 1 (role [`Role::Coated`] alone).
    pub coat: f32,
    /// Perceptual roughness of a mirror or coat, 0 to 1: see [`Self::reflection_roughness`] and
    /// [`Self::highlight_roughness`].
    pub mirror_roughness: f32,
    /// The file's flag that both sides are drawn: see [`Self::is_one_sided`].
    pub double_sided: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            role: Role::Diffuse,
            base_color: Vec4::ONE,
            base_texture: None,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            unlit: false,
            microfacets: None,
            lobes: None,
            normal_map: None,
            coat_normal_map: None,
            coat_texture: None,
            occlusion_map: None,
            alpha_mode: AlphaMode::Opaque,
            ior: 1.5,
            absorption: Vec3::ZERO,
            priority: 0,
            schlick: false,
            blend: None,
            coat: 0.0,
            mirror_roughness: 0.0,
            double_sided: true,
        }
    }
}

impl Material {
    /// A lit diffuse material of one colour.
    pub fn diffuse(name: &str, albedo: Vec3) -> Self {
        Self { name: name.into(), base_color: albedo.extend(1.0), ..Self::default() }
    }

    /// A perfect mirror with a tint.
    pub fn mirror(name: &str, tint: Vec3) -> Self {
        Self { name: name.into(), role: Role::Reflector, base_color: tint.extend(1.0), ..Self::default() }
    }

    /// Perceptual roughness with which a mirror or coat reflects surfaces; 0: sharply.
    #[inline]
    pub fn reflection_roughness(&self) -> f32 {
        let is_rough = matches!(self.role, Role::Reflector | Role::Coated) && self.mirror_roughness > SHARP_ROUGHNESS;
        if is_rough { self.mirror_roughness } else { 0.0 }
    }

    /// True if [`Self::facets_alpha`] may be above zero somewhere.
    #[inline]
    pub fn may_spread_light(&self) -> bool {
        self.turning_map().is_some() || self.reflection_roughness() > 0.0
    }

    /// The map that turns the rays which a mirror, lens or coat reflects and refracts.
    #[inline(always)]
    pub fn turning_map(&self) -> Option<&NormalMap> {
        match self.role {
            Role::Diffuse => None,
            Role::Reflector | Role::Lens => self.normal_map.as_ref(),
            Role::Coated => self.coat_normal_map.as_ref(),
        }
    }

    /// Perceptual roughness with which a mirror or coat reflects lights; `None`: they make no highlights on it, as the
    /// lobe of a perfect mirror is a line.
    #[inline]
    pub fn highlight_roughness(&self) -> Option<f32> {
        if !matches!(self.role, Role::Reflector | Role::Coated) {
            return None;
        }
        let own = (self.mirror_roughness > 0.0).then_some(self.mirror_roughness);
        self.blend.and_then(|blend| blend.highlight_roughness).or(own)
    }

    /// Returns true if a mirror, lens or coat sends light of its own, beside what it reflects and refracts.
    #[inline]
    pub fn has_own_light(&self) -> bool {
        self.role == Role::Coated || self.blend.is_some() || self.highlight_roughness().is_some()
    }

    /// The lobes that rays follow; `None` for mirrors, lenses and coats, whose paths are their own.
    #[inline(always)]
    pub fn lobes(&self) -> Option<&Lobes> {
        self.lobes.as_deref().filter(|_| self.role == Role::Diffuse)
    }

    /// True if there is a medium behind the surface, which light enters.
    #[inline(always)]
    pub fn has_inside(&self) -> bool {
        self.role == Role::Lens || self.lobes().is_some_and(|lobes| lobes.transmission > 0.0 && !lobes.is_thin)
    }

    /// Returns true if it emits light onto others: what is unlit is a picture.
    pub fn emits_light(&self) -> bool {
        !self.unlit && self.emissive.max_element() > 0.0
    }

    /// True if the surface is seen from its outer side alone: the other one is not there for rays of sight. Bodies that
    /// light enters have both.
    #[inline(always)]
    pub fn is_one_sided(&self) -> bool {
        !self.double_sided && !self.has_inside()
    }

    /// All textures that it reads.
    pub fn bindings(&self) -> impl Iterator<Item = &TextureBinding> {
        let microfacets = self.microfacets.as_ref().and_then(|microfacets| microfacets.texture.as_ref());
        let normals = self.normal_map.as_ref().map(|map| &map.binding);
        let of_coat = self.coat_normal_map.as_ref().map(|map| &map.binding);
        let occlusion = self.occlusion_map.as_ref().map(|map| &map.binding);
        let colors = [self.base_texture.as_ref(), self.emissive_texture.as_ref(), self.coat_texture.as_ref()];
        let others = self.lobes.as_deref().into_iter().flat_map(Lobes::bindings);
        colors.into_iter().chain([microfacets, normals, occlusion, of_coat]).flatten().chain(others)
    }

    /// The same, to be changed.
    pub fn bindings_mut(&mut self) -> impl Iterator<Item = &mut TextureBinding> {
        let microfacets = self.microfacets.as_mut().and_then(|microfacets| microfacets.texture.as_mut());
        let normals = self.normal_map.as_mut().map(|map| &mut map.binding);
        let of_coat = self.coat_normal_map.as_mut().map(|map| &mut map.binding);
        let occlusion = self.occlusion_map.as_mut().map(|map| &mut map.binding);
        let colors = [self.base_texture.as_mut(), self.emissive_texture.as_mut(), self.coat_texture.as_mut()];
        let others = self.lobes.as_deref_mut().into_iter().flat_map(Lobes::bindings_mut);
        colors.into_iter().chain([microfacets, normals, occlusion, of_coat]).flatten().chain(others)
    }

    /// Clear glass.
    pub fn glass(name: &str, ior: f32) -> Self {
        Self { name: name.into(), role: Role::Lens, ior, ..Self::default() }
    }
}
