// The ray that leaves a surface.

// The index of refraction of a bounce; 1 but for lenses.
fn relative_index_of(object: u32, outside: bool) -> f32 {
    return select(1.0, relative_index(surface_of(object).ior, outside), surface_of(object).role == LENS);
}

// By reflection or refraction; without direction on total internal reflection.
fn leaving_ray(kind: u32, incoming: vec3f, at: Facing, eta: f32, point: SurfacePoint) -> Ray {
    return departing_ray(outgoing(kind, at, incoming, eta), point);
}

// In a direction.
fn departing_ray(direction: vec3f, point: SurfacePoint) -> Ray {
    // A little off the surface on the side that the ray leaves to.
    let offset = 16.0 * 1.1920929e-7 * max(point.coordinate_size, 1e-37);
    let side = select(offset, -offset, dot(direction, point.geometric_normal) < 0.0);
    return Ray(point.position + point.geometric_normal * side, direction);
}

// The change of a ray after an event, from that of the ray that arrives.
fn change_after(
    step: LightStep,
    kind: u32,
    incoming: vec3f,
    change: RayDifferential,
    met: SurfaceInteraction,
) -> RayDifferential {
    return RayDifferential(
        met.position_dx,
        met.position_dy,
        direction_change(step, kind, incoming, change.direction_dx, met.normal_dx),
        direction_change(step, kind, incoming, change.direction_dy, met.normal_dy),
    );
}
