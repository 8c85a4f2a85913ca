//! Textures of layers with which pictures from viewpoints come out best (Hakura, Snyder 2001, section 4.3).

pub(crate) mod direct;
pub(crate) mod least_squares;
pub(crate) mod observations;

use super::mesh::visible::SeenSurfaces;
use super::mesh::{self, Criteria};
use super::shells::layer_geometry::LayerGeometry;
use super::shells::viewpoints::{picture_of, picture_past};
use super::texels::TexelLayout;
use super::textures::maps::Layer;
use super::textures::texture::LayerTexture;
use crate::layered_environment_map::settings::{Edges, LayeredEnvironmentMapSettings};
use catoptric_core::parallel;
use catoptric_core::progress::{Progress, Silent, Stage};
use catoptric_core::scene::{Scene, View};
use catoptric_engine::error::RenderError;
use catoptric_engine::light::two_path_tracer::TwoPathTracer;
use catoptric_engine::method::{Job, Quality};
use direct::Missing;
use glam::Vec4;
use least_squares::{Equations, Residual, Stop, solve};
use observations::{Observation, Observations, Observer};

/// The weight that holds a texel to its expected value, against pixels that count by the squares of their shares in it.
/// With a fifth of this textures of viewpoints that are inferred together get noisy, with twenty times of it they stay
/// at their expected values.
const TRUST: f32 = 0.005;

/// The weight that holds texels of coarser levels to the means of finer ones. Without it an excess in one level is a
/// lack in the next, and levels that no picture reads keep their expected values: pictures at other sizes are noisy.
/// Chosen, not measured.
const COUPLING: f32 = 1.0;

/// The weight of pictures from beside a viewpoint against the picture from itself: they show parts that it does not
/// show, and should not blur those that it does. Chosen, not measured.
const NEIGHBOUR_WEIGHT: f32 = 0.3;

/// Weight of surfaces that others of their group hide, against those that a viewpoint shows: as of pictures from beside
/// it. Chosen, not measured.
pub const HIDDEN_WEIGHT: f32 = NEIGHBOUR_WEIGHT;

/// Angle of refinement of the pictures' adaptive mesh, independent of that of views: 3 degrees.
const CRITERIA: Criteria = Criteria { tau_px: 2.0, least_cosine: 0.998_629_5, edges: Edges::Traced };

/// When a texture is good enough. Chosen, not measured.
pub const STOP: Stop = Stop { most_steps: 100, gradient: 1e-4 };

/// Pictures of each viewpoint, each one half as large as the one before: smaller ones determine the coarser levels of
/// textures. Chosen, not measured.
const PICTURE_SIZES: u32 = 3;

/// Observations whose equations a thread makes at once. A size for threads; chosen, not measured.
const OBSERVATIONS_AT_ONCE: usize = 4096;

/// Inputs of inference.
pub struct Inference<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The settings of the method.
    pub settings: &'a LayeredEnvironmentMapSettings,
    /// The groups and their shells.
    pub known: &'a LayerGeometry,
}

/// Appends equations that say that the texels of coarser levels are the means of those that they cover.
fn couple(layout: &TexelLayout, confidence: f32, equations: &mut Equations) {
    for (texel, covered) in layout.coarser() {
        equations.push(confidence, Vec4::ZERO, |tap| {
            tap(texel, 1.0);
            covered.into_iter().for_each(|finer| tap(finer, -0.25));
        });
    }
}

impl Inference<'_> {
    /// The layers that are made together (of a part, and as they are `projected`) as they are for a viewpoint, with
    /// how well they fit.
    ///
    /// # Errors
    /// Errors of the rasteriser.
    pub(crate) fn infer(
        &self,
        part: usize,
        projected: &[Layer],
        viewpoint: u32,
        progress: &dyn Progress,
    ) -> Result<(Vec<Layer>, Vec<Residual>), RenderError> {
        let systems = self.systems(part, projected, viewpoint, progress)?;
        let mut residuals = Vec::with_capacity(systems.len());
        let stage = Stage::begin(progress, "inferring layers", systems.len())?;
        let layer = |(systems, layer): (Vec<Equations>, &Layer)| -> Result<Layer, RenderError> {
            let (texture, residual) = self.fitted(layer, Equations::joined(systems));
            residuals.push(residual);
            stage.advance(1)?;
            Ok(Layer { distances: layer.distances.clone(), texture, ..*layer })
        };
        let layers: Vec<Layer> = systems.into_iter().zip(projected).map(layer).collect::<Result<_, _>>()?;
        Ok((layers, residuals))
    }

    /// The texture of a layer (as it is projected) by which equations hold best, and how well they do.
    pub fn fitted(&self, layer: &Layer, mut equations: Equations) -> (LayerTexture, Residual) {
        let layout = layer.texture.layout.clone();
        let mut expected = vec![Vec4::ZERO; layout.texel_count()];
        if self.settings.direct.is_from_center() {
            expected.iter_mut().zip(&layer.texture.texels).for_each(|(value, texel)| *value = texel.value());
        }
        couple(&layout, COUPLING, &mut equations);
        let (texels, residual) = solve(&equations, &expected, TRUST, STOP);
        (LayerTexture::new(layout, &texels), residual)
    }

    /// Observations of a group (by its number) from a viewpoint.
    ///
    /// # Errors
    /// Errors of the rasteriser.
    pub fn seen(&self, number: usize, viewpoint: u32) -> Result<Observations, RenderError> {
        self.with_observer(number, |observer| {
            let eye = observer.known.viewspace.eye(viewpoint, 0.0);
            let view = picture_of(self.scene, &observer.known.group, eye, self.settings.picture_size);
            self.observations(observer, &view)
        })
    }

    /// The equations of every layer of a part, from all pictures of a viewpoint: those of all groups that look it up.
    ///
    /// # Errors
    /// Errors of the rasteriser.
    pub fn systems(
        &self,
        part: usize,
        layers: &[Layer],
        viewpoint: u32,
        progress: &dyn Progress,
    ) -> Result<Vec<Vec<Equations>>, RenderError> {
        let Self { scene, settings, known } = *self;
        let groups = known.groups_of(part);
        let neighbours = settings.neighbours as i32;
        let mut systems: Vec<Vec<Equations>> = vec![Vec::new(); layers.len()];
        let (sharpest, direct) = (2 * settings.neighbours as usize + 1, settings.direct.is_from_viewpoint());
        let pictures = sharpest * PICTURE_SIZES as usize;
        let stage = Stage::begin(progress, "looking at layers", groups.len() * (pictures + usize::from(direct)))?;
        // Pictures of the finest size, if texels that they miss are to be filled in.
        let mut seen = Vec::new();
        for group in groups.clone() {
            self.with_observer(group, |observer| {
                for picture in 0..pictures as i32 {
                    let (neighbour, halved) =
                        (picture / PICTURE_SIZES as i32 - neighbours, picture % PICTURE_SIZES as i32);
                    let offset = 0.5 * neighbour as f32 / neighbours.max(1) as f32;
                    let weight = if neighbour == 0 { 1.0 } else { NEIGHBOUR_WEIGHT };
                    let eye = observer.known.viewspace.eye(viewpoint, offset);
                    let view = picture_of(scene, &observer.known.group, eye, settings.picture_size >> halved);
                    let observations = self.observations(observer, &view)?;
                    let is_continued = settings.continued && neighbour == 0;
                    let hidden = is_continued.then(|| observer.observe_hidden(&view));
                    for (index, systems) in systems.iter_mut().enumerate() {
                        let number = known.number_of(part, group, index);
                        let mut push = |observations: &Observations, weight: f32| {
                            let counts = |observation: &Observation| observation.confidence * weight;
                            systems.push(equations(&layers[index], observations, number, counts));
                        };
                        push(&observations, weight);
                        hidden.iter().for_each(|hidden| push(hidden, HIDDEN_WEIGHT));
                    }
                    if direct && halved == 0 {
                        seen.extend(std::iter::once(observations).chain(hidden));
                    }
                    stage.advance(1)?;
                }
                Ok::<(), RenderError>(())
            })?;
        }
        if direct {
            let missing: Vec<Missing<'_>> = layers.iter().map(|layer| Missing::from(layer, &seen)).collect();
            for group in groups {
                let observations = self.with_observer(group, |observer| {
                    let eye = observer.known.viewspace.eye(viewpoint, 0.0);
                    let view = picture_past(scene, &observer.known.group, eye, settings.picture_size);
                    observer.observe_directly(&view)
                });
                for ((index, systems), missing) in systems.iter_mut().enumerate().zip(&missing) {
                    let layer = &layers[index];
                    let counts = |observation: &Observation| match layer.texel_at(&observation.ray) {
                        Some(texel) if layer.surrounds(observation.ray.origin) => missing.likelihood(texel),
                        _ => 0.0,
                    };
                    systems.push(equations(layer, &observations, known.number_of(part, group, index), counts));
                }
                stage.advance(1)?;
            }
        }
        Ok(systems)
    }

    /// Calls `work` with the observer of a group.
    pub fn with_observer<R>(&self, number: usize, work: impl FnOnce(&Observer<'_>) -> R) -> R {
        let Self { scene, settings, known } = *self;
        let group = &known.groups[number];
        let strata = known.apart(settings, scene, number);
        let paths = TwoPathTracer { scene, tracer: &group.group.tracer, order: known.order };
        work(&Observer { scene, known: group, paths, strata: &strata, samples: settings.capture_samples })
    }

    /// Observations in a picture of a group.
    ///
    /// # Errors
    /// Errors of the rasteriser.
    pub fn observations(&self, observer: &Observer<'_>, view: &View) -> Result<Observations, RenderError> {
        let (scene, paths, group) = (self.scene, observer.paths, &observer.known.group);
        let is_in_group = |object: u32| group.holds(object);
        let of_group = |object: u32| is_in_group(object).then_some(paths);
        let quality = Quality { samples: 1, order: self.known.order };
        let job = Job { scene, view, quality, progress: &Silent };
        let (lists, mesh) = mesh::drawn(&job, &self.known.welds, &of_group, CRITERIA, is_in_group)?;
        let seen = SeenSurfaces::of(scene, view, &lists)?;
        Ok(observer.observe(view, &mesh, &seen))
    }
}

/// The equations of a layer's look-ups: the rendering matrix, with the observed radiance of the layer of a number on
/// the right-hand side, each weighted by its count.
pub fn equations(
    layer: &Layer,
    observations: &Observations,
    number: usize,
    counts: impl Fn(&Observation) -> f32 + Sync,
) -> Equations {
    let list = &observations.list;
    let piece = |piece: usize| {
        let start = piece * OBSERVATIONS_AT_ONCE;
        let mut equations = Equations::default();
        for (index, observation) in list.iter().enumerate().skip(start).take(OBSERVATIONS_AT_ONCE) {
            let confidence = counts(observation);
            if confidence <= 0.0 {
                continue;
            }
            equations.push(confidence, observations.seen(index, number), |tap| {
                layer.taps_of(&observation.ray, &observation.change, |taps| {
                    taps.iter().for_each(|(texel, weight)| tap(texel, weight));
                });
            });
        }
        equations
    };
    Equations::joined(parallel::map_collect(list.len().div_ceil(OBSERVATIONS_AT_ONCE), piece))
}
