use super::*;
use catoptric_core::scene::PoseMemory;
use catoptric_core::scene::model::{ChannelValues, Interpolation};
use glam::Vec3;

fn animate(file: &mut File, node: usize, path: &str, interpolation: &str, input: usize, output: usize) {
    let channel = json!({ "sampler": 0, "target": { "node": node, "path": path } });
    let sampler = json!({ "input": input, "output": output, "interpolation": interpolation });
    file.push("animations", json!({ "channels": [channel], "samplers": [sampler] }));
}

fn at(file: &File, time: f32) -> Vec3 {
    file.model().pose(&PoseOptions { time, ..Default::default() }).unwrap().positions[1]
}

#[test]
fn translations_in_all_interpolations() {
    let animated = |interpolation: &str, numbers: &[f32]| {
        let mut file = File::triangle();
        let times = file.accessor(F32, "SCALAR", 2, &[1.0f32, 3.0]);
        let values = file.accessor(F32, "VEC3", numbers.len() / 3, numbers);
        animate(&mut file, 0, "translation", interpolation, times, values);
        file
    };
    let ends = [0.0, 0.0, 0.0, 0.0, 4.0, 0.0];
    let step = animated("STEP", &ends);
    assert_eq!((at(&step, 2.9), at(&step, 3.0)), (Vec3::X, Vec3::new(1.0, 4.0, 0.0)));
    let linear = animated("LINEAR", &ends);
    assert_eq!(
        (at(&linear, 0.0), at(&linear, 2.0), at(&linear, 9.0)),
        (Vec3::X, Vec3::new(1.0, 2.0, 0.0), Vec3::new(1.0, 4.0, 0.0))
    );
    // Value 0 with out-tangent 1, value 4 with in-tangent 3: h10 * 2 * 1 + h01 * 4 + h11 * 2 * 3 at the middle.
    let cubic = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 3.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0];
    let cubic = animated("CUBICSPLINE", &cubic);
    assert!((at(&cubic, 2.0) - Vec3::new(1.0, 0.25 + 2.0 - 0.75, 0.0)).length() < 1e-6);
}

#[test]
fn rotations_may_be_normalised_integers() {
    let mut file = File::triangle();
    let times = file.accessor(F32, "SCALAR", 1, &[0.0f32]);
    let quarter = (std::f32::consts::FRAC_1_SQRT_2 * 32767.0) as i16;
    let values = file.accessor(I16, "VEC4", 1, &[0i16, 0, quarter, quarter]);
    file.json["accessors"][values]["normalized"] = json!(true);
    animate(&mut file, 0, "rotation", "LINEAR", times, values);
    assert!((at(&file, 0.0) - Vec3::Y).length() < 1e-4);
}

#[test]
fn morph_targets_and_their_weights() {
    let mut file = File::triangle();
    let target = file.accessor(F32, "VEC3", 3, &[0.0f32, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": target }, { "POSITION": 0 }]);
    file.json["meshes"][0]["weights"] = json!([0.5, 0]);
    assert_eq!(file.scene().positions[1], Vec3::new(1.0, 0.0, 0.5));
    file.json["nodes"][0]["weights"] = json!([0, 2]);
    assert_eq!(file.scene().positions[1], Vec3::new(3.0, 0.0, 0.0));
    let times = file.accessor(F32, "SCALAR", 2, &[0.0f32, 1.0]);
    let weights = file.accessor(U8, "SCALAR", 4, &[0u8, 0, 255, 0]);
    file.json["accessors"][weights]["normalized"] = json!(true);
    animate(&mut file, 0, "weights", "LINEAR", times, weights);
    assert_eq!(at(&file, 0.25), Vec3::new(1.0, 0.0, 0.25));
    // Pieces of the pose before are used only where they hold.
    let (model, mut memory) = (file.model(), PoseMemory::default());
    for (time, height) in [(0.25, 0.25), (0.75, 0.75), (0.75, 0.75), (0.25, 0.25)] {
        let scene = model.pose_again(&PoseOptions { time, ..Default::default() }, &mut memory).unwrap();
        assert_eq!(scene.positions[1], Vec3::new(1.0, 0.0, height));
    }
    file.json["accessors"][weights]["count"] = json!(3);
    file.assert_warning("animations[0].channels[0].sampler.output: 3 values; 2 keys need 4");
}

#[test]
fn skins_bend_meshes() {
    let mut file = File::triangle();
    let joints = file.accessor(U8, "VEC4", 3, &[0u8, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = file.accessor(U8, "VEC4", 3, &[255u8, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0]);
    let mut matrices = [0.0f32; 32];
    for diagonal in 0..4 {
        matrices[diagonal * 5] = 1.0;
        matrices[16 + diagonal * 5] = 1.0;
    }
    matrices[16 + 14] = -7.0;
    let matrices = file.accessor(F32, "MAT4", 2, &matrices);
    let attributes = json!({ "POSITION": 0, "JOINTS_0": joints, "WEIGHTS_0": weights });
    file.json["meshes"][0]["primitives"][0]["attributes"] = attributes;
    file.json["nodes"] = json!([
        { "mesh": 0, "skin": 0, "translation": [100, 0, 0] },
        {},
        { "translation": [0, 0, 9] },
    ]);
    file.push("skins", json!({ "joints": [1, 2], "inverseBindMatrices": matrices }));
    file.json["scenes"] = json!([{ "nodes": [0] }]);
    // Joints outside the scene move vertices all the same; the node's own place does not count.
    assert_eq!(file.scene().positions, [Vec3::ZERO, Vec3::new(1.0, 0.0, 2.0), Vec3::new(0.0, 1.0, 2.0)]);
    file.json["skins"][0]["joints"] = json!([1, 2, 0]);
    file.assert_error("skins[0].inverseBindMatrices: 2 matrices for 3 joints");
    file.json["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": 0, "JOINTS_0": joints });
    file.json["skins"][0]["joints"] = json!([1, 2]);
    file.assert_error("attributes.WEIGHTS_0: missing");
}

#[test]
fn the_strongest_four_of_many_joints_are_kept() {
    let mut file = File::triangle();
    let joints = |file: &mut File, first: u16| {
        let numbers: Vec<u16> = (0..12).map(|number| first + number % 4).collect();
        file.accessor(U16, "VEC4", 3, &numbers)
    };
    let (low, high) = (joints(&mut file, 0), joints(&mut file, 4));
    let weak = file.accessor(F32, "VEC4", 3, &[0.3f32, 0.0, 0.1, 0.0].repeat(3));
    let strong = file.accessor(F32, "VEC4", 3, &[0.2f32, 0.25, 0.0, 0.15].repeat(3));
    file.json["meshes"][0]["primitives"][0]["attributes"] =
        json!({ "POSITION": 0, "JOINTS_0": low, "WEIGHTS_0": weak, "JOINTS_1": high, "WEIGHTS_1": strong });
    file.json["nodes"][0]["skin"] = json!(0);
    file.push("skins", json!({ "joints": [0] }));
    let model = file.model();
    let primitive = &model.meshes[0].primitives[0];
    assert_eq!((primitive.joints[2], primitive.weights[2]), ([0, 5, 4, 7], [0.3, 0.25, 0.2, 0.15]));
    assert!(model.warnings[0].contains("four strongest"));
}

#[test]
fn channels_that_move_nothing_are_left_out_with_a_warning() {
    let mut file = File::triangle();
    let times = file.accessor(F32, "SCALAR", 2, &[1.0f32, 0.5]);
    let values = file.accessor(F32, "VEC3", 2, &[0.0f32; 6]);
    animate(&mut file, 0, "translation", "LINEAR", times, values);
    let channel = json!({ "sampler": 0, "target": { "path": "pointer" } });
    file.json["animations"][0]["channels"].as_array_mut().unwrap().push(channel);
    let model = file.model();
    assert!(model.animations[0].channels.is_empty());
    for problem in ["do not rise", "moves no node"] {
        assert!(model.warnings.iter().any(|warning| warning.contains(problem)), "{problem}");
    }
    file.json["animations"][0]["samplers"][0]["interpolation"] = json!("CURVED");
    file.json["accessors"][times]["count"] = json!(1);
    file.assert_warning("sampler.interpolation: allowed are");
    file.json["animations"][0]["samplers"][0]["interpolation"] = json!(0);
    file.assert_warning("sampler.interpolation: allowed are");
}

#[test]
fn channels_keep_the_values_of_the_file() {
    let mut file = File::triangle();
    let times = file.accessor(F32, "SCALAR", 2, &[0.0f32, 0.5]);
    let values = file.accessor(F32, "VEC3", 2, &[1.0f32; 6]);
    animate(&mut file, 0, "scale", "STEP", times, values);
    let channel = file.model().animations[0].channels[0].clone();
    assert_eq!(
        (channel.node, channel.times.as_slice(), channel.interpolation),
        (0, &[0.0, 0.5][..], Interpolation::Step)
    );
    assert!(matches!(channel.values, ChannelValues::Scale(values) if values == [Vec3::ONE; 2]));
}
