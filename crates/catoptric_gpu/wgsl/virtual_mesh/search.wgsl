// Where a point appears in a reflector: the search in the reflector's picture (Estalella et al. 2005) for the place
// whose reflected ray leads to the point, here by the ray's change from pixel to pixel.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "scene/microfacets.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "virtual_mesh/reflection.wgsl"

// Numbers of the reflector's triangles and 1.
@group(2) @binding(1) var reflector_picture: texture_2d<u32>;

// A bound on time; steps this small, in pixels, are the last. Chosen, not measured.
const MOST_SEARCH_STEPS = 16u;
const LAST_SEARCH_STEP_PX = 0.01;
// Searches whose last step is longer than this, in pixels, have found nothing. Chosen, not measured.
const UNSURE_PX = 0.1;
const SHRINKING = 0.7;
const MOST_STRAYS = 3u;
// Longer steps are not numbers.
const FARTHEST_STEP_PX = 3e38;
// A step goes no further than this share of the reflector's picture; one that leads beside it is halved so often.
const LONGEST_SEARCH_STEP = 0.2;
const MOST_HALVINGS = 7u;
// Beside the reflector points appear no further from it than this, in pixels: stencils cut what is drawn there.
const FARTHEST_BESIDE_PX = 64.0;

// The ray that leaves the reflector where a place of the picture shows it, with its change a pixel.
struct LeavingRay {
    ray: Ray,
    change: RayDifferential,
    // From the eye (orthographic: from its plane).
    way: f32,
    // True if the reflector is met on the side that reflects.
    is_there: bool,
}

// NONE beside the reflector.
fn triangle_at_px(image_px: vec2f) -> u32 {
    let at = (image_px - reflection.low) / reflection.size * f32(PICTURE_SIDE);
    if !(all(at >= vec2f(0.0)) && all(at < vec2f(f32(PICTURE_SIDE)))) {
        return NONE;
    }
    return textureLoad(reflector_picture, vec2u(at), 0).x - 1u;
}

// Where a ray meets the reflector near one of its triangles. At the silhouette the plane of that may be met anywhere.
fn reflector_encounter(index: u32, ray: Ray, change: RayDifferential) -> SurfaceInteraction {
    let triangle = triangle_at(index);
    if HAS_EXACT && (surface_of(triangle.object).flags & EXACT) != 0u {
        let middle = (triangle.a.position + triangle.b.position + triangle.c.position) / 3.0;
        let distance = refine(exact_of(triangle.object), ray, dot(middle - ray.origin, ray.direction));
        if distance >= 0.0 {
            return exact_encounter(triangle.object, ray, distance, change);
        }
    }
    var met = plane_met(triangle, ray, change);
    met.at.value = known_place(triangle, ray, met);
    return encounter(triangle, met.at, 1u);
}

fn leaving_at(image_px: vec2f, triangle: u32) -> LeavingRay {
    let arriving = eye_ray(image_px);
    let change = eye_ray_differential(image_px);
    let met = reflector_encounter(triangle, arriving, change);
    let at = facing(arriving.direction, met.point.geometric_normal, met.point.normal);
    let side = select(-1.0, 1.0, at.outside);
    let direction = mirrored(arriving.direction, at.normal);
    let dx = reflected_change(arriving.direction, change.direction_dx, at.normal, met.normal_dx * side);
    let dy = reflected_change(arriving.direction, change.direction_dy, at.normal, met.normal_dy * side);
    let moved = RayDifferential(met.position_dx, met.position_dy, dx, dy);
    var origin = frame.origin;
    if (frame.flags & PERSPECTIVE) == 0u {
        origin = arriving.origin;
    }
    let is_blind = at.outside && (surface_of(reflection.object).flags & INSIDE) != 0u;
    return LeavingRay(Ray(met.point.position, direction), moved, distance(origin, met.point.position), !is_blind);
}

// A step of Newton's method in the picture: by so many pixels the ray leads to the point, about, after such a distance;
// and how that place changes with the point.
struct SearchStep {
    by: vec2f,
    distance: f32,
    change_x: vec3f,
    change_y: vec3f,
    is_turned: bool,
}

fn search_step(leaving: LeavingRay, point: vec3f) -> SearchStep {
    let direction = leaving.ray.direction;
    let offset = point - leaving.ray.origin;
    let along = dot(offset, direction);
    let right = leaving.change.origin_dx + leaving.change.direction_dx * along;
    let down = leaving.change.origin_dy + leaving.change.direction_dy * along;
    // The first rows of the inverse of the matrix with these columns and the direction.
    let volume = dot(cross(right, down), direction);
    let row_x = cross(down, direction) / volume;
    let row_y = cross(direction, right) / volume;
    let aside = offset - direction * along;
    let start_volume = dot(cross(leaving.change.origin_dx, leaving.change.origin_dy), direction);
    let by = vec2f(dot(row_x, aside), dot(row_y, aside));
    return SearchStep(by, along, row_x, row_y, start_volume * volume < 0.0);
}

// The cosine between a view ray and the view's axis.
fn cosine_to_axis(image_px: vec2f) -> f32 {
    return dot(eye_ray(image_px).direction, reflection.axis);
}

// Where a point appears, looked for from a place of the picture that shows the reflector.
fn appearance_from(point: vec3f, start_px: vec2f) -> Appearance {
    var found: Appearance;
    var image_px = start_px;
    var triangle = triangle_at_px(image_px);
    var is_found = false;
    var last_size = FARTHEST_STEP_PX;
    var strays = 0u;
    var last_by = vec2f(0.0);
    for (var count = 0u; count < MOST_SEARCH_STEPS && triangle != NONE && !is_found; count++) {
        let leaving = leaving_at(image_px, triangle);
        let step = search_step(leaving, point);
        let size = length(step.by);
        // Where the ray leads away from the point the last step was too long; what is not a number is no place, either.
        if !(leaving.is_there && step.distance > reflection.shortest && size < FARTHEST_STEP_PX) {
            last_by *= 0.5;
            image_px -= last_by;
            triangle = select(NONE, triangle_at_px(image_px), length(last_by) > LAST_SEARCH_STEP_PX);
            last_size = FARTHEST_STEP_PX;
            continue;
        }
        let longest = LONGEST_SEARCH_STEP * min(reflection.size.x, reflection.size.y);
        var by = step.by * min(1.0, longest / max(size, 1e-20));
        var next = triangle_at_px(image_px + by);
        for (var halving = 0u; halving < MOST_HALVINGS && next == NONE; halving++) {
            by *= 0.5;
            next = triangle_at_px(image_px + by);
        }
        // Steps that do not become shorter lead nowhere if there are many; those that were cut do not count.
        let is_cut = length(by) < 0.9 * size;
        strays += u32(size > SHRINKING * last_size && !is_cut);
        last_size = select(size, FARTHEST_STEP_PX, is_cut);
        if strays > MOST_STRAYS {
            break;
        }
        let is_last = size < LAST_SEARCH_STEP_PX || count + 1u == MOST_SEARCH_STEPS;
        // At the silhouette there is no further to go.
        let is_beside = next == NONE || (length(by) < LAST_SEARCH_STEP_PX && !is_last);
        if is_last || is_beside {
            if is_last && !(size < UNSURE_PX) {
                break;
            }
            found.image_px = image_px + step.by * min(1.0, FARTHEST_BESIDE_PX / max(size, 1e-20));
            found.state = select(WITHIN, BESIDE_IT, triangle_at_px(found.image_px) == NONE);
            found.change_x = step.change_x;
            found.change_y = step.change_y;
            found.is_turned = u32(step.is_turned);
            let path = leaving.way + step.distance;
            let is_perspective = (frame.flags & PERSPECTIVE) != 0u;
            found.depth = select(path, path * cosine_to_axis(found.image_px), is_perspective);
            found.w = select(1.0, found.depth, is_perspective);
            is_found = true;
        }
        image_px += by;
        last_by = by;
        triangle = next;
    }
    // Behind the eye's plane there is no picture.
    if !(found.w > 0.0 && found.depth > 0.0) {
        found.state = NOWHERE;
    }
    return found;
}
