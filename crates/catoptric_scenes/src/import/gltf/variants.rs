//! Variants of materials (KHR_materials_variants).

use super::schema::{self, Document};
use catoptric_core::error::SceneError;

/// The names of the file's variants, in its order.
pub(super) fn names(name: &str, document: &Document) -> Result<Vec<String>, SceneError> {
    let owner = || "root".to_owned();
    let found: Option<schema::Variants> =
        schema::extension(name, &owner, &document.extensions, "KHR_materials_variants")?;
    Ok(found.unwrap_or_default().variants.into_iter().map(|variant| variant.name).collect())
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
