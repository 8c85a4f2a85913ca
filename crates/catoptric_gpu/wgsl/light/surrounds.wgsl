// How far rays go until they leave shapes that surround a centre, which may be grown to hold their origins; FAR where they
// never do: the twin of `light/parallax_proxy`.

// The smaller of two distances; what is not finite is left out.
fn sooner(distance: f32, other: f32) -> f32 {
    return select(distance, min(distance, other), abs(other) < FAR);
}

fn box_distance(low: vec3f, high: vec3f, origin: vec3f, direction: vec3f) -> f32 {
    let exits = select(min(low, origin), max(high, origin), direction > vec3f(0.0));
    let distances = (exits - origin) / direction;
    return sooner(sooner(sooner(FAR, distances.x), distances.y), distances.z);
}

// The origin is from the centre, as for cylinders.
fn sphere_distance(radius: f32, origin: vec3f, direction: vec3f) -> f32 {
    let along = dot(origin, direction);
    let beyond = max(radius * radius - dot(origin, origin), 0.0);
    return sqrt(along * along + beyond) - along;
}

fn cylinder_distance(radius: f32, bottom: f32, top: f32, origin: vec3f, direction: vec3f) -> f32 {
    let along = dot(origin.xz, direction.xz);
    let beyond = max(radius * radius - dot(origin.xz, origin.xz), 0.0);
    let across2 = dot(direction.xz, direction.xz);
    let side = (sqrt(along * along + across2 * beyond) - along) / across2;
    let end = select(min(bottom, origin.y), max(top, origin.y), direction.y > 0.0);
    return sooner(sooner(FAR, side), (end - origin.y) / direction.y);
}
