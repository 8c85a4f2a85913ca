// The shading of pixels that show mirrors and glass, in the tiles that have some. What they show, and whether four
// samples are shaded at once, the shader says that includes this: `followed_radiance` and `is_shaded_once`.

@compute @workgroup_size(8, 8)
fn follow_one_sample(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let in_band = followed_pixel(group, local);
    let pixel = in_band + vec2u(0u, frame.first_row);
    let cell = in_band / 2u;
    if !is_in_picture(pixel) || any(cell >= frame.cells) {
        return;
    }
    let ray = (in_band.x & 1u) | ((in_band.y & 1u) << 1u);
    let hit = hits[hit_index(cell, 0u, 0u)][ray];
    if is_followed(hit) {
        let place = vec2f(pixel) + frame.sample_place;
        let color = followed_radiance(place, cell, ray, triangle_of(hit), frame.sample_side, 1u);
        textureStore(colors, pixel, vec4f(color, 1.0));
    }
}

// Pixels of a group, and the most things that are shaded for each: all samples as one, and each on its own where they
// turn out to show several places.
const PIXELS = 64u;
const MOST_SHADED = 5u;

// Things to be shaded: a pixel of the group, times 8, plus a sample or ALL_SAMPLES.
var<workgroup> to_shade: array<u32, PIXELS * MOST_SHADED>;
var<workgroup> shade_count: atomic<u32>;
var<workgroup> count_so_far: u32;
// Light, and its share of the pixel's.
var<workgroup> of_samples: array<vec4f, PIXELS * RAYS>;
const ALL_SAMPLES = 4u;

fn let_wait(pixel: u32, is_one: bool) {
    if is_one {
        to_shade[atomicAdd(&shade_count, 1u)] = pixel * 8u + ALL_SAMPLES;
        return;
    }
    let first = atomicAdd(&shade_count, RAYS);
    for (var ray = 0u; ray < RAYS; ray++) {
        to_shade[first + ray] = pixel * 8u + ray;
    }
}

// The same with a thread a pixel, for scenes in which light spreads: four samples that are shaded as one have as many
// rays there as four on their own, and would hold up others of their group.
@compute @workgroup_size(8, 8)
fn follow_four_samples_spreading(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_id) local: vec3u) {
    let cell = followed_pixel(group, local);
    let pixel = cell + vec2u(0u, frame.first_row);
    if !is_in_picture(pixel) || any(cell >= frame.cells) {
        return;
    }
    let ids = hits[hit_index(cell, 0u, 0u)];
    if !is_followed(ids.x | ids.y | ids.z | ids.w) {
        return;
    }
    var is_one = is_shaded_once(ids, cell, pixel);
    var sum = vec3f(0.0);
    shows_several = false;
    for (var ray = 0u; ray < RAYS; ray++) {
        let place = vec2f(pixel) + select(four_samples[ray], vec2f(0.5), is_one);
        let side = select(0.5, 1.0, is_one);
        let color = followed_radiance(place, cell, ray, triangle_of(ids[ray]), side, select(1u, RAYS, is_one));
        if !is_one {
            sum += color * 0.25;
        } else if !shows_several {
            sum = color;
            break;
        } else {
            // Each on its own, then: the first is next.
            is_one = false;
            shows_several = false;
            sum = vec3f(0.0);
            ray = NONE;
        }
    }
    textureStore(colors, pixel, vec4f(sum, 1.0));
}

// Threads share what there is to be shaded: where a few pixels show several places, the others need not wait for them.
// This suits things that take about as long to shade as each other.
@compute @workgroup_size(8, 8)
fn follow_four_samples(
    @builtin(workgroup_id) group: vec3u,
    @builtin(local_invocation_id) local: vec3u,
    @builtin(local_invocation_index) thread: u32,
) {
    let own_cell = followed_pixel(group, local);
    let own_pixel = own_cell + vec2u(0u, frame.first_row);
    var is_shown = is_in_picture(own_pixel) && all(own_cell < frame.cells);
    if is_shown {
        let ids = hits[hit_index(own_cell, 0u, 0u)];
        is_shown = is_followed(ids.x | ids.y | ids.z | ids.w);
        if is_shown {
            let_wait(thread, is_shaded_once(ids, own_cell, own_pixel));
        }
    }
    var done = 0u;
    loop {
        workgroupBarrier();
        if thread == 0u {
            count_so_far = atomicLoad(&shade_count);
        }
        let count = workgroupUniformLoad(&count_so_far);
        if done == count {
            break;
        }
        let place_in_queue = done + thread;
        // More may be added meanwhile.
        done = min(done + PIXELS, count);
        if place_in_queue < count {
            let item = to_shade[place_in_queue];
            let index = item / 8u;
            let is_one = item % 8u == ALL_SAMPLES;
            let ray = select(item % 8u, 0u, is_one);
            let cell = followed_pixel(group, vec3u(index % 8u, index / 8u, 0u));
            let corner = vec2f(cell + vec2u(0u, frame.first_row));
            let place = corner + select(four_samples[ray], vec2f(0.5), is_one);
            let triangle = triangle_of(hits[hit_index(cell, 0u, 0u)][ray]);
            shows_several = false;
            let side = select(0.5, 1.0, is_one);
            let color = followed_radiance(place, cell, ray, triangle, side, select(1u, RAYS, is_one));
            if is_one && shows_several {
                let_wait(index, false);
            } else {
                of_samples[index * RAYS + ray] = vec4f(color, side * side);
            }
        }
    }
    if is_shown {
        var sum = vec3f(0.0);
        for (var ray = 0u; ray < RAYS; ray++) {
            let light = of_samples[thread * RAYS + ray];
            sum += light.xyz * light.w;
        }
        textureStore(colors, own_pixel, vec4f(sum, 1.0));
    }
}
