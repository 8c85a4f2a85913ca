//! Lobes that rays follow at a surface that is neither a plain mirror nor plain glass.

use super::binding::TextureBinding;
use glam::Vec3;

/// Lobes of a surface that are followed by rays, evaluated at each point from factors and textures: what its facets
/// and its coat reflect, and what passes it (glTF 2.0, appendix B, and the extensions KHR_materials_anisotropy,
/// clearcoat, diffuse_transmission, dispersion, iridescence, sheen, specular, transmission, volume).
///
/// Reflectances, roughness and the coat's share are those of [`Microfacets`](super::Microfacets) and
/// [`Material::coat`](super::Material::coat), what is within is [`Material::ior`](super::Material::ior) and
/// [`Material::absorption`](super::Material::absorption). Methods that follow no lobes draw such a surface by its
/// facets alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lobes {
    /// The share of the light that enters a dielectric which passes the surface, 0 to 1.
    pub transmission: f32,
    /// A wall that has no thickness: what passes goes straight on.
    pub is_thin: bool,
    /// Both sides of a thin wall reflect, and light goes to and fro between them: of the light that one of them
    /// reflects twice as much over one more.
    pub is_plate: bool,
    /// How much the index of refraction differs from red to blue: 20 over Abbe's number; 0: not at all.
    pub dispersion: f32,
    /// The colour of light that fibres scatter; black: none.
    pub sheen: Vec3,
    /// Perceptual roughness of fibres.
    pub sheen_roughness: f32,
    /// How much wider highlights are along one direction than across it, 0 to 1.
    pub anisotropy: f32,
    /// The angle of that direction with the tangent, counter-clockwise, in radians.
    pub anisotropy_rotation: f32,
    /// A thin film over the facets, if there is one.
    pub film: Option<Film>,
    /// The share of scattered light that leaves on the other side, 0 to 1.
    pub diffuse_transmission: f32,
    /// The colour of that light.
    pub diffuse_transmission_color: Vec3,
    /// Textures, by [`LobeTexture`].
    pub textures: [Option<TextureBinding>; LobeTexture::COUNT],
}

/// A thin film whose two sides interfere (Belcour, Barla 2017).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// The share of the surface that it covers, 0 to 1.
    pub share: f32,
    /// The film's index of refraction.
    pub ior: f32,
    /// The film's thickness in nanometres where its texture is 0, and where it is 1; without a texture the second one.
    pub thickness_nm: [f32; 2],
}

/// Textures that multiply properties of lobes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LobeTexture {
    /// Red: the transmission.
    Transmission,
    /// Green: the coat's roughness.
    CoatRoughness,
    /// Alpha: a dielectric's reflectance.
    Specular,
    /// Colour: a dielectric's reflectance at normal incidence.
    SpecularColor,
    /// Colour: that of the sheen.
    SheenColor,
    /// Alpha: the sheen's roughness.
    SheenRoughness,
    /// Red and green: the direction of the anisotropy, from -1 to 1; blue: its strength.
    Anisotropy,
    /// Red: the film's share.
    FilmShare,
    /// Green: the film's thickness, between its two.
    FilmThickness,
    /// Alpha: the diffuse transmission.
    DiffuseTransmission,
    /// Colour: that of the diffuse transmission.
    DiffuseTransmissionColor,
}

impl LobeTexture {
    /// How many there are.
    pub const COUNT: usize = 11;
}

impl Lobes {
    /// A texture, if it is there.
    #[inline(always)]
    pub fn texture(&self, texture: LobeTexture) -> Option<&TextureBinding> {
        self.textures[texture as usize].as_ref()
    }

    /// All textures.
    pub fn bindings(&self) -> impl Iterator<Item = &TextureBinding> {
        self.textures.iter().flatten()
    }

    /// The same, to be changed.
    pub fn bindings_mut(&mut self) -> impl Iterator<Item = &mut TextureBinding> {
        self.textures.iter_mut().flatten()
    }
}
