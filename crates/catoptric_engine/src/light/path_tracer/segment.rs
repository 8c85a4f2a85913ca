//! Rays that wait to be traced, and a thread's buffers of them.

use crate::light::bodies::Bodies;
use crate::light::sides::Sides;
use crate::light::wide_hierarchy::Treelet;
use crate::optics::path::bundle::BounceKind;
use crate::optics::step::Deferred;
use catoptric_core::scene::{Ray, RayDifferential, ShadingQueue};
use glam::Vec3;

/// A ray that waits to be traced.
#[derive(Clone, Copy)]
pub(super) struct Segment {
    pub(super) ray: Ray,
    pub(super) change: Option<RayDifferential>,
    pub(super) near: f32,
    pub(super) throughput: Vec3,
    /// Specular events so far.
    pub(super) order: u32,
    /// Absorption of the medium that it crosses.
    pub(super) absorption: Vec3,
    /// The bodies that it is in, where that matters: some meet, or the path began within one.
    pub(super) bodies: Bodies,
    /// The two-path model has split already.
    pub(super) split: bool,
    /// The ray is one of several that left a rough mirror: it stands for a cone.
    pub(super) is_cone: bool,
    /// The light from infinity that was counted where it started, and is taken away if it meets something; `None`: it
    /// brings that light itself.
    pub(super) counted: Option<Vec3>,
    /// The density of rays like it, a solid angle, where others seek emitters from where it started; 0: none do.
    pub(super) density: f32,
    /// The primary colour of its light, 0 to 2, if it has only one.
    pub(super) color: Option<u8>,
    /// Surfaces that it has passed straight on.
    pub(super) passages: u8,
    /// Light of the mirror that it left, whose share depends on the ray's length.
    pub(super) deferred: Option<Deferred>,
}

impl Segment {
    /// A path's first ray, to surfaces at a distance of at least `near`.
    #[inline(always)]
    pub(super) fn first(ray: Ray, change: Option<RayDifferential>, near: f32) -> Self {
        Self {
            ray,
            change,
            near,
            throughput: Vec3::ONE,
            order: 0,
            absorption: Vec3::ZERO,
            bodies: Bodies::default(),
            split: false,
            is_cone: false,
            counted: None,
            density: 0.0,
            color: None,
            passages: 0,
            deferred: None,
        }
    }

    /// The same on the side where light goes on by an event.
    #[inline(always)]
    pub(super) fn after(&self, kind: BounceKind, sides: &Sides) -> Self {
        match kind {
            BounceKind::Reflect => Self { absorption: sides.absorption[0], ..*self },
            BounceKind::Transmit => Self { absorption: sides.absorption[1], bodies: sides.behind, ..*self },
        }
    }
}

/// A thread's buffers.
#[derive(Default)]
pub(super) struct Waves {
    /// The sum that each waiting segment adds to.
    pub(super) owners: Vec<u32>,
    pub(super) wave: Vec<(Segment, u32)>,
    /// Where paths end.
    pub(super) points: ShadingQueue,
    /// The part of the scene that the first rays may meet.
    pub(super) treelet: Treelet,
}
