//! Fields of rays: the source of a ray map's rays, as the rays of a view are.

use catoptric_core::scene::{PreciseView, Projection, Ray, View, ViewRays};
use catoptric_engine::light::path_tracer::NearPlane;
use catoptric_engine::optics::path::bundle::Eye;
use glam::DVec3;

/// Source of a ray map's rays: a two-dimensional field of rays, with coordinates in pixels.
pub trait RayField: Sync {
    /// The width and height, in pixels.
    fn size_px(&self) -> [f32; 2];

    /// Common data of all its rays.
    fn eye(&self) -> Eye;

    /// The ray at a place of the field, and from which distance on it counts.
    fn ray(&self, x_px: f32, y_px: f32) -> (Ray, f32);

    /// The place where a world point is seen; none behind the eye.
    fn place_of(&self, point: DVec3) -> Option<[f64; 2]>;

    /// The change of the two coordinates of [`Self::place_of`] with the point.
    fn place_change(&self, point: DVec3) -> [DVec3; 2];
}

/// Common data of the rays of a view.
pub fn eye_of(view: &View) -> Eye {
    match view.projection {
        Projection::Perspective { .. } => Eye::Point(view.eye().as_dvec3()),
        Projection::Orthographic { .. } => Eye::Direction(view.ray(0.0, 0.0).direction.as_dvec3().normalize()),
    }
}

/// The rays of a view, and of a margin around its picture.
pub struct ViewField {
    margin_px: f32,
    rays: ViewRays,
    near: NearPlane,
    size_px: [f32; 2],
    eye: Eye,
    picture: PreciseView,
}

impl ViewField {
    /// The rays of `view`, with so many pixels more on every side.
    pub fn new(view: &View, margin_px: f32) -> Self {
        Self {
            margin_px,
            rays: view.rays(),
            near: NearPlane::new(view),
            size_px: [view.width as f32 + 2.0 * margin_px, view.height as f32 + 2.0 * margin_px],
            eye: eye_of(view),
            picture: PreciseView::new(view),
        }
    }
}

impl RayField for ViewField {
    fn size_px(&self) -> [f32; 2] {
        self.size_px
    }

    fn eye(&self) -> Eye {
        self.eye
    }

    fn ray(&self, x_px: f32, y_px: f32) -> (Ray, f32) {
        let ray = self.rays.ray(x_px - self.margin_px, y_px - self.margin_px);
        (ray, self.near.distance(&ray))
    }

    fn place_of(&self, point: DVec3) -> Option<[f64; 2]> {
        let margin = f64::from(self.margin_px);
        self.picture.place_of(point).map(|[x, y]| [x + margin, y + margin])
    }

    fn place_change(&self, point: DVec3) -> [DVec3; 2] {
        self.picture.place_change(point)
    }
}
