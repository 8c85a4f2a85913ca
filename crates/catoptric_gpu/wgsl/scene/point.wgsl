// Points of surfaces: the twin of `SurfacePoint` and `SurfaceInteraction` in `scene/shading/shade`.

//#include "scene/exact.wgsl"

struct SurfacePoint {
    object: u32,
    // NONE on exact surfaces.
    triangle: u32,
    position: vec3f,
    geometric_normal: vec3f,
    normal: vec3f,
    // Two sets of texture coordinates, and their change with the pixel's column and row.
    uvs: vec4f,
    uvs_dx: vec4f,
    uvs_dy: vec4f,
    samples: u32,
    color: vec4f,
    tangent: vec4f,
    normal_change2: f32,
    barycentrics: vec2f,
    coordinate_size: f32,
}

struct SurfaceInteraction {
    point: SurfacePoint,
    position_dx: vec3f,
    position_dy: vec3f,
    normal_dx: vec3f,
    normal_dy: vec3f,
}

struct Ray {
    origin: vec3f,
    direction: vec3f,
}

// The change of a ray with the pixel's column and row.
struct RayDifferential {
    origin_dx: vec3f,
    origin_dy: vec3f,
    direction_dx: vec3f,
    direction_dy: vec3f,
}

// Weights of a triangle's second and third vertex, and their change.
struct Barycentrics {
    value: vec2f,
    dx: vec2f,
    dy: vec2f,
}

fn eye_ray(position: vec2f) -> Ray {
    let offset = frame.right * position.x + frame.down * position.y;
    if (frame.flags & PERSPECTIVE) != 0u {
        return Ray(frame.origin, normalize(frame.direction + offset));
    }
    return Ray(frame.origin + offset, frame.direction);
}

fn eye_ray_differential(position: vec2f) -> RayDifferential {
    if (frame.flags & PERSPECTIVE) == 0u {
        return RayDifferential(frame.right, frame.down, vec3f(0.0), vec3f(0.0));
    }
    let through = frame.direction + frame.right * position.x + frame.down * position.y;
    let inverse_length = inverseSqrt(dot(through, through));
    let direction = through * inverse_length;
    let dx = (frame.right - direction * dot(direction, frame.right)) * inverse_length;
    let dy = (frame.down - direction * dot(direction, frame.down)) * inverse_length;
    return RayDifferential(vec3f(0.0), vec3f(0.0), dx, dy);
}

// The change of a part of a pixel with such a side.
fn scaled_change(change: RayDifferential, side: f32) -> RayDifferential {
    return RayDifferential(
        change.origin_dx * side,
        change.origin_dy * side,
        change.direction_dx * side,
        change.direction_dy * side,
    );
}

// The change of the point where a ray meets a plane.
fn transferred(change: RayDifferential, direction: vec3f, distance: f32, normal: vec3f) -> array<vec3f, 2> {
    let cosine = dot(direction, normal);
    let inverse = select(0.0, 1.0 / cosine, abs(cosine) > 1e-12 * length(normal));
    let moved_x = change.origin_dx + change.direction_dx * distance;
    let moved_y = change.origin_dy + change.direction_dy * distance;
    return array<vec3f, 2>(
        moved_x - direction * (dot(moved_x, normal) * inverse),
        moved_y - direction * (dot(moved_y, normal) * inverse),
    );
}

// The weights at which a ray meets a triangle's plane, and their change; the distance too.
struct PlaneMet {
    at: Barycentrics,
    distance: f32,
}

// A triangle with all that its corners have.
struct Triangle {
    index: u32,
    object: u32,
    a: Vertex,
    b: Vertex,
    c: Vertex,
}

fn triangle_at(index: u32) -> Triangle {
    let corners = corners_of(index);
    return Triangle(index, corners.w, vertex_of(corners.x), vertex_of(corners.y), vertex_of(corners.z));
}

fn plane_met(triangle: Triangle, ray: Ray, change: RayDifferential) -> PlaneMet {
    let a = triangle.a.position;
    let ab = triangle.b.position - a;
    let ac = triangle.c.position - a;
    let face = cross(ab, ac);
    let distance = dot(a - ray.origin, face) / dot(ray.direction, face);
    let relative = ray.origin + ray.direction * distance - a;
    // The dual basis of the edges turns steps into changes of the weights.
    let inverse = 1.0 / max(dot(face, face), 1e-37);
    let dual_b = cross(ac, face) * inverse;
    let dual_c = cross(face, ab) * inverse;
    let moved = transferred(change, ray.direction, distance, face);
    var met: PlaneMet;
    met.distance = distance;
    met.at.value = vec2f(dot(relative, dual_b), dot(relative, dual_c));
    met.at.dx = vec2f(dot(moved[0], dual_b), dot(moved[0], dual_c));
    met.at.dy = vec2f(dot(moved[1], dual_b), dot(moved[1], dual_c));
    return met;
}

fn largest(vector: vec3f) -> f32 {
    return max(vector.x, max(vector.y, vector.z));
}

fn surface_point(triangle: Triangle, at: Barycentrics, samples: u32) -> SurfacePoint {
    let a = triangle.a;
    let b = triangle.b;
    let c = triangle.c;
    let weights = vec3f(1.0 - at.value.x - at.value.y, at.value.x, at.value.y);
    let ab = b.position - a.position;
    let ac = c.position - a.position;
    let sum = a.normal * weights.x + b.normal * weights.y + c.normal * weights.z;
    var face = cross(ab, ac);
    if dot(face, a.normal + b.normal + c.normal) < 0.0 {
        face = -face;
    }
    var point: SurfacePoint;
    point.object = triangle.object;
    point.triangle = triangle.index;
    point.barycentrics = at.value;
    point.samples = samples;
    point.position = a.position + ab * at.value.x + ac * at.value.y;
    point.geometric_normal = normalize_or(face, a.normal);
    point.normal = normalize_or(sum, point.geometric_normal);
    let uv_a = vec4f(a.u0, a.v0, a.uv1);
    let uv_ab = vec4f(b.u0, b.v0, b.uv1) - uv_a;
    let uv_ac = vec4f(c.u0, c.v0, c.uv1) - uv_a;
    point.uvs = uv_a + uv_ab * at.value.x + uv_ac * at.value.y;
    point.uvs_dx = uv_ab * at.dx.x + uv_ac * at.dx.y;
    point.uvs_dy = uv_ab * at.dy.x + uv_ac * at.dy.y;
    point.color = vec4f(1.0);
    if HAS_COLORS {
        point.color = a.color * weights.x + b.color * weights.y + c.color * weights.z;
    }
    if HAS_NORMAL_MAPS {
        let along = a.tangent.xyz * weights.x + b.tangent.xyz * weights.y + c.tangent.xyz * weights.z;
        point.tangent = vec4f(along, a.tangent.w);
    }
    point.coordinate_size = largest(max(abs(a.position), max(abs(b.position), abs(c.position))));
    let change_b = b.normal - a.normal;
    let change_c = c.normal - a.normal;
    let dx = change_b * at.dx.x + change_c * at.dx.y;
    let dy = change_b * at.dy.x + change_c * at.dy.y;
    let across_x = dx - point.normal * dot(dx, point.normal);
    let across_y = dy - point.normal * dot(dy, point.normal);
    point.normal_change2 = (dot(across_x, across_x) + dot(across_y, across_y)) / max(dot(sum, sum), 1e-6);
    return point;
}

// The point of a triangle and its changes a pixel.
fn encounter(triangle: Triangle, at: Barycentrics, samples: u32) -> SurfaceInteraction {
    var result: SurfaceInteraction;
    result.point = surface_point(triangle, at, samples);
    let ab = triangle.b.position - triangle.a.position;
    let ac = triangle.c.position - triangle.a.position;
    let na = triangle.a.normal;
    let nab = triangle.b.normal - na;
    let nac = triangle.c.normal - na;
    let inverse = 1.0 / max(length(na + nab * at.value.x + nac * at.value.y), 1e-6);
    let dx = (nab * at.dx.x + nac * at.dx.y) * inverse;
    let dy = (nab * at.dy.x + nac * at.dy.y) * inverse;
    let normal = result.point.normal;
    result.normal_dx = dx - normal * dot(normal, dx);
    result.normal_dy = dy - normal * dot(normal, dy);
    result.position_dx = ab * at.dx.x + ac * at.dx.y;
    result.position_dy = ab * at.dy.x + ac * at.dy.y;
    return result;
}

fn exact_encounter(object: u32, ray: Ray, distance: f32, change: RayDifferential) -> SurfaceInteraction {
    let exact = exact_of(object);
    let position = ray.origin + ray.direction * distance;
    let taylor = exact_taylor(exact, position - exact.center);
    let size = length(taylor.gradient);
    let normal = taylor.gradient / size;
    let moved = transferred(change, ray.direction, distance, normal);
    let bent_x = taylor.hessian * moved[0] / size;
    let bent_y = taylor.hessian * moved[1] / size;
    var result: SurfaceInteraction;
    result.position_dx = moved[0];
    result.position_dy = moved[1];
    result.normal_dx = bent_x - normal * dot(normal, bent_x);
    result.normal_dy = bent_y - normal * dot(normal, bent_y);
    result.point.object = object;
    result.point.triangle = NONE;
    result.point.position = position;
    result.point.geometric_normal = normal;
    result.point.normal = normal;
    result.point.color = vec4f(1.0);
    result.point.coordinate_size = largest(abs(position));
    if surface_of(object).role != DIFFUSE {
        result.point.normal_change2 =
            dot(result.normal_dx, result.normal_dx) + dot(result.normal_dy, result.normal_dy);
    }
    return result;
}

// Places in a triangle's plane belong to it up to this far beside it, in its sizes: where geometry is off by parts of a
// pixel. On surfaces at a path's end textures may show beyond what belongs to others.
const BESIDE = 3.0;
const HARDLY_BESIDE = 0.1;

// The place of an edge that a ray passes nearest: how far along it that is, and how far the ray passes by, as a share
// of the distance, squared.
fn passed_edge(ray: Ray, start: vec3f, end: vec3f) -> vec2f {
    let first = start - ray.origin;
    let edge = end - start;
    let first_across = first - ray.direction * dot(first, ray.direction);
    let edge_across = edge - ray.direction * dot(edge, ray.direction);
    let along = clamp(-dot(first_across, edge_across) / max(dot(edge_across, edge_across), 1e-37), 0.0, 1.0);
    let place = first + edge * along;
    let aside = first_across + edge_across * along;
    return vec2f(along, dot(aside, aside) / max(dot(place, place), 1e-37));
}

// The place of a triangle that is known to be seen, where a ray misses it by parts of a pixel: that of its plane if it
// is near, or else that of its border which the ray passes nearest.
fn known_place(triangle: Triangle, ray: Ray, met: PlaneMet) -> vec2f {
    let beside = select(BESIDE, HARDLY_BESIDE, surface_of(triangle.object).role == DIFFUSE);
    let is_near = all(met.at.value >= vec2f(-beside)) && all(met.at.value <= vec2f(1.0 + beside));
    if is_near && met.distance > 0.0 {
        return met.at.value;
    }
    let ab = passed_edge(ray, triangle.a.position, triangle.b.position);
    let bc = passed_edge(ray, triangle.b.position, triangle.c.position);
    let ca = passed_edge(ray, triangle.c.position, triangle.a.position);
    if ab.y <= bc.y && ab.y <= ca.y {
        return vec2f(ab.x, 0.0);
    }
    return select(vec2f(0.0, 1.0 - ca.x), vec2f(1.0 - bc.x, bc.x), bc.y <= ca.y);
}

// The encounter of a ray with a triangle after some events: on an exact surface at the exact place.
fn drawn_encounter(index: u32, ray: Ray, change: RayDifferential, samples: u32, events: u32) -> SurfaceInteraction {
    let triangle = triangle_at(index);
    var met = plane_met(triangle, ray, change);
    if HAS_LISTS && events > 0u {
        met.at.value = known_place(triangle, ray, met);
    }
    if HAS_EXACT && (surface_of(triangle.object).flags & EXACT) != 0u {
        let distance = refine(exact_of(triangle.object), ray, met.distance);
        if distance >= 0.0 {
            return exact_encounter(triangle.object, ray, distance, change);
        }
    }
    return encounter(triangle, met.at, samples);
}
