//! Sizes of the pictures, and the parts of them that panels show.

/// The size of the paper's pictures.
pub(super) const FULL: [u32; 2] = [720, 480];

/// The size of pictures that are shown in one panel only.
pub(super) const PANEL: [u32; 2] = [360, 240];

/// The part of the pictures of `sphere_room` that shows the ball.
pub(super) const BALL: [f32; 4] = [0.27, 0.1, 0.46, 0.72];

/// The width of panels that show the ball alone.
pub(super) const NARROW: u32 = 240;
