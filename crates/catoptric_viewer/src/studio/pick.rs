//! Picking: the path of the ray through a place of the picture.

use catoptric::light::path_tracer::NearPlane;
use catoptric::light::tracer::Tracer;
use catoptric::optics::path::bundle::BounceKind;
use catoptric::optics::step::LightStep;
use catoptric::scene::{Scene, View};
use glam::Vec3;

/// A place where a path meets a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Bounce {
    /// Index of the object.
    pub object: u32,
    /// The place in the world.
    pub position: Vec3,
    /// How the path goes on there, reflected or transmitted; `None` where it ends.
    pub kind: Option<BounceKind>,
    /// The distance from the place before, or from where the ray starts.
    pub distance: f32,
    /// The angle between the ray and the surface's normal, in degrees.
    pub incidence_deg: f32,
}

/// Follows the ray through a place of the picture, with its stronger branch at glass, up to so many events: the
/// surfaces that it meets, the last one being where it ends. Normal maps turn nothing.
pub fn follow(scene: &Scene, tracer: &Tracer, view: &View, [x_px, y_px]: [f32; 2], order: u32) -> Vec<Bounce> {
    let mut ray = view.ray(x_px, y_px);
    let mut near = NearPlane::new(view).distance(&ray);
    let mut path = Vec::new();
    while let Some(hit) = tracer.first_hit(scene, &ray, near) {
        let point = tracer.point(scene, &ray, &hit);
        let material = scene.material_of(point.object);
        let step = LightStep::at(scene, material, &point, ray.direction);
        let goes_on = material.role.is_specular() && (path.len() as u32) < order;
        let kind = if step.prefers_reflection() { BounceKind::Reflect } else { BounceKind::Transmit };
        let next = step.outgoing(kind, ray.direction).filter(|_| goes_on && step.weight(kind) != Vec3::ZERO);
        path.push(Bounce {
            object: point.object,
            position: point.position,
            kind: next.map(|_| kind),
            distance: hit.distance(),
            incidence_deg: ray.direction.dot(point.normal).abs().min(1.0).acos().to_degrees(),
        });
        let Some(direction) = next else { break };
        (ray.origin, ray.direction, near) = (tracer.departure(&point, direction), direction, 0.0);
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric_scenes::builtin;

    #[test]
    fn the_path_obeys_the_law_of_reflection() {
        let scene = builtin::load("sphere_room", &[]).unwrap().pose(&Default::default()).unwrap();
        let tracer = Tracer::build(&scene, |_| true);
        let view = scene.default_view(640, 480);
        let mut mirrored = 0;
        for step in 0..40 {
            let at = [16.0 * step as f32 + 3.0, 200.0 + 2.0 * step as f32];
            let path = follow(&scene, &tracer, &view, at, 2);
            assert!(path.len() <= 3 && path.iter().rev().skip(1).all(|bounce| bounce.kind.is_some()));
            let [first, second, ..] = &path[..] else { continue };
            let object = &scene.objects[first.object as usize];
            let center = object.bounds.center();
            let normal = (first.position - center).normalize();
            let to_eye = (view.eye() - first.position).normalize();
            let to_point = (second.position - first.position).normalize();
            // The ball's triangles carry its exact normals to about a thousandth.
            assert!((to_eye + to_point).normalize().dot(normal) > 0.9999, "{path:?}");
            assert!((second.distance - first.position.distance(second.position)).abs() < 1e-3);
            mirrored += 1;
        }
        assert!(mirrored > 5, "{mirrored}");
    }
}
