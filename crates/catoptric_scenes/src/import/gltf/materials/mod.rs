//! Materials: mirrors, lenses, coats and diffuse surfaces from the file's properties.

mod factors;

use super::extensions;
use super::meshes::{TextureSets, VertexNeeds};
use super::schema::{self, Material as MaterialEntry};
use super::source::Source;
use super::textures::{Content, DecodedTexture, TextureSet, TextureUse};
use catoptric_core::error::SceneError;
use catoptric_core::scene::{AlphaMode, LobeTexture, Material, NormalMap, OcclusionMap, TextureBinding};
use glam::{Affine2, Vec3, Vec4};

/// The textures of a material; base colours first.
#[derive(Default)]
struct TextureUses {
    base: Option<TextureUse>,
    microfacets: Option<TextureUse>,
    normals: Option<TextureUse>,
    occlusion: Option<TextureUse>,
    emissive: Option<TextureUse>,
    coat: Option<TextureUse>,
    coat_normals: Option<TextureUse>,
    lobes: [Option<TextureUse>; LobeTexture::COUNT],
}

impl TextureUses {
    fn all_mut(&mut self) -> impl Iterator<Item = &mut Option<TextureUse>> {
        let Self { base, microfacets, normals, occlusion, emissive, coat, coat_normals, lobes } = self;
        [base, microfacets, normals, occlusion, emissive, coat, coat_normals].into_iter().chain(lobes)
    }
}

/// Textures of extensions that lobes read: the extension, its field, and what the picture holds.
const LOBE_TEXTURES: [(LobeTexture, &str, &str, Content); LobeTexture::COUNT] = [
    (LobeTexture::Transmission, "KHR_materials_transmission", "transmissionTexture", Content::Data),
    (LobeTexture::CoatRoughness, "KHR_materials_clearcoat", "clearcoatRoughnessTexture", Content::Data),
    (LobeTexture::Specular, "KHR_materials_specular", "specularTexture", Content::Data),
    (LobeTexture::SpecularColor, "KHR_materials_specular", "specularColorTexture", Content::Color),
    (LobeTexture::SheenColor, "KHR_materials_sheen", "sheenColorTexture", Content::Color),
    (LobeTexture::SheenRoughness, "KHR_materials_sheen", "sheenRoughnessTexture", Content::Data),
    (LobeTexture::Anisotropy, "KHR_materials_anisotropy", "anisotropyTexture", Content::Data),
    (LobeTexture::FilmShare, "KHR_materials_iridescence", "iridescenceTexture", Content::Data),
    (LobeTexture::FilmThickness, "KHR_materials_iridescence", "iridescenceThicknessTexture", Content::Data),
    (
        LobeTexture::DiffuseTransmission,
        "KHR_materials_diffuse_transmission",
        "diffuseTransmissionTexture",
        Content::Data,
    ),
    (
        LobeTexture::DiffuseTransmissionColor,
        "KHR_materials_diffuse_transmission",
        "diffuseTransmissionColorTexture",
        Content::Color,
    ),
];

/// A material whose textures are identified but not yet decoded.
pub(super) struct PlannedMaterial {
    material: Material,
    textures: TextureUses,
    /// The sets of texture coordinates that its textures read.
    sets: TextureSets,
}

impl PlannedMaterial {
    /// The attributes that vertices must bring.
    pub(super) fn attributes(&self) -> VertexNeeds {
        // A vertex has one tangent: along the coat's map only if the surface beneath has none.
        let stretched = &self.textures.lobes[LobeTexture::Anisotropy as usize];
        let texture = [&self.textures.normals, &self.textures.coat_normals, stretched].into_iter().flatten().next();
        let channel = texture.and_then(|texture| self.channel(texture));
        let first = || self.sets.iter().position(|set| *set == Some(0)).filter(|_| self.is_stretched());
        VertexNeeds { sets: self.sets, normal_map: channel.or_else(first) }
    }

    /// True if highlights are wider along one direction.
    fn is_stretched(&self) -> bool {
        self.material.lobes.as_ref().is_some_and(|lobes| lobes.anisotropy > 0.0)
    }

    /// The channel of a vertex's texture coordinates that a texture reads.
    fn channel(&self, texture: &TextureUse) -> Option<usize> {
        self.sets.iter().position(|set| *set == Some(texture.set))
    }

    /// Chooses the sets of texture coordinates. A vertex has two; textures that need a third one are left out.
    fn choose_sets(&mut self, source: &Source<'_>, owner: &dyn Fn() -> String) {
        for texture in self.textures.all_mut() {
            let Some(set) = texture.as_ref().map(|texture| texture.set) else { continue };
            match self.sets.iter().position(|taken| *taken == Some(set) || taken.is_none()) {
                Some(channel) => self.sets[channel] = Some(set),
                None => {
                    source.warn(format!("{}: only two sets of texture coordinates are used", owner()));
                    *texture = None;
                }
            }
        }
        // The direction of highlights is that of the first set where no texture says otherwise.
        let is_free = self.sets.iter().position(|set| set.is_none()).filter(|_| !self.sets.contains(&Some(0)));
        if let Some(channel) = is_free.filter(|_| self.is_stretched()) {
            self.sets[channel] = Some(0);
        }
    }

    /// The material, now that its textures are there.
    pub(super) fn finish(mut self, textures: &[DecodedTexture]) -> Material {
        let binding = |texture: &Option<TextureUse>| {
            let texture = texture.as_ref()?;
            Some(texture.binding(self.channel(texture)? as u8))
        };
        let uses = &self.textures;
        let [base, microfacets, normals] = [&uses.base, &uses.microfacets, &uses.normals].map(binding);
        let [occlusion, emissive] = [&uses.occlusion, &uses.emissive].map(binding);
        let [coat, coat_normals] = [&uses.coat, &uses.coat_normals].map(binding);
        let of_lobes = uses.lobes.each_ref().map(binding);
        let material = &mut self.material;
        let texture = base.as_ref().and_then(|binding| textures.get(binding.texture as usize));
        let is_translucent = material.base_color.w < 1.0 || texture.is_some_and(|texture| texture.is_translucent);
        if material.alpha_mode == AlphaMode::Blend && !is_translucent {
            material.alpha_mode = AlphaMode::Opaque;
        }
        (material.base_texture, material.emissive_texture) = (base, emissive);
        if let Some(of_material) = &mut material.microfacets {
            of_material.texture = microfacets;
        }
        if let Some(lobes) = &mut material.lobes {
            lobes.textures = of_lobes;
        }
        // Made for the entry's textures; here are those that have pictures.
        let bound = |map: Option<NormalMap>, binding: Option<TextureBinding>| {
            map.zip(binding).map(|(map, binding)| NormalMap { binding, ..map })
        };
        material.normal_map = bound(material.normal_map.take(), normals);
        material.coat_normal_map = bound(material.coat_normal_map.take(), coat_normals);
        material.coat_texture = coat;
        material.occlusion_map =
            material.occlusion_map.take().zip(occlusion).map(|(map, binding)| OcclusionMap { binding, ..map });
        self.material
    }
}

/// Reads a material. `textures` takes up its textures; without it, the material is not drawn and has none.
pub(super) fn plan(
    source: &Source<'_>,
    index: usize,
    entry: &MaterialEntry,
    textures: Option<&mut TextureSet>,
) -> Result<PlannedMaterial, SceneError> {
    let owner = || format!("materials[{index}]");
    let (entry, glossiness) = &factors::with_metallic_roughness(source, entry, &owner)?;
    let pbr = &entry.pbr_metallic_roughness;
    check_texture_indices(source, entry, &owner)?;
    let strength: Option<schema::EmissiveStrength> =
        source.extension(&owner, &entry.extensions, "KHR_materials_emissive_strength")?;
    let strength = strength.and_then(|extension| extension.emissive_strength).unwrap_or(1.0);
    let unlit = entry.extensions.contains_key("KHR_materials_unlit");
    let mut material = Material {
        name: entry.name.clone(),
        base_color: factors::finite(Vec4::from(pbr.base_color_factor.unwrap_or([1.0; 4]))),
        emissive: if unlit { Vec3::ZERO } else { factors::finite3(Vec3::from(entry.emissive_factor) * strength) },
        unlit,
        double_sided: entry.double_sided,
        ..Material::default()
    };
    material.alpha_mode = match entry.alpha_mode.as_deref().unwrap_or("OPAQUE") {
        "OPAQUE" => AlphaMode::Opaque,
        "MASK" => AlphaMode::Mask(entry.alpha_cutoff.unwrap_or(0.5)),
        "BLEND" => AlphaMode::Blend,
        other => {
            let problem = format!("`{other}`; allowed are OPAQUE, MASK and BLEND");
            return Err(source.invalid(format!("{}.alphaMode", owner()), problem));
        }
    };
    if !unlit {
        material.microfacets = Some(factors::microfacets(source, entry, &owner)?);
    }
    let not_drawn = entry.extensions.keys().map(String::as_str).filter(|key| !extensions::is_supported(key));
    let not_drawn: Vec<&str> = not_drawn.collect();
    if !not_drawn.is_empty() {
        source.warn(format!("{} `{}` is drawn without {}", owner(), entry.name, not_drawn.join(", ")));
    }
    factors::give_lobes(source, entry, &owner, &mut material)?;
    let mut planned = PlannedMaterial { material, textures: TextureUses::default(), sets: TextureSets::default() };
    if let Some(textures) = textures {
        planned.add_textures(source, (entry, *glossiness), textures, &owner)?;
        planned.choose_sets(source, &owner);
    }
    Ok(planned)
}

impl PlannedMaterial {
    /// Takes up the textures that its light depends on.
    fn add_textures(
        &mut self,
        source: &Source<'_>,
        (entry, glossiness): (&MaterialEntry, Option<u16>),
        textures: &mut TextureSet,
        owner: &dyn Fn() -> String,
    ) -> Result<(), SceneError> {
        let pbr = &entry.pbr_metallic_roughness;
        let is_lit = !self.material.unlit;
        let glows = self.material.emissive != Vec3::ZERO;
        let (is_coated, has_lobes) = (self.material.coat > 0.0, self.material.lobes.is_some());
        let coat: Option<schema::Clearcoat> = source.extension(owner, &entry.extensions, "KHR_materials_clearcoat")?;
        let coat = coat.unwrap_or_default();
        let roughness = glossiness.map_or(Content::Data, Content::Glossiness);
        let wanted = [
            ("pbrMetallicRoughness.baseColorTexture", &pbr.base_color_texture, Content::Color, true),
            ("pbrMetallicRoughness.metallicRoughnessTexture", &pbr.metallic_roughness_texture, roughness, is_lit),
            ("normalTexture", &entry.normal_texture, Content::Normals, is_lit),
            ("occlusionTexture", &entry.occlusion_texture, Content::Data, is_lit),
            ("emissiveTexture", &entry.emissive_texture, Content::Color, glows),
            ("extensions.KHR_materials_clearcoat.clearcoatTexture", &coat.clearcoat_texture, Content::Data, is_coated),
            (
                "extensions.KHR_materials_clearcoat.clearcoatNormalTexture",
                &coat.clearcoat_normal_texture,
                Content::Normals,
                is_coated,
            ),
        ];
        for ((field, info, content, is_used), texture) in wanted.into_iter().zip(self.textures.all_mut()) {
            if let Some(info) = info.as_ref().filter(|_| is_used) {
                *texture = textures.add(source, info, content, &|| format!("{}.{field}", owner()))?;
            }
        }
        for (slot, extension, field, content) in LOBE_TEXTURES {
            if !(has_lobes && is_lit) {
                continue;
            }
            if let Some(info) = source.texture_of_extension(owner, &entry.extensions, extension, field)? {
                let owner = || format!("{}.extensions.{extension}.{field}", owner());
                self.textures.lobes[slot as usize] = textures.add(source, &info, content, &owner)?;
            }
        }
        self.set_maps(entry, &coat);
        Ok(())
    }

    /// The maps of normals and occlusion whose textures are used.
    fn set_maps(&mut self, entry: &MaterialEntry, coat: &schema::Clearcoat) {
        let number = |value: Option<f32>| value.filter(|value| value.is_finite()).unwrap_or(1.0);
        let binding = || TextureBinding { texture: 0, uv_channel: 0, texture_from_uv: Affine2::IDENTITY };
        let info = entry.normal_texture.as_ref().filter(|_| self.textures.normals.is_some());
        let of_info = |info: &schema::TextureInfo| NormalMap { binding: binding(), scale: number(info.scale) };
        self.material.normal_map = info.map(of_info);
        let info = coat.clearcoat_normal_texture.as_ref().filter(|_| self.textures.coat_normals.is_some());
        self.material.coat_normal_map = info.map(of_info);
        let info = entry.occlusion_texture.as_ref().filter(|_| self.textures.occlusion.is_some());
        self.material.occlusion_map =
            info.map(|info| OcclusionMap { binding: binding(), strength: number(info.strength).clamp(0.0, 1.0) });
    }
}

/// Indices that point nowhere are faults even where the texture is not drawn.
fn check_texture_indices(
    source: &Source<'_>,
    entry: &MaterialEntry,
    owner: &dyn Fn() -> String,
) -> Result<(), SceneError> {
    let pbr = &entry.pbr_metallic_roughness;
    let infos = [
        ("pbrMetallicRoughness.baseColorTexture", &pbr.base_color_texture),
        ("pbrMetallicRoughness.metallicRoughnessTexture", &pbr.metallic_roughness_texture),
        ("normalTexture", &entry.normal_texture),
        ("occlusionTexture", &entry.occlusion_texture),
        ("emissiveTexture", &entry.emissive_texture),
    ];
    for (field, info) in infos {
        if let Some(index) = info.as_ref().and_then(|info| info.index) {
            let field = || format!("{}.{field}.index", owner());
            source.entry(&source.document.textures, index, &field, "textures")?;
        }
    }
    Ok(())
}
