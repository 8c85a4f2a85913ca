//! The manifold of specular surfaces: points on them and steps along them, for solvers of specular paths.

mod exact;
mod mesh;
mod topology;
mod vertex;

use catoptric_core::scene::hit::{Hit, PrimitiveHit};
use catoptric_core::scene::{Ray, Role, Scene};
use catoptric_core::surface::patch::SurfacePatch;
use catoptric_core::surface::{PlacedSurface, SurfaceHit};
use glam::{DVec2, DVec3};
use mesh::MeshManifold;
use std::sync::Arc;
use topology::Topology;
pub use topology::welded_vertices;
pub use vertex::{ManifoldFrame, ManifoldVertex, NO_TRIANGLE};

/// The arrival of a ray at a specular object, for rays without derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceArrival {
    /// The specular object.
    pub object: u32,
    /// The point on its surface.
    pub position: DVec3,
    /// The unit (shading) normal on the outer side.
    pub normal: DVec3,
    /// The unit normal of the flat triangle, on the outer side.
    pub geometric_normal: DVec3,
}

/// The representation of a specular object's surface.
enum SurfaceKind<'a> {
    Exact(&'a PlacedSurface),
    Mesh(MeshManifold<'a>),
}

struct SpecularObject<'a> {
    surface: SurfaceKind<'a>,
    index: f64,
    role: Role,
    inner_only: bool,
}

/// Neighbours of the triangles, and curvature at the vertices, of a scene's specular meshes.
///
/// Building takes some tenths of a second a million triangles; the result is valid until the meshes change.
#[derive(Clone, Default)]
pub struct MeshTopologies {
    /// One for each object that is a mesh and reflects or refracts.
    of_objects: Vec<Option<Arc<Topology>>>,
}

impl MeshTopologies {
    /// The topologies of all reflectors, lenses and coated objects of a scene that are meshes.
    pub fn of(scene: &Scene) -> Self {
        let topology = |(index, object): (usize, &catoptric_core::scene::Object)| {
            let is_mesh = scene.role_of(index as u32).is_specular() && object.surface.is_none();
            is_mesh.then(|| Arc::new(Topology::new(scene, object.triangles.clone(), object.vertices.clone())))
        };
        Self { of_objects: scene.objects.iter().enumerate().map(topology).collect() }
    }

    /// True if an object of the scene is a closed and convex mesh.
    pub fn is_convex(&self, object: u32) -> bool {
        self.of_objects.get(object as usize).is_some_and(|topology| topology.as_ref().is_some_and(|mesh| mesh.convex))
    }
}

/// The surfaces of a scene's specular objects, made ready for solvers.
pub struct SpecularSurfaces<'a> {
    entries: Vec<Option<SpecularObject<'a>>>,
    objects_of_triangles: &'a [u32],
}

impl<'a> SpecularSurfaces<'a> {
    /// The surfaces of all reflectors, lenses and coated objects of a scene.
    pub fn new(scene: &'a Scene) -> Self {
        Self::with_topologies(scene, &MeshTopologies::of(scene))
    }

    /// The same with the topologies of the scene's meshes, or of those of a scene that differs only in
    /// objects that are neither reflector nor lens.
    pub fn with_topologies(scene: &'a Scene, topologies: &MeshTopologies) -> Self {
        let entry = |(index, object): (usize, &'a catoptric_core::scene::Object)| {
            let material = scene.material_of(index as u32);
            if !material.role.is_specular() {
                return None;
            }
            let surface = match &object.surface {
                Some(surface) => SurfaceKind::Exact(surface),
                None => SurfaceKind::Mesh(MeshManifold::new(scene, object, topologies.of_objects.get(index)?.clone()?)),
            };
            let index = if material.role == Role::Lens { material.ior as f64 } else { 1.0 };
            Some(SpecularObject { surface, index, role: material.role, inner_only: object.inside })
        };
        Self {
            entries: scene.objects.iter().enumerate().map(entry).collect(),
            objects_of_triangles: &scene.triangle_objects,
        }
    }

    /// Bytes held beside the scene.
    pub fn byte_count(&self) -> u64 {
        let meshes = self.entries.iter().flatten().map(|entry| match &entry.surface {
            SurfaceKind::Exact(_) => 0,
            SurfaceKind::Mesh(mesh) => mesh.byte_count(),
        });
        size_of_val(self.entries.as_slice()) as u64 + meshes.sum::<u64>()
    }

    #[inline]
    fn entry(&self, object: u32) -> Option<&SpecularObject<'a>> {
        self.entries.get(object as usize)?.as_ref()
    }

    /// The object and the site where a ray met the scene, in double precision: on the surface to rounding, and on
    /// the ray as it is given. Returns `None` for diffuse objects and rays that only graze.
    pub fn site_of(&self, ray: &Ray, hit: &Hit) -> Option<(u32, ManifoldVertex)> {
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3().try_normalize()?);
        match hit {
            Hit::Surface { object, hit: SurfaceHit { distance, .. } } => {
                let SurfaceKind::Exact(surface) = &self.entry(*object)?.surface else { return None };
                let position = exact::intersection(surface, origin, direction, *distance as f64)?;
                Some((*object, ManifoldVertex::on_surface(position)))
            }
            Hit::Triangle { triangle, .. } => {
                let object = *self.objects_of_triangles.get(*triangle as usize)?;
                let SurfaceKind::Mesh(mesh) = &self.entry(object)?.surface else { return None };
                Some((object, mesh.intersection(*triangle, origin, direction)?))
            }
        }
    }

    /// [`Self::site_of`] with the normals of [`Self::frame`], in one go; `direction` is of unit length.
    #[inline]
    pub fn arrival(&self, origin: DVec3, direction: DVec3, hit: &PrimitiveHit) -> Option<SurfaceArrival> {
        match *hit {
            PrimitiveHit::Surface { object, distance } => {
                let SurfaceKind::Exact(surface) = &self.entry(object)?.surface else { return None };
                let (position, normal) = exact::arrival(surface, origin, direction, distance)?;
                Some(SurfaceArrival { object, position, normal, geometric_normal: normal })
            }
            PrimitiveHit::Triangle(triangle) => {
                let object = *self.objects_of_triangles.get(triangle as usize)?;
                let SurfaceKind::Mesh(mesh) = &self.entry(object)?.surface else { return None };
                let (position, normal, geometric_normal) = mesh.arrived(triangle, origin, direction)?;
                Some(SurfaceArrival { object, position, normal, geometric_normal })
            }
        }
    }

    /// The surface at a site to first order; returns `None` if it has no normal.
    #[inline]
    pub fn frame(&self, object: u32, site: &ManifoldVertex) -> Option<ManifoldFrame> {
        match &self.entry(object)?.surface {
            SurfaceKind::Exact(surface) => exact::frame(site.position, &surface.taylor2(site.position)),
            SurfaceKind::Mesh(mesh) => mesh.frame(site),
        }
    }

    /// The surface at a site to second order.
    ///
    /// On meshes it is the smooth surface that the triangles stand for: its tangents are perpendicular to the
    /// interpolated normal (not in the flat triangle's plane, as those of [`ManifoldFrame`]), its curvature comes from
    /// operators fitted at the vertices (Rusinkiewicz 2004) and interpolated between them. On a torus with triangles
    /// of a tenth of the tube's radius curvatures are within 0.8 %, with half as large ones within 0.2 %: the error
    /// falls with the square of their size. Second derivatives of the normal are within 4 % on such meshes.
    pub fn patch(&self, object: u32, site: &ManifoldVertex) -> Option<SurfacePatch> {
        match &self.entry(object)?.surface {
            SurfaceKind::Exact(surface) => SurfacePatch::of_implicit(site.position, &surface.taylor3(site.position)),
            SurfaceKind::Mesh(mesh) => mesh.patch(site),
        }
    }

    /// The site reached by a step along the tangents of the site's frame and back onto the surface.
    ///
    /// The new site may lie beyond the borders of an open surface, on its continuation (see [`Self::is_within`]).
    /// Returns `None` if the step is so long that the surface is lost.
    pub fn moved(&self, object: u32, site: &ManifoldVertex, step: DVec2) -> Option<ManifoldVertex> {
        self.stepped(object, &self.landed(object, site)?, step).map(|(site, _)| site)
    }

    /// The site itself, brought onto the surface where it is a little off, with its frame.
    pub fn landed(&self, object: u32, site: &ManifoldVertex) -> Option<(ManifoldVertex, ManifoldFrame)> {
        match &self.entry(object)?.surface {
            SurfaceKind::Exact(surface) => exact::landed(surface, site.position, f64::INFINITY),
            SurfaceKind::Mesh(mesh) => mesh.landed(site),
        }
    }

    /// [`Self::moved`] from a site on the surface with a given frame, with the frame at the new one.
    #[inline]
    pub fn stepped(
        &self,
        object: u32,
        from: &(ManifoldVertex, ManifoldFrame),
        step: DVec2,
    ) -> Option<(ManifoldVertex, ManifoldFrame)> {
        match &self.entry(object)?.surface {
            SurfaceKind::Exact(surface) => exact::stepped(surface, &from.1, step),
            SurfaceKind::Mesh(mesh) => mesh.stepped(from, step),
        }
    }

    /// Returns true if a site lies on the surface itself, not on its continuation beyond a border.
    pub fn is_within(&self, object: u32, site: &ManifoldVertex) -> bool {
        match self.entry(object).map(|entry| &entry.surface) {
            Some(SurfaceKind::Exact(surface)) => exact::is_within(surface, site.position),
            Some(SurfaceKind::Mesh(mesh)) => mesh.is_within(site),
            None => false,
        }
    }

    /// The index of refraction of a lens over that of its surroundings; 1 for all others.
    #[inline]
    pub fn index_of(&self, object: u32) -> f64 {
        self.entry(object).map_or(1.0, |entry| entry.index)
    }

    /// Returns true if the object is the surface of a formula.
    pub fn is_formula(&self, object: u32) -> bool {
        self.entry(object).is_some_and(|entry| matches!(entry.surface, SurfaceKind::Exact(_)))
    }

    /// Returns true if no ray that leaves the object's outer side comes back to it: it is convex.
    #[inline]
    pub fn is_convex(&self, object: u32) -> bool {
        self.entry(object).is_some_and(|entry| match &entry.surface {
            SurfaceKind::Exact(surface) => surface.is_convex(),
            SurfaceKind::Mesh(mesh) => mesh.is_convex(),
        })
    }

    /// Returns true if the object is a body that light passes.
    #[inline]
    pub fn is_lens(&self, object: u32) -> bool {
        self.entry(object).is_some_and(|entry| entry.role == Role::Lens)
    }

    /// Returns true if the object is a mirror on its inner side alone.
    #[inline]
    pub fn is_mirror_inside_only(&self, object: u32) -> bool {
        self.entry(object).is_some_and(|entry| entry.inner_only)
    }
}
