//! Decoded pictures.

/// A decoded picture: RGBA, rows from the top.
#[derive(Debug)]
pub(in super::super) struct Picture {
    pub(in super::super) width: u32,
    pub(in super::super) height: u32,
    pub(in super::super) texels: Vec<[u8; 4]>,
}

#[cfg(feature = "gltf")]
impl Picture {
    /// Returns true if any texel is not fully opaque.
    pub(in super::super) fn is_translucent(&self) -> bool {
        self.texels.iter().any(|texel| texel[3] < 255)
    }
}
