//! The looks of `.mtl` materials: their models of illumination, and the properties of physically based materials.

use super::super::lobes::{Details, give_role_or_lobes};
use super::library::{MapKind, MtlMaterial};
use super::pictures::Pictures;
use catoptric_core::scene::{AlphaMode, LobeTexture, Lobes, Material, Microfacets, NormalMap};
use glam::Vec3;

/// The index of refraction of materials that name none.
const DEFAULT_IOR: f32 = 1.5;
/// Reflectance at normal incidence of a highlight of 1: twice that of common dielectrics, as Blender writes them.
const HIGHLIGHT_REFLECTANCE: f32 = 0.08;

/// The kinds of reflection and passage that a model of illumination asks for (`illum`, appendix of Wavefront's Advanced
/// Visualizer manual).
#[derive(Clone, Copy, PartialEq, Eq)]
enum Model {
    /// Lambert's law, perhaps with highlights.
    Opaque,
    /// Reflects other surfaces; the flag says that it does so by the angle.
    Mirror {
        by_angle: bool,
    },
    Glass,
}

/// The material that the statements describe, with its pictures.
pub(super) fn material(source: &MtlMaterial, pictures: &mut Pictures<'_>) -> Material {
    let or_white = |color: Option<Vec3>, map: MapKind| match color {
        // Programs write black where a picture is meant alone.
        Some(color) if color != Vec3::ZERO || source.map(map).is_none() => color,
        _ => Vec3::ONE,
    };
    let share = |value: f32| value.clamp(0.0, 1.0);
    let dissolve = share(source.dissolve.unwrap_or(1.0));
    let model = model(source, dissolve);
    let mut material = Material {
        name: source.name.clone(),
        base_color: or_white(source.diffuse, MapKind::Diffuse).extend(1.0),
        emissive: match source.emission {
            None if source.map(MapKind::Emission).is_none() => Vec3::ZERO,
            emission => or_white(emission, MapKind::Emission),
        },
        ior: source.ior.filter(|ior| (1.0..=10.0).contains(ior)).unwrap_or(DEFAULT_IOR),
        ..Material::default()
    };
    let mut lobes = Lobes { is_thin: model != Model::Glass, ..Lobes::default() };
    if model == Model::Glass {
        let filter = source.filter.unwrap_or(Vec3::ONE);
        // A filter of 0 stands in files of programs that know none.
        let filter = if filter == Vec3::ZERO { Vec3::ONE } else { filter.min(Vec3::ONE) };
        lobes.transmission = match source.diffuse {
            Some(diffuse) if diffuse != Vec3::ZERO && dissolve < 1.0 => 1.0 - dissolve,
            _ => 1.0,
        };
        if lobes.transmission == 1.0 {
            material.base_color = filter.extend(1.0);
        }
    } else if dissolve < 1.0 {
        material.alpha_mode = AlphaMode::Blend;
        material.base_color.w = dissolve;
    }
    give_maps(source, &mut material, &mut lobes, pictures);
    give_facets(source, model, &mut material, &mut lobes, pictures);
    material
}

/// The model that the materials' number and opacity ask for.
fn model(source: &MtlMaterial, dissolve: f32) -> Model {
    let filters = source.filter.is_some_and(|filter| filter != Vec3::ZERO && filter != Vec3::ONE);
    let passes = dissolve < 1.0 || filters;
    // A body whose index is that of air bends nothing.
    let bends = source.ior.is_none_or(|ior| ior > 1.0);
    match source.model {
        Some(6 | 7) if bends => Model::Glass,
        Some(4 | 9) if bends && passes => Model::Glass,
        Some(3 | 4 | 8) => Model::Mirror { by_angle: false },
        Some(5) => Model::Mirror { by_angle: true },
        _ => Model::Opaque,
    }
}

/// Pictures of colours, opacity and normals.
fn give_maps(source: &MtlMaterial, material: &mut Material, lobes: &mut Lobes, pictures: &mut Pictures<'_>) {
    let (binding, alpha) = pictures.colors(source);
    material.base_texture = binding;
    if let Some(mode) = alpha {
        material.alpha_mode = mode;
    }
    if let Some(map) = source.map(MapKind::Emission) {
        material.emissive_texture = pictures.color(source, map);
    }
    if let Some(map) = source.map(MapKind::Specular) {
        lobes.textures[LobeTexture::SpecularColor as usize] = pictures.color(source, map);
    }
    let normals = source.map(MapKind::Normals).map(|map| (map, true));
    if let Some((map, holds_normals)) = normals.or(source.map(MapKind::Bump).map(|map| (map, false))) {
        let binding = pictures.normals(source, map, holds_normals);
        material.normal_map = binding.map(|binding| NormalMap { binding, scale: 1.0 });
    }
}

/// The reflection of the surface: its facets, and with them its role or lobes.
fn give_facets(
    source: &MtlMaterial,
    model: Model,
    material: &mut Material,
    lobes: &mut Lobes,
    pictures: &mut Pictures<'_>,
) {
    let share = |value: Option<f32>| value.map(|value| value.clamp(0.0, 1.0));
    let at_normal = ((material.ior - 1.0) / (material.ior + 1.0)).powi(2);
    let facet_maps = [MapKind::Roughness, MapKind::Metallic].map(|kind| source.map(kind));
    let is_physical = [source.roughness, source.metallic, source.sheen, source.coat].iter().any(Option::is_some)
        || facet_maps.iter().any(Option::is_some);
    let mut facets = Microfacets { specular: Vec3::splat(at_normal), roughness: 0.0, ..Microfacets::default() };
    let mut details = Details::default();
    let is_black = source.diffuse.unwrap_or(Vec3::ZERO) == Vec3::ZERO && source.map(MapKind::Diffuse).is_none();
    let specular = source.specular.unwrap_or(if is_black { Vec3::ONE } else { Vec3::ZERO }).min(Vec3::ONE);
    if is_physical {
        let default = |map: usize, without: f32| if facet_maps[map].is_some() { 1.0 } else { without };
        facets.roughness = share(source.roughness).unwrap_or(default(0, 0.5));
        facets.metallic = share(source.metallic).unwrap_or(default(1, 0.0));
        facets.texture = pictures.facets(source, facet_maps);
        details.has_facet_texture = facets.texture.is_some();
        facets.coat = share(source.coat).unwrap_or(0.0);
        facets.coat_roughness = share(source.coat_roughness).unwrap_or(0.0);
        material.coat = facets.coat;
        lobes.sheen = Vec3::splat(share(source.sheen).unwrap_or(0.0));
        lobes.sheen_roughness = 0.3;
        lobes.anisotropy = share(source.anisotropy).unwrap_or(0.0);
        // A share of a turn.
        lobes.anisotropy_rotation = source.anisotropy_rotation.unwrap_or(0.0) * std::f32::consts::TAU;
    } else if let (Model::Mirror { .. }, true, Some(ambient)) = (model, source.is_of_blender, source.ambient) {
        facets.metallic = ambient.element_sum().min(3.0) / 3.0;
        facets.roughness = highlight_roughness(source);
        facets.specular = (specular * HIGHLIGHT_REFLECTANCE).min(Vec3::ONE);
    } else if let (Model::Mirror { by_angle }, true) = (model, specular != Vec3::ZERO) {
        details.has_specular = true;
        facets.specular = specular;
        facets.specular_at_grazing = if by_angle { 1.0 } else { specular.max_element() };
        if is_black {
            (facets.metallic, material.base_color) = (1.0, specular.extend(material.base_color.w));
            material.base_texture = None;
        }
    } else if model != Model::Glass {
        let has_highlights = source.model.is_none_or(|model| model >= 2) && source.exponent.is_some_and(|n| n > 0.0);
        let has_map = lobes.textures[LobeTexture::SpecularColor as usize].is_some();
        if !(has_highlights && (specular != Vec3::ZERO || has_map) && source.specular.is_some()) {
            lobes.textures = Default::default();
            if material.alpha_mode == AlphaMode::Blend {
                material.lobes = Some(Box::new(std::mem::take(lobes)));
            }
            return;
        }
        let factor = if specular == Vec3::ZERO { Vec3::ONE } else { specular };
        facets.specular = (factor * HIGHLIGHT_REFLECTANCE).min(Vec3::ONE);
        facets.roughness = highlight_roughness(source);
        details.has_specular = true;
    }
    material.microfacets = Some(facets);
    give_role_or_lobes(material, std::mem::take(lobes), details);
    if let (Model::Mirror { by_angle: false }, false) = (model, is_physical) {
        material.schlick = false;
    }
}

/// Perceptual roughness of highlights: Phong's exponent as the width of facets (Walter et al. 2007, section 5.2:
/// 2 / alpha^2 - 2), or what Blender writes in its place: 1000 (1 - roughness)^2.
fn highlight_roughness(source: &MtlMaterial) -> f32 {
    let exponent = source.exponent.unwrap_or(0.0).max(0.0);
    if source.is_of_blender {
        1.0 - (exponent / 1000.0).min(1.0).sqrt()
    } else {
        (2.0 / (exponent + 2.0)).sqrt().sqrt()
    }
}
