//! The path of light that each pixel shows, the list that it ends in, and the triangle of the scene.

use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::scene::{Role, Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::method::overlay::paths::Numbers;
use catoptric_engine::method::projector::SpecularPath;
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use catoptric_engine::raster::{Fragment, FragmentBatch, FragmentShader, LayerSurface};
use glam::{Vec2, Vec3};

/// Numbers below this are exact in single precision.
const EXACT: u32 = 1 << 20;

/// The end of a path of light: all that tells one of a pixel's contents from another but the triangle.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct PathEnd {
    pub(crate) path: SpecularPath,
    /// The list that has drawn its last surface, with the triangle; `None`: the environment is seen.
    pub(crate) list: Option<u32>,
}

/// The surface that each pixel of a picture shows at its centre; at glass, the transmitted path.
pub(crate) struct ShownPixels {
    pub(crate) size: [u32; 2],
    /// The ends of all paths that show, short paths first.
    pub(crate) ends: Vec<PathEnd>,
    /// The end of every pixel's path, as an index of `ends`.
    pub(crate) end_of_pixels: Vec<Option<u32>>,
    /// The triangle of the scene in every pixel; `u32::MAX`: the environment.
    pub(crate) triangle_of_pixels: Vec<u32>,
}

impl ShownPixels {
    /// Draws a view with a shader whose colours are numbers; `draw` must take one sample a pixel.
    ///
    /// # Errors
    /// The errors of `draw`.
    pub(crate) fn of(
        scene: &Scene,
        view: &View,
        draw: impl FnOnce(&ShownShader<'_>, &mut Framebuffer) -> Result<(), RenderError>,
    ) -> Result<Self, RenderError> {
        let shader = ShownShader { scene, ends: Numbers::default() };
        let mut picture = Framebuffer::new(view.width, view.height);
        draw(&shader, &mut picture)?;
        let (ends, places) =
            shader.ends.sorted(|one, other| (one.path.bounces.len(), one).cmp(&(other.path.bounces.len(), other)));
        let end_of = |pixel: &[f32; 4]| (pixel[0] as u32).checked_sub(1).map(|number| places[number as usize]);
        let triangle_of = |pixel: &[f32; 4]| match pixel[2] as u32 {
            0 => u32::MAX,
            high => (high - 1) * EXACT + pixel[1] as u32,
        };
        Ok(Self {
            size: [view.width, view.height],
            end_of_pixels: picture.pixels.iter().map(end_of).collect(),
            triangle_of_pixels: picture.pixels.iter().map(triangle_of).collect(),
            ends,
        })
    }
}

/// Gives each fragment the numbers of its path and of its triangle as a colour; black where another fragment of the
/// same sample counts.
pub(crate) struct ShownShader<'a> {
    scene: &'a Scene,
    ends: Numbers<PathEnd>,
}

impl ShownShader<'_> {
    fn is_lens(&self, surface: &LayerSurface) -> bool {
        self.scene.role_of(self.scene.triangle_objects[surface.source as usize]) == Role::Lens
    }

    /// True for the fragment of a sample that takes the way through all glass.
    fn counts(&self, fragment: &Fragment<'_>) -> bool {
        let goes_through = |surface: &LayerSurface| surface.group != 0 && self.is_lens(surface);
        let through = fragment.chain.iter().enumerate().filter(|(_, surface)| goes_through(surface));
        through.fold(0, |bits, (layer, _)| bits | 1u64 << layer) == fragment.second_branches
    }

    /// The end of a fragment's path, with the triangle there.
    fn end(&self, fragment: &Fragment<'_>) -> (PathEnd, Option<u32>) {
        let (mut end, mut triangle) = (PathEnd::default(), None);
        for (layer, surface) in fragment.chain.iter().enumerate() {
            let object = self.scene.triangle_objects[surface.source as usize];
            if surface.group != 0 && self.scene.role_of(object).is_specular() {
                let kind = match fragment.second_branches >> layer & 1 {
                    0 => BounceKind::Reflect,
                    _ => BounceKind::Transmit,
                };
                end.path.bounces.push(Bounce { object, kind });
            } else {
                (end.list, triangle) = (Some(surface.list), Some(surface.source));
            }
        }
        (end, triangle)
    }
}

impl FragmentShader for ShownShader<'_> {
    fn shade(&self, fragment: &Fragment<'_>) -> Vec3 {
        if !self.counts(fragment) {
            return Vec3::ZERO;
        }
        let (end, triangle) = self.end(fragment);
        color(self.ends.number(end), triangle)
    }

    fn shade_batch(&self, batch: &FragmentBatch<'_>, colors: &mut [Vec3]) {
        // Neighbours mostly show the same.
        let mut last: Option<(PathEnd, u32)> = None;
        for (fragment, shown) in batch.iter().zip(colors) {
            *shown = Vec3::ZERO;
            if !self.counts(&fragment) {
                continue;
            }
            let (end, triangle) = self.end(&fragment);
            let number = match &last {
                Some((known, number)) if *known == end => *number,
                _ => self.ends.number(end.clone()),
            };
            last = Some((end, number));
            *shown = color(number, triangle);
        }
    }

    fn is_present(&self, surface: &LayerSurface, _position: Vec2) -> bool {
        self.scene.is_surface_present(surface.source, &surface.barycentrics)
    }
}

fn color(end: u32, triangle: Option<u32>) -> Vec3 {
    let [low, high] = triangle.map_or([0, 0], |triangle| [triangle % EXACT, triangle / EXACT + 1]);
    Vec3::new((end + 1) as f32, low as f32, high as f32)
}
