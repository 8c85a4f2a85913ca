//! Tests with small files that are put together in memory.

mod animation;
mod broken;
mod compression;
mod container;
mod geometry;
mod ktx2;
pub(super) mod materials;
mod nodes;
mod schema;
mod surfaces;
mod textures;

use catoptric_core::scene::model::Model;
use catoptric_core::scene::{PoseOptions, Scene};
use catoptric_scenes::import::NoFiles;
use catoptric_scenes::import::gltf::{from_slice, from_slice_as};
use serde_json::{Value, json};

pub(super) const I8: u32 = 5120;
pub(super) const U8: u32 = 5121;
pub(super) const I16: u32 = 5122;
pub(super) const U16: u32 = 5123;
pub(super) const U32: u32 = 5125;
pub(super) const F32: u32 = 5126;

/// A glTF file while it is put together: all binary data goes into one buffer.
#[derive(Clone)]
pub(super) struct File {
    pub(super) json: Value,
    pub(super) binary: Vec<u8>,
}

/// Numbers as bytes.
pub(super) trait Bytes {
    fn bytes(&self) -> Vec<u8>;
}

macro_rules! bytes_of {
    ($($type:ty)*) => {$(
        impl Bytes for [$type] {
            fn bytes(&self) -> Vec<u8> {
                self.iter().flat_map(|number| number.to_le_bytes()).collect()
            }
        }
    )*};
}
bytes_of!(u8 i8 u16 i16 u32 f32);

impl File {
    pub(super) fn new() -> Self {
        Self { json: json!({ "asset": { "version": "2.0" } }), binary: Vec::new() }
    }

    /// Adds an entry to a top-level list and returns its index.
    pub(super) fn push(&mut self, list: &str, entry: Value) -> usize {
        let entries = &mut self.json[list];
        if entries.is_null() {
            *entries = json!([]);
        }
        let entries = entries.as_array_mut().unwrap();
        entries.push(entry);
        entries.len() - 1
    }

    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        while !self.binary.len().is_multiple_of(4) {
            self.binary.push(0);
        }
        let offset = self.binary.len();
        self.binary.extend(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    pub(super) fn accessor<T>(&mut self, component: u32, kind: &str, count: usize, numbers: &[T]) -> usize
    where
        [T]: Bytes,
    {
        let view = self.view(&numbers.bytes());
        self.push("accessors", json!({ "bufferView": view, "componentType": component, "type": kind, "count": count }))
    }

    /// Positions, three numbers a vertex.
    pub(super) fn positions(&mut self, numbers: &[f32]) -> usize {
        self.accessor(F32, "VEC3", numbers.len() / 3, numbers)
    }

    /// A node with a mesh of one primitive.
    pub(super) fn show(&mut self, primitive: Value) -> usize {
        let mesh = self.push("meshes", json!({ "primitives": [primitive] }));
        self.push("nodes", json!({ "mesh": mesh }))
    }

    /// A triangle in the xy plane, shown by node 0.
    pub(super) fn triangle() -> Self {
        let mut file = Self::new();
        let positions = file.positions(&TRIANGLE);
        file.show(json!({ "attributes": { "POSITION": positions } }));
        file
    }

    pub(super) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if !self.binary.is_empty() && json["buffers"].is_null() {
            json["buffers"] = json!([{ "byteLength": self.binary.len() }]);
        }
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut binary = self.binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let chunks = [(text, *b"JSON"), (binary, *b"BIN\0")];
        let length: usize = 12 + chunks.iter().map(|(data, _)| 8 + data.len()).sum::<usize>();
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        glb.extend((length as u32).to_le_bytes());
        for (data, kind) in chunks {
            glb.extend((data.len() as u32).to_le_bytes());
            glb.extend(kind);
            glb.extend(data);
        }
        glb
    }

    pub(super) fn model(&self) -> Model {
        from_slice("test.glb", &self.glb(), &NoFiles).unwrap()
    }

    pub(super) fn scene(&self) -> Scene {
        self.model().pose(&PoseOptions::default()).unwrap()
    }

    pub(super) fn error(&self) -> String {
        from_slice("test.glb", &self.glb(), &NoFiles).unwrap_err().to_string()
    }

    /// The file must be read, with a warning that names this.
    #[track_caller]
    pub(super) fn assert_warning(&self, needle: &str) {
        let warnings = self.model().warnings;
        assert!(warnings.iter().any(|warning| warning.contains(needle)), "{warnings:?}");
    }

    /// The error must name this.
    #[track_caller]
    pub(super) fn assert_error(&self, needle: &str) {
        let message = self.error();
        assert!(message.starts_with("test.glb: ") && message.contains(needle), "{message}");
    }
}

pub(super) const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
