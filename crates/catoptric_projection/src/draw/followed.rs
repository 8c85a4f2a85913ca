//! Surfaces with lobes, and lenses, whose light rays find.

use super::path_shader::{Part, PathShader, meet_hardly_beside};
use catoptric_core::scene::hit::Hit;
use catoptric_core::scene::{Ray, RayDifferential};
use catoptric_engine::light::path_tracer::{PathModel, PathTracer, SeenSurface};
use catoptric_engine::light::tracer::Tracer;
use catoptric_engine::light::wide_hierarchy::Treelet;
use catoptric_engine::raster::{Fragment, LayerSurface, sample_positions};
use glam::{Vec2, Vec3};

/// Rays that follow a rough lobe of a fragment. Chosen between noise and time.
const LOBE_RAYS: u32 = 16;

/// The side of the squares of pixels whose rays are followed together: about as many as the tracer follows at once.
const SQUARE_PX: f32 = 8.0;

/// Paths of fragments of as many parts each, which wait to be followed together.
#[derive(Default)]
struct WaitingPaths {
    /// Surfaces where they start, part after part of each fragment.
    seen: Vec<SeenSurface>,
    /// The fragments' indices.
    fragments: Vec<u32>,
    sums: Vec<Vec3>,
}

impl WaitingPaths {
    /// Sets the colours of the fragments: means of their parts.
    fn follow(&mut self, paths: &mut PathTracer<'_>, colors: &mut [Vec3]) {
        if self.fragments.is_empty() {
            return;
        }
        let parts = self.seen.len() / self.fragments.len();
        paths.set_rough_rays((LOBE_RAYS / parts as u32).max(1), parts as u32);
        self.sums.resize(self.seen.len(), Vec3::ZERO);
        paths.radiances_of_seen(&self.seen, &mut self.sums);
        for (index, sums) in self.fragments.iter().zip(self.sums.chunks_exact(parts)) {
            colors[*index as usize] = (sums.iter().sum::<Vec3>() / parts as f32).max(Vec3::ZERO);
        }
        self.seen.clear();
        self.fragments.clear();
    }

    /// Has a fragment wait that shows these surfaces; those that wait and show more or fewer are followed first.
    fn add(
        &mut self,
        index: u32,
        seen: impl ExactSizeIterator<Item = SeenSurface>,
        paths: &mut PathTracer<'_>,
        colors: &mut [Vec3],
    ) {
        if self.seen.len() != self.fragments.len() * seen.len() {
            self.follow(paths, colors);
        }
        self.seen.extend(seen);
        self.fragments.push(index);
    }
}

impl PathShader<'_> {
    /// Sets the colours of fragments whose first surface is one that rays follow, at the indices that stand beside
    /// them.
    #[inline(never)] // as long as a path
    pub(super) fn follow_all(&self, fragments: &mut [(u32, Fragment<'_>)], colors: &mut [Vec3]) {
        let Some((tracer, order)) = self.lobes else { return };
        let square = |fragment: &Fragment<'_>| (fragment.position / SQUARE_PX).floor().as_ivec2().to_array();
        fragments.sort_unstable_by_key(|(index, fragment)| (square(fragment), *index));
        let mut paths = PathTracer::new(self.scene, tracer, PathModel::Tree, order);
        let (mut waiting, mut treelet) = (WaitingPaths::default(), Treelet::default());
        for fragments in fragments.chunk_by(|(_, a), (_, b)| square(a) == square(b)) {
            let positions = fragments.iter().map(|(_, fragment)| fragment.position);
            let low = positions.clone().fold(Vec2::INFINITY, Vec2::min) - 0.5;
            let high = positions.fold(Vec2::NEG_INFINITY, Vec2::max) + 0.5;
            tracer.gather(&self.rays, low, high, &mut treelet);
            for (index, fragment) in fragments {
                let whole = Part { offset: Vec2::ZERO, side: self.side(fragment) };
                self.add_parts(&mut waiting, (*index, fragment, whole), (tracer, &treelet), &mut paths, colors);
            }
            waiting.follow(&mut paths, colors);
        }
        self.note_ended(paths.take_ended_count());
    }

    /// The light of the first surface of a fragment, over a part of its pixel.
    pub(super) fn followed(&self, (tracer, order): (&Tracer, u32), fragment: &Fragment<'_>, part: Part) -> Vec3 {
        let mut paths = PathTracer::new(self.scene, tracer, PathModel::Tree, order);
        let (mut waiting, mut treelet) = (WaitingPaths::default(), Treelet::default());
        let at = fragment.position + part.offset;
        tracer.gather(&self.rays, at - 0.5, at + 0.5, &mut treelet);
        let mut color = [Vec3::ZERO];
        self.add_parts(&mut waiting, (0, fragment, part), (tracer, &treelet), &mut paths, &mut color);
        waiting.follow(&mut paths, &mut color);
        self.note_ended(paths.take_ended_count());
        color[0]
    }

    /// The light of a surface that is met after some bounces.
    #[inline(never)] // as long as a path
    pub(super) fn followed_on(
        &self,
        (tracer, order): (&Tracer, u32),
        (surface, bounce): (&LayerSurface, usize),
        ray: &Ray,
    ) -> Vec3 {
        // The differentials of the rays are not known here.
        let change = RayDifferential::default();
        let encounter = self.scene.drawn_encounter(surface.source, &surface.barycentrics, ray, &change);
        let order = order.saturating_sub(bounce as u32);
        let mut paths = PathTracer::new(self.scene, tracer, PathModel::Tree, order);
        paths.set_rough_rays(LOBE_RAYS, 1);
        let mut sums = [Vec3::ZERO];
        paths.radiances_of_seen(&[SeenSurface { ray: *ray, change, encounter, known: Default::default() }], &mut sums);
        self.note_ended(paths.take_ended_count());
        sums[0].max(Vec3::ZERO)
    }

    /// The hit of a ray on the triangle that a surface shows, `None` if it passes beside the triangle.
    #[inline(always)]
    fn hit_within(&self, ray: &Ray, surface: &LayerSurface) -> Option<Hit> {
        let triangle = surface.source;
        let object = self.scene.triangle_objects[triangle as usize];
        let (barycentrics, distance) = self.scene.plane_met(triangle, ray)?;
        let is_met = distance > 0.0 && barycentrics.min_element() >= 0.0 && barycentrics.element_sum() <= 1.0;
        let is_mesh = self.scene.objects[object as usize].surface.is_none();
        (is_met && is_mesh).then_some(Hit::Triangle { distance, triangle, barycentrics })
    }

    /// Has a fragment wait, by one path over a part of its pixel, or by several, each over a part of that.
    fn add_parts(
        &self,
        waiting: &mut WaitingPaths,
        (index, fragment, part): (u32, &Fragment<'_>, Part),
        (tracer, treelet): (&Tracer, &Treelet),
        paths: &mut PathTracer<'_>,
        colors: &mut [Vec3],
    ) {
        let Some(surface) = fragment.chain.first() else { return };
        let object = self.scene.triangle_objects[surface.source as usize];
        let samples = surface.barycentrics.samples;
        let is_all = samples == self.samples;
        let met = |part: Part| {
            let at = fragment.position + part.offset;
            let (mut ray, change) = self.rays.ray_with_differential(at.x, at.y);
            let mut surface = *surface;
            meet_hardly_beside(self.scene, &mut ray, &mut surface);
            let change = change.scaled(part.side);
            // The fragment's position may lie beyond the edge of the triangle that a sample shows: rays would start
            // outside the body.
            let shown = if is_all { self.hit_within(&ray, &surface) } else { None };
            let hit = shown.or_else(|| tracer.first_hit_among(self.scene, &ray, 0.0, treelet));
            let encounter = match hit.filter(|hit| hit.object(self.scene) == object) {
                Some(hit) => tracer.encounter(self.scene, &ray, &hit, Some(&change)),
                None => self.scene.drawn_encounter(surface.source, &surface.barycentrics, &ray, &change),
            };
            let lights = self.lobe_lights.filter(|lights| lights.tell_of(object));
            let lights = lights.map(|lights| lights.at(at, &encounter.point));
            let (known, is_whole) = lights.unwrap_or_default();
            (SeenSurface { ray, change, encounter, known }, is_whole)
        };
        if samples < 4 || self.lobe_lights.is_some_and(|lights| lights.tell_all(fragment.position, object)) {
            let (seen, is_whole) = met(part);
            if is_whole || samples < 4 {
                return waiting.add(index, std::iter::once(seen), paths, colors);
            }
        }
        let of_samples = sample_positions(samples).ok().filter(|_| is_all);
        let parts = of_samples.map_or(4, <[Vec2]>::len);
        let seen = (0..parts).map(|index| match of_samples {
            // The reference has its rays at the samples, too: edges are smoother with these than with quarters.
            Some(positions) => met(part.at_sample(positions, index)).0,
            None => met(part.quarters()[index]).0,
        });
        waiting.add(index, seen, paths, colors);
    }
}
