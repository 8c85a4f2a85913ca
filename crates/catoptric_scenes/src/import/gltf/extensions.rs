//! The extensions that are understood, and the error for files that need another one.

use super::source::Source;
use catoptric_core::error::SceneError;

/// Understood in full, as far as the methods can draw them.
const SUPPORTED: [&str; 25] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
];

/// Extensions that change no picture: what can be done with nodes, sounds, physics, data about the scene, and coarser
/// versions for the distance.
const WITHOUT_EFFECT: [&str; 13] = [
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "FB_ngon_encoding",
    "KHR_audio_emitter",
    "KHR_implicit_shapes",
    "KHR_interactivity",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "MSFT_lod",
    "OMI_physics_body",
    "OMI_physics_shape",
];

/// Extensions without which the rest of a file can still be drawn, even where it says that they are required.
const DRAWN_WITHOUT: [&str; 2] = ["KHR_animation_pointer", "KHR_materials_volume_scatter"];

/// True if an extension is understood, or has no effect.
pub(super) fn is_supported(extension: &str) -> bool {
    SUPPORTED.contains(&extension) || WITHOUT_EFFECT.contains(&extension)
}

/// Refuses files that cannot be drawn without an extension that is not understood, and warns of newer versions and of
/// what else is not drawn.
pub(super) fn check_required(source: &Source<'_>) -> Result<(), SceneError> {
    if let Some(version) = source.document.asset.min_version.as_ref().filter(|version| *version != "2.0") {
        source.warn(format!("asset.minVersion is {version}: what is newer than glTF 2.0 in the file is not drawn"));
    }
    for required in &source.document.extensions_required {
        if !(is_supported(required) || DRAWN_WITHOUT.contains(&required.as_str())) {
            return Err(SceneError::Unsupported {
                file: source.name.into(),
                feature: format!("the glTF extension {required}"),
                remedy: format!("save it without; these can be read: {}", SUPPORTED.join(", ")),
            });
        }
    }
    // Extensions of materials that are not drawn are told where the material is read.
    let others = |name: &&String| !is_supported(name) && !name.contains("_materials_");
    let others: Vec<&str> = source.document.extensions_used.iter().filter(others).map(String::as_str).collect();
    if !others.is_empty() {
        source.warn(format!("extensionsUsed: what {} adds is not drawn", others.join(", ")));
    }
    Ok(())
}
