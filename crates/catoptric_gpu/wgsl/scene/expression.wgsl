// Surfaces where an expression is zero: the twin of `surface/analytic/implicit`. Programs lie behind the objects.

// Steps of programs.
const VARIABLE = 0u;
const CONSTANT = 1u;
const ADD = 2u;
const SUBTRACT = 3u;
const MULTIPLY = 4u;
const DIVIDE = 5u;
const NEGATE = 6u;
const WHOLE_POWER = 7u;
const REAL_POWER = 8u;
const POWER = 9u;
const SQUARE_ROOT = 10u;
const EXPONENTIAL = 11u;
const SINE = 12u;
const COSINE = 13u;
const ABSOLUTE = 14u;
// The most values that wait at once.
const MOST_VALUES = 24u;

// A value with its derivatives: the second ones as xx, yy, zz, and yz, zx, xy.
struct Jet {
    value: f32,
    gradient: vec3f,
    curved: vec3f,
    twisted: vec3f,
}

fn jet_of(value: f32) -> Jet {
    return Jet(value, vec3f(0.0), vec3f(0.0), vec3f(0.0));
}

fn scaled_jet(a: Jet, factor: f32) -> Jet {
    return Jet(a.value * factor, a.gradient * factor, a.curved * factor, a.twisted * factor);
}

fn sum_of_jets(a: Jet, b: Jet) -> Jet {
    return Jet(a.value + b.value, a.gradient + b.gradient, a.curved + b.curved, a.twisted + b.twisted);
}

fn product_of_jets(a: Jet, b: Jet) -> Jet {
    return Jet(
        a.value * b.value,
        a.gradient * b.value + b.gradient * a.value,
        a.curved * b.value + b.curved * a.value + 2.0 * a.gradient * b.gradient,
        a.twisted * b.value + b.twisted * a.value + a.gradient.yzx * b.gradient.zxy + a.gradient.zxy * b.gradient.yzx,
    );
}

// A function of a jet, by its value and its first and second derivative.
fn function_of_jet(a: Jet, function: vec3f) -> Jet {
    return Jet(
        function.x,
        function.y * a.gradient,
        function.y * a.curved + function.z * a.gradient * a.gradient,
        function.y * a.twisted + function.z * a.gradient.yzx * a.gradient.zxy,
    );
}

fn whole_power(value: f32, exponent: i32) -> f32 {
    var result = 1.0;
    var factor = value;
    for (var rest = abs(exponent); rest > 0; rest = rest >> 1u) {
        result *= select(1.0, factor, (rest & 1) == 1);
        factor *= factor;
    }
    return select(result, 1.0 / result, exponent < 0);
}

fn whole_power_of_jet(a: Jet, exponent: i32) -> Jet {
    let n = f32(exponent);
    let first = select(n * whole_power(a.value, exponent - 1), 0.0, exponent == 0);
    let second = select(n * (n - 1.0) * whole_power(a.value, exponent - 2), 0.0, exponent == 0 || exponent == 1);
    return function_of_jet(a, vec3f(whole_power(a.value, exponent), first, second));
}

// A step that replaces the topmost value.
fn unary(operation: vec4u, a: Jet) -> Jet {
    let v = a.value;
    switch operation.x {
        case NEGATE: {
            return scaled_jet(a, -1.0);
        }
        case WHOLE_POWER: {
            return whole_power_of_jet(a, bitcast<i32>(operation.y));
        }
        case REAL_POWER: {
            let exponent = bitcast<f32>(operation.z);
            if v == 0.0 {
                return jet_of(select(1.0, 0.0, exponent > 0.0));
            }
            let power = pow(v, exponent);
            return function_of_jet(a, power * vec3f(1.0, exponent / v, exponent * (exponent - 1.0) / (v * v)));
        }
        case SQUARE_ROOT: {
            if v == 0.0 {
                return jet_of(0.0);
            }
            let root = sqrt(v);
            return function_of_jet(a, vec3f(root, 0.5 / root, -0.25 / (root * v)));
        }
        case EXPONENTIAL: {
            return function_of_jet(a, vec3f(exp(v)));
        }
        case SINE: {
            return function_of_jet(a, vec3f(sin(v), cos(v), -sin(v)));
        }
        case COSINE: {
            return function_of_jet(a, vec3f(cos(v), -sin(v), -cos(v)));
        }
        default: {
            return scaled_jet(a, select(1.0, -1.0, v < 0.0));
        }
    }
}

// A step that replaces the two topmost values.
fn binary(operation: u32, a: Jet, b: Jet) -> Jet {
    switch operation {
        case ADD: {
            return sum_of_jets(a, b);
        }
        case SUBTRACT: {
            return sum_of_jets(a, scaled_jet(b, -1.0));
        }
        case MULTIPLY: {
            return product_of_jets(a, b);
        }
        case DIVIDE: {
            let inverse = 1.0 / b.value;
            let reciprocal = vec3f(inverse, -inverse * inverse, 2.0 * inverse * inverse * inverse);
            return product_of_jets(a, function_of_jet(b, reciprocal));
        }
        default: {
            let inverse = 1.0 / a.value;
            let logarithm = function_of_jet(a, vec3f(log(a.value), inverse, -inverse * inverse));
            let exponent = product_of_jets(b, logarithm);
            return function_of_jet(exponent, vec3f(exp(exponent.value)));
        }
    }
}

fn is_known_jet(a: Jet) -> bool {
    let size = max(abs(a.gradient), max(abs(a.curved), abs(a.twisted)));
    return abs(a.value) < 3e38 && all(size < vec3f(3e38));
}

// The function of a surface at a place along its axes. Where it has no value there is no surface.
fn expression_taylor(exact: ExactSurface, at: vec3f) -> Taylor {
    let point = at * exact.curved.x;
    var values: array<Jet, MOST_VALUES>;
    var count = 0u;
    let first = u32(exact.twisted.x);
    for (var step = 0u; step < u32(exact.twisted.y); step++) {
        let operation = textureLoad(surface_table, row_of(first + step), 0);
        switch operation.x {
            case VARIABLE: {
                var axis = vec3f(0.0);
                axis[operation.y] = exact.curved.x;
                values[count] = Jet(point[operation.y], axis, vec3f(0.0), vec3f(0.0));
                count++;
            }
            case CONSTANT: {
                values[count] = jet_of(bitcast<f32>(operation.z));
                count++;
            }
            case ADD, SUBTRACT, MULTIPLY, DIVIDE, POWER: {
                count--;
                values[count - 1u] = binary(operation.x, values[count - 1u], values[count]);
            }
            default: {
                values[count - 1u] = unary(operation, values[count - 1u]);
            }
        }
    }
    let found = scaled_jet(values[0], exact.curved.y);
    if !is_known_jet(found) {
        return Taylor(1.0, vec3f(0.0), diagonal(vec3f(0.0)));
    }
    let mixed = found.twisted;
    return Taylor(
        found.value,
        found.gradient,
        mat3x3f(
            vec3f(found.curved.x, mixed.z, mixed.y),
            vec3f(mixed.z, found.curved.y, mixed.x),
            vec3f(mixed.y, mixed.x, found.curved.z),
        ),
    );
}
