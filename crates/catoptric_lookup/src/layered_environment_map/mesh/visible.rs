//! The triangles that a picture shows, with their pixels.

use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::progress::Silent;
use catoptric_core::scene::{PicturePoint, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::raster::{self, DrawList, Fragment, FragmentShader, LayerSurface};
use glam::{Vec2, Vec3};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

/// The triangles that a picture shows.
pub(crate) struct VisibleTriangles {
    width: u32,
    height: u32,
    /// A triangle that each pixel shows; [`NOTHING`] if it shows none.
    pixels: Vec<AtomicU32>,
    /// Flags of all triangles of the scene.
    is_seen: Vec<AtomicBool>,
}

const NOTHING: u32 = u32::MAX;

/// Shader of passes that only record the visible surfaces.
struct Presence<'a>(&'a Scene);

impl FragmentShader for Presence<'_> {
    fn shade(&self, _fragment: &Fragment<'_>) -> Vec3 {
        Vec3::ZERO
    }

    fn is_present(&self, surface: &LayerSurface, _position: Vec2) -> bool {
        self.0.is_surface_present(surface.source, &surface.barycentrics)
    }
}

impl VisibleTriangles {
    /// Finds the visible triangles of one list (its index) in front of those of all lists, whose sources are the
    /// scene's triangles.
    ///
    /// # Errors
    /// Errors of the rasteriser.
    pub(crate) fn of(
        scene: &Scene,
        view: &View,
        samples: u32,
        lists: &[DrawList],
        list: u32,
    ) -> Result<Self, RenderError> {
        let (width, height) = (view.width, view.height);
        let pixels = (0..width as usize * height as usize).map(|_| AtomicU32::new(NOTHING)).collect();
        let is_seen = (0..scene.triangles.len()).map(|_| AtomicBool::new(false)).collect();
        let found = Self { width, height, pixels, is_seen };
        // Every pixel belongs to one thread, and flags of triangles are set alike by any thread: results do not depend
        // on the number of threads.
        raster::for_each_seen(view, samples, lists, list, &Presence(scene), |[x, y], triangle| {
            found.pixels[(y * width + x) as usize].store(triangle.source, Ordering::Relaxed);
            found.is_seen[triangle.source as usize].store(true, Ordering::Relaxed);
        })?;
        Ok(found)
    }

    /// Returns true for visible triangles.
    pub(crate) fn shows(&self, triangle: u32) -> bool {
        self.is_seen[triangle as usize].load(Ordering::Relaxed)
    }

    /// True if a part of a triangle may be seen: a pixel of the box about it shows the triangle, or one of its corners
    /// lies before the near plane.
    pub(crate) fn shows_part(&self, triangle: u32, corners: [PicturePoint; 3], near: f32) -> bool {
        if corners.iter().any(|corner| corner.depth < near) {
            return true;
        }
        let places = corners.map(|corner| corner.xy / corner.w);
        let low = places[0].min(places[1]).min(places[2]);
        let high = places[0].max(places[1]).max(places[2]);
        if !(low.is_finite() && high.is_finite()) {
            return false;
        }
        // Casts saturate at 0.
        let (x0, y0) = ((low.x - 1.0) as usize, (low.y - 1.0) as usize);
        let within = |place: f32, size: u32| ((place + 2.0) as usize).min(size as usize);
        let (x1, y1) = (within(high.x, self.width), within(high.y, self.height));
        (y0..y1).any(|y| {
            let row = &self.pixels[y * self.width as usize..][..self.width as usize];
            row[x0.min(x1)..x1].iter().any(|shown| shown.load(Ordering::Relaxed) == triangle)
        })
    }
}

/// The surfaces that the pixels of a picture show, with one sample each.
pub(crate) struct SeenSurfaces {
    width: u32,
    pixels: Vec<OnceLock<LayerSurface>>,
}

struct Keeper<'a> {
    scene: &'a Scene,
    found: &'a SeenSurfaces,
}

impl FragmentShader for Keeper<'_> {
    #[inline]
    fn shade(&self, fragment: &Fragment<'_>) -> Vec3 {
        if let Some(surface) = fragment.chain.first() {
            let place = fragment.position.as_uvec2();
            // A pixel has one fragment, as there is one sample.
            self.found.pixels[(place.y * self.found.width + place.x) as usize].get_or_init(|| *surface);
        }
        Vec3::ZERO
    }

    fn is_present(&self, surface: &LayerSurface, _position: Vec2) -> bool {
        self.scene.is_surface_present(surface.source, &surface.barycentrics)
    }
}

impl SeenSurfaces {
    /// Visible surfaces of draw lists whose sources are the scene's triangles.
    ///
    /// # Errors
    /// Errors of the rasteriser.
    pub(crate) fn of(scene: &Scene, view: &View, lists: &[DrawList]) -> Result<Self, RenderError> {
        let pixels = (0..view.width as usize * view.height as usize).map(|_| OnceLock::new()).collect();
        let found = Self { width: view.width, pixels };
        let mut picture = Framebuffer::new(view.width, view.height);
        raster::draw(view, 1, lists, &Keeper { scene, found: &found }, &mut picture, &Silent)?;
        Ok(found)
    }

    /// Visible surface of a pixel.
    pub(crate) fn at(&self, x: u32, y: u32) -> Option<&LayerSurface> {
        self.pixels[(y * self.width + x) as usize].get()
    }
}
