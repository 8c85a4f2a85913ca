//! Wavefront `.obj` files and their materials.

use super::mutated;
use catoptric_core::error::SceneError;
use catoptric_core::scene::model::{Model, Primitive};
use catoptric_core::scene::{AlphaMode, Material, PoseOptions, Role};
use catoptric_scenes::import::obj::from_slice;
use catoptric_scenes::import::{LoadOptions, NoFiles, Resolver, load_with};
use glam::{DVec3, Vec2, Vec3};

const QUAD: &str = "o wall\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";

struct Materials(&'static str);

impl Resolver for Materials {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, SceneError> {
        if name.ends_with(".mtl") { Ok(self.0.into()) } else { NoFiles.read(name, limit) }
    }
}

#[test]
fn polygons_become_triangles_of_named_nodes() {
    let model = from_slice("quad.obj", QUAD.as_bytes(), &NoFiles).unwrap();
    assert_eq!(model.nodes[0].name, "wall");
    let primitive = &model.meshes[0].primitives[0];
    assert_eq!((primitive.triangles.len(), primitive.normals.len()), (2, 0));
    assert_eq!(primitive.uvs[0][0], Vec2::new(0.0, 1.0));
    let scene = model.pose(&PoseOptions::default()).unwrap();
    assert!(scene.normals.iter().all(|normal| (*normal - Vec3::Z).length() < 1e-6));
}

/// Coordinates of a national grid, which single precision rounds to half a metre.
#[test]
fn vertices_far_away_keep_their_digits() {
    let text = "v 431872.25 12.5 5810241.53\nv 431873.25 12.5 5810241.53\nv 431872.25 13.5 5810240.03\nf 1 2 3\n";
    let mut model = from_slice("far.obj", text.as_bytes(), &NoFiles).unwrap();
    model.move_near_origin().unwrap();
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    let scene = model.pose(&PoseOptions::default()).unwrap();
    let corners: Vec<DVec3> = scene.positions.iter().map(|corner| corner.as_dvec3() + scene.origin).collect();
    let expected =
        [[431_872.25, 12.5, 5_810_241.53], [431_873.25, 12.5, 5_810_241.53], [431_872.25, 13.5, 5_810_240.03]];
    for (corner, expected) in corners.iter().zip(expected) {
        assert!((*corner - DVec3::from_array(expected)).length() < 1e-6, "{corner} {expected:?}");
    }
}

#[test]
fn materials_are_diffuse() {
    let text = format!("mtllib a.mtl\nusemtl red\n{QUAD}");
    let model = from_slice("a.obj", text.as_bytes(), &Materials("newmtl red\nKd 0.5 0 0\nillum 5\n")).unwrap();
    assert_eq!(model.materials[0], Material::diffuse("red", Vec3::new(0.5, 0.0, 0.0)));
    assert_eq!(model.meshes[0].primitives[0].material, 0);
    let without = from_slice("a.obj", text.as_bytes(), &NoFiles).unwrap();
    assert!(without.warnings[0].contains("a.mtl"), "{:?}", without.warnings);
}

fn model(text: &str) -> Model {
    from_slice("a.obj", text.as_bytes(), &NoFiles).expect("a readable file")
}

fn area(model: &Model) -> f32 {
    let parts = model.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let of_part = |part: &Primitive| -> f32 {
        let triangles = part.triangles.iter().map(|triangle| triangle.map(|corner| part.positions[corner as usize]));
        triangles.map(|[a, b, c]| (b - a).cross(c - a).z / 2.0).sum()
    };
    parts.map(of_part).sum()
}

/// An L whose notch, and a dart whose hollow, a fan from the first corner would fill.
#[test]
fn concave_polygons_keep_their_area_and_sense_of_rotation() {
    let l = "v 0 0 0\nv 2 0 0\nv 2 0.4 0\nv 0.4 0.4 0\nv 0.4 2 0\nv 0 2 0\n";
    assert!((area(&model(&format!("{l}f 1 2 3 4 5 6\n"))) - 1.44).abs() < 1e-6);
    assert!((area(&model(&format!("{l}f 6 5 4 3 2 1\n"))) + 1.44).abs() < 1e-6);
    let dart = "v -1 1 0\nv 0 -1 0\nv 1 1 0\nv 0 0.2 0\nf 1 2 3 4\n";
    assert!((area(&model(dart)) - 1.2).abs() < 1e-6);
}

#[test]
fn one_broken_line_loses_one_line() {
    for (text, needle) in [
        ("v 0 0 0\nv 1 x 0\nv 1 0 0\nv 0 1 0\nf 1 3 4\nf 1 2 3\n", "line 2: `x` is no number"),
        ("v 0 0 0\nv 1 0\nv 1 0 0\nv 0 1 0\nf 1 3 4\nf 1 2 3\n", "line 2: 2 numbers, at least 3"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 9\n", "line 5: a face is left out"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 1 y\n", "line 5: `y` is no corner"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -5 1 1\nf 1 2 3\n", "line 4: `-5` is no corner"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1 2 3\n", "line 4: a face of fewer than three"),
    ] {
        let model = model(text);
        assert!(model.warnings.iter().any(|warning| warning.contains(needle)), "{text}: {:?}", model.warnings);
        assert!((area(&model) - 0.5).abs() < 1e-6, "{text}");
    }
    assert!(from_slice("a.obj", b"\x89PNG no scene at all", &NoFiles).is_err());
}

/// Each text is the same square, as other programs write it.
#[test]
fn many_ways_of_writing_are_read() {
    let plain = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n";
    let texts: [Vec<u8>; 9] = [
        format!("\u{feff}{plain}").into_bytes(),
        plain.replace('\n', "\r").into_bytes(),
        plain.replace('\n', "\r\n").into_bytes(),
        plain.replace("f 1 2", "f 1 2 \\\n").into_bytes(),
        plain.replace("v 1 1 0", "v 1 1 0 # top").into_bytes(),
        plain.replace("v 1 1 0", "v\t1,0 1,0 0,0").into_bytes(),
        [b"# gr\xfcn\n", plain.as_bytes()].concat(),
        plain.replace("f 1 2 3 4", "f -4 -3 -2 -1").into_bytes(),
        [b"\xff\xfe".to_vec(), plain.encode_utf16().flat_map(u16::to_le_bytes).collect()].concat(),
    ];
    for text in texts {
        let model = from_slice("a.obj", &text, &NoFiles).expect("a readable file");
        assert!((area(&model) - 4.0).abs() < 1e-6, "{}", String::from_utf8_lossy(&text));
        assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    }
}

/// Two walls of a roof in one smoothing group share the mean of their normals along the ridge.
#[test]
fn smoothing_groups_give_normals() {
    let roof = "v 0 0 0\nv 0 0 1\nv 1 1 0\nv 1 1 1\nv 2 0 0\nv 2 0 1\n";
    let smooth = model(&format!("{roof}s 1\nf 1 2 4 3\nf 3 4 6 5\n"));
    let part = &smooth.meshes[0].primitives[0];
    let ridge = part.positions.iter().position(|place| *place == Vec3::new(1.0, 1.0, 0.0)).expect("the ridge");
    assert!((part.normals[ridge] - Vec3::Y).length() < 1e-6, "{}", part.normals[ridge]);
    let flat = model(&format!("{roof}s off\nf 1 2 4 3\nf 3 4 6 5\n"));
    assert!(flat.meshes[0].primitives[0].normals.is_empty());
}

fn material(mtl: &'static str) -> Material {
    let text = format!("mtllib a.mtl\nusemtl m\n{QUAD}");
    let model = from_slice("a.obj", text.as_bytes(), &Materials(mtl)).expect("a readable file");
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    model.materials[0].clone()
}

#[test]
fn models_of_illumination_are_mirrors_and_glass() {
    let mirror = material("newmtl m\nKd 0 0 0\nKs 0.9 0.8 0.7\nNs 1000\nillum 3\n");
    assert_eq!((mirror.role, mirror.base_color.truncate()), (Role::Reflector, Vec3::new(0.9, 0.8, 0.7)));
    assert!(!mirror.schlick);
    assert_eq!(material("newmtl m\nPm 1\nPr 0\nKd 1 0 0\n").role, Role::Reflector);
    let glass = material("newmtl m\nKd 0 0 0\nNi 1.4\nd 0.05\nTf 0.5 1 1\nillum 7\n");
    assert_eq!((glass.role, glass.ior, glass.base_color.x), (Role::Lens, 1.4, 0.5));
    assert_eq!(material("newmtl m\nillum 6\n").ior, 1.5);
    let pane = material("newmtl m\nKd 1 0 0\nTr 0.75\n");
    assert_eq!((pane.alpha_mode, pane.base_color.w), (AlphaMode::Blend, 0.25));
    let polished = material("newmtl m\nKd 0.5 0 0\nKs 0.3 0.3 0.3\nillum 5\n");
    let facets = polished.microfacets.as_ref().expect("facets");
    assert_eq!((facets.specular, facets.specular_at_grazing, facets.roughness), (Vec3::splat(0.3), 1.0, 0.0));
    assert!(polished.lobes.is_some());
}

/// Phong's exponent and the width of facets: alpha^2 = 2 / (n + 2).
#[test]
fn highlights_have_the_width_of_their_exponent() {
    let facets = material("newmtl m\nKd 1 1 1\nKs 0.5 0.5 0.5\nNs 48\nillum 2\n").microfacets.expect("facets");
    assert!((facets.roughness.powi(4) - 0.04).abs() < 1e-6 && facets.specular == Vec3::splat(0.04));
    let of_blender = "# Blender 4.1 MTL File\nnewmtl m\nKa 1 1 1\nKd 1 1 1\nKs 0.5 0.5 0.5\nNs 250\nillum 3\n";
    let facets = material(of_blender).microfacets.expect("facets");
    assert_eq!((facets.roughness, facets.metallic), (0.5, 1.0));
}

#[test]
fn options_of_maps_move_and_scale_them() {
    let mtl = "newmtl m\nmap_Kd -o 0.25 0.5 0 -s 2 4 1 -clamp on my picture.png\n";
    let text = format!("mtllib a.mtl\nusemtl m\n{QUAD}");
    let model = from_slice("a.obj", text.as_bytes(), &WithPicture(mtl)).expect("a readable file");
    let binding = model.materials[0].base_texture.as_ref().expect("a texture");
    // The upper left corner of the quad: u 0, v 1 from the bottom.
    let place = binding.texture_from_uv.transform_point2(Vec2::ZERO);
    assert_eq!(place, Vec2::new(0.25, 1.0 - (1.0 * 4.0 + 0.5)));
    let gone = from_slice("a.obj", text.as_bytes(), &Materials(mtl)).expect("a readable file");
    assert!(gone.warnings[0].contains("my picture.png") && gone.materials[0].base_texture.is_none());
}

/// Materials, and for every other name a picture of one grey texel.
struct WithPicture(&'static str);

impl Resolver for WithPicture {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, SceneError> {
        if name.ends_with(".mtl") {
            return Materials(self.0).read(name, limit);
        }
        let mut bytes = std::io::Cursor::new(Vec::new());
        let picture = image::RgbaImage::from_pixel(1, 1, image::Rgba([128, 128, 128, 255]));
        picture.write_to(&mut bytes, image::ImageFormat::Png).expect("a picture in memory");
        Ok(bytes.into_inner())
    }
}

/// Numbers at vertices are what programs show; those of other ranges are bytes.
#[test]
fn vertex_colors_are_srgb() {
    for scale in [1.0, 255.0] {
        let color = 0.5 * scale;
        let text =
            format!("v 0 0 0 {scale} {color} 0\nv 1 0 0 {scale} {color} 0\nv 0 1 0 {scale} {color} 0\nf 1 2 3\n");
        let [red, green, blue, alpha] = model(&text).meshes[0].primitives[0].colors[0];
        // The curve of IEC 61966-2-1 at 0.5.
        assert!((green - 0.214_041).abs() < 1e-5 && [red, blue, alpha] == [1.0, 0.0, 1.0], "{green}");
    }
}

/// A scene opens what lies beside it and in the folder above, and no file of elsewhere unless that is wanted.
#[test]
fn names_do_not_lead_out_of_the_folder_above() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path().join("models/chair");
    std::fs::create_dir_all(&folder).expect("folders");
    let materials = "newmtl red\nKd 1 0 0\n";
    std::fs::write(root.path().join("outside.mtl"), materials).expect("a file");
    std::fs::write(root.path().join("models/above.mtl"), materials).expect("a file");
    let scene = folder.join("chair.obj");
    let color = |library: &str, allow_outside: bool| {
        std::fs::write(&scene, format!("mtllib {library}\nusemtl red\n{QUAD}")).expect("a file");
        let model =
            load_with(&scene, LoadOptions { allow_outside, ..LoadOptions::default() }).expect("a readable file");
        (model.materials[0].base_color.truncate(), model.warnings)
    };
    let red = Vec3::X;
    assert_eq!(color("../above.mtl", false), (red, vec![]));
    assert_eq!(color("..\\..\\outside.mtl", true), (red, vec![]));
    for library in ["../../outside.mtl", "..\\..\\outside.mtl", "x/../../../outside.mtl", "../x/../../outside.mtl"] {
        let (color, warnings) = color(library, false);
        assert!(color == Vec3::ONE && warnings[0].contains("--allow-outside"), "{library}: {warnings:?}");
    }
}

/// The bytes of every file.
struct Same(Vec<u8>);

impl Resolver for Same {
    fn read(&self, _name: &str, _limit: u64) -> Result<Vec<u8>, SceneError> {
        Ok(self.0.clone())
    }
}

/// Changed and lost bytes of materials make warnings at most, and numbers within their bounds.
#[test]
fn mutated_materials_never_panic() {
    let sound = b"newmtl m\nKd 0.5 0 0\nKs 1 1 1\nNs 30\nNi 1.5\nd 0.5\nTf 1 0 0\nillum 7\nPr 0.5\nPm 1\nPc 1\n\
                  map_Kd -s 2 2 1 -o 0 0 -bm 2 -clamp on a.png\nmap_d -imfchan l b.png\nbump -bm 1 c.png\n";
    let text = format!("mtllib a.mtl\nusemtl m\n{QUAD}");
    for iteration in 0..5000u64 {
        let model = from_slice("a.obj", text.as_bytes(), &Same(mutated(sound, iteration)))
            .expect("broken materials refuse no file");
        for material in &model.materials {
            assert!(material.base_color.is_finite() && (1.0..=10.0).contains(&material.ior), "{iteration}");
            let facets = material.microfacets.iter();
            assert!(facets.clone().all(|facets| (0.0..=1.0).contains(&facets.roughness)), "{iteration}");
            assert!(facets.clone().all(|facets| (0.0..=1.0).contains(&facets.metallic)), "{iteration}");
        }
    }
}
