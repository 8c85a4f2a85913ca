//! The library call behind `catoptric project`: all specular paths between an eye and scene points.
//!
//! # The appearance of a vertex in a mirror (graphics)
//!
//! ```
//! use catoptric::methods::projection::find::exact_search::{ExactSearch, SearchSettings};
//! use catoptric::methods::path_query::PathSearch;
//! use catoptric::progress::Silent;
//! use catoptric_scenes::builtin;
//!
//! let scene = builtin::load("sphere_room", &[]).unwrap().pose(&Default::default()).unwrap();
//! let view = scene.default_view(640, 480);
//! let (eye, objects) = (view.eye().as_dvec3(), scene.specular_objects());
//! let search = ExactSearch::new(&scene, eye, 1, &objects, &SearchSettings::default(), &Silent).unwrap();
//! let mut found = Vec::new();
//! for position in scene.positions.iter().take(100) {
//!     found.clear();
//!     search.search(position.as_dvec3(), &mut found);
//!     for path in &found {
//!         // The virtual vertex: in the picture where the bounce point is, as deep as the path is long.
//!         if let Some(pixel) = view.pixel_of_exact(path.bounce_points[0]) {
//!             assert!(pixel.is_finite() && path.optical_length > 0.0 && path.residual < 1e-9);
//!         }
//!     }
//! }
//! ```
//!
//! # The picture of a landmark in a mirror ball (catadioptric vision)
//!
//! The forward projection of a catadioptric camera, with the derivatives that bundle adjustment needs.
//!
//! ```
//! use catoptric::methods::projection::find::exact_search::{ExactSearch, SearchSettings};
//! use catoptric::methods::path_query::PathSearch;
//! use catoptric::scene::model::{AnalyticAsset, Model, Node};
//! use catoptric::scene::{Camera, Material, View};
//! use catoptric::progress::Silent;
//! use catoptric::surface::AnalyticSurface;
//! use glam::{DVec3, Vec3};
//!
//! let mut model = Model { materials: vec![Material::mirror("chrome", Vec3::ONE)], ..Model::default() };
//! let surface = AnalyticSurface::Sphere { radius: 0.05 }; // metres
//! let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
//! model.nodes.push(Node { name: "ball".into(), analytic, ..Node::default() });
//! let scene = model.pose(&Default::default()).unwrap();
//!
//! let camera = Camera::look_at("camera", Vec3::new(0.0, 0.0, 0.4), Vec3::ZERO, Vec3::Y, 20.0);
//! let view = View::new(&camera, 1280, 960, 1e-4);
//! let search = ExactSearch::new(&scene, view.eye().as_dvec3(), 1, &[0], &SearchSettings::default(), &Silent).unwrap();
//! let landmark = DVec3::new(0.8, 0.3, 0.6);
//! let mut found = Vec::new();
//! search.search(landmark, &mut found);
//! let path = found[0]; // a convex mirror shows every point once
//! let pixel = view.pixel_of_exact(path.bounce_points[0]).unwrap();
//! // The mirror law holds at the bounce: the normal halves the angle.
//! let at = path.bounce_points[0];
//! let (to_eye, to_point) = ((view.eye().as_dvec3() - at).normalize(), (landmark - at).normalize());
//! assert!((to_eye + to_point).cross(at.normalize()).length() < 1e-9);
//! // Moving the landmark moves the bounce point by the Jacobian, and the pixel with it.
//! let step = DVec3::new(1e-4, 0.0, 0.0);
//! let moved = view.pixel_of_exact(at + path.jacobian * step).unwrap();
//! found.clear();
//! search.search(landmark + step, &mut found);
//! let exact = view.pixel_of_exact(found[0].bounce_points[0]).unwrap();
//! assert!((moved - exact).length() < 1e-2 * (exact - pixel).length());
//! ```
//!
//! # The paths and delays of a signal (radio)
//!
//! All paths of up to two bounces from a transmitter to a receiver by a round tower and the ground, with their
//! delays. Visibility is that among reflectors; antenna patterns and reflection coefficients are the caller's.
//!
//! ```
//! use catoptric::methods::projection::find::exact_search::{ExactSearch, SearchSettings};
//! use catoptric::methods::path_query::PathSearch;
//! use catoptric::scene::model::{AnalyticAsset, LocalTransform, Model, Node};
//! use catoptric::scene::Material;
//! use catoptric::progress::Silent;
//! use catoptric::surface::AnalyticSurface;
//! use glam::{DVec3, Vec3};
//!
//! let mut model = Model { materials: vec![Material::mirror("metal", Vec3::ONE)], ..Model::default() };
//! let mut place = |name: &str, surface, center| {
//!     let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
//!     model.nodes.push(Node { name: name.into(), analytic, local: LocalTransform::at(center), ..Node::default() });
//! };
//! place("ground", AnalyticSurface::Plane { half_width: 100.0, half_height: 100.0 }, Vec3::ZERO);
//! place("dome", AnalyticSurface::Sphere { radius: 12.0 }, Vec3::new(0.0, 4.0, -30.0));
//! let scene = model.pose(&Default::default()).unwrap();
//!
//! let (transmitter, receiver) = (Vec3::new(-40.0, 10.0, 0.0), DVec3::new(40.0, 2.0, 0.0));
//! let (eye, objects) = (transmitter.as_dvec3(), scene.specular_objects());
//! let search = ExactSearch::new(&scene, eye, 2, &objects, &SearchSettings::default(), &Silent).unwrap();
//! let mut found = Vec::new();
//! search.search(receiver, &mut found);
//! const SPEED_OF_LIGHT: f64 = 299_792_458.0; // metres a second
//! let direct = receiver.distance(transmitter.as_dvec3());
//! let ways: Vec<(String, f64)> = found
//!     .iter()
//!     .map(|path| (search.paths()[path.path as usize].names(&scene), (path.optical_length - direct) / SPEED_OF_LIGHT))
//!     .collect();
//! // The ground's path is the shortest after the straight line: its length is that to the mirrored receiver.
//! assert_eq!(ways[0].0, "ground");
//! assert!((found[0].optical_length - (80f64.powi(2) + 12f64.powi(2)).sqrt()).abs() < 1e-9);
//! assert!(ways.iter().any(|(names, _)| names == "dome"));
//! assert!(ways.iter().all(|(_, delay)| *delay > 0.0));
//! ```

use crate::method::projector::{MAX_BOUNCES, SpecularPath};
use glam::{DMat3, DVec3};

/// One specular path from the eye to a scene point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FoundPath {
    /// Index of its sequence of bounces in [`PathSearch::paths`].
    pub path: u32,
    /// The number of its bounces.
    pub bounce_count: usize,
    /// The bounce points, from the eye; those beyond `bounce_count` are zero.
    pub bounce_points: [DVec3; MAX_BOUNCES],
    /// Focal points passed, summed over the path.
    pub focal_index: u32,
    /// Optical length from eye to point: inside a lens a segment counts its index of refraction times.
    pub optical_length: f64,
    /// The largest norm over the bounces of the specular constraint.
    pub residual: f64,
    /// The change of the first bounce point with the scene point (rows: components of the bounce point).
    pub jacobian: DMat3,
}

/// The outcome of the search for one point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SearchOutcome {
    /// The number of paths appended.
    pub found: usize,
    /// The point has infinitely many paths of some sequence of bounces; those are left out.
    pub infinite: bool,
    /// A limit has cut the search short: paths may be missing.
    pub cut_short: bool,
}

/// Finds all specular paths between one eye and scene points.
pub trait PathSearch: Sync {
    /// All sequences of bounces that found paths refer to.
    fn paths(&self) -> &[SpecularPath];

    /// Appends all paths to `point` to `found`, the shortest (optically) first. Never panics; points that are not
    /// finite have none.
    fn search(&self, point: DVec3, found: &mut Vec<FoundPath>) -> SearchOutcome;
}
