//! Cameras and views: rays through pixels, and pixels of points.

mod framing;

use crate::math::Aabb;
use crate::math::portable::PortableMath;
use glam::{Affine3A, DAffine3, DMat3, DVec2, DVec3, Mat3, Mat3A, Vec2, Vec3, Vec3A};

/// A camera's map from directions to the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A pinhole; the vertical field of view in radians, the horizontal one follows from the picture's shape.
    Perspective {
        /// Vertical field of view.
        fov_y: f32,
    },
    /// Parallel rays; half the height of the picture, in scene units.
    Orthographic {
        /// Half the height of the picture.
        half_height: f32,
    },
}

/// A named camera placed in the world. It looks along its own -z, y is up (glTF).
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The camera's name; may be empty.
    pub name: String,
    /// A second name to find it by; may be empty.
    pub other_name: String,
    /// The camera's place: rotation and translation only.
    pub world_from_camera: Affine3A,
    /// The projection onto the picture.
    pub projection: Projection,
}

impl Camera {
    /// A perspective camera at `eye` that looks at `target`; the field of view is vertical, in degrees.
    ///
    /// Never fails: where `up` and the direction are parallel, or eye and target coincide, another axis is taken.
    pub fn look_at(name: &str, eye: Vec3, target: Vec3, up: Vec3, fov_deg: f32) -> Self {
        Self {
            name: name.into(),
            other_name: String::new(),
            world_from_camera: placement(eye, target - eye, up),
            projection: Projection::Perspective { fov_y: fov_deg.clamp(0.01, 179.0).to_radians() },
        }
    }

    /// The point on its axis at the depth of a box's centre; where that is not in front, the box's size ahead.
    pub fn point_looked_at(&self, bounds: &Aabb) -> Vec3 {
        let eye = Vec3::from(self.world_from_camera.translation);
        let forward = -Vec3::from(self.world_from_camera.matrix3.z_axis);
        let depth = (bounds.center() - eye).dot(forward);
        let depth = if depth > bounds.diagonal() * 1e-8 { depth } else { bounds.diagonal() };
        eye + forward * depth
    }
}

fn placement(eye: Vec3, forward: Vec3, up: Vec3) -> Affine3A {
    let back = (-forward).try_normalize().unwrap_or(Vec3::Z);
    let right =
        up.cross(back).try_normalize().filter(|_| up.is_finite()).unwrap_or_else(|| back.any_orthonormal_vector());
    let up = back.cross(right);
    Affine3A { matrix3: Mat3A::from_cols(right.into(), up.into(), back.into()), translation: eye.into() }
}

/// A ray; the direction is of unit length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The origin.
    pub origin: Vec3,
    /// The direction, unit length.
    pub direction: Vec3,
}

/// The change of a ray from a pixel to its right and lower neighbour (Igehy 1999).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayDifferential {
    /// Change of the origin with the pixel's column.
    pub origin_dx: Vec3,
    /// Change of the origin with the pixel's row.
    pub origin_dy: Vec3,
    /// Change of the unit direction with the pixel's column.
    pub direction_dx: Vec3,
    /// Change of the unit direction with the pixel's row.
    pub direction_dy: Vec3,
}

impl RayDifferential {
    /// The changes for a share of a pixel.
    #[inline(always)]
    #[must_use]
    pub fn scaled(&self, share: f32) -> Self {
        let Self { origin_dx, origin_dy, direction_dx, direction_dy } = *self;
        Self {
            origin_dx: origin_dx * share,
            origin_dy: origin_dy * share,
            direction_dx: direction_dx * share,
            direction_dy: direction_dy * share,
        }
    }

    /// The solid angle between the directions of neighbouring rays.
    #[inline]
    pub fn solid_angle(&self) -> f32 {
        self.direction_dx.cross(self.direction_dy).length()
    }

    /// The changes of rays that each stand for a cone of so many radians across, about a unit direction: longer, at
    /// right angles to each other and to the ray.
    #[must_use]
    pub fn widened(&self, direction: Vec3, width: f32) -> Self {
        let across = self.direction_dx.reject_from_normalized(direction);
        let across = across.try_normalize().unwrap_or_else(|| direction.any_orthonormal_vector());
        let along = direction.cross(across);
        let [dx, dy] = [self.direction_dx.length(), self.direction_dy.dot(along).abs()];
        Self { direction_dx: across * dx.hypotenuse(width), direction_dy: along * dy.hypotenuse(width), ..*self }
    }

    /// The change of the point where the ray meets a plane at `distance` (Igehy 1999, equation 10).
    #[inline]
    pub fn transferred(&self, ray: &Ray, distance: f32, normal: Vec3) -> [Vec3; 2] {
        let cosine = ray.direction.dot(normal);
        let inverse = if cosine.abs() > 1e-12 * normal.length() { 1.0 / cosine } else { 0.0 };
        let moved_x = self.origin_dx + self.direction_dx * distance;
        let moved_y = self.origin_dy + self.direction_dy * distance;
        [
            moved_x - ray.direction * (moved_x.dot(normal) * inverse),
            moved_y - ray.direction * (moved_y.dot(normal) * inverse),
        ]
    }
}

/// A camera with a picture size.
///
/// Picture coordinates are pixels from the top left corner of the picture, x to the right, y down; the centre of
/// the first pixel is (0.5, 0.5).
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// The camera's place: a rotation and a translation, or, for mirrored views, a reflection and a translation.
    pub world_from_view: Affine3A,
    /// The projection onto the picture.
    pub projection: Projection,
    /// Picture width in pixels.
    pub width: u32,
    /// Picture height in pixels.
    pub height: u32,
    /// Points nearer than this in front of the eye are not drawn.
    pub near: f32,
}

impl View {
    /// The view of `camera` on a picture of `width` times `height` pixels.
    pub fn new(camera: &Camera, width: u32, height: u32, near: f32) -> Self {
        Self { world_from_view: camera.world_from_camera, projection: camera.projection, width, height, near }
    }

    /// The eye: the origin of all rays of a perspective view.
    #[inline]
    pub fn eye(&self) -> Vec3 {
        self.world_from_view.translation.into()
    }

    /// True if rays of the view may start within a box: the eye is in it, or in orthographic views the plane that rays
    /// start from cuts it.
    pub fn may_start_within(&self, bounds: &Aabb) -> bool {
        match self.projection {
            Projection::Perspective { .. } => bounds.contains(self.eye()),
            Projection::Orthographic { .. } => {
                let axis = Vec3::from(self.world_from_view.matrix3.z_axis);
                let depth = (bounds.center() - self.eye()).dot(axis);
                depth.abs() <= (bounds.size() * 0.5).dot(axis.abs())
            }
        }
    }

    /// True if something with these corners or vertices may be seen: not all lie before the near plane, or beyond the
    /// same side of the picture.
    pub fn may_show(&self, points: impl IntoIterator<Item = Vec3>) -> bool {
        let transform = self.picture_from_world();
        let (size_px, mut beside) = (Vec2::new(self.width as f32, self.height as f32), [true; 5]);
        for position in points {
            let point = transform.apply(position);
            let sides = [
                point.depth < self.near,
                point.xy.x < 0.0,
                point.xy.y < 0.0,
                point.xy.x > size_px.x * point.w,
                point.xy.y > size_px.y * point.w,
            ];
            for (beside, side) in beside.iter_mut().zip(sides) {
                *beside &= side;
            }
        }
        !beside.contains(&true)
    }

    /// The size of a pixel at distance 1 (perspective) or anywhere (orthographic).
    #[inline]
    pub fn pixel_size(&self) -> f32 {
        let half = match self.projection {
            Projection::Perspective { fov_y } => (fov_y * 0.5).tangent(),
            Projection::Orthographic { half_height } => half_height,
        };
        2.0 * half / self.height as f32
    }

    /// The rays of all positions of the picture. Worth keeping for many rays.
    #[inline]
    pub fn rays(&self) -> ViewRays {
        let pixel_size = self.pixel_size();
        let axes = self.world_from_view.matrix3;
        let right = axes.x_axis * pixel_size;
        let down = axes.y_axis * -pixel_size;
        let corner = right * (-0.5 * self.width as f32) + down * (-0.5 * self.height as f32);
        let eye = self.world_from_view.translation;
        let forward = -axes.z_axis;
        match self.projection {
            Projection::Perspective { .. } => {
                ViewRays { perspective: true, origin: eye, direction: forward + corner, right, down }
            }
            Projection::Orthographic { .. } => {
                ViewRays { perspective: false, origin: eye + corner, direction: forward.normalize(), right, down }
            }
        }
    }

    /// The ray through a picture position.
    #[inline]
    pub fn ray(&self, x_px: f32, y_px: f32) -> Ray {
        self.rays().ray(x_px, y_px)
    }

    /// The ray through a picture position and its change a pixel.
    #[inline]
    pub fn ray_with_differential(&self, x_px: f32, y_px: f32) -> (Ray, RayDifferential) {
        self.rays().ray_with_differential(x_px, y_px)
    }

    /// Homogeneous picture coordinates of a world point: (x w, y w, w); w is the depth along the view axis for
    /// perspective views, and 1 for orthographic ones. The fourth number is the depth along the axis for both.
    #[inline]
    pub fn picture_from_world(&self) -> PictureTransform {
        let view_from_world = self.world_from_view.inverse();
        PictureTransform {
            view_from_world,
            pixels_per_unit: 1.0 / self.pixel_size(),
            center: Vec2::new(self.width as f32, self.height as f32) * 0.5,
            perspective: matches!(self.projection, Projection::Perspective { .. }),
        }
    }

    /// Like [`Self::picture_from_world`], for points that `world_from_moved` moves first.
    ///
    /// The product is taken in double precision, so that far moves do not cost any.
    pub fn picture_from_moved(&self, world_from_moved: &DAffine3) -> PictureTransform {
        let place = &self.world_from_view;
        let world_from_view = DAffine3 {
            matrix3: Mat3::from(place.matrix3).as_dmat3(),
            translation: Vec3::from(place.translation).as_dvec3(),
        };
        let view_from_moved = world_from_view.inverse() * *world_from_moved;
        PictureTransform { view_from_world: view_from_moved.as_affine3a(), ..self.picture_from_world() }
    }

    /// The picture position of a world point, or `None` if it is nearer than the near plane or behind the eye.
    #[inline]
    pub fn pixel_of(&self, point: Vec3) -> Option<Vec2> {
        let projected = self.picture_from_world().apply(point);
        (projected.depth >= self.near).then(|| projected.xy / projected.w)
    }

    /// Like [`Self::pixel_of`], computed in double precision from the view's single-precision numbers.
    #[inline]
    pub fn pixel_of_exact(&self, point: DVec3) -> Option<DVec2> {
        let picture = PreciseView::new(self);
        let in_front = picture.depth_of(point) >= self.near as f64;
        picture.place_of(point).filter(|_| in_front).map(DVec2::from)
    }
}

/// A view's projection in double precision.
#[derive(Clone, Copy, Debug)]
pub struct PreciseView {
    origin: DVec3,
    right: DVec3,
    down: DVec3,
    forward: DVec3,
    center: [f64; 2],
    perspective: bool,
}

impl PreciseView {
    /// The projection of `view`.
    pub fn new(view: &View) -> Self {
        let axes = view.world_from_view.matrix3;
        let axis = |axis: Vec3A| Vec3::from(axis).as_dvec3();
        let half = match view.projection {
            Projection::Perspective { fov_y } => (fov_y as f64 * 0.5).tangent(),
            Projection::Orthographic { half_height } => half_height as f64,
        };
        let pixels_per_unit = view.height as f64 / (2.0 * half);
        Self {
            origin: view.eye().as_dvec3(),
            right: axis(axes.x_axis) * pixels_per_unit,
            down: axis(axes.y_axis) * -pixels_per_unit,
            forward: -axis(axes.z_axis),
            center: [view.width as f64 * 0.5, view.height as f64 * 0.5],
            perspective: matches!(view.projection, Projection::Perspective { .. }),
        }
    }

    /// Distance of a world point from the eye along the view axis.
    #[inline]
    pub fn depth_of(&self, point: DVec3) -> f64 {
        (point - self.origin).dot(self.forward)
    }

    /// The picture position of a world point, in pixels; returns `None` behind the eye.
    #[inline]
    pub fn place_of(&self, point: DVec3) -> Option<[f64; 2]> {
        let [[across], [along]] = self.places_of(&point.to_array().map(|coordinate| [coordinate]));
        (self.depth_of(point) > 0.0).then_some([across, along])
    }

    /// The same for several points, given by their coordinates: not a number behind the eye.
    #[inline(always)]
    pub fn places_of<const COUNT: usize>(&self, [x, y, z]: &[[f64; COUNT]; 3]) -> [[f64; COUNT]; 2] {
        let Self { origin, right, down, forward, center, perspective } = *self;
        let [mut across, mut along] = [[0.0; COUNT]; 2];
        for k in 0..COUNT {
            let [x, y, z] = [x[k] - origin.x, y[k] - origin.y, z[k] - origin.z];
            let depth = x * forward.x + y * forward.y + z * forward.z;
            let before = if depth > 0.0 { 1.0 } else { f64::NAN };
            let scale = before / if perspective { depth } else { 1.0 };
            across[k] = center[0] + (x * right.x + y * right.y + z * right.z) * scale;
            along[k] = center[1] + (x * down.x + y * down.y + z * down.z) * scale;
        }
        [across, along]
    }

    /// The matrix that turns a point, as seen from the eye, into its place in pixels times depth, and its depth;
    /// returns `None` for parallel rays.
    pub fn homogeneous(&self) -> Option<DMat3> {
        let [across, along] = self.center;
        let rows = DMat3::from_cols(self.right + self.forward * across, self.down + self.forward * along, self.forward);
        self.perspective.then(|| rows.transpose())
    }

    /// The change of the place with a step of the point: one gradient for x and one for y, in pixels a unit.
    #[inline]
    pub fn place_change(&self, point: DVec3) -> [DVec3; 2] {
        if !self.perspective {
            return [self.right, self.down];
        }
        let relative = point - self.origin;
        let inverse = 1.0 / relative.dot(self.forward);
        [self.right, self.down].map(|axis| (axis - self.forward * (relative.dot(axis) * inverse)) * inverse)
    }
}

/// The rays of a view: see [`View::rays`].
#[derive(Clone, Copy, Debug)]
pub struct ViewRays {
    /// All rays start at the eye; else they are parallel.
    pub perspective: bool,
    /// The eye, or the origin of the ray through the picture's corner.
    pub origin: Vec3A,
    /// Through the picture's corner at distance 1 along the axis, or the common direction.
    pub direction: Vec3A,
    /// The step to the next column.
    pub right: Vec3A,
    /// The step to the next row.
    pub down: Vec3A,
}

impl ViewRays {
    /// The direction of the ray through a picture position, of any length.
    #[inline]
    pub fn direction(&self, x_px: f32, y_px: f32) -> Vec3 {
        let offset = if self.perspective { self.right * x_px + self.down * y_px } else { Vec3A::ZERO };
        (self.direction + offset).into()
    }

    /// The ray through a picture position.
    #[inline]
    pub fn ray(&self, x_px: f32, y_px: f32) -> Ray {
        let offset = self.right * x_px + self.down * y_px;
        if self.perspective {
            Ray { origin: self.origin.into(), direction: (self.direction + offset).normalize().into() }
        } else {
            Ray { origin: (self.origin + offset).into(), direction: self.direction.into() }
        }
    }

    /// The ray through a picture position and its change a pixel.
    #[inline]
    pub fn ray_with_differential(&self, x_px: f32, y_px: f32) -> (Ray, RayDifferential) {
        let (right, down) = (self.right, self.down);
        if !self.perspective {
            let change =
                RayDifferential { origin_dx: right.into(), origin_dy: down.into(), ..RayDifferential::default() };
            return (self.ray(x_px, y_px), change);
        }
        // d = v / |v|, so dd = (dv - d (d . dv)) / |v|.
        let through = self.direction + right * x_px + down * y_px;
        let inverse_length = through.length_recip();
        let direction = through * inverse_length;
        let change = |step: Vec3A| Vec3::from((step - direction * direction.dot(step)) * inverse_length);
        let change =
            RayDifferential { direction_dx: change(right), direction_dy: change(down), ..RayDifferential::default() };
        (Ray { origin: self.origin.into(), direction: direction.into() }, change)
    }
}

/// A world point in the homogeneous coordinates of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PicturePoint {
    /// Picture position times `w`, in pixels.
    pub xy: Vec2,
    /// The homogeneous coordinate: depth for perspective views, 1 for orthographic ones.
    pub w: f32,
    /// Distance from the eye along the view axis.
    pub depth: f32,
}

/// Maps world points to [`PicturePoint`]s.
#[derive(Clone, Copy, Debug)]
pub struct PictureTransform {
    view_from_world: Affine3A,
    pixels_per_unit: f32,
    center: Vec2,
    perspective: bool,
}

impl PictureTransform {
    /// The picture point of a world point.
    #[inline]
    pub fn apply(&self, point: Vec3) -> PicturePoint {
        let p = self.view_from_world.transform_point3(point);
        let depth = -p.z;
        let w = if self.perspective { depth } else { 1.0 };
        let xy = Vec2::new(p.x, -p.y) * self.pixels_per_unit + self.center * w;
        PicturePoint { xy, w, depth }
    }

    /// The picture position of a point, and the change of its x and of its y with the point (pixels a scene unit);
    /// none in the eye's plane (perspective views).
    #[inline]
    pub fn pixel_with_change(&self, point: Vec3) -> Option<(Vec2, [Vec3; 2])> {
        let p = self.view_from_world.transform_point3(point);
        let rows = self.view_from_world.matrix3.transpose();
        let [right, up, back] = [rows.x_axis, rows.y_axis, rows.z_axis].map(Vec3::from);
        let scale = if self.perspective { 1.0 / -p.z } else { 1.0 };
        // Only in perspective does the depth matter: d(x / -z) = (dx + x/(-z) dz) / -z.
        let narrowing = if self.perspective { scale } else { 0.0 };
        let position = self.center + Vec2::new(p.x, -p.y) * (self.pixels_per_unit * scale);
        let change = |axis: Vec3, at: f32| (axis + back * (at * narrowing)) * (self.pixels_per_unit * scale);
        let changes = [change(right, p.x), -change(up, p.y)];
        (position.is_finite() && changes.iter().all(|change| change.is_finite())).then_some((position, changes))
    }
}
