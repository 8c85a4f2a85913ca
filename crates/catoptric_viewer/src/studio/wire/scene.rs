//! Summaries of scenes as text.

use super::error::WireError;
use super::wish::{WireCamera, WireDisplay, WireLook, role_of};
use crate::studio::news::{ClipSummary, ObjectSummary, SceneSummary};
use catoptric::math::Aabb;
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

#[derive(Serialize, Deserialize)]
pub(super) struct WireScene {
    number: u64,
    name: String,
    cameras: Vec<WireCamera>,
    objects: Vec<WireObject>,
    triangles: usize,
    clips: Vec<(String, f32)>,
    bounds: [[f32; 3]; 2],
    settings: BTreeMap<String, toml::Table>,
    warnings: Vec<String>,
    origin: [f64; 3],
    has_environment: bool,
    order_needed: u32,
    display: WireDisplay,
    automatic_stops: f32,
    load_ms: f64,
}

#[derive(Serialize, Deserialize)]
pub(super) struct WireObject {
    name: String,
    material: String,
    role: String,
    ior: f32,
    look: WireLook,
    triangles: u32,
    bounds: [[f32; 3]; 2],
}

impl From<&SceneSummary> for WireScene {
    fn from(summary: &SceneSummary) -> Self {
        let object = |object: &ObjectSummary| WireObject {
            name: object.name.clone(),
            material: object.material.clone(),
            role: object.role.name().into(),
            ior: object.ior,
            look: WireLook::from(&object.look),
            triangles: object.triangles,
            bounds: corners(&object.bounds),
        };
        Self {
            number: summary.number,
            name: summary.name.clone(),
            cameras: summary.cameras.iter().map(WireCamera::from).collect(),
            objects: summary.objects.iter().map(object).collect(),
            triangles: summary.triangles,
            clips: summary.clips.iter().map(|clip| (clip.name.clone(), clip.duration)).collect(),
            bounds: corners(&summary.bounds),
            settings: summary.settings.clone(),
            warnings: summary.warnings.clone(),
            origin: summary.origin.to_array(),
            has_environment: summary.has_environment,
            order_needed: summary.order_needed,
            display: WireDisplay::from(summary.display),
            automatic_stops: summary.automatic_stops,
            load_ms: summary.load_ms,
        }
    }
}

impl WireScene {
    pub(super) fn read(self) -> Result<SceneSummary, WireError> {
        let object = |object: WireObject| {
            Ok(ObjectSummary {
                name: object.name,
                material: object.material,
                role: role_of(&object.role)?,
                ior: object.ior,
                look: object.look.read(),
                triangles: object.triangles,
                bounds: read_bounds(object.bounds),
            })
        };
        Ok(SceneSummary {
            number: self.number,
            name: self.name,
            cameras: self.cameras.into_iter().map(WireCamera::read).collect::<Result<_, _>>()?,
            objects: self.objects.into_iter().map(object).collect::<Result<_, WireError>>()?,
            triangles: self.triangles,
            clips: self.clips.into_iter().map(|(name, duration)| ClipSummary { name, duration }).collect(),
            bounds: read_bounds(self.bounds),
            settings: self.settings,
            warnings: self.warnings,
            origin: DVec3::from_array(self.origin),
            has_environment: self.has_environment,
            order_needed: self.order_needed,
            display: self.display.read()?,
            automatic_stops: self.automatic_stops,
            load_ms: self.load_ms,
        })
    }
}

fn corners(bounds: &Aabb) -> [[f32; 3]; 2] {
    [bounds.min.to_array(), bounds.max.to_array()]
}

fn read_bounds([min, max]: [[f32; 3]; 2]) -> Aabb {
    Aabb { min: Vec3::from_array(min), max: Vec3::from_array(max) }
}
