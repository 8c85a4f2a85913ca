//! Panoramic cameras as bytes, for baked files: only the data that answers need.

use super::cameras::{PanoramaFace, PanoramaSettings, PanoramicCameras, group_of_path};
use crate::sample_based_camera::cameras::Cameras;
use crate::sample_based_camera::layout::{WordReader, WordWriter};
use crate::sample_based_camera::panorama::cube::FACES;
use crate::sample_based_camera::rays::grid::RayGrid;
use crate::sample_based_camera::rays::path_rays::DensePathRays;
use catoptric_engine::method::projector::{MAX_BOUNCES, SpecularPath};
use catoptric_engine::optics::path::bundle::{Bounce, BounceKind};
use glam::Vec3;

impl PanoramicCameras {
    /// The cameras as bytes, without the data that [`Self::compact`] leaves out, and without the settings.
    pub(in super::super) fn to_bytes(&self) -> Vec<u8> {
        let mut words = WordWriter::default();
        words.floats(&self.eye.to_array());
        words.floats(&[self.near]);
        words.number(self.object_count as u32);
        words.number(self.paths.len() as u32);
        for path in &self.paths {
            let letter = |bounce: &Bounce| bounce.object << 1 | u32::from(bounce.kind == BounceKind::Reflect);
            words.numbers(&path.bounces.iter().map(letter).collect::<Vec<u32>>());
        }
        words.number(self.faces.len() as u32);
        for PanoramaFace { number, grid, cameras, group_of_path, media } in &self.faces {
            words.number(*number as u32);
            words.number(grid.traced.min(u32::MAX.into()) as u32);
            words.number(grid.groups.len() as u32);
            for (index, ((group, cameras), media)) in (0..).zip(grid.groups.iter().zip(cameras).zip(media)) {
                let path = group_of_path.iter().position(|group| *group == Some(index));
                words.number(path.map_or(u32::MAX, |path| path as u32));
                words.floats(&media.unwrap_or([f32::NAN; 2]));
                group.store(&mut words);
                cameras.store(&mut words);
            }
        }
        words.into_bytes()
    }

    /// The cameras about a place in a scene of so many objects that [`Self::to_bytes`] has written, with the settings
    /// that they were built with; `None` for other bytes, and for those of another place or scene.
    pub(in super::super) fn of_bytes(
        bytes: &[u8],
        eye: Vec3,
        object_count: usize,
        settings: &PanoramaSettings,
    ) -> Option<Self> {
        let (words, []) = bytes.as_chunks::<4>() else { return None };
        let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
        let mut words = WordReader::new(&words);
        let (place, [near]) = (Vec3::from_array(words.floats()?), words.floats()?);
        if place != eye || !near.is_finite() || words.number()? as usize != object_count {
            return None;
        }
        let bounce = |letter: &u32| {
            let kind = if letter & 1 == 1 { BounceKind::Reflect } else { BounceKind::Transmit };
            let object = letter >> 1;
            ((object as usize) < object_count).then_some(Bounce { object, kind })
        };
        let mut paths = Vec::new();
        for _ in 0..words.number()? {
            let letters = words.numbers()?;
            if !(1..=MAX_BOUNCES).contains(&letters.len()) {
                return None;
            }
            paths.push(SpecularPath { bounces: letters.iter().map(bounce).collect::<Option<_>>()? });
        }
        let mut faces = Vec::new();
        for _ in 0..words.number()? {
            let face = face_of_words(&mut words, &paths, settings)?;
            faces.push(Some(face).filter(|face| face.number < FACES)?);
        }
        (words.left() == 0).then(|| Self { eye, near, object_count, settings: settings.clone(), paths, faces })
    }
}

fn face_of_words(
    words: &mut WordReader<'_>,
    paths: &[SpecularPath],
    settings: &PanoramaSettings,
) -> Option<PanoramaFace> {
    let (number, traced) = (words.number()? as usize, words.number()?.into());
    let mut grid = RayGrid { spacing_px: settings.spacing_px(), groups: Vec::new(), traced };
    let (mut cameras, mut media) = (Vec::new(), Vec::new());
    for _ in 0..words.number()? {
        let path = paths.get(words.number()? as usize)?;
        let [before, behind] = words.floats()?;
        media.push((before.is_finite() && behind.is_finite()).then_some([before, behind]));
        grid.groups.push(DensePathRays::stored(path.clone(), words)?);
        cameras.push(Cameras::stored(settings.camera, words)?);
    }
    let group_of_path = group_of_path(paths, &grid);
    Some(PanoramaFace { number, grid, cameras, group_of_path, media })
}
