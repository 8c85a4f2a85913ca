//! Reflectors with the shapes of optics, against closed forms.

use super::super::{reflector, toml_model};
use catoptric_core::scene::enclosure::FaceSums;
use catoptric_core::scene::{PoseOptions, Scene};
use catoptric_core::surface::PlacedSurface;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

fn posed(text: &str) -> Scene {
    toml_model(text).unwrap().pose(&PoseOptions::default()).unwrap()
}

/// The exact surface of the reflector of a kind at the origin.
fn surface(kind: &str, lines: &str) -> PlacedSurface {
    let scene = reflector(kind, lines).unwrap().pose(&PoseOptions::default()).unwrap();
    scene.objects[0].surface.clone().unwrap()
}

/// Where a ray along -y meets the surface.
fn height(surface: &PlacedSurface, x: f64, z: f64) -> Option<f64> {
    let origin = Vec3::new(x as f32, 5.0, z as f32);
    surface.first_distance(origin, Vec3::NEG_Y, 0.0, 20.0).map(|distance| 5.0 - distance)
}

/// The distance from a point of the line on which a ray goes on after reflection.
#[track_caller]
fn miss(surface: &PlacedSurface, origin: DVec3, direction: DVec3, point: DVec3) -> f64 {
    let direction = direction.normalize();
    let hit = surface.intersect(origin.as_vec3(), direction.as_vec3(), 0.0, 1e3).unwrap();
    let at = origin + direction * surface.first_distance(origin.as_vec3(), direction.as_vec3(), 0.0, 1e3).unwrap();
    let normal = hit.normal.as_dvec3();
    let reflected = direction - normal * (2.0 * direction.dot(normal));
    (point - at).cross(reflected.normalize()).length()
}

fn sag(radius: f64, conic: f64, r: f64) -> f64 {
    let c = 1.0 / radius;
    c * r * r / (1.0 + (1.0 - (1.0 + conic) * c * c * r * r).sqrt())
}

#[test]
fn conics_have_their_sag_and_end_at_their_aperture() {
    for (radius, conic) in [(1.0, 0.0), (1.5, -1.0), (0.8, -3.0), (1.2, 0.4), (2.0, -0.5), (-0.9, -0.2), (-1.0, -4.0)] {
        let dish = surface("conic", &format!("radius = {radius}\nconic_constant = {conic}\naperture_radius = 0.5"));
        for (x, z) in [(0.0, 0.0), (0.1, 0.2), (-0.3, 0.3), (0.25, -0.43), (0.4999, 0.0)] {
            let (x, z) = (f64::from(x as f32), f64::from(z as f32));
            let expected = sag(radius, conic, x.hypot(z));
            assert!((height(&dish, x, z).unwrap() - expected).abs() < 1e-9, "{radius} {conic}: {x} {z}");
        }
        for angle in 0..24 {
            let (sin, cos) = (f64::from(angle) * PI / 12.0).sin_cos();
            assert!(height(&dish, 0.4999 * cos, 0.4999 * sin).is_some(), "{radius} {conic}: {angle}");
            assert!(height(&dish, 0.5001 * cos, 0.5001 * sin).is_none(), "{radius} {conic}: {angle}");
        }
    }
    // Half a sphere, whose rim stands upright, is there from pole to rim.
    let half = surface("conic", "radius = 1\nconic_constant = 0\naperture_radius = 1");
    assert!(height(&half, 0.0, 0.0).unwrap().abs() < 1e-12 && height(&half, 0.99, 0.0).is_some());
    let strip =
        surface("conic", "radius = 1\nconic_constant = -1\naperture_size = [0.4, 0.2]\naperture_center = [0.5, 0.1]");
    // To the right is x, up is -z where the axis is y.
    let inside = |x: f64, z: f64| height(&strip, x, z).is_some();
    assert!(inside(0.301, -0.001) && inside(0.699, -0.199) && !inside(0.299, -0.1) && !inside(0.5, 0.001));
    assert!((height(&strip, 0.5, -0.125).unwrap() - (0.25 + 0.015625) / 2.0).abs() < 1e-9);
}

#[test]
fn paraboloids_send_light_along_their_axis_through_the_focus() {
    let beyond =
        ["aperture_radius = 0.6", "aperture_size = [1, 0.6]", "aperture_radius = 0.3\naperture_center = [0.5, 0.4]"];
    for aperture in beyond {
        let dish = surface("paraboloid", &format!("radius = 1.6\n{aperture}"));
        let mut met = 0;
        for (x, z) in [(0.1, -0.1), (0.4, -0.25), (0.55, -0.2), (0.6, -0.6), (0.3, -0.5), (-0.2, 0.2)] {
            if height(&dish, x, z).is_some() {
                met += 1;
                assert!(miss(&dish, DVec3::new(x, 3.0, z), DVec3::NEG_Y, DVec3::Y * 0.8) < 1e-6, "{aperture}");
            }
        }
        assert!(met >= 3, "{aperture}");
    }
    // One that looks at +x, and one that bulges, whose focus lies behind it.
    let text = "[[reflector]]\nsurface = \"paraboloid\"\ncenter = [1, 2, 3]\naxis = [1, 0, 0]\n\
                radius = 2\naperture_radius = 1\n";
    let across = posed(text).objects[0].surface.clone().unwrap();
    assert!(miss(&across, DVec3::new(4.0, 2.5, 3.3), DVec3::NEG_X, DVec3::new(2.0, 2.0, 3.0)) < 1e-6);
    let bulge = surface("paraboloid", "radius = -2\naperture_radius = 1");
    assert!(miss(&bulge, DVec3::new(0.5, 3.0, 0.5), DVec3::NEG_Y, DVec3::NEG_Y) < 1e-6);
}

#[test]
fn ellipsoids_and_hyperboloids_join_their_foci() {
    // Vertex radius R and eccentricity e: the foci are R / (1 + e) and R / (1 - e) from the vertex.
    for (kind, eccentricity, aperture) in [
        ("ellipsoid of revolution", 0.6f64, "aperture_radius = 0.7"),
        ("ellipsoid of revolution", 0.6, "aperture_radius = 0.25\naperture_center = [0.5, 0]"),
        ("hyperboloid", 1.7, "aperture_radius = 0.7"),
        ("hyperboloid", 1.7, "aperture_radius = 0.3\naperture_center = [0, -0.4]"),
    ] {
        let conic = -eccentricity * eccentricity;
        let mirror = surface(kind, &format!("radius = 1\nconic_constant = {conic}\n{aperture}"));
        let foci = [1.0 / (1.0 + eccentricity), 1.0 / (1.0 - eccentricity)];
        for target in [(0.45, 0.05), (0.6, 0.1), (0.05, 0.45), (0.1, 0.3)] {
            let Some(y) = height(&mirror, target.0, target.1) else { continue };
            let from = DVec3::Y * foci[0];
            let towards = DVec3::new(target.0, y, target.1) - from;
            assert!(miss(&mirror, from, towards, DVec3::Y * foci[1]) < 2e-6, "{kind} {aperture}");
        }
        assert!(height(&mirror, 0.45, 0.05).is_some() || height(&mirror, 0.05, 0.45).is_some());
    }
}

#[test]
fn a_round_part_off_the_axis_of_a_paraboloid_is_round_along_the_axis() {
    let (middle, radius) = (DVec3::new(0.6, 0.0, -0.3), 0.25);
    let lines = "radius = 1.5\naperture_radius = 0.25\naperture_center = [0.6, 0.3]";
    let scene = reflector("paraboloid", lines).unwrap().pose(&PoseOptions::default()).unwrap();
    let across = |p: &Vec3| (p.as_dvec3() - middle).with_y(0.0).length();
    let widest = scene.positions.iter().map(across).fold(0.0, f64::max);
    assert!((widest - radius).abs() < 1e-5, "{widest}");
    let projected = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| scene.positions[corner as usize].as_dvec3());
        0.5 * (b - a).cross(c - a).y
    };
    let area: f64 = scene.triangles.iter().map(projected).sum();
    assert!((area / (PI * radius * radius) - 1.0).abs() < 1e-3, "{area}");
}

#[test]
fn aspheres_have_their_sag() {
    let asphere = surface(
        "asphere",
        "radius = 2\nconic_constant = -0.7\ncoefficients = [0.05, -0.02, 0.003, 0.0004]\naperture_radius = 0.8",
    );
    let plate = surface("asphere", "coefficients = [0.1]\naperture_size = [1, 1]");
    for r in [0.0f32, 0.2, 0.5, 0.79] {
        let r = f64::from(r);
        let terms = 0.05 * r.powi(4) - 0.02 * r.powi(6) + 0.003 * r.powi(8) + 0.0004 * r.powi(10);
        assert!((height(&asphere, r, 0.0).unwrap() - sag(2.0, -0.7, r) - terms).abs() < 1e-9, "{r}");
        let at = height(&plate, 0.0, -r);
        assert!(at.map_or(r > 0.5, |y| (y - 0.1 * r.powi(4)).abs() < 1e-9), "{r}: {at:?}");
    }
    assert!(height(&asphere, 0.5, 0.63).is_none());
}

#[test]
fn cylinders_and_cones_stand_about_their_middle() {
    let across = |surface: &PlacedSurface, y: f32| {
        surface.first_distance(Vec3::new(5.0, y, 0.0), Vec3::NEG_X, 0.0, 20.0).map(|distance| 5.0 - distance)
    };
    let cylinder = surface("cylinder", "radius = 0.5\nheight = 2");
    assert!((across(&cylinder, 0.99).unwrap() - 0.5).abs() < 1e-9 && across(&cylinder, 1.01).is_none());
    let cone = surface("axicon", "radius = 0.5\nheight = 2");
    assert!((across(&cone, 0.5).unwrap() - 0.125).abs() < 1e-9 && across(&cone, -1.01).is_none());
    let stump = surface("cone", "radius = 0.5\ntop_radius = 0.1\nheight = 1");
    assert!((across(&stump, 0.0).unwrap() - 0.3).abs() < 1e-9);
}

/// The sums over all faces of glass.
fn enclosed(text: &str) -> FaceSums {
    let scene = posed(text);
    (0..scene.objects.len() as u32).fold(FaceSums::default(), |sums, object| sums.with(&scene, object))
}

#[test]
fn lenses_are_closed_bodies_of_their_volume() {
    let glass = |lines: &str| format!("[[reflector]]\ncenter = [0, 0, 0]\nior = 1.5\n{lines}");
    let cap = |radius: f64, height: f64| PI * height * height * (radius - height / 3.0);
    let disk = PI * 0.25 * 0.25;
    let (half, quarter) = (sag(1.0, 0.0, 0.25), sag(0.5, 0.0, 0.25));
    let cases = [
        (
            "front = { radius = 1 }\nback = { radius = -0.5 }",
            disk * (0.2 - half - quarter) + cap(1.0, half) + cap(0.5, quarter),
        ),
        ("front = { radius = 1 }", disk * (0.2 - half) + cap(1.0, half)),
        ("back = { radius = 1 }", disk * (0.2 + half) - cap(1.0, half)),
        // A paraboloid's cap has half the volume of the cylinder around it.
        ("front = { radius = 1, conic_constant = -1 }", disk * (0.2 - 0.03125 + 0.03125 / 2.0)),
        ("front = { coefficients = [8] }", disk * (0.2 - 0.03125 + 0.03125 / 3.0 * 2.0)),
    ];
    for (faces, volume) in cases {
        let sums = enclosed(&glass(&format!("surface = \"lens\"\naperture_radius = 0.25\nthickness = 0.2\n{faces}\n")));
        assert!(!sums.are_open(), "{faces}: {sums:?}");
        assert!((sums.volume / 6.0 / volume - 1.0).abs() < 1e-3, "{faces}: {} {volume}", sums.volume / 6.0);
    }
    // By the height of its edge: sharp, and as high as above.
    for (edge, volume) in [(0.0, cap(1.0, half) * 2.0), (0.1, cap(1.0, half) * 2.0 + disk * 0.1)] {
        let faces = "front = { radius = 1 }\nback = { radius = -1 }";
        let sums = enclosed(&glass(&format!("surface = \"lens\"\naperture_radius = 0.25\nedge = {edge}\n{faces}\n")));
        assert!(!sums.are_open() && (sums.volume / 6.0 / volume - 1.0).abs() < 1e-3, "{edge}: {sums:?}");
    }
    let rod = enclosed(&glass("surface = \"cylinder\"\nradius = 0.25\nheight = 2\n"));
    assert!(!rod.are_open() && (rod.volume / 6.0 / (disk * 2.0) - 1.0).abs() < 1e-3);
    let axicon = enclosed(&glass("surface = \"axicon\"\nradius = 0.25\nheight = 0.3\n"));
    assert!(!axicon.are_open() && (axicon.volume / 6.0 / (disk * 0.1) - 1.0).abs() < 1e-3);
}

/// A ray's direction behind an interface from one index of refraction to another (Snell).
fn refracted(direction: DVec3, normal: DVec3, ratio: f64) -> DVec3 {
    let normal = if direction.dot(normal) > 0.0 { -normal } else { normal };
    let cosine = -direction.dot(normal);
    let inner = (1.0 - ratio * ratio * (1.0 - cosine * cosine)).sqrt();
    direction * ratio + normal * (ratio * cosine - inner)
}

/// Where a ray along the lens's axis y, at a distance from it, crosses it behind both faces.
fn crossing(scene: &Scene, ior: f64, distance: f64) -> f64 {
    let (mut at, mut direction) = (DVec3::new(distance, -5.0, 0.0), DVec3::Y);
    for (face, ratio) in [("lens front", 1.0 / ior), ("lens back", ior)] {
        let object = scene.objects.iter().find(|object| object.name == face).unwrap();
        let hit = object.surface.as_ref().unwrap();
        let hit = hit.intersect(at.as_vec3(), direction.as_vec3(), 0.0, 20.0).unwrap();
        (at, direction) = (hit.position.as_dvec3(), refracted(direction, hit.normal.as_dvec3(), ratio).normalize());
    }
    at.y - direction.y * at.x / direction.x
}

#[test]
fn lenses_focus_as_the_lensmaker_says() {
    let lens = |front: &str, back: &str| {
        let faces = format!("front = {{ {front} }}\nback = {{ {back} }}\n");
        posed(&format!(
            "[[reflector]]\nname = \"lens\"\nsurface = \"lens\"\ncenter = [0, 0, 0]\nior = 1.5\n\
             aperture_radius = 0.2\nthickness = 0.1\n{faces}"
        ))
    };
    // 1 / f = (n - 1) (1 / R1 - 1 / R2 + (n - 1) t / (n R1 R2)); the focus lies f (1 - (n - 1) t / (n R1)) behind the
    // back vertex.
    for (r1, r2) in [(1.0, -1.0), (0.8, -2.0), (0.6, 1.5)] {
        let power = 0.5 * (1.0 / r1 - 1.0 / r2 + 0.5 * 0.1 / (1.5 * r1 * r2));
        let expected = 0.05 + (1.0 - 0.5 * 0.1 / (1.5 * r1)) / power;
        let scene = lens(&format!("radius = {r1}"), &format!("radius = {r2}"));
        let found = crossing(&scene, 1.5, 0.01);
        assert!((found - expected).abs() < 2e-3 * expected, "{r1} {r2}: {found} {expected}");
    }
    // Behind a nearly flat front, a hyperboloid of constant -n^2 sends all rays through one focus, R / (n - 1) away.
    let scene = lens("radius = 1e6", "radius = -0.5, conic_constant = -2.25");
    for distance in [0.05, 0.1, 0.19] {
        let found = crossing(&scene, 1.5, distance);
        assert!((found - 1.05).abs() < 1e-4, "{distance}: {found}");
    }
}

#[test]
fn errors_of_the_shapes_of_optics_name_their_key() {
    let cases = [
        ("conic", "radius = 1\naperture_radius = 0.5", "conic_constant: missing"),
        ("conic", "conic_constant = 0\naperture_radius = 0.5", "radius: missing"),
        ("conic", "radius = 1\nconic_constant = 0\naperture_radius = 1.1", "the surface ends at 1"),
        ("conic", "radius = 0\nconic_constant = 0\naperture_radius = 1", "radius: 0; a length must be"),
        ("conic", "radius = 1\nconic_constant = 0", "aperture_radius: missing"),
        ("conic", "radius = 1\nconic_constant = 0\napperture_radius = 0.1", "did you mean `aperture_radius`?"),
        ("paraboloid", "radius = 1\nconic_constant = -1\naperture_radius = 1", "conic_constant: unknown key"),
        ("hyperboloid", "radius = 1\nconic_constant = 0\naperture_radius = 1", "-1000000 to -1"),
        ("asphere", "radius = 1\naperture_radius = 0.5", "coefficients: missing"),
        ("asphere", "coefficients = [1, -8]\naperture_radius = 0.5", "rise, or fall, all the way"),
        ("asphere", "coefficients = [1]\naperture_radius = 0.5\naperture_center = [1, 0]", "is for conics"),
        ("asphere", "coefficients = [1e9]\naperture_radius = 1e3", "aperture_radius: there is nothing to draw in it"),
        ("asphere", "coefficients = [1e300, -1e300]\naperture_size = [1e9, 1e9]", "aperture_size: there is nothing"),
        ("asphere", "coefficients = [1e300, -1e300]\naperture_radius = 1e9", "there is nothing"),
        ("cylinder", "radius = 1", "height: missing"),
        ("cone", "radius = 1\nheight = 1\ntop_radius = -1", "top_radius: -1; a length"),
        ("lens", "ior = 1.5\naperture_radius = 0.5\nthickness = 0.1\nfront = { radius = 0.6 }", "the faces meet"),
        ("lens", "aperture_radius = 0.5\nthickness = 0.1", "ior"),
        (
            "lens",
            "ior = 1.5\naperture_radius = 0.5\nthickness = 1\nfront = { radus = 0.6 }",
            "front.radus: unknown key (did you",
        ),
        ("lens", "ior = 1.5\naperture_radius = 0.5\nthickness = 1\nedge = 0.1", "edge: follows from"),
        ("lens", "ior = 1.5\naperture_radius = 0.5\nedge = -1", "edge: -1; must be"),
        ("lens", "ior = 1.5\naperture_radius = 0.5\nfront = { radius = 1 }", "thickness: missing"),
        ("parabloid", "", "did you mean `paraboloid`?"),
    ];
    for (kind, lines, needle) in cases {
        let message = reflector(kind, lines).unwrap_err();
        assert!(message.contains(needle), "{kind} {lines}: {message}");
    }
}
