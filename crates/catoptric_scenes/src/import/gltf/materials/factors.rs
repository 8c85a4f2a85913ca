//! The factors of a material: its facets, its role or its lobes.

use super::super::super::lobes::{self, Details, give_role_or_lobes};
use super::super::schema::{self, Material as MaterialEntry};
use super::super::source::Source;
use catoptric_core::error::SceneError;
use catoptric_core::scene::{AlphaMode, Film, Lobes, Material, Microfacets};
use glam::{Vec3, Vec4};
use std::borrow::Cow;

/// The index of refraction of materials that name none, and its reflectance at normal incidence.
const DEFAULT_IOR: f32 = 1.5;
const USUAL_REFLECTANCE: f32 = 0.04;

/// The reflection of a lit material's facets.
pub(super) fn microfacets(
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
pub(super) fn give_lobes(
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
        set_modifiers(source, entry, owner, &mut lobes)?;
        let has_field = |key: &str, field| entry.extensions.get(key).is_some_and(|value| value.get(field).is_some());
        let details = Details {
            has_facet_texture: entry.pbr_metallic_roughness.metallic_roughness_texture.is_some(),
            has_transmission_texture: has_field("KHR_materials_transmission", "transmissionTexture"),
            has_specular: entry.extensions.contains_key("KHR_materials_specular"),
        };
        give_role_or_lobes(material, lobes, details);
        return Ok(());
    }
    if blends {
        material.lobes = Some(Box::new(lobes));
    }
    Ok(())
}

/// Anisotropy, thin films, dispersion and diffuse transmission.
fn set_modifiers(
    source: &Source<'_>,
    entry: &MaterialEntry,
    owner: &dyn Fn() -> String,
    lobes: &mut Lobes,
) -> Result<(), SceneError> {
    let share = |value: f32| if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.0 };
    let extensions = &entry.extensions;
    let anisotropy: Option<schema::Anisotropy> = source.extension(owner, extensions, "KHR_materials_anisotropy")?;
    if let Some(anisotropy) = anisotropy {
        lobes.anisotropy = share(anisotropy.anisotropy_strength);
        let rotation = anisotropy.anisotropy_rotation;
        lobes.anisotropy_rotation = if rotation.is_finite() { rotation } else { 0.0 };
    }
    let dispersion: Option<schema::Dispersion> = source.extension(owner, extensions, "KHR_materials_dispersion")?;
    // Nothing bends colours further apart than this: Abbe's number of 1.
    const MOST_DISPERSION: f32 = 20.0;
    lobes.dispersion =
        dispersion.map_or(0.0, |extension| share(extension.dispersion / MOST_DISPERSION)) * MOST_DISPERSION;
    let passing: Option<schema::DiffuseTransmission> =
        source.extension(owner, extensions, "KHR_materials_diffuse_transmission")?;
    if let Some(passing) = passing {
        lobes.diffuse_transmission = share(passing.diffuse_transmission_factor);
        let color = passing.diffuse_transmission_color_factor.unwrap_or([1.0; 3]);
        lobes.diffuse_transmission_color = finite3(Vec3::from(color)).min(Vec3::ONE);
    }
    let film: Option<schema::Iridescence> = source.extension(owner, extensions, "KHR_materials_iridescence")?;
    lobes.film = film.map(|film| {
        let number = |value: Option<f32>, default: f32| value.filter(|value| value.is_finite()).unwrap_or(default);
        let thickness_nm =
            [number(film.iridescence_thickness_minimum, 100.0), number(film.iridescence_thickness_maximum, 400.0)];
        Film {
            share: share(film.iridescence_factor),
            ior: number(film.iridescence_ior, 1.3).clamp(1.0, 10.0),
            thickness_nm: thickness_nm.map(|nanometres| nanometres.clamp(0.0, 1e6)),
        }
    });
    lobes.film = lobes.film.filter(|film| film.share > 0.0);
    Ok(())
}

/// A material with the properties of the metallic-roughness model, and, if it is written in those of
/// KHR_materials_pbrSpecularGlossiness, the factor on the glossiness in its roughness texture, over 65535: its specular
/// colour is a dielectric's reflectance at normal incidence.
pub(super) fn with_metallic_roughness<'e>(
    source: &Source<'_>,
    entry: &'e MaterialEntry,
    owner: &dyn Fn() -> String,
) -> Result<(Cow<'e, MaterialEntry>, Option<u16>), SceneError> {
    const KEY: &str = "KHR_materials_pbrSpecularGlossiness";
    let Some(given): Option<schema::SpecularGlossiness> = source.extension(owner, &entry.extensions, KEY)? else {
        return Ok((Cow::Borrowed(entry), None));
    };
    let glossiness = given.glossiness_factor.filter(|factor| factor.is_finite()).unwrap_or(1.0).clamp(0.0, 1.0);
    let texture = given.specular_glossiness_texture;
    let mut entry = entry.clone();
    let specular = finite3(Vec3::from(given.specular_factor.unwrap_or([1.0; 3]))) / USUAL_REFLECTANCE;
    let mut of_specular = serde_json::json!({ "specularColorFactor": specular.to_array() });
    if texture.is_some() {
        of_specular["specularColorTexture"] = entry.extensions[KEY]["specularGlossinessTexture"].clone();
    }
    entry.extensions.insert("KHR_materials_specular".into(), of_specular);
    entry.pbr_metallic_roughness = schema::MetallicRoughness {
        base_color_factor: Some(given.diffuse_factor.unwrap_or([1.0; 4])),
        base_color_texture: given.diffuse_texture,
        metallic_factor: Some(0.0),
        roughness_factor: Some(if texture.is_some() { 1.0 } else { 1.0 - glossiness }),
        metallic_roughness_texture: texture,
    };
    Ok((Cow::Owned(entry), Some((glossiness * 65535.0).round() as u16)))
}

/// Beer-Lambert absorption a unit of length; zero if the distance is infinite or invalid.
fn absorption(volume: &schema::Volume) -> Vec3 {
    let color = Vec3::from(volume.attenuation_color.unwrap_or([1.0; 3]));
    lobes::absorption(color, volume.attenuation_distance.unwrap_or(f32::INFINITY))
}

/// Colours beyond reason (or not numbers) would swamp or poison the picture.
pub(super) fn finite(color: Vec4) -> Vec4 {
    Vec4::from_array(color.to_array().map(|c| if c.is_finite() { c.clamp(0.0, 1e6) } else { 1.0 }))
}

pub(super) fn finite3(color: Vec3) -> Vec3 {
    finite(color.extend(1.0)).truncate()
}
