//! Errors on built-in scenes.

use catoptric_engine::method::limits::{ErrorLimits, below, scene};

/// The limits.
pub(super) static LIMITS: ErrorLimits = ErrorLimits {
    settings: "edge_error_px = 2\npiece_px = 4\nwork = 150\nbeyond_work = 'coarse'",
    scenes: &[
        scene("sphere_room", [below(0.035, 0.046), below(0.035, 0.046)]),
        scene("two_spheres", [below(0.024, 0.036), below(0.045, 0.056)]),
        scene("vase", [below(0.056, 0.067), below(0.056, 0.067)]),
        scene("teapot", [below(0.280, 0.227), below(0.338, 0.294)]),
        scene("glass_sphere", [below(0.283, 0.216), below(0.526, 0.299)]),
        scene("glass_slab", [below(0.039, 0.058), below(0.258, 0.247)]),
        scene("lens", [below(0.046, 0.051), below(0.240, 0.208)]),
        scene("dish", [below(0.003, 0.014), below(0.003, 0.014)]),
        scene("planar_mirror", [below(0.005, 0.010), below(0.024, 0.026)]),
        scene("ellipsoid", [below(0.008, 0.033), below(0.008, 0.033)]),
        scene("torus", [below(0.044, 0.074), below(0.116, 0.122)]),
        scene("car", [below(0.040, 0.046), below(0.056, 0.059)]),
        scene("large_room", [below(0.037, 0.051), below(0.037, 0.051)]),
        scene("colonnade", [below(0.472, 0.411), below(0.438, 0.315)]),
        scene("highlights", [below(0.029, 0.091), below(0.029, 0.091)]),
        scene("brushed", [below(0.077, 0.085), below(0.118, 0.117)]),
        scene("rippled", [below(0.233, 0.155), below(0.257, 0.154)]),
        scene("workshop", [below(0.152, 0.122), below(0.175, 0.140)]),
    ],
};
