// Lobes of mirrored directions.

// A lobe that covers less than this share of a cone across is not seen beside it.
const HIDDEN_LOBE = 0.3;

// The light that a place of a rough mirror reflects, before tint and Fresnel's share.
struct RoughLight {
    // The mean radiance over the lobe, times its weight against what the sharp ray shows.
    radiance: vec3f,
    weight: f32,
    // The share of light that facets neither mask nor shadow.
    share: f32,
    // The distance to the surface that is reflected sharply.
    distance: f32,
    // The width of the lobe's bright part, in pixels of the sharp reflection.
    width_px: f32,
    // The object that is seen there, and 1; 0: none is.
    object: u32,
}

// True for rough mirrors and coats: grids of rays tell what they reflect.
fn is_rough(object: u32) -> bool {
    return HAS_ROUGH && surface_of(object).mirror_roughness > 0.0;
}

// The angle across a lobe of mirrored directions where it is half as bright as in its middle.
fn lobe_width(alpha: f32) -> f32 {
    return 2.57 * alpha;
}

// The angle across a cone that stands for such a lobe.
fn cone_width(alpha: f32) -> f32 {
    return 2.82842712 * alpha;
}

// How much closer points of the disc are towards its rim, where few facets lean far: what is bright there counts.
const TAIL = 1.5;

// The first number of a point of the disc for an even one, and the part of the disc that it stands for, in units of
// their mean; a point alone is as likely everywhere.
fn facet_number(number: vec2f, count: f32) -> vec2f {
    let rest = 1.0 - number.x;
    return select(vec2f(1.0 - pow(rest, TAIL), TAIL * pow(rest, TAIL - 1.0)), vec2f(number.x, 1.0), count <= 1.0);
}

// One of `count` points that fill the unit square evenly (Hammersley 1960).
fn hammersley(index: u32, count: f32) -> vec2f {
    return vec2f((f32(index) + 0.5) / count, f32(reverseBits(index)) * (1.0 / 4294967296.0));
}
