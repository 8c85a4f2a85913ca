// Where searches begin: at the answer of an explosion map, or of a grid of rays over the reflector's picture.

//#include "virtual_mesh/spheres.wgsl"

// A ray that leaves the reflector at a place of the grid; without weight where that does not show it.
struct StartRay {
    origin: vec3f,
    weight: f32,
    direction: vec3f,
    unused: f32,
}

// From explosion maps.
override FROM_MAPS: bool = false;

@group(2) @binding(2) var<storage, read_write> start_rays: array<StartRay>;
// The explosion maps of the near and of the far sphere: places of the picture, with 1 where there is a record.
@group(2) @binding(8) var near_map: texture_2d<f32>;
@group(2) @binding(9) var far_map: texture_2d<f32>;

fn start_px(number: u32) -> vec2f {
    // In the middle of a texel: rounding finds the same one again.
    let cell = vec2u(number % GRID_SIDE, number / GRID_SIDE);
    let texel = cell * (PICTURE_SIDE / GRID_SIDE) + PICTURE_SIDE / GRID_SIDE / 2u;
    return reflection.low + (vec2f(texel) + 0.5) / f32(PICTURE_SIDE) * reflection.size;
}

// By the records of both spheres in the direction of a point: between them places of the reflector move about evenly
// with one over the distance.
fn start_by_maps(point: vec3f) -> vec3f {
    let offset = point - sphere_center();
    let away = length(offset);
    let place = map_place(on_axes(offset / max(away, 1e-20)));
    let side = f32(textureDimensions(near_map).x);
    let at = vec2u(clamp((place * vec2f(0.5, -0.5) + 0.5) * side, vec2f(0.0), vec2f(side - 1.0)));
    let here = textureLoad(near_map, at, 0).xyz;
    let there = textureLoad(far_map, at, 0).xyz;
    let nearest = 1.0 / sphere_radius(0u);
    let share = clamp((nearest - 1.0 / max(away, 1e-20)) / (nearest - 1.0 / sphere_radius(1u)), 0.0, 1.0);
    if here.z == 0.0 || there.z == 0.0 {
        return select(here, there, here.z == 0.0);
    }
    return mix(here, there, share);
}
