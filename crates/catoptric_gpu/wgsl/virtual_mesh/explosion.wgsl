// The explosion map of a convex reflector (Ofek, Rappoport 1998): where its reflected rays hit a near and a far sphere
// about it, drawn by hardware, each with the place of the picture that shows it. The twin of `explosion_map/map/chart`.

//#include "scene/records.wgsl"
//#include "scene/microfacets.wgsl"
//#include "optics/step.wgsl"
//#include "virtual_mesh/reflection.wgsl"
//#include "virtual_mesh/spheres.wgsl"

// Triangles that reach this near to the map's singular direction are not drawn: only what is hidden behind the
// reflector lies there.
const SINGULAR = -0.998;

// 1 for the far sphere.
override SPHERE: u32 = 0u;

struct Corner {
    @builtin(position) position: vec4f,
    // In pixels, with the lowest component along the map's axis.
    @location(0) @interpolate(linear) image_px: vec2f,
    @location(1) @interpolate(linear) axial: f32,
}

// Where the ray by a place of the reflector, seen straight from the eye, hits the sphere.
@vertex
fn map_corner(@builtin(vertex_index) index: u32) -> Corner {
    let vertex = vertex_of(corners_of(index / 3u)[index % 3u]);
    let is_perspective = (frame.flags & PERSPECTIVE) != 0u;
    let arriving = select(frame.direction, normalize(vertex.position - frame.origin), is_perspective);
    // Surfaces that are turned away let rays pass: thereby the map goes on behind the reflector.
    let normal = normalize_or(vertex.normal, -arriving);
    let leaving = select(arriving, mirrored(arriving, normal), dot(arriving, normal) < 0.0);
    let radius = sphere_radius(SPHERE);
    let offset = vertex.position - sphere_center();
    let along = dot(offset, leaving);
    let far_side = sqrt(max(along * along - dot(offset, offset) + radius * radius, 0.0)) - along;
    let local = on_axes(normalize(offset + leaving * far_side));
    let clip = frame.clip_from_world * vec4f(vertex.position, 1.0);
    let size = vec2f(f32(frame.width), f32(frame.height));
    let image_px = (clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5) * size;
    // Towards the singular direction places of the map are anywhere.
    let is_drawn = local.z > SINGULAR;
    return Corner(vec4f(map_place(local), select(-1.0, 0.5, is_drawn), 1.0), image_px, local.z);
}

@fragment
fn map_record(corner: Corner) -> @location(0) vec4f {
    if corner.axial < SINGULAR {
        discard;
    }
    return vec4f(corner.image_px, 1.0, 0.0);
}
