//! Portions of triangles that threads work on.

/// Triangles that are worked on at once. Sizes for threads; chosen, not measured.
const TRIANGLES_AT_ONCE: usize = 8;
const LEAST_PORTIONS: usize = 16;

/// Of so many triangles as many are worked on at once: of few, which are mostly large, every one alone.
pub(super) fn triangles_at_once(count: usize) -> usize {
    (count / LEAST_PORTIONS).clamp(1, TRIANGLES_AT_ONCE)
}
