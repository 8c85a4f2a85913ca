//! Points of objects whose appearances are polynomials while the eye stays among its nodes.

use super::blend::{MorphProjector, Outlook, weights_of};
use super::sightings::{SightingField, half_way, known, known_once};
use crate::draw::virtual_mesh::{PictureScale, Steadiness, SteadyField, SteadyPath, SteadySource};
use crate::find::node_sightings::{MOST_NODES, NodeSightings, Sighting};
use crate::find::tetrahedron_form::{FormWeights, TetrahedronForm};
use crate::find::work::SharedWork;
use crate::sample_based_camera::settings::Blend;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::progress::{Cancelled, Stage};
use catoptric_core::scene::{Camera, PreciseView, Projection, View};
use catoptric_engine::method::projector;
use glam::Vec3;

/// Points that a node sees at less than this sine of an angle above the mirror may come and go while the eye moves.
/// Chosen, not measured.
const GRAZING: f32 = 0.05;

/// The picture from the middle reaches so far from its axis at most: this is the tangent. Chosen, not measured.
const WIDEST: f32 = 2.0;

/// The picture of a ball that fills it, with as many pixels a radian in its middle as that of `like`; `None` from
/// within the ball or too near to it.
fn view_of_ball(like: &View, eye: Vec3, (center, radius): (Vec3, f32)) -> Option<View> {
    let Projection::Perspective { fov_y } = like.projection else { return None };
    let focal_px = like.height as f32 * 0.5 / (fov_y * 0.5).tangent();
    let way = center - eye;
    let tangent = radius / (way.length_squared() - radius * radius).max(0.0).sqrt();
    if tangent.is_nan() || tangent > WIDEST {
        return None;
    }
    let up = if way.y.abs() > 0.9 * way.length() { Vec3::X } else { Vec3::Y };
    let half_px = (focal_px * tangent).ceil() + 1.0;
    let fov_deg = 2.0 * (half_px / focal_px).arc_tangent().to_degrees();
    let size = 2 * half_px as u32;
    Some(View::new(&Camera::look_at("", eye, center, up, fov_deg), size, size, like.near))
}

impl SteadySource for MorphProjector<'_> {
    fn on_path(&self, path: u32) -> Option<SteadyPath<'_>> {
        if self.polish > 0 {
            return None;
        }
        let lookout = self.lookout_on(path)?;
        let blended = self.blended.get(path as usize)?;
        let mirror = self.scene.objects[lookout.path.bounces.first()?.object as usize].bounds;
        let middle = lookout.eyes().iter().sum::<Vec3>() / MOST_NODES as f32;
        let view = view_of_ball(&self.view, middle, (mirror.center(), mirror.diagonal() * 0.5))?;
        Some(SteadyPath {
            meshes: &self.reflectors[blended.reflector].known.meshes,
            path,
            kept_path: *blended.in_nodes.first()?,
            middle,
            view_from_middle: PreciseView::new(&view),
            scale_from_middle: PictureScale::new(&view),
            weights: FormWeights::new(weights_of(lookout.nodes)),
            nodes: lookout.eyes(),
            mirror: (mirror.center(), mirror.diagonal()),
            view: self.precise_view,
            scale: PictureScale::new(&self.view),
        })
    }

    fn field(
        &self,
        at: &SteadyPath<'_>,
        points: &[Vec3],
        work: &SharedWork,
        stage: &Stage<'_>,
    ) -> Result<Option<Box<dyn SteadyField>>, Cancelled> {
        let Some((lookout, blended)) = self.lookout_on(at.path).zip(self.blended.get(at.path as usize)) else {
            return Ok(None);
        };
        if lookout.path.bounces.len() != 1 || !self.solves() {
            return Ok(None);
        }
        let around = (self.reflectors[blended.reflector].known, at.kept_path);
        let mirror = (lookout.eyes(), at.mirror.0, at.mirror.1);
        let field = SightingField::new(around, mirror, points, |point| lookout.look(point), (work, stage))?;
        Ok(field.map(|field| Box::new(field) as Box<dyn SteadyField>))
    }

    fn steadiness(&self, at: &SteadyPath<'_>, point: Vec3) -> Steadiness {
        let Some(lookout) = self.lookout_on(at.path) else { return Steadiness::Unsteady(Vec::new()) };
        let found = lookout.look(point);
        match &*found {
            [] => Steadiness::Nowhere,
            [one] if !one.is_rough => match known(one) {
                Some(seen) => self.steadiness_of(at, &seen),
                None => Steadiness::Unsteady(Vec::new()),
            },
            all => {
                let mean = |seen| Some(self.seen_from_middle(at, &seen)?.1);
                Steadiness::Unsteady(all.iter().filter_map(known).filter_map(mean).collect())
            }
        }
    }

    fn sightings(&self, at: &SteadyPath<'_>, point: Vec3) -> Option<NodeSightings> {
        known_once(&self.lookout_on(at.path)?.look(point))
    }

    fn half_way(&self, at: &SteadyPath<'_>, ends: [(Vec3, &NodeSightings); 2]) -> Option<NodeSightings> {
        if self.blend == Blend::Mean {
            return None;
        }
        let [from, to] = ends;
        half_way(&at.nodes, at.mirror, from, to)
    }

    fn steadiness_of(&self, at: &SteadyPath<'_>, seen: &NodeSightings) -> Steadiness {
        match self.seen_from_middle(at, seen) {
            Some((form, mean)) if seen.at.iter().zip(at.nodes).all(is_above) => Steadiness::Shown(form, mean),
            mean => Steadiness::Unsteady(mean.into_iter().map(|(_, mean)| mean).collect()),
        }
    }

    fn seen(&self, at: &SteadyPath<'_>, sightings: &NodeSightings) -> Option<projector::Projection> {
        let outlook = Outlook { eye: self.eye, weights: at.weights, view: &at.view };
        let form = self.form_of(&at.nodes, &sightings.at);
        Self::mean((at.path, sightings.focal_index), &outlook, &form, &sightings.at)
    }
}

impl MorphProjector<'_> {
    /// An appearance that all nodes know of, as a polynomial, and from the middle; `None` if it is not seen from there.
    fn seen_from_middle(
        &self,
        at: &SteadyPath<'_>,
        seen: &NodeSightings,
    ) -> Option<(TetrahedronForm, projector::Projection)> {
        let weights = FormWeights::new([1.0 / MOST_NODES as f32; MOST_NODES]);
        let outlook = Outlook { eye: at.middle.as_dvec3(), weights, view: &at.view_from_middle };
        let form = self.form_of(&at.nodes, &seen.at);
        let mean = Self::mean((at.path, seen.focal_index), &outlook, &form, &seen.at)?;
        form.is_finite().then_some((form, mean))
    }
}

/// True if a node sees an appearance, and not from just above the mirror.
fn is_above((seen, node): (&Sighting, Vec3)) -> bool {
    let way = node - seen.first;
    seen.normal.dot(way) > GRAZING * way.length()
}
