//! Appearances of scene points from virtual objects, polished where that is asked for.

use super::descent::{Appearance, Descent, DescentScratch, PathStep, Recursion};
use super::locator::Locator;
use super::mesh::ReflectorMesh;
use super::path_tree::PathTree;
use crate::find::polish::{Effort, polished};
use catoptric_core::scene::{PictureTransform, PreciseView};
use catoptric_engine::method::Report;
use catoptric_engine::method::projector::{MAX_BOUNCES, Projection, Projections, SpecularPath, VertexProjector};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind, Eye};
use catoptric_engine::optics::path::manifold::{ManifoldVertex, SpecularSurfaces};
use catoptric_engine::optics::path::specular_solver::PathSites;
use glam::{DVec2, Vec3};
use std::cell::Cell;

/// Beyond its silhouette or border a reflector shows points that lie behind the tangent plane by up to this share of
/// its size, or of their distance: drawing is cut there. Chosen, not measured.
const BEYOND: f32 = 0.1;

/// Reflectors that may hide a part of themselves show points no further beside their parts than this, in pixels.
/// Chosen, not measured.
const BESIDE_PX: f32 = 4.0;

/// Two appearances on one sheet nearer than this, in pixels, are one: neighbouring cells both hold it. Chosen, not
/// measured.
const SAME_PX: f32 = 0.75;

/// The greatest distance, in pixels, of two appearances on one sheet that count as one because of their error bounds.
/// Chosen, not measured.
const MAX_UNSURE_PX: f32 = 4.0;

/// Like [`SAME_PX`], for polished appearances. Chosen, not measured.
const SAME_POLISHED_PX: f32 = 0.3;

/// The greatest distance of a polished place from its start, as a share of the reflector's size: places further away
/// have starts of their own. Chosen, not measured.
const REACH: f32 = 0.3;

/// The number of steps within which the solver finds an existing path from a virtual point: if it has not by then,
/// there is none. Chosen, not measured.
const SURE_STEPS: u32 = 5;

/// Another part of the reflector hides a point of it when it is nearer by more than this share of its size. Chosen, not
/// measured.
const HIDING: f32 = 0.06;

/// Points nearer to their last bounce than this share of the reflector's size lie on it. Chosen, not measured.
const TOUCHING: f32 = 2e-4;

/// Points whose reflection points are found at once. A size for caches; chosen, not measured.
const POINTS_AT_ONCE: usize = 256;

thread_local! {
    /// Scratch space, kept from batch to batch.
    static SCRATCH: Cell<DescentScratch> = Cell::default();
}

/// Options of appearances from virtual points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Options {
    /// Steps of the solver; 0 for none.
    pub(crate) polish: u32,
    pub(crate) recursion: Recursion,
}

/// Projects scene points by the levels of one view.
pub(crate) struct VirtualObjects<'a, L> {
    pub(crate) tree: &'a PathTree<L>,
    pub(crate) meshes: &'a [ReflectorMesh],
    pub(crate) surfaces: SpecularSurfaces<'a>,
    pub(crate) eye: Eye,
    pub(crate) picture: PictureTransform,
    pub(crate) view: PreciseView,
    pub(crate) options: Options,
}

impl<L: Locator> VertexProjector for VirtualObjects<'_, L> {
    fn paths(&self) -> &[SpecularPath] {
        &self.tree.paths
    }

    fn project_on(&self, path: u32, points: &[Vec3], found: &mut Projections) {
        let Self { tree, meshes, options: Options { recursion, .. }, .. } = *self;
        let descent = Descent { tree, meshes, recursion };
        let mut scratch = SCRATCH.take();
        for points in points.chunks(POINTS_AT_ONCE) {
            descent.locate(path, points, &mut scratch);
            let mut numbers = 0..;
            found.extend(points, |point, found| {
                let start = found.len();
                let one = (numbers.next().unwrap_or_default(), point);
                descent.appearances(path, one, &mut scratch, &mut |appearance| {
                    self.add_appearance(path, appearance, point, start, found);
                });
            });
        }
        SCRATCH.set(scratch);
    }

    fn left_out(&self) -> &[SpecularPath] {
        &self.tree.left_out
    }

    fn add_fallbacks(&self, report: &mut Report) {
        for ray_set in self.tree.levels.iter().flat_map(|level| &level.ray_sets) {
            ray_set.locator.add_fallbacks(report);
        }
    }
}

impl<L: Locator> VirtualObjects<'_, L> {
    /// Appends an appearance of a point unless it is one of those that the point has already, from `start` on.
    fn add_appearance(
        &self,
        path: u32,
        appearance: &Appearance<'_>,
        point: Vec3,
        start: usize,
        found: &mut Vec<Projection>,
    ) {
        let Some(projection) = self.projection(path, appearance, point) else { return };
        let same_px = if self.options.polish > 0 { SAME_POLISHED_PX } else { SAME_PX };
        let same = |other: &Projection| {
            // At caustics the rays of neighbouring triangles cross where those of the surface do not yet.
            let same_px = same_px.max((other.error_px + projection.error_px).min(MAX_UNSURE_PX));
            other.focal_index == projection.focal_index && other.image_px.distance(projection.image_px) < same_px
        };
        if !found[start..].iter().any(same) {
            found.push(projection);
        }
    }

    /// An appearance in the picture; returns `None` if it is hidden or too far beyond where its reflectors end.
    fn projection(&self, path: u32, appearance: &Appearance<'_>, point: Vec3) -> Option<Projection> {
        let (last, first) = (appearance.steps.first()?, appearance.steps.last()?);
        let last_segment = last.reflection_point.position.distance(point);
        if last_segment < TOUCHING * self.meshes[last.mesh as usize].radius {
            return None;
        }
        let mut beyond = false;
        let mut seen = point;
        for step in appearance.steps {
            let reflection_point = &step.reflection_point;
            beyond |= reflection_point.beyond;
            // The virtual point lies on the ray to the reflection point, but beyond where the reflector ends.
            if step.bounce.kind == BounceKind::Reflect {
                let aside = reflection_point.normal.dot(seen - reflection_point.position);
                if aside < 0.0
                    && -aside
                        > BEYOND * self.meshes[step.mesh as usize].radius.max(seen.distance(reflection_point.position))
                {
                    return None;
                }
                let mirrored = seen - reflection_point.normal * (2.0 * aside);
                seen = reflection_point.blended_image.map_or(mirrored, |(image, _)| image);
            }
        }
        let place = self.picture.apply(first.reflection_point.position);
        let reflection_px = place.xy / place.w;
        if !(place.depth > 0.0 && reflection_px.is_finite()) {
            return None;
        }
        if let Some(image) = self.tree.image_of(first.mesh) {
            let mesh = &self.meshes[first.mesh as usize];
            if image.hides(mesh, reflection_px, first.reflection_point.position, HIDING * mesh.radius) {
                return None;
            }
        }
        let (image_px, gradients) = self.picture.pixel_with_change(appearance.seen)?;
        // Beside one part of a reflector another may be.
        if beyond && !self.meshes[first.mesh as usize].convex && image_px.distance(reflection_px) > BESIDE_PX {
            return None;
        }
        let depth = self.picture.apply(appearance.seen).depth;
        if depth.is_nan() || depth <= 0.0 {
            return None;
        }
        let path_length = match self.eye {
            Eye::Point(eye) => first.reflection_point.position.distance(eye.as_vec3()),
            Eye::Direction(_) => place.depth,
        } + appearance.length;
        let turned = appearance.change.transpose();
        let projection = Projection {
            path,
            focal_index: appearance.focal_index,
            image_px,
            image_change: gradients.map(|gradient| turned * gradient),
            path_length,
            reflection_point: first.reflection_point.position,
            last_segment,
            error_px: appearance.error * gradients[0].length().max(gradients[1].length()),
        };
        match self.options.polish {
            0 => projection.if_meaningful(),
            // Starts beyond the silhouette are polished, too, as far as they may be off: there is a path or none.
            _ => self.polished(path, appearance, point),
        }
    }

    /// The appearance made exact by the solver; returns `None` if that finds no path.
    fn polished(&self, path: u32, appearance: &Appearance<'_>, point: Vec3) -> Option<Projection> {
        let count = appearance.steps.len();
        let mut bounces = [(Bounce { object: 0, kind: BounceKind::Reflect }, ManifoldVertex::default()); MAX_BOUNCES];
        let mut outside = [false; MAX_BOUNCES];
        for (k, step) in appearance.steps.iter().rev().enumerate() {
            bounces[k] = (step.bounce, self.site(step)?);
            outside[k] = step.outside;
        }
        let start = PathSites::new(&bounces[..count])?;
        let reach = f64::from(REACH * self.meshes[appearance.steps[count - 1].mesh as usize].radius);
        let effort = Effort { steps: self.options.polish, reach, must_converge: self.options.polish >= SURE_STEPS };
        let exact = point.as_dvec3();
        let found = polished(&self.surfaces, &self.eye, &start, &outside[..count], exact, effort)?;
        let (sites, last) = (&found.sites, appearance.steps.first()?);
        let first = sites.sites[0].position;
        let mut length = match self.eye {
            Eye::Point(eye) => first.distance(eye),
            Eye::Direction(_) => self.view.depth_of(first),
        };
        for k in 1..count {
            let index = f64::from(appearance.steps[count - k].index_after);
            length += index * sites.sites[k].position.distance(sites.sites[k - 1].position);
        }
        length += f64::from(last.index_after) * found.last.distance(exact);
        found.projection(path, &self.view, length, exact)
    }

    /// The site of the surface at a reflection point.
    fn site(&self, step: &PathStep) -> Option<ManifoldVertex> {
        let (mesh, reflection_point) = (self.tree.mesh_of(self.meshes, step), &step.reflection_point);
        let object = mesh.object;
        if self.surfaces.is_formula(object) {
            return Some(
                self.surfaces.landed(object, &ManifoldVertex::on_surface(reflection_point.position.as_dvec3()))?.0,
            );
        }
        let site = mesh.site(reflection_point.triangle, reflection_point.weights);
        // The reflection point may lie in another triangle, a walk away.
        let [right, up] = self.surfaces.frame(object, &site)?.tangents;
        let step = reflection_point.position.as_dvec3() - site.position;
        self.surfaces.moved(object, &site, DVec2::new(step.dot(right), step.dot(up))).or(Some(site))
    }
}
