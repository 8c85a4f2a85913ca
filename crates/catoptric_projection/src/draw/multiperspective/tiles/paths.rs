//! The paths that the samples of a tile show.

use super::super::bundles::coverage::ROOT;
use super::found::FoundSurface;
use catoptric_core::math::lanes::LANES;
use catoptric_core::scene::{Role, Scene};
use catoptric_engine::raster::source::{EMPTY, TileBelow, found_number};

/// The path of light to a surface, in one tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) struct TilePath {
    /// The path without its last bounce, plus 1.
    parent: u16,
    /// The smooth surface that it reached last.
    part: u32,
    pub(in super::super) object: u32,
    /// A normal map has turned its rays somewhere.
    pub(in super::super) is_bumpy: bool,
}

/// The paths of a tile.
#[derive(Default)]
pub(in super::super) struct TilePaths {
    pub(in super::super) paths: Vec<TilePath>,
    /// The path of each sample, plus 1, for every layer; 0: no path goes on there.
    labels: Vec<Vec<u16>>,
}

/// The paths that go on from a layer.
#[derive(Clone, Copy, Debug, Default)]
pub(in super::super) struct GoingOn {
    pub(in super::super) any: bool,
    /// True if some go on by two branches.
    pub(in super::super) divides: bool,
}

impl TilePaths {
    pub(in super::super) fn clear(&mut self) {
        self.paths.clear();
    }

    /// Finds the paths that samples show in the layer below and that go on, by refraction or reflection.
    pub(in super::super) fn label(
        &mut self,
        scene: &Scene,
        tile: &TileBelow<'_>,
        surfaces: &[FoundSurface],
        refracts: bool,
    ) -> GoingOn {
        let below = tile.layer() - 1;
        if self.labels.len() <= below {
            self.labels.resize(below + 1, Vec::new());
        }
        let mut labels = std::mem::take(&mut self.labels[below]);
        labels.clear();
        let parents = below.checked_sub(1).map(|layer| std::mem::take(&mut self.labels[layer]));
        let mut going = GoingOn::default();
        let ids = tile.ids(below);
        // Lists have holes of whole blocks.
        let samples = if tile.has_holes() { tile.samples_a_block() } else { ids.len().max(1) };
        for (block, ids) in ids.chunks(samples).enumerate() {
            let parents = parents.as_deref().map(|parents| &parents[block * samples..][..ids.len()]);
            label_samples(ids, parents, &mut labels, |id, parent| {
                let label = self.path(scene, tile, surfaces, (id, parent, block), refracts, &mut going);
                going.any |= label != 0;
                label
            });
        }
        if let Some(parents) = parents {
            self.labels[below - 1] = parents;
        }
        self.labels[below] = labels;
        going
    }

    /// The path that goes on from a surface, plus 1, or 0.
    fn path(
        &mut self,
        scene: &Scene,
        tile: &TileBelow<'_>,
        surfaces: &[FoundSurface],
        (id, parent, block): (u32, u16, usize),
        refracts: bool,
        going: &mut GoingOn,
    ) -> u16 {
        let (triangle, group) = match found_number(id) {
            Some(number) => (surfaces[number as usize].triangle, surfaces[number as usize].group),
            None => {
                let drawn = tile.triangle(id);
                (drawn.source, if tile.has_list(id, block) { 0 } else { drawn.group })
            }
        };
        if group == 0 {
            return 0;
        }
        let object = scene.triangle_objects[triangle as usize];
        let is_lens = scene.role_of(object) == Role::Lens;
        going.divides |= is_lens;
        if refracts && !is_lens {
            return 0;
        }
        let of_object = scene.patch_of_object(object);
        let of_mesh = || scene.triangle_parts.get(triangle as usize).copied();
        let is_bumpy = scene.material_of(object).turning_map().is_some()
            || parent.checked_sub(1).is_some_and(|parent| self.paths[parent as usize].is_bumpy);
        let part = of_object.or_else(of_mesh).unwrap_or(triangle);
        let path = TilePath { parent, part, object, is_bumpy };
        let number = self.paths.iter().rposition(|other| *other == path).unwrap_or_else(|| {
            self.paths.push(path);
            self.paths.len() - 1
        });
        // A tile has fewer samples than there are numbers.
        u16::try_from(number + 1).unwrap_or(0)
    }
}

/// Places of the cache of labels.
const CACHE_LOG2: u32 = 7;

/// Appends the label of each sample, by its surface's id and the label of the path to it (0 throughout without
/// `parents`).
#[cfg_attr(
    not(debug_assertions),
    multiversion::multiversion(targets(
        "x86_64+avx512f+avx512bw+avx512cd+avx512dq+avx512vl+avx2+bmi1+bmi2+popcnt+lzcnt",
        "x86_64+avx2+bmi1+bmi2+popcnt+lzcnt"
    ))
)]
fn label_samples(ids: &[u32], parents: Option<&[u16]>, labels: &mut Vec<u16>, mut find: impl FnMut(u32, u16) -> u16) {
    let mut cache = [(EMPTY, 0u16, 0u16); 1 << CACHE_LOG2];
    // Neighbours mostly show the same.
    let mut last = (EMPTY, 0u16, 0u16);
    let (groups, rest) = ids.as_chunks::<LANES>();
    debug_assert!(rest.is_empty(), "tiles have whole groups of samples");
    for (group, ids) in groups.iter().enumerate() {
        let none = [0u16; LANES];
        let parents = parents.map_or(&none, |parents| &parents.as_chunks::<LANES>().0[group]);
        let other_ids = ids.iter().fold(0, |sum, id| sum | (id ^ last.0));
        let other_parents = parents.iter().fold(0, |sum, parent| sum | (parent ^ last.1));
        if other_ids == 0 && other_parents == 0 {
            labels.extend_from_slice(&[last.2; LANES]);
            continue;
        }
        let mut found = [0u16; LANES];
        for (found, (&id, &parent)) in found.iter_mut().zip(ids.iter().zip(parents)) {
            if id == EMPTY {
                continue;
            }
            if (id, parent) != (last.0, last.1) {
                let key = (id ^ u32::from(parent) << 20).wrapping_mul(0x9e37_79b9);
                let place = &mut cache[(key >> (32 - CACHE_LOG2)) as usize];
                if (place.0, place.1) != (id, parent) {
                    *place = (id, parent, find(id, parent));
                }
                last = *place;
            }
            *found = last.2;
        }
        labels.extend_from_slice(&found);
    }
}

/// The pixels of a root tile by the path that they show.
#[derive(Default)]
pub(in super::super) struct RootPaths {
    /// Paths (plus 1), each with the bits of the pixels whose samples all show it.
    pub(in super::super) full: Vec<(u16, [u16; ROOT])>,
    /// Other pixels.
    pub(in super::super) partial: Vec<PartialPixel>,
}

/// A pixel some of whose samples show a path.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct PartialPixel {
    /// The path, plus 1.
    pub(in super::super) label: u16,
    /// Column and row in the root tile.
    pub(in super::super) place: [u8; 2],
    /// Bits of the samples.
    pub(in super::super) samples: u32,
}

impl RootPaths {
    /// Finds the paths in the root tile whose first pixel has this column and row in the tile.
    pub(in super::super) fn gather(&mut self, tile: &TileBelow<'_>, [column, row]: [usize; 2], paths: &TilePaths) {
        self.full.clear();
        self.partial.clear();
        let labels = &paths.labels[tile.layer() - 1];
        let samples = tile.positions.len();
        for y in 0..ROOT.min(tile.extent[1].saturating_sub(row)) {
            for x in 0..ROOT.min(tile.extent[0].saturating_sub(column)) {
                let first = tile.first_sample(column + x, row + y);
                let labels = &labels[first..first + samples];
                let differences = labels.iter().fold(0, |sum, label| sum | (label ^ labels[0]));
                if differences == 0 {
                    if labels[0] != 0 {
                        self.rows_of(labels[0])[y] |= 1 << x;
                    }
                    continue;
                }
                let mut rest = labels.iter().enumerate().fold(0u32, |bits, (i, l)| bits | u32::from(*l != 0) << i);
                while rest != 0 {
                    let label = labels[rest.trailing_zeros() as usize];
                    let same = labels.iter().enumerate().fold(0, |bits, (i, l)| bits | u32::from(*l == label) << i);
                    self.partial.push(PartialPixel { label, place: [x as u8, y as u8], samples: same });
                    rest &= !same;
                }
            }
        }
    }

    fn rows_of(&mut self, label: u16) -> &mut [u16; ROOT] {
        let known = self.full.iter().rposition(|(other, _)| *other == label);
        let place = known.unwrap_or_else(|| {
            self.full.push((label, [0; ROOT]));
            self.full.len() - 1
        });
        &mut self.full[place].1
    }
}
