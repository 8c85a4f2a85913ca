//! Appearances of a point at all nodes around the eye, sorted by what belongs together.

use super::places::Carried;
use super::walk::{Mirror, Reflection};
use crate::methods::projection::find::ray_map::{RaySample, Specular, follow};
use crate::methods::projection::find::work;
use crate::methods::projection::sample_based_camera::panorama::{PanoramicProjection, PanoramicProjector};
use crate::methods::projector::SpecularPath;
use crate::optics::path::bundle::{Bounce, BounceKind, Eye};
use crate::optics::path::manifold::ManifoldVertex;
use crate::scene::Ray;
use glam::{Mat3, Vec3};

/// The most nodes around an eye: the corners of a tetrahedron.
pub(super) const MOST_NODES: usize = 4;

/// Work of following a ray to a bounce.
const WORK_A_RAY: u64 = 10;

/// The solver may move a first reflection point by this share of the reflector's size. Chosen, not measured.
pub(super) const REACH: f64 = 0.25;

/// Appearances at two nodes whose reflection points are farther than this from where the derivatives of both expect
/// them are not one: a share of the reflector's size, and of the way between them, which near a horizon changes fast.
/// Chosen, not measured.
const MISMATCH: f32 = 0.02;
const MISMATCH_OF_WAY: f32 = 0.35;

/// A ray that is to meet a mirror in any case leads so far below its surface, as a share of its size. Chosen, not
/// measured.
const DEEPER: f64 = 0.01;

/// An appearance at one node.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sighting {
    /// The first reflection point, and how it changes with the scene point.
    pub(super) first: Vec3,
    pub(super) change: Mat3,
    /// How it changes with the eye; not known after several bounces, and of glass.
    pub(super) change_with_eye: Option<Mat3>,
    /// Unit normal there, on the side from which other nodes see it, if it is beyond this node's horizon.
    pub(super) normal: Vec3,
    /// Optical length from the node to the scene point.
    pub(super) length: f32,
    pub(super) last_segment: f32,
    /// How far the reflection point may be off.
    pub(super) error: f32,
}

/// An appearance at several nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sightings {
    pub(super) focal_index: u32,
    /// At each node, of those that know of it.
    pub(super) at: [Option<Sighting>; MOST_NODES],
}

/// A node around the eye.
pub(super) struct Node<'a> {
    pub(super) weight: f32,
    pub(super) projector: PanoramicProjector<'a>,
    /// It has moved with its reflector since it was built.
    pub(super) carried: Option<Carried>,
}

impl Node<'_> {
    /// Where it is.
    pub(super) fn eye(&self) -> Vec3 {
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

    /// That of a mirror, exactly. `None` if anything is not finite.
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

/// The partner of an appearance among those at another node: each is the other's nearest.
fn partner(of: &PanoramicProjection, own: &[PanoramicProjection], others: &[PanoramicProjection]) -> Option<usize> {
    let nearest = |to: &PanoramicProjection, list: &[PanoramicProjection]| {
        let distance = |one: &PanoramicProjection| one.reflection_point.distance_squared(to.reflection_point);
        let same_sheet = list.iter().enumerate().filter(|(_, one)| one.focal_index == to.focal_index);
        same_sheet.min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b))).map(|(index, _)| index)
    };
    let other = nearest(of, others)?;
    let back = nearest(&others[other], own)?;
    std::ptr::eq(&own[back], of).then_some(other)
}

/// Looks for a point's appearances on one path at the nodes around the eye.
pub(super) struct Lookout<'a> {
    pub(super) nodes: &'a [Node<'a>],
    /// The path's number at each node.
    pub(super) in_nodes: &'a [u32],
    pub(super) path: &'a SpecularPath,
    pub(super) specular: Specular<'a>,
    /// What a node does not see is followed beyond what it sees.
    pub(super) cures: bool,
}

impl Lookout<'_> {
    /// Appends a point's appearances, each with the nodes that know of it. What one node sees and another does not
    /// (beyond its horizon, or past the reflector's border) is looked for there by the solver.
    pub(super) fn look(
        &self,
        point: Vec3,
        at_nodes: &mut [Vec<PanoramicProjection>; MOST_NODES],
        found: &mut Vec<Sightings>,
    ) {
        for ((list, node), number) in at_nodes.iter_mut().zip(self.nodes).zip(self.in_nodes) {
            list.clear();
            node.project_on(*number, point, list);
        }
        for (index, list) in at_nodes[..self.nodes.len()].iter().enumerate() {
            for own in list {
                let partners: [Option<usize>; MOST_NODES] = std::array::from_fn(|other| match other {
                    _ if other >= self.nodes.len() => None,
                    _ if other == index => Some(0),
                    _ => partner(own, list, &at_nodes[other]),
                });
                // What an earlier node sees, too, was found there.
                if partners[..index].iter().any(Option::is_some) {
                    continue;
                }
                let seen_at = |other: usize| match other {
                    _ if other == index => Some(own),
                    _ => partners[other].map(|number| &at_nodes[other][number]),
                };
                let at = match self.of_mirror(point, index, &seen_at) {
                    Some(exact) => exact,
                    None => std::array::from_fn(|other| {
                        seen_at(other).map(|seen| Sighting::of(seen, self.nodes[other].eye()))
                    }),
                };
                let focal_index = own.focal_index;
                if self.belong_together(&at) {
                    found.push(Sightings { focal_index, at });
                    continue;
                }
                for (node, one) in at.iter().enumerate().filter(|(_, one)| one.is_some()) {
                    let mut alone = [None; MOST_NODES];
                    alone[node] = *one;
                    found.push(Sightings { focal_index, at: alone });
                }
            }
        }
    }

    /// True unless the derivatives with the eye tell that appearances at two nodes are not the same: on one sheet each
    /// half of the way between them moves the reflection point as its end says, but for terms of third order.
    fn belong_together(&self, at: &[Option<Sighting>; MOST_NODES]) -> bool {
        let most = MISMATCH * self.size(self.path.bounces.first()) as f32;
        let known = || self.nodes.iter().zip(at).filter_map(|(node, at)| Some((node.eye(), at.as_ref()?)));
        known().enumerate().all(|(index, (from, one))| {
            known().skip(index + 1).all(|(to, other)| {
                let (Some(at_one), Some(at_other)) = (one.change_with_eye, other.change_with_eye) else { return true };
                let expected = (at_one + at_other) * (to - from) * 0.5;
                (other.first - one.first).distance(expected) <= most.max(MISMATCH_OF_WAY * expected.length())
            })
        })
    }

    /// The exact appearances in a single mirror: what nodes see is the start, and where one does not see what others
    /// do, that is followed from these. `None` on other paths.
    fn of_mirror<'s>(
        &self,
        point: Vec3,
        index: usize,
        seen_at: &impl Fn(usize) -> Option<&'s PanoramicProjection>,
    ) -> Option<[Option<Sighting>; MOST_NODES]> {
        let [Bounce { object, kind: BounceKind::Reflect }] = self.path.bounces[..] else { return None };
        let (surfaces, eye_of) = (self.specular.surfaces, |node: usize| self.nodes[node].eye());
        let size = self.size(self.path.bounces.first());
        // Cameras are somewhat off: where they see what grazes the mirror, the ray may pass it.
        let site_of = |node: usize, seen: &PanoramicProjection| {
            let (eye, deeper) = (eye_of(node), seen.reflection_point - seen.normal * (DEEPER * size) as f32);
            let towards = [seen.direction, (deeper - eye).normalize_or_zero()];
            towards.into_iter().find_map(|direction| self.site(object, eye, direction))
        };
        let own = seen_at(index)?;
        let own_site = site_of(index, own)?;
        // Light stays in one medium.
        let medium = own.path_length / (own.reflection_point.distance(eye_of(index)) + own.last_segment);
        let reach = REACH * size;
        let mirror = Mirror { surfaces, object, point: point.as_dvec3(), reach };
        let mut at = [None; MOST_NODES];
        for (node, at) in at.iter_mut().enumerate().take(self.nodes.len()) {
            let eye = eye_of(node);
            let found = match seen_at(node) {
                Some(_) if node == index => mirror.seen(eye.as_dvec3(), &own_site),
                Some(seen) => site_of(node, seen).and_then(|site| mirror.seen(eye.as_dvec3(), &site)),
                None => None,
            };
            let walked = || mirror.walked(&own_site, [eye_of(index), eye].map(Vec3::as_dvec3));
            let found = found.or_else(|| if node == index || !self.cures { None } else { walked() });
            let exact = found.and_then(|found| Sighting::exact(&found, eye, point, (own.normal, medium)));
            *at = exact.or_else(|| seen_at(node).map(|seen| Sighting::of(seen, eye)));
        }
        Some(at)
    }

    /// Where a ray first meets specular surfaces, if that is on an object.
    pub(super) fn site(&self, object: u32, eye: Vec3, direction: Vec3) -> Option<ManifoldVertex> {
        work::add(WORK_A_RAY);
        let Specular { scene, tracer, surfaces, .. } = self.specular;
        let ray = Ray { origin: eye, direction };
        let hit = tracer.first_hit(scene, &ray, scene.near())?;
        surfaces.site_of(&ray, &hit).filter(|(met, _)| *met == object).map(|(_, site)| site)
    }

    /// The path's ray in a direction from a place.
    pub(super) fn sample(&self, eye: Vec3, direction: Vec3) -> Option<RaySample> {
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
    pub(super) fn size(&self, bounce: Option<&Bounce>) -> f64 {
        let size = |bounce: &Bounce| self.specular.scene.objects[bounce.object as usize].bounds.diagonal();
        bounce.map_or(0.0, |bounce| f64::from(size(bounce)))
    }
}
