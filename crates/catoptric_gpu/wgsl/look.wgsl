// The colours of pixels that show mirrors and glass, which look light up in maps.

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
//#include "light/paths/paths.wgsl"
//#include "light/reflectors.wgsl"
//#include "tiles/one_surface.wgsl"
//#include "tiles/followed.wgsl"

// The radiance that the shading of mirrors and glass in `tiles/followed.wgsl` asks for.
fn followed_radiance(place: vec2f, cell: vec2u, ray: u32, triangle: u32, side: f32, samples: u32) -> vec3f {
    return look_radiance(place, triangle, side, samples);
}
