//! Picture points from places in a picture and path lengths.

use catoptric_core::math::portable::PortableMath;
use catoptric_core::scene::{PicturePoint, View};
use catoptric_engine::method::projector::Projection;
use catoptric_engine::raster::BlockMask;
use glam::Vec2;

/// Picture points from places in a picture and path lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureScale {
    pub(super) size_px: Vec2,
    /// Pixels per unit of the tangent of the angle to the view axis; none in orthographic views.
    focal_px: Option<f32>,
}

impl PictureScale {
    /// The scale of a view's picture.
    pub fn new(view: &View) -> Self {
        let size_px = Vec2::new(view.width as f32, view.height as f32);
        let focal_px = match view.projection {
            catoptric_core::scene::Projection::Perspective { fov_y } => Some(size_px.y * 0.5 / (fov_y * 0.5).tangent()),
            catoptric_core::scene::Projection::Orthographic { .. } => None,
        };
        Self { size_px, focal_px }
    }

    /// The depth of the place that lies the path's length away on the view ray.
    #[inline(always)]
    fn depth(&self, image_px: Vec2, path_length: f32) -> f32 {
        match self.focal_px {
            Some(focal_px) => depth_along(image_px - self.size_px * 0.5, path_length, focal_px),
            None => path_length,
        }
    }

    /// Divisor of depths: the homogeneous coordinate.
    #[inline]
    pub(super) fn w(&self, one: &Projection) -> f32 {
        if self.focal_px.is_some() { self.depth(one.image_px, one.path_length) } else { 1.0 }
    }

    /// An empty set of the picture's blocks.
    pub(super) fn no_blocks(&self) -> BlockMask {
        BlockMask::new([self.size_px.x, self.size_px.y].map(|pixels| pixels as usize))
    }

    /// True if places all lie beyond one side of the picture.
    pub(super) fn is_beside<const COUNT: usize>(&self, places: [Vec2; COUNT]) -> bool {
        let beyond = |is: &dyn Fn(Vec2) -> bool| places.into_iter().all(is);
        beyond(&|place| place.x < 0.0)
            || beyond(&|place| place.y < 0.0)
            || beyond(&|place| place.x > self.size_px.x)
            || beyond(&|place| place.y > self.size_px.y)
    }

    /// The point at the place of an appearance.
    pub(super) fn point(&self, one: &Projection) -> PicturePoint {
        let depth = self.depth(one.image_px, one.path_length);
        let w = if self.focal_px.is_some() { depth } else { 1.0 };
        PicturePoint { xy: one.image_px * w, w, depth }
    }

    /// The points at places, so far away on their paths, to the bit as [`Self::point`] has them.
    #[inline(always)]
    pub(super) fn points_at<const COUNT: usize>(
        &self,
        [across, down]: [&[f64; COUNT]; 2],
        lengths: &[f32; COUNT],
        points: &mut [PicturePoint; COUNT],
    ) {
        // Lists of numbers, so that many are done at once.
        let (mut x_px, mut y_px) = ([0.0f32; COUNT], [0.0f32; COUNT]);
        for k in 0..COUNT {
            (x_px[k], y_px[k]) = (across[k] as f32, down[k] as f32);
        }
        let (mut depths, mut w) = (*lengths, [1.0f32; COUNT]);
        if let Some(focal_px) = self.focal_px {
            let half = self.size_px * 0.5;
            for (k, depth) in depths.iter_mut().enumerate() {
                *depth = depth_along(Vec2::new(x_px[k], y_px[k]) - half, *depth, focal_px);
            }
            w = depths;
        }
        for (k, point) in points.iter_mut().enumerate() {
            *point = PicturePoint { xy: Vec2::new(x_px[k] * w[k], y_px[k] * w[k]), w: w[k], depth: depths[k] };
        }
    }
}

/// The depth of a point from its distance along the ray through a place, given in pixels from the picture's middle.
#[inline(always)]
fn depth_along(from_middle_px: Vec2, path_length: f32, focal_px: f32) -> f32 {
    path_length / (1.0 + (from_middle_px / focal_px).length_squared()).sqrt()
}
