// Surfaces given by formulas: the twin of `surface/analytic`.

//#include "scene/expression.wgsl"

// Kinds; the numbers of those that are not of second degree:
const SECOND_DEGREE = 0u;
// Radii of the ring and of the tube.
const TORUS = 1u;
// The profile's coefficients, highest first, and the height.
const REVOLUTION = 2u;
// The radii, and the exponents of the profiles along z and of the sections across it.
const SUPERQUADRIC = 3u;
// One over the size, and the factor on the expression; the first step of its program among the texels of objects, and
// how many there are.
const EXPRESSION = 4u;

// The reach of refinement, as a share of the surface's size.
const REFINEMENT_REACH = 0.02;
const MOST_STEPS = 12u;
// Steps that are a smaller share of the size are rounding.
const LAST_STEP = 1e-6;
// The same for expressions, whose terms may cancel.
const LAST_STEP_OF_EXPRESSIONS = 1e-5;
// Distances from an axis are no smaller, and neither are coordinates of superquadrics, as a share of the size.
const SOFTENING = 1e-7;

// A function, and its first and second derivatives.
struct Taylor {
    value: f32,
    gradient: vec3f,
    hessian: mat3x3f,
}

fn outer(a: vec3f, b: vec3f) -> mat3x3f {
    return mat3x3f(a * b.x, a * b.y, a * b.z);
}

fn diagonal(a: vec3f) -> mat3x3f {
    return mat3x3f(vec3f(a.x, 0.0, 0.0), vec3f(0.0, a.y, 0.0), vec3f(0.0, 0.0, a.z));
}

fn torus_taylor(exact: ExactSurface, at: vec3f) -> Taylor {
    let soft2 = pow(SOFTENING * exact.curved.x, 2.0);
    let axis_distance = sqrt(dot(at.xz, at.xz) + soft2);
    let outwards = vec3f(at.x, 0.0, at.z) / axis_distance;
    let beside = axis_distance - exact.curved.x;
    let distance = sqrt(beside * beside + at.y * at.y + soft2);
    let normal = (outwards * beside + vec3f(0.0, at.y, 0.0)) / distance;
    let around = diagonal(vec3f(1.0, 0.0, 1.0)) - outer(outwards, outwards);
    let across = outer(outwards, outwards) - outer(normal, normal) + diagonal(vec3f(0.0, 1.0, 0.0));
    return Taylor(
        distance - exact.curved.y,
        normal,
        around * (beside / (axis_distance * distance)) + across * (1.0 / distance),
    );
}

fn revolution_taylor(exact: ExactSurface, at: vec3f) -> Taylor {
    let profile = vec4f(exact.curved, exact.twisted.x);
    let inverse_height = 1.0 / exact.twisted.y;
    let s = at.y * inverse_height;
    let radius = ((profile.x * s + profile.y) * s + profile.z) * s + profile.w;
    let slope = ((3.0 * profile.x * s + 2.0 * profile.y) * s + profile.z) * inverse_height;
    let bend = (6.0 * profile.x * s + 2.0 * profile.y) * inverse_height * inverse_height;
    let axis_distance = sqrt(dot(at.xz, at.xz) + pow(SOFTENING * exact.size, 2.0));
    let outwards = vec3f(at.x, 0.0, at.z) / axis_distance;
    let around = (diagonal(vec3f(1.0, 0.0, 1.0)) - outer(outwards, outwards)) * (1.0 / axis_distance);
    return Taylor(
        axis_distance - radius,
        vec3f(outwards.x, -slope, outwards.z),
        around + diagonal(vec3f(0.0, -bend, 0.0)),
    );
}

// The mean (u^(1/e) + v^(1/e))^e of two positive numbers, with its derivatives.
struct Mean {
    value: f32,
    slope: vec2f,
    mixed: f32,
}

fn mean_of(exponent: f32, u: f32, v: f32) -> Mean {
    let power = 1.0 / exponent;
    let larger = max(u, v);
    let p = pow(u / larger, power);
    let q = pow(v / larger, power);
    let value = larger * pow(p + q, exponent);
    let slope = vec2f(value * p / ((p + q) * u), value * q / ((p + q) * v));
    return Mean(value, slope, (1.0 - power) * slope.x * slope.y / value);
}

fn superquadric_taylor(exact: ExactSurface, at: vec3f) -> Taylor {
    let radii = exact.curved;
    let unit = at / radii;
    let squares = unit * unit + SOFTENING * SOFTENING;
    let across = mean_of(exact.twisted.y, squares.x, squares.y);
    let all = mean_of(exact.twisted.x, across.value, squares.z);
    // Derivatives of the squares.
    let first = 2.0 * unit / radii;
    let second = 2.0 / (radii * radii);
    let gradient_across = vec3f(across.slope * first.xy, 0.0);
    let mixed = across.mixed * first.x * first.y;
    let xx = across.slope.x * second.x - squares.y / squares.x * across.mixed * first.x * first.x;
    let yy = across.slope.y * second.y - squares.x / squares.y * across.mixed * first.y * first.y;
    let hessian_across = mat3x3f(vec3f(xx, mixed, 0.0), vec3f(mixed, yy, 0.0), vec3f(0.0));
    let along_z = vec3f(0.0, 0.0, first.z);
    let gradient = gradient_across * all.slope.x + along_z * all.slope.y;
    let zz = all.slope.y * second.z - across.value / squares.z * all.mixed * first.z * first.z;
    let hessian = outer(gradient_across, gradient_across) * (-squares.z / across.value * all.mixed)
        + (outer(gradient_across, along_z) + outer(along_z, gradient_across)) * all.mixed
        + hessian_across * all.slope.x
        + diagonal(vec3f(0.0, 0.0, zz));
    let size = sqrt(all.value);
    let least = min(radii.x, min(radii.y, radii.z));
    return Taylor(
        least * (size - 1.0),
        gradient * (0.5 * least / size),
        (hessian - outer(gradient, gradient) * (0.5 / all.value)) * (0.5 * least / size),
    );
}

// The axes of a surface, as the columns of a matrix.
fn axes_of(exact: ExactSurface) -> mat3x3f {
    return mat3x3f(exact.axis_x, exact.axis_y, exact.axis_z);
}

// The function of a surface at a place from its centre, in world axes.
fn exact_taylor(exact: ExactSurface, relative: vec3f) -> Taylor {
    if !HAS_HIGHER_DEGREES || exact.kind == SECOND_DEGREE {
        let hessian = mat3x3f(
            vec3f(exact.curved.x, exact.twisted.z, exact.twisted.y),
            vec3f(exact.twisted.z, exact.curved.y, exact.twisted.x),
            vec3f(exact.twisted.y, exact.twisted.x, exact.curved.z),
        );
        let bent = hessian * relative;
        let value = exact.value + dot(exact.gradient, relative) + 0.5 * dot(relative, bent);
        return Taylor(value, exact.gradient + bent, hessian);
    }
    let axes = axes_of(exact);
    let at = relative * axes;
    var local: Taylor;
    switch exact.kind {
        case TORUS: {
            local = torus_taylor(exact, at);
        }
        case REVOLUTION: {
            local = revolution_taylor(exact, at);
        }
        case SUPERQUADRIC: {
            local = superquadric_taylor(exact, at);
        }
        default: {
            if HAS_EXPRESSIONS {
                local = expression_taylor(exact, at);
            }
        }
    }
    return Taylor(local.value, axes * local.gradient, axes * local.hessian * transpose(axes));
}

// The meeting of a ray with a surface near a distance; below 0: there is none. As `PlacedSurface::refine`.
fn refine(exact: ExactSurface, ray: Ray, start: f32) -> f32 {
    // From the point drawn: distances from the eye would cost digits.
    let relative = ray.origin + ray.direction * start - exact.center;
    let is_quadric = !HAS_HIGHER_DEGREES || exact.kind == SECOND_DEGREE;
    let last_step = select(LAST_STEP, LAST_STEP_OF_EXPRESSIONS, exact.kind == EXPRESSION) * exact.size;
    var along = 0.0;
    var is_met = false;
    // On surfaces of second degree the first step is exact.
    for (var step_number = 0u; step_number < select(MOST_STEPS, 1u, is_quadric) && !is_met; step_number++) {
        let taylor = exact_taylor(exact, relative + ray.direction * along);
        let slope = dot(taylor.gradient, ray.direction);
        let bend = dot(ray.direction, taylor.hessian * ray.direction);
        // The nearer root of the parabola, without cancellation; or where the ray comes nearest, from there once more.
        let discriminant = slope * slope - 2.0 * taylor.value * bend;
        let root = -2.0 * taylor.value / (slope + select(-1.0, 1.0, slope >= 0.0) * sqrt(max(discriminant, 0.0)));
        let step = select(-slope / bend, root, discriminant >= 0.0);
        along += step;
        if !(abs(along) <= REFINEMENT_REACH * exact.size) {
            return -1.0;
        }
        is_met = discriminant >= 0.0 && (is_quadric || abs(step) <= last_step);
    }
    let local = (relative + ray.direction * along) * axes_of(exact);
    let within = all(local >= exact.low) && all(local <= exact.high);
    return select(-1.0, start + along, is_met && within && start + along >= 0.0);
}
