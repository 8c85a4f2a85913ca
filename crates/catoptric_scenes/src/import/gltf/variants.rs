//! Variants of materials (KHR_materials_variants).

use super::schema::{self, Document};
use catoptric_core::error::SceneError;

/// The names of the file's variants, in its order; one that is no text is empty, and cannot be chosen.
pub(super) fn names(document: &Document) -> Vec<String> {
    let variants = document.extensions.get("KHR_materials_variants").and_then(|extension| extension.get("variants"));
    let name =
        |variant: &serde_json::Value| variant.get("name").and_then(|name| name.as_str()).unwrap_or_default().into();
    variants.and_then(|variants| variants.as_array()).into_iter().flatten().map(name).collect()
}

/// Gives all primitives the materials that they have in the variant with this index; those that it does not mention
/// keep theirs.
pub(super) fn choose(name: &str, document: &mut Document, variant: usize) -> Result<(), SceneError> {
    let materials = document.materials.len();
    for (index, mesh) in document.meshes.iter_mut().enumerate() {
        for (part, primitive) in mesh.primitives.iter_mut().enumerate() {
            let owner = || format!("meshes[{index}].primitives[{part}]");
            let found: Option<schema::VariantMappings> =
                schema::extension(name, &owner, &primitive.extensions, "KHR_materials_variants")?;
            let mappings = found.unwrap_or_default().mappings;
            let Some(number) = mappings.iter().position(|mapping| mapping.variants.contains(&variant)) else {
                continue;
            };
            let material = mappings[number].material.filter(|material| *material < materials);
            if material.is_none() {
                let field = format!("{}.extensions.KHR_materials_variants.mappings[{number}].material", owner());
                let problem = format!("is missing or no material; the file has {materials}");
                return Err(SceneError::invalid(name, field, problem));
            }
            primitive.material = material;
        }
    }
    Ok(())
}
