//! The state of mirrors and lenses that projections depend on.

use super::rigid_motion::rigid_motion;
use catoptric_core::scene::{Role, Scene};
use catoptric_core::surface::PlacedSurface;
use glam::{DAffine3, Vec3};

/// Shapes and indices of refraction that projections depend on, beside the view.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MirrorState {
    objects: Vec<MirrorShape>,
    indices: Vec<f32>,
    object_count: usize,
}

/// One reflector or lens: its optical properties, and its surface, or its mesh where it has none.
#[derive(Clone, Debug, PartialEq)]
struct MirrorShape {
    object: u32,
    role: Role,
    inside: bool,
    surface: Option<PlacedSurface>,
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
}

/// Normals that differ by no more than this after a motion have moved with it.
const SAME_NORMAL: f32 = 1e-3;

impl MirrorShape {
    /// The motion from here to another state of the same object; `None` if it is no rotation and translation.
    fn motion_to(&self, now: &Self) -> Option<DAffine3> {
        let fixed = |shape: &Self| (shape.object, shape.role, shape.inside);
        if fixed(self) != fixed(now) {
            return None;
        }
        if self == now {
            return Some(DAffine3::IDENTITY);
        }
        match (&self.surface, &now.surface) {
            (Some(from), Some(to)) => {
                (from.surface == to.surface).then(|| to.world_from_surface * from.world_from_surface.inverse())
            }
            (None, None) => {
                let motion = rigid_motion(&self.positions, &now.positions)?;
                let turned = |normal: Vec3| motion.transform_vector3(normal.as_dvec3()).as_vec3();
                let mut normals = self.normals.iter().zip(&now.normals);
                let same = normals.all(|(from, to)| turned(*from).abs_diff_eq(*to, SAME_NORMAL));
                (same && self.normals.len() == now.normals.len()).then_some(motion)
            }
            _ => None,
        }
    }
}

impl MirrorState {
    /// The motion of every object to its present place, if these are the same mirrors and lenses and none has changed
    /// its shape. Entries of other objects mean nothing.
    pub(crate) fn motions_to(&self, now: &Self) -> Option<Vec<DAffine3>> {
        let fixed = |state: &Self| (state.objects.len(), state.object_count);
        if fixed(self) != fixed(now) || self.indices != now.indices {
            return None;
        }
        let mut motions = vec![DAffine3::IDENTITY; self.object_count];
        for (from, to) in self.objects.iter().zip(&now.objects) {
            *motions.get_mut(from.object as usize)? = from.motion_to(to)?;
        }
        Some(motions)
    }

    pub(crate) fn of(scene: &Scene) -> Self {
        let objects = scene.specular_objects();
        let kept = objects.iter().map(|&index| {
            let object = &scene.objects[index as usize];
            let vertices = object.vertices.start as usize..object.vertices.end as usize;
            let vertices = if object.surface.is_none() { vertices } else { 0..0 };
            MirrorShape {
                object: index,
                role: scene.role_of(index),
                inside: object.inside,
                surface: object.surface.clone(),
                positions: scene.positions[vertices.clone()].to_vec(),
                normals: scene.normals[vertices].to_vec(),
            }
        });
        let indices = objects.iter().map(|&index| scene.material_of(index).ior);
        Self { objects: kept.collect(), indices: indices.collect(), object_count: scene.objects.len() }
    }
}
