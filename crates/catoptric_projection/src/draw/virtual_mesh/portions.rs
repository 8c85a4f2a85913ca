//! Portions of triangles that threads work on.

/// Triangles that are worked on at once. Sizes for threads; chosen, not measured.
const TRIANGLES_AT_ONCE: usize = 8;
const LEAST_PORTIONS: usize = 16;

/// The number of triangles in a portion of work: few triangles are mostly large, and every one is a portion.
pub(super) fn triangles_at_once(count: usize) -> usize {
    (count / LEAST_PORTIONS).clamp(1, TRIANGLES_AT_ONCE)
}
