//! Appearances at the nodes, blended.

use super::mean::{Mean, form_of, plain_form_of};
use super::sightings::{AroundEye, Lookout, Mirror, Node, REACH, Sightings};
use crate::find::node_sightings::{MOST_NODES, Sighting};
use crate::find::polish::{Effort, polished};
use crate::find::ray_map::Specular;
use crate::find::tetrahedron_form::{FormWeights, TetrahedronForm};
use crate::sample_based_camera::project::{CameraProjector, TOUCHING};
use crate::sample_based_camera::settings::Blend;
use catoptric_core::scene::{PreciseView, Scene, View};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::method::Report;
use catoptric_engine::method::projector::{Projection, Projections, SpecularPath, VertexProjector};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind, Eye};
use catoptric_engine::optics::path::manifold::SpecularSurfaces;
use glam::{DVec3, Mat3, Vec2, Vec3};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Steps of the solver where some node knows nothing: it starts from another's appearance. Chosen, not measured.
const STEPS_WHERE_AMBIGUOUS: u32 = 12;

/// Steps of the solver where the mean is not accurate. Chosen, not measured.
const STEPS_WHERE_ROUGH: u32 = 4;

/// Answers are one when they are nearer than this, in pixels. Chosen, not measured.
const SAME_PX: f32 = 0.5;

/// The numbers of a path at the nodes around the eye.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BlendedPath {
    /// The index of its first reflector among those with nodes.
    pub(super) reflector: usize,
    /// The path's number at each node.
    pub(super) in_nodes: Vec<u32>,
}

/// Numbers of points, since the projector was made.
#[derive(Debug, Default)]
pub(super) struct PointCounts {
    /// Points that were looked for at the nodes, as nothing was known of them.
    sought: AtomicU64,
    /// Appearances that some node does not know of, whatever is tried: the solver looks for them from the eye.
    ambiguous: AtomicU64,
    /// Appearances among these that the solver does not find.
    unsolved: AtomicU64,
}

/// A reflector with its nodes around the eye.
pub(in super::super) struct BlendedReflector<'a> {
    pub(super) nodes: Vec<Node<'a>>,
    /// Known appearances of points at these nodes.
    pub(super) known: &'a AroundEye,
}

/// Projects scene points by blending.
pub(in super::super) struct MorphProjector<'a> {
    pub(super) reflectors: Vec<BlendedReflector<'a>>,
    pub(super) paths: &'a [SpecularPath],
    /// The numbers at the nodes of the blended paths, which come first.
    pub(super) blended: &'a [BlendedPath],
    /// The cameras at the eye for the rest of the paths, and the numbers of these there.
    pub(super) cameras_at_eye: Option<CameraProjector<'a>>,
    pub(super) in_cameras_at_eye: &'a [u32],
    pub(super) left_out: &'a [SpecularPath],
    pub(super) eye: DVec3,
    pub(super) view: View,
    pub(super) precise_view: PreciseView,
    pub(super) scene: &'a Scene,
    pub(super) tracer: Arc<Tracer>,
    pub(super) surfaces: SpecularSurfaces<'a>,
    pub(super) order: u32,
    /// Steps of the solver after blending, or 0.
    pub(super) polish: u32,
    /// True if points that some nodes do not see are followed beyond these nodes' horizons and borders; else they are
    /// left out.
    pub(super) cures: bool,
    pub(super) blend: Blend,
    pub(super) counts: PointCounts,
}

impl VertexProjector for MorphProjector<'_> {
    fn paths(&self) -> &[SpecularPath] {
        self.paths
    }

    fn left_out(&self) -> &[SpecularPath] {
        self.left_out
    }

    /// Nodes that are not there, or disagree, take no work.
    fn left_out_for_work(&self) -> &[SpecularPath] {
        &[]
    }

    fn project_on(&self, path: u32, points: &[Vec3], found: &mut Projections) {
        if let Some((cameras, number)) = self.at_eye(path) {
            let near = |point, found: &mut Vec<Projection>| cameras.project_near(number, point, None, found);
            return found.extend(points, |point, found| renumbered(path, found, |found| near(point, found)));
        }
        found.extend(points, |point, found| self.project_point(path, point, found));
    }

    fn follow(&self, one: &Projection, point: Vec3, found: &mut Projections) {
        if !self.solves() {
            return self.project_on(one.path, &[point], found);
        }
        if let Some((cameras, number)) = self.at_eye(one.path) {
            let own = Projection { path: number, ..*one };
            let followed = |found: &mut Vec<Projection>| cameras.follow_point(&own, point, found);
            return found.extend(&[point], |_, found| renumbered(one.path, found, followed));
        }
        found.extend(&[point], |point, found| {
            let followed = match self.mirror_of(one.path) {
                Some(mirror) => self.followed(mirror, one, point),
                None => self.solved_from(one, point).map(Some),
            };
            match followed {
                Some(projection) => found.extend(projection),
                None => self.project_point(one.path, point, found),
            }
        });
    }

    fn add_fallbacks(&self, report: &mut Report) {
        report.counts.insert("points_sought_at_nodes", self.counts.sought.load(Ordering::Relaxed));
        report.add_fallback("ambiguous_points", self.counts.ambiguous.load(Ordering::Relaxed));
        report.add_fallback("ambiguous_points_unsolved", self.counts.unsolved.load(Ordering::Relaxed));
    }
}

/// An eye among the nodes, with its weights and view.
pub(super) struct Outlook<'a> {
    pub(super) eye: DVec3,
    /// The weights of the nodes.
    pub(super) weights: FormWeights,
    pub(super) view: &'a PreciseView,
}

/// The weights of nodes around the eye.
pub(super) fn weights_of(nodes: &[Node<'_>]) -> [f32; MOST_NODES] {
    std::array::from_fn(|index| nodes.get(index).map_or(0.0, |node| node.weight))
}

/// Finds appearances, and gives them the number of another path.
fn renumbered(path: u32, found: &mut Vec<Projection>, find: impl FnOnce(&mut Vec<Projection>)) {
    let start = found.len();
    find(found);
    found[start..].iter_mut().for_each(|projection| projection.path = path);
}

impl MorphProjector<'_> {
    /// True if a solver looks from the eye where nodes do not tell enough.
    pub(super) fn solves(&self) -> bool {
        self.cures && self.blend == Blend::Solved
    }

    /// An appearance that all nodes around the eye know of, while the eye moves among these.
    pub(super) fn form_of(&self, nodes: &[Vec3; MOST_NODES], at: &[Sighting]) -> TetrahedronForm {
        match self.blend {
            Blend::Solved => form_of(nodes, at),
            Blend::Mean => plain_form_of(at),
        }
    }

    /// The cameras at the eye, and a path's number there, if it is not blended.
    fn at_eye(&self, path: u32) -> Option<(&CameraProjector<'_>, u32)> {
        let index = (path as usize).checked_sub(self.blended.len())?;
        Some((self.cameras_at_eye.as_ref()?, *self.in_cameras_at_eye.get(index)?))
    }

    /// Appends the appearances of a point on a path.
    fn project_point(&self, path: u32, point: Vec3, found: &mut Vec<Projection>) {
        let Some(lookout) = self.lookout_on(path).filter(|_| point.is_finite()) else { return };
        let seen = self.sightings(path, &lookout, point);
        let start = found.len();
        for sightings in &*seen {
            let (Some(projection), _) = self.seen_from_eye(path, &lookout, sightings, point) else { continue };
            let is_same = |other: &Projection| {
                other.focal_index == projection.focal_index && other.image_px.distance(projection.image_px) < SAME_PX
            };
            if !found[start..].iter().any(is_same) {
                found.push(projection);
            }
        }
    }

    /// A point's appearances at the nodes around the eye.
    pub(super) fn sightings(&self, path: u32, lookout: &Lookout<'_>, point: Vec3) -> Arc<[Sightings]> {
        let look = || {
            self.counts.sought.fetch_add(1, Ordering::Relaxed);
            lookout.look(point)
        };
        let known = self.blended.get(path as usize).and_then(|blended| {
            // The path has one number at the first node, whatever others there are.
            Some((self.reflectors.get(blended.reflector)?.known, *blended.in_nodes.first()?))
        });
        match known {
            Some((known, path)) => known.points.get(path, point, look),
            None => look(),
        }
    }

    /// An appearance from the eye, if it is seen there, and whether it is blended: all nodes know of it.
    pub(super) fn seen_from_eye(
        &self,
        path: u32,
        lookout: &Lookout<'_>,
        sightings: &Sightings,
        point: Vec3,
    ) -> (Option<Projection>, bool) {
        let count = lookout.nodes.len();
        if sightings.at[..count].iter().all(Option::is_some) {
            let whole = sightings.at.map(Option::unwrap_or_default);
            return (self.blend(path, lookout, (sightings, &whole[..count]), point), true);
        }
        (self.settle(path, lookout, sightings, point), false)
    }

    /// The nodes that look for points on a path.
    pub(super) fn lookout_on(&self, path: u32) -> Option<Lookout<'_>> {
        let BlendedPath { reflector, in_nodes } = self.blended.get(path as usize)?;
        Some(self.lookout(path, &self.reflectors[*reflector].nodes, in_nodes))
    }

    fn lookout<'s>(&'s self, path: u32, nodes: &'s [Node<'s>], in_nodes: &'s [u32]) -> Lookout<'s> {
        let (scene, tracer, surfaces, order) = (self.scene, &*self.tracer, &self.surfaces, self.order);
        let specular = Specular { scene, tracer, surfaces, order };
        let (path, is_exact) = (&self.paths[path as usize], self.blend == Blend::Solved);
        Lookout { nodes, in_nodes, path, specular, cures: self.cures, is_exact }
    }

    /// The mirror of a path that has one only.
    fn mirror_of(&self, path: u32) -> Option<u32> {
        match self.paths.get(path as usize)?.bounces[..] {
            [Bounce { object, kind: BounceKind::Reflect }] => Some(object),
            _ => None,
        }
    }

    /// The continuation of an appearance at a point near its own, in a single mirror, exactly: that takes one
    /// reflection in place of one for each node, and is asked for points that no other view asks for. `Some(None)`
    /// beyond the horizon; `None` if the solver does not get there.
    fn followed(&self, mirror: u32, one: &Projection, point: Vec3) -> Option<Option<Projection>> {
        let medium = one.path_length / (one.reflection_point.distance(self.eye.as_vec3()) + one.last_segment);
        self.reflected(mirror, one, medium, point)
    }

    /// The appearance of a point in a single mirror near the reflection point of another appearance, of which it has
    /// the path and the focal index, by the solver; optical lengths are so many times as large as lengths. As
    /// [`Self::followed`].
    fn reflected(&self, mirror: u32, near: &Projection, medium: f32, point: Vec3) -> Option<Option<Projection>> {
        let lookout = self.lookout(near.path, &[], &[]);
        let eye = self.eye.as_vec3();
        let site = lookout.site(mirror, eye, (near.reflection_point - eye).normalize_or_zero())?;
        let reach = REACH * lookout.size(lookout.path.bounces.first());
        let exact = point.as_dvec3();
        let solver = Mirror { surfaces: &self.surfaces, object: mirror, point: exact, reach };
        let seen_from = |normal: DVec3, at: DVec3| normal.dot(self.eye - at) > 0.0;
        let side = seen_from(self.surfaces.frame(mirror, &site)?.normal, site.position);
        let found = solver.seen(self.eye, &site)?;
        if seen_from(found.normal, found.position) != side {
            return Some(None);
        }
        let last_segment = found.position.distance(exact) as f32;
        let path_length = medium * (found.position.distance(self.eye) as f32 + last_segment);
        let projection = Self::shown(&self.precise_view, found.position, found.change_with_point(), 0.0)?;
        let (path, focal_index) = (near.path, near.focal_index);
        Some(Projection { path, focal_index, path_length, last_segment, ..projection }.if_meaningful())
    }

    /// The continuation of an appearance on other paths, by the solver from the path of the point near it; `None` if
    /// that does not get there, or beyond a focal point.
    fn solved_from(&self, one: &Projection, point: Vec3) -> Option<Projection> {
        let lookout = self.lookout(one.path, &[], &[]);
        let effort = Effort { steps: STEPS_WHERE_AMBIGUOUS, reach: REACH, must_converge: true };
        let ray = (self.eye.as_vec3(), one.reflection_point);
        let found = self.solved(one.path, &lookout, ray, one.reflection_point.as_dvec3(), point, effort)?;
        (found.focal_index == one.focal_index).then_some(found)
    }

    /// A reflection point in the picture, with its change with the scene point, and its error; without the data of the
    /// path. `None` behind the eye.
    fn shown(view: &PreciseView, first: DVec3, change: Mat3, error: f32) -> Option<Projection> {
        let [x, y] = view.place_of(first)?;
        let gradients = view.place_change(first).map(DVec3::as_vec3);
        let across = change.transpose();
        Some(Projection {
            image_px: Vec2::new(x as f32, y as f32),
            image_change: gradients.map(|gradient| across * gradient),
            reflection_point: first.as_vec3(),
            error_px: error * gradients[0].length().max(gradients[1].length()),
            ..Projection::default()
        })
    }

    /// An appearance that some node does not know of, by the solver from the eye.
    fn settle(&self, path: u32, lookout: &Lookout<'_>, sightings: &Sightings, point: Vec3) -> Option<Projection> {
        if !self.solves() {
            return None;
        }
        self.counts.ambiguous.fetch_add(1, Ordering::Relaxed);
        let effort = Effort { steps: STEPS_WHERE_AMBIGUOUS, reach: REACH, must_converge: true };
        let mut known = lookout.nodes.iter().zip(&sightings.at).filter_map(|(node, at)| Some((node, at.as_ref()?)));
        let solved = known.find_map(|(node, at)| {
            let way = (self.eye - node.eye().as_dvec3()).as_vec3();
            let expected = at.first + at.change_with_eye.map_or(Vec3::ZERO, |change| change * way);
            self.solved(path, lookout, (node.eye(), at.first), expected.as_dvec3(), point, effort)
        });
        if solved.is_none() {
            self.counts.unsolved.fetch_add(1, Ordering::Relaxed);
        }
        solved
    }

    /// The mean of the appearances at all nodes of a reflector; `None` where it is beyond the eye's horizon.
    pub(super) fn mean(
        (path, focal_index): (u32, u32),
        outlook: &Outlook<'_>,
        form: &TetrahedronForm,
        at: &[Sighting],
    ) -> Option<Projection> {
        let Mean { first, change, normal, length, last_segment, error } = Mean::of(form, &outlook.weights, at);
        if normal.as_dvec3().dot(outlook.eye - first) <= 0.0 {
            return None;
        }
        let projection = Self::shown(outlook.view, first, change, error)?;
        Projection { path, focal_index, path_length: length, last_segment, ..projection }.if_meaningful()
    }

    /// The blend of the sightings as seen from the eye, made exact if that is wanted, or where it is not accurate.
    fn blend(
        &self,
        path: u32,
        lookout: &Lookout<'_>,
        (sightings, at): (&Sightings, &[Sighting]),
        point: Vec3,
    ) -> Option<Projection> {
        let weights = FormWeights::new(weights_of(lookout.nodes));
        let outlook = Outlook { eye: self.eye, weights, view: &self.precise_view };
        let form = self.form_of(&lookout.eyes(), at);
        let projection = Self::mean((path, sightings.focal_index), &outlook, &form, at)?;
        if sightings.is_rough
            && self.solves()
            && self.polish == 0
            && let Some((mirror, (node, seen))) = self.mirror_of(path).zip(lookout.nodes.first().zip(at.first()))
        {
            // Light stays in one medium.
            let medium = seen.length / (seen.first.distance(node.eye()) + seen.last_segment);
            if let Some(Some(exact)) = self.reflected(mirror, &projection, medium, point) {
                return Some(exact);
            }
        }
        let steps = if sightings.is_rough && self.solves() { self.polish.max(STEPS_WHERE_ROUGH) } else { self.polish };
        if steps == 0 {
            return Some(projection);
        }
        let effort = Effort { steps, reach: REACH, must_converge: false };
        let (nodes, first) = (lookout.nodes, form.at(&weights).0);
        let mut by_weight: [usize; MOST_NODES] = std::array::from_fn(|node| node);
        by_weight[..nodes.len()].sort_by(|&a, &b| nodes[b].weight.total_cmp(&nodes[a].weight));
        let heaviest_first = by_weight[..nodes.len()].iter().map(|&node| (nodes[node].eye(), at[node].first));
        // The eye's own ray is nearest to the path; where the mean is just beyond the eye's horizon, nodes have one.
        let mut rays = std::iter::once((self.eye.as_vec3(), first.as_vec3())).chain(heaviest_first);
        let solved = rays.find_map(|ray| self.solved(path, lookout, ray, first, point, effort));
        solved.or(Some(projection))
    }

    /// The appearance of a point near a place on the first reflector by the solver, which starts from the ray from a
    /// node or the eye towards a place; `None` where it finds none.
    fn solved(
        &self,
        path: u32,
        lookout: &Lookout<'_>,
        (from, towards): (Vec3, Vec3),
        near: DVec3,
        point: Vec3,
        effort: Effort,
    ) -> Option<Projection> {
        let sample = lookout.sample(from, (towards - from).normalize_or_zero())?;
        let start = sample.sites_at(&self.surfaces, sample.parameters_of(near))?;
        let (eye, exact) = (Eye::Point(self.eye), point.as_dvec3());
        let effort = Effort { reach: effort.reach * lookout.size(lookout.path.bounces.first()), ..effort };
        let found = polished(&self.surfaces, &eye, &start, &sample.outside, exact, effort)?;
        if found.last.distance(exact) < TOUCHING * lookout.size(lookout.path.bounces.last()) {
            return None;
        }
        let length = sample.optical_length_along(&eye, &found.sites, exact);
        let projection = found.projection(path, &self.precise_view, length, exact)?;
        // Cameras count the focal points of the last segment alone.
        let before = if self.polish == 0 { sample.focal_points_passed } else { 0 };
        Some(Projection { focal_index: projection.focal_index.saturating_sub(before), ..projection })
    }
}
