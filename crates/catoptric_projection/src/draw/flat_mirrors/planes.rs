//! Finds the flat mirrors of a scene.

use catoptric_core::scene::{Role, Scene};
use catoptric_core::surface::AnalyticSurface;
use glam::{DAffine3, DMat3, DVec3};

/// A flat part of a reflector.
#[derive(Clone, Debug)]
pub(crate) struct MirrorPlane {
    /// The object that it is a part of.
    pub(crate) object: u32,
    /// Unit normal on the outer side.
    pub(crate) normal: DVec3,
    /// The plane is where `normal . x = offset`.
    pub(crate) offset: f64,
    /// True if only the inner side reflects.
    pub(crate) inside: bool,
    /// The triangles of the scene that lie in it.
    pub(crate) triangles: Vec<u32>,
}

/// The flat mirrors of a scene, and the numbers of triangles of other reflectors and lenses.
#[derive(Clone, Debug, Default)]
pub struct Mirrors {
    pub(crate) planes: Vec<MirrorPlane>,
    /// 1 + the index of the mirror of every triangle of the scene, 0 if it belongs to none.
    pub(crate) mirror_of_triangle: Vec<u32>,
    /// Triangles of curved reflectors; they are drawn black.
    pub(crate) curved_triangles: u64,
    /// Triangles of lenses; they are drawn black.
    pub(crate) lens_triangles: u64,
}

/// The most flat parts that an object is split into; with more it counts as a curved surface. Chosen, not measured.
const MAX_PLANES_OF_OBJECT: usize = 64;

/// Glass with no more faces is seen through in large pieces. Chosen, not measured.
const FEW_FACES: usize = 12;

/// The greatest distance of a mirror's corners from its plane, as a share of the object's size. Chosen, not measured.
const FLATNESS: f64 = 1e-5;

/// The greatest angle between shading normals and the plane's normal, in radians: less than a hundredth of a degree.
/// Chosen, not measured.
const NORMAL_TOLERANCE: f64 = 1.5e-4;

impl Mirrors {
    /// Finds all flat mirrors of a scene.
    pub fn find(scene: &Scene) -> Self {
        Self::find_among(scene, |_| true)
    }

    /// Finds the flat mirrors among some objects; other reflectors count as curved.
    pub(crate) fn find_among(scene: &Scene, is_among: impl Fn(u32) -> bool) -> Self {
        let mut mirrors = Self { mirror_of_triangle: vec![0; scene.triangles.len()], ..Self::default() };
        for (index, object) in scene.objects.iter().enumerate() {
            let count = u64::from(object.triangles.end - object.triangles.start);
            match scene.role_of(index as u32) {
                Role::Diffuse => {}
                Role::Lens => mirrors.lens_triangles += count,
                Role::Reflector | Role::Coated => {
                    match planes_of_object(scene, index as u32).filter(|_| is_among(index as u32)) {
                        Some(planes) => {
                            for plane in planes {
                                mirrors.planes.push(plane);
                                let number = mirrors.planes.len() as u32;
                                for &triangle in &mirrors.planes[number as usize - 1].triangles {
                                    mirrors.mirror_of_triangle[triangle as usize] = number;
                                }
                            }
                        }
                        None => mirrors.curved_triangles += count,
                    }
                }
            }
        }
        mirrors
    }
}

/// Returns true if an object has a few flat faces and nothing else.
pub(crate) fn has_flat_faces(scene: &Scene, object: u32) -> bool {
    planes_of_object(scene, object).is_some_and(|planes| planes.len() <= FEW_FACES)
}

/// The flat parts of an object, or none when it is curved.
fn planes_of_object(scene: &Scene, index: u32) -> Option<Vec<MirrorPlane>> {
    let object = &scene.objects[index as usize];
    match &object.surface {
        Some(placed) => match placed.surface {
            AnalyticSurface::Plane { .. } => {
                let normal = placed.world_from_surface.matrix3.y_axis.normalize();
                let offset = normal.dot(placed.world_from_surface.translation);
                let triangles = object.triangles.clone().collect();
                Some(vec![MirrorPlane { object: index, normal, offset, inside: object.inside, triangles }])
            }
            _ => None,
        },
        None => flat_parts(scene, index),
    }
}

fn flat_parts(scene: &Scene, index: u32) -> Option<Vec<MirrorPlane>> {
    let object = &scene.objects[index as usize];
    let tolerance = FLATNESS * object.bounds.diagonal() as f64;
    let mut planes: Vec<MirrorPlane> = Vec::new();
    for triangle in object.triangles.clone() {
        let vertices = scene.triangles[triangle as usize].map(|vertex| vertex as usize);
        let corners = vertices.map(|vertex| scene.positions[vertex].as_dvec3());
        let normals = vertices.map(|vertex| scene.normals[vertex].as_dvec3());
        let face = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let Some(face) = face.try_normalize() else { continue }; // a triangle without area is never seen
        let face = if face.dot(normals[0]) < 0.0 { -face } else { face };
        if normals.iter().any(|normal| normal.cross(face).length() > NORMAL_TOLERANCE) {
            return None;
        }
        let lies_in = |plane: &MirrorPlane| {
            plane.normal.dot(face) > 0.999
                && corners.iter().all(|corner| (plane.normal.dot(*corner) - plane.offset).abs() <= tolerance)
        };
        match planes.iter().position(lies_in) {
            Some(plane) => planes[plane].triangles.push(triangle),
            None if planes.len() == MAX_PLANES_OF_OBJECT => return None,
            None => planes.push(MirrorPlane {
                object: index,
                normal: face,
                offset: face.dot(corners[0]),
                inside: object.inside,
                triangles: vec![triangle],
            }),
        }
    }
    Some(planes)
}

impl MirrorPlane {
    /// Height above the plane, on its outer side.
    pub(crate) fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// The reflection about the plane.
    pub(crate) fn reflection(&self) -> DAffine3 {
        let n = self.normal;
        let matrix3 = DMat3::IDENTITY - DMat3::from_cols(n * n.x, n * n.y, n * n.z) * 2.0;
        DAffine3 { matrix3, translation: n * (2.0 * self.offset) }
    }
}
