// Look-ups in layered environment maps: the twin of `methods/lookup/layered_environment_map/textures/maps`.

//#include "light/cubes.wgsl"
//#include "light/surrounds.wgsl"
//#include "light/layered/shells.wgsl"
//#include "light/layered/depths.wgsl"

// A group of reflectors and lenses: the hierarchy over them, the layers about it, the nearest first, and the shares of
// the viewpoints that are blended.
struct LayerGroup {
    root: u32,
    first_layer: u32,
    layers: u32,
    viewpoints: u32,
    shares: vec4f,
}

const LAYER_GROUP_TEXELS = 2u;
const LAYER_TEXELS = 8u;
const MOST_LAYERS = 17u;
const MOST_VIEWPOINTS = 4u;
// Layers that let less than this share through hide all that is behind them.
const OPAQUE = 1.0 / 1024.0;

// The number of every object's group, from 1; four a texel.
@group(3) @binding(0) var group_numbers: texture_2d<u32>;
// The groups, and behind them the layers.
@group(3) @binding(1) var layer_table: texture_2d<u32>;

fn group_number_of(object: u32) -> u32 {
    return textureLoad(group_numbers, row_of(object / 4u), 0)[object % 4u];
}

fn layer_group_of(number: u32) -> LayerGroup {
    let start = (number - 1u) * LAYER_GROUP_TEXELS;
    let first = textureLoad(layer_table, row_of(start), 0);
    let second = textureLoad(layer_table, row_of(start + 1u), 0);
    return LayerGroup(first.x, first.y, first.z, first.w, bitcast<vec4f>(second));
}

// A layer, by the place of its record among all texels of the table.
fn layer_of(place: u32) -> Layer {
    let a = textureLoad(layer_table, row_of(place), 0);
    let b = textureLoad(layer_table, row_of(place + 1u), 0);
    let c = textureLoad(layer_table, row_of(place + 2u), 0);
    let d = textureLoad(layer_table, row_of(place + 3u), 0);
    let e = textureLoad(layer_table, row_of(place + 4u), 0);
    let f = textureLoad(layer_table, row_of(place + 5u), 0);
    let g = textureLoad(layer_table, row_of(place + 6u), 0);
    let h = textureLoad(layer_table, row_of(place + 7u), 0);
    return Layer(
        bitcast<vec3f>(a.xyz), a.w,
        bitcast<vec3f>(b.xyz), b.w,
        bitcast<vec3f>(c.xyz), c.w,
        bitcast<vec3f>(d.xyz), bitcast<f32>(d.w),
        bitcast<vec3f>(e.xyz), bitcast<f32>(e.w),
        f.x, f.y, f.z, f.w,
        g.x, g.y, vec2u(0u),
        h,
    );
}

// The footprint of a look-up by a ray that meets a layer so.
fn met_footprint(layer: Layer, ray: ShellRay, hit: LayerHit) -> LayerFootprint {
    if layer.has_depths == 0u {
        return layer_footprint(layer, ray);
    }
    // The ray meets the shell where it is as far away as what it meets. Shells are looked up where rays leave them:
    // where one comes in, the same line is followed back from within.
    var shrunk = ray;
    if hit.is_inward {
        let within = hit.distance + 0.5 * (hit.outward - hit.distance);
        shrunk.origin = at_distance(ray, within);
        shrunk.direction = -ray.direction;
        for (var neighbour = 0u; neighbour < 2u; neighbour++) {
            shrunk.moved[neighbour] += shrunk.turned[neighbour] * within;
            shrunk.turned[neighbour] = -shrunk.turned[neighbour];
        }
    }
    shrunk.origin /= hit.share;
    shrunk.moved[0] /= hit.share;
    shrunk.moved[1] /= hit.share;
    var footprint = layer_footprint(layer, shrunk);
    if layer.shape == SHELL_QUAD {
        return footprint;
    }
    // The place as it is seen from the centre, and no more of what is around it than surfaces show that are not too
    // oblique.
    let place = at_distance(ray, hit.distance);
    let inverse = 1.0 / length(place);
    footprint.place = place * inverse;
    var moved = ray.moved;
    var turned = ray.turned;
    for (var neighbour = 0u; neighbour < 2u; neighbour++) {
        let passed = cross(moved[neighbour] + turned[neighbour] * hit.distance, place);
        let most = MAX_OBLIQUE * length(passed) * inverse * inverse;
        let change = footprint.changes[neighbour];
        let length2 = dot(change, change);
        if length2 > most * most {
            footprint.changes[neighbour] = change * (most / sqrt(length2));
        }
    }
    return footprint;
}

// The radiance that arrives along a ray: layer over layer before the scene's background, blended over viewpoints.
fn layers_radiance(group: LayerGroup, ray: Ray, change: RayDifferential) -> vec3f {
    // The layers that the ray meets, the nearest first and of equals the first: where, and their numbers.
    var places: array<f32, MOST_LAYERS>;
    var numbers: array<u32, MOST_LAYERS>;
    var hits_of: array<LayerHit, MOST_LAYERS>;
    var met = 0u;
    for (var number = 0u; number < min(group.layers, MOST_LAYERS); number++) {
        let layer = layer_of(group.first_layer + number * LAYER_TEXELS);
        var hit = LayerHit(f32(number), 1.0, true, false, FAR);
        // Without depths the shells follow each other.
        if layer.has_depths != 0u {
            hit = layer_hit(layer, shell_ray(ray, change, layer.center));
        }
        if !hit.is_met || !(hit.distance < FAR) {
            continue;
        }
        var at = met;
        while at > 0u && places[at - 1u] > hit.distance {
            places[at] = places[at - 1u];
            numbers[at] = numbers[at - 1u];
            at--;
        }
        places[at] = hit.distance;
        numbers[at] = number;
        hits_of[number] = hit;
        met++;
    }
    // Radiance so far, and the share of what is behind, by viewpoint.
    var sums = array<vec4f, MOST_VIEWPOINTS>(
        vec4f(0.0, 0.0, 0.0, 1.0), vec4f(0.0, 0.0, 0.0, 1.0), vec4f(0.0, 0.0, 0.0, 1.0), vec4f(0.0, 0.0, 0.0, 1.0),
    );
    let viewpoints = min(group.viewpoints, MOST_VIEWPOINTS);
    var is_open = true;
    for (var order = 0u; order < met && is_open; order++) {
        let number = numbers[order];
        let layer = layer_of(group.first_layer + number * LAYER_TEXELS);
        let footprint = met_footprint(layer, shell_ray(ray, change, layer.center), hits_of[number]);
        is_open = false;
        for (var viewpoint = 0u; viewpoint < viewpoints; viewpoint++) {
            let sum = sums[viewpoint];
            if sum.w >= OPAQUE {
                let own = layer_seen(layer, layer.first_texels[viewpoint], footprint);
                let rest = sum.w * (1.0 - clamp(own.w, 0.0, 1.0));
                sums[viewpoint] = vec4f(sum.xyz + own.xyz * sum.w, rest);
                is_open = is_open || rest >= OPAQUE;
            }
        }
    }
    var shares = group.shares;
    var radiance = vec3f(0.0);
    let behind = background(ray.direction);
    for (var viewpoint = 0u; viewpoint < viewpoints; viewpoint++) {
        let sum = sums[viewpoint];
        radiance += (sum.xyz + select(vec3f(0.0), behind * sum.w, sum.w >= OPAQUE)) * shares[viewpoint];
    }
    // Inferred textures may swing below zero beside what is bright.
    return max(radiance, vec3f(0.0));
}

// The distance along a ray of the nearest layer with an opacity over one half; FAR without any.
fn layers_distance(group: LayerGroup, ray: Ray) -> f32 {
    var nearest_place = FAR;
    var sharp: RayDifferential;
    for (var number = 0u; number < min(group.layers, MOST_LAYERS); number++) {
        let layer = layer_of(group.first_layer + number * LAYER_TEXELS);
        let of_layer = shell_ray(ray, sharp, layer.center);
        var hit = LayerHit(shell_distance(layer, of_layer.origin, ray.direction), 1.0, true, false, FAR);
        if layer.has_depths != 0u {
            hit = layer_hit(layer, of_layer);
        }
        if hit.is_met && layer_seen(layer, layer.first_texels.x, met_footprint(layer, of_layer, hit)).w > 0.5 {
            nearest_place = min(nearest_place, hit.distance);
        }
    }
    return nearest_place;
}
