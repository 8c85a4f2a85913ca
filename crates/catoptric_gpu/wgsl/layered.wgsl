// The colours of pixels that show mirrors and glass, which look light up in layers about groups of them.

//#include "scene/records.wgsl"
//#include "scene/texture.wgsl"
//#include "scene/microfacets.wgsl"
//#include "scene/environment.wgsl"
//#include "optics/step.wgsl"
//#include "scene/point.wgsl"
//#include "scene/base.wgsl"
//#include "scene/shade.wgsl"
//#include "light/trace.wgsl"
//#include "tiles/cells.wgsl"
//#include "tiles/pixels.wgsl"
//#include "light/paths/tabled.wgsl"
//#include "light/paths/nothing_known.wgsl"
//#include "light/layered/layers.wgsl"
//#include "tiles/one_surface.wgsl"
//#include "tiles/followed.wgsl"

// The group whose paths are followed.
var<private> group_of_paths: LayerGroup;

// Rays are traced among the group's reflectors and lenses; beyond are its layers.
fn root_of_paths() -> u32 {
    return group_of_paths.root;
}

fn light_beyond(segment: Segment) -> vec3f {
    return layers_radiance(group_of_paths, segment.ray, segment.change);
}

// Mirrors whose reflection fades with distance ask after the first event alone.
fn distance_beyond(segment: Segment) -> f32 {
    if segment.order > 1u {
        return FAR;
    }
    return layers_distance(group_of_paths, segment.ray);
}

// The radiance that the shading of mirrors and glass in `tiles/followed.wgsl` asks for.
fn followed_radiance(place: vec2f, cell: vec2u, ray: u32, triangle: u32, side: f32, samples: u32) -> vec3f {
    var number = 0u;
    if triangle != NONE {
        number = group_number_of(object_of(triangle));
    }
    if number == 0u {
        return seen_radiance(place, triangle, side, samples);
    }
    group_of_paths = layer_group_of(number);
    return path_radiance(place, cell, ray, side, samples);
}
