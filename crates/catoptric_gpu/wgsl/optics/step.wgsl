// How light reflects and refracts: the twin of `optics/step`.

//#include "scene/microfacets.wgsl"

const MIN_SINE = 1e-3;
const REFLECT = 0u;
const TRANSMIT = 1u;

fn normalize_or(vector: vec3f, otherwise: vec3f) -> vec3f {
    let length2 = dot(vector, vector);
    return select(otherwise, vector * inverseSqrt(length2), length2 > 1e-36 && length2 < 1e37);
}

// Two axes of the plane across a unit vector (Duff et al. 2017).
fn axes_across(axis: vec3f) -> array<vec3f, 2> {
    let sign = select(1.0, -1.0, axis.z < 0.0);
    let a = -1.0 / (sign + axis.z);
    let b = axis.x * axis.y * a;
    return array<vec3f, 2>(
        vec3f(1.0 + sign * axis.x * axis.x * a, sign * b, -sign * axis.x),
        vec3f(b, sign + axis.y * axis.y * a, -axis.y),
    );
}

fn mirrored(incoming: vec3f, normal: vec3f) -> vec3f {
    return incoming - normal * (2.0 * dot(incoming, normal));
}

// The refracted direction, of unit length but for rounding; zero on total internal reflection.
fn refracted(incoming: vec3f, normal: vec3f, eta: f32) -> vec3f {
    let cos_in = -dot(incoming, normal);
    let sin2_out = eta * eta * max(1.0 - cos_in * cos_in, 0.0);
    if sin2_out >= 1.0 {
        return vec3f(0.0);
    }
    return incoming * eta + normal * (eta * cos_in - sqrt(1.0 - sin2_out));
}

fn reflected_change(incoming: vec3f, incoming_change: vec3f, normal: vec3f, normal_change: vec3f) -> vec3f {
    let cosine_change = dot(incoming_change, normal) + dot(incoming, normal_change);
    return incoming_change - (normal_change * dot(incoming, normal) + normal * cosine_change) * 2.0;
}

fn refracted_change(
    incoming: vec3f,
    incoming_change: vec3f,
    normal: vec3f,
    normal_change: vec3f,
    eta: f32,
) -> vec3f {
    let cos_in = -dot(incoming, normal);
    let cos_out = sqrt(max(1.0 - eta * eta * (1.0 - cos_in * cos_in), 1e-4));
    let cos_change = -(dot(incoming_change, normal) + dot(incoming, normal_change));
    let along_change = (eta - eta * eta * cos_in / cos_out) * cos_change;
    return incoming_change * eta + normal_change * (eta * cos_in - cos_out) + normal * along_change;
}

fn relative_index(ior: f32, outside: bool) -> f32 {
    return select(ior, 1.0 / ior, outside);
}

fn fresnel_dielectric(cosine: f32, eta: f32) -> f32 {
    let cos_in = clamp(cosine, 0.0, 1.0);
    let sin2_out = eta * eta * (1.0 - cos_in * cos_in);
    if sin2_out >= 1.0 {
        return 1.0;
    }
    let cos_out = sqrt(1.0 - sin2_out);
    let along = cos_in + eta * cos_out;
    let across = eta * cos_in + cos_out;
    // Grazing incidence between equal media: the limit of the formula.
    if along <= 0.0 || across <= 0.0 {
        return 1.0;
    }
    let parallel = (cos_in - eta * cos_out) / along;
    let perpendicular = (eta * cos_in - cos_out) / across;
    return clamp(0.5 * (parallel * parallel + perpendicular * perpendicular), 0.0, 1.0);
}

fn fresnel_schlick(normal_reflectance: vec3f, cos_in: f32) -> vec3f {
    return normal_reflectance + (1.0 - normal_reflectance) * grazing_share(clamp(cos_in, 0.0, 1.0));
}

fn transmittance(absorption: vec3f, distance: f32) -> vec3f {
    return exp(absorption * -max(distance, 0.0));
}

struct Facing {
    outside: bool,
    geometric: vec3f,
    normal: vec3f,
}

fn facing(direction: vec3f, geometric_normal: vec3f, shading_normal: vec3f) -> Facing {
    var result: Facing;
    result.outside = dot(direction, geometric_normal) <= 0.0;
    let sign = select(-1.0, 1.0, result.outside);
    result.geometric = geometric_normal * sign;
    result.normal = shading_normal * sign;
    let cosine = dot(direction, result.normal);
    if cosine > -MIN_SINE {
        result.normal = normalize_or(result.normal - direction * (cosine + MIN_SINE), result.geometric);
    }
    return result;
}

fn keep_on_side(direction: vec3f, normal: vec3f) -> vec3f {
    let sine = dot(direction, normal);
    if sine >= MIN_SINE {
        return direction;
    }
    return normalize_or(direction + normal * (MIN_SINE - sine), normal);
}

// Zero on total internal reflection.
fn outgoing(kind: u32, at: Facing, incoming: vec3f, eta: f32) -> vec3f {
    if kind == REFLECT {
        return keep_on_side(mirrored(incoming, at.normal), at.geometric);
    }
    let direction = refracted(incoming, at.normal, eta);
    if all(direction == vec3f(0.0)) {
        return direction;
    }
    return keep_on_side(normalize(direction), -at.geometric);
}

struct LightStep {
    facing: Facing,
    eta: f32,
    reflectance: f32,
    reflected: vec3f,
    transmitted: vec3f,
    scattered: f32,
    is_attenuated: bool,
}

fn attenuation_weight(surface: u32, distance: f32) -> f32 {
    let specularity = surface_of(surface).attenuation;
    let share = min(distance / surface_of(surface).attenuation_distance, 1.0);
    return specularity.y - (specularity.y - specularity.x) * (share * share);
}

// The step at a surface of a tint (of coats: the share that they cover).
fn light_step(surface: u32, tint: vec3f, at: Facing, direction: vec3f) -> LightStep {
    let cosine = -dot(direction, at.normal);
    let flags = surface_of(surface).flags;
    var step: LightStep;
    step.facing = at;
    step.eta = 1.0;
    switch surface_of(surface).role {
        case REFLECTOR: {
            let is_blind = at.outside && (flags & INSIDE) != 0u;
            if !is_blind {
                let ramp = (flags & RAMP) != 0u;
                step.reflected = tint;
                if (flags & SCHLICK) != 0u && !ramp {
                    step.reflected = fresnel_schlick(tint, cosine);
                }
                step.reflectance = 1.0;
                if (flags & BLEND) != 0u {
                    if ramp {
                        let weights = surface_of(surface).ramp;
                        step.reflectance = weights.x + (weights.y - weights.x) * min(cosine * cosine, 1.0);
                    }
                    step.reflected *= step.reflectance;
                    step.is_attenuated = (flags & ATTENUATION) != 0u;
                    let faintest = select(1.0, surface_of(surface).attenuation.x, step.is_attenuated);
                    step.scattered = 1.0 - step.reflectance * faintest;
                }
            }
        }
        case COATED: {
            step.reflectance = tint.x * fresnel_dielectric(cosine, 1.0 / surface_of(surface).ior);
            step.reflected = vec3f(step.reflectance);
            step.scattered = 1.0 - step.reflectance;
        }
        case LENS: {
            step.eta = relative_index(surface_of(surface).ior, at.outside);
            step.reflectance = fresnel_dielectric(cosine, step.eta);
            step.reflected = vec3f(step.reflectance);
            if step.reflectance < 1.0 {
                step.transmitted = tint * (1.0 - step.reflectance);
            }
        }
        default: {
            step.scattered = 1.0;
        }
    }
    return step;
}

fn direction_change(step: LightStep, kind: u32, incoming: vec3f, change: vec3f, outer_normal_change: vec3f) -> vec3f {
    let normal_change = outer_normal_change * select(-1.0, 1.0, step.facing.outside);
    if kind == REFLECT {
        return reflected_change(incoming, change, step.facing.normal, normal_change);
    }
    return refracted_change(incoming, change, step.facing.normal, normal_change, step.eta);
}
