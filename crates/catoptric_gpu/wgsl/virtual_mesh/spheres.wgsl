// Spheres about a reflector, and the map of their directions.

// The near sphere is this much larger than what it is to hold.
const ROOM = 1.001;

fn sphere_center() -> vec3f {
    return (reflection.box_low + reflection.box_high) * 0.5;
}

fn sphere_radius(sphere: u32) -> f32 {
    return select(reflection.radius * ROOM, reflection.far_radius, sphere == 1u);
}

// A direction along the map's axes; the third is towards the eye, its opposite the map's singular direction.
fn on_axes(direction: vec3f) -> vec3f {
    return vec3f(
        dot(direction, reflection.map_x),
        dot(direction, reflection.map_y),
        dot(direction, reflection.map_z),
    );
}

// The place of a direction in the map: -1 to 1.
fn map_place(local: vec3f) -> vec2f {
    return local.xy * inverseSqrt(max(2.0 + 2.0 * local.z, 1e-12));
}
