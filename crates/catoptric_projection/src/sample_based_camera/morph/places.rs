//! The places of mirrors now, and when the grids about them were laid out: nodes move with their reflectors (Popescu,
//! Sacks, Mei 2006, section VI).

use super::node_key::NodeKey;
use crate::draw::virtual_scene::MirrorState;
use crate::sample_based_camera::panorama::PanoramicProjection;
use catoptric_core::math::Aabb;
use catoptric_core::scene::Scene;
use glam::{DAffine3, Mat3, Vec3};
use std::sync::Arc;

/// Mirrors that have moved relative to each other by no more than this share of their size have not.
const TOGETHER: f32 = 2e-5;

/// The size of the box about a reflector in which cameras are accurate, in sizes that the scene needs, where mirrors
/// move, or other things beyond the scene's box: these may go so far until cameras are made again. Chosen, not
/// measured.
const ROOM_TO_MOVE: f32 = 1.25;

/// A moment of the mirrors.
#[derive(Clone, Debug)]
pub(super) struct MirrorPlaces {
    /// The mirrors as they were when the grids were laid out, and the boxes of all objects then.
    laid_out: Arc<(MirrorState, Vec<Aabb>)>,
    now: Arc<Moment>,
}

/// The places of all objects at one moment.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Moment {
    /// The motion of every mirror and lens since the grids were laid out.
    motions: Vec<DAffine3>,
    /// The boxes of all objects.
    boxes: Vec<Aabb>,
    /// Mirrors and lenses.
    specular: Vec<u32>,
}

fn moment(scene: &Scene, motions: Vec<DAffine3>) -> Arc<Moment> {
    let boxes = scene.objects.iter().map(|object| object.bounds).collect();
    Arc::new(Moment { motions, boxes, specular: scene.specular_objects() })
}

impl MirrorPlaces {
    /// Lays out the grids at the present places.
    pub(super) fn new(scene: &Scene) -> Self {
        let now = moment(scene, vec![DAffine3::IDENTITY; scene.objects.len()]);
        Self { laid_out: Arc::new((MirrorState::of(scene), now.boxes.clone())), now }
    }

    /// The mirrors' places at another moment; `None` if mirrors have changed otherwise than by motions.
    pub(super) fn at(&self, scene: &Scene, state: &MirrorState) -> Option<Self> {
        let motions = self.laid_out.0.motions_to(state)?;
        Some(Self { laid_out: self.laid_out.clone(), now: moment(scene, motions) })
    }

    /// The present moment.
    pub(super) fn now(&self) -> &Arc<Moment> {
        &self.now
    }

    /// A reflector's box when its grid was laid out.
    pub(super) fn box_of_grid(&self, reflector: u32) -> &Aabb {
        &self.laid_out.1[reflector as usize]
    }

    /// A place where it would be had the reflector not moved.
    pub(super) fn place_in_grid(&self, reflector: u32, place: Vec3) -> Vec3 {
        moved(&self.now.motions[reflector as usize].inverse(), place)
    }

    /// A place of a grid where it is now.
    pub(super) fn place_now(&self, reflector: u32, place: Vec3) -> Vec3 {
        moved(&self.now.motions[reflector as usize], place)
    }
}

impl Moment {
    /// The box about a reflector in which the cameras of its nodes are to be accurate if they are built now, with room
    /// to move: turned as the reflector may be.
    pub(super) fn roomy_box(&self, reflector: u32, scene: &Aabb) -> Aabb {
        let center = self.boxes[reflector as usize].center();
        let reach = scene.corners().into_iter().map(|corner| corner.distance(center)).fold(0.0, f32::max);
        let reach = Vec3::splat(reach * ROOM_TO_MOVE);
        Aabb { min: center - reach, max: center + reach }
    }

    /// The motion with its reflector, until `now`, of a node that was built at this moment (about `eye`, with cameras
    /// accurate in a box); the scene has another box now. `None` if the node is no longer valid.
    ///
    /// Other mirrors and lenses may have moved otherwise where paths have one bounce and none of them was or is between
    /// the node and the reflector.
    pub(super) fn motion_of_node(
        &self,
        now: &Self,
        NodeKey { reflector, order, .. }: NodeKey,
        (eye, accurate): (Vec3, &Aabb),
        scene: &Aabb,
    ) -> Option<DAffine3> {
        let own = reflector as usize;
        let (motion, back) = match self.motions[own] == now.motions[own] {
            true => (DAffine3::IDENTITY, DAffine3::IDENTITY),
            false => {
                let motion = now.motions[own] * self.motions[own].inverse();
                (motion, motion.inverse())
            }
        };
        let then = if back == DAffine3::IDENTITY { *scene } else { scene.transformed(&back) };
        if accurate.union(then) != *accurate {
            return None;
        }
        if std::ptr::eq(self, now) {
            return Some(motion);
        }
        let is_between = |bounds: &Aabb| may_hide(bounds, eye, &self.boxes[own]);
        let holds = |&object: &u32| {
            let other = object as usize;
            let (expected, found) = (motion * self.motions[other], now.motions[other]);
            let bounds = &self.boxes[other];
            let apart = |corner: Vec3| {
                // The corner as it was laid out.
                let start = self.motions[other].inverse().transform_point3(corner.as_dvec3());
                expected.transform_point3(start).distance(found.transform_point3(start)) as f32
            };
            let together = expected == found
                || bounds.corners().into_iter().all(|corner| apart(corner) <= TOGETHER * bounds.diagonal());
            let is_free = || !is_between(bounds) && !is_between(&now.boxes[other].transformed(&back));
            together || order == 1 && is_free()
        };
        let mut others = self.specular.iter().filter(|object| **object != reflector);
        others.all(holds).then_some(motion)
    }
}

/// False if a box hides nothing of another from an eye: they are apart along an axis, or on two sides of a plane
/// through the eye and a side of one of them.
pub fn may_hide(bounds: &Aabb, eye: Vec3, other: &Aabb) -> bool {
    let between = other.with(eye);
    if !(bounds.max.cmpge(between.min) & bounds.min.cmple(between.max)).all() {
        return false;
    }
    let [box_ways, other_ways] = [bounds, other].map(|bounds| bounds.corners().map(|corner| corner - eye));
    let are_apart = |normal: Vec3| {
        let range = |ways: &[Vec3; 8]| {
            let along = ways.map(|way| way.dot(normal));
            (along.into_iter().fold(f32::INFINITY, f32::min), along.into_iter().fold(f32::NEG_INFINITY, f32::max))
        };
        let ((low, high), (other_low, other_high)) = (range(&box_ways), range(&other_ways));
        low > 0.0 && other_high <= 0.0 || high < 0.0 && other_low >= 0.0
    };
    let mut ways = box_ways.into_iter().chain(other_ways);
    !ways.any(|way| Vec3::AXES.into_iter().any(|axis| are_apart(way.cross(axis))))
}

/// A point moved.
pub(super) fn moved(motion: &DAffine3, point: Vec3) -> Vec3 {
    if *motion == DAffine3::IDENTITY { point } else { motion.transform_point3(point.as_dvec3()).as_vec3() }
}

/// The transform that carries a node's appearances along with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carried {
    /// The motion since the node was built.
    motion: DAffine3,
    back: DAffine3,
    rotation: Mat3,
}

impl Carried {
    /// The transform of a motion; `None` if nothing has moved.
    pub(super) fn new(motion: &DAffine3) -> Option<Self> {
        let (rotation, back) = (motion.matrix3.as_mat3(), motion.inverse());
        (*motion != DAffine3::IDENTITY).then_some(Self { motion: *motion, back, rotation })
    }

    /// A place of now where it was for the node.
    pub(super) fn back(&self, place: Vec3) -> Vec3 {
        moved(&self.back, place)
    }

    /// A place of the node's where it is now.
    pub(super) fn place(&self, place: Vec3) -> Vec3 {
        moved(&self.motion, place)
    }

    /// An appearance where it is now.
    pub(super) fn carry(&self, seen: &mut PanoramicProjection) {
        let turned = |change: Mat3| self.rotation * change * self.rotation.transpose();
        seen.reflection_point = self.place(seen.reflection_point);
        seen.direction = self.rotation * seen.direction;
        seen.normal = self.rotation * seen.normal;
        seen.direction_change = turned(seen.direction_change);
        seen.reflection_change = turned(seen.reflection_change);
    }
}
