//! Scenes in `.toml` files.

mod object;
mod optics;
mod reflector;

use catoptric_core::error::SceneError;
use catoptric_core::math::Aabb;
use catoptric_core::scene::model::{LocalTransform, Model};
use catoptric_core::scene::roles::{BlendRule, RoleRule};
use catoptric_core::scene::{Attenuation, Blend, PoseOptions, Projection, Role};
use catoptric_core::surface::AnalyticSurface;
use catoptric_scenes::import::load;
use catoptric_scenes::import::toml_scene::{SceneFile, parse};
use glam::{DVec3, Vec3};
use std::path::Path;

fn read(text: &str) -> Model {
    parse("scene.toml", text).unwrap().model
}

/// The error must name this line and this text.
#[track_caller]
fn assert_error(text: &str, line: usize, needle: &str) {
    let message = parse("scene.toml", text).unwrap_err().to_string();
    assert!(message.starts_with(&format!("scene.toml: line {line}: ")) && message.contains(needle), "{message}");
}

/// Each pair of lines and text behind a table must give an error in the last line with that text.
#[track_caller]
fn assert_errors_behind(table: &str, cases: &[(&str, &str)]) {
    for (lines, needle) in cases {
        let text = format!("{table}{lines}\n");
        assert_error(&text, text.lines().count(), needle);
    }
}

const FULL: &str = r#"
gltf = ["room.glb", "more/chairs.gltf"]
environment = "sky.hdr"
[camera]
eye = [0, 1, 4]
target = [0, 1, 0]
up = [0, 1, 0]
fov_deg = 40
[[reflector]]
name = "ball"
surface = "sphere"
center = [0, 1, 0]
radius = 0.5
tint = [0.95, 0.9, 0.85]
fresnel = [0.1, 0.9]
attenuation = { distance = 0.3, specularity = [0, 1] }
diffuse = [0.2, 0.3, 0.4]
[[reflector]]
name = "drop"
surface = "sphere"
center = [2, 1, 0]
radius = 0.25
ior = 1.5
[[reflector]]
name = "bowl"
surface = "sphere"
center = [4, 1, 0]
radius = 1e0
inside = true
[[reflector]]
name = "wall"
surface = "plane"
center = [0.1, 0, -2]
normal = [0, 0, 5]
size = [4, 2]
rotation_deg = [0, 90, 0]
[role]
"ball" = "reflector"
"chair*" = "diffuse"
[blend."b{all,owl}"]
fresnel = [0.5, 0.5]
[blend.wall.attenuation]
distance = 2
specularity = [0.25, 0.75]
[region]
min = [-1, 0, -1]
max = [1, 2, 1]
[method.sample_based_camera]
accuracy_px = 1.0
[method.reference]
"#;

const BY_HAND: &str = r#"
[[object]]
name = "ball"
shape = "sphere"
radius = 0.5
scale = [1, 2, 0.5]
checker = 0.1
checker_color = [0.1, 0.2, 0.3]
count = [3, 1, 2]
step = [1, 0, -2.5]
[[object]]
shape = "quad"
size = [4, 2]
normal = [0, 1, 1]
unlit = true
[[reflector]]
surface = "conic"
center = [0, 1, 0]
axis = [0, 0, 1]
radius = -1.5
conic_constant = -0.6
aperture_radius = 0.3
aperture_center = [0.1, 0.2]
count = 2
step = [1, 0, 0]
[[reflector]]
surface = "asphere"
center = [0, 1, 0]
radius = 2
coefficients = [0.1, -0.02, 3e-3]
aperture_size = [0.5, 0.4]
[[reflector]]
surface = "lens"
center = [3, 1, 0]
ior = 1.5
aperture_radius = 0.4
thickness = 0.3
front = { radius = 1.2 }
back = { radius = -0.9, conic_constant = -1 }
"#;

#[test]
fn everything_is_read() {
    let SceneFile { base, gltf, environment, variant, environment_edit, model, .. } =
        parse("scene.toml", FULL).unwrap();
    assert_eq!((base, gltf.len(), variant), (None, 2, None));
    assert_eq!(gltf, ["room.glb", "more/chairs.gltf"]);
    assert_eq!(environment.as_deref(), Some("sky.hdr"));
    assert_eq!((environment_edit.rotation_deg, environment_edit.strength), (None, None));
    let camera = &model.cameras[0];
    assert_eq!(camera.projection, Projection::Perspective { fov_y: 40f32.to_radians() });
    assert_eq!(camera.placement.translation, Vec3::new(0.0, 1.0, 4.0).into());
    let names: Vec<&str> = model.nodes.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["ball", "drop", "bowl", "wall"]);
    assert_eq!(model.materials[0].base_color.truncate(), Vec3::new(0.95, 0.9, 0.85));
    assert_eq!(
        model.materials.iter().map(|material| material.role).collect::<Vec<_>>(),
        [Role::Reflector, Role::Lens, Role::Reflector, Role::Reflector]
    );
    assert_eq!((model.materials[1].name.as_str(), model.materials[1].ior), ("drop", 1.5));
    let wall = model.nodes[3].analytic.as_ref().unwrap();
    assert_eq!(wall.surface, AnalyticSurface::Plane { half_width: 2.0, half_height: 1.0 });
    assert!(model.nodes[2].analytic.as_ref().unwrap().inside && !wall.inside);
    let LocalTransform::Rigid { rotation, translation } = model.nodes[3].local else { panic!("in single precision") };
    assert_eq!(translation, DVec3::new(0.1, 0.0, -2.0));
    assert!((rotation * DVec3::Y - DVec3::X).length() < 1e-12); // the normal, turned from z to x
    assert!((rotation * DVec3::X - DVec3::NEG_Z).length() < 1e-12);
    assert_eq!(model.roles.iter().map(RoleRule::pattern).collect::<Vec<_>>(), ["ball", "chair*"]);
    let fading = Attenuation { distance: 0.3, specularity: [0.0, 1.0] };
    let ball = Blend {
        fresnel: Some([0.1, 0.9]),
        attenuation: Some(fading),
        diffuse: Some(Vec3::new(0.2, 0.3, 0.4)),
        ..Blend::default()
    };
    assert_eq!(model.materials[0].blend, Some(ball));
    assert!(model.materials[1..].iter().all(|material| material.blend.is_none()));
    assert_eq!(model.blends.iter().map(BlendRule::pattern).collect::<Vec<_>>(), ["b{all,owl}", "wall"]);
    assert_eq!(model.region, Some(Aabb { min: Vec3::new(-1.0, 0.0, -1.0), max: Vec3::new(1.0, 2.0, 1.0) }));
    assert_eq!(model.method_settings["sample_based_camera"]["accuracy_px"].as_float(), Some(1.0));
    assert!(model.method_settings["reference"].is_empty());
}

#[test]
fn an_empty_file_is_an_empty_scene() {
    assert!(read("").nodes.is_empty());
    assert!(read("# nothing\n").pose(&PoseOptions::default()).is_ok());
}

#[test]
fn reflectors_become_objects() {
    let text = "[[reflector]]\nsurface = \"sphere\"\ncenter = [1, 2, 3]\nradius = 0.5\n";
    let scene = read(text).pose(&PoseOptions::default()).unwrap();
    assert_eq!(scene.objects[0].name, "reflector 0");
    assert!((scene.bounds.center() - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-4);
}

#[test]
fn errors_name_the_line() {
    assert_error("a = \n", 1, "TOML");
    assert_error("\n\n[camera\n", 3, "TOML");
    assert_error("\nsky = 1\n", 2, "sky: unknown key; known are: base, gltf, ");
    assert_error("gltf = \"room.glb\"\n", 1, "must be a list");
    assert_error("gltf = [\"room.glb\",\n\"room.obj\"]\n", 2, ".gltf");
    assert_error("gltf = [1]\n", 1, "gltf");
    assert_error("environment = \"sky.gif\"\n", 1, ".exr");
    assert_error("environment = 3\n", 1, "must be a text, not `3`");
    assert_error("camera = 3\n", 1, "camera: must be a table");
    assert_error("[camera]\neye = [0, 0, 0]\n", 1, "camera.target: missing");
    assert_error("[camera]\neye = [0, 0]\ntarget = [0, 0, 0]\n", 2, "camera.eye: must be 3 finite numbers");
    assert_error("[camera]\neye = [0, 0, nan]\ntarget = [0, 0, 0]\n", 2, "camera.eye");
    assert_error("[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 1]\n", 3, "is where the eye is");
    assert_error("[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nfov_deg = 180\n", 4, "0.01 to 179");
    assert_error("[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nfov = 40\n", 4, "camera.fov: unknown key");
    assert_error("[camera]\neye = [0, 0, 1]\ntarget = [0, 0, 0]\nup = [0, 0, 0]\n", 4, "must not be zero");
    assert_error("[camera]\neye = [0, 0, 1e30]\ntarget = [0, 0, 0]\n", 2, "from the origin");
    assert_error("[role]\nball = \"mirror\"\n", 2, "role.ball: must be \"reflector\", \"lens\" or \"diffuse\"");
    assert_error("[region]\nmin = [0, 0, 0]\nmax = [1, 0, 1]\n", 3, "greater than `min`");
    assert_error("[region]\nmin = [0, 0, 0]\n", 1, "region.max: missing");
    assert_error("[method]\nreference = 3\n", 2, "must be a table");
    assert_error("reflector = 3\n", 1, "[[reflector]]");
    assert_error("[reflector]\nsurface = \"sphere\"\n", 1, "[[reflector]]");
}

#[test]
fn errors_of_reflectors_name_the_line() {
    let ball = "[[reflector]]\nsurface = \"sphere\"\ncenter = [0, 0, 0]\n";
    let cases = [
        ("radius = 0", "a length must be"),
        ("radius = -1.5", "-1.5"),
        ("radius = inf", "must be a finite number, not `inf`"),
        ("radius = \"1\"", "must be a finite number, not the text \"1\""),
        ("radius = 1\ntint = [2, 0, 0]", "from 0 to 1"),
        ("radius = 1\nior = 0.05", "0.1 to 10"),
        ("radius = 1\nior = 1.5\ninside = true", "is for mirrors"),
        ("radius = 1\ninside = 1", "must be true or false"),
        ("radius = 1\nrotation_deg = [0, 0]", "3 finite numbers"),
        ("radius = 1\nsize = [1, 1]", "reflector.size: unknown key"),
        ("radius = 1\nradii = [1, 1, 1]", "reflector.radii: unknown key; known are: surface, name, center"),
    ];
    assert_errors_behind(ball, &cases);
    assert_error(ball, 1, "reflector.radius: missing");
    assert_error("\n[[reflector]]\nname = \"a\"\n", 2, "reflector.surface: missing");
    assert_error("[[reflector]]\nsurface = \"sphere\"\nradius = 1\n", 1, "reflector.center: missing");
    assert_error("[[reflector]]\nsurface = \"ball\"\n", 2, "supported are `plane`, `sphere`");
    let torus = "[[reflector]]\nsurface = \"torus\"\ncenter = [0, 0, 0]\nmajor_radius = 1\n";
    assert_error(torus, 1, "reflector.minor_radius: missing");
    assert_error(&format!("{torus}minor_radius = 1.5\n"), 5, "must be below `major_radius`");
    let vase = "[[reflector]]\nsurface = \"revolution\"\ncenter = [0, 0, 0]\nheight = 2\n";
    assert_error(&format!("{vase}profile = [1, 2, 3]\n"), 5, "must be 4 finite numbers");
    assert_error(&format!("{vase}profile = [0, 0, -1, 0.5]\n"), 5, "must not be negative");
    let blob = "[[reflector]]\nsurface = \"implicit\"\nbounds_min = [-1, -1, -1]\nbounds_max = [1, 1, 1]\n";
    assert_error(blob, 1, "reflector.expression: missing");
    assert_error(&format!("{blob}expression = \"x^2 + w\"\n"), 5, "character 7: unknown name `w`");
    assert_error(&format!("{blob}expression = \"sqrt(-4 - x^2)\"\n"), 5, "has no value");
    assert_error(&format!("{blob}expression = 3\n"), 5, "must be a text");
    let ball = read(&format!("{blob}expression = \"x^2 + y^2 + z^2 - 0.25\"\n"));
    assert_eq!(ball.nodes[0].analytic.as_ref().unwrap().surface.kind(), "implicit");
    let dish = "[[reflector]]\nsurface = \"quadric\"\ncenter = [0, 0, 0]\nbounds_min = [-1, 0, -1]\n";
    let bowl = "coefficients = [1, 0, 1, 0, 0, 0, 0, -1, 0, 0]\n";
    assert_error(&format!("{dish}{bowl}bounds_max = [1, 0, 1]\n"), 6, "must be above that of `bounds_min`");
    assert_error(&format!("{dish}coefficients = [0, 0, 0, 0, 0, 0, 0, 0, 0, 1]\nbounds_max = [1, 1, 1]\n"), 5, "0");
    let plane = "[[reflector]]\nsurface = \"plane\"\ncenter = [0, 0, 0]\n";
    assert_error(&format!("{plane}size = [1, 1]\n"), 1, "reflector.normal: missing");
    assert_error(&format!("{plane}normal = [0, 1, 0]\n"), 1, "reflector.size: missing");
    assert_error(&format!("{plane}normal = [0, 0, 0]\nsize = [1, 1]\n"), 4, "must not be zero");
    assert_error(&format!("{plane}normal = [0, 1, 0]\nsize = [1, 0]\n"), 5, "a length must be");
    let named = "[[reflector]]\nname = \"a\"\nsurface = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\n";
    assert_error(&format!("{named}{named}"), 6, "there is a reflector `a` already");
}

#[test]
fn blends_are_given_by_name_and_the_last_one_wins() {
    let ball = "[[reflector]]\nname = \"ball\"\nsurface = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\n";
    let blend_of = |text: &str| {
        let scene = read(&format!("{ball}{text}")).pose(&PoseOptions::default())?;
        Ok::<_, SceneError>(scene.material_of(0).blend)
    };
    let even = |weight| Some(Blend { fresnel: Some([weight; 2]), ..Blend::default() });
    assert_eq!(blend_of("").unwrap(), None);
    assert_eq!(blend_of("fresnel = [0.5, 0.5]\n").unwrap(), even(0.5));
    let rules = "fresnel = [0.5, 0.5]\n[blend.\"b*\"]\nfresnel = [0.25, 0.25]\n[blend.ball]\nfresnel = [0.75, 0.75]\n";
    assert_eq!(blend_of(rules).unwrap(), even(0.75));
    // Rules that match nothing, or no mirror, give a warning; unless this pose's own roles made them so.
    let problem = |text: &str| blend_of(text).unwrap_err().to_string();
    assert!(
        problem("[blend.bell]\nfresnel = [0, 1]\n")
            .contains("no node or material `bell` (did you mean `ball`?); there are: ball")
    );
    let glass = "[blend.ball]\nfresnel = [0, 1]\n[role]\nball = \"diffuse\"\n";
    assert!(problem(glass).contains("blend.ball: `ball` is not a mirror: give it the role \"reflector\""));
    let roles = vec![RoleRule::new("ball", Role::Lens, None).unwrap()];
    let scene = read(&format!("{ball}{rules}")).pose(&PoseOptions { roles, ..PoseOptions::default() }).unwrap();
    assert_eq!((scene.role_of(0), scene.material_of(0).blend), (Role::Lens, None));
}

#[test]
fn moves_and_looks_are_given_by_name() {
    let ball = "[[reflector]]\nname = \"ball\"\nsurface = \"sphere\"\ncenter = [0, 1, 0]\nradius = 1\n";
    let posed = |text: &str| read(&format!("{ball}{text}")).pose(&PoseOptions::default());
    let plain = posed("").unwrap();
    // Ways add up; the exact surface and its triangles go alike.
    let moved = posed("[move]\nball = [1, 0, -2]\n\"b*\" = [0, 0.5, 0]\n").unwrap();
    let by = Vec3::new(1.0, 0.5, -2.0);
    for (before, after) in plain.positions.iter().zip(&moved.positions) {
        assert!((*after - *before - by).length() < 1e-6);
    }
    let center = |scene: &catoptric_core::scene::Scene| {
        scene.objects[0].surface.as_ref().unwrap().world_from_surface.translation.as_vec3()
    };
    assert_eq!(center(&moved), center(&plain) + by);
    let looks = "[material.\"*\"]\ncolor = [0.5, 0.25, 1]\n[material.ball]\nroughness = 0.9\n";
    let scene = posed(looks).unwrap();
    // The last of several rules wins, whole.
    assert_eq!((scene.material_of(0).mirror_roughness, scene.material_of(0).base_color.x), (0.5, 1.0));
    let glass = posed("[role]\nball = \"lens\"\n[material.ball]\ncolor = [0.5, 0.25, 1]\nior = 1.7\n").unwrap();
    assert_eq!((glass.role_of(0), glass.material_of(0).ior), (Role::Lens, 1.7));
    assert_eq!(glass.material_of(0).base_color.truncate(), Vec3::new(0.5, 0.25, 1.0));
    let problem = |text: &str| posed(text).unwrap_err().to_string();
    assert!(
        problem("[move]\nbell = [1, 0, 0]\n")
            .contains("move.bell: there is no node `bell` (did you mean `ball`?); there are: ball")
    );
    assert!(problem("[material.bell]\nior = 2\n").contains("material.bell: there is no node or material `bell`"));
    assert_error("\n[move]\nball = 3\n", 3, "move.ball: must be a way");
    assert_error("[material.ball]\n", 1, "material.ball: says nothing");
    assert_error("[material.ball]\nroughness = 7\n", 1, "the roughness 7 is outside 0 to 1");
    assert_error("[material.ball]\ntint = [1, 1, 1]\n", 2, "material.ball.tint: unknown key");
}

#[test]
fn a_scene_can_change_another_one() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let base = "base = \"builtin:sphere_room\"\n[method.light_field]\npreset = \"full\"\n";
    write("room.toml", base);
    let text = "base = \"room.toml\"\n[camera]\neye = [0, 1, 3]\ntarget = [0, 1, 0]\n[move]\nsphere = [0.5, 0, 0]\n\
                [method.light_field]\ntransfer = \"stored\"\n";
    let model = load(&write("moved.toml", text)).unwrap();
    let plain = catoptric_scenes::builtin::parse("sphere_room").unwrap();
    let [scene, before] = [&model, &plain].map(|model| model.pose(&PoseOptions::default()).unwrap());
    assert_eq!(scene.positions.len(), before.positions.len());
    assert_eq!(scene.camera(None, 1.0).unwrap().world_from_camera.translation, glam::Vec3A::new(0.0, 1.0, 3.0));
    let ball = before.objects.iter().position(|object| object.name == "sphere").unwrap();
    let by = scene.objects[ball].bounds.min - before.objects[ball].bounds.min;
    assert!((by - Vec3::new(0.5, 0.0, 0.0)).length() < 1e-6, "{by}");
    assert_eq!(model.method_settings["light_field"].len(), 2);
    // A file that is its own base has an end.
    let own = write("own.toml", "base = \"own.toml\"\n");
    assert!(load(&own).unwrap_err().to_string().contains("are the base of each other"));
    let missing = load(&write("lost.toml", "\nbase = \"none.glb\"\n")).unwrap_err().to_string();
    assert!(missing.contains("line 2: base") && missing.contains("none.glb"), "{missing}");
}

#[test]
fn errors_of_blends_name_the_line() {
    let ball = "[[reflector]]\nsurface = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\n";
    let cases = [
        ("fresnel = [0.9, 0.2]", "reflector.fresnel: [0.9, 0.2]; must be [least, greatest]"),
        ("fresnel = [0.1, 1.2]", "0 <= least <= greatest <= 1"),
        ("fresnel = 0.5", "reflector.fresnel: must be 2 finite numbers"),
        ("attenuation = 3", "reflector.attenuation: must be a table"),
        ("attenuation = { distance = 1 }", "reflector.attenuation.specularity: missing"),
        ("attenuation = { specularity = [0, 1] }", "reflector.attenuation.distance: missing; needed is"),
        ("attenuation = { distance = 0, specularity = [0, 1] }", "a length must be"),
        ("attenuation = { distance = 1, specularity = [1, 0] }", "reflector.attenuation.specularity: [1.0, 0.0]"),
        ("attenuation = { distance = 1, specularity = [0, 1], near = 1 }", "near: unknown key; known are: distance"),
        ("diffuse = [0.5, 0.5, 0.5]", "reflector.diffuse: shows nowhere while all is reflection"),
        ("fresnel = [0, 1]\ndiffuse = [2, 0, 0]", "every number must be from 0 to 1"),
        ("ior = 1.5\nfresnel = [0, 1]", "reflector.fresnel: is for mirrors, not for lenses"),
    ];
    assert_errors_behind(ball, &cases);
    assert_error("blend = 3\n", 1, "blend: must be a table");
    assert_error("[blend]\nball = 3\n", 2, "blend.ball: must be a table");
    assert_error("\n[blend.ball]\n", 2, "blend.ball: says nothing; needed is `fresnel`, `attenuation` or");
    assert_error("[blend.ball]\nfresnel = [0, 1]\ntint = [1, 1, 1]\n", 3, "blend.ball.tint: unknown key");
    assert_error("[blend.\"b*\"]\nfresnel = [0, 7]\n", 2, "blend.b*.fresnel: [0.0, 7.0]");
}

#[test]
fn nesting_has_an_end() {
    for (open, close) in [("[", "]"), ("{a=", "}")] {
        let text = format!("gltf = {}{}\n", open.repeat(100_000), close.repeat(100_000));
        assert_error(&text, 1, "TOML");
    }
    let text = format!("[method]\n{}b = 1\n", "a.".repeat(100_000));
    assert!(parse("deep", &text).is_err());
    let text = format!("[{}b]\n", "a.".repeat(100_000));
    assert!(parse("deep", &text).is_err());
}

#[test]
fn mutated_scenes_never_panic() {
    const SYMBOLS: &[u8] = b"[]{}\"'=.,#-+e_0123456789\n ";
    let mut sound = 0;
    for iteration in 0..4000u64 {
        let mut random = catoptric_core::math::random::Stream::new(iteration);
        let mut below = |limit: usize| (random.next_unit() * limit as f32) as usize;
        let sample = if iteration % 2 == 0 { FULL } else { BY_HAND };
        let mut bytes = sample.as_bytes().to_vec();
        for _ in 0..1 + below(3) {
            let place = below(bytes.len());
            match below(4) {
                0 => bytes[place] = SYMBOLS[below(SYMBOLS.len())],
                1 => bytes[place] ^= 1 << below(8),
                2 => {
                    let end = (place + below(40)).min(bytes.len());
                    let piece = bytes[place..end].to_vec();
                    let to = below(bytes.len());
                    bytes.splice(to..to, piece);
                }
                _ => drop(bytes.drain(place..(place + below(20)).min(place + 1))),
            }
        }
        let Ok(text) = String::from_utf8(bytes) else { continue };
        if let Ok(scene) = parse("mutated", &text) {
            // Roles may name nothing here, which is an error of its own. Lenses take longer to tessellate.
            let is_posed = iteration % 2 == 0 || iteration % 200 == 1;
            sound += usize::from(is_posed && scene.model.pose(&PoseOptions::default()).is_ok());
            sound += 1;
        }
    }
    assert!(sound > 100, "only {sound}");
}

#[test]
fn files_are_found_beside_the_scene() {
    let folder = std::env::temp_dir().join(format!("catoptric_toml_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let scene = folder.join("scene.toml");
    std::fs::write(&scene, "gltf = [\"gone.glb\"]\n").unwrap();
    let message = load(&scene).unwrap_err().to_string();
    assert!(message.contains("gone.glb"), "{message}");
    let mut hdr = Vec::new();
    image::codecs::hdr::HdrEncoder::new(&mut hdr).encode(&[image::Rgb([1.0f32; 3]); 2], 2, 1).unwrap();
    std::fs::write(folder.join("sky.hdr"), hdr).unwrap();
    std::fs::write(&scene, "environment = \"sky.hdr\"\n").unwrap();
    assert_eq!(load(&scene).unwrap().environment.unwrap().name, "sky.hdr");
    std::fs::remove_dir_all(&folder).unwrap();
    let message = load(Path::new("scene.fbx")).unwrap_err().to_string();
    assert!(message.contains(".toml"), "{message}");
}

/// Environments, built-in ones and those of a base too, are turned and scaled.
#[test]
fn environments_are_turned_and_scaled() {
    let studio = catoptric_scenes::studio();
    let edit = "environment_rotation_deg = -90\nenvironment_strength = 0.5\n";
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("base.toml"), format!("environment = \"studio\"\n{edit}")).unwrap();
    std::fs::write(path("more.toml"), format!("base = \"base.toml\"\n{edit}")).unwrap();
    for (name, degrees, factor) in [("base.toml", -90.0f32, 0.5), ("more.toml", -180.0, 0.25)] {
        let sky = load(&path(name)).unwrap().environment.expect("it has one");
        let towards = Vec3::new(-0.9, 0.3, 0.4).normalize();
        let there = glam::Quat::from_rotation_y(degrees.to_radians()) * towards;
        let (before, after) = (studio.radiance(towards), sky.radiance(there));
        assert!((before * factor - after).length() < 1e-4, "{name}: {before}, {after}");
    }
    for (text, named) in [
        (edit, "line 1: environment_rotation_deg: there is no environment"),
        ("environment = 'sun'", "one of: studio, sky"),
        ("environment_strength = -1", "line 1: environment_strength: -1; allowed is 0"),
        ("environment_rotation_deg = 'north'", "environment_rotation_deg"),
    ] {
        std::fs::write(path("wrong.toml"), text).unwrap();
        let message = load(&path("wrong.toml")).unwrap_err().to_string();
        assert!(message.contains(named), "{message}");
    }
}

#[test]
fn lights_of_all_kinds() {
    use catoptric_core::scene::LightKind;
    let scene = read(
        "[[light]]\nkind = 'directional'\ndirection = [1, -2, 0]\nintensity = 3\ncolor = [1, 0.5, 0]\n\
         [[light]]\nkind = 'point'\nposition = [1, 2, 3]\nrange = 4\n\
         [[light]]\nkind = 'spot'\nposition = [0, 1, 0]\ndirection = [0, 0, 1]\nouter_angle_deg = 60\ninner_angle_deg \
         = 30\n",
    )
    .pose(&Default::default())
    .unwrap();
    let [sun, bulb, spot] = &scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!((sun.kind, sun.intensity), (LightKind::Directional, Vec3::new(3.0, 1.5, 0.0)));
    assert!((sun.direction - Vec3::new(1.0, -2.0, 0.0).normalize()).length() < 1e-6);
    assert_eq!((bulb.kind, bulb.position), (LightKind::Point { range: 4.0 }, Vec3::new(1.0, 2.0, 3.0)));
    assert!((spot.direction - Vec3::Z).length() < 1e-6, "straight against -z: {}", spot.direction);
    let LightKind::Spot { range, inner_cos, outer_cos } = spot.kind else { panic!("{:?}", spot.kind) };
    assert!(range == f32::INFINITY && (inner_cos - 0.75f32.sqrt()).abs() < 1e-6 && (outer_cos - 0.5).abs() < 1e-6);
}

#[test]
fn wrong_lights_name_the_line() {
    assert_error("\n[[light]]\nposition = [0, 0, 0]\n", 2, "kind");
    assert_error("[[light]]\nkind = 'lamp'\n", 2, "point");
    assert_error("[[light]]\nkind = 'point'\n", 1, "position");
    assert_error("[[light]]\nkind = 'point'\nposition = [0, 0, 0]\ndirection = [0, 0, 1]\n", 4, "has none");
    assert_error("[[light]]\nkind = 'directional'\ndirection = [0, 0, 1]\nintensity = -1\n", 4, "-1");
    assert_error("[[light]]\nkind = 'directional'\ndirection = [0, 0, 0]\n", 3, "zero");
    assert_error("[[light]]\nkind = 'directional'\ndirection = [0, 0, 1]\nhue = 1\n", 4, "hue");
}

#[test]
fn what_is_found_out_later_names_the_line() {
    let read = |text: &str| parse("scene.toml", text).unwrap().model;
    let ball = "[[reflector]]\nname = 'ball'\nsurface = 'sphere'\ncenter = [0, 0, 0]\nradius = 1\n";
    for rule in ["[role]\n'bal' = 'diffuse'\n", "[blend]\n[blend.bal]\nfresnel = [0.5, 0.5]\n"] {
        let model = read(&format!("{ball}{rule}"));
        let message = model.pose(&PoseOptions::default()).unwrap_err().to_string();
        assert!(
            message.starts_with("scene.toml: line 7: ")
                && message.contains("`bal` (did you mean `ball`?); there are: ball"),
            "{message}"
        );
    }
    let model = read("[method.reference]\nseed = 1\npaths = 'tree'\n");
    assert_eq!((model.lines["method.reference"], model.lines["method.reference.paths"]), (1, 3));
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    for (text, line, named) in [
        ("gltf = [\n\"gone.glb\"]\n", 2, "gone.glb"),
        ("\n\nenvironment = \"gone.hdr\"\n", 3, "gone.hdr"),
        ("gltf = [\"broken.gltf\"]\n", 1, "is no JSON at line 1"),
    ] {
        std::fs::write(folder.path().join("broken.gltf"), "nonsense").unwrap();
        std::fs::write(&scene, text).unwrap();
        let message = load(&scene).unwrap_err().to_string();
        assert!(message.contains(&format!("scene.toml: line {line}: ")) && message.contains(named), "{message}");
    }
}
