//! How scenes are opened, as text.

use super::WireError;
use super::wish::role_of;
use crate::studio::order::{Opening, RoleChange};
use catoptric_scenes::import::EnvironmentEdit;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

#[derive(Serialize, Deserialize)]
pub(super) struct WireOpening {
    environment: Option<PathBuf>,
    rotation_deg: Option<f64>,
    strength: Option<f64>,
    variant: Option<String>,
    allow_outside: bool,
    has_solid_glass: bool,
    lacks_shadows: bool,
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
            roles: self.roles.into_iter().map(role).collect::<Result<_, WireError>>()?,
        })
    }
}
