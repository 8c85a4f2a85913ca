//! Materials: mirrors, lenses, coats and diffuse surfaces from the file's properties.

use super::meshes::{TextureSets, VertexNeeds};
use super::schema::{self, Material as MaterialEntry};
use super::source::Source;
use super::textures::{Content, DecodedTexture, TextureSet, TextureUse};
use catoptric_core::error::SceneError;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::{AlphaMode, Lobes, Material, Microfacets, NormalMap, OcclusionMap, Role, TextureBinding};
use glam::{Affine2, Vec3, Vec4};

/// Perceptual roughness up to which metal is a plain mirror, and glass is clear.
const MAX_SHARP_ROUGHNESS: f32 = 0.02;
/// Opaque dielectrics that are rougher all over reflect the environment alone, as wide as half of the sky.
const MAX_FOLLOWED_ROUGHNESS: f32 = 0.75;
/// The index of refraction of materials that name none.
const DEFAULT_IOR: f32 = 1.5;

/// Extensions that change reflections in ways that are not drawn.
const NOT_DRAWN: [&str; 4] = [
    "KHR_materials_anisotropy",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_iridescence",
];

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
    transmission: Option<TextureUse>,
    coat_roughness: Option<TextureUse>,
    specular: Option<TextureUse>,
    specular_color: Option<TextureUse>,
    sheen: Option<TextureUse>,
    sheen_roughness: Option<TextureUse>,
}

impl TextureUses {
    fn all_mut(&mut self) -> [&mut Option<TextureUse>; 13] {
        let Self { base, microfacets, normals, occlusion, emissive, coat, coat_normals, .. } = self;
        let Self { transmission, coat_roughness, specular, specular_color, sheen, sheen_roughness, .. } = self;
        [
            base,
            microfacets,
            normals,
            occlusion,
            emissive,
            coat,
            coat_normals,
            transmission,
            coat_roughness,
            specular,
            specular_color,
            sheen,
            sheen_roughness,
        ]
    }
}

/// A material whose textures are identified but not yet decoded.
pub(super) struct PlannedMaterial {
    material: Material,
    textures: TextureUses,
    /// The sets of texture coordinates that its textures read.
    sets: TextureSets,
}

impl PlannedMaterial {
    /// What vertices must bring.
    pub(super) fn attributes(&self) -> VertexNeeds {
        // A vertex has one tangent: along the coat's map only if the surface beneath has none.
        let normals = self.textures.normals.as_ref().or(self.textures.coat_normals.as_ref());
        VertexNeeds { sets: self.sets, normal_map: normals.and_then(|normals| self.channel(normals)) }
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
        let [transmission, coat_roughness] = [&uses.transmission, &uses.coat_roughness].map(binding);
        let [specular, specular_color] = [&uses.specular, &uses.specular_color].map(binding);
        let [sheen, sheen_roughness] = [&uses.sheen, &uses.sheen_roughness].map(binding);
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
            (lobes.transmission_texture, lobes.coat_roughness_texture) = (transmission, coat_roughness);
            (lobes.specular_texture, lobes.specular_color_texture) = (specular, specular_color);
            (lobes.sheen_texture, lobes.sheen_roughness_texture) = (sheen, sheen_roughness);
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
    let pbr = &entry.pbr_metallic_roughness;
    check_texture_indices(source, entry, &owner)?;
    let strength: Option<schema::EmissiveStrength> =
        source.extension(&owner, &entry.extensions, "KHR_materials_emissive_strength")?;
    let strength = strength.and_then(|extension| extension.emissive_strength).unwrap_or(1.0);
    let unlit = entry.extensions.contains_key("KHR_materials_unlit");
    let mut material = Material {
        name: entry.name.clone(),
        base_color: finite(Vec4::from(pbr.base_color_factor.unwrap_or([1.0; 4]))),
        emissive: if unlit { Vec3::ZERO } else { finite3(Vec3::from(entry.emissive_factor) * strength) },
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
        material.microfacets = Some(microfacets(source, entry, &owner)?);
        let not_drawn: Vec<&str> = NOT_DRAWN.into_iter().filter(|key| entry.extensions.contains_key(*key)).collect();
        if !not_drawn.is_empty() {
            let (name, not_drawn) = (&entry.name, not_drawn.join(", "));
            source.warn(format!("{} `{name}` is drawn without {not_drawn}", owner()));
        }
    }
    give_lobes(source, entry, &owner, &mut material)?;
    let mut planned = PlannedMaterial { material, textures: TextureUses::default(), sets: TextureSets::default() };
    if let Some(textures) = textures {
        planned.add_textures(source, entry, textures, &owner)?;
        planned.choose_sets(source, &owner);
    }
    Ok(planned)
}

impl PlannedMaterial {
    /// Takes up the textures that its light depends on.
    fn add_textures(
        &mut self,
        source: &Source<'_>,
        entry: &MaterialEntry,
        textures: &mut TextureSet,
        owner: &dyn Fn() -> String,
    ) -> Result<(), SceneError> {
        let pbr = &entry.pbr_metallic_roughness;
        let is_lit = !self.material.unlit;
        let glows = self.material.emissive != Vec3::ZERO;
        let lobes = self.material.lobes.as_deref();
        let (is_coated, passes) = (self.material.coat > 0.0, lobes.is_some_and(|lobes| lobes.transmission > 0.0));
        let has_lobes = lobes.is_some();
        let transmission: Option<schema::Transmission> =
            source.extension(owner, &entry.extensions, "KHR_materials_transmission")?;
        let specular: Option<schema::Specular> =
            source.extension(owner, &entry.extensions, "KHR_materials_specular")?;
        let sheen: Option<schema::Sheen> = source.extension(owner, &entry.extensions, "KHR_materials_sheen")?;
        let (transmission, specular) = (transmission.unwrap_or_default(), specular.unwrap_or_default());
        let sheen = sheen.unwrap_or_default();
        let coat: Option<schema::Clearcoat> = source.extension(owner, &entry.extensions, "KHR_materials_clearcoat")?;
        let coat = coat.unwrap_or_default();
        let wanted = [
            ("pbrMetallicRoughness.baseColorTexture", &pbr.base_color_texture, Content::Color, true),
            ("pbrMetallicRoughness.metallicRoughnessTexture", &pbr.metallic_roughness_texture, Content::Data, is_lit),
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
            (
                "extensions.KHR_materials_transmission.transmissionTexture",
                &transmission.transmission_texture,
                Content::Data,
                passes,
            ),
            (
                "extensions.KHR_materials_clearcoat.clearcoatRoughnessTexture",
                &coat.clearcoat_roughness_texture,
                Content::Data,
                is_coated,
            ),
            (
                "extensions.KHR_materials_specular.specularTexture",
                &specular.specular_texture,
                Content::Data,
                has_lobes && is_lit,
            ),
            (
                "extensions.KHR_materials_specular.specularColorTexture",
                &specular.specular_color_texture,
                Content::Color,
                has_lobes && is_lit,
            ),
            (
                "extensions.KHR_materials_sheen.sheenColorTexture",
                &sheen.sheen_color_texture,
                Content::Color,
                has_lobes && is_lit,
            ),
            (
                "extensions.KHR_materials_sheen.sheenRoughnessTexture",
                &sheen.sheen_roughness_texture,
                Content::Color,
                has_lobes && is_lit,
            ),
        ];
        for ((field, info, content, is_used), texture) in wanted.into_iter().zip(self.textures.all_mut()) {
            if let Some(info) = info.as_ref().filter(|_| is_used) {
                *texture = textures.add(source, info, content, &|| format!("{}.{field}", owner()))?;
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

/// The reflection of a lit material's facets.
fn microfacets(
    source: &Source<'_>,
    entry: &MaterialEntry,
    owner: &dyn Fn() -> String,
) -> Result<Microfacets, SceneError> {
    let pbr = &entry.pbr_metallic_roughness;
    let share = |value: Option<f32>, default: f32| value.filter(|v| v.is_finite()).unwrap_or(default).clamp(0.0, 1.0);
    let ior: Option<schema::Ior> = source.extension(owner, &entry.extensions, "KHR_materials_ior")?;
    let specular: Option<schema::Specular> = source.extension(owner, &entry.extensions, "KHR_materials_specular")?;
    let coat: Option<schema::Clearcoat> = source.extension(owner, &entry.extensions, "KHR_materials_clearcoat")?;
    let (specular, coat) = (specular.unwrap_or_default(), coat.unwrap_or_default());
    let ior = match ior.and_then(|extension| extension.ior).unwrap_or(DEFAULT_IOR) {
        // The extension's value for materials of another model: all reflects like a metal.
        0.0 => f32::INFINITY,
        ior if (1.0..=10.0).contains(&ior) => ior,
        _ => DEFAULT_IOR,
    };
    let at_normal = if ior.is_finite() { ((ior - 1.0) / (ior + 1.0)).powi(2) } else { 1.0 };
    let factor = share(specular.specular_factor, 1.0);
    let color = finite3(Vec3::from(specular.specular_color_factor.unwrap_or([1.0; 3])));
    Ok(Microfacets {
        metallic: share(pbr.metallic_factor, 1.0),
        roughness: share(pbr.roughness_factor, 1.0),
        texture: None,
        specular: (color * at_normal).min(Vec3::ONE) * factor,
        specular_at_grazing: factor,
        coat: share(Some(coat.clearcoat_factor), 0.0),
        coat_roughness: share(Some(coat.clearcoat_roughness_factor), 0.0),
    })
}

/// Plain mirrors and plain glass have roles; what else reflects or lets light pass has lobes.
fn give_lobes(
    source: &Source<'_>,
    entry: &MaterialEntry,
    owner: &dyn Fn() -> String,
    material: &mut Material,
) -> Result<(), SceneError> {
    let blends = material.alpha_mode == AlphaMode::Blend;
    let transmission: Option<schema::Transmission> =
        source.extension(owner, &entry.extensions, "KHR_materials_transmission")?;
    let ior: Option<schema::Ior> = source.extension(owner, &entry.extensions, "KHR_materials_ior")?;
    let volume: Option<schema::Volume> = source.extension(owner, &entry.extensions, "KHR_materials_volume")?;
    let transmission = transmission.unwrap_or_default();
    let is_thin = volume.as_ref().is_none_or(|volume| volume.thickness_factor <= 0.0);
    let mut lobes = Lobes { is_thin, ..Lobes::default() };
    if let Some(facets) = &material.microfacets {
        material.ior = match ior.and_then(|extension| extension.ior).unwrap_or(DEFAULT_IOR) {
            0.0 => DEFAULT_IOR,
            ior if (1.0..=10.0).contains(&ior) => ior,
            ior => {
                source.warn(format!("{}: ior {ior} is outside 1 to 10; {DEFAULT_IOR} is used", owner()));
                DEFAULT_IOR
            }
        };
        material.absorption = volume.filter(|_| !is_thin).map_or(Vec3::ZERO, |volume| absorption(&volume));
        let factor = transmission.transmission_factor;
        lobes.transmission = if factor.is_finite() { factor.clamp(0.0, 1.0) } else { 0.0 };
        material.coat = facets.coat;
        let sheen: Option<schema::Sheen> = source.extension(owner, &entry.extensions, "KHR_materials_sheen")?;
        if let Some(sheen) = sheen {
            lobes.sheen = finite3(Vec3::from(sheen.sheen_color_factor.unwrap_or_default())).min(Vec3::ONE);
            lobes.sheen_roughness = sheen.sheen_roughness_factor.clamp(0.0, 1.0);
        }
        let has_texture = entry.pbr_metallic_roughness.metallic_roughness_texture.is_some();
        let has_sheen = lobes.sheen != Vec3::ZERO;
        let is_plain =
            !(has_texture || blends || has_sheen) && facets.coat == 0.0 && facets.roughness <= MAX_SHARP_ROUGHNESS;
        if is_plain && facets.metallic == 1.0 {
            material.role = Role::Reflector;
            material.mirror_roughness = facets.roughness;
            material.schlick = true;
            return Ok(());
        }
        let lets_all_pass = lobes.transmission == 1.0 && transmission.transmission_texture.is_none() && !is_thin;
        let is_usual = !entry.extensions.contains_key("KHR_materials_specular") && facets.metallic == 0.0;
        if is_plain && lets_all_pass && is_usual {
            material.role = Role::Lens;
            return Ok(());
        }
        let reflects = facets.metallic > 0.0 || has_texture || facets.roughness < MAX_FOLLOWED_ROUGHNESS;
        if !(reflects || has_sheen || facets.coat > 0.0 || lobes.transmission > 0.0 || blends) {
            return Ok(());
        }
    } else if !blends {
        return Ok(());
    }
    material.lobes = Some(Box::new(lobes));
    Ok(())
}

/// Beer-Lambert absorption a unit of length; zero if the distance is infinite or invalid.
fn absorption(volume: &schema::Volume) -> Vec3 {
    let color = Vec3::from(volume.attenuation_color.unwrap_or([1.0; 3]));
    let distance = volume.attenuation_distance.unwrap_or(f32::INFINITY);
    if !(distance.is_finite() && distance > 0.0 && color.is_finite()) {
        return Vec3::ZERO;
    }
    // Black would absorb infinitely much.
    let absorption = -color.clamp(Vec3::splat(1e-6), Vec3::ONE).map(f32::logarithm) / distance;
    finite3(absorption)
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

/// Colours beyond reason (or not numbers) would swamp or poison the picture.
fn finite(color: Vec4) -> Vec4 {
    Vec4::from_array(color.to_array().map(|c| if c.is_finite() { c.clamp(0.0, 1e6) } else { 1.0 }))
}

fn finite3(color: Vec3) -> Vec3 {
    finite(color.extend(1.0)).truncate()
}
