//! The keys that describe an analytic surface, the same in `.toml` scenes and in glTF extras.

use crate::scene::Material;
use crate::surface::AnalyticSurface;
use glam::Vec3;

/// The kinds that this version can draw.
const KINDS: [&str; 2] = ["plane", "sphere"];
/// Kinds of the scene format that later versions draw.
const LATER_KINDS: [&str; 6] = ["ellipsoid", "quadric", "torus", "superquadric", "revolution", "implicit"];

/// The largest length in a scene file.
pub(super) const MAX_LENGTH: f64 = 1e9;

/// A wrong key, and what is wrong with it.
#[derive(Debug, PartialEq)]
pub(super) struct KeyError {
    pub(super) key: &'static str,
    pub(super) problem: String,
}

fn wrong<T>(key: &'static str, problem: impl Into<String>) -> Result<T, KeyError> {
    Err(KeyError { key, problem: problem.into() })
}

/// The keys of a surface as they were given; the place is not among them.
#[derive(Clone, Debug, Default)]
pub(super) struct SurfaceKeys {
    pub(super) kind: String,
    pub(super) radius: Option<f64>,
    pub(super) size: Option<[f64; 2]>,
    pub(super) tint: Option<[f64; 3]>,
    pub(super) ior: Option<f64>,
    pub(super) inside: bool,
}

/// Whether a kind can be drawn; to be asked before its keys are looked at.
pub(super) fn check_kind(kind: &str) -> Result<(), KeyError> {
    if KINDS.contains(&kind) {
        return Ok(());
    }
    let supported = KINDS.map(|kind| format!("`{kind}`")).join(" and ");
    if LATER_KINDS.contains(&kind) {
        return wrong("surface", format!("`{kind}` is not supported in this version; supported are {supported}"));
    }
    wrong("surface", format!("there is no kind `{kind}`; supported are {supported}"))
}

impl SurfaceKeys {
    /// The surface in its own frame.
    pub(super) fn surface(&self) -> Result<AnalyticSurface, KeyError> {
        check_kind(&self.kind)?;
        let not_here = |key, given: bool| match given {
            true => wrong(key, format!("a {} has no `{key}`", self.kind)),
            false => Ok(()),
        };
        if self.kind == "plane" {
            not_here("radius", self.radius.is_some())?;
            let Some([width, height]) = self.size else {
                return wrong("size", "missing; a plane needs `size = [w, h]`");
            };
            let half = |length| Ok(positive("size", length)? * 0.5);
            return Ok(AnalyticSurface::Plane { half_width: half(width)?, half_height: half(height)? });
        }
        not_here("size", self.size.is_some())?;
        let Some(radius) = self.radius else { return wrong("radius", "missing; a sphere needs a `radius`") };
        Ok(AnalyticSurface::Sphere { radius: positive("radius", radius)? })
    }

    /// The material: glass where there is an index of refraction, else a mirror.
    pub(super) fn material(&self, name: &str) -> Result<Material, KeyError> {
        let mut tint = Vec3::ONE;
        if let Some(numbers) = self.tint {
            if numbers.iter().any(|number| !(0.0..=1.0).contains(number)) {
                return wrong("tint", format!("{numbers:?}; every number must be from 0 to 1"));
            }
            tint = Vec3::from(numbers.map(|number| number as f32));
        }
        let Some(ior) = self.ior else { return Ok(Material::mirror(name, tint)) };
        if !(0.1..=10.0).contains(&ior) {
            return wrong("ior", format!("{ior}; allowed is 0.1 to 10"));
        }
        if self.inside {
            return wrong("inside", "is for mirrors, not for lenses: leave out `inside` or `ior`");
        }
        Ok(Material { base_color: tint.extend(1.0), ..Material::glass(name, ior as f32) })
    }
}

fn positive(key: &'static str, length: f64) -> Result<f64, KeyError> {
    // Below the smallest normal float a length would be rounded to 0.
    if !(1e-9..=MAX_LENGTH).contains(&length) {
        return wrong(key, format!("{length}; a length must be from 1e-9 to {MAX_LENGTH:e}"));
    }
    Ok(length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Role;

    #[test]
    fn surfaces_and_materials() {
        let ball = SurfaceKeys { kind: "sphere".into(), radius: Some(2.0), ..Default::default() };
        assert_eq!(ball.surface().unwrap(), AnalyticSurface::Sphere { radius: 2.0 });
        assert_eq!(ball.material("ball").unwrap(), Material::mirror("ball", Vec3::ONE));
        let plane = SurfaceKeys { kind: "plane".into(), size: Some([2.0, 4.0]), ior: Some(1.3), ..Default::default() };
        assert_eq!(plane.surface().unwrap(), AnalyticSurface::Plane { half_width: 1.0, half_height: 2.0 });
        assert_eq!(plane.material("").unwrap().role, Role::Lens);
    }

    #[test]
    fn wrong_keys_are_named() {
        let ball = SurfaceKeys { kind: "sphere".into(), radius: Some(1.0), ..Default::default() };
        let key = |keys: SurfaceKeys| {
            keys.surface().map(|_| ()).and_then(|()| keys.material("").map(|_| ())).unwrap_err().key
        };
        assert_eq!(key(SurfaceKeys { radius: None, ..ball.clone() }), "radius");
        assert_eq!(key(SurfaceKeys { radius: Some(f64::NAN), ..ball.clone() }), "radius");
        assert_eq!(key(SurfaceKeys { radius: Some(-1.0), ..ball.clone() }), "radius");
        assert_eq!(key(SurfaceKeys { size: Some([1.0; 2]), ..ball.clone() }), "size");
        assert_eq!(key(SurfaceKeys { ior: Some(11.0), ..ball.clone() }), "ior");
        assert_eq!(key(SurfaceKeys { ior: Some(1.5), inside: true, ..ball.clone() }), "inside");
        assert_eq!(key(SurfaceKeys { tint: Some([0.0, 2.0, 0.0]), ..ball }), "tint");
        assert!(check_kind("torus").unwrap_err().problem.contains("this version"));
        assert!(check_kind("cube").unwrap_err().problem.contains("sphere"));
    }
}
