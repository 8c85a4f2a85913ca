// The last ray of a path, from what its rays have hit before.

//#include "scene/microfacets.wgsl"
//#include "scene/bumps.wgsl"
//#include "light/paths/bounce.wgsl"

struct PathRay {
    ray: Ray,
    own: OwnRule,
    is_active: bool,
}

// The hits of a cell's rays at each event of a path.
struct Chain {
    hits: array<vec4u, MOST_EVENTS>,
}

// Tiles follow paths of no more events.
const MOST_EVENTS = 2u;

fn chain_of(cell: vec2u) -> Chain {
    var result: Chain;
    for (var event = 0u; event < min(tiling.events, MOST_EVENTS); event++) {
        result.hits[event] = hits[hit_index(cell, event, tiling.kinds)];
    }
    return result;
}

fn path_ray(cell: vec2u, ray: u32, chain: Chain) -> PathRay {
    var result: PathRay;
    result.ray = eye_ray(position_of(cell, ray));
    result.is_active = true;
    // How rays differ from pixel to pixel says which texels of a map turn the normal.
    var change: RayDifferential;
    if HAS_TURNS {
        let side = select(0.5, frame.sample_side, SAMPLES == 1u);
        change = scaled_change(eye_ray_differential(position_of(cell, ray)), side);
    }
    for (var event = 0u; event < min(tiling.events, MOST_EVENTS); event++) {
        let hit = chain.hits[event][ray];
        let kind = (tiling.kinds >> event) & 1u;
        if !goes_on(hit, kind) {
            result.is_active = false;
            break;
        }
        let incoming = result.ray.direction;
        let met = turned_encounter(drawn_encounter(triangle_of(hit), result.ray, change, 1u, event)).met;
        let point = met.point;
        let at = facing(incoming, point.geometric_normal, point.normal);
        let object = point.object;
        result.ray = leaving_ray(kind, incoming, at, relative_index_of(object, at.outside), point);
        result.own = own_rule(object, kind, at.outside == (kind == REFLECT));
        if HAS_TURNS {
            var step: LightStep;
            step.facing = at;
            step.eta = relative_index_of(object, at.outside);
            change = change_after(step, kind, incoming, change, met);
        }
        let is_blind = at.outside && (surface_of(object).flags & INSIDE) != 0u;
        // Neither without direction nor not a number.
        if is_blind || !(dot(result.ray.direction, result.ray.direction) > 0.5) {
            result.is_active = false;
            break;
        }
    }
    return result;
}
