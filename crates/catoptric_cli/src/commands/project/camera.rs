//! Pinhole cameras as matrices in JSON files: OpenCV's K, R and t, or a 3x4 projection.

use crate::failure::Failure;
use catoptric::input::read_file;
use catoptric::output;
use catoptric::scene::{PreciseView, Scene, View};
use glam::{DMat3, DVec2, DVec3};
use serde::Deserialize;
use serde_json::{Value, json};
use std::io::Write as _;
use std::path::Path;

/// The largest file that is read, in bytes.
const MOST_BYTES: u64 = 1 << 20;
/// The longest side of a picture, in pixels.
const MOST_SIDE: u32 = 1 << 24;
/// Eyes farther from the origin are taken for slips.
const MOST_COORDINATE: f64 = 1e9;
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
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraFile {
    #[serde(default, rename = "note")]
    _note: String,
    width: Option<u32>,
    height: Option<u32>,
    #[serde(rename = "K")]
    intrinsics: Option<Value>,
    #[serde(rename = "R")]
    rotation: Option<Value>,
    #[serde(rename = "t")]
    translation: Option<Value>,
    #[serde(rename = "P")]
    projection: Option<Value>,
    /// Coefficients of distortion; all must be zero.
    dist: Option<Value>,
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
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
        let form = "a camera has width, height and K, R, t or P, such as {\"K\": [[500, 0, 319.5], ...], ...}";
        let file: CameraFile = serde_json::from_slice(text).map_err(|error| fail(format!("{error}; {form}")))?;
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
        let projection: [[f64; 4]; 3] = std::array::from_fn(|row| {
            let [x, y, z] = left[row];
            [x, y, z, last[row]]
        });
        let [width, height] = self.size;
        let file = json!({
            "note": NOTE, "width": width, "height": height, "K": rows(&intrinsics), "R": rows(&rotation),
            "t": translation.to_array(), "P": projection,
        });
        let text = serde_json::to_string_pretty(&file)?;
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
        let size = match (self.width, self.height, size) {
            (Some(width), Some(height), Some(given)) if [width, height] != given => {
                return Err(format!("its picture has {width}x{height} pixels, --size {}x{}", given[0], given[1]));
            }
            (Some(width), Some(height), _) => [width, height],
            (None, None, Some(given)) => given,
            (None, None, None) => return Err("it has no width and height: add them, or give --size".into()),
            _ => return Err("width and height belong together: one of them is missing".into()),
        };
        if size.iter().any(|side| !(1..=MOST_SIDE).contains(side)) {
            return Err(format!("width and height must be 1 to {MOST_SIDE} pixels"));
        }
        if let Some(dist) = &self.dist
            && numbers("dist", dist)?.iter().any(|coefficient| *coefficient != 0.0)
        {
            return Err("dist: lens distortion is not supported; undistort the picture first, and leave it out".into());
        }
        let (left, last) = self.projection()?;
        let inverse = left.inverse();
        if !inverse.is_finite() {
            return Err("its projection is singular: a camera with an eye is needed".into());
        }
        let eye = -(inverse * last);
        if !eye.is_finite() || eye.abs().max_element() > MOST_COORDINATE {
            return Err(format!("t or P: the eye is not within {MOST_COORDINATE:e} of the origin"));
        }
        let to_corner = DMat3::from_translation(DVec2::splat(FIRST_PIXEL));
        let in_front = left.determinant().signum();
        Ok(PinholeCamera { size, eye: eye - scene.origin, projection: to_corner * (left * in_front) })
    }

    /// The projection of points of the world to OpenCV's pixels, whose last row has the length 1.
    fn projection(&self) -> Result<Projection, String> {
        let given = match &self.projection {
            None => None,
            Some(value) => {
                let rows = matrix::<4>("P", value)?;
                let length = DVec3::from_slice(&rows[2][..3]).length();
                let rows = rows.map(|row| row.map(|number| number / length));
                Some((from_rows(rows.map(|[x, y, z, _]| [x, y, z])), DVec3::from(rows.map(|[.., last]| last))))
            }
        };
        let parts = match (&self.intrinsics, &self.rotation, &self.translation) {
            (Some(intrinsics), Some(rotation), Some(translation)) => {
                let intrinsics = from_rows(matrix("K", intrinsics)?);
                let rotation = from_rows(matrix("R", rotation)?);
                check_parts(&intrinsics, &rotation)?;
                let translation = numbers("t", translation)?;
                let translation: [f64; 3] = translation.try_into().map_err(|_| "t must be three numbers")?;
                Some((intrinsics * rotation, intrinsics * DVec3::from(translation)))
            }
            (None, None, None) => None,
            _ => return Err("K, R and t belong together: one of them is missing".into()),
        };
        match (given, parts) {
            (Some(one), Some(other)) if !is_same(one, other) => {
                Err("P is not K [R | t]: leave one of the two out".into())
            }
            (_, Some(projection)) | (Some(projection), None) => Ok(projection),
            (None, None) => Err("it has neither K, R and t nor P".into()),
        }
    }
}

/// True for projections that are the same up to their sign.
fn is_same((one, first): Projection, (other, second): Projection) -> bool {
    let sign = one.row(2).dot(other.row(2)).signum();
    let numbers = one.to_cols_array().into_iter().chain(first.to_array());
    let tolerance = TOLERANCE * numbers.fold(0.0, |most: f64, number| most.max(number.abs()));
    one.abs_diff_eq(other * sign, tolerance) && first.abs_diff_eq(second * sign, tolerance)
}

fn from_rows(rows: [[f64; 3]; 3]) -> DMat3 {
    DMat3::from_cols_array_2d(&rows).transpose()
}

/// Three rows of so many numbers.
fn matrix<const COLUMNS: usize>(key: &str, value: &Value) -> Result<[[f64; COLUMNS]; 3], String> {
    let all = numbers(key, value)?;
    if all.len() != 3 * COLUMNS {
        return Err(format!("{key} must be 3 rows of {COLUMNS} numbers"));
    }
    Ok(std::array::from_fn(|row| std::array::from_fn(|column| all[row * COLUMNS + column])))
}

/// The numbers of a list, of rows, or of a column.
fn numbers(key: &str, value: &Value) -> Result<Vec<f64>, String> {
    let wrong = || format!("{key} must be made of finite numbers");
    let Value::Array(list) = value else { return Ok(vec![value.as_f64().ok_or_else(wrong)?]) };
    let rows = list.iter().map(|entry| match entry {
        Value::Array(row) => row.iter().map(|number| number.as_f64().ok_or_else(wrong)).collect(),
        number => Ok(vec![number.as_f64().ok_or_else(wrong)?]),
    });
    Ok(rows.collect::<Result<Vec<Vec<f64>>, String>>()?.concat())
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
