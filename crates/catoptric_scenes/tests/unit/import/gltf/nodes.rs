use super::*;
use catoptric_core::scene::model::LocalTransform;
use catoptric_core::scene::{Attenuation, Blend, LightKind, Projection, Role};
use catoptric_core::surface::AnalyticSurface;
use glam::{DVec3, Vec3};

#[test]
fn the_tree_places_meshes() {
    let mut file = File::triangle();
    file.json["nodes"] = json!([
        { "name": "leaf", "mesh": 0, "translation": [0, 0, 1] },
        { "children": [0, 2], "scale": [-2, 2, 2] },
        { "mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 5,0,0,1] },
    ]);
    let scene = file.scene();
    assert_eq!(scene.objects.len(), 2);
    assert_eq!(scene.objects[0].name, "leaf");
    assert_eq!(scene.positions[0], Vec3::new(0.0, 0.0, 2.0));
    assert_eq!(scene.positions[3], Vec3::new(-10.0, 0.0, 0.0));
    // A mirrored triangle still shows its outer side to +z.
    assert!(scene.normals.iter().all(|normal| (*normal - Vec3::Z).length() < 1e-6), "{:?}", scene.normals);
}

#[test]
fn only_the_default_scene_is_drawn() {
    let mut file = File::triangle();
    file.push("nodes", json!({ "mesh": 0, "name": "other", "camera": 0 }));
    file.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } }));
    assert_eq!(file.scene().objects.len(), 2);
    file.json["scenes"] = json!([{ "nodes": [0] }, { "nodes": [1] }]);
    assert_eq!((file.scene().objects.len(), file.scene().cameras.len()), (1, 0));
    file.json["scene"] = json!(1);
    assert_eq!((file.scene().objects[0].name.as_str(), file.scene().cameras.len()), ("other", 1));
    file.json["scenes"] = json!([{}, {}]);
    assert_eq!(file.scene().objects.len(), 0);
}

#[test]
fn cycles_and_second_parents_are_errors() {
    let mut file = File::triangle();
    file.json["nodes"] = json!([{ "children": [1] }, { "children": [2] }, { "children": [0] }]);
    file.assert_error("own ancestor");
    file.json["nodes"] = json!([{ "children": [0] }]);
    file.assert_error("own ancestor");
    file.json["nodes"] = json!([{ "children": [2] }, { "children": [2] }, {}]);
    file.assert_error("nodes[1].children: nodes[2] is a child of nodes[0] too");
}

#[test]
fn very_deep_trees_are_read() {
    let mut file = File::triangle();
    let count = 50_000;
    let mut nodes: Vec<Value> = (0..count).map(|node| json!({ "children": [node + 1] })).collect();
    nodes.push(json!({ "mesh": 0, "translation": [1, 0, 0] }));
    file.json["nodes"] = nodes.into();
    file.json["scenes"] = json!([{ "nodes": [0] }]);
    assert_eq!(file.scene().positions[0], Vec3::X);
}

#[test]
fn instances_are_placed() {
    let mut file = File::triangle();
    let translations = file.accessor(F32, "VEC3", 2, &[0.0f32, 0.0, 0.0, 0.0, 0.0, 5.0]);
    let rotations = file.accessor(I8, "VEC4", 2, &[0i8, 0, 0, 127, 0, 0, 127, 0]);
    file.json["accessors"][rotations]["normalized"] = json!(true);
    let attributes = json!({ "TRANSLATION": translations, "ROTATION": rotations });
    file.json["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": attributes } });
    file.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let scene = file.scene();
    assert_eq!(scene.objects.len(), 2);
    assert!((scene.positions[4] - Vec3::new(-1.0, 0.0, 5.0)).length() < 1e-6, "{}", scene.positions[4]);
    file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(0);
    file.assert_error("nodes[0].extensions.EXT_mesh_gpu_instancing.attributes.SCALE: all attributes");
}

#[test]
fn cameras_are_named_like_their_nodes() {
    let mut file = File::new();
    file.push("cameras", json!({ "name": "lens", "type": "perspective", "perspective": { "yfov": 0.8, "znear": 1 } }));
    let orthographic = json!({ "xmag": 3, "ymag": 2, "znear": 0.1, "zfar": 10 });
    file.push("cameras", json!({ "name": "flat", "type": "orthographic", "orthographic": orthographic }));
    file.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 4 } }));
    file.json["nodes"] = json!([
        { "name": "front", "camera": 0, "translation": [0, 0, 3] },
        { "camera": 1 },
        { "camera": 2 },
    ]);
    let model = file.model();
    assert!(model.warnings[0].contains("cameras[2]"), "{:?}", model.warnings);
    let scene = file.scene();
    let names: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["front", "flat"]);
    // A camera can also be chosen by its own name, if the node has another.
    assert_eq!(scene.camera(Some("lens"), 1.0).unwrap().name, "front");
    assert_eq!(scene.cameras[0].projection, Projection::Perspective { fov_y: 0.8 });
    assert_eq!(scene.cameras[1].projection, Projection::Orthographic { half_height: 2.0 });
    assert_eq!(scene.cameras[0].world_from_camera.translation, Vec3::new(0.0, 0.0, 3.0).into());
}

#[test]
fn lights_of_all_kinds() {
    let mut file = File::triangle();
    let lights = json!([
        { "type": "directional", "color": [1, 0.5, 0], "intensity": 2 },
        { "type": "point", "range": 10 },
        { "type": "spot", "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.2 } },
    ]);
    file.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": lights } });
    for light in 0..3 {
        file.push("nodes", json!({ "extensions": { "KHR_lights_punctual": { "light": light } } }));
    }
    let lights = file.scene().lights;
    assert_eq!((lights[0].kind, lights[0].intensity), (LightKind::Directional, Vec3::new(2.0, 1.0, 0.0)));
    assert_eq!(lights[1].kind, LightKind::Point { range: 10.0 });
    let spot = LightKind::Spot { range: f32::INFINITY, inner_cos: 0.1f32.cos(), outer_cos: 0.2f32.cos() };
    assert_eq!((lights[2].kind, lights[2].direction), (spot, Vec3::NEG_Z));
    file.json["extensions"]["KHR_lights_punctual"]["lights"][2]["spot"]["innerConeAngle"] = json!(0.3);
    file.assert_error("lights[2].spot");
}

#[test]
fn extras_name_analytic_surfaces() {
    let mut file = File::triangle();
    file.push("materials", json!({ "name": "red", "pbrMetallicRoughness": { "baseColorFactor": [1, 0, 0, 1] } }));
    file.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    file.json["nodes"][0] = json!({
        "name": "ball", "mesh": 0, "translation": [1, 2, 3],
        "extras": { "catoptric": { "surface": "sphere", "radius": 2, "tint": [0.5, 1, 1] } },
    });
    let scene = file.scene();
    assert_eq!(scene.objects.len(), 1);
    let placed = scene.objects[0].surface.as_ref().unwrap();
    assert_eq!(placed.surface, AnalyticSurface::Sphere { radius: 2.0 });
    assert_eq!(placed.world_from_surface.translation, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!((scene.role_of(0), scene.material_of(0).name.as_str()), (Role::Reflector, "ball"));
    // On a mesh, without a colour of its own: the triangles' material stays.
    file.json["nodes"][0] = json!({ "mesh": 0 });
    file.json["meshes"][0]["extras"] = json!({ "catoptric": { "surface": "plane", "size": [2, 4] } });
    let scene = file.scene();
    assert_eq!((scene.role_of(0), scene.material_of(0).name.as_str()), (Role::Diffuse, "red"));
    let keys = json!({
        "surface": "sphere", "radius": 1, "tint": [1, 1, 1], "fresnel": [0.25, 1], "diffuse": [0, 0, 1],
        "attenuation": { "distance": 2, "specularity": [0, 1] },
    });
    file.json["meshes"][0]["extras"]["catoptric"] = keys;
    let attenuation = Some(Attenuation { distance: 2.0, specularity: [0.0, 1.0] });
    let blend = Blend { fresnel: Some([0.25, 1.0]), attenuation, diffuse: Some(Vec3::Z), ..Blend::default() };
    assert_eq!(file.scene().material_of(0).blend, Some(blend));
    // Over a material that is a mirror already.
    file.json["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = json!(1);
    file.json["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = json!(0);
    file.json["meshes"][0]["extras"]["catoptric"] = json!({ "surface": "sphere", "radius": 1, "fresnel": [0.5, 1] });
    let scene = file.scene();
    assert_eq!((scene.role_of(0), scene.material_of(0).name.as_str()), (Role::Reflector, "red"));
    assert_eq!(scene.material_of(0).blend.and_then(|blend| blend.fresnel), Some([0.5, 1.0]));
    file.json["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = json!(0);
    for (keys, needle) in [
        (json!({ "surface": "sphere", "radius": 1, "fresnel": [1, 0] }), "extras.catoptric.fresnel: [1.0, 0.0]"),
        (json!({ "surface": "sphere", "radius": 1, "fresnel": [0, 1] }), "fresnel: is for mirrors, but the material"),
        (json!({ "surface": "sphere", "radius": 1, "fresnel": 1 }), "fresnel: must be 2 finite numbers in brackets"),
        (json!({ "surface": "sphere", "radius": 1, "attenuation": 1 }), "attenuation: must be an object"),
        (json!({ "surface": "sphere", "radius": 1, "attenuation": { "distance": 1 } }), "specularity: missing"),
        (json!({ "surface": "sphere", "radius": 1, "attenuation": { "far": 1 } }), "unknown field `far`"),
        (json!({ "surface": "torus", "major_radius": 1 }), "meshes[0].extras.catoptric.minor_radius: missing"),
        (json!({ "surface": "ellipsoid", "radii": [1, 2] }), "extras.catoptric.radii: must be 3 finite numbers"),
        (json!({ "surface": "egg" }), "supported are `plane`, `sphere`"),
        (json!({ "surface": "sphere" }), "meshes[0].extras.catoptric.radius: missing"),
        (json!({ "surface": "sphere", "radius": 1, "centre": 2 }), "unknown field `centre`"),
        (json!({ "surface": "sphere", "radius": "1" }), "extras.catoptric.radius"),
        (json!({ "radius": 1 }), "extras.catoptric.surface: missing"),
        (json!(7), "must be an object"),
    ] {
        file.json["meshes"][0]["extras"]["catoptric"] = keys;
        file.assert_error(needle);
    }
}

#[test]
fn indices_that_point_nowhere_are_named() {
    let base = File::triangle();
    for (path, value, needle) in [
        ("/nodes/0", json!({ "mesh": 9 }), "nodes[0].mesh: there is no meshes[9]"),
        ("/nodes/0", json!({ "camera": 1 }), "nodes[0].camera"),
        ("/nodes/0", json!({ "skin": 1 }), "nodes[0].skin"),
        ("/nodes/0", json!({ "children": [4] }), "nodes[0].children"),
        ("/scenes", json!([{ "nodes": [3] }]), "scenes[0].nodes"),
        ("/scene", json!(2), "scene: there is no scenes[2]"),
        ("/skins", json!([{ "joints": [7] }]), "skins[0].joints"),
        ("/meshes/0/primitives/0", json!({ "attributes": { "POSITION": 5 } }), "attributes.POSITION"),
        ("/meshes/0/primitives/0", json!({ "attributes": { "POSITION": 0 }, "indices": 5 }), "indices"),
        ("/meshes/0/primitives/0", json!({ "attributes": { "POSITION": 0 }, "material": 0 }), "material"),
        ("/accessors/0/bufferView", json!(9), "accessors[0].bufferView"),
        ("/bufferViews/0/buffer", json!(9), "bufferViews[0].buffer"),
    ] {
        let mut file = base.clone();
        match file.json.pointer_mut(path) {
            Some(target) => *target = value,
            None => file.json[&path[1..]] = value,
        }
        file.assert_error(needle);
    }
}

#[test]
fn transforms_stay_animatable_unless_they_are_matrices() {
    let mut file = File::triangle();
    file.push("nodes", json!({ "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] }));
    let model = file.model();
    assert_eq!(model.nodes[0].local, LocalTransform::default());
    assert!(matches!(model.nodes[1].local, LocalTransform::Matrix(_)));
}
