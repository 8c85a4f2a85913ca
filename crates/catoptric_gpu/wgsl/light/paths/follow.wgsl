// All paths of a ray. The shader that includes this says what they meet (`hit_on_path`; `root_of_paths`: of the
// hierarchy that is traced), what lies beyond, by a path that ends there (`light_beyond`, `distance_beyond`), and what
// is known of the light of rough mirrors that are seen directly (`known_light`).

//#include "light/paths/paths.wgsl"

// A ray of a cell, at a position of the picture; it stands for a part of a pixel with such a side, and so many samples.
struct PictureRay {
    position: vec2f,
    cell: vec2u,
    ray: u32,
    side: f32,
    samples: u32,
    // Rays that leave the first surface which spreads light, and what chooses them.
    rays: f32,
    numbers: RayNumbers,
}

// Rays that leave a surface which spreads light and are still to be followed. Paths that began there have but one such
// child each: there is one surface at a time.
struct Waiting {
    spread: Spread,
    // Rays in all, how many have begun, and how many paths waited when they did.
    count: u32,
    begun: u32,
    paths: u32,
}

// Rays of a pixel that tell whether the light of lamps arrives over a lobe.
const RAYS_TO_LAMPS = 4u;

fn traced_hit(segment: Segment) -> u32 {
    return (nearest(root_of_paths(), segment.ray, 0.0, FAR, segment.own, 0u).triangle + 1u) | HIT_REFLECTS;
}

// The numbers that choose one of so many rays of a lobe.
fn number_of_lobe(place: PictureRay, index: u32, count: u32, ray: u32) -> vec2f {
    let numbers = place.numbers;
    let total = f32(count * numbers.step);
    return number_of(RayNumbers(numbers.moved + CHOICE[index], numbers.first, numbers.step, total), ray);
}

// The light from infinity over a lobe, as if nothing stood before it, beside lamps: by cones of a pattern, of which a
// place of the pixel has every so many-th, and as the lobe's rays find it. So many of both are given.
fn gathered_sky(
    lobes: SurfaceLobes,
    index: u32,
    incoming: vec3f,
    place: PictureRay,
    counts: vec2u,
) -> array<vec3f, 2> {
    let all = counts.x * place.numbers.step;
    var sums = array<vec3f, 2>(vec3f(0.0), vec3f(0.0));
    // One loop for both: compilers copy functions to each place that calls them.
    for (var part = 0u; part < counts.x + counts.y; part++) {
        let is_ray = part >= counts.x;
        var number = hammersley(part * place.numbers.step + place.numbers.first, f32(all));
        var weight = 1.0;
        if is_ray {
            number = number_of_lobe(place, index, counts.y, part - counts.x);
            let chosen = facet_number(number, f32(counts.y));
            number.x = chosen.x;
            weight = chosen.y;
        }
        let found = part_of_lobe(lobes, index, incoming, number, f32(select(all, counts.y, is_ray)));
        let width = found.width * select(OVERLAP, sqrt(weight), is_ray);
        let light = found.weight * sky_within(found, width, lobes.cones) * weight;
        sums[u32(is_ray)] += light / f32(select(counts.x, counts.y, is_ray));
    }
    return sums;
}

// The same of lobes, one after the other.
fn next_lobe_ray(waiting: ptr<function, Waiting>, place: PictureRay) -> Segment {
    var child: Segment;
    while (*waiting).begun < (*waiting).count {
        var number = (*waiting).begun;
        (*waiting).begun++;
        var index = 0u;
        var count = 0u;
        for (; index < LOBES; index++) {
            count = rays_of_lobe((*waiting).spread.lobes, index, (*waiting).spread.path.throughput, place.rays);
            if number < count {
                break;
            }
            number -= count;
        }
        let chosen = number_of_lobe(place, index, count, number);
        child = lobe_ray((*waiting).spread, index, chosen, f32(count), place.side);
        if carries_light(child) {
            return child;
        }
    }
    child.ray.direction = vec3f(0.0);
    return child;
}

// Where a path goes on by lobes of a surface: sharp ones, and the one that a single ray follows, wait with the paths,
// of which there are so many; the number of these afterwards, rays of the others, and light from infinity as if nothing
// stood before it.
struct Begun {
    count: u32,
    rays: u32,
    light: vec3f,
}

fn begin_lobes(
    waiting: ptr<function, array<Segment, MAX_ORDER>>,
    children: ptr<function, Children>,
    segment: Segment,
    place: PictureRay,
    paths: u32,
) -> Begun {
    var begun = Begun(paths, 0u, vec3f(0.0));
    let incoming = segment.ray.direction;
    let moved = moved_by(incoming, (*children).spread.met.point.position);
    if segment.is_single && (*children).spread.lobes.is_clear {
        // The one facet that such a ray meets says how much it reflects and how much passes it.
        let facet = part_of_lobe((*children).spread.lobes, OF_FACETS, incoming, moved.xy, 1.0).facet;
        for (var index = OF_FACETS; index <= OF_PASSING; index++) {
            let weight = lobe_weight((*children).spread.lobes, index, -dot(incoming, facet));
            (*children).spread.lobes.shares[index] = weight;
        }
    }
    let chosen = chosen_lobe((*children).spread.lobes, fract(moved.z + CHOICE.y));
    for (var index = 0u; index < LOBES; index++) {
        var lobes = (*children).spread.lobes;
        let throughput = (*children).spread.path.throughput;
        var is_followed = lobes.ways[index] == SHARP;
        var count = 0u;
        if segment.is_single {
            is_followed = index == chosen.index;
        } else {
            count = rays_of_lobe(lobes, index, throughput, place.rays);
            begun.rays += count;
        }
        var sky = vec3f(0.0);
        // The one facet of a single ray has chosen already whether it is reflected.
        let is_chosen = segment.is_single && lobes.is_clear && index != OF_COAT;
        let is_spread = lobes.ways[index] == SPREAD && (is_followed || count > 0u);
        if is_spread && sees_sky(lobes, index) {
            if is_chosen {
                sky = vec3f(1.0);
            } else if segment.is_single {
                sky = sky_over_lobe(lobes, index, incoming);
            } else {
                let share = min(largest(throughput * lobes.shares[index]), 1.0);
                let cones = cone_count(place.numbers.step, share);
                lobes.cones = min(f32(cones * place.numbers.step), MOST_CONES);
                let gathered = gathered_sky(lobes, index, incoming, place, vec2u(cones, count));
                begun.light += throughput * gathered[0];
                sky = min(gathered[0] / max(gathered[1], vec3f(1e-30)), vec3f(1e37));
                if lamp_count() > 0u {
                    let rays = RAYS_TO_LAMPS / place.numbers.step;
                    let first = f32(place.numbers.first * rays) + moved.w;
                    let numbers = fract((first + vec4f(0.0, 1.0, 2.0, 3.0)) / f32(RAYS_TO_LAMPS));
                    let lamps = light_of_lamps(lobes, index, incoming, numbers);
                    var arrives = vec3f(f32(rays));
                    if largest(throughput * lamps.light) >= MIN_THROUGHPUT {
                        arrives = vec3f(0.0);
                        for (var ray = 0u; ray < rays; ray++) {
                            let start = departing_ray(lamp_at(lamps.chosen[ray]).towards, (*children).spread.met.point);
                            arrives += light_through(frame.root, start, FAR);
                        }
                    }
                    begun.light += throughput * lamps.light * arrives / f32(rays);
                }
                (*children).spread.lobes.cones = lobes.cones;
            }
            (*children).spread.lobes.counts_sky[index] = true;
            (*children).spread.lobes.taken[index] = sky;
        }
        if is_followed {
            var child = lobe_ray((*children).spread, index, moved.xy, 1.0, place.side);
            let factor = select(1.0, chosen.factor, segment.is_single);
            child.throughput *= factor;
            child.counted *= factor;
            begun.light += child.counted;
            if carries_light(child) && begun.count < MAX_ORDER {
                (*waiting)[begun.count] = child;
                begun.count++;
            }
        }
    }
    return begun;
}

// The next of them that carries light; without direction if there are none.
fn next_ray(waiting: ptr<function, Waiting>, place: PictureRay) -> Segment {
    var child: Segment;
    let is_by_both = HAS_LENSES && (*waiting).spread.goes_on[TRANSMIT];
    if HAS_LOBES && (*waiting).spread.by == BY_LOBES {
        return next_lobe_ray(waiting, place);
    }
    while (*waiting).begun < (*waiting).count {
        let number = (*waiting).begun;
        (*waiting).begun++;
        let kind = select(REFLECT, number & 1u, is_by_both);
        if !(*waiting).spread.goes_on[kind] {
            continue;
        }
        let index = select(number, number >> 1u, is_by_both);
        child = spread_ray((*waiting).spread, index, place.rays, kind, place.numbers, place.side);
        if carries_light(child) {
            return child;
        }
    }
    child.ray.direction = vec3f(0.0);
    return child;
}

// The children of a path at a surface that spreads light; of a path that stands for a pixel, the rays wait.
fn begin_spread(children: ptr<function, Children>, segment: Segment, place: PictureRay, paths: u32) -> Waiting {
    var waiting: Waiting;
    let moved = moved_by(segment.ray.direction, (*children).spread.met.point.position);
    let numbers = RayNumbers(moved, 0u, 1u, 1.0);
    for (var kind = REFLECT; kind <= select(REFLECT, TRANSMIT, HAS_LENSES); kind++) {
        (*children).goes_on[kind] = segment.is_single && (*children).spread.goes_on[kind];
        if (*children).goes_on[kind] {
            let child = spread_ray((*children).spread, 0u, 1.0, kind, numbers, place.side);
            (*children).segments[kind] = child;
            (*children).goes_on[kind] = carries_light(child);
        }
    }
    if !segment.is_single {
        let kinds = select(1u, 2u, HAS_LENSES && (*children).spread.goes_on[TRANSMIT]);
        waiting = Waiting((*children).spread, kinds * u32(place.rays), 0u, paths);
    }
    return waiting;
}

// The light of a rough mirror that is known, and the path that goes on sharply: the twin of `RoughWalk`.
fn lit_by_known(children: ptr<function, Children>, known: RoughLight, is_all: bool) -> vec3f {
    let path = (*children).spread.path;
    let reflected = (*children).spread.step.reflected;
    var factor = path.throughput * known.share;
    var light = vec3f(0.0);
    if HAS_ATTENUATION && path.deferred != NONE {
        let weight = attenuation_weight(path.deferred, known.distance);
        light += settled(path, weight);
        factor *= weight;
    }
    // Where no ray is followed the mean is all of it, also beside places where its weight is 1.
    light += factor * reflected * known.radiance / select(1.0, max(known.weight, 0.5), is_all);
    var child = (*children).segments[REFLECT];
    child.throughput = factor * reflected * select(1.0 - known.weight, 0.0, is_all);
    child.deferred = NONE;
    child.is_single = true;
    // Textures are blurred by the lobe; what has edges is not.
    let widening = sqrt(1.0 + known.width_px * known.width_px);
    child.change.direction_dx *= widening;
    child.change.direction_dy *= widening;
    (*children).segments[REFLECT] = child;
    (*children).goes_on[REFLECT] = carries_light(child);
    return light;
}

// The radiance along a path that meets a triangle, by its hit.
fn light_along(first: Segment, first_hit: u32, place: PictureRay) -> vec3f {
    var segment = first;
    var hit = first_hit;
    var waiting: array<Segment, MAX_ORDER>;
    var count = 0u;
    var rays: Waiting;
    var sum = vec3f(0.0);
    loop {
        var children: Children;
        // Rays that tiles have not followed have no direction but for rounding: total internal reflection.
        let shown = select(triangle_of(hit), NONE, hit == UNRESOLVED);
        if shown != NONE {
            if HAS_LOBES {
                // Each way on of a surface with lobes may wait, and later events may leave a path each.
                let later = select(0u, frame.order - min(segment.order, frame.order), HAS_LENSES);
                segment.is_single = segment.is_single || count + LOBES + 1u + later > MAX_ORDER;
            }
            let last = segment.order >= frame.order || (hit & HIT_REFLECTS) == 0u;
            children = arrive(segment, shown, place.samples, last);
            sum += children.sum;
        } else if !(HAS_LOBES && segment.counts_sky) {
            var throughput = segment.throughput;
            if HAS_ATTENUATION && segment.deferred != NONE {
                let weight = attenuation_weight(segment.deferred, distance_beyond(segment));
                sum += settled(segment, weight);
                throughput *= weight;
            }
            sum += throughput * light_beyond(segment);
        }
        // Behind many veils and coats the last paths have no room: those that are left carry little.
        if HAS_LOBES && children.passes && count < MAX_ORDER {
            waiting[count] = children.passing;
            count++;
        }
        if HAS_LOBES && children.spread.by == BY_LOBES {
            let begun = begin_lobes(&waiting, &children, segment, place, count);
            count = begun.count;
            sum += begun.light;
            if begun.rays > 0u {
                rays = Waiting(children.spread, begun.rays, 0u, count);
            }
        } else if spreads_light() && children.spread.by != NO_SPREAD {
            var known: RoughLight;
            if HAS_ROUGH && segment.order == 0u {
                known = known_light(children.spread.met.point.object, place.position);
            }
            if known.object != 0u {
                sum += lit_by_known(&children, known, (hit & HIT_BLURRED) != 0u);
            } else {
                let begun = begin_spread(&children, segment, place, count);
                if begun.count > 0u {
                    rays = begun;
                }
            }
        }
        let is_at_end = !children.goes_on[REFLECT] && !(HAS_LENSES && children.goes_on[TRANSMIT]);
        if spreads_light() && is_at_end && rays.begun < rays.count && count == rays.paths {
            // No path of the last ray is left.
            let child = next_ray(&rays, place);
            children.goes_on[REFLECT] = any(child.ray.direction != vec3f(0.0));
            children.segments[REFLECT] = child;
        }
        if children.goes_on[REFLECT] {
            segment = children.segments[REFLECT];
            // Each event on the way has left one at most.
            if HAS_LENSES && children.goes_on[TRANSMIT] && count < MAX_ORDER {
                waiting[count] = children.segments[TRANSMIT];
                count++;
            }
        } else if HAS_LENSES && children.goes_on[TRANSMIT] {
            segment = children.segments[TRANSMIT];
        } else if (HAS_LENSES || HAS_LOBES) && count > 0u {
            count--;
            segment = waiting[count];
        } else {
            break;
        }
        hit = hit_on_path(segment, place);
        if shows_several {
            break;
        }
    }
    return sum;
}
