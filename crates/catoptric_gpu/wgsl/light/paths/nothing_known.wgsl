// Nothing is known of the light of rough mirrors: see `light/paths/follow.wgsl`.

fn known_light(object: u32, position: vec2f) -> RoughLight {
    var none: RoughLight;
    return none;
}
