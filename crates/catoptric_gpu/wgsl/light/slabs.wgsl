// Look-ups in light-field slabs about regions of reflectors: the twin of `methods/lookup/light_field/slabs`.

// A region with its six slabs.
struct FieldRegion {
    // The root of the hierarchy over its reflectors and lenses; NONE: paths leave it after one event.
    root: u32,
    // Views a side of a slab.
    views: u32,
    // Pixels a side of a view.
    pixels: u32,
    // The first of the six layers of its pictures.
    first_layer: u32,
    // Not 0: the parallax of pixels is looked up.
    has_depth: u32,
    // Not 0: paths leave it after one event, and how far what they show is away is looked up.
    by_one_event: u32,
    unused: vec2u,
}

// The plane of a slab's views: its coordinate, and across it the first view's, the steps between views, and the
// parallax of the focal plane.
struct FieldSlab {
    low: vec2f,
    plane: f32,
    focal: f32,
    spacing: vec2f,
    unused: vec2u,
}

const FIELD_REGION_TEXELS = 2u;
const FIELD_SLAB_TEXELS = 2u;
const SLABS = 6u;

// The middles of the outermost pixels see this slope.
const STEEPEST = 1.0625;
const MOST_SLAB_PROBES = 8.0;
// Steps by which a view finds what a ray meets.
const PARALLAX_STEPS = 4u;
// More than any parallax: what lies before the plane of views is nearer than all beyond.
const BEFORE_ALL = 100.0;
// A view knows what a ray meets if its pixel there shows what lies on the ray, up to so many pixels.
const AGREES_PX = 1.0;
// The parallax of one step of what is stored.
const PARALLAX_UNIT = 2.0 / 32767.0;

@group(3) @binding(2) var region_table: texture_2d<u32>;
// All views of a slab side by side, a layer a slab; to the right of the finest level the others, one below the other.
@group(3) @binding(3) var slab_radiances: texture_2d_array<f32>;
@group(3) @binding(4) var slab_parallaxes: texture_2d_array<i32>;
@group(3) @binding(5) var linear: sampler;

fn field_region_of(number: u32) -> FieldRegion {
    let start = (number - 1u) * (FIELD_REGION_TEXELS + SLABS * FIELD_SLAB_TEXELS);
    let first = textureLoad(region_table, row_of(start), 0);
    let second = textureLoad(region_table, row_of(start + 1u), 0);
    return FieldRegion(first.x, first.y, first.z, first.w, second.x, second.y, vec2u(0u));
}

fn field_slab_of(number: u32, slab: u32) -> FieldSlab {
    let of_region = (number - 1u) * (FIELD_REGION_TEXELS + SLABS * FIELD_SLAB_TEXELS);
    let start = of_region + FIELD_REGION_TEXELS + slab * FIELD_SLAB_TEXELS;
    let first = bitcast<vec4f>(textureLoad(region_table, row_of(start), 0));
    let second = bitcast<vec4f>(textureLoad(region_table, row_of(start + 1u), 0));
    return FieldSlab(first.xy, first.z, first.w, second.xy, vec2u(0u));
}

// The two coordinates across an axis.
fn across(axis: u32, vector: vec3f) -> vec2f {
    return select(select(vector.xy, vector.zx, axis == 1u), vector.yz, axis == 0u);
}

// A ray in a slab.
struct SlabRay {
    // False where no slab holds it.
    is_held: bool,
    slab: FieldSlab,
    layer: u32,
    axis: u32,
    sign: f32,
    // Where it meets the plane of views, in views from the first.
    st: vec2f,
    // Steps across the axis a step along it.
    slope: vec2f,
    // How far along the axis the plane lies ahead of the ray's origin.
    ahead: f32,
}

fn located(number: u32, region: FieldRegion, ray: Ray) -> SlabRay {
    var result: SlabRay;
    result.axis = largest_absolute_axis(ray.direction);
    let forward = ray.direction[result.axis];
    result.sign = select(1.0, -1.0, forward < 0.0);
    let index = result.axis * 2u + select(0u, 1u, forward < 0.0);
    result.slab = field_slab_of(number, index);
    result.layer = region.first_layer + index;
    result.ahead = (result.slab.plane - ray.origin[result.axis]) * result.sign;
    result.slope = across(result.axis, ray.direction) / abs(forward);
    let meets = across(result.axis, ray.origin) + result.slope * result.ahead;
    let st = (meets - result.slab.low) / result.slab.spacing;
    let last = f32(region.views - 1u);
    // Not what is not a number.
    result.is_held = all(st >= vec2f(-1e-3)) && all(st <= vec2f(last + 1e-3));
    result.st = clamp(st, vec2f(0.0), vec2f(last));
    return result;
}

// One of the four views about a ray.
struct NearbyView {
    view: vec2u,
    share: f32,
    // How much the slope changes from the ray to the view's pixel with the parallax.
    shift: vec2f,
    parallax: f32,
}

struct NearbyViews {
    views: array<NearbyView, 4>,
    // The sum of their shares.
    total: f32,
}

// The step of slopes from pixel to pixel.
fn slope_step(region: FieldRegion) -> f32 {
    return 2.0 * STEEPEST / f32(region.pixels - 1u);
}

// The parallax of the pixel of a view that is nearest to a slope.
fn parallax_at(region: FieldRegion, layer: u32, view: vec2u, slope: vec2f) -> f32 {
    let per_pixel = 1.0 / slope_step(region);
    let place = floor(slope * per_pixel + (STEEPEST * per_pixel + 0.5));
    let pixel = vec2u(clamp(place, vec2f(0.0), vec2f(f32(region.pixels - 1u))));
    return f32(textureLoad(slab_parallaxes, view * region.pixels + pixel, layer, 0).x) * PARALLAX_UNIT;
}

fn nearby_views(region: FieldRegion, ray: SlabRay) -> NearbyViews {
    let low = min(floor(ray.st), vec2f(f32(region.views - 2u)));
    let at = ray.st - low;
    let aspect = ray.slab.spacing / max(ray.slab.spacing.x, ray.slab.spacing.y);
    var result: NearbyViews;
    for (var number = 0u; number < 4u; number++) {
        let corner = vec2u(number & 1u, number >> 1u);
        let aside = at - vec2f(corner);
        let share = (1.0 - abs(aside.x)) * (1.0 - abs(aside.y));
        result.views[number] = NearbyView(vec2u(low) + corner, share, aside * aspect, ray.slab.focal);
    }
    if region.has_depth != 0u {
        find_depths(region, ray, &result);
    }
    for (var number = 0u; number < 4u; number++) {
        result.total += result.views[number].share;
    }
    return result;
}

// Sets the parallax by which each view finds what the ray meets, and the views' shares.
fn find_depths(region: FieldRegion, ray: SlabRay, found: ptr<function, NearbyViews>) {
    let per_pixel = 1.0 / slope_step(region);
    var agree: array<bool, 4>;
    // The nearest one of several surfaces on the ray hides the others.
    var nearest_parallax = 0.0;
    var nearness = -FAR;
    for (var number = 0u; number < 4u; number++) {
        var view = (*found).views[number];
        let longest = length(view.shift) * per_pixel;
        var off = FAR;
        for (var step = 0u; step < PARALLAX_STEPS && off >= 0.25 * AGREES_PX; step++) {
            let seen = parallax_at(region, ray.layer, view.view, ray.slope + view.shift * view.parallax);
            off = longest * abs(seen - view.parallax);
            view.parallax = seen;
        }
        let slope = abs(ray.slope + view.shift * view.parallax);
        agree[number] = slope.x <= STEEPEST && slope.y <= STEEPEST && off < AGREES_PX && view.share > 0.0;
        let near = view.parallax + select(0.0, BEFORE_ALL, view.parallax < 0.0);
        if agree[number] && near > nearness {
            nearness = near;
            nearest_parallax = view.parallax;
        }
        (*found).views[number] = view;
    }
    // All views count if none has the ray's surface.
    if nearness == -FAR {
        return;
    }
    for (var number = 0u; number < 4u; number++) {
        let apart = abs((*found).views[number].parallax - nearest_parallax) * per_pixel;
        (*found).views[number].share *= select(0.0, clamp(2.0 * AGREES_PX - apart, 0.0, 1.0), agree[number]);
    }
}

fn mean_parallax(found: NearbyViews) -> f32 {
    var views = found.views;
    var sum = 0.0;
    for (var number = 0u; number < 4u; number++) {
        sum += views[number].parallax * views[number].share;
    }
    return sum / found.total;
}

// The change from pixel to pixel of the slope at which a view shows what a ray meets.
fn slab_footprint(ray: SlabRay, parallax: f32, forward: f32, moved: vec3f, turned: vec3f) -> vec2f {
    let slope = (across(ray.axis, turned) - ray.slope * (turned[ray.axis] * ray.sign)) / forward;
    let aside = across(ray.axis, moved) - ray.slope * (moved[ray.axis] * ray.sign);
    return slope + (aside + slope * ray.ahead) * parallax;
}

// The radiance that a level of a view shows at a slope, bilinear.
fn view_radiance(region: FieldRegion, layer: u32, view: vec2u, slope: vec2f, level: u32) -> vec3f {
    let side = region.pixels >> level;
    let shrunk = 1.0 / f32(1u << level);
    let per_pixel = shrunk / slope_step(region);
    let at = clamp(slope * per_pixel + (STEEPEST * per_pixel + 0.5 * shrunk - 0.5), vec2f(0.0), vec2f(f32(side - 1u)));
    var corner = vec2u(0u);
    if level > 0u {
        corner.x = region.views * region.pixels;
        for (var finer = 1u; finer < level; finer++) {
            corner.y += region.views * (region.pixels >> finer);
        }
    }
    let place = vec2f(corner + view * side) + at + 0.5;
    let size = vec2f(textureDimensions(slab_radiances));
    return textureSampleLevel(slab_radiances, linear, place / size, layer, 0.0).xyz;
}

// The radiance along a ray from a place of a region, blurred over its changes from pixel to pixel.
fn slab_radiance(number: u32, region: FieldRegion, ray: Ray, change: RayDifferential) -> vec3f {
    let met = located(number, region, ray);
    if !met.is_held {
        return background(ray.direction);
    }
    let found = nearby_views(region, met);
    let parallax = mean_parallax(found) / max(met.slab.spacing.x, met.slab.spacing.y);
    let forward = abs(ray.direction[met.axis]);
    let across_x = slab_footprint(met, parallax, forward, change.origin_dx, change.direction_dx);
    let across_y = slab_footprint(met, parallax, forward, change.origin_dy, change.direction_dy);
    let x2 = dot(across_x, across_x);
    let y2 = dot(across_y, across_y);
    let is_x = x2 >= y2;
    let longest = sqrt(select(y2, x2, is_x));
    let shortest = sqrt(select(x2, y2, is_x));
    let axis = select(across_y, across_x, is_x);
    let pixel = slope_step(region);
    // Also what is not a number has one.
    let has_row = longest > pixel && longest < FAR;
    let ratio = ceil(clamp(longest / max(shortest, pixel), 1.0, MOST_SLAB_PROBES));
    let probes = select(1.0, ratio, has_row);
    let wide = longest / (probes * pixel);
    let coarsest = f32(firstLeadingBit(region.pixels));
    let level = select(0.0, min(log2(wide), coarsest), wide > 1.0);
    let fine = u32(level);
    let blend = level - f32(fine);
    var views = found.views;
    var sum = vec3f(0.0);
    for (var index = 0u; index < 4u; index++) {
        let view = views[index];
        if view.share <= 0.0 {
            continue;
        }
        let slope = met.slope + view.shift * view.parallax;
        let weight = view.share / (found.total * probes);
        for (var probe = 0.0; probe < probes; probe += 1.0) {
            let at = slope + axis * ((probe + 0.5) / probes - 0.5);
            sum += view_radiance(region, met.layer, view.view, at, fine) * (weight * (1.0 - blend));
            if blend > 0.0 {
                sum += view_radiance(region, met.layer, view.view, at, fine + 1u) * (weight * blend);
            }
        }
    }
    return sum;
}

// How far away what a ray meets lies; FAR where that is not known.
fn slab_distance(number: u32, region: FieldRegion, ray: Ray) -> f32 {
    let met = located(number, region, ray);
    if !met.is_held {
        return FAR;
    }
    let beyond = max(met.slab.spacing.x, met.slab.spacing.y) / mean_parallax(nearby_views(region, met));
    let distance = (met.ahead + beyond) / abs(ray.direction[met.axis]);
    return select(FAR, min(distance, FAR), distance > 0.0);
}
