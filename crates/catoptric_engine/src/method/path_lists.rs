//! The virtual geometry of a view for those who draw it otherwise than the CPU's rasteriser: with a GPU.

use crate::method::Report;
use crate::raster::DrawList;

/// The geometry that appears at the ends of a view's paths: a list a path, shorter paths first.
///
/// [`Stencil::list`](crate::raster::Stencil::list) counts from 1, the place of a list plus one; 0 is what is seen
/// directly, of which there is no list. A triangle's group is the object that it belongs to plus 1 where paths may go
/// on from it, else 0.
#[derive(Clone, Debug, Default)]
pub struct PathLists {
    /// The lists. Their vertices' `w` (in perspective views; else their `depth`) orders visibility.
    pub lists: Vec<DrawList>,
    /// True if reflectors and lenses are to be drawn by something else where no list goes on, and in the
    /// [holes](DrawList::holes) of those that do. Else they show the environment there.
    pub has_rest: bool,
    /// Times, counts and fall-backs of making them.
    pub report: Report,
}
