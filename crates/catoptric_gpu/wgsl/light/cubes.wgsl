// Places on the faces of a cube, by directions: the twin of `light/cube_map`.

fn largest_absolute_axis(direction: vec3f) -> u32 {
    let size = abs(direction);
    if size.x >= size.y && size.x >= size.z {
        return 0u;
    }
    return select(2u, 1u, size.y >= size.z);
}

struct CubePlace {
    face: u32,
    // From -1 to 1, to the right and down.
    at: vec2f,
    // The squared secant to the face's middle.
    secant2: f32,
}

fn locate(direction: vec3f) -> CubePlace {
    let axis = largest_absolute_axis(direction);
    let along = direction[axis];
    let is_negative = along < 0.0;
    let side_x = select(-direction.z, direction.z, is_negative);
    let side_z = select(direction.x, -direction.x, is_negative);
    let right = select(select(side_z, direction.x, axis == 1u), side_x, axis == 0u);
    let down = select(-direction.y, select(direction.z, -direction.z, is_negative), axis == 1u);
    let at = vec2f(right, down) / abs(along);
    let is_known = abs(at.x) <= 1.0 && abs(at.y) <= 1.0;
    var place: CubePlace;
    place.face = select(4u, axis * 2u + u32(is_negative), is_known);
    place.at = select(vec2f(0.0), at, is_known);
    place.secant2 = 1.0 + dot(place.at, place.at);
    return place;
}

// The texels that a footprint of a width (radians) spans on a face of so many texels a side.
fn texels_across(spread: f32, size: u32, secant2: f32) -> f32 {
    return spread * f32(size) * 0.5 * sqrt(secant2 * sqrt(secant2));
}

// Look-ups of a footprint, side by side along its longer axis: how many, and the width of each.
struct ProbeRow {
    count: f32,
    spread: f32,
    axis: vec3f,
}

// The look-ups for a footprint whose place changes by `dx` and `dy` from pixel to pixel: as many as the ratio of its
// axes, and no more than `most`.
fn probe_row(dx: vec3f, dy: vec3f, most: f32) -> ProbeRow {
    let x2 = dot(dx, dx);
    let y2 = dot(dy, dy);
    let is_x = x2 >= y2;
    let major2 = select(y2, x2, is_x);
    let minor2 = select(x2, y2, is_x);
    let ratio = ceil(min(max(sqrt(major2 / max(minor2, 1e-20)), 1.0), most));
    let is_row = ratio > 1.0 && major2 < FAR;
    let count = select(1.0, ratio, is_row);
    return ProbeRow(count, sqrt(major2) / count, select(vec3f(0.0), select(dy, dx, is_x), is_row));
}
