//! Coverage, depth, normals, objects and reflections of a frame, beside its colours.

use crate::drawing::Drawing;
use crate::failure::Failure;
use crate::settings::Chosen;
use catoptric::framebuffer::Framebuffer;
use catoptric::light::first_surfaces::{FirstSurfaces, SeenPoint};
use catoptric::light::tracer::Tracer;
use catoptric::methods::reference::{ReferenceSettings, sample_place};
use catoptric::methods::{Prepared, Quality, Settings};
use catoptric::picture::{Channel, ChannelValues};
use catoptric::progress::Silent;
use catoptric::scene::{Scene, View};
use glam::Vec3;
use serde_json::json;
use std::sync::Arc;

/// Passes of the frames of one method; what holds for a scene is kept for the next frame.
pub(super) struct Passes<'a> {
    chosen: &'a Chosen,
    quality: Quality,
    /// How the reference places its samples; all methods place theirs as it does by default.
    placement: ReferenceSettings,
    of_scene: Option<OfScene>,
}

struct OfScene {
    scene: Arc<Scene>,
    tracer: Tracer,
    /// Draws what is seen directly.
    direct: Option<Box<dyn Prepared>>,
    /// Draws all before white.
    on_white: Option<Box<dyn Prepared>>,
}

impl<'a> Passes<'a> {
    pub(super) fn new(chosen: &'a Chosen, quality: Quality) -> Result<Self, Failure> {
        let default = toml::Table::new();
        let settings = if chosen.info.id == "reference" { &chosen.settings } else { &default };
        let placement = ReferenceSettings::from_table(settings).map_err(Failure::usage)?;
        Ok(Self { chosen, quality, placement, of_scene: None })
    }

    fn of_scene(&mut self, scene: &Arc<Scene>) -> &mut OfScene {
        let kept = self.of_scene.take().filter(|of| Arc::ptr_eq(&of.scene, scene));
        self.of_scene.insert(kept.unwrap_or_else(|| OfScene {
            scene: scene.clone(),
            tracer: Tracer::build(scene, |_| true),
            direct: None,
            on_white: None,
        }))
    }

    /// The share of each pixel's samples that show a reflector or lens first.
    pub(super) fn mask(&mut self, drawing: &Drawing) -> Vec<f32> {
        self.shares(drawing, |scene, object| scene.role_of(object).is_specular())
    }

    fn shares(&mut self, drawing: &Drawing, is_wanted: impl Fn(&Scene, u32) -> bool + Sync) -> Vec<f32> {
        let (samples, placement) = (self.quality.samples, self.placement.clone());
        let OfScene { scene, tracer, .. } = self.of_scene(&drawing.scene);
        let place = |pixel: [u32; 2], sample: u32| sample_place(&placement, pixel, sample, samples);
        FirstSurfaces::new(scene, tracer, &drawing.view).shares(samples, place, |object| is_wanted(scene, object))
    }

    /// The share of each pixel that shows a surface, of a frame before black.
    pub(super) fn coverage(&mut self, drawing: &Drawing) -> Result<Vec<f32>, Failure> {
        if self.chosen.info.id == "reference" {
            return Ok(self.shares(drawing, |_, _| true));
        }
        // Others draw triangles where rays meet exact surfaces: the difference before white is the share that they
        // leave (Smith, Blinn 1996).
        let (chosen, quality) = (self.chosen, self.quality);
        let on_white = &mut self.of_scene(&drawing.scene).on_white;
        if on_white.is_none() {
            let scene = Scene { backdrop: Some(Vec3::ONE), ..(*drawing.scene).clone() };
            *on_white = Some(chosen.method.prepare(&Arc::new(scene), quality, chosen.bake.clone(), &Silent)?);
        }
        let on_white = drawn(on_white, &drawing.view)?;
        let samples = quality.samples as f32;
        let share = |(white, black): (&[f32; 4], &[f32; 4])| {
            let uncovered = (0..3).map(|channel| white[channel] - black[channel]).sum::<f32>() / 3.0;
            ((1.0 - uncovered) * samples).round().clamp(0.0, samples) / samples
        };
        Ok(on_white.pixels.iter().zip(&drawing.picture.pixels).map(share).collect())
    }

    /// The channels of all layers, and what they hold, as JSON. Distances are in scene units.
    pub(super) fn layers(&mut self, drawing: &Drawing) -> Result<(Vec<Channel>, String), Failure> {
        let direct = self.direct(drawing)?;
        let OfScene { scene, tracer, .. } = self.of_scene(&drawing.scene);
        let seen = FirstSurfaces::new(scene, tracer, &drawing.view).in_the_middle();
        let floats = |of: &dyn Fn(&SeenPoint) -> f32, nothing: f32| {
            ChannelValues::Float(seen.iter().map(|seen| seen.as_ref().map_or(nothing, of)).collect())
        };
        let reflection = |channel: usize| {
            let pixels = drawing.picture.pixels.iter().zip(&direct.pixels);
            ChannelValues::Light(pixels.map(|(all, direct)| all[channel] - direct[channel]).collect())
        };
        let numbers = seen.iter().map(|seen| seen.map_or(0, |seen| seen.object + 1)).collect();
        let channels = [
            ("depth.Z", floats(&|seen| seen.depth, f32::INFINITY)),
            ("normal.X", floats(&|seen| seen.normal.x, 0.0)),
            ("normal.Y", floats(&|seen| seen.normal.y, 0.0)),
            ("normal.Z", floats(&|seen| seen.normal.z, 0.0)),
            ("object.id", ChannelValues::Number(numbers)),
            ("reflection.R", reflection(0)),
            ("reflection.G", reflection(1)),
            ("reflection.B", reflection(2)),
        ];
        let channels = channels.map(|(name, values)| Channel { name, values }).into();
        let names =
            scene.objects.iter().enumerate().map(|(index, object)| ((index + 1).to_string(), json!(object.name)));
        let about = json!({
            "depth.Z": "distance from the eye's plane along the view axis, in scene units, in the middle of the pixel; \
                        infinite where there is nothing",
            "normal": "unit shading normal in the world, on the side that is seen, in the middle of the pixel",
            "object.id": "key of `objects` in the middle of the pixel; 0: nothing",
            "reflection": "the picture less what is seen without mirrors and glass",
            "objects": names.collect::<serde_json::Map<_, _>>(),
        });
        Ok((channels, about.to_string()))
    }

    /// The frame with black mirrors and glass.
    fn direct(&mut self, drawing: &Drawing) -> Result<Framebuffer, Failure> {
        let (chosen, quality) = (self.chosen, Quality { order: 0, ..self.quality });
        let direct = &mut self.of_scene(&drawing.scene).direct;
        if direct.is_none() {
            let scene = Scene { ends_in_environment: false, ..(*drawing.scene).clone() };
            *direct = Some(chosen.method.prepare(&Arc::new(scene), quality, chosen.bake.clone(), &Silent)?);
        }
        drawn(direct, &drawing.view)
    }
}

/// A view by a prepared method.
fn drawn(prepared: &mut Option<Box<dyn Prepared>>, view: &View) -> Result<Framebuffer, Failure> {
    let mut picture = Framebuffer::new(view.width, view.height);
    if let Some(prepared) = prepared {
        prepared.frame(view, &Silent)?.draw(&mut picture, &Silent)?;
    }
    Ok(picture)
}

/// A picture without its background: each pixel's coverage is its share of what is seen, by which its colour is
/// multiplied already.
pub(super) fn cut_out(picture: &Framebuffer, shares: &[f32]) -> Framebuffer {
    let of_pixel = |([r, g, b, _], share): (&[f32; 4], &f32)| match *share {
        0.0 => [0.0; 4],
        share => [*r, *g, *b, share],
    };
    let pixels = picture.pixels.iter().zip(shares).map(of_pixel).collect();
    Framebuffer { pixels, ..picture.clone() }
}

/// The same picture with colours that are not multiplied by the coverage.
pub(super) fn straight(picture: &Framebuffer) -> Framebuffer {
    let of_pixel = |[r, g, b, share]: &[f32; 4]| match *share {
        0.0 => [0.0; 4],
        share => (Vec3::new(*r, *g, *b) / share).extend(share).to_array(),
    };
    let pixels = picture.pixels.iter().map(of_pixel).collect();
    let mut straight = Framebuffer::of_pixels(picture.width, picture.height, pixels);
    // Samples of the background would darken a silhouette.
    let covered = |(pixel, _): &(u32, &[Vec3])| picture.pixels[*pixel as usize][3] == 1.0;
    picture.edges.iter().filter(covered).for_each(|(pixel, samples)| straight.edges.add(pixel, samples));
    straight
}
