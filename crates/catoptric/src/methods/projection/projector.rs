//! What every projection method answers: where does a scene point appear?

use crate::optics::bundle::{Bounce, BounceKind};
use crate::scene::Scene;
use glam::{Vec2, Vec3};

pub use crate::optics::specular_solver::MAX_BOUNCES;

/// A sequence of bounces, counted from the eye. A path and its focal index make a reflection group.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SpecularPath {
    /// What happens, from the eye on.
    pub bounces: Vec<Bounce>,
}

impl SpecularPath {
    /// The letters of its kinds: `R` or `T`, from the eye on.
    pub fn kinds(&self) -> String {
        self.bounces.iter().map(|bounce| bounce.kind.letter()).collect()
    }

    /// The names of its objects from the eye on, joined by `>`.
    pub fn names(&self, scene: &Scene) -> String {
        let name = |bounce: &Bounce| scene.objects[bounce.object as usize].name.as_str();
        self.bounces.iter().map(name).collect::<Vec<_>>().join(">")
    }

    /// The path without its last bounce; none for paths of one bounce.
    pub fn parent(&self) -> Option<Self> {
        let (_, rest) = self.bounces.split_last()?;
        (!rest.is_empty()).then(|| Self { bounces: rest.to_vec() })
    }

    /// Whether any bounce passes through a surface.
    pub fn transmits(&self) -> bool {
        self.bounces.iter().any(|bounce| bounce.kind == BounceKind::Transmit)
    }
}

/// One appearance of a scene point: its virtual vertex and how that moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Projection {
    /// Index of the path in [`VertexProjector::paths`].
    pub path: u32,
    /// Focal points that the path has passed, summed over its segments.
    pub focal_index: u32,
    /// Where it appears, in pixels from the picture's top left corner.
    pub image_px: Vec2,
    /// The change of `image_px.x` and of `image_px.y` with the scene point: pixels a scene unit.
    pub image_change: [Vec3; 2],
    /// Optical length (within glass times its index of refraction) from the eye's plane (orthographic) or the eye to the
    /// scene point along the path, in scene units.
    pub path_length: f32,
    /// The first reflection point, counted from the eye.
    pub reflection_point: Vec3,
    /// Length of the path's last segment, from the last bounce to the scene point, in scene units.
    pub last_segment: f32,
    /// Estimated error in pixels; 0 where a solver has converged.
    pub error_px: f32,
}

impl Projection {
    /// It, unless any of its numbers means nothing.
    #[inline]
    pub(super) fn if_meaningful(self) -> Option<Self> {
        let meaningful = self.image_px.is_finite()
            && self.image_change.iter().all(|change| change.is_finite())
            && self.path_length.is_finite()
            && self.path_length > 0.0;
        meaningful.then_some(self)
    }

    /// Where a point `step` away is expected to appear, to first order.
    #[inline]
    pub fn predicted(&self, step: Vec3) -> Vec2 {
        self.image_px + Vec2::new(self.image_change[0].dot(step), self.image_change[1].dot(step))
    }
}

/// Projects scene points: built for one scene and one view.
pub trait VertexProjector: Sync {
    /// All paths that can be asked for; a path's parents are among them.
    fn paths(&self) -> &[SpecularPath];

    /// Appends all appearances of a scene point on one path (an index into [`Self::paths`]) to `found`: none to many.
    /// Never panics; points that are not finite appear nowhere. The same point always gives the same appearances.
    ///
    /// A point on a reflector does not appear in that reflector at itself. Where a reflector ends, appearances may
    /// continue a little beyond its border, so that drawing can be cut there exactly.
    fn project_on(&self, path: u32, point: Vec3, found: &mut Vec<Projection>);

    /// Appends at least the appearance of a scene point that `one`, an appearance of a point near it, continues into,
    /// if there is one; it may append others.
    fn follow(&self, one: &Projection, point: Vec3, found: &mut Vec<Projection>) {
        self.project_on(one.path, point, found);
    }

    /// Appends all appearances of a scene point to `found`, in the order of their paths.
    fn project(&self, point: Vec3, found: &mut Vec<Projection>) {
        for path in 0..self.paths().len() as u32 {
            self.project_on(path, point, found);
        }
    }
}
