//! Errors on built-in scenes.

use catoptric_engine::method::limits::{ErrorLimits, below, scene};

/// The limits.
pub(super) static LIMITS: ErrorLimits = ErrorLimits {
    settings: "size = 64",
    scenes: &[
        scene("sphere_room", [below(0.308, 0.170), below(0.308, 0.170)]),
        scene("two_spheres", [below(0.361, 0.148), below(0.340, 0.130)]),
        scene("vase", [below(0.311, 0.177), below(0.306, 0.176)]),
        scene("teapot", [below(0.426, 0.268), below(0.405, 0.265)]),
        scene("glass_sphere", [below(1.000, 0.941), below(0.602, 0.236)]),
        scene("glass_slab", [below(1.000, 0.939), below(0.886, 0.752)]),
        scene("lens", [below(1.000, 0.691), below(0.935, 0.824)]),
        scene("dish", [below(0.296, 0.216), below(0.296, 0.216)]),
        scene("planar_mirror", [below(0.650, 0.466), below(0.655, 0.376)]),
        scene("ellipsoid", [below(0.178, 0.103), below(0.178, 0.103)]),
        scene("torus", [below(0.164, 0.159), below(0.095, 0.107)]),
        scene("car", [below(0.419, 0.284), below(0.412, 0.273)]),
        scene("large_room", [below(0.434, 0.163), below(0.434, 0.163)]),
        scene("colonnade", [below(0.999, 0.848), below(0.751, 0.432)]),
        scene("highlights", [below(0.102, 0.145), below(0.102, 0.145)]),
        scene("brushed", [below(0.236, 0.143), below(0.189, 0.128)]),
        scene("rippled", [below(0.767, 0.572), below(0.598, 0.384)]),
        scene("workshop", [below(0.259, 0.248), below(0.160, 0.195)]),
    ],
};
