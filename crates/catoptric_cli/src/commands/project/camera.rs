//! Pinhole cameras as matrices in JSON files: OpenCV's K, R and t, or a 3x4 projection.

use crate::failure::Failure;
use catoptric::input::read_file;
use catoptric::output;
use catoptric::scene::{PreciseView, Scene, View};
use glam::{DMat3, DVec2, DVec3};
use serde::{Deserialize, Serialize};
use std::io::Write as _;
use std::path::Path;

/// The largest file that is read, in bytes.
const MOST_BYTES: u64 = 1 << 20;
/// The longest side of a picture, in pixels.
const MOST_SIDE: u32 = 1 << 24;
/// The largest deviation from a rotation, and of two descriptions from each other, relative to their numbers.
const TOLERANCE: f64 = 1e-4;
/// The position, in our pixels, of the middle of a picture's first pixel: 0, 0 in OpenCV's.
const FIRST_PIXEL: f64 = 0.5;
const NOTE: &str = "Pixels as in OpenCV: the middle of the first one is 0, 0 (image_x and image_y of paths are larger \
                    by 0.5). Camera: x to the right, y down, z forward. P = K [R | t].";

/// A pinhole camera whose picture has any scales, skew and principal point.
#[derive(Clone, Debug)]
pub(super) struct PinholeCamera {
    /// Width and height in pixels.
    pub(super) size: [u32; 2],
    /// The place of its eye in the scene.
    pub(super) eye: DVec3,
    /// Turns a point, as seen from the eye, into pixels (from the picture's corner) times depth, and depth.
    projection: DMat3,
}

/// A camera in a file.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct CameraFile {
    #[serde(default)]
    note: String,
    width: Option<u32>,
    height: Option<u32>,
    #[serde(rename = "K", default)]
    intrinsics: Option<[[f64; 3]; 3]>,
    #[serde(rename = "R", default)]
    rotation: Option<[[f64; 3]; 3]>,
    #[serde(rename = "t", default)]
    translation: Option<Column>,
    #[serde(rename = "P", default)]
    projection: Option<[[f64; 4]; 3]>,
    /// Coefficients of distortion; all must be zero.
    #[serde(default, skip_serializing)]
    dist: Vec<f64>,
}

/// Three numbers, or three rows of one.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(untagged)]
enum Column {
    Flat([f64; 3]),
    Rows([[f64; 1]; 3]),
}

impl Column {
    fn vector(self) -> DVec3 {
        match self {
            Self::Flat(numbers) => numbers.into(),
            Self::Rows(rows) => rows.map(|[number]| number).into(),
        }
    }
}

/// The left part and the last column of a 3x4 projection.
type Projection = (DMat3, DVec3);

impl PinholeCamera {
    /// The camera of a view; `None` if that has no eye, as its rays are parallel.
    pub(super) fn of_view(view: &View) -> Option<Self> {
        let projection = PreciseView::new(view).homogeneous()?;
        Some(Self { size: [view.width, view.height], eye: view.eye().as_dvec3(), projection })
    }

    /// The same camera with its eye elsewhere.
    pub(super) fn moved_to(self, eye: DVec3) -> Self {
        Self { eye, ..self }
    }

    /// Reads a file; `size` stands for that of a file that has none.
    pub(super) fn read(path: &Path, size: Option<[u32; 2]>, scene: &Scene) -> Result<Self, Failure> {
        let fail = |problem: String| Failure::input(format!("{}: {problem}", path.display()));
        let bytes = read_file(path, MOST_BYTES).map_err(|error| fail(format!("cannot read it: {error}")))?;
        let file: CameraFile = serde_json::from_slice(&bytes).map_err(|error| {
            fail(format!(
                "{error}; a camera is {{\"width\", \"height\", \"K\": 3x3, \"R\": 3x3, \"t\": 3}} or has \"P\": 3x4"
            ))
        })?;
        file.camera(size, scene).map_err(fail)
    }

    /// Writes a file that can be read again.
    pub(super) fn write(&self, path: &Path, scene: &Scene) -> Result<(), Failure> {
        let to_corner = DMat3::from_translation(DVec2::splat(FIRST_PIXEL));
        let (intrinsics, rotation) = parts(&(to_corner.inverse() * self.projection));
        let translation = -(rotation * (self.eye + scene.origin));
        let last = intrinsics * translation;
        let rows = |matrix: &DMat3| matrix.transpose().to_cols_array_2d();
        let left = rows(&(intrinsics * rotation));
        let file = CameraFile {
            note: NOTE.to_owned(),
            width: Some(self.size[0]),
            height: Some(self.size[1]),
            intrinsics: Some(rows(&intrinsics)),
            rotation: Some(rows(&rotation)),
            translation: Some(Column::Flat(translation.into())),
            projection: Some(std::array::from_fn(|row| {
                let [x, y, z] = left[row];
                [x, y, z, last[row]]
            })),
            dist: Vec::new(),
        };
        let text = serde_json::to_string_pretty(&file).map_err(|error| Failure::input(error.to_string()))?;
        Ok(output::write_file(path, |writer| writeln!(writer, "{text}"))?)
    }

    /// The place in the picture of a point of the scene, in pixels from the upper left corner; `None` behind the eye.
    pub(super) fn pixel_of(&self, point: DVec3) -> Option<DVec2> {
        let place = self.projection * (point - self.eye);
        (place.z > 0.0).then(|| place.truncate() / place.z).filter(|pixel| pixel.is_finite())
    }

    /// True for places within the picture.
    pub(super) fn holds(&self, pixel: DVec2) -> bool {
        let [width, height] = self.size.map(f64::from);
        (0.0..width).contains(&pixel.x) && (0.0..height).contains(&pixel.y)
    }
}

impl CameraFile {
    fn camera(&self, size: Option<[u32; 2]>, scene: &Scene) -> Result<PinholeCamera, String> {
        let size = match (self.width.zip(self.height), size) {
            (Some((width, height)), Some(given)) if [width, height] != given => {
                return Err(format!("its picture has {width}x{height} pixels, --size {}x{}", given[0], given[1]));
            }
            (Some((width, height)), _) => [width, height],
            (None, Some(given)) => given,
            (None, None) => return Err("it has no width and height: add them, or give --size".into()),
        };
        if size.iter().any(|side| !(1..=MOST_SIDE).contains(side)) {
            return Err(format!("width and height must be 1 to {MOST_SIDE} pixels"));
        }
        if self.dist.iter().any(|coefficient| *coefficient != 0.0) {
            return Err("dist: lens distortion is not supported; undistort the picture first, and leave it out".into());
        }
        let (left, last) = self.projection()?;
        let depth = left.row(2).length();
        let sign = left.determinant().signum();
        let scale = sign / depth;
        if !scale.is_finite() || left.determinant().abs() <= f64::MIN_POSITIVE || !left.inverse().is_finite() {
            return Err("its projection is singular: a camera with an eye is needed".into());
        }
        let eye = -(left.inverse() * last);
        let to_corner = DMat3::from_translation(DVec2::splat(FIRST_PIXEL));
        Ok(PinholeCamera { size, eye: eye - scene.origin, projection: to_corner * (left * scale) })
    }

    /// The projection of points of the world to OpenCV's pixels.
    fn projection(&self) -> Result<Projection, String> {
        let from_rows = |rows: [[f64; 3]; 3]| DMat3::from_cols_array_2d(&rows).transpose();
        let given = self.projection.map(|rows| {
            let left = from_rows(rows.map(|[x, y, z, _]| [x, y, z]));
            (left, DVec3::from(rows.map(|[.., last]| last)))
        });
        let parts = match (self.intrinsics, self.rotation, self.translation) {
            (Some(intrinsics), Some(rotation), Some(translation)) => {
                let (intrinsics, rotation) = (from_rows(intrinsics), from_rows(rotation));
                check_parts(&intrinsics, &rotation)?;
                Some((intrinsics * rotation, intrinsics * translation.vector()))
            }
            (None, None, None) => None,
            _ => return Err("K, R and t belong together: one of them is missing".into()),
        };
        let is_close = |(one, other): (Projection, Projection)| {
            let unit = |(left, last): Projection| (left * (1.0 / left.row(2).length()), last / left.row(2).length());
            let ((one, first), (other, second)) = (unit(one), unit(other));
            let sign = (one.row(2).dot(other.row(2))).signum();
            let size =
                one.to_cols_array().into_iter().chain(first.to_array()).fold(0.0, |size: f64, x| size.max(x.abs()));
            one.abs_diff_eq(other * sign, TOLERANCE * size) && first.abs_diff_eq(second * sign, TOLERANCE * size)
        };
        match (given, parts) {
            (Some(one), Some(other)) if !is_close((one, other)) => {
                Err("P is not K [R | t]: leave one of the two out".into())
            }
            (_, Some(projection)) | (Some(projection), None) => Ok(projection),
            (None, None) => Err("it has neither K, R and t nor P".into()),
        }
    }
}

fn check_parts(intrinsics: &DMat3, rotation: &DMat3) -> Result<(), String> {
    let [below, first, second] = [intrinsics.x_axis.y, intrinsics.x_axis.z, intrinsics.y_axis.z];
    let [across, down, one] = [intrinsics.x_axis.x, intrinsics.y_axis.y, intrinsics.z_axis.z];
    if !(across > 0.0 && down > 0.0 && one == 1.0 && below == 0.0 && first == 0.0 && second == 0.0) {
        return Err("K must be [[fx, s, cx], [0, fy, cy], [0, 0, 1]] with fx and fy above 0".into());
    }
    let product = *rotation * rotation.transpose();
    if !product.abs_diff_eq(DMat3::IDENTITY, TOLERANCE) || rotation.determinant() < 0.0 {
        return Err("R must be a rotation: rows of length 1, at right angles, with determinant 1".into());
    }
    Ok(())
}

/// The intrinsics and the rotation whose product is a matrix of positive determinant, up to its scale.
fn parts(projection: &DMat3) -> (DMat3, DMat3) {
    let rows = [projection.row(0), projection.row(1), projection.row(2)].map(|row| row / projection.row(2).length());
    let forward = rows[2];
    let middle = [rows[0].dot(forward), rows[1].dot(forward)];
    let down = rows[1] - forward * middle[1];
    let height = down.length();
    let down = down / height;
    let skew = rows[0].dot(down);
    let across = rows[0] - down * skew - forward * middle[0];
    let width = across.length();
    let intrinsics = DMat3::from_cols_array_2d(&[[width, 0.0, 0.0], [skew, height, 0.0], [middle[0], middle[1], 1.0]]);
    let rotation = DMat3::from_cols(across / width, down, forward).transpose();
    (intrinsics, rotation)
}
