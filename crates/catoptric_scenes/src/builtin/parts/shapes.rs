//! Meshes by formula: positions, exact unit normals, texture coordinates, counter-clockwise from outside.

use catoptric_core::math::portable::{PortableMath, at_angle};
use catoptric_core::surface::{SurfaceMesh, sphere_mesh};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// A mesh without a place or a material.
pub(crate) type Shape = SurfaceMesh;

/// A vertex of a [`grid`].
pub(crate) struct GridVertex {
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
    pub(crate) uv: Vec2,
}

/// A sheet of `columns` times `rows` cells with a vertex for every `(i, j)` of `0..=columns`, `0..=rows`.
///
/// The outer side is that of (change with `i`) x (change with `j`). Triangles that have shrunk to a line, as at a
/// pole, are left out.
pub(crate) fn grid(columns: u32, rows: u32, vertex: impl Fn(u32, u32) -> GridVertex) -> Shape {
    let mut shape = Shape::default();
    for j in 0..=rows {
        for i in 0..=columns {
            let vertex = vertex(i, j);
            shape.positions.push(vertex.position);
            shape.normals.push(vertex.normal);
            shape.uvs.push(vertex.uv);
        }
    }
    let index = |i: u32, j: u32| j * (columns + 1) + i;
    for j in 0..rows {
        for i in 0..columns {
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            for triangle in [[a, b, c], [a, c, d]] {
                let [p, q, r] = triangle.map(|vertex| shape.positions[vertex as usize]);
                if p != q && q != r && r != p {
                    shape.triangles.push(triangle);
                }
            }
        }
    }
    shape
}

/// Adds the triangles of `other`.
pub(crate) fn append(shape: &mut Shape, other: &Shape) {
    let offset = shape.positions.len() as u32;
    shape.positions.extend_from_slice(&other.positions);
    shape.normals.extend_from_slice(&other.normals);
    shape.uvs.extend_from_slice(&other.uvs);
    shape.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + offset)));
}

/// A flat rectangle from `corner` along `right` and `up`, seen upright from the side of `right x up`; a texture
/// covers `tile` scene units.
pub(crate) fn rectangle(corner: Vec3, right: Vec3, up: Vec3, cells: [u32; 2], tile: Vec2) -> Shape {
    let normal = right.cross(up).normalize_or(Vec3::Y);
    let repeats = Vec2::new(right.length(), up.length()) / tile;
    grid(cells[0], cells[1], |i, j| {
        let (s, t) = (i as f32 / cells[0] as f32, j as f32 / cells[1] as f32);
        // Corners shared with other rectangles must not be rounded differently: interpolate from both ends.
        let edge = corner * (1.0 - s) + (corner + right) * s;
        let position = edge * (1.0 - t) + (edge + up) * t;
        GridVertex { position, normal, uv: Vec2::new(s, 1.0 - t) * repeats }
    })
}

/// A box about the origin with the whole texture on every face, each of `cells` times `cells` cells.
pub(in super::super) fn cuboid(half: Vec3, cells: u32) -> Shape {
    let corner = |x: f32, y: f32, z: f32| half * Vec3::new(x, y, z);
    let (x, y, z) = (Vec3::X * half.x * 2.0, Vec3::Y * half.y * 2.0, Vec3::Z * half.z * 2.0);
    let mut shape = Shape::default();
    for (corner, right, up) in [
        (corner(-1.0, -1.0, 1.0), x, y),
        (corner(1.0, -1.0, -1.0), -x, y),
        (corner(1.0, -1.0, 1.0), -z, y),
        (corner(-1.0, -1.0, -1.0), z, y),
        (corner(-1.0, 1.0, 1.0), x, -z),
        (corner(-1.0, -1.0, -1.0), x, z),
    ] {
        append(&mut shape, &rectangle(corner, right, up, [cells; 2], Vec2::new(right.length(), up.length())));
    }
    shape
}

/// A sphere about the origin with `rings` rings and twice as many segments.
pub(crate) fn sphere(radius: f32, rings: u32) -> Shape {
    sphere_mesh(radius, rings, rings * 2)
}

/// An ellipsoid about the origin with `rings` rings and twice as many segments.
pub(in super::super) fn ellipsoid(radii: Vec3, rings: u32) -> Shape {
    let mut shape = sphere(1.0, rings);
    shape.positions.iter_mut().for_each(|position| *position *= radii);
    // The gradient of the implicit function.
    shape.normals.iter_mut().for_each(|normal| *normal = (*normal / radii).normalize());
    shape
}

/// A point of the profile of a surface of revolution about y.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ProfilePoint {
    /// Distance from the axis.
    pub(crate) radius: f32,
    /// Height.
    pub(crate) y: f32,
    /// Direction of the profile (radius, y) here; the outer side is to its right, that is outside when it rises.
    pub(crate) direction: Vec2,
}

/// The surface that a profile sweeps out about the y axis, in `segments` steps.
pub(crate) fn revolution(profile: &[ProfilePoint], segments: u32) -> Shape {
    let Some(last) = profile.len().checked_sub(1) else { return Shape::default() };
    grid(last as u32, segments, |i, j| {
        let point = &profile[i as usize];
        // The seam's two columns of vertices must be the same points, bit for bit.
        let (sin, cos) = ((j % segments) as f32 / segments as f32 * TAU).sine_cosine();
        let normal = Vec3::new(point.direction.y * cos, -point.direction.x, point.direction.y * sin);
        GridVertex {
            position: Vec3::new(point.radius * cos, point.y, point.radius * sin),
            normal: normal.normalize_or(Vec3::Y),
            uv: Vec2::new(1.0 - j as f32 / segments as f32, 1.0 - i as f32 / last as f32),
        }
    })
}

/// The points of a profile given as a function of 0..1 that returns the point and its derivative (radius, y).
pub(in super::super) fn profile(steps: u32, curve: impl Fn(f32) -> (Vec2, Vec2)) -> Vec<ProfilePoint> {
    let point = |step: u32| {
        let (point, direction) = curve(step as f32 / steps as f32);
        ProfilePoint { radius: point.x, y: point.y, direction }
    };
    (0..=steps).map(point).collect()
}

fn line(from: Vec2, to: Vec2) -> Vec<ProfilePoint> {
    profile(1, |t| (from.lerp(to, t), to - from))
}

/// A closed body of revolution whose profile is a chain of straight lines (radius, y), with sharp edges.
pub(in super::super) fn turned(points: &[Vec2], segments: u32) -> Shape {
    let mut shape = Shape::default();
    for pair in points.windows(2) {
        append(&mut shape, &revolution(&line(pair[0], pair[1]), segments));
    }
    shape
}

/// A closed cylinder that stands on the xz plane.
pub(in super::super) fn cylinder(radius: f32, height: f32, segments: u32) -> Shape {
    turned(&[Vec2::ZERO, Vec2::new(radius, 0.0), Vec2::new(radius, height), Vec2::new(0.0, height)], segments)
}

/// A closed cone that stands on the xz plane.
pub(in super::super) fn cone(radius: f32, height: f32, segments: u32) -> Shape {
    turned(&[Vec2::ZERO, Vec2::new(radius, 0.0), Vec2::new(0.0, height)], segments)
}

/// A torus about the y axis: `rings` steps around the tube and twice as many about the axis.
pub(in super::super) fn torus(major_radius: f32, minor_radius: f32, rings: u32) -> Shape {
    let point = |step: u32| {
        let (sin, cos) = ((step % rings) as f32 / rings as f32 * TAU).sine_cosine();
        ProfilePoint {
            radius: major_radius + minor_radius * cos,
            y: minor_radius * sin,
            direction: Vec2::new(-sin, cos),
        }
    };
    revolution(&(0..=rings).map(point).collect::<Vec<_>>(), rings * 2)
}

/// A closed lens about the y axis: two caps of spheres of radius `curvature` that meet in a circle of radius
/// `aperture` (below `curvature`) in the xz plane.
pub(in super::super) fn biconvex_lens(curvature: f32, aperture: f32, rings: u32) -> Shape {
    let widest = (aperture / curvature).arc_sine();
    let cap = |upper: bool| {
        // Each cap runs upwards: the lower one from its pole to the rim, the upper one back to the axis.
        let point = |step: u32| {
            let from_pole = if upper { rings - step } else { step };
            let sign = if upper { 1.0 } else { -1.0 };
            let (sin, cos) = (widest * from_pole as f32 / rings as f32).sine_cosine();
            let on_rim = from_pole == rings;
            ProfilePoint {
                radius: if on_rim { aperture } else { curvature * sin },
                y: if on_rim { 0.0 } else { sign * curvature * (cos - widest.cosine()) },
                direction: Vec2::new(-sign * cos, sin),
            }
        };
        revolution(&(0..=rings).map(point).collect::<Vec<_>>(), rings * 4)
    };
    let mut shape = cap(false);
    append(&mut shape, &cap(true));
    shape
}

/// A spherical dish that opens towards +y, its deepest point at the origin; the outer side is the hollow one.
pub(in super::super) fn spherical_dish(curvature: f32, aperture: f32, rings: u32) -> Shape {
    let widest = (aperture / curvature).arc_sine();
    let curve = |t: f32| {
        let (sin, cos) = (widest * (1.0 - t)).sine_cosine();
        (Vec2::new(curvature * sin, curvature * (1.0 - cos)), -Vec2::new(cos, sin))
    };
    revolution(&profile(rings, curve), rings * 3)
}

/// A parabolic dish of that focal length that opens towards +y; the outer side is the hollow one.
pub(in super::super) fn parabolic_dish(focal_length: f32, aperture: f32, rings: u32) -> Shape {
    let curve = |t: f32| {
        let radius = aperture * (1.0 - t);
        (Vec2::new(radius, radius * radius / (4.0 * focal_length)), -Vec2::new(1.0, radius / (2.0 * focal_length)))
    };
    revolution(&profile(rings, curve), rings * 3)
}

/// A point of the path of a [`tube`].
pub(in super::super) struct TubePoint {
    /// The point of the curve and its first and second derivative.
    pub(in super::super) curve: [Vec2; 3],
    /// The tube's radius and its derivative.
    pub(in super::super) radius: [f32; 2],
}

/// A tube of changing radius along a curve in the xy plane, given over 0..1; open at both ends.
pub(in super::super) fn tube(rings: u32, segments: u32, path: impl Fn(f32) -> TubePoint) -> Shape {
    grid(rings, segments, |i, j| {
        let t = i as f32 / rings as f32;
        let TubePoint { curve: [center, first, second], radius: [radius, radius_change] } = path(t);
        let speed = first.length();
        let along = first / speed;
        let side = Vec3::new(along.y, -along.x, 0.0);
        let (sin, cos) = ((j % segments) as f32 / segments as f32 * TAU).sine_cosine();
        let radial = side * cos + Vec3::Z * sin;
        // On the outer side of a bend the wall is longer than the curve: the curve's turning a unit of the parameter.
        let turning = first.perp_dot(second) / (speed * speed);
        let normal = radial * (speed + radius * cos * turning) - along.extend(0.0) * radius_change;
        GridVertex {
            position: center.extend(0.0) + radial * radius,
            normal: normal.normalize_or(Vec3::Y),
            uv: Vec2::new(j as f32 / segments as f32, t),
        }
    })
}

/// A regular icosahedron with corners at that distance, 20 flat faces; each shows its own cell of a texture of
/// five times five.
pub(in super::super) fn icosahedron(radius: f32) -> Shape {
    let golden = 0.5 + 1.25f32.sqrt();
    let corner = |index: usize| {
        let sign = |bit: usize| if index & bit == 0 { 1.0 } else { -1.0 };
        let (short, long) = (sign(1), sign(2) * golden);
        match index / 4 {
            0 => Vec3::new(0.0, short, long),
            1 => Vec3::new(short, long, 0.0),
            _ => Vec3::new(long, 0.0, short),
        }
    };
    let touching = |a: usize, b: usize| corner(a).distance(corner(b)) < 2.1;
    let mut shape = Shape::default();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if !(touching(a, b) && touching(b, c) && touching(c, a)) {
                    continue;
                }
                let normal = (corner(a) + corner(b) + corner(c)).normalize();
                let flipped = (corner(b) - corner(a)).cross(corner(c) - corner(a)).dot(normal) < 0.0;
                let face = shape.triangles.len() as u32;
                let cell = Vec2::new((face % 5) as f32, (face / 5) as f32);
                let offsets = [Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(0.5, 0.0)];
                for (vertex, offset) in
                    [a, if flipped { c } else { b }, if flipped { b } else { c }].into_iter().zip(offsets)
                {
                    shape.positions.push(corner(vertex).normalize() * radius);
                    shape.normals.push(normal);
                    shape.uvs.push((cell + offset) / 5.0);
                }
                shape.triangles.push([face * 3, face * 3 + 1, face * 3 + 2]);
            }
        }
    }
    shape
}

/// A flat polygon in the xy plane, facing +z, from its outline (counter-clockwise, without self-intersections):
/// exactly the outline's vertices, cut into triangles by removing ears.
pub(in super::super) fn polygon(outline: &[Vec2]) -> Shape {
    let bounds = outline.iter().fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
    let size = (bounds.1 - bounds.0).max_element().max(f32::MIN_POSITIVE);
    let mut shape = Shape {
        positions: outline.iter().map(|p| p.extend(0.0)).collect(),
        normals: vec![Vec3::Z; outline.len()],
        uvs: outline.iter().map(|p| Vec2::new(p.x - bounds.0.x, bounds.1.y - p.y) / size).collect(),
        triangles: Vec::new(),
    };
    let turn = |a: Vec2, b: Vec2, c: Vec2| (b - a).perp_dot(c - a);
    let mut rest: Vec<u32> = (0..outline.len() as u32).collect();
    while rest.len() >= 3 {
        let at = |k: usize| rest[k % rest.len()];
        let is_ear = |k: &usize| {
            let corners = [at(k + rest.len() - 1), at(*k), at(k + 1)];
            let [a, b, c] = corners.map(|vertex| outline[vertex as usize]);
            let empty = rest.iter().filter(|vertex| !corners.contains(vertex)).all(|&vertex| {
                let p = outline[vertex as usize];
                turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0
            });
            turn(a, b, c) > 0.0 && empty
        };
        // Every simple polygon has an ear; of those the most regular is cut first, which avoids slivers.
        let quality = |k: &usize| {
            let [a, b, c] = [at(k + rest.len() - 1), at(*k), at(k + 1)].map(|vertex| outline[vertex as usize]);
            turn(a, b, c) / (a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a))
        };
        let best = (0..rest.len()).filter(is_ear).max_by(|a, b| quality(a).total_cmp(&quality(b)));
        let Some(ear) = best else { break };
        shape.triangles.push([at(ear + rest.len() - 1), at(ear), at(ear + 1)]);
        rest.remove(ear);
    }
    shape
}

/// The number of segments of small round objects beside a mirror of this `tess`.
pub(in super::super) fn prop_segments(tess: u32) -> u32 {
    (tess / 2).clamp(3, 64)
}

/// The direction of one of `count` objects evenly around a circle; the first is at +x.
pub(in super::super) fn around(count: u32, index: u32) -> Vec2 {
    at_angle(index as f32 / count as f32 * TAU)
}
