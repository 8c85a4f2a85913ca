//! Profiles of optical surfaces: the height over the vertex by the distance from the axis.

use super::super::super::key_error::{KeyError, wrong};
use super::sheet::{Form, Sheet, Window};
use catoptric_core::surface::{AnalyticSurface, Implicit, Quadric};
use glam::{DMat3, DQuat, DVec3};

/// A conic with even terms: `c r^2 / (1 + sqrt(1 - (1 + k) c^2 r^2)) + a r^4 + b r^6 + ...` over the vertex, along the
/// axis y.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Profile {
    /// One over the radius of curvature at the vertex, whose centre lies at +y if it is positive; 0: flat.
    pub(super) curvature: f64,
    /// The conic constant k: -1 for paraboloids, 0 for spheres.
    pub(super) conic: f64,
    /// The factors of `r^4`, `r^6`, `r^8` and `r^10`.
    pub(super) terms: [f64; 4],
}

/// Steps in which a profile is looked at.
const STEPS: u32 = 512;
/// Room for rounding beside bounds that a surface touches, as a share of lengths.
const ROUNDING: f64 = 1e-9;
/// Room beside bounds that must not cut, as a share of the height.
const ROOM: f64 = 0.05;

impl Profile {
    pub(super) fn is_flat(&self) -> bool {
        self.curvature == 0.0 && !self.has_terms()
    }

    fn has_terms(&self) -> bool {
        self.terms.iter().any(|term| *term != 0.0)
    }

    /// The largest distance from the axis at which there is a surface.
    pub(super) fn reach(&self) -> f64 {
        match (1.0 + self.conic) * self.curvature * self.curvature {
            square if square > 0.0 => 1.0 / square.sqrt(),
            _ => f64::INFINITY,
        }
    }

    /// The height at a distance from the axis, within [`Self::reach`].
    pub(super) fn sag(&self, distance: f64) -> f64 {
        let square = distance * distance;
        let root = (1.0 - (1.0 + self.conic) * (self.curvature * self.curvature * square)).max(0.0).sqrt();
        let even = self.terms.iter().rev().fold(0.0, |sum, term| sum * square + term);
        self.curvature * square / (1.0 + root) + even * square * square
    }

    /// The part within a window, whose outer side is at +y if `is_up`, else at -y.
    pub(super) fn sheet(&self, window: &Window, is_up: bool) -> Result<Sheet, KeyError> {
        let (far, reach) = (window.farthest(), self.reach());
        if far > reach * (1.0 + ROUNDING) {
            let problem = format!("reaches {far} from the axis; the surface ends at {reach}");
            return wrong(window.key(), problem);
        }
        match window {
            Window::Round { radius, center } if *center == DVec3::ZERO && self.is_flat() => {
                Ok(Sheet::in_place(Form::Disk { radius: *radius, is_up }))
            }
            Window::Round { center, .. } if *center != DVec3::ZERO && !self.has_terms() => {
                self.tilted_sheet(window, is_up)
            }
            Window::Round { center, .. } if *center != DVec3::ZERO => wrong(
                "aperture_center",
                "is for conics, or for rectangles of `aperture_size`: leave out the coefficients",
            ),
            _ => self.straight_sheet(window, is_up),
        }
    }

    /// A part that bounds along the axes cut out: a rectangle, or a round one about the axis, which ends in one height.
    fn straight_sheet(&self, window: &Window, is_up: bool) -> Result<Sheet, KeyError> {
        let (near, far) = (window.nearest(), window.farthest());
        let at = |step: u32| self.sag(near + (far - near) * f64::from(step) / f64::from(STEPS));
        let heights: Vec<f64> = (0..=STEPS).map(at).collect();
        let (low, high) =
            heights.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(*y), high.max(*y)));
        let room = (ROOM * (high - low)).max(1e-6 * far);
        let is_conic = !self.has_terms();
        // A conic has another half about a middle at this height.
        let middle = 1.0 / (self.curvature * (1.0 + self.conic));
        let (mut low_bound, mut high_bound) = (low - room, high + room);
        if is_conic && middle.is_finite() {
            (low_bound, high_bound) =
                if middle > 0.0 { (low_bound, high_bound.min(middle)) } else { (low_bound.max(middle), high_bound) };
        }
        let [min, max] = window.corners();
        if let Window::Round { radius, .. } = window {
            // The rim has one height, and the surface passes it once.
            let rim = self.sag(*radius);
            let beyond = (radius * std::f64::consts::SQRT_2).min(self.reach());
            let is_rising = rim > 0.0;
            let further = (0..=STEPS).map(|step| self.sag(beyond * f64::from(step) / f64::from(STEPS)));
            let further: Vec<f64> = further.collect();
            if !further.windows(2).all(|pair| (pair[1] > pair[0]) == is_rising) {
                let problem = "the surface must rise, or fall, all the way to 1.42 times it: take a smaller one, or a \
                               rectangle of `aperture_size`";
                return wrong("aperture_radius", problem);
            }
            if is_rising { high_bound = rim } else { low_bound = rim }
        }
        let (min, max) = (min.with_y(low_bound).to_array(), max.with_y(high_bound).to_array());
        let no_part = |error| window.wrong_part(&error);
        let surface = if is_conic {
            AnalyticSurface::Quadric(Quadric::new(self.coefficients(is_up), min, max).map_err(no_part)?)
        } else {
            AnalyticSurface::Implicit(Implicit::new(&self.expression(is_up), min, max).map_err(no_part)?)
        };
        Ok(Sheet::in_place(Form::Exact(Box::new(surface))))
    }

    /// The conic's polynomial, positive on its outer side: near the vertex a length.
    fn coefficients(&self, is_up: bool) -> [f64; 10] {
        let side = if is_up { 1.0 } else { -1.0 };
        let across = -0.5 * self.curvature * side;
        [across, across * (1.0 + self.conic), across, 0.0, 0.0, 0.0, 0.0, side, 0.0, 0.0]
    }

    /// The height over the surface, or below it, as an expression.
    fn expression(&self, is_up: bool) -> String {
        let Self { curvature, conic, terms: [a, b, c, d] } = self;
        let square = "(x^2 + z^2)";
        let bend = (1.0 + conic) * curvature * curvature;
        let base = format!("{square} * ({curvature:e}) / (1 + sqrt(1 - ({bend:e}) * {square}))");
        let even = format!("({a:e} + {square} * ({b:e} + {square} * ({c:e} + {square} * ({d:e}))))");
        let sag = format!("{base} + {square}^2 * {even}");
        if is_up { format!("y - ({sag})") } else { format!("({sag}) - y") }
    }

    /// A round part off the axis of a conic: a plane along the tangent plane at its middle cuts it off, as wide across
    /// as the window. Of a paraboloid the rim is a circle as seen along the axis, of a sphere a circle.
    fn tilted_sheet(&self, window: &Window, is_up: bool) -> Result<Sheet, KeyError> {
        let Window::Round { radius, center } = window else { return self.straight_sheet(window, is_up) };
        let distance = center.length();
        let point = DVec3::new(center.x, self.sag(distance), center.z);
        let coefficients = self.coefficients(true);
        let curved = DMat3::from_diagonal(DVec3::new(coefficients[0], coefficients[1], coefficients[2]));
        let gradient = curved * point * 2.0 + DVec3::Y;
        let (slope, normal) = (gradient.length(), gradient.normalize());
        let across = DVec3::Y.cross(*center).normalize();
        let outwards = normal.cross(across) * normal.cross(across).dot(*center).signum();
        // Axes: away from the conic's axis, along the normal, and across.
        let axes = DMat3::from_cols(outwards, normal, outwards.cross(normal));
        let turned = axes.transpose() * curved * axes;
        let [along, lift, wide] = [turned.x_axis.x, turned.x_axis.y, turned.z_axis.z];
        // Sections at a height h are ellipses: along (s - s0)^2 + wide t^2 + rise h^2 + slope h = 0.
        let rise = turned.y_axis.y - lift * lift / along;
        let discriminant = slope * slope - 4.0 * rise * wide * radius * radius;
        if discriminant < 0.0 || !discriminant.is_finite() {
            return wrong("aperture_radius", format!("{radius}; no plane cuts the surface so wide about this middle"));
        }
        let height = -2.0 * wide * radius * radius / (slope + discriminant.sqrt());
        let extent = |share: u32| {
            let h = height * f64::from(share) / f64::from(STEPS);
            let half = (-(slope * h + rise * h * h) / along).max(0.0).sqrt();
            let middle = -lift * h / along;
            (middle - half, middle + half)
        };
        let extents = (0..=STEPS).map(extent);
        let (low, high) = extents.fold((0f64, 0f64), |(low, high), (a, b)| (low.min(a), high.max(b)));
        let room = 0.01 * (high - low);
        let beside = (ROOM * height.abs()).min(1e-2 / (self.curvature * (1.0 + self.conic)).abs()).copysign(-height);
        let (bottom, top) = if height > 0.0 { (beside, height) } else { (height, beside) };
        let wide_bound = radius * 1.001;
        let straight = axes.transpose() * (curved * point * 2.0 + DVec3::Y);
        let value = point.dot(curved * point) + point.y;
        let side = if is_up { 1.0 } else { -1.0 };
        let polynomial = [
            along,
            turned.y_axis.y,
            wide,
            2.0 * lift,
            2.0 * turned.y_axis.z,
            2.0 * turned.x_axis.z,
            straight.x,
            straight.y,
            straight.z,
            value,
        ];
        let polynomial = polynomial.map(|coefficient| coefficient * side);
        let (min, max) = ([low - room, bottom, -wide_bound], [high + room, top, wide_bound]);
        let surface =
            AnalyticSurface::Quadric(Quadric::new(polynomial, min, max).map_err(|error| window.wrong_part(&error))?);
        Ok(Sheet {
            name: "",
            form: Form::Exact(Box::new(surface)),
            at: point,
            turn: DQuat::from_mat3(&axes).normalize(),
        })
    }
}
