//! Appearances of scene points from virtual objects, polished where that is asked for.

use super::levels::{Appearance, Levels, Locator, Recursion, Step};
use super::mesh::ReflectorMesh;
use crate::methods::projection::polish::{Effort, polished};
use crate::methods::projection::{MAX_BOUNCES, Projection, SpecularPath, VertexProjector};
use crate::optics::bundle::{Bounce, BounceKind, Eye};
use crate::optics::specular_solver::PathSites;
use crate::scene::{PictureTransform, PreciseView};
use crate::surface::site::{Site, SpecularSurfaces};
use glam::{DVec2, Vec3};

/// Beyond its end as it is seen a reflector shows points this far, in shares of its size: there drawing is cut.
const BEYOND: f32 = 0.1;

/// Reflectors that may hide a part of themselves show points no further beside their parts than this, in pixels.
const BESIDE_PX: f32 = 4.0;

/// Two appearances on one sheet nearer than this, in pixels, are one: neighbouring cells both know it.
const SAME_PX: f32 = 0.75;

/// Less sure ones are one as far from each other as they may be off, and this at the most.
const MOST_UNSURE_PX: f32 = 4.0;

/// The same for polished ones.
const SAME_POLISHED_PX: f32 = 0.3;

/// Polished places are no further from where they start than this share of the reflector's size: what is further away has
/// starts of its own.
const REACH: f32 = 0.3;

/// The solver finds paths that are there in so many steps, from virtual points: what it has not found by then is none.
const SURE_STEPS: u32 = 5;

/// Another part of the reflector hides a point of it when it is nearer by more than this share of its size.
const HIDING: f32 = 0.06;

/// Points nearer to their last bounce than this share of the reflector's size lie on it.
const TOUCHING: f32 = 2e-4;

/// How appearances are made of virtual points.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Options {
    /// Steps of the solver; 0 for none.
    pub(in super::super) polish: u32,
    pub(in super::super) recursion: Recursion,
}

/// Projects scene points by the levels of one view.
pub(in super::super) struct VirtualObjects<'a, L> {
    pub(in super::super) levels: &'a Levels<L>,
    pub(in super::super) meshes: &'a [ReflectorMesh],
    pub(in super::super) surfaces: SpecularSurfaces<'a>,
    pub(in super::super) eye: Eye,
    pub(in super::super) picture: PictureTransform,
    pub(in super::super) view: PreciseView,
    pub(in super::super) options: Options,
}

impl<L: Locator> VertexProjector for VirtualObjects<'_, L> {
    fn paths(&self) -> &[SpecularPath] {
        &self.levels.paths
    }

    fn project_on(&self, path: u32, point: Vec3, found: &mut Vec<Projection>) {
        if !point.is_finite() {
            return;
        }
        let start = found.len();
        self.levels.appearances(self.meshes, path, point, self.options.recursion, &mut |appearance| {
            let Some(projection) = self.projection(path, appearance, point) else { return };
            let same_px = if self.options.polish > 0 { SAME_POLISHED_PX } else { SAME_PX };
            let same = |other: &Projection| {
                // At caustics the rays of neighbouring triangles cross where those of the surface do not yet.
                let same_px = same_px.max((other.error_px + projection.error_px).min(MOST_UNSURE_PX));
                other.focal_index == projection.focal_index && other.image_px.distance(projection.image_px) < same_px
            };
            if !found[start..].iter().any(same) {
                found.push(projection);
            }
        });
    }
}

impl<L: Locator> VirtualObjects<'_, L> {
    /// An appearance in the picture; none where it is hidden or too far beyond where its reflectors end.
    fn projection(&self, path: u32, appearance: &Appearance<'_>, point: Vec3) -> Option<Projection> {
        let (last, first) = (appearance.steps.first()?, appearance.steps.last()?);
        let last_segment = last.foot.position.distance(point);
        if last_segment < TOUCHING * self.meshes[last.mesh as usize].radius {
            return None;
        }
        let mut beyond = false;
        let mut seen = point;
        for step in appearance.steps {
            let foot = &step.foot;
            beyond |= foot.beyond;
            // The virtual point lies on the ray to the foot, but beyond where the reflector ends.
            if step.bounce.kind == BounceKind::Reflect {
                let aside = foot.normal.dot(seen - foot.position);
                if aside < 0.0
                    && -aside > BEYOND * self.meshes[step.mesh as usize].radius.max(seen.distance(foot.position))
                {
                    return None;
                }
                seen -= foot.normal * (2.0 * aside);
            }
        }
        let place = self.picture.apply(first.foot.position);
        let foot_px = place.xy / place.w;
        if !(place.depth > 0.0 && foot_px.is_finite()) {
            return None;
        }
        if let Some(image) = self.levels.image_of(first.mesh) {
            let mesh = &self.meshes[first.mesh as usize];
            if image.hides(mesh, foot_px, first.foot.position, HIDING * mesh.radius) {
                return None;
            }
        }
        let (image_px, gradients) = self.picture.pixel_with_change(appearance.seen)?;
        // Beside one part of a reflector another may be.
        if beyond && !self.meshes[first.mesh as usize].convex && image_px.distance(foot_px) > BESIDE_PX {
            return None;
        }
        let depth = self.picture.apply(appearance.seen).depth;
        if depth.is_nan() || depth <= 0.0 {
            return None;
        }
        let path_length = match self.eye {
            Eye::Point(eye) => first.foot.position.distance(eye.as_vec3()),
            Eye::Direction(_) => place.depth,
        } + appearance.length;
        let turned = appearance.change.transpose();
        let projection = Projection {
            path,
            focal_index: appearance.focal_index,
            image_px,
            image_change: gradients.map(|gradient| turned * gradient),
            path_length,
            reflection_point: first.foot.position,
            last_segment,
            error_px: appearance.error * gradients[0].length().max(gradients[1].length()),
        };
        match self.options.polish {
            0 => projection.if_meaningful(),
            // Also from beyond the silhouette, as far as starts are off: there is a path or none.
            _ => self.polished(path, appearance, point),
        }
    }

    /// The appearance made exact by the solver; none where that finds no path.
    fn polished(&self, path: u32, appearance: &Appearance<'_>, point: Vec3) -> Option<Projection> {
        let count = appearance.steps.len();
        let mut bounces = [(Bounce { object: 0, kind: BounceKind::Reflect }, Site::default()); MAX_BOUNCES];
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

    /// The site of the surface at a foot.
    fn site(&self, step: &Step) -> Option<Site> {
        let (mesh, foot) = (self.levels.mesh_of(self.meshes, step), &step.foot);
        let object = mesh.object;
        if self.surfaces.is_formula(object) {
            return Some(self.surfaces.landed(object, &Site::on_surface(foot.position.as_dvec3()))?.0);
        }
        let site = mesh.site(foot.triangle, foot.weights);
        // The foot may lie in another triangle, a walk away.
        let [right, up] = self.surfaces.frame(object, &site)?.tangents;
        let step = foot.position.as_dvec3() - site.position;
        self.surfaces.moved(object, &site, DVec2::new(step.dot(right), step.dot(up))).or(Some(site))
    }
}
