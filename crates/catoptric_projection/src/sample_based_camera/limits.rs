//! Errors on built-in scenes.

use catoptric_engine::method::limits::{ErrorLimits, below, scene};

/// The limits.
pub(super) static LIMITS: ErrorLimits = ErrorLimits {
    settings: "edge_error_px = 2\npiece_px = 4\nwork = 150\nbeyond_work = 'coarse'",
    scenes: &[
        scene("sphere_room", [below(0.035, 0.048), below(0.035, 0.048)]),
        scene("two_spheres", [below(0.026, 0.049), below(0.039, 0.060)]),
        scene("vase", [below(0.058, 0.072), below(0.058, 0.073)]),
        scene("teapot", [below(0.277, 0.231), below(0.289, 0.224)]),
        scene("glass_sphere", [below(0.169, 0.134), below(0.488, 0.303)]),
        scene("glass_slab", [below(0.040, 0.051), below(0.112, 0.101)]),
        scene("lens", [below(0.031, 0.038), below(0.250, 0.206)]),
        scene("dish", [below(0.003, 0.016), below(0.003, 0.016)]),
        scene("planar_mirror", [below(0.003, 0.007), below(0.003, 0.009)]),
        scene("ellipsoid", [below(0.020, 0.041), below(0.020, 0.041)]),
        scene("torus", [below(0.127, 0.125), below(0.184, 0.141)]),
        scene("car", [below(0.086, 0.088), below(0.088, 0.093)]),
        scene("large_room", [below(0.057, 0.071), below(0.060, 0.071)]),
        scene("colonnade", [below(0.254, 0.172), below(0.885, 0.658)]),
        scene("highlights", [below(0.032, 0.099), below(0.032, 0.099)]),
        scene("brushed", [below(0.091, 0.085), below(0.108, 0.105)]),
        scene("rippled", [below(0.228, 0.153), below(0.237, 0.145)]),
        scene("workshop", [below(0.198, 0.155), below(0.183, 0.140)]),
    ],
};
