// Rays are traced through the whole scene; beyond is what surrounds it.

fn root_of_paths() -> u32 {
    return frame.root;
}

fn light_beyond(segment: Segment) -> vec3f {
    if spreads_light() && segment.is_cone {
        return background_over(segment.ray.direction, segment.change.direction_dx, segment.change.direction_dy);
    }
    return background(segment.ray.direction);
}

fn distance_beyond(segment: Segment) -> f32 {
    return FAR;
}
