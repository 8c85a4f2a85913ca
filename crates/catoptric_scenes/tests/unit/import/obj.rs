//! Wavefront `.obj` files and their materials.

use catoptric_core::error::SceneError;
use catoptric_core::scene::{Material, PoseOptions};
use catoptric_scenes::import::obj::from_slice;
use catoptric_scenes::import::{NoFiles, Resolver};
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

#[test]
fn faults_are_errors() {
    for (text, needle) in [
        ("v 0 0 0\nv 0 x 0\n", "line 2"),
        ("v 0 0\n", "line 1"),
        ("v 0 0 0\nf 1 2 3\n", "a.obj: geometry"),
        ("v 0 0 0\nf 1 1 y\n", "a.obj: geometry"),
        ("v 0 0 0\nf -5 1 1\n", "a.obj: geometry"),
    ] {
        let message = from_slice("a.obj", text.as_bytes(), &NoFiles).unwrap_err().to_string();
        assert!(message.contains(needle), "{text}: {message}");
    }
    assert!(from_slice("a.obj", b"v 0 0 \xff\n", &NoFiles).is_err());
    let text = format!("mtllib a.mtl\nusemtl a\n{QUAD}");
    let missing = from_slice("a.obj", text.as_bytes(), &Materials("newmtl a\nmap_Kd gone.png\n")).unwrap_err();
    assert!(missing.to_string().contains("gone.png"));
}
