//! Textures that materials use: pictures from files and buffers, decoded once, with the file's samplers.

use super::super::picture::{self, Picture, TexelBudget};
use super::schema::{self, TextureInfo};
use super::source::Source;
use catoptric_core::error::SceneError;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::{MipFilter, Sampler, Texture, TextureBinding, Wrap};
use glam::{Affine2, Mat2, Vec2};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Gathers the textures of all materials before any is decoded, so that all are decoded at once.
#[derive(Default)]
pub(super) struct TextureSet {
    /// The number of each texture here.
    numbers: BTreeMap<WantedTexture, u32>,
    /// By their numbers.
    wanted: Vec<WantedTexture>,
}

/// A picture and sampler of the file, and what the picture holds.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct WantedTexture {
    picture: usize,
    sampler: Option<usize>,
    content: Content,
}

/// The bytes of a picture, or why they cannot be decoded.
type Encoded<'s> = Result<Cow<'s, [u8]>, String>;

/// The meaning of a picture's texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Content {
    /// Colours in sRGB.
    Color,
    /// Numbers.
    Data,
    /// Normals in a tangent frame.
    Normals,
    /// In alpha glossiness, over this factor (in units of 1/65535): it becomes the roughness in green, and no metal.
    Glossiness(u16),
}

/// A decoded texture, and whether it has texels that are not opaque.
pub(super) struct DecodedTexture {
    pub(super) texture: Arc<Texture>,
    pub(super) is_translucent: bool,
}

/// A material's use of a texture.
#[derive(Clone, Debug)]
pub(super) struct TextureUse {
    pub(super) texture: u32,
    /// The set of the file's texture coordinates.
    pub(super) set: u32,
    pub(super) texture_from_uv: Affine2,
}

impl TextureUse {
    pub(super) fn binding(&self, uv_channel: u8) -> TextureBinding {
        TextureBinding { texture: self.texture, uv_channel, texture_from_uv: self.texture_from_uv }
    }
}

impl TextureSet {
    /// Takes up a material's texture. Returns `None`, with a warning, if it has no picture that can be used.
    pub(super) fn add(
        &mut self,
        source: &Source<'_>,
        info: &TextureInfo,
        content: Content,
        owner: &dyn Fn() -> String,
    ) -> Result<Option<TextureUse>, SceneError> {
        let index_field = || format!("{}.index", owner());
        let index = info.index.ok_or_else(|| source.invalid(index_field(), "missing"))?;
        let texture = source.entry(&source.document.textures, index, &index_field, "textures")?;
        let transform: Option<schema::TextureTransform> =
            source.extension(owner, &info.extensions, "KHR_texture_transform")?;
        let Some(picture) = picture_of(source, index, texture)? else {
            source.warn(format!("textures[{index}] has no picture and is left out"));
            return Ok(None);
        };
        source.entry(&source.document.images, picture, &|| format!("textures[{index}].source"), "images")?;
        if let Some(sampler) = texture.sampler {
            source.entry(&source.document.samplers, sampler, &|| format!("textures[{index}].sampler"), "samplers")?;
        }
        let key = WantedTexture { picture, sampler: texture.sampler, content };
        let number = *self.numbers.entry(key).or_insert_with(|| {
            self.wanted.push(key);
            self.wanted.len() as u32 - 1
        });
        let transform = transform.unwrap_or_default();
        Ok(Some(TextureUse {
            texture: number,
            set: transform.tex_coord.unwrap_or(info.tex_coord),
            texture_from_uv: affine(&transform),
        }))
    }

    /// Reads and decodes every picture once, on all cores. A picture that cannot be read leaves the factor alone, with
    /// a warning.
    pub(super) fn decode(&self, source: &Source<'_>) -> Vec<DecodedTexture> {
        let mut places: BTreeMap<usize, usize> = BTreeMap::new();
        let mut encoded: Vec<(usize, Encoded<'_>)> = Vec::new();
        let mut budget = TexelBudget::default();
        for &WantedTexture { picture, .. } in &self.wanted {
            if places.contains_key(&picture) {
                continue;
            }
            let bytes = picture_bytes(source, picture).map_err(|error| error.without_file()).and_then(|bytes| {
                picture::dimensions(&bytes).and_then(|size| budget.admit(size, bytes.len()))?;
                Ok(bytes)
            });
            places.insert(picture, encoded.len());
            encoded.push((picture, bytes));
        }
        let decoded = catoptric_core::parallel::map_collect(encoded.len(), |place| match &encoded[place].1 {
            Ok(bytes) => picture::decode(bytes),
            Err(problem) => Err(problem.clone()),
        });
        let mut pictures: Vec<Option<Picture>> = Vec::with_capacity(decoded.len());
        for (result, (picture, _)) in decoded.into_iter().zip(&encoded) {
            if let Err(problem) = &result {
                let name = source.document.picture_name(*picture);
                source.warn(format!("picture `{name}` is not drawn, its factors alone are: {problem}"));
            }
            pictures.push(result.ok());
        }
        drop(encoded);
        let document = source.document;
        catoptric_core::parallel::map_collect(self.wanted.len(), |number| {
            let WantedTexture { picture, sampler, content } = self.wanted[number];
            let name = document.picture_name(picture);
            let sampler = sampler.map(|sampler| sampler_of(&document.samplers[sampler])).unwrap_or_default();
            let Some(picture) = &pictures[places[&picture]] else {
                let neutral = if content == Content::Normals { [128, 128, 255, 255] } else { [255; 4] };
                let make = if content == Content::Normals { Texture::from_normals8 } else { Texture::from_linear8 };
                let texture = Arc::new(make(&name, 1, 1, &[neutral], sampler));
                return DecodedTexture { texture, is_translucent: false };
            };
            let make = match content {
                Content::Color => Texture::from_srgb8,
                Content::Data | Content::Glossiness(_) => Texture::from_linear8,
                Content::Normals => Texture::from_normals8,
            };
            let texels = match content {
                Content::Glossiness(factor) => Cow::Owned(roughness_of_glossiness(&picture.texels, factor)),
                _ => Cow::Borrowed(picture.texels.as_slice()),
            };
            let texture = make(&name, picture.width, picture.height, &texels, sampler);
            DecodedTexture { texture: Arc::new(texture), is_translucent: picture.is_translucent() }
        })
    }
}

/// Texels whose green is the roughness that belongs to the glossiness in alpha.
fn roughness_of_glossiness(texels: &[[u8; 4]], factor: u16) -> Vec<[u8; 4]> {
    let factor = f32::from(factor) / 65535.0;
    texels.iter().map(|texel| [0, (255.0 - f32::from(texel[3]) * factor).round() as u8, 0, 255]).collect()
}

/// The picture of a texture: one in a format of an extension, else the plain one.
fn picture_of(source: &Source<'_>, index: usize, texture: &schema::Texture) -> Result<Option<usize>, SceneError> {
    let owner = || format!("textures[{index}]");
    for key in ["EXT_texture_webp", "KHR_texture_basisu"] {
        if let Some(schema::TextureSource { source: Some(picture) }) =
            source.extension(&owner, &texture.extensions, key)?
        {
            return Ok(Some(picture));
        }
    }
    Ok(texture.source)
}

fn picture_bytes<'s>(source: &'s Source<'_>, picture: usize) -> Result<Cow<'s, [u8]>, SceneError> {
    let image = &source.document.images[picture];
    let field = || format!("images[{picture}]");
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => Ok(Cow::Owned(source.read_uri(uri, &|| format!("{}.uri", field()))?)),
        (None, Some(view)) => Ok(Cow::Borrowed(source.view(view, &|| format!("{}.bufferView", field()))?)),
        (None, None) => Err(source.invalid(field(), "has neither uri nor bufferView")),
    }
}

fn sampler_of(sampler: &schema::Sampler) -> Sampler {
    let wrap = |code: Option<u32>| match code {
        Some(33071) => Wrap::ClampToEdge,
        Some(33648) => Wrap::MirroredRepeat,
        _ => Wrap::Repeat,
    };
    let (minify_linear, mip_filter) = match sampler.min_filter {
        Some(9728) => (false, MipFilter::None),
        Some(9729) => (true, MipFilter::None),
        Some(9984) => (false, MipFilter::Nearest),
        Some(9985) => (true, MipFilter::Nearest),
        Some(9986) => (false, MipFilter::Linear),
        _ => (true, MipFilter::Linear),
    };
    Sampler {
        wrap_u: wrap(sampler.wrap_s),
        wrap_v: wrap(sampler.wrap_t),
        magnify_linear: sampler.mag_filter != Some(9728),
        minify_linear,
        mip_filter,
    }
}

/// KHR_texture_transform: scale, then rotate, then move; the rotation is counter-clockwise in a frame with v down.
fn affine(transform: &schema::TextureTransform) -> Affine2 {
    let (sin, cos) = transform.rotation.sine_cosine();
    let scale = Vec2::from(transform.scale.unwrap_or([1.0; 2]));
    let rotation = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    let result = Affine2 { matrix2: rotation * Mat2::from_diagonal(scale), translation: Vec2::from(transform.offset) };
    if result.is_finite() { result } else { Affine2::IDENTITY }
}
