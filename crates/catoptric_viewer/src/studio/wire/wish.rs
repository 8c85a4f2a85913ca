//! Wishes, and how scenes are opened, as text.

use super::error::WireError;
use super::overlay::kind_of;
use crate::studio::order::{Changes, Drawn, Opening, RoleChange, Wish};
use catoptric::methods::Quality;
use catoptric::scene::edits::Look;
use catoptric::scene::{Camera, Projection, Role};
use catoptric::tone::{Display, ToneCurve};
use catoptric_scenes::import::EnvironmentEdit;
use glam::{Affine3A, Vec3};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

#[derive(Serialize, Deserialize)]
pub(super) struct WireWish {
    scene: u64,
    time: f32,
    clip: Option<usize>,
    roles: Vec<(String, String, Option<f32>)>,
    looks: Vec<(String, WireLook)>,
    moves: Vec<(String, [f32; 3])>,
    camera: WireCamera,
    size: [u32; 2],
    sides: Vec<(String, toml::Table, u32, u32)>,
    has_automatic_order: bool,
    display: WireDisplay,
    compares: bool,
    overlays: Vec<String>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct WireDisplay {
    exposure_stops: f32,
    curve: String,
}

#[derive(Serialize, Deserialize)]
pub(super) struct WireLook {
    color: Option<[f32; 3]>,
    roughness: Option<f32>,
    ior: Option<f32>,
    priority: Option<i32>,
}

#[derive(Serialize, Deserialize)]
pub(super) struct WireCamera {
    name: String,
    other_name: String,
    place: [f32; 12],
    fov_y: Option<f32>,
    half_height: Option<f32>,
}

impl From<&Wish> for WireWish {
    fn from(wish: &Wish) -> Self {
        let Wish { scene, time, clip, changes, camera, size, sides, .. } = wish;
        let Wish { has_automatic_order, display, compares, overlays, .. } = wish;
        let Changes { roles, looks, moves } = changes;
        let side = |Drawn { method, settings, quality }: &Drawn| {
            (method.clone(), settings.clone(), quality.samples, quality.order)
        };
        let role = |change: &RoleChange| (change.name.clone(), change.role.name().to_owned(), change.ior);
        Self {
            scene: *scene,
            time: *time,
            clip: *clip,
            roles: roles.iter().map(role).collect(),
            looks: looks.iter().map(|(name, look)| (name.clone(), WireLook::from(look))).collect(),
            moves: moves.iter().map(|(name, by)| (name.clone(), by.to_array())).collect(),
            camera: WireCamera::from(camera),
            size: *size,
            sides: sides.iter().map(side).collect(),
            has_automatic_order: *has_automatic_order,
            display: WireDisplay::from(*display),
            compares: *compares,
            overlays: overlays.iter().map(|kind| kind.name().into()).collect(),
        }
    }
}

impl WireWish {
    pub(super) fn read(self) -> Result<Wish, WireError> {
        let Self { scene, time, clip, roles, looks, moves, camera, size, sides, .. } = self;
        let Self { has_automatic_order, display, compares, overlays, .. } = self;
        let role =
            |(name, role, ior): (String, String, Option<f32>)| Ok(RoleChange { name, role: role_of(&role)?, ior });
        let side = |(method, settings, samples, order)| Drawn { method, settings, quality: Quality { samples, order } };
        let changes = Changes {
            roles: roles.into_iter().map(role).collect::<Result<_, WireError>>()?,
            looks: looks.into_iter().map(|(name, look)| (name, look.read())).collect(),
            moves: moves.into_iter().map(|(name, by)| (name, Vec3::from_array(by))).collect(),
        };
        let (camera, sides) = (camera.read()?, sides.into_iter().map(side).collect());
        let overlays = overlays.iter().map(|name| kind_of(name)).collect::<Result<_, _>>()?;
        let display = display.read()?;
        Ok(Wish { scene, time, clip, changes, camera, size, sides, has_automatic_order, display, compares, overlays })
    }
}

#[derive(Serialize, Deserialize)]
pub(super) struct WireOpening {
    environment: Option<PathBuf>,
    rotation_deg: Option<f64>,
    strength: Option<f64>,
    variant: Option<String>,
    allow_outside: bool,
    has_solid_glass: bool,
    lacks_shadows: bool,
    lacks_bounces: bool,
    roles: Vec<(String, String, Option<f32>)>,
}

impl From<&Opening> for WireOpening {
    fn from(opening: &Opening) -> Self {
        let Opening { environment, environment_edit, variant, roles, .. } = opening;
        let role = |change: &RoleChange| (change.name.clone(), change.role.name().to_owned(), change.ior);
        Self {
            environment: environment.clone(),
            rotation_deg: environment_edit.rotation_deg,
            strength: environment_edit.strength,
            variant: variant.clone(),
            allow_outside: opening.allow_outside,
            has_solid_glass: opening.has_solid_glass,
            lacks_shadows: opening.lacks_shadows,
            lacks_bounces: opening.lacks_bounces,
            roles: roles.iter().map(role).collect(),
        }
    }
}

impl WireOpening {
    pub(super) fn read(self) -> Result<Opening, WireError> {
        let role =
            |(name, role, ior): (String, String, Option<f32>)| Ok(RoleChange { name, role: role_of(&role)?, ior });
        Ok(Opening {
            environment: self.environment,
            environment_edit: EnvironmentEdit { rotation_deg: self.rotation_deg, strength: self.strength },
            variant: self.variant,
            allow_outside: self.allow_outside,
            has_solid_glass: self.has_solid_glass,
            lacks_shadows: self.lacks_shadows,
            lacks_bounces: self.lacks_bounces,
            roles: self.roles.into_iter().map(role).collect::<Result<_, WireError>>()?,
        })
    }
}

impl From<Display> for WireDisplay {
    fn from(Display { exposure_stops, curve }: Display) -> Self {
        Self { exposure_stops, curve: curve.name().into() }
    }
}

impl WireDisplay {
    pub(super) fn read(self) -> Result<Display, WireError> {
        let found = ToneCurve::NAMES.into_iter().find(|(_, name)| *name == self.curve);
        let (curve, _) = found.ok_or_else(|| WireError::new(format!("there is no tone curve `{}`", self.curve)))?;
        Ok(Display { exposure_stops: self.exposure_stops, curve })
    }
}

impl From<&Look> for WireLook {
    fn from(Look { color, roughness, ior, priority }: &Look) -> Self {
        let color = color.map(|color| color.to_array());
        Self { color, roughness: *roughness, ior: *ior, priority: *priority }
    }
}

impl WireLook {
    pub(super) fn read(self) -> Look {
        let Self { color, roughness, ior, priority } = self;
        Look { color: color.map(Vec3::from_array), roughness, ior, priority }
    }
}

impl From<&Camera> for WireCamera {
    fn from(Camera { name, other_name, world_from_camera, projection }: &Camera) -> Self {
        let (fov_y, half_height) = match projection {
            Projection::Perspective { fov_y } => (Some(*fov_y), None),
            Projection::Orthographic { half_height } => (None, Some(*half_height)),
        };
        let (name, other_name, place) = (name.clone(), other_name.clone(), world_from_camera.to_cols_array());
        Self { name, other_name, place, fov_y, half_height }
    }
}

impl WireCamera {
    pub(super) fn read(self) -> Result<Camera, WireError> {
        let projection = match (self.fov_y, self.half_height) {
            (Some(fov_y), None) => Projection::Perspective { fov_y },
            (None, Some(half_height)) => Projection::Orthographic { half_height },
            _ => return Err(WireError::new("a camera has one projection".into())),
        };
        let world_from_camera = Affine3A::from_cols_array(&self.place);
        Ok(Camera { name: self.name, other_name: self.other_name, world_from_camera, projection })
    }
}

pub(super) fn role_of(name: &str) -> Result<Role, WireError> {
    let all = [Role::Diffuse, Role::Reflector, Role::Lens, Role::Coated];
    let found = all.into_iter().find(|role| role.name() == name);
    found.ok_or_else(|| WireError::new(format!("there is no role `{name}`")))
}
