// The colours of pixels that show mirrors and glass, which look light up in light fields about regions of them.

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
//#include "light/reflectors.wgsl"
//#include "light/slabs.wgsl"
//#include "tiles/one_surface.wgsl"
//#include "tiles/followed.wgsl"

// The region whose paths are followed, from 1.
var<private> region_number: u32;
var<private> region: FieldRegion;

// Rays are traced among the region's reflectors and lenses; beyond are its slabs.
fn root_of_paths() -> u32 {
    return region.root;
}

fn light_beyond(segment: Segment) -> vec3f {
    return slab_radiance(region_number, region, segment.ray, segment.change);
}

fn distance_beyond(segment: Segment) -> f32 {
    if region.by_one_event == 0u {
        return FAR;
    }
    return slab_distance(region_number, region, segment.ray);
}

// The radiance that the shading of mirrors and glass in `tiles/followed.wgsl` asks for.
fn followed_radiance(place: vec2f, cell: vec2u, ray: u32, triangle: u32, side: f32, samples: u32) -> vec3f {
    region_number = 0u;
    if triangle != NONE {
        region_number = field_number_of(object_of(triangle));
    }
    if region_number == 0u {
        return look_radiance(place, triangle, side, samples);
    }
    region = field_region_of(region_number);
    return path_radiance(place, cell, ray, side, samples);
}
