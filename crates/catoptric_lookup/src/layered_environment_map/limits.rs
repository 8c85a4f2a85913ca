//! Errors on built-in scenes.

use catoptric_engine::method::limits::{ErrorLimits, below, scene};

/// The limits.
pub(super) static LIMITS: ErrorLimits = ErrorLimits {
    settings: "size = 32\npicture_size = 64\ncapture_samples = 1\nviewpoint_count = 3",
    scenes: &[
        scene("sphere_room", [below(0.058, 0.076), below(0.058, 0.076)]),
        scene("two_spheres", [below(0.094, 0.070), below(0.076, 0.063)]),
        scene("vase", [below(0.058, 0.072), below(0.056, 0.071)]),
        scene("teapot", [below(0.111, 0.121), below(0.113, 0.129)]),
        scene("glass_sphere", [below(0.022, 0.036), below(0.407, 0.228)]),
        scene("glass_slab", [below(0.003, 0.024), below(0.165, 0.107)]),
        scene("lens", [below(0.003, 0.017), below(0.415, 0.183)]),
        scene("dish", [below(0.139, 0.098), below(0.139, 0.098)]),
        scene("planar_mirror", [below(0.153, 0.121), below(0.269, 0.180)]),
        scene("ellipsoid", [below(0.085, 0.071), below(0.085, 0.071)]),
        scene("torus", [below(0.036, 0.075), below(0.024, 0.074)]),
        scene("car", [below(0.127, 0.115), below(0.140, 0.100)]),
        scene("large_room", [below(0.063, 0.084), below(0.063, 0.084)]),
        scene("colonnade", [below(0.033, 0.045), below(0.096, 0.094)]),
        scene("highlights", [below(0.051, 0.131), below(0.051, 0.131)]),
        scene("brushed", [below(0.120, 0.101), below(0.075, 0.091)]),
        scene("rippled", [below(0.319, 0.228), below(0.320, 0.225)]),
        scene("workshop", [below(0.103, 0.119), below(0.122, 0.118)]),
    ],
};
