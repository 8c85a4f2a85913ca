//! The JSON of a glTF file as plain structs.
//!
//! Only fields that the importer uses are here. Fields are optional wherever a sound rest can be drawn without them;
//! indices are plain numbers that are checked where they are used.

use catoptric_core::error::SceneError;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

pub(super) type Extensions = Map<String, Value>;

/// More values than this in the JSON are refused: every one takes far more memory than text.
const MAX_JSON_VALUES: usize = 8_000_000;
/// The most entries of a top-level list.
const MAX_ENTRIES: usize = 1 << 20;

macro_rules! schema {
    ($($(#[$meta:meta])* $name:ident { $($(#[$field_meta:meta])* $field:ident: $type:ty,)* })*) => {$(
        $(#[$meta])*
        #[derive(Clone, Debug, Default, Deserialize)]
        #[serde(rename_all = "camelCase", default)]
        pub(super) struct $name { $($(#[$field_meta])* pub(super) $field: $type,)* }
    )*};
}

schema! {
    Document {
        asset: Asset,
        extensions: Extensions,
        extensions_used: Vec<String>,
        extensions_required: Vec<String>,
        accessors: Vec<Accessor>,
        animations: Vec<Animation>,
        buffers: Vec<Buffer>,
        buffer_views: Vec<BufferView>,
        cameras: Vec<Camera>,
        images: Vec<Image>,
        materials: Vec<Material>,
        meshes: Vec<Mesh>,
        nodes: Vec<Node>,
        samplers: Vec<Sampler>,
        scene: Option<usize>,
        scenes: Vec<Scene>,
        skins: Vec<Skin>,
        textures: Vec<Texture>,
    }
    Asset { version: String, min_version: Option<String>, }
    Accessor {
        buffer_view: Option<usize>,
        byte_offset: u64,
        component_type: u32,
        normalized: bool,
        count: u64,
        #[serde(rename = "type")]
        kind: String,
        sparse: Option<Sparse>,
    }
    Sparse { count: u64, indices: SparseIndices, values: SparseValues, }
    SparseIndices { buffer_view: Option<usize>, byte_offset: u64, component_type: u32, }
    SparseValues { buffer_view: Option<usize>, byte_offset: u64, }
    Animation { name: String, channels: Vec<Channel>, samplers: Vec<AnimationSampler>, }
    Channel { sampler: Option<usize>, target: Target, }
    Target { node: Option<usize>, path: String, }
    AnimationSampler { input: Option<usize>, interpolation: Option<Value>, output: Option<usize>, }
    Buffer { uri: Option<String>, byte_length: u64, }
    BufferView {
        buffer: Option<usize>,
        byte_offset: u64,
        byte_length: u64,
        byte_stride: Option<u64>,
        extensions: Extensions,
    }
    Camera {
        name: String,
        #[serde(rename = "type")]
        kind: String,
        perspective: Option<Perspective>,
        orthographic: Option<Orthographic>,
    }
    Perspective { yfov: f32, }
    Orthographic { ymag: f32, }
    Image { name: String, uri: Option<String>, buffer_view: Option<usize>, }
    Material {
        name: String,
        pbr_metallic_roughness: MetallicRoughness,
        emissive_factor: [f32; 3],
        emissive_texture: Option<TextureInfo>,
        normal_texture: Option<TextureInfo>,
        occlusion_texture: Option<TextureInfo>,
        alpha_mode: Option<String>,
        alpha_cutoff: Option<f32>,
        double_sided: bool,
        extensions: Extensions,
    }
    MetallicRoughness {
        base_color_factor: Option<[f32; 4]>,
        base_color_texture: Option<TextureInfo>,
        metallic_factor: Option<f32>,
        roughness_factor: Option<f32>,
        metallic_roughness_texture: Option<TextureInfo>,
    }
    TextureInfo {
        index: Option<usize>,
        tex_coord: u32,
        /// The factor on x and y of normals.
        scale: Option<f32>,
        /// The share of occlusion that counts.
        strength: Option<f32>,
        extensions: Extensions,
    }
    Mesh { name: String, primitives: Vec<Primitive>, weights: Vec<f32>, extras: Value, }
    Primitive {
        attributes: BTreeMap<String, usize>,
        indices: Option<usize>,
        material: Option<usize>,
        mode: Option<u32>,
        targets: Vec<BTreeMap<String, usize>>,
        extensions: Extensions,
    }
    Node {
        name: String,
        camera: Option<usize>,
        children: Vec<usize>,
        matrix: Option<[f32; 16]>,
        translation: Option<[f32; 3]>,
        rotation: Option<[f32; 4]>,
        scale: Option<[f32; 3]>,
        mesh: Option<usize>,
        skin: Option<usize>,
        weights: Vec<f32>,
        extensions: Extensions,
        extras: Value,
    }
    Sampler {
        mag_filter: Option<u32>,
        min_filter: Option<u32>,
        wrap_s: Option<u32>,
        wrap_t: Option<u32>,
    }
    Scene { nodes: Vec<usize>, }
    Skin { inverse_bind_matrices: Option<usize>, joints: Vec<usize>, }
    Texture { sampler: Option<usize>, source: Option<usize>, extensions: Extensions, }

    Light {
        color: Option<[f32; 3]>, intensity: Option<f32>, #[serde(rename = "type")] kind: String, range: Option<f32>,
        spot: Spot,
    }
    Spot { inner_cone_angle: f32, outer_cone_angle: Option<f32>, }
    Lights { lights: Vec<Light>, }
    VariantMappings { mappings: Vec<VariantMapping>, }
    VariantMapping { material: Option<usize>, variants: Vec<usize>, }
    LightReference { light: Option<usize>, }
    TextureTransform { offset: [f32; 2], rotation: f32, scale: Option<[f32; 2]>, tex_coord: Option<u32>, }
    Visibility { visible: Option<bool>, }
    Ior { ior: Option<f32>, }
    EmissiveStrength { emissive_strength: Option<f32>, }
    Transmission { transmission_factor: f32, }
    Volume { thickness_factor: f32, attenuation_distance: Option<f32>, attenuation_color: Option<[f32; 3]>, }
    Clearcoat {
        clearcoat_factor: f32,
        clearcoat_roughness_factor: f32,
        clearcoat_texture: Option<TextureInfo>,
        clearcoat_normal_texture: Option<TextureInfo>,
    }
    Specular { specular_factor: Option<f32>, specular_color_factor: Option<[f32; 3]>, }
    Sheen { sheen_color_factor: Option<[f32; 3]>, sheen_roughness_factor: f32, }
    Anisotropy { anisotropy_strength: f32, anisotropy_rotation: f32, }
    Dispersion { dispersion: f32, }
    DiffuseTransmission { diffuse_transmission_factor: f32, diffuse_transmission_color_factor: Option<[f32; 3]>, }
    Iridescence {
        iridescence_factor: f32,
        iridescence_ior: Option<f32>,
        iridescence_thickness_minimum: Option<f32>,
        iridescence_thickness_maximum: Option<f32>,
    }
    SpecularGlossiness {
        diffuse_factor: Option<[f32; 4]>,
        diffuse_texture: Option<TextureInfo>,
        specular_factor: Option<[f32; 3]>,
        glossiness_factor: Option<f32>,
        specular_glossiness_texture: Option<TextureInfo>,
    }
    TextureSource { source: Option<usize>, }
    Draco { buffer_view: Option<usize>, attributes: BTreeMap<String, u32>, }
    Instancing { attributes: BTreeMap<String, usize>, }
    Meshopt {
        buffer: Option<usize>,
        byte_offset: u64,
        byte_length: u64,
        byte_stride: u64,
        count: u64,
        mode: String,
        filter: Option<String>,
    }
}

impl Document {
    /// The name of a picture, else its file, else its place.
    pub(super) fn picture_name(&self, picture: usize) -> String {
        let image = &self.images[picture];
        [image.name.as_str(), image.uri.as_deref().unwrap_or("")]
            .into_iter()
            .find(|name| !name.is_empty() && !name.get(..5).is_some_and(|begin| begin.eq_ignore_ascii_case("data:")))
            .map_or_else(|| format!("images[{picture}]"), String::from)
    }
}

/// Reads the JSON part of a file.
pub(super) fn parse(name: &str, json: &[u8]) -> Result<Document, SceneError> {
    let invalid = |field: &str, problem: String| SceneError::invalid(name, field, problem);
    if json.iter().filter(|byte| **byte == b',').count() > MAX_JSON_VALUES {
        return Err(invalid("JSON", format!("more than {MAX_JSON_VALUES} values")));
    }
    let mut root: Value = serde_json::from_slice(json).map_err(|error| invalid("JSON", broken_json(&error)))?;
    let Value::Object(entries) = &root else {
        return Err(invalid("JSON", "a glTF file is one object `{...}`".into()));
    };
    for (key, value) in entries {
        if value.as_array().is_some_and(|list| list.len() > MAX_ENTRIES) {
            return Err(invalid(key, format!("more than {MAX_ENTRIES} entries")));
        }
    }
    // Files of version 1 hold other kinds of values everywhere: they are named before their fields are read.
    let version = entries.get("asset").and_then(|asset| asset.get("version"));
    let version = version.map(|version| version.as_str().map_or_else(|| version.to_string(), str::to_owned));
    let Some(version) = version else { return Err(invalid("asset.version", "is missing; glTF 2 has it".into())) };
    if version.split('.').next() != Some("2") {
        let version: String = version.chars().take(20).collect();
        let problem = format!("is glTF {version}, only glTF 2 can be read: convert it, as with gltf-pipeline");
        return Err(invalid("asset.version", problem));
    }
    whole_numbers(&mut root);
    let document: Document = typed(root).map_err(|(field, problem)| invalid(&field, problem))?;
    Ok(document)
}

/// An extension's object, if it is there.
pub(super) fn extension<T: DeserializeOwned>(
    name: &str,
    owner: &dyn Fn() -> String,
    extensions: &Extensions,
    key: &str,
) -> Result<Option<T>, SceneError> {
    let Some(value) = extensions.get(key) else { return Ok(None) };
    typed(value.clone())
        .map(Some)
        .map_err(|(field, problem)| SceneError::invalid(name, format!("{}.extensions.{key}.{field}", owner()), problem))
}

/// A value as a struct; the error is the path of the field and its fault.
pub(super) fn typed<T: DeserializeOwned>(value: Value) -> Result<T, (String, String)> {
    serde_path_to_error::deserialize(value)
        .map_err(|error| (error.path().to_string(), in_words(&error.inner().to_string())))
}

/// The message about a text that is no JSON.
fn broken_json(error: &serde_json::Error) -> String {
    let problem = match error.to_string() {
        _ if error.is_eof() => "ends too early",
        text if text.starts_with("recursion limit") => "has lists within lists too deep",
        _ => "is no JSON",
    };
    format!("{problem} at line {}, column {}", error.line(), error.column())
}

/// The message about a value of the wrong kind, without names of types of this program.
fn in_words(message: &str) -> String {
    let wrong = message.strip_prefix("invalid type: ").or_else(|| message.strip_prefix("invalid value: "));
    let Some((found, wanted)) = wrong.and_then(|wrong| wrong.split_once(", expected ")) else { return message.into() };
    let wanted = match wanted {
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number of 0 or more",
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number",
        "f32" | "f64" => "a number",
        "a string" => "a text",
        "a sequence" => "a list",
        wanted if wanted.starts_with("struct ") => "an object `{...}`",
        wanted => wanted,
    };
    format!("is {found}; must be {wanted}")
}

/// Turns numbers such as `3.0` and `3e0` into whole ones: JSON does not distinguish them, and glTF allows both.
fn whole_numbers(root: &mut Value) {
    let mut open = vec![root];
    while let Some(value) = open.pop() {
        match value {
            Value::Array(list) => open.extend(list.iter_mut()),
            Value::Object(map) => open.extend(map.values_mut()),
            Value::Number(number) if number.is_f64() => {
                let float = number.as_f64().unwrap_or(0.5);
                // Above 2^53 not every whole number is a double.
                if float.fract() == 0.0 && (0.0..9_007_199_254_740_992.0).contains(&float) {
                    *number = (float as u64).into();
                }
            }
            _ => {}
        }
    }
}
