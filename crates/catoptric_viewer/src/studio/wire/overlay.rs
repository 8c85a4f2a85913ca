//! Overlays as text and bytes.

use super::error::WireError;
use catoptric::methods::overlay::{MAX_GROUPS, Overlay, OverlayKind, OverlaySegment};
use glam::Vec2;
use serde::{Deserialize, Serialize};

/// Bytes of a line: four places and a group.
const SEGMENT_BYTES: usize = 18;

/// An overlay without its pixels and lines, which are bytes.
#[derive(Serialize, Deserialize)]
pub(super) struct WireOverlay {
    kind: String,
    size: [u32; 2],
    groups: Vec<String>,
    has_pixels: bool,
    segments_left_out: u64,
}

/// The kind of a name.
pub(super) fn kind_of(name: &str) -> Result<OverlayKind, WireError> {
    let found = OverlayKind::ALL.into_iter().find(|kind| kind.name() == name);
    found.ok_or_else(|| WireError::new(format!("there is no overlay `{name}`")))
}

/// An overlay, and the bytes that go with it: pixels, then lines.
pub(super) fn written(overlay: &Overlay) -> (WireOverlay, Vec<u8>) {
    let Overlay { kind, size, groups, pixels, segments, segments_left_out } = overlay;
    let mut bytes = Vec::with_capacity(2 * pixels.len() + SEGMENT_BYTES * segments.len());
    bytes.extend(pixels.iter().flat_map(|group| group.to_le_bytes()));
    for OverlaySegment { ends: [a, b], group } in segments {
        bytes.extend([a.x, a.y, b.x, b.y].into_iter().flat_map(f32::to_le_bytes));
        bytes.extend(group.to_le_bytes());
    }
    let (kind, groups, has_pixels) = (kind.name().into(), groups.clone(), !pixels.is_empty());
    (WireOverlay { kind, size: *size, groups, has_pixels, segments_left_out: *segments_left_out }, bytes)
}

impl WireOverlay {
    /// The overlay with these bytes.
    pub(super) fn read(self, bytes: &[u8]) -> Result<Overlay, WireError> {
        let Self { kind, size, groups, has_pixels, segments_left_out } = self;
        let wanted = (size[0] as usize).checked_mul(size[1] as usize).and_then(|pixels| pixels.checked_mul(2));
        let wanted = if has_pixels { wanted.unwrap_or(usize::MAX) } else { 0 };
        let short = || WireError::new(format!("{} bytes for an overlay", bytes.len()));
        let (pixels, lines) = bytes.split_at_checked(wanted).ok_or_else(short)?;
        let (lines, rest) = lines.as_chunks::<SEGMENT_BYTES>();
        if !rest.is_empty() || groups.len() > MAX_GROUPS {
            return Err(short());
        }
        let pixels: Vec<u16> = pixels.as_chunks().0.iter().map(|group| u16::from_le_bytes(*group)).collect();
        let segment = |line: &[u8; SEGMENT_BYTES]| {
            let place = |index: usize| {
                let at = 4 * index;
                f32::from_le_bytes([line[at], line[at + 1], line[at + 2], line[at + 3]])
            };
            let ends = [Vec2::new(place(0), place(1)), Vec2::new(place(2), place(3))];
            OverlaySegment { ends, group: u16::from_le_bytes([line[16], line[17]]) }
        };
        let segments: Vec<OverlaySegment> = lines.iter().map(segment).collect();
        let is_known = |group: u16| usize::from(group) <= groups.len();
        let are_lines = segments.iter().all(|segment| segment.group > 0 && is_known(segment.group));
        if !are_lines || !pixels.iter().all(|group| is_known(*group)) {
            return Err(WireError::new("an overlay's group has no name".into()));
        }
        Ok(Overlay { kind: kind_of(&kind)?, size, groups, pixels, segments, segments_left_out })
    }
}
