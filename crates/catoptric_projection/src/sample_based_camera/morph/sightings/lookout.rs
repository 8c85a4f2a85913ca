//! Appearances of a point at all nodes around the eye, matched between the nodes.

use super::cache::PointCache;
use super::walk::{Mirror, Reflection, expected_move};
use crate::find::node_sightings::{MOST_NODES, NodeSightings, Sighting};
use crate::find::ray_map::{RaySample, Specular, follow};
use crate::find::work;
use crate::sample_based_camera::morph::places::Carried;
use crate::sample_based_camera::panorama::{PanoramicProjection, PanoramicProjector};
use catoptric_core::scene::Ray;
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind, Eye};
use catoptric_engine::optics::path::manifold::ManifoldVertex;
use glam::Vec3;
use std::cell::RefCell;
use std::sync::Arc;

/// Work of following a ray to a bounce.
const WORK_A_RAY: u64 = 10;

/// The solver may move a first reflection point by this share of the reflector's size. Chosen, not measured.
pub(in super::super) const REACH: f64 = 0.25;

/// Appearances at two nodes whose reflection points are farther than this from where the derivatives of both expect
/// them are not one: a share of the reflector's size, and of the way between them, which near a horizon changes fast.
/// Chosen, not measured.
const MISMATCH: f32 = 0.02;
const MISMATCH_OF_WAY: f32 = 0.35;

/// The greatest misfit at which the mean counts as accurate, as a share of the reflector's size: the mean is off by
/// about a seventh of it, which is more than half a pixel where a mirror fills a picture. Chosen, not measured.
const ROUGH: f32 = 0.005;

/// Like [`ROUGH`], where a point appears several times, or beyond a focal point: the ends of appearances, where two of
/// them merge, are found exactly, and errors leave gaps before these. Chosen by `dish`, which has none then.
const ROUGH_BESIDE_FOLDS: f32 = 0.001;

/// A ray that is to meet a mirror in any case leads so far below its surface, as a share of its size. Chosen, not
/// measured.
const DEEPER: f64 = 0.01;

/// An appearance at several nodes.
#[derive(Clone, Copy, Debug)]
pub struct Sightings {
    /// The number of focal points that light passes.
    pub focal_index: u32,
    /// The sighting at each node; `None` at nodes that have none.
    pub at: [Option<Sighting>; MOST_NODES],
    /// The mean of these is not accurate: as beside folds, where appearances move as roots.
    pub is_rough: bool,
}

/// An appearance that all nodes know of.
pub(in super::super) fn known(one: &Sightings) -> Option<NodeSightings> {
    let seen = NodeSightings { focal_index: one.focal_index, at: one.at.map(Option::unwrap_or_default) };
    one.at.iter().all(Option::is_some).then_some(seen)
}

/// The only appearance of a point, if all nodes know of it and their mean is accurate.
pub(in super::super) fn known_once(found: &[Sightings]) -> Option<NodeSightings> {
    match found {
        [one] if !one.is_rough => known(one),
        _ => None,
    }
}

/// A node around the eye.
pub(in super::super) struct Node<'a> {
    pub(in super::super) weight: f32,
    pub(in super::super) projector: PanoramicProjector<'a>,
    /// The node's motion with its reflector since it was built.
    pub(in super::super) carried: Option<Carried>,
    /// Known appearances of points at the node.
    pub(in super::super) answers: &'a PointCache<NodeAnswer>,
}

/// An appearance at a node, as its cameras see it and as it is.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct NodeAnswer {
    focal_index: u32,
    /// Values as the cameras have them.
    reflection_point: Vec3,
    direction: Vec3,
    normal: Vec3,
    /// Optical length of a unit before the first bounce, if there is one only.
    medium: f32,
    /// Exact in a single mirror, where its change with the eye is known.
    sighting: Sighting,
}

impl Node<'_> {
    /// The position of the node.
    pub(in super::super) fn eye(&self) -> Vec3 {
        let eye = self.projector.eye();
        self.carried.as_ref().map_or(eye, |carried| carried.place(eye))
    }

    /// Appends the appearances of a point on a path, by its number at the node.
    fn project_on(&self, path: u32, point: Vec3, found: &mut Vec<PanoramicProjection>) {
        let Some(carried) = &self.carried else { return self.projector.project_on(path, point, found) };
        let start = found.len();
        self.projector.project_on(path, carried.back(point), found);
        found[start..].iter_mut().for_each(|seen| carried.carry(seen));
    }
}

impl Sighting {
    fn of(seen: &PanoramicProjection, eye: Vec3) -> Self {
        Self {
            first: seen.reflection_point,
            change: seen.reflection_change,
            change_with_eye: None,
            normal: seen.normal,
            length: seen.path_length,
            last_segment: seen.last_segment,
            error: seen.error * seen.reflection_point.distance(eye),
        }
    }

    /// The exact sighting of a mirror's reflection. `None` if anything is not finite.
    fn exact(found: &Reflection, eye: Vec3, point: Vec3, (towards, medium): (Vec3, f32)) -> Option<Self> {
        let Reflection { position, normal, .. } = found;
        let (normal, last_segment) = (normal.as_vec3(), position.distance(point.as_dvec3()));
        let sighting = Self {
            first: position.as_vec3(),
            change: found.change_with_point(),
            change_with_eye: Some(found.change_with_eye()),
            normal: if normal.dot(towards) < 0.0 { -normal } else { normal },
            length: medium * (position.distance(eye.as_dvec3()) + last_segment) as f32,
            last_segment: last_segment as f32,
            error: 0.0,
        };
        let is_finite = sighting.first.is_finite() && sighting.change.is_finite() && sighting.length.is_finite();
        (is_finite && sighting.change_with_eye?.is_finite()).then_some(sighting)
    }
}

/// The agreement of appearances at the nodes.
struct Misfit {
    are_one: bool,
    /// The greatest distance of a reflection point from its expected place, as a share of the reflector's size.
    most: f32,
}

/// The partner of an appearance among those at another node: each is the other's nearest.
fn partner(of: &NodeAnswer, own: &[NodeAnswer], others: &[NodeAnswer]) -> Option<usize> {
    let nearest = |to: &NodeAnswer, list: &[NodeAnswer]| {
        let distance = |one: &NodeAnswer| one.reflection_point.distance_squared(to.reflection_point);
        let same_sheet = list.iter().enumerate().filter(|(_, one)| one.focal_index == to.focal_index);
        same_sheet.min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b))).map(|(index, _)| index)
    };
    let other = nearest(of, others)?;
    let back = nearest(&others[other], own)?;
    std::ptr::eq(&own[back], of).then_some(other)
}

/// Looks for a point's appearances on one path at the nodes around the eye.
pub(in super::super) struct Lookout<'a> {
    pub(in super::super) nodes: &'a [Node<'a>],
    /// The path's number at each node.
    pub(in super::super) in_nodes: &'a [u32],
    pub(in super::super) path: &'a SpecularPath,
    pub(in super::super) specular: Specular<'a>,
    /// True if points that a node does not see are followed beyond its horizon and borders.
    pub(in super::super) cures: bool,
    /// True if, in a single mirror, the cameras' answers are made exact.
    pub(in super::super) is_exact: bool,
}

thread_local! {
    static AT_NODE: RefCell<Vec<PanoramicProjection>> = RefCell::default();
}

impl Lookout<'_> {
    /// The positions of the nodes.
    pub(in super::super) fn eyes(&self) -> [Vec3; MOST_NODES] {
        std::array::from_fn(|index| self.nodes.get(index).map_or(Vec3::ZERO, Node::eye))
    }

    /// A point's appearances, each with the nodes that know of it. Appearances that one node has and another does not
    /// (beyond its horizon, or past the reflector's border) are searched there by the solver.
    pub(in super::super) fn look(&self, point: Vec3) -> Arc<[Sightings]> {
        let nothing: Arc<[NodeAnswer]> = Arc::from([]);
        let at_nodes: [Arc<[NodeAnswer]>; MOST_NODES] = std::array::from_fn(|index| {
            let (Some(node), Some(&path)) = (self.nodes.get(index), self.in_nodes.get(index)) else {
                return nothing.clone();
            };
            node.answers.get(path, point, || self.at_node(node, path, point))
        });
        let mut found = Vec::new();
        for (index, list) in at_nodes[..self.nodes.len()].iter().enumerate() {
            for own in &**list {
                let partners: [Option<usize>; MOST_NODES] = std::array::from_fn(|other| match other {
                    _ if other >= self.nodes.len() => None,
                    _ if other == index => Some(0),
                    _ => partner(own, list, &at_nodes[other]),
                });
                // Appearances that an earlier node has, too, were found there.
                if partners[..index].iter().any(Option::is_some) {
                    continue;
                }
                let seen_at = |other: usize| match other {
                    _ if other == index => Some(own),
                    _ => partners[other].map(|number| &at_nodes[other][number]),
                };
                let at = self.at_all(point, index, &seen_at);
                let focal_index = own.focal_index;
                let Misfit { are_one, most } = self.misfit(&at);
                if are_one {
                    let is_only = focal_index == 0 && at_nodes.iter().all(|list| list.len() <= 1);
                    let is_rough = most > if is_only { ROUGH } else { ROUGH_BESIDE_FOLDS };
                    found.push(Sightings { focal_index, at, is_rough });
                    continue;
                }
                for (node, one) in at.iter().enumerate().filter(|(_, one)| one.is_some()) {
                    let mut alone = [None; MOST_NODES];
                    alone[node] = *one;
                    found.push(Sightings { focal_index, at: alone, is_rough: true });
                }
            }
        }
        Arc::from(found)
    }

    /// A point's appearances at a node.
    fn at_node(&self, node: &Node<'_>, path: u32, point: Vec3) -> Arc<[NodeAnswer]> {
        AT_NODE.with_borrow_mut(|seen| {
            seen.clear();
            node.project_on(path, point, seen);
            seen.iter().map(|seen| self.answer(node.eye(), seen, point)).collect()
        })
    }

    /// An appearance at a node: exact in a single mirror, where the cameras' answer is the start.
    fn answer(&self, eye: Vec3, seen: &PanoramicProjection, point: Vec3) -> NodeAnswer {
        let PanoramicProjection { focal_index, reflection_point, direction, normal, .. } = *seen;
        // Light stays in one medium.
        let medium = seen.path_length / (reflection_point.distance(eye) + seen.last_segment);
        let sighting = Sighting::of(seen, eye);
        let mut answer = NodeAnswer { focal_index, reflection_point, direction, normal, medium, sighting };
        if self.is_exact
            && let Some(mirror) = self.single_mirror(point)
            && let Some(site) = self.site_of(mirror.object, eye, &answer)
            && let Some(found) = mirror.seen(eye.as_dvec3(), &site)
            && let Some(exact) = Sighting::exact(&found, eye, point, (normal, medium))
        {
            answer.sighting = exact;
        }
        answer
    }

    /// The mirror of a path that has one only.
    fn single_mirror(&self, point: Vec3) -> Option<Mirror<'_>> {
        let [Bounce { object, kind: BounceKind::Reflect }] = self.path.bounces[..] else { return None };
        let (surfaces, reach) = (self.specular.surfaces, REACH * self.size(self.path.bounces.first()));
        Some(Mirror { surfaces, object, point: point.as_dvec3(), reach })
    }

    /// The place on the mirror of an appearance that cameras see. Cameras are somewhat off: at grazing angles the ray
    /// may pass the mirror.
    fn site_of(&self, object: u32, eye: Vec3, seen: &NodeAnswer) -> Option<ManifoldVertex> {
        let deeper = DEEPER * self.size(self.path.bounces.first());
        let deeper = seen.reflection_point - seen.normal * deeper as f32;
        let towards = [seen.direction, (deeper - eye).normalize_or_zero()];
        towards.into_iter().find_map(|direction| self.site(object, eye, direction))
    }

    /// The misfit of appearances at the nodes, as far as the derivatives with respect to the eye are known.
    fn misfit(&self, at: &[Option<Sighting>; MOST_NODES]) -> Misfit {
        let size = self.size(self.path.bounces.first()) as f32;
        let known = || self.nodes.iter().zip(at).filter_map(|(node, at)| Some((node.eye(), at.as_ref()?)));
        let mut misfit = Misfit { are_one: true, most: 0.0 };
        for (index, (from, one)) in known().enumerate() {
            for (to, other) in known().skip(index + 1) {
                let (Some(at_one), Some(at_other)) = (one.change_with_eye, other.change_with_eye) else { continue };
                let expected = expected_move([at_one, at_other], to - from);
                let off = (other.first - one.first).distance(expected);
                misfit.are_one &= off <= (MISMATCH * size).max(MISMATCH_OF_WAY * expected.length());
                misfit.most = misfit.most.max(off / size);
            }
        }
        misfit
    }

    /// An appearance at all nodes. In a single mirror, an appearance that one node has and another does not, or whose
    /// cameras there are too far off, is followed from the first.
    fn at_all<'s>(
        &self,
        point: Vec3,
        index: usize,
        seen_at: &impl Fn(usize) -> Option<&'s NodeAnswer>,
    ) -> [Option<Sighting>; MOST_NODES] {
        let mut at: [Option<Sighting>; MOST_NODES] =
            std::array::from_fn(|node| seen_at(node).map(|seen| seen.sighting));
        let is_known = |at: &Option<Sighting>| at.is_some_and(|at| !self.is_exact || at.change_with_eye.is_some());
        let eye_of = |node: usize| self.nodes[node].eye();
        let (Some(own), Some(mirror)) = (seen_at(index), self.single_mirror(point)) else { return at };
        if !self.cures || at[..self.nodes.len()].iter().all(is_known) {
            return at;
        }
        let Some(site) = self.site_of(mirror.object, eye_of(index), own) else { return at };
        for (node, at) in at.iter_mut().enumerate().take(self.nodes.len()) {
            if node != index && !is_known(at) {
                let found = mirror.walked(&site, [eye_of(index), eye_of(node)].map(Vec3::as_dvec3));
                let towards = (own.normal, own.medium);
                let exact = found.and_then(|found| Sighting::exact(&found, eye_of(node), point, towards));
                *at = exact.or(*at);
            }
        }
        at
    }

    /// The first specular surface that a ray meets, if it is that of an object.
    pub(in super::super) fn site(&self, object: u32, eye: Vec3, direction: Vec3) -> Option<ManifoldVertex> {
        work::add(WORK_A_RAY);
        let Specular { scene, tracer, surfaces, .. } = self.specular;
        let ray = Ray { origin: eye, direction };
        let hit = tracer.first_hit(scene, &ray, scene.near())?;
        surfaces.site_of(&ray, &hit).filter(|(met, _)| *met == object).map(|(_, site)| site)
    }

    /// The path's ray in a direction from a place.
    pub(in super::super) fn sample(&self, eye: Vec3, direction: Vec3) -> Option<RaySample> {
        work::add(WORK_A_RAY * self.path.bounces.len() as u64);
        let ray = Ray { origin: eye, direction };
        let mut sample = None;
        follow(
            &self.specular,
            &Eye::Point(eye.as_dvec3()),
            &ray,
            self.specular.scene.near(),
            &mut |other, followed| {
                if other == *self.path {
                    sample = Some(followed);
                }
            },
        );
        sample
    }

    /// The size of a bounce's object.
    pub(in super::super) fn size(&self, bounce: Option<&Bounce>) -> f64 {
        let size = |bounce: &Bounce| self.specular.scene.objects[bounce.object as usize].bounds.diagonal();
        bounce.map_or(0.0, |bounce| f64::from(size(bounce)))
    }
}
