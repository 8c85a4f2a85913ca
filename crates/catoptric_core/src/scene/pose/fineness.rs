//! How fine the meshes of exact surfaces are: as fine as pictures ever need, or as all of a scene have room for.

use crate::surface::{AnalyticSurface, SurfaceMesh};
use std::sync::Arc;

/// The most triangles of all exact surfaces together: for larger numbers everything that goes over triangles takes
/// seconds. A dozen balls of the finest mesh have as many.
const MOST_TRIANGLES: f64 = 1_200_000.0;

/// From a fineness to the next: surfaces that differ little share a mesh.
const STEP: f64 = 0.84;

/// No mesh is coarser.
const COARSEST: f64 = 0.05;

/// The finenesses of a scene's exact surfaces.
///
/// All are off by the same length, so that larger ones have more triangles, and none has more than its finest mesh.
pub(super) struct Fineness {
    /// The share of the finest mesh's triangles, for each unit of a surface's size.
    share: f64,
}

impl Fineness {
    pub(super) fn of<'a>(surfaces: impl Iterator<Item = &'a AnalyticSurface>) -> Self {
        let counts: Vec<(f64, f64)> =
            surfaces.map(|surface| (surface.finest_triangle_count(), surface.size())).collect();
        let total = |share: f64| counts.iter().map(|(count, size)| count * (share * size).min(1.0)).sum::<f64>();
        if total(f64::INFINITY) <= MOST_TRIANGLES {
            return Self { share: f64::INFINITY };
        }
        // Surfaces are from 1e-9 to 1e9 long.
        let (mut low, mut high) = (1e-24, 1e24);
        for _ in 0..200 {
            let middle = f64::sqrt(low * high);
            *if total(middle) > MOST_TRIANGLES { &mut high } else { &mut low } = middle;
        }
        Self { share: low }
    }

    /// The share of cells along each direction that a surface's mesh has of its finest one.
    pub(super) fn of_surface(&self, surface: &AnalyticSurface) -> f64 {
        let along = (self.share * surface.size()).min(1.0).sqrt();
        let mut fineness = 1.0;
        while fineness > along && fineness > COARSEST {
            fineness *= STEP;
        }
        fineness
    }
}

/// Meshes of exact surfaces, shared by equal ones.
#[derive(Default)]
pub(super) struct SharedMeshes(Vec<(AnalyticSurface, f64, Arc<SurfaceMesh>)>);

/// Scenes have many equal surfaces or many different ones; more than this are not looked for.
const MOST_SHARED: usize = 16;

impl SharedMeshes {
    /// The mesh of a surface.
    pub(super) fn get(&mut self, surface: &AnalyticSurface, fineness: f64) -> Arc<SurfaceMesh> {
        let known = self.0.iter().find(|(other, fine, _)| (other, *fine) == (surface, fineness));
        if let Some((_, _, mesh)) = known {
            return mesh.clone();
        }
        let mesh = Arc::new(surface.tessellate_to(fineness));
        if self.0.len() == MOST_SHARED {
            self.0.remove(0);
        }
        self.0.push((surface.clone(), fineness, mesh.clone()));
        mesh
    }
}
