//! The appearances of an object's points, interpolated from known ones beside them where that is possible.

use super::meshes::KnownPoints;
use super::source::{Steadiness, SteadyField, SteadyPath, SteadySource};
use crate::find::node_sightings::NodeSightings;
use crate::find::work;
use catoptric_engine::method::projector::{Projection, Projections, SpecularPath, VertexProjector};
use glam::Vec3;

/// Work of a point that is interpolated.
const WORK_IN_FIELD: u64 = 2;

/// Finds out how points of an object appear on a path.
#[derive(Clone, Copy)]
pub(super) struct SteadySearch<'a> {
    pub(super) source: &'a dyn SteadySource,
    pub(super) at: &'a SteadyPath<'a>,
    pub(super) field: Option<&'a dyn SteadyField>,
}

impl SteadySearch<'_> {
    fn in_field(&self, point: Vec3) -> Option<NodeSightings> {
        let found = self.field?.sightings(point)?;
        work::add(WORK_IN_FIELD);
        Some(found)
    }

    pub(super) fn steadiness(&self, point: Vec3) -> Steadiness {
        match self.in_field(point) {
            Some(found) => self.source.steadiness_of(self.at, &found),
            None => self.source.steadiness(self.at, point),
        }
    }

    pub(super) fn sightings(&self, point: Vec3) -> Option<NodeSightings> {
        self.in_field(point).or_else(|| self.source.sightings(self.at, point))
    }

    /// The sightings and appearance half-way between two points.
    pub(super) fn half_way(&self, ends: [(Vec3, &NodeSightings); 2]) -> Option<(NodeSightings, Steadiness)> {
        work::add(WORK_IN_FIELD);
        let found = self.source.half_way(self.at, ends)?;
        Some((found, self.source.steadiness_of(self.at, &found)))
    }
}

/// Projects points: those that are known to the bit as they are kept.
pub(in super::super) struct KnownPointsProjector<'a, P: ?Sized> {
    inner: &'a P,
    source: &'a dyn SteadySource,
    at: &'a SteadyPath<'a>,
    known: &'a KnownPoints,
}

impl<'a, P: ?Sized> KnownPointsProjector<'a, P> {
    /// Wraps the projector of all other points.
    pub(super) fn new(
        inner: &'a P,
        (source, at): (&'a dyn SteadySource, &'a SteadyPath<'a>),
        known: &'a KnownPoints,
    ) -> Self {
        Self { inner, source, at, known }
    }
}

impl<P: VertexProjector + ?Sized> VertexProjector for KnownPointsProjector<'_, P> {
    fn paths(&self) -> &[SpecularPath] {
        self.inner.paths()
    }

    fn project_on(&self, path: u32, points: &[Vec3], found: &mut Projections) {
        for point in points {
            let known = self.known.get(&point.to_array().map(f32::to_bits)).filter(|_| path == self.at.path);
            match known {
                Some(seen) => {
                    work::add(WORK_IN_FIELD);
                    found.extend(&[*point], |_, found| found.extend(self.source.seen(self.at, seen)));
                }
                None => self.inner.project_on(path, &[*point], found),
            }
        }
    }

    fn follow(&self, one: &Projection, point: Vec3, found: &mut Projections) {
        self.inner.follow(one, point, found);
    }
}
