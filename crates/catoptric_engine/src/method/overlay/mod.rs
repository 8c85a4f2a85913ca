//! Overlays over a method's picture: how the method has divided the picture, and what it has moved where.
//!
//! Overlays are made beside the picture, by the same tables; a picture that has none costs nothing for them.

pub mod paths;

use glam::Vec2;

/// The most line segments of an overlay: a bound on memory and on what can be told apart. Chosen, not measured.
pub const MAX_SEGMENTS: usize = 200_000;

/// The most groups of an overlay that have names of their own; the others share the last one.
pub const MAX_GROUPS: usize = 1024;

/// A kind of overlay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum OverlayKind {
    /// Pixels by the path of light that they show.
    Paths,
    /// The edges of moved triangles where they appear.
    VirtualTriangles,
    /// The squares of pixels whose rays are drawn together.
    Tiles,
    /// Pixels by the sample-based camera that draws their reflection.
    Leaves,
    /// Pixels by the layer of the surroundings that they look up.
    Layers,
}

impl OverlayKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Paths, Self::VirtualTriangles, Self::Tiles, Self::Leaves, Self::Layers];

    /// The kind's name, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paths => "reflection groups",
            Self::VirtualTriangles => "virtual triangles",
            Self::Tiles => "tiles",
            Self::Leaves => "leaves",
            Self::Layers => "layers",
        }
    }

    /// The kind's meaning, in one or two sentences.
    pub fn help(self) -> &'static str {
        match self {
            Self::Paths => {
                "Pixels by the sequence of reflectors (R) and glass (T) that light takes to them, from the eye on; \
                 at glass the way through it, where light takes one."
            }
            Self::VirtualTriangles => {
                "The edges of the scene's triangles where the method makes them appear in reflectors and through \
                 glass, cut where something else is seen."
            }
            Self::Tiles => {
                "Squares of the first bounce's pixels whose rays are drawn together: by one bundle, or with a ray for \
                 each pixel; and pixels that are traced sample by sample. Thin lines: the squares of 16 x 16 pixels \
                 that the division begins with."
            }
            Self::Leaves => {
                "Pixels by the leaf of the trees of sample-based cameras that draws their reflection: a camera, or a \
                 list of rays where no camera is accurate. Lines: where one leaf ends and another begins."
            }
            Self::Layers => {
                "Pixels by the layer of the surroundings that shows there, the nearest first; of two paths the one \
                 with more light."
            }
        }
    }
}

/// A straight line in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OverlaySegment {
    /// The line's ends, in pixels from the top left corner.
    pub ends: [Vec2; 2],
    /// The line's group: an index into [`Overlay::groups`], plus 1.
    pub group: u16,
}

/// Something to be shown over a picture: a group for every pixel, lines, or both.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// The kind.
    pub kind: OverlayKind,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// The names of groups; at most [`MAX_GROUPS`].
    pub groups: Vec<String>,
    /// The group of every pixel (an index into `groups`, plus 1), row by row from the top left corner; 0: none. Empty
    /// if there are lines alone.
    pub pixels: Vec<u16>,
    /// Lines, at most [`MAX_SEGMENTS`].
    pub segments: Vec<OverlaySegment>,
    /// The number of lines beyond these, which are left out.
    pub segments_left_out: u64,
}

impl Overlay {
    /// An overlay without groups, pixels and lines.
    pub fn new(kind: OverlayKind, size: [u32; 2]) -> Self {
        let (groups, pixels, segments) = (Vec::new(), Vec::new(), Vec::new());
        Self { kind, size, groups, pixels, segments, segments_left_out: 0 }
    }

    /// Adds a line, or counts it where there are too many.
    pub fn add_segment(&mut self, segment: OverlaySegment) {
        if self.segments.len() < MAX_SEGMENTS {
            self.segments.push(segment);
        } else {
            self.segments_left_out += 1;
        }
    }

    /// The group with a name, plus 1: a new one if there is room, else the last one, which stands for all others.
    pub fn group(&mut self, name: impl Into<String>) -> u16 {
        let name = name.into();
        let known = self.groups.iter().position(|known| *known == name);
        let number = known.unwrap_or_else(|| {
            if self.groups.len() < MAX_GROUPS {
                self.groups.push(if self.groups.len() + 1 < MAX_GROUPS { name } else { "all others".into() });
            }
            self.groups.len() - 1
        });
        number as u16 + 1
    }
}
