//! Scenes that lie far from their file's origin.

use super::super::model::Model;
use crate::error::SceneError;
use glam::DVec3;

/// Scenes are far from an origin that is so many times their size away.
const FAR: f64 = 32.0;

/// Coordinates of meshes are rounded coarsely where the step between numbers is larger than this share of the scene.
const COARSE_STEP: f64 = 1e-5;

impl Model {
    /// Has scenes lie about their own origin where they are far from the file's: single precision would round their
    /// places, and what lies between them. What is rounded in the file's meshes already is said.
    ///
    /// # Errors
    /// As [`Self::pose`](Self::pose), for nodes that are wrong.
    pub fn move_near_origin(&mut self) -> Result<(), SceneError> {
        let worlds = self.world_transforms(&self.animated(0.0)?)?;
        let (mut low, mut high, mut largest) = (DVec3::INFINITY, DVec3::NEG_INFINITY, 0.0f64);
        let mut add = |point: DVec3| {
            if point.is_finite() {
                (low, high) = (low.min(point), high.max(point));
            }
        };
        for (node, world) in self.nodes.iter().zip(&worlds) {
            if node.analytic.is_some() {
                add(world.translation);
            }
            let Some(mesh) = node.mesh.and_then(|mesh| self.meshes.get(mesh)) else { continue };
            if let Some(skin) = node.skin.and_then(|skin| self.skins.get(skin)) {
                let joints = skin.joints.iter().filter_map(|joint| worlds.get(*joint));
                joints.for_each(|joint| add(joint.translation));
                continue;
            }
            for position in mesh.primitives.iter().flat_map(|primitive| &primitive.positions) {
                add(world.transform_point3(position.as_dvec3()));
                if position.is_finite() {
                    largest = largest.max(f64::from(position.abs().max_element()));
                }
            }
        }
        let (center, size) = ((low + high) * 0.5, (high - low).length());
        if !(size > 0.0 && size.is_finite() && center.abs().max_element() > FAR * size) {
            return Ok(());
        }
        // A round number, so that coordinates stay readable.
        let mut step = 1.0;
        while step > size {
            step *= 0.5;
        }
        while step * 2.0 <= size {
            step *= 2.0;
        }
        self.origin = (center / step).round() * step;
        let rounding = largest * f64::from(f32::EPSILON);
        if rounding > COARSE_STEP * size {
            let warning = format!(
                "coordinates of meshes lie up to {largest:.3e} from their origin: the file rounds them to steps of \
                 about {rounding:.1e} (move the meshes' own origins near them)"
            );
            self.warnings.push(warning);
        }
        Ok(())
    }
}
