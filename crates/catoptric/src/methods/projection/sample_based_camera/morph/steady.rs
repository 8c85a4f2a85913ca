//! Which points of objects appear as polynomials while the eye stays among its nodes.

use super::blend::{MorphProjector, Outlook, weights_of};
use super::mean::form_of;
use super::sightings::{MOST_NODES, Sighting, Sightings};
use crate::math::portable::PortableMath;
use crate::methods::projection::draw::virtual_mesh::{PictureScale, Steadiness, SteadyPath, SteadySource};
use crate::methods::projection::find::tetrahedron_form::FormWeights;
use crate::scene::{Camera, PreciseView, Projection, View};
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
            view: self.precise_view,
            scale: PictureScale::new(&self.view),
        })
    }

    fn steadiness(&self, at: &SteadyPath<'_>, point: Vec3) -> Steadiness {
        let Some(lookout) = self.lookout_on(at.path) else { return Steadiness::Unsteady(Vec::new()) };
        let found = lookout.look(point);
        let nodes = lookout.eyes();
        let outlook = Outlook {
            eye: at.middle.as_dvec3(),
            weights: [1.0 / MOST_NODES as f32; MOST_NODES],
            view: &at.view_from_middle,
        };
        let from_middle = |one: &Sightings| {
            let known = one.at.iter().all(Option::is_some);
            let sightings = one.at.map(Option::unwrap_or_default);
            let form = form_of(&nodes, &sightings);
            let seen = known.then(|| Self::mean((at.path, one.focal_index), &outlook, &form, &sightings)).flatten()?;
            form.is_finite().then_some((form, seen))
        };
        match &*found {
            [] => Steadiness::Nowhere,
            [one] if !one.is_rough && one.at.iter().zip(nodes).all(is_above) => match from_middle(one) {
                Some((form, seen)) => Steadiness::Shown(form, seen),
                None => Steadiness::Unsteady(Vec::new()),
            },
            all => Steadiness::Unsteady(all.iter().filter_map(from_middle).map(|(_, seen)| seen).collect()),
        }
    }
}

/// True if a node sees an appearance, and not from just above the mirror.
fn is_above((seen, node): (&Option<Sighting>, Vec3)) -> bool {
    seen.is_some_and(|seen| {
        let way = node - seen.first;
        seen.normal.dot(way) > GRAZING * way.length()
    })
}
