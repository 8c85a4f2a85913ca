//! Errors on built-in scenes.

use catoptric_engine::method::limits::{ErrorLimits, below, scene};

/// The limits.
pub(super) static LIMITS: ErrorLimits = ErrorLimits {
    settings: "edge_error_px = 2\npiece_px = 4\nwork = 150\nbeyond_work = 'coarse'",
    scenes: &[
        scene("sphere_room", [below(0.018, 0.030), below(0.018, 0.030)]),
        scene("two_spheres", [below(0.016, 0.029), below(0.015, 0.029)]),
        scene("vase", [below(0.130, 0.118), below(0.128, 0.117)]),
        scene("teapot", [below(0.585, 0.485), below(0.641, 0.542)]),
        scene("glass_sphere", [below(0.017, 0.027), below(0.619, 0.492)]),
        scene("glass_slab", [below(0.034, 0.035), below(0.075, 0.059)]),
        scene("lens", [below(0.003, 0.006), below(0.265, 0.222)]),
        scene("dish", [below(0.013, 0.025), below(0.013, 0.025)]),
        scene("planar_mirror", [below(0.015, 0.021), below(0.013, 0.017)]),
        scene("ellipsoid", [below(0.006, 0.031), below(0.006, 0.031)]),
        scene("torus", [below(0.153, 0.139), below(0.138, 0.129)]),
        scene("car", [below(0.077, 0.071), below(0.090, 0.075)]),
        scene("large_room", [below(0.015, 0.035), below(0.015, 0.035)]),
        scene("colonnade", [below(0.528, 0.298), below(0.788, 0.442)]),
        scene("highlights", [below(0.026, 0.090), below(0.026, 0.090)]),
        scene("brushed", [below(0.077, 0.084), below(0.056, 0.081)]),
        scene("rippled", [below(0.229, 0.151), below(0.247, 0.147)]),
        scene("workshop", [below(0.114, 0.117), below(0.217, 0.167)]),
    ],
};
