// The lobes of a surface at a point: the twin of `scene/shading/lobes`.

//#include "scene/bumps.wgsl"

struct LobesAt {
    flags: u32,
    // The share of the surface that is there.
    coverage: f32,
    base: vec3f,
    metallic: f32,
    alpha: f32,
    // Reflectance of the dielectric at normal incidence, and at grazing angles.
    specular: vec3f,
    grazing: f32,
    transmission: f32,
    // Unit normals on the outer side, turned by maps.
    normal: vec3f,
    coat_normal: vec3f,
    // The share that the coat covers, and the width of its facets.
    coat: f32,
    coat_alpha: f32,
}

// The normal of a point by one of its surface's maps, of which the texels are known.
fn normal_by_texel(point: SurfacePoint, place: u32, scale: f32, texel: vec4f) -> TurnedNormal {
    let binding = binding_of(point.object, place);
    if !HAS_NORMAL_MAPS || binding.texture == NONE || all(point.tangent.xyz == vec3f(0.0)) {
        return TurnedNormal(point.normal, 0.0);
    }
    let mean = texel.xyz * 2.0 - 1.0;
    let variance = variance_of_mean(length(mean)) * (scale * scale) * hidden_share(binding, point);
    return TurnedNormal(turned(point.normal, point.tangent, 1.0, scale, mean), variance);
}

fn lobes_at(point: SurfacePoint, texels: Texels, base: vec4f) -> LobesAt {
    let surface = surface_of(point.object);
    let record = lobes_record_at(surface.lobes);
    var of_lobes = array<vec4f, LOBE_TEXTURES>(
        vec4f(1.0), vec4f(1.0), vec4f(1.0), vec4f(1.0), vec4f(1.0), vec4f(1.0), vec4f(1.0), vec4f(1.0), vec4f(1.0),
        vec4f(1.0), vec4f(1.0));
    // A loop, not one call a texture: compilers copy functions to each place that calls them.
    for (var index = 0u; index < LOBE_TEXTURES; index++) {
        of_lobes[index] = sample_bound(binding_at(surface.lobes + LOBE_BINDINGS_AT + 2u * index), point);
    }
    let facets = normal_by_texel(point, NORMALS, surface.normal_scale, texels.values[NORMALS]);
    let coat = normal_by_texel(point, COAT_NORMALS, record.coat_normal_scale, texels.values[COAT_NORMALS]);
    var at: LobesAt;
    at.flags = record.flags;
    at.coverage = select(1.0, clamp(base.w, 0.0, 1.0), (record.flags & BLENDS) != 0u);
    at.base = base.xyz;
    at.normal = facets.normal;
    at.coat_normal = coat.normal;
    at.coat = surface.coat * texels.values[COAT].x;
    at.transmission = record.transmission * of_lobes[OF_TRANSMISSION].x;
    at.alpha = 1.0;
    if (surface.flags & MICROFACETS) != 0u {
        let roughness = surface.roughness * texels.values[FACETS].y;
        let coat_roughness = surface.facets_coat_roughness * of_lobes[OF_COAT_ROUGHNESS].y;
        let share = of_lobes[OF_SPECULAR].w;
        at.metallic = surface.metallic * texels.values[FACETS].z;
        at.alpha = widened_alpha(roughness * roughness, facets.variance);
        at.coat_alpha = widened_alpha(coat_roughness * coat_roughness, coat.variance);
        at.specular = surface.specular * of_lobes[OF_SPECULAR_COLOR].xyz * share;
        at.grazing = surface.specular_at_grazing * share;
    }
    return at;
}
