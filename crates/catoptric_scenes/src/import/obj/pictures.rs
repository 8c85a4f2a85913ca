//! Pictures of `.mtl` materials.

use super::super::files::{MAX_SCENE_BYTES, Resolver, read_written};
use super::super::picture::{self, Picture, TexelBudget};
use super::library::{Map, MapKind, MtlMaterial};
use catoptric_core::scene::{AlphaMode, Sampler, Texture, TextureBinding, Wrap};
use glam::{Affine2, Mat2, Vec2, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// Reads pictures, each once, and makes textures of them, equal ones once.
pub(super) struct Pictures<'a> {
    resolver: &'a dyn Resolver,
    budget: TexelBudget,
    /// By their files; `None` where one cannot be read.
    pictures: HashMap<String, Option<Arc<Picture>>>,
    numbers: HashMap<String, u32>,
    pub(super) textures: Vec<Arc<Texture>>,
    pub(super) warnings: Vec<String>,
}

impl<'a> Pictures<'a> {
    pub(super) fn new(resolver: &'a dyn Resolver) -> Self {
        Self {
            resolver,
            budget: TexelBudget::default(),
            pictures: HashMap::new(),
            numbers: HashMap::new(),
            textures: Vec::new(),
            warnings: Vec::new(),
        }
    }

    /// The picture of a map: beside its `.mtl` file, else beside the `.obj` file. `None`, with a warning, if it cannot
    /// be read.
    fn picture(&mut self, material: &MtlMaterial, map: &Map) -> Option<Arc<Picture>> {
        let name = format!("{}{}", material.folder, map.file);
        if let Some(found) = self.pictures.get(&name) {
            return found.clone();
        }
        let read = |name: &str| read_written(self.resolver, name, MAX_SCENE_BYTES);
        let bytes = read(&name).or_else(|error| {
            // Some programs write names relative to the `.obj` file.
            if material.folder.is_empty() { Err(error) } else { read(&map.file).or(Err(error)) }
        });
        let decoded = bytes
            .map_err(|error| error.without_file())
            .and_then(|bytes| picture::decode_within(&bytes, &mut self.budget));
        let found = match decoded {
            Ok(picture) => Some(Arc::new(picture)),
            Err(problem) => {
                let (name, file) = (&material.name, &map.file);
                self.warnings.push(format!("material `{name}` is drawn without the picture `{file}`: {problem}"));
                None
            }
        };
        self.pictures.insert(name, found.clone());
        found
    }

    /// The number of a texture by all that it is made of.
    fn texture(&mut self, key: String, make: impl FnOnce() -> Texture) -> u32 {
        *self.numbers.entry(key).or_insert_with(|| {
            self.textures.push(Arc::new(make()));
            self.textures.len() as u32 - 1
        })
    }

    /// A picture of colours.
    pub(super) fn color(&mut self, material: &MtlMaterial, map: &Map) -> Option<TextureBinding> {
        let picture = self.picture(material, map)?;
        let key = format!("{}{} {}", material.folder, map.file, map.is_clamped);
        let make = || Texture::from_srgb8(&map.file, picture.width, picture.height, &picture.texels, sampler(map));
        Some(binding(self.texture(key, make), map))
    }

    /// The picture of diffuse colours with that of opacity in its alpha, and the use of it; `None`: opaque.
    pub(super) fn colors(&mut self, material: &MtlMaterial) -> (Option<TextureBinding>, Option<AlphaMode>) {
        let color_map = material.map(MapKind::Diffuse);
        let opacity = material.map(MapKind::Dissolve).and_then(|map| Some((map, self.picture(material, map)?)));
        let Some((opacity_map, opacity)) = opacity else {
            return (color_map.and_then(|map| self.color(material, map)), None);
        };
        let map = color_map.unwrap_or(opacity_map);
        let color = color_map.and_then(|map| self.picture(material, map));
        // Opacity stands in alpha, or in the picture's brightness where it has none.
        let has_alpha = opacity.texels.iter().any(|texel| texel[3] < 255);
        let alpha_of = |texel: [u8; 4]| if has_alpha { texel[3] } else { luma(texel) };
        let sources = [color.as_deref(), Some(&*opacity)];
        let (width, height) = common_size(sources);
        let texels = texels(width, height, sources, |[color, opacity]| {
            let [red, green, blue, _] = color.unwrap_or([255; 4]);
            [red, green, blue, opacity.map_or(255, alpha_of)]
        });
        let is_there_or_not = texels.iter().all(|texel| texel[3] == 0 || texel[3] == 255);
        let mode = if is_there_or_not { AlphaMode::Mask(0.5) } else { AlphaMode::Blend };
        let key = format!("{}{} {} alpha {}", material.folder, map.file, map.is_clamped, opacity_map.file);
        let number = self.texture(key, || Texture::from_srgb8(&map.file, width, height, &texels, sampler(map)));
        (Some(binding(number, map)), Some(mode))
    }

    /// Pictures of roughness and metalness in one: in green and blue.
    pub(super) fn facets(&mut self, material: &MtlMaterial, maps: [Option<&Map>; 2]) -> Option<TextureBinding> {
        let map = maps.into_iter().flatten().next()?;
        let pictures = maps.map(|map| map.and_then(|map| self.picture(material, map)));
        let sources = pictures.each_ref().map(|picture| picture.as_deref());
        sources.iter().flatten().next()?;
        let (width, height) = common_size(sources);
        let texels = texels(width, height, sources, |[roughness, metallic]| {
            [255, roughness.map_or(255, luma), metallic.map_or(255, luma), 255]
        });
        let files = maps.map(|map| map.map_or("", |map| map.file.as_str()));
        let key = format!("{}{} {} facets {}", material.folder, files[0], map.is_clamped, files[1]);
        let number = self.texture(key, || Texture::from_linear8(&map.file, width, height, &texels, sampler(map)));
        Some(binding(number, map))
    }

    /// A picture of normals, or of heights, whose slopes it becomes. A picture of heights with colours holds normals.
    pub(super) fn normals(&mut self, material: &MtlMaterial, map: &Map, holds_normals: bool) -> Option<TextureBinding> {
        let picture = self.picture(material, map)?;
        let is_grey = |texel: &[u8; 4]| texel[0].abs_diff(texel[1]) < 8 && texel[1].abs_diff(texel[2]) < 8;
        let holds_normals = holds_normals || !picture.texels.iter().all(is_grey);
        let key = format!("{}{} {} normals {}", material.folder, map.file, map.is_clamped, map.bump);
        let number = self.texture(key, || {
            let (width, height) = (picture.width, picture.height);
            if holds_normals {
                Texture::from_normals8(&map.file, width, height, &picture.texels, sampler(map))
            } else {
                Texture::from_normals(&map.file, width, height, slopes(&picture, map), sampler(map))
            }
        });
        Some(binding(number, map))
    }
}

/// Normals of a picture of heights, row by row from the top: white lies the factor times a hundredth of the picture's
/// width above black, as the format gives no unit.
fn slopes<'p>(picture: &'p Picture, map: &Map) -> impl Iterator<Item = Vec3> + 'p {
    let (width, height, is_clamped) = (picture.width as i64, picture.height as i64, map.is_clamped);
    let step = map.bump * 0.01 * picture.width as f32 / 255.0;
    let at = move |x: i64, y: i64| {
        let inside = |place: i64, size: i64| {
            if is_clamped { place.clamp(0, size - 1) } else { place.rem_euclid(size) }
        };
        let index = inside(y, height) * width + inside(x, width);
        f32::from(luma(picture.texels[index as usize])) * step
    };
    (0..height).flat_map(move |y| {
        (0..width).map(move |x| {
            let slope = Vec2::new(at(x + 1, y) - at(x - 1, y), at(x, y - 1) - at(x, y + 1)) * 0.5;
            Vec3::new(-slope.x, -slope.y, 1.0).normalize()
        })
    })
}

/// The brightness of a texel as it is written (Rec. 601).
fn luma([red, green, blue, _]: [u8; 4]) -> u8 {
    ((u32::from(red) * 299 + u32::from(green) * 587 + u32::from(blue) * 114 + 500) / 1000) as u8
}

/// The larger width and height of two pictures, at least one of which is there.
fn common_size(pictures: [Option<&Picture>; 2]) -> (u32, u32) {
    let sizes = pictures.into_iter().flatten().map(|picture| (picture.width, picture.height));
    sizes.fold((1, 1), |(width, height), size| (width.max(size.0), height.max(size.1)))
}

/// Texels of a size from the nearest ones of two pictures.
fn texels(
    width: u32,
    height: u32,
    pictures: [Option<&Picture>; 2],
    of: impl Fn([Option<[u8; 4]>; 2]) -> [u8; 4],
) -> Vec<[u8; 4]> {
    let nearest = |picture: &Picture, x: u32, y: u32| {
        let scaled = |place: u32, from: u32, to: u32| u64::from(place) * u64::from(to) / u64::from(from);
        let (x, y) = (scaled(x, width, picture.width), scaled(y, height, picture.height));
        picture.texels[(y * u64::from(picture.width) + x) as usize]
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    places.map(|(x, y)| of(pictures.map(|picture| picture.map(|picture| nearest(picture, x, y))))).collect()
}

fn sampler(map: &Map) -> Sampler {
    let wrap = if map.is_clamped { Wrap::ClampToEdge } else { Wrap::Repeat };
    Sampler { wrap_u: wrap, wrap_v: wrap, ..Sampler::default() }
}

/// The use of a texture with a map's scale and offset, which are about the lower left corner: coordinates here run
/// down.
fn binding(texture: u32, map: &Map) -> TextureBinding {
    let translation = Vec2::new(map.offset.x, 1.0 - map.scale.y - map.offset.y);
    let texture_from_uv = Affine2 { matrix2: Mat2::from_diagonal(map.scale), translation };
    TextureBinding { texture, uv_channel: 0, texture_from_uv }
}
