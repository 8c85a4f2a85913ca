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
