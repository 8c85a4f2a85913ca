//! Views made elsewhere: a folder of pictures, by any renderer or camera, and a manifest that says where they belong.

use super::form::ViewForm;
use super::rows::ViewRow;
use super::texels::{ViewLevels, packed, stored};
use crate::light_field::layout::{FieldLayout, SLABS, STEEPEST, SlabLayout, along};
use crate::light_field::settings::{Compression, Disparity, LightFieldSettings};
use catoptric_core::input::read_file;
use catoptric_core::math::Aabb;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::picture;
use catoptric_engine::error::{RenderError, SceneError};
use catoptric_engine::method::Settings;
use glam::{Vec2, Vec3};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Slabs in names of files.
const NAMES: [&str; SLABS] = ["px", "nx", "py", "ny", "pz", "nz"];

/// Digits of the number that stands for pictures: 128 bits.
const FINGERPRINT_DIGITS: usize = 32;

/// The largest manifest, and the largest picture of a view.
const MAX_MANIFEST_BYTES: u64 = 16 << 20;
const MAX_VIEW_BYTES: u64 = 4 << 30;

/// Regions are the same if they are so near to each other, as a share of their size. Chosen, not measured.
const SAME: f32 = 1e-4;

/// Channels that hold a distance, in pictures of one.
const DISTANCE_CHANNELS: [&str; 4] = ["Z", "Y", "V", "R"];

/// Manifest of views: their places, and the scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    /// Views a side of a slab.
    st: u32,
    /// Pixels a side of a view.
    uv: u32,
    /// Names of the pictures, with `{slab}`, `{s}` and `{t}` in them.
    radiance: String,
    /// Names of the pictures of distances along the slab's axis, in scene units.
    distance: Option<String>,
    region: ViewsRegion,
    /// The cameras of the views, for the program that renders them.
    #[serde(default, rename = "view", skip_serializing)]
    _view: IgnoredAny,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ViewsRegion {
    min: [f32; 3],
    max: [f32; 3],
}

/// A manifest with its pictures.
#[derive(Clone, Debug)]
pub(crate) struct Views {
    path: PathBuf,
    manifest: Manifest,
}

fn setting(problem: impl std::fmt::Display) -> RenderError {
    RenderError::Setting { method: LightFieldSettings::METHOD, problem: format!("views: {problem}") }
}

impl Views {
    /// Reads a manifest.
    ///
    /// # Errors
    /// [`RenderError::Setting`] where it cannot be read, or means nothing.
    pub(crate) fn open(path: &Path) -> Result<Self, RenderError> {
        let invalid = |problem: String| setting(format!("{}: {problem}", path.display()));
        let bytes = read_file(path, MAX_MANIFEST_BYTES).map_err(|error| invalid(format!("cannot read it: {error}")))?;
        let text = String::from_utf8(bytes).map_err(|_| invalid("is no text; save it as UTF-8".into()))?;
        let manifest: Manifest = toml::from_str(&text).map_err(|error| invalid(error.to_string().trim().into()))?;
        for (field, names) in [("radiance", Some(&manifest.radiance)), ("distance", manifest.distance.as_ref())] {
            let missing = ["{slab}", "{s}", "{t}"].into_iter().find(|part| names.is_some_and(|it| !it.contains(part)));
            if let Some(missing) = missing {
                return Err(invalid(format!("{field}: {missing} is missing in the name")));
            }
        }
        Ok(Self { path: path.into(), manifest })
    }

    /// Checks the views against a layout and settings.
    pub(crate) fn check(&self, settings: &LightFieldSettings, layouts: &[FieldLayout]) -> Result<(), RenderError> {
        let Manifest { st, uv, region, distance, .. } = &self.manifest;
        let fail = |problem: String| Err(setting(format!("{}: {problem}", self.path.display())));
        let [layout] = layouts else {
            return fail(format!("is of one region, the scene has {}; give it one, as [region]", layouts.len()));
        };
        for (name, found, asked) in [("st", *st, settings.st), ("uv", *uv, settings.uv)] {
            if found != asked {
                return fail(format!("{name} is {found} there, {asked} in the settings; set {name}={found}"));
            }
        }
        let (low, high) = (Vec3::from(region.min), Vec3::from(region.max));
        let Aabb { min, max } = *layout.region();
        let off = (low - min).abs().max((high - max).abs()).max_element();
        if off.is_nan() || off > SAME * layout.region().diagonal() {
            return fail(format!("region: is {low} to {high} there, {min} to {max} in the scene"));
        }
        let needs_distance = match settings.disparity {
            Disparity::Depth => true,
            Disparity::Plane => settings.focal_distance == 0.0,
            Disparity::None => false,
        };
        if needs_distance && distance.is_none() {
            let instead = "set disparity=none, or disparity=plane and a focal_distance, or give pictures of distances";
            return fail(format!("has no distance: {instead}"));
        }
        Ok(())
    }

    /// A number that changes with any picture, in hexadecimal digits: it stands in baked files.
    pub(crate) fn fingerprint(&self) -> Result<String, RenderError> {
        let mut hasher = blake3::Hasher::new();
        let Manifest { st, distance, radiance, .. } = &self.manifest;
        for number in 0..SLABS as u32 * st * st {
            let (slab, t, s) = (number / (st * st), number / st % st, number % st);
            for names in [Some(radiance), distance.as_ref()].into_iter().flatten() {
                let path = self.file(names, slab as usize, s, t);
                let bytes =
                    read_file(&path, MAX_VIEW_BYTES).map_err(|source| setting(SceneError::Read { path, source }))?;
                hasher.update(&(bytes.len() as u64).to_le_bytes()).update(&bytes);
            }
        }
        Ok(hasher.finalize().to_hex()[..FINGERPRINT_DIGITS].to_owned())
    }

    /// A row of views: that of a number, slab after slab.
    pub(crate) fn row(&self, layout: &SlabLayout, number: usize) -> Result<ViewRow, RenderError> {
        let levels = ViewLevels::new(layout.uv);
        let (slab, t) = (number / layout.st as usize, (number % layout.st as usize) as u32);
        let mut row = ViewRow::with_room_for(layout.st, &ViewForm::new(layout.uv, Compression::None));
        let longer = layout.slabs[slab].spacing.max_element();
        for s in 0..layout.st {
            let radiance = self.file(&self.manifest.radiance, slab, s, t);
            let picture = picture::read(&radiance).map_err(setting)?;
            self.check_size(&radiance, picture.width, picture.height)?;
            row.texels.extend(self.in_order(slab, |index| {
                let [r, g, b, _] = picture.pixels[index];
                packed(Vec3::new(r, g, b))
            }));
            levels.append(&mut row.texels);
            match &self.manifest.distance {
                Some(names) => {
                    let path = self.file(names, slab, s, t);
                    let (width, height, distances) =
                        picture::read_channel(&path, &DISTANCE_CHANNELS).map_err(setting)?;
                    self.check_size(&path, width, height)?;
                    row.parallax.extend(self.in_order(slab, |index| stored(longer / distances[index].max(0.0))));
                }
                None => row.parallax.extend(std::iter::repeat_n(0, (layout.uv * layout.uv) as usize)),
            }
        }
        Ok(row)
    }

    /// Texels in the order of a view: pictures of slabs that look against their axis are turned about.
    fn in_order<T>(&self, slab: usize, value: impl Fn(usize) -> T) -> impl Iterator<Item = T> {
        let side = self.manifest.uv as usize;
        let against = !slab.is_multiple_of(2);
        (0..side * side).map(move |index| {
            let (row, column) = (index / side, index % side);
            value(row * side + if against { side - 1 - column } else { column })
        })
    }

    fn check_size(&self, path: &Path, width: u32, height: u32) -> Result<(), RenderError> {
        let side = self.manifest.uv;
        if (width, height) == (side, side) {
            return Ok(());
        }
        Err(setting(format!("{}: has {width} x {height} pixels, the manifest says {side} x {side}", path.display())))
    }

    fn file(&self, names: &str, slab: usize, s: u32, t: u32) -> PathBuf {
        let name = names.replace("{slab}", NAMES[slab]).replace("{s}", &s.to_string()).replace("{t}", &t.to_string());
        self.path.parent().unwrap_or(Path::new("")).join(name)
    }
}

/// The manifest for views of a layout that another renderer is to make, with the camera of each.
pub(crate) fn manifest(layout: &SlabLayout) -> Result<String, RenderError> {
    let Aabb { min, max } = layout.region;
    let manifest = Manifest {
        st: layout.st,
        uv: layout.uv,
        radiance: "radiance-{slab}-{s}-{t}.exr".into(),
        distance: Some("distance-{slab}-{s}-{t}.exr".into()),
        region: ViewsRegion { min: min.to_array(), max: max.to_array() },
        _view: IgnoredAny,
    };
    let head = toml::to_string(&manifest).map_err(setting)?;
    // The outermost pixels' middles are as steep as that, their outer edges more.
    let half = STEEPEST * layout.uv as f32 / (layout.uv - 1) as f32;
    let fov_deg = 2.0 * half.arc_tangent().to_degrees();
    let mut text = format!(
        "# Views of light-field slabs, to be made by any renderer without the reflectors in the region.\n\
         # Square pictures without any lens distortion: .png (8-bit sRGB) or .exr (linear), and .exr of \
         distances along the\n\
         # view's `forward`, in scene units. Leave the line `distance` out where there are none.\n\
         {head}\n# All views have fov_deg = {fov_deg} in both directions.\n"
    );
    let vector = |v: Vec3| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
    for (index, slab) in layout.slabs.iter().enumerate() {
        let forward = along(slab.axis, slab.sign, Vec2::ZERO);
        let (right, down) = (along(slab.axis, 0.0, Vec2::X) * slab.sign, along(slab.axis, 0.0, Vec2::Y));
        let turned = format!("right = {}\ndown = {}\nforward = {}", vector(right), vector(down), vector(forward));
        for t in 0..layout.st {
            for s in 0..layout.st {
                let eye = vector(slab.eye(s, t));
                let place = format!("slab = \"{}\"\ns = {s}\nt = {t}", NAMES[index]);
                // Writing to a string cannot fail.
                let _ = write!(text, "\n[[view]]\n{place}\neye = {eye}\n{turned}\n");
            }
        }
    }
    Ok(text)
}
