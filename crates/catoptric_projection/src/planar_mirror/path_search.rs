//! All paths over flat mirrors to a point, in closed form.

use super::chain::{Chain, ChainStart};
use super::settings::PlanarMirrorSettings;
use crate::draw::flat_mirrors::Mirrors;
use catoptric_core::scene::Scene;
use catoptric_engine::error::RenderError;
use catoptric_engine::method::Settings;
use catoptric_engine::method::path_query::{FoundPath, PathSearch, SearchOutcome};
use catoptric_engine::method::projector::{MAX_BOUNCES, SpecularPath};
use glam::{DMat3, DVec3};
use std::collections::HashMap;

/// More sequences of mirrors than this are refused: each is tried for every point. Chosen, not measured.
const MAX_CHAINS: usize = 1 << 16;

/// Finds all paths over the flat mirrors of a scene: exactly, in double precision. Curved reflectors and lenses
/// have no part in them.
pub(super) struct MirrorSearch<'a> {
    scene: &'a Scene,
    mirrors: &'a Mirrors,
    eye: DVec3,
    paths: Vec<SpecularPath>,
    chains: Vec<ChainOfPath>,
}

struct ChainOfPath {
    chain: Chain,
    /// Flat parts of one object share their paths.
    path: u32,
    image_change: DMat3,
}

impl<'a> MirrorSearch<'a> {
    /// A search for paths of one to `order` bounces (at most [`MAX_BOUNCES`]) on these objects alone.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where there are more than 65,536 sequences of mirrors.
    pub(super) fn new(
        scene: &'a Scene,
        mirrors: &'a Mirrors,
        eye: DVec3,
        order: u32,
        objects: &[u32],
    ) -> Result<Self, RenderError> {
        let mut search = Self { scene, mirrors, eye, paths: Vec::new(), chains: Vec::new() };
        let usable: Vec<u32> = (0..mirrors.planes.len() as u32)
            .filter(|&plane| objects.contains(&mirrors.planes[plane as usize].object))
            .collect();
        let mut known: HashMap<SpecularPath, u32> = HashMap::new();
        let mut last = vec![Chain::default()];
        for _ in 0..order.min(MAX_BOUNCES as u32) {
            let mut longer = Vec::new();
            for chain in &last {
                // A plane never shows itself.
                let next = usable.iter().filter(|plane| chain.planes().last() != Some(plane));
                longer.extend(next.filter_map(|&plane| chain.extended(plane)));
                if search.chains.len() + longer.len() > MAX_CHAINS {
                    let problem = format!(
                        "more than {MAX_CHAINS} sequences of flat mirrors; allow fewer mirrors or a lower order"
                    );
                    return Err(RenderError::Limit { method: PlanarMirrorSettings::METHOD, problem });
                }
            }
            for &chain in &longer {
                let path = chain.path(mirrors);
                let paths = &mut search.paths;
                let path = *known.entry(path).or_insert_with_key(|path| {
                    paths.push(path.clone());
                    paths.len() as u32 - 1
                });
                search.chains.push(ChainOfPath { chain, path, image_change: chain.image_change(mirrors) });
            }
            last = longer;
        }
        Ok(search)
    }

    fn path(&self, candidate: &ChainOfPath, point: DVec3) -> Option<FoundPath> {
        let chain = &candidate.chain;
        let unfolded = chain.unfold(self.mirrors, ChainStart::Point(self.eye), point)?;
        let bounces = &unfolded.bounces[..chain.length];
        let on_mirrors = |(plane, at): (&u32, &DVec3)| self.mirrors.contains(self.scene, *plane, *at);
        if !chain.planes().iter().zip(bounces).all(on_mirrors) {
            return None;
        }
        // Where the line from the eye to the image meets the first mirror: x = e + s (p' - e), s = h_e / (h_e - h_p').
        let first = &self.mirrors.planes[chain.planes()[0] as usize];
        let (height, depth) = (first.height(self.eye), first.height(unfolded.image));
        let share = height / (height - depth);
        let tilt = (unfolded.image - self.eye) * (share / (height - depth));
        let n = first.normal;
        let turned = DMat3::from_cols(tilt * n.x, tilt * n.y, tilt * n.z);
        let jacobian = (DMat3::from_diagonal(DVec3::splat(share)) + turned) * candidate.image_change;
        let ends = |index: usize| {
            let before = if index == 0 { self.eye } else { bounces[index - 1] };
            (before, bounces.get(index + 1).copied().unwrap_or(point))
        };
        let residual = |index: usize| {
            let (before, after) = ends(index);
            let normal = self.mirrors.planes[chain.planes()[index] as usize].normal;
            let at = bounces[index];
            (before - at).normalize_or_zero().reject_from_normalized(normal)
                + (after - at).normalize_or_zero().reject_from_normalized(normal)
        };
        let residual = (0..chain.length).map(|index| residual(index).length()).fold(0.0, f64::max);
        let found = FoundPath {
            path: candidate.path,
            bounce_count: chain.length,
            bounce_points: unfolded.bounces,
            focal_index: 0,
            optical_length: unfolded.image.distance(self.eye),
            residual,
            jacobian,
        };
        (found.optical_length.is_finite() && jacobian.is_finite()).then_some(found)
    }
}

impl PathSearch for MirrorSearch<'_> {
    fn paths(&self) -> &[SpecularPath] {
        &self.paths
    }

    fn search(&self, point: DVec3, found: &mut Vec<FoundPath>) -> SearchOutcome {
        let start = found.len();
        if point.is_finite() {
            found.extend(self.chains.iter().filter_map(|candidate| self.path(candidate, point)));
        }
        let own = &mut found[start..];
        own.sort_by(|a, b| a.optical_length.total_cmp(&b.optical_length).then(a.path.cmp(&b.path)));
        SearchOutcome { found: own.len(), ..SearchOutcome::default() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use catoptric_core::scene::{Material, model::*};
    use catoptric_core::surface::AnalyticSurface;
    use glam::{Quat, Vec3};

    /// A floor (facing up) and a wall (facing +x, a square of triangles) that meet in the z axis, two units wide.
    fn corner(inside: bool) -> (Scene, Mirrors) {
        let mut model = Model { materials: vec![Material::mirror("", Vec3::ONE)], ..Model::default() };
        let surface = AnalyticSurface::Plane { half_width: 1.0, half_height: 1.0 };
        let analytic = Some(AnalyticAsset { surface, material: 0, inside });
        let local = LocalTransform::at(Vec3::new(1.0, 0.0, 0.0));
        model.nodes.push(Node { name: "floor".into(), analytic, local, ..Node::default() });
        let primitive = Primitive {
            positions: [(0.0, -1.0), (2.0, -1.0), (2.0, 1.0), (0.0, 1.0)].map(|(y, z)| Vec3::new(0.0, y, z)).to_vec(),
            normals: vec![Vec3::X; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Primitive::default()
        };
        model.meshes.push(MeshAsset { primitives: vec![primitive], ..MeshAsset::default() });
        model.nodes.push(Node { name: "wall".into(), mesh: Some(0), ..Node::default() });
        let scene = model.pose(&Default::default()).unwrap();
        let mirrors = Mirrors::find(&scene);
        (scene, mirrors)
    }

    fn found(search: &MirrorSearch<'_>, point: DVec3) -> Vec<(String, FoundPath)> {
        let mut paths = Vec::new();
        let outcome = search.search(point, &mut paths);
        assert_eq!((outcome.found, outcome.infinite), (paths.len(), false));
        let name = |path: &FoundPath| search.paths()[path.path as usize].names(search.scene);
        paths.iter().map(|path| (name(path), *path)).collect()
    }

    #[test]
    fn a_corner_has_the_reflections_of_the_textbook() {
        let (scene, mirrors) = corner(false);
        let eye = DVec3::new(1.2, 0.7, 0.25);
        let point = DVec3::new(0.5, 1.0, -0.5);
        let search = MirrorSearch::new(&scene, &mirrors, eye, 4, &[0, 1]).unwrap();
        let all = found(&search, point);
        let names: Vec<&str> = all.iter().map(|(name, _)| name.as_str()).collect();
        // One in each mirror; the image in both is one point behind the edge, met in the order of the path's side.
        let images = [DVec3::new(0.5, -1.0, -0.5), DVec3::new(-0.5, 1.0, -0.5), DVec3::new(-0.5, -1.0, -0.5)];
        assert_eq!(names, ["wall", "floor", "floor>wall"]);
        for ((_, path), image) in all.iter().zip([images[1], images[0], images[2]]) {
            assert!((path.optical_length - eye.distance(image)).abs() < 1e-14);
            assert!(path.residual < 1e-14 && path.focal_index == 0);
            let line = (image - eye).normalize();
            assert!((path.bounce_points[0] - eye).cross(line).length() < 1e-14);
        }
        let (_, both) = &all[2];
        assert!(both.bounce_points[0].y.abs() < 1e-15 && both.bounce_points[1].x.abs() < 1e-15);
    }

    #[test]
    fn jacobians_are_differences() {
        let (scene, mirrors) = corner(false);
        let (eye, point) = (DVec3::new(1.2, 0.7, 0.25), DVec3::new(0.5, 1.0, -0.5));
        let search = MirrorSearch::new(&scene, &mirrors, eye, 2, &[0, 1]).unwrap();
        for (index, (_, path)) in found(&search, point).iter().enumerate() {
            for (axis, column) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().zip(0..) {
                let at = |step: f64| found(&search, point + axis * step)[index].1.bounce_points[0];
                let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
                assert!((difference - path.jacobian.col(column)).length() < 1e-9, "{index} {axis}");
            }
        }
    }

    #[test]
    fn mirrors_end_where_they_end_and_have_sides() {
        let (scene, mirrors) = corner(false);
        let eye = DVec3::new(1.0, 1.0, 0.0);
        let floor = MirrorSearch::new(&scene, &mirrors, eye, 1, &[0]).unwrap();
        // By symmetry the bounce lies half way: the border is at x = 2.
        assert_eq!(found(&floor, DVec3::new(3.0, 1.0, 0.0)).len(), 1);
        assert_eq!(found(&floor, DVec3::new(3.0 + 1e-9, 1.0, 0.0)).len(), 0);
        // Behind the mirror, on it, and at no place at all.
        for nowhere in [DVec3::new(1.0, -0.5, 0.0), DVec3::new(1.5, 0.0, 0.0), DVec3::NAN, DVec3::INFINITY] {
            assert_eq!(found(&floor, nowhere).len(), 0, "{nowhere}");
        }
        assert!(found(&floor, DVec3::splat(1e300)).iter().all(|(_, path)| path.residual.is_finite()));
        let (scene, mirrors) = corner(true);
        let blind = MirrorSearch::new(&scene, &mirrors, eye, 1, &[0]).unwrap();
        assert_eq!(found(&blind, DVec3::new(1.5, 1.0, 0.0)).len(), 0);
        let below = MirrorSearch::new(&scene, &mirrors, -eye + DVec3::X * 2.0, 1, &[0]).unwrap();
        assert_eq!(found(&below, DVec3::new(1.5, -1.0, 0.0)).len(), 1);
    }

    #[test]
    fn no_bounce_falls_between_the_triangles_of_a_mirror() {
        let (scene, mirrors) = corner(false);
        let eye = DVec3::new(1.0, 1.0, 0.0);
        let search = MirrorSearch::new(&scene, &mirrors, eye, 1, &[1]).unwrap();
        // The eye's own reflections over the diagonal of the wall: the bounce of a point at the same distance is
        // half way between.
        for step in 0..=1000 {
            let along = f64::from(step) / 1000.0;
            let bounce = DVec3::new(0.0, 2.0 * along, 2.0 * along - 1.0);
            let point = DVec3::new(1.0, 2.0 * bounce.y - eye.y, 2.0 * bounce.z - eye.z);
            assert_eq!(found(&search, point).len(), 1, "{bounce}");
        }
    }

    #[test]
    fn sequences_without_end_are_refused() {
        let mut model = Model { materials: vec![Material::mirror("", Vec3::ONE)], ..Model::default() };
        for step in 0..60 {
            let surface = AnalyticSurface::Plane { half_width: 1.0, half_height: 1.0 };
            let analytic = Some(AnalyticAsset { surface, material: 0, inside: false });
            let rotation = Quat::from_rotation_x(step as f32 * 0.1);
            let local = LocalTransform::Parts { translation: Vec3::ZERO, rotation, scale: Vec3::ONE };
            model.nodes.push(Node { analytic, local, ..Node::default() });
        }
        let scene = model.pose(&Default::default()).unwrap();
        let mirrors = Mirrors::find(&scene);
        let all: Vec<u32> = (0..60).collect();
        assert!(MirrorSearch::new(&scene, &mirrors, DVec3::ONE, 2, &all).is_ok());
        let refused = MirrorSearch::new(&scene, &mirrors, DVec3::ONE, 3, &all).err().map(|error| error.to_string());
        assert!(refused.is_some_and(|message| message.contains("sequences")));
    }
}
