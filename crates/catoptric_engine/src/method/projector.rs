//! Appearances of scene points: the answers of every method that projects points.

use crate::method::Report;
use crate::optics::path::bundle::{Bounce, BounceKind};
use crate::raster::BlockMask;
use catoptric_core::scene::Scene;
use glam::{Vec2, Vec3};
use std::collections::BTreeSet;

pub use crate::optics::path::specular_solver::MAX_BOUNCES;

/// A sequence of bounces, counted from the eye. A path and its focal index make a reflection group.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SpecularPath {
    /// The bounces, from the eye on.
    pub bounces: Vec<Bounce>,
}

impl SpecularPath {
    /// The letters of its kinds: `R` or `T`, from the eye on.
    pub fn kinds(&self) -> String {
        self.bounces.iter().map(|bounce| bounce.kind.letter()).collect()
    }

    /// The names of its objects from the eye on, joined by `>`; one in a name is `\>`, a backslash is two.
    pub fn names(&self, scene: &Scene) -> String {
        let name = |bounce: &Bounce| Self::name_in_paths(&scene.objects[bounce.object as usize].name);
        self.bounces.iter().map(name).collect::<Vec<_>>().join(">")
    }

    /// A name as it stands in those of paths.
    pub fn name_in_paths(name: &str) -> String {
        name.replace('\\', "\\\\").replace('>', "\\>")
    }

    /// The path without its last bounce; returns `None` if it has one bounce.
    pub fn parent(&self) -> Option<Self> {
        let (_, rest) = self.bounces.split_last()?;
        (!rest.is_empty()).then(|| Self { bounces: rest.to_vec() })
    }

    /// True if any bounce passes through a surface.
    pub fn transmits(&self) -> bool {
        self.bounces.iter().any(|bounce| bounce.kind == BounceKind::Transmit)
    }
}

/// The place where a path goes on: the bounces before its last one, and the object of that. At a lens it holds for both
/// of its paths.
pub type PathBeginning = (Vec<Bounce>, u32);

/// Beginnings of paths: whatever goes on from one of them is meant, too.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PathBeginnings {
    places: BTreeSet<PathBeginning>,
}

impl PathBeginnings {
    /// The beginning of a path; returns `None` if it has no bounce.
    pub fn of(path: &SpecularPath) -> Option<PathBeginning> {
        let (last, before) = path.bounces.split_last()?;
        Some((before.to_vec(), last.object))
    }

    /// Adds one.
    pub fn add(&mut self, beginning: PathBeginning) {
        self.places.insert(beginning);
    }

    /// Adds several.
    pub fn extend(&mut self, beginnings: impl IntoIterator<Item = PathBeginning>) {
        self.places.extend(beginnings);
    }

    /// Keeps those that pass a filter.
    pub fn retain(&mut self, wanted: impl FnMut(&PathBeginning) -> bool) {
        self.places.retain(wanted);
    }

    /// Returns true if it is one of them.
    pub fn contains(&self, beginning: &PathBeginning) -> bool {
        self.places.contains(beginning)
    }

    /// Returns true if a path goes on from one of them, or is one.
    pub fn hold(&self, path: &SpecularPath) -> bool {
        let bounces = &path.bounces;
        let begins = |length: usize| self.places.contains(&(bounces[..length].to_vec(), bounces[length].object));
        !self.places.is_empty() && (0..bounces.len()).any(begins)
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = &PathBeginning> {
        self.places.iter()
    }

    /// Their number.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Returns true if there are none.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }
}

/// One appearance of a scene point: its virtual vertex and how that moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Projection {
    /// Index of the path in [`VertexProjector::paths`].
    pub path: u32,
    /// Focal points that the path has passed, summed over its segments.
    pub focal_index: u32,
    /// The appearance's place in the picture, in pixels from the top left corner.
    pub image_px: Vec2,
    /// The change of `image_px.x` and of `image_px.y` with the scene point: pixels a scene unit.
    pub image_change: [Vec3; 2],
    /// Optical length (within glass times its index of refraction) from the eye's plane (orthographic) or the eye to
    /// the scene point along the path, in scene units.
    pub path_length: f32,
    /// The first reflection point, counted from the eye.
    pub reflection_point: Vec3,
    /// Length of the path's last segment, from the last bounce to the scene point, in scene units.
    pub last_segment: f32,
    /// Estimated error in pixels; 0 where a solver has converged.
    pub error_px: f32,
}

impl Projection {
    /// Itself; returns `None` if any of its numbers is not finite or the length not positive.
    #[inline]
    pub fn if_meaningful(self) -> Option<Self> {
        let meaningful = self.image_px.is_finite()
            && self.image_change.iter().all(|change| change.is_finite())
            && self.path_length.is_finite()
            && self.path_length > 0.0;
        meaningful.then_some(self)
    }

    /// The expected place in the picture of a point `step` (world space) away, to first order, in pixels.
    #[inline]
    pub fn predicted(&self, step: Vec3) -> Vec2 {
        self.image_px + Vec2::new(self.image_change[0].dot(step), self.image_change[1].dot(step))
    }
}

/// The appearances of a batch of scene points.
pub type Projections = PerPoint<Projection>;

/// Results of a batch of scene points, none to many each, in the order of the points.
#[derive(Clone, Debug, PartialEq)]
pub struct PerPoint<T> {
    all: Vec<T>,
    /// For each point the end of its results in `all`.
    ends: Vec<usize>,
}

impl<T> Default for PerPoint<T> {
    fn default() -> Self {
        Self { all: Vec::new(), ends: Vec::new() }
    }
}

impl<T> PerPoint<T> {
    /// Removes all points.
    pub fn clear(&mut self) {
        self.all.clear();
        self.ends.clear();
    }

    /// The number of points.
    pub fn point_count(&self) -> usize {
        self.ends.len()
    }

    /// The results of a point; empty for a point that is not in the batch.
    pub fn of(&self, point: usize) -> &[T] {
        let start = point.checked_sub(1).map_or(Some(0), |before| self.ends.get(before).copied());
        let range = start.zip(self.ends.get(point).copied());
        range.map_or(&[], |(start, end)| &self.all[start..end])
    }

    /// The results of all points.
    pub fn all(&self) -> &[T] {
        &self.all
    }

    /// Removes results of the points from `first` on.
    pub fn retain_from(&mut self, first: usize, is_kept: impl Fn(&T) -> bool)
    where
        T: Copy,
    {
        let mut start = first.checked_sub(1).map_or(0, |before| self.ends[before]);
        let mut count = start;
        for end in &mut self.ends[first..] {
            for index in start..*end {
                if is_kept(&self.all[index]) {
                    self.all[count] = self.all[index];
                    count += 1;
                }
            }
            start = *end;
            *end = count;
        }
        self.all.truncate(count);
    }

    /// Leaves no more than `most` results for each of the points from `first` on, those with the largest `rank`, and
    /// returns how many are removed.
    pub fn keep_largest_from(&mut self, first: usize, most: usize, rank: impl Fn(&T) -> f32) -> usize
    where
        T: Copy,
    {
        let start = first.checked_sub(1).map_or(0, |before| self.ends[before]);
        let mut is_kept = Vec::new();
        let mut from = start;
        for &end in &self.ends[first..] {
            let results = &self.all[from..end];
            let mut order: Vec<usize> = (0..results.len()).collect();
            if results.len() > most {
                order.sort_by(|a, b| rank(&results[*b]).total_cmp(&rank(&results[*a])).then(a.cmp(b)));
                order.truncate(most);
            }
            let kept_before = is_kept.len();
            is_kept.resize(kept_before + results.len(), false);
            order.into_iter().for_each(|index| is_kept[kept_before + index] = true);
            from = end;
        }
        let removed = is_kept.iter().filter(|kept| !**kept).count();
        if removed > 0 {
            let index = std::cell::Cell::new(0);
            self.retain_from(first, |_| is_kept[index.replace(index.get() + 1)]);
        }
        removed
    }

    /// Appends points; `append` adds the results of one to its second argument.
    pub fn extend(&mut self, points: &[Vec3], mut append: impl FnMut(Vec3, &mut Vec<T>)) {
        for point in points {
            append(*point, &mut self.all);
            self.ends.push(self.all.len());
        }
    }
}

/// Projects scene points: built for one scene and one view.
pub trait VertexProjector: Sync {
    /// All paths that points can be projected on; a path's parents are among them.
    fn paths(&self) -> &[SpecularPath];

    /// Appends a batch of scene points with all their appearances on one path (an index into [`Self::paths`]): none to
    /// many each. Never panics; points that are not finite appear nowhere. The same point always has the same
    /// appearances, whatever the batch.
    ///
    /// A point on a reflector does not appear in that reflector at itself. Where a reflector ends, appearances may
    /// continue a little beyond its border, so that drawing can be cut there exactly.
    fn project_on(&self, path: u32, points: &[Vec3], found: &mut Projections);

    /// As [`Self::project_on`], but for appearances whose last segments are shorter than `least_segment`: those of a
    /// reflector's own points where they touch it. Some of these may be among the appearances, too.
    fn project_beyond(&self, path: u32, least_segment: f32, points: &[Vec3], found: &mut Projections) {
        let _ = least_segment;
        self.project_on(path, points, found);
    }

    /// False if no point of a ball appears on a path, as far as it is looked for.
    fn may_show(&self, path: u32, center: Vec3, radius: f32) -> bool {
        let _ = (path, center, radius);
        true
    }

    /// Blocks of the picture where appearances on a path are not looked for, if there are any: something else draws
    /// them.
    fn holes(&self, path: u32) -> Option<&BlockMask> {
        let _ = path;
        None
    }

    /// Appends `point` with at least the appearance that `one`, an appearance of a point near it, continues into, if
    /// there is one; others may be among them.
    fn follow(&self, one: &Projection, point: Vec3, found: &mut Projections) {
        self.project_on(one.path, &[point], found);
    }

    /// Paths that points might be projected on, but that are not among [`Self::paths`], because there is too much to do
    /// for them, without longer ones that start with them. What is said of one path of a lens holds for both.
    fn left_out(&self) -> &[SpecularPath] {
        &[]
    }

    /// The left out paths that another view, or more work, may have.
    fn left_out_for_work(&self) -> &[SpecularPath] {
        self.left_out()
    }

    /// Adds the counts of searches that were cut short by a limit, since the data of the view were built.
    fn add_fallbacks(&self, _report: &mut Report) {}

    /// Appends a batch of scene points with all their appearances, those of a point in the order of their paths.
    fn project(&self, points: &[Vec3], found: &mut Projections) {
        let mut on_path = Projections::default();
        found.extend(points, |point, all| {
            on_path.clear();
            for path in 0..self.paths().len() as u32 {
                self.project_on(path, &[point], &mut on_path);
            }
            all.extend_from_slice(on_path.all());
        });
    }
}
