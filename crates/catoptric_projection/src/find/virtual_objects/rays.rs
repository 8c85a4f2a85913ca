//! Rays that leave the vertices of a reflector, and where a scene point appears in the plane through a point of it.

use super::mesh::ReflectorMesh;
use super::piece::steps;
use catoptric_core::math::portable::PortableMath;
use catoptric_engine::method::projector::PerPoint;
use catoptric_engine::optics::path::bundle::BounceKind;
use catoptric_engine::optics::step::{reflect, refract_unscaled};
use glam::{Mat3, Vec2, Vec3};

/// Rays of one bounce, vertex by vertex.
#[derive(Clone, Debug)]
pub struct VertexRays {
    /// Reflection or refraction.
    pub kind: BounceKind,
    /// The side that is met: 1 is the outer one, -1 the inner one.
    pub side: f32,
    /// The index of refraction before the bounce over that after it; 1 for reflections.
    pub eta: f32,
    /// True if rays go on within the lens object.
    pub inside_after: bool,
    /// The index of refraction there.
    pub index_after: f32,
    /// Origins of rays: the eye or the bounce before; not finite where none arrives.
    pub origins: Vec<Vec3>,
    /// Their unit directions as they arrive.
    pub incoming: Vec<Vec3>,
    /// Cosines of the angles of incidence; below 0 where the vertex faces away, not a number where no ray arrives.
    pub cosines: Vec<f32>,
    /// Unit directions as they leave; where the vertex faces away, those of the formula. Not finite where there are
    /// none (total reflection).
    pub outgoing: Vec<Vec3>,
    /// `LEAVES` and `FACES`, vertex by vertex.
    pub states: Vec<u8>,
}

/// A ray leaves the vertex.
const LEAVES: u8 = 1;

/// The vertex faces the ray that arrives.
const FACES: u8 = 2;

/// A ray that arrives at a vertex: where it comes from, and its unit direction; not finite where there is none.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArrivingRay {
    pub(super) origin: Vec3,
    pub(super) direction: Vec3,
}

impl ArrivingRay {
    /// The value in place of a missing ray.
    pub(super) const NONE: Self = Self { origin: Vec3::NAN, direction: Vec3::NAN };
}

impl VertexRays {
    /// The rays after a bounce; `inside` is the index of refraction of the body that they meet, if they go on within
    /// it; `arriving` gives the origin and unit direction of each vertex's ray.
    pub(super) fn new(
        mesh: &ReflectorMesh,
        kind: BounceKind,
        side: f32,
        eta: f32,
        inside: Option<f32>,
        arriving: &[ArrivingRay],
    ) -> Self {
        let mut rays = Self {
            kind,
            side,
            eta,
            inside_after: inside.is_some(),
            index_after: inside.unwrap_or(1.0),
            origins: arriving.iter().map(|arrival| arrival.origin).collect(),
            incoming: arriving.iter().map(|arrival| arrival.direction).collect(),
            cosines: Vec::new(),
            outgoing: Vec::new(),
            states: Vec::new(),
        };
        let cosine = |(incoming, normal): (&Vec3, &Vec3)| -incoming.dot(*normal * side);
        rays.cosines = rays.incoming.iter().zip(&mesh.normals).map(cosine).collect();
        let scattered = |(incoming, normal): (&Vec3, &Vec3)| rays.scattered(*incoming, *normal * side);
        rays.outgoing = rays.incoming.iter().zip(&mesh.normals).map(scattered).collect();
        let state = |(outgoing, cosine): (&Vec3, &f32)| {
            (if outgoing.is_finite() { LEAVES } else { 0 }) | (if *cosine > 0.0 { FACES } else { 0 })
        };
        rays.states = rays.outgoing.iter().zip(&rays.cosines).map(state).collect();
        rays
    }

    /// The direction after the bounce, about the normal on the side that is met (both of unit length); it goes on
    /// smoothly to where the surface faces away.
    #[inline]
    pub(crate) fn scattered(&self, incoming: Vec3, normal: Vec3) -> Vec3 {
        match self.kind {
            BounceKind::Reflect => reflect(incoming, normal),
            BounceKind::Transmit => refract_unscaled(incoming, normal, self.eta).unwrap_or(Vec3::NAN),
        }
    }

    /// Turn of rays for a turn of the normal, in radians.
    pub(super) fn bend(&self, normal_turns: f32) -> f32 {
        match self.kind {
            BounceKind::Reflect => 2.0 * normal_turns,
            BounceKind::Transmit => (self.eta - 1.0).abs() * normal_turns,
        }
    }

    /// True if a triangle has rays at all corners and shows the side that is met at one of them at least.
    pub(crate) fn shows(&self, triangle: [u32; 3]) -> bool {
        let [a, b, c] = triangle.map(|vertex| self.states[vertex as usize]);
        a & b & c & LEAVES != 0 && (a | b | c) & FACES != 0
    }

    /// Number of focal points that a ray of a triangle has passed at a distance from it.
    pub(crate) fn focal_index(&self, mesh: &ReflectorMesh, triangle: u32, distance: f32) -> u32 {
        let corners = mesh.triangles[triangle as usize];
        let [p0, p1, p2] = corners.map(|vertex| mesh.positions[vertex as usize]);
        let [d0, d1, d2] = corners.map(|vertex| self.outgoing[vertex as usize]);
        let ([e1, e2], [f1, f2]) = ([p1 - p0, p2 - p0], [d1 - d0, d2 - d0]);
        let middle = d0 + d1 + d2;
        // The area that the three rays span at distance t is c0 + c1 t + c2 t^2.
        let area = |a: Vec3, b: Vec3| a.cross(b).dot(middle);
        focal_points([area(e1, e2), area(f1, e2) + area(e1, f2), area(f1, f2)], distance)
    }
}

/// Number of focal points that rays pass up to a distance t if they span the area `c0 + c1 t + c2 t^2` there.
///
/// Rays that leave a smooth surface are normal to wave fronts: the area is `c0 (1 + k t) (1 + l t)` with the two
/// curvatures of the front. Made of triangles it may have no real roots; then the mean of both factors gives the side
/// of the two focal points, which lie next to each other, on which a distance is. Triangles that are turned away from
/// their rays count one more than those across the silhouette: which separates appearances beyond the silhouette from
/// those in the reflector.
pub fn focal_points([c0, c1, c2]: [f32; 3], distance: f32) -> u32 {
    let end = c0 + distance * (c1 + distance * c2);
    if c0 * end < 0.0 {
        1
    } else if c0 * (2.0 * c0 + distance * c1) < 0.0 {
        2
    } else {
        0
    }
}

/// Newton's method for a crossing of a plane of glass. A bound on time; chosen, not measured.
const MAX_CROSSING_STEPS: u32 = 30;

/// A correction goes no further than this share of the reflector's radius. Chosen, not measured.
const LONGEST_STEP: f32 = 0.5;

/// Reflection points of a batch of scene points.
pub type ReflectionPoints = PerPoint<ReflectionPoint>;

/// A place of a reflector where a scene point appears, about.
#[derive(Clone, Copy, Debug)]
pub struct ReflectionPoint {
    /// The place.
    pub position: Vec3,
    /// The unit normal on the side that is met.
    pub normal: Vec3,
    /// Change of the position with the scene point.
    pub position_change: Mat3,
    /// Change of the normal with the scene point.
    pub normal_change: Mat3,
    /// Origin of the ray that arrives here.
    pub origin: Vec3,
    /// The triangle of the reflector's mesh.
    pub triangle: u32,
    /// Weights of its second and third corner.
    pub weights: Vec2,
    /// True if it lies beyond where the reflector ends as it is seen.
    pub beyond: bool,
    /// The virtual point of the scene point that it was located for and its change, if these are blends of several
    /// tangent planes' images; `None` if they follow from position and normal.
    pub blended_image: Option<(Vec3, Mat3)>,
}

impl ReflectionPoint {
    /// The virtual point of a point by this bounce (Ofek, Rappoport 1998: its mirror image in the tangent plane;
    /// through glass its image along the ray that reaches it by the tangent plane), and its derivative with respect to
    /// the point. Returns `None` if a refracted ray cannot get to it.
    pub fn virtual_point(&self, rays: &VertexRays, point: Vec3) -> Option<(Vec3, Mat3)> {
        if self.blended_image.is_some() {
            return self.blended_image;
        }
        match rays.kind {
            BounceKind::Reflect => Some(self.mirrored(point)),
            BounceKind::Transmit => self.refracted(rays.eta, point),
        }
    }

    /// The place whose ray leads to the point, from here, by one step of Newton's method in the reflector's triangle of
    /// rays, and how that moves with the point; a place of the silhouette where the surface turns away. Returns `None`
    /// if the step leads nowhere.
    pub(super) fn corrected(&self, mesh: &ReflectorMesh, rays: &VertexRays, point: Vec3) -> Option<Self> {
        let corners = mesh.triangles[self.triangle as usize];
        let (edges, turns) = (steps(&mesh.positions, corners), steps(&rays.outgoing, corners));
        let bends = steps(&mesh.normals, corners).map(|bend| bend * rays.side);
        let direction = rays.scattered((self.position - self.origin).normalize_or_zero(), self.normal);
        let from = point - self.position;
        let distance = from.dot(direction);
        let [right, down] = [0, 1].map(|k: usize| edges[k] + turns[k] * distance);
        let inverse = Mat3::from_cols(right, down, direction).inverse();
        let step = (inverse * (from - direction * distance)).truncate();
        let moved = edges[0] * step.x + edges[1] * step.y;
        // Further away another triangle holds the point; values that are not numbers are rejected here, too.
        let near = moved.length_squared() <= (LONGEST_STEP * mesh.radius).powi(2);
        if !near || distance <= 0.0 {
            return None;
        }
        let rows = inverse.transpose();
        let moved = Self {
            position: self.position + moved,
            normal: (self.normal + bends[0] * step.x + bends[1] * step.y).normalize_or_zero(),
            weights: self.weights + step,
            beyond: false,
            blended_image: None,
            ..*self
        };
        Some(moved.held_at_horizon(mesh, rays, [rows.x_axis, rows.y_axis]))
    }

    /// This reflection point with its derivatives, from those of its weights; where the surface turns away, the place
    /// of the silhouette next to it.
    pub(crate) fn held_at_horizon(self, mesh: &ReflectorMesh, rays: &VertexRays, change: [Vec3; 2]) -> Self {
        let corners = mesh.triangles[self.triangle as usize];
        let (edges, bends) =
            (steps(&mesh.positions, corners), steps(&mesh.normals, corners).map(|bend| bend * rays.side));
        let cosine = self.normal.dot((self.origin - self.position).normalize_or_zero());
        let [c0, c1, c2] = corners.map(|vertex| rays.cosines[vertex as usize]);
        let slope = Vec2::new(c1 - c0, c2 - c0);
        let back = slope * (-cosine / slope.length_squared());
        let hidden = cosine < 0.0 && back.is_finite();
        let mut held = self;
        let mut change = change;
        if hidden {
            held.position += edges[0] * back.x + edges[1] * back.y;
            held.normal = (held.normal + bends[0] * back.x + bends[1] * back.y).normalize_or_zero();
            held.weights += back;
            held.beyond = true;
            // Along the silhouette alone.
            let along = Vec2::new(-slope.y, slope.x).normalize_or_zero();
            let moves = change[0] * along.x + change[1] * along.y;
            change = [moves * along.x, moves * along.y];
        }
        let normal_change = outer(bends[0], change[0]) + outer(bends[1], change[1]);
        held.position_change = outer(edges[0], change[0]) + outer(edges[1], change[1]);
        held.normal_change = normal_change - outer(held.normal, normal_change.transpose() * held.normal);
        held
    }

    /// The image beside the silhouette of a point that the reflector turns away from, and its derivative with respect
    /// to the point: as far out as the mirror image in the tangent plane at the silhouette, and at the silhouette
    /// itself if the point is above that plane.
    pub(super) fn beside(&self, point: Vec3) -> (Vec3, Mat3) {
        let from = point - self.position;
        let depth = -self.normal.dot(from);
        if depth <= 0.0 {
            return (self.position, self.position_change);
        }
        let before = self.position.distance(self.origin);
        let share = before / (before + from.length());
        // d depth = slope . d point
        let slope =
            self.position_change.transpose() * self.normal - self.normal - self.normal_change.transpose() * from;
        let change = self.position_change + (outer(self.normal, slope) + self.normal_change * depth) * share;
        (self.position + self.normal * (depth * share), change)
    }

    fn mirrored(&self, point: Vec3) -> (Vec3, Mat3) {
        let normal = self.normal;
        let from = point - self.position;
        let height = normal.dot(from);
        // d height = slope . d point
        let slope = normal - self.position_change.transpose() * normal + self.normal_change.transpose() * from;
        let change = Mat3::IDENTITY - outer(normal * 2.0, slope) - self.normal_change * (2.0 * height);
        (point - normal * (2.0 * height), change)
    }

    fn refracted(&self, eta: f32, point: Vec3) -> Option<(Vec3, Mat3)> {
        let image = |point: Vec3, position: Vec3, normal: Vec3| seen_through(self.origin, point, position, normal, eta);
        let seen = image(point, self.position, self.normal)?;
        // Differences: small against both distances, large against rounding.
        let step = 2e-3 * point.distance(self.position).min(self.origin.distance(self.position));
        let mut change = Mat3::ZERO;
        for axis in 0..3 {
            let by = Vec3::AXES[axis] * step;
            let normal = (self.normal + self.normal_change * by).normalize_or_zero();
            let moved = image(point + by, self.position + self.position_change * by, normal)?;
            *change.col_mut(axis) = (moved - seen) / step;
        }
        Some((seen, change))
    }
}

/// The matrix `a b^T`.
#[inline]
pub fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Image of a point behind a plane of glass, from `origin`: in the direction of the ray that gets there by
/// Snell's law, as far away as the ray is long. Returns `None` if it is not behind the plane.
pub fn seen_through(origin: Vec3, point: Vec3, position: Vec3, normal: Vec3, eta: f32) -> Option<Vec3> {
    let (above, below) = (normal.dot(origin - position), normal.dot(position - point));
    // Values that are not numbers are rejected, too.
    if !(above > 0.0 && below > 0.0) {
        return None;
    }
    let aside = (point - origin) + normal * (above + below);
    // Differences are taken of this: in double precision.
    let [above, below, width, eta] = [above, below, aside.length(), eta].map(f64::from);
    // The sines' difference grows with the place of the crossing: one root between both reflection points.
    let (mut low, mut high) = (0.0, width);
    let mut at = width * above / (above + below);
    for _ in 0..MAX_CROSSING_STEPS {
        let rest = width - at;
        let (before, after) = (at.hypotenuse(above), rest.hypotenuse(below));
        let excess = eta * at / before - rest / after;
        if excess > 0.0 {
            high = at
        } else {
            low = at
        }
        let slope = eta * above * above / (before * before * before) + below * below / (after * after * after);
        let next = at - excess / slope;
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        let step = (next - at).abs();
        at = next;
        if step <= 1e-10 * width {
            break;
        }
    }
    let crossing = aside.as_dvec3().normalize_or_zero() * at - normal.as_dvec3() * above;
    let (before, after) = (at.hypotenuse(above), (width - at).hypotenuse(below));
    let seen = (origin.as_dvec3() + crossing * (1.0 + after / before)).as_vec3();
    seen.is_finite().then_some(seen)
}
