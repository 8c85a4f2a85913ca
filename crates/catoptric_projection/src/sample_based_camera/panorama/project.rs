//! Scene points to their appearances in all directions; each appears once where two faces meet.

use super::cameras::{PanoramaFace, PanoramicCameras, PanoramicMirrors};
use super::cube::{FACES, beyond, owner};
use crate::find::ray_map::{ViewField, eye_of};
use crate::sample_based_camera::cameras::CameraProjection;
use crate::sample_based_camera::project::{Appearance, CameraProjector};
use crate::sample_based_camera::settings::SampleBasedCameraSettings;
use catoptric_core::scene::{PreciseView, ViewRays};
use catoptric_engine::error::RenderError;
use catoptric_engine::method::Settings;
use catoptric_engine::method::projector::{Projection, SpecularPath};
use catoptric_engine::optics::path::manifold::SpecularSurfaces;
use glam::{Mat3, Vec2, Vec3};
use std::cell::RefCell;

/// Two faces may disagree by this many cells about where a point appears. That is less than the margin around them:
/// points so near to a seam are searched on both sides. Chosen, not measured.
const SEAM_CELLS: f32 = 1.0;

/// Answers of two faces are one only if they are nearer than this, in cells. Chosen, not measured.
const SAME_CELLS: f32 = 2.0;

/// Appearance of a scene point in a mirror, from the eye of [`PanoramicCameras`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PanoramicProjection {
    /// Index of the path in [`PanoramicCameras::paths`].
    pub path: u32,
    /// Focal points that the path has passed, summed over its segments; without polish, those of the last segment.
    pub focal_index: u32,
    /// The first reflection point, counted from the eye.
    pub reflection_point: Vec3,
    /// Unit direction from the eye to it.
    pub direction: Vec3,
    /// The change of the direction with the scene point, to first order: radians a scene unit, across the direction.
    /// Without polish that of the leaf's polynomials, some hundredths off at the border of one that fills a face.
    pub direction_change: Mat3,
    /// The change of the reflection point with the scene point, to first order, as the leaf's polynomials have it.
    pub reflection_change: Mat3,
    /// Unit normal of the mirror there, on the side from which it is seen.
    pub normal: Vec3,
    /// Optical length of the path from the eye to the scene point, in scene units. On paths of several bounces, without
    /// polish, leaves have the part up to the last bounce as a polynomial that the accuracy does not cover: where one
    /// leaf fills a face, as over a flat mirror nearby, it may be some hundredths off.
    pub path_length: f32,
    /// Length of its last segment, from the last bounce to the scene point, in scene units.
    pub last_segment: f32,
    /// Estimated error of the direction in radians; 0 where a solver has converged.
    pub error: f32,
}

impl PanoramicCameras {
    /// The projector of scene points. `mirrors` are those that the cameras were built for, or those of another moment
    /// of the scene, in which other things have moved.
    ///
    /// # Errors
    /// [`RenderError::Limit`] when that scene has not as many objects.
    pub fn projector<'a>(&'a self, mirrors: &PanoramicMirrors<'a>) -> Result<PanoramicProjector<'a>, RenderError> {
        let (built_for, given) = (self.object_count, mirrors.scene.objects.len());
        if built_for == given {
            return Ok(PanoramicProjector::new(self, mirrors));
        }
        let problem = format!("panoramic cameras of a scene with {built_for} objects do not fit one with {given}");
        Err(RenderError::Limit { method: SampleBasedCameraSettings::METHOD, problem })
    }
}

/// Projects scene points by [`PanoramicCameras`].
pub struct PanoramicProjector<'a> {
    eye: Vec3,
    paths: &'a [SpecularPath],
    faces: Vec<FaceProjector<'a>>,
    /// Answers of two faces that are farther from each other than this, in radians, are two.
    same: f32,
}

struct FaceProjector<'a> {
    face: &'a PanoramaFace,
    cameras: CameraProjector<'a>,
    rays: ViewRays,
    eye: Vec3,
    /// Half faces a pixel, and radians a pixel in the middle.
    pixel: f32,
    /// The width, in half faces, of the border in which answers are compared with those of other faces.
    seam: f32,
}

/// An answer of a face.
#[derive(Clone, Copy, Debug)]
struct FaceCandidate {
    face: usize,
    /// True if its direction is in that face, and not in the next one.
    owned: bool,
    at_seam: bool,
    seen: PanoramicProjection,
}

/// An appearance in a face's picture, and the change of its reflection point with the scene point.
#[derive(Clone, Copy, Debug)]
struct FaceAppearance {
    seen: Projection,
    reflection_change: Mat3,
    normal: Vec3,
}

impl Appearance for FaceAppearance {
    fn new(seen: Projection, answer: &CameraProjection) -> Self {
        let [right, up] = answer.moves;
        let column = |axis: usize| right * answer.lateral[0][axis] + up * answer.lateral[1][axis];
        let reflection_change = Mat3::from_cols(column(0), column(1), column(2));
        Self { seen, reflection_change, normal: answer.normal.normalize_or_zero() }
    }

    fn projection(&self) -> &Projection {
        &self.seen
    }
}

#[derive(Default)]
struct PanoramaScratch {
    of_face: Vec<FaceAppearance>,
    candidates: Vec<FaceCandidate>,
}

thread_local! {
    static SCRATCH: RefCell<PanoramaScratch> = RefCell::default();
}

impl<'a> PanoramicProjector<'a> {
    pub(super) fn new(cameras: &'a PanoramicCameras, mirrors: &PanoramicMirrors<'a>) -> Self {
        let faces = cameras.faces.iter().map(|face| FaceProjector::new(cameras, face, mirrors));
        let same = SAME_CELLS * cameras.settings.spacing_px() * 2.0 / cameras.settings.size_px as f32;
        Self { eye: cameras.eye, paths: &cameras.paths, faces: faces.collect(), same }
    }

    /// The point from which is seen.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    /// The paths that can be asked for: [`PanoramicCameras::paths`].
    pub fn paths(&self) -> &'a [SpecularPath] {
        self.paths
    }

    /// Appends all appearances of a scene point on one path (an index into [`Self::paths`]) to `found`: none to many,
    /// each once, wherever the seams of the cube are.
    ///
    /// Never panics; points that are not finite appear nowhere. The same point always gives the same appearances. A
    /// point on a reflector does not appear in that reflector at itself. Things between a point and the mirror do not
    /// hide it. Where a reflector ends, appearances may continue beyond its border, by three quarters of the spacing of
    /// the rays. Where leaves interpolate between rays, errors may be up to the spacing of the rays
    /// ([`PanoramicProjection::error`] says so), and beyond the scene's box they are not bounded.
    pub fn project_on(&self, path: u32, point: Vec3, found: &mut Vec<PanoramicProjection>) {
        SCRATCH.with_borrow_mut(|PanoramaScratch { of_face, candidates }| {
            candidates.clear();
            for face in &self.faces {
                let Some(Some(group)) = face.face.group_of_path.get(path as usize) else { continue };
                of_face.clear();
                face.cameras.project_near(*group, point, None, of_face);
                candidates.extend(of_face.iter().filter_map(|seen| face.candidate(path, seen, *group)));
            }
            let kept = candidates.iter().filter(|&own| !own.at_seam || is_the_one(own, candidates, self.same));
            found.extend(kept.map(|candidate| candidate.seen));
        });
    }

    /// Appends all appearances of a scene point to `found`, in the order of their paths: see [`Self::project_on`].
    pub fn project(&self, point: Vec3, found: &mut Vec<PanoramicProjection>) {
        for path in 0..self.paths.len() as u32 {
            self.project_on(path, point, found);
        }
    }
}

/// True if an answer beside a seam is the one to be kept of all faces' answers that mean the same appearance: the first
/// that is in its own face, or if each face has it in the other, the first. So where faces do not quite agree nothing
/// is lost and nothing is seen twice.
fn is_the_one(own: &FaceCandidate, all: &[FaceCandidate], same: f32) -> bool {
    let rank = |candidate: &FaceCandidate| (!candidate.owned, candidate.face);
    let distance = |a: &FaceCandidate, b: &FaceCandidate| a.seen.direction.distance(b.seen.direction);
    let nearest = |to: &FaceCandidate, face: usize| {
        let others = all.iter().filter(|other| other.face == face && other.seen.focal_index == to.seen.focal_index);
        others.min_by(|a, b| distance(to, a).total_cmp(&distance(to, b)))
    };
    // Beside folds appearances come close to each other: the same are those that are nearest to each other.
    let is_better = |face: usize| {
        let other = nearest(own, face).filter(|&other| face != own.face && distance(own, other) <= same);
        other.is_some_and(|other| {
            rank(other) < rank(own) && nearest(other, own.face).is_some_and(|back| std::ptr::eq(back, own))
        })
    };
    !(0..FACES).any(is_better)
}

impl<'a> FaceProjector<'a> {
    fn new(cameras: &'a PanoramicCameras, face: &'a PanoramaFace, mirrors: &PanoramicMirrors<'a>) -> Self {
        let (settings, scene) = (&cameras.settings, mirrors.scene);
        let view = cameras.view(face.number);
        let pixel = 2.0 / settings.size_px as f32;
        let cameras = CameraProjector {
            left_out: &[],
            holes: Vec::new(),
            grid: &face.grid,
            cameras: &face.cameras,
            paths: face.grid.groups.iter().map(|group| group.path.clone()).collect(),
            eye: eye_of(&view),
            view: PreciseView::new(&view),
            field: ViewField::new(&view, settings.margin_px()),
            scene,
            tracer: mirrors.tracer.clone(),
            surfaces: SpecularSurfaces::with_topologies(scene, &mirrors.topologies),
            margin_px: settings.margin_px().into(),
            accuracies_px: face.grid.groups.iter().map(|group| settings.accuracy_of(&group.path)).collect(),
            polish: settings.polish,
            sizes: scene.objects.iter().map(|object| f64::from(object.bounds.diagonal())).collect(),
        };
        let eye = view.eye();
        Self { face, cameras, rays: view.rays(), eye, pixel, seam: SEAM_CELLS * settings.spacing_px() * pixel }
    }

    /// Direction of a point by the face's cameras; returns `None` if another face owns it.
    fn candidate(&self, path: u32, found: &FaceAppearance, group: u32) -> Option<FaceCandidate> {
        let FaceAppearance { seen, reflection_change, normal } = found;
        let Vec2 { x, y } = seen.image_px;
        let (ray, change) = self.rays.ray_with_differential(x, y);
        let beyond = beyond(self.face.number, ray.direction);
        if beyond.is_nan() || beyond > self.seam {
            return None;
        }
        let [across, down] = [change.direction_dx, change.direction_dy];
        let [by_x, by_y] = seen.image_change;
        let column = |axis: usize| across * by_x[axis] + down * by_y[axis];
        // Over the wide field of a face the leaves' polynomials for lengths are poor: one segment is measured instead.
        let media = &self.face.media;
        let measured = media
            .get(group as usize)
            .copied()
            .flatten()
            .map(|[before, behind]| before * seen.reflection_point.distance(self.eye) + behind * seen.last_segment);
        let projection = PanoramicProjection {
            path,
            focal_index: seen.focal_index,
            reflection_point: seen.reflection_point,
            direction: ray.direction,
            direction_change: Mat3::from_cols(column(0), column(1), column(2)),
            reflection_change: *reflection_change,
            normal: *normal,
            path_length: measured.unwrap_or(seen.path_length),
            last_segment: seen.last_segment,
            // A pixel is widest across the way to the middle of the face.
            error: seen.error_px * self.pixel / self.rays.direction(x, y).length(),
        };
        let face = self.face.number;
        Some(FaceCandidate {
            face,
            owned: owner(ray.direction) == face,
            at_seam: beyond > -self.seam,
            seen: projection,
        })
    }
}

impl std::fmt::Debug for PanoramicProjector<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (paths, faces) = (self.paths.len(), self.faces.len());
        formatter.debug_struct("PanoramicProjector").field("paths", &paths).field("faces", &faces).finish()
    }
}
