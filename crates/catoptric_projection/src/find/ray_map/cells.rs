//! The cells of a ray map: a regular grid, refined where neighbouring rays disagree.

use super::field::RayField;
use super::sample::{Approximation, RaySample, follow};
use super::scatter::Specular;
use catoptric_core::math::Aabb;
use catoptric_core::math::portable::PortableMath;
use catoptric_core::parallel;
use catoptric_core::progress::{Cancelled, Progress};
use catoptric_engine::method::projector::SpecularPath;

/// Density of the samples of a field of rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// A ray every so many pixels, in both directions.
    pub spacing_px: f32,
    /// The size down to which cells are divided in four where neighbouring rays disagree; equal to `spacing_px` for a
    /// regular grid.
    pub finest_px: f32,
    /// Neighbours disagree when they belong to different paths, or when one predicts the other's place with a larger
    /// error than this, in pixels.
    pub accuracy_px: f32,
    /// The maximum number of cells that are made.
    pub max_cells: usize,
}

/// A square of the field with a ray through its centre.
#[derive(Clone, Copy, Debug)]
struct SampleCell {
    /// Corner and size, in units of the finest cell.
    corner: [u32; 2],
    size: u32,
}

type PathSamples = Vec<(SpecularPath, RaySample)>;

/// Cells by place of a field.
#[derive(Clone, Debug, Default)]
pub(super) struct CellIndex {
    unit_px: f32,
    extent: [u32; 2],
    index: Vec<u32>,
}

impl CellIndex {
    /// The cell at a place of the field; none outside.
    pub(super) fn cell_at(&self, [x, y]: [f64; 2]) -> Option<u32> {
        let unit = f64::from(self.unit_px);
        let (column, row) = ((x / unit).floor(), (y / unit).floor());
        let inside = column >= 0.0 && row >= 0.0 && column < self.extent[0].into() && row < self.extent[1].into();
        inside.then(|| self.index[row as usize * self.extent[0] as usize + column as usize])
    }
}

/// The cells of a map with their samples.
pub(super) struct SampleCells {
    unit_px: f32,
    /// Width and height of the field in finest cells.
    extent: [u32; 2],
    cells: Vec<SampleCell>,
    samples: Vec<PathSamples>,
    /// Index of the cell that covers each finest cell.
    index: Vec<u32>,
    rays_traced: u64,
    /// Cells that disagree with their neighbours, but are not divided since there would be too many.
    left_coarse: u64,
}

impl SampleCells {
    pub(super) fn sample(
        specular: &Specular<'_>,
        field: &dyn RayField,
        sampling: &Sampling,
        bounds: &Aabb,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let divisions = (sampling.spacing_px / sampling.finest_px).max(1.0).logarithm2().round() as u32;
        let base = 1u32 << divisions.min(10);
        let unit_px = sampling.spacing_px / base as f32;
        let [width, height] = field.size_px();
        let columns = ((width / sampling.spacing_px).ceil() as u32).max(1);
        let rows = ((height / sampling.spacing_px).ceil() as u32).max(1);
        let extent = [columns * base, rows * base];
        let grid = (0..rows).flat_map(|row| (0..columns).map(move |column| [column * base, row * base]));
        let mut cells = Self {
            unit_px,
            extent,
            cells: Vec::new(),
            samples: Vec::new(),
            index: vec![0; extent[0] as usize * extent[1] as usize],
            rays_traced: 0,
            left_coarse: 0,
        };
        let regular = grid.map(|corner| SampleCell { corner, size: base }).collect();
        cells.add(specular, field, regular, &[], progress)?;
        let mut size = base;
        while size > 1 {
            let divided = cells.disagreeing(field, sampling, bounds, size, progress)?;
            if divided.is_empty() {
                break;
            }
            if cells.len() + 3 * divided.len() > sampling.max_cells {
                cells.left_coarse = divided.len() as u64;
                break;
            }
            let half = size / 2;
            let children = divided.iter().flat_map(|&cell| {
                let [x, y] = cells.cells[cell as usize].corner;
                [[x, y], [x + half, y], [x, y + half], [x + half, y + half]]
                    .map(|corner| SampleCell { corner, size: half })
            });
            let children = children.collect();
            cells.add(specular, field, children, &divided, progress)?;
            size = half;
        }
        Ok(cells)
    }

    /// Traces new cells; the first of them take the places of `replaced`.
    fn add(
        &mut self,
        specular: &Specular<'_>,
        field: &dyn RayField,
        new: Vec<SampleCell>,
        replaced: &[u32],
        progress: &dyn Progress,
    ) -> Result<(), Cancelled> {
        let eye = field.eye();
        let samples = parallel::map_stage(progress, "tracing sample rays", new.len(), |index| {
            let cell = &new[index];
            let middle = |corner: u32| (corner as f32 + cell.size as f32 * 0.5) * self.unit_px;
            let (ray, near) = field.ray(middle(cell.corner[0]), middle(cell.corner[1]));
            let mut found: PathSamples = Vec::new();
            follow(specular, &eye, &ray, near, &mut |path, sample| found.push((path, sample)));
            found
        })?;
        for (number, (cell, samples)) in new.into_iter().zip(samples).enumerate() {
            self.rays_traced += 1 + samples.len() as u64;
            // A divided cell's four children take its place and three new ones.
            let place = match (number % 4, replaced.get(number / 4)) {
                (0, Some(&place)) => {
                    self.cells[place as usize] = cell;
                    self.samples[place as usize] = samples;
                    place
                }
                _ => {
                    self.cells.push(cell);
                    self.samples.push(samples);
                    self.cells.len() as u32 - 1
                }
            };
            for y in cell.corner[1]..cell.corner[1] + cell.size {
                let start = (y * self.extent[0] + cell.corner[0]) as usize;
                self.index[start..start + cell.size as usize].fill(place);
            }
        }
        Ok(())
    }

    /// The cells of a size that disagree with a neighbour.
    fn disagreeing(
        &self,
        field: &dyn RayField,
        sampling: &Sampling,
        bounds: &Aabb,
        size: u32,
        progress: &dyn Progress,
    ) -> Result<Vec<u32>, Cancelled> {
        let of_size: Vec<u32> =
            (0..self.cells.len() as u32).filter(|&cell| self.cells[cell as usize].size == size).collect();
        let wanted = parallel::map_stage(progress, "comparing sample rays", of_size.len(), |index| {
            let cell = of_size[index];
            self.neighbours_of(cell).iter().any(|&other| {
                disagree(field, &self.samples[cell as usize], &self.samples[other as usize], sampling, bounds)
            })
        })?;
        Ok(of_size.into_iter().zip(wanted).filter(|(_, wanted)| *wanted).map(|(cell, _)| cell).collect())
    }

    /// The cells around a cell, corners included.
    fn neighbours_of(&self, cell: u32) -> Vec<u32> {
        let SampleCell { corner: [x, y], size } = self.cells[cell as usize];
        let mut found = Vec::with_capacity(8);
        let mut visit = |x: i64, y: i64| {
            if x >= 0 && y >= 0 && x < self.extent[0] as i64 && y < self.extent[1] as i64 {
                found.push(self.index[(y as u32 * self.extent[0] + x as u32) as usize]);
            }
        };
        let (x, y, size) = (x as i64, y as i64, size as i64);
        for step in -1..=size {
            visit(x + step, y - 1);
            visit(x + step, y + size);
            visit(x - 1, y + step);
            visit(x + size, y + step);
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    pub(super) fn len(&self) -> usize {
        self.cells.len()
    }

    pub(super) fn rays_traced(&self) -> u64 {
        self.rays_traced
    }

    pub(super) fn left_coarse(&self) -> u64 {
        self.left_coarse
    }

    /// The paths that occur, sorted.
    pub(super) fn paths(&self) -> Vec<SpecularPath> {
        let mut paths: Vec<SpecularPath> = Vec::new();
        for (path, _) in self.samples.iter().flatten() {
            if let Err(place) = paths.binary_search(path) {
                paths.insert(place, path.clone());
            }
        }
        paths
    }

    /// The size of every cell, in pixels.
    pub(super) fn sizes_px(&self) -> Vec<f32> {
        self.cells.iter().map(|cell| cell.size as f32 * self.unit_px).collect()
    }

    /// The neighbours of every cell.
    pub(super) fn neighbours(&self) -> Vec<Vec<u32>> {
        parallel::map_collect(self.cells.len(), |cell| self.neighbours_of(cell as u32))
    }

    /// Cells by place of the field, and the samples of all cells.
    pub(super) fn into_parts(self) -> (CellIndex, Vec<PathSamples>) {
        (CellIndex { unit_px: self.unit_px, extent: self.extent, index: self.index }, self.samples)
    }
}

/// True if two neighbouring cells saw different paths, or predict each other badly.
fn disagree(field: &dyn RayField, a: &PathSamples, b: &PathSamples, sampling: &Sampling, bounds: &Aabb) -> bool {
    if a.len() != b.len() || a.iter().zip(b).any(|((first, _), (second, _))| first != second) {
        return true;
    }
    a.iter().zip(b).any(|((_, a), (_, b))| predicts_badly(field, a, b, sampling.accuracy_px, bounds))
}

/// True if a sample puts points on a neighbour's ray further from the neighbour than so many pixels.
pub(super) fn predicts_badly(
    field: &dyn RayField,
    a: &RaySample,
    b: &RaySample,
    accuracy_px: f32,
    bounds: &Aabb,
) -> bool {
    // A point on each ray where it may end: as far away as the scene reaches.
    let size = f64::from(bounds.diagonal());
    [0.15, 0.6].iter().any(|share| {
        let point = b.rays.origin + b.rays.direction * (share * size);
        let Some(truth) = field.place_of(b.first.value) else { return false };
        let Some(guess) = a.neighbour(point, Approximation::Quadratic) else { return true };
        match field.place_of(guess.reflection_point) {
            Some(place) => {
                let error = (place[0] - truth[0]).hypotenuse(place[1] - truth[1]);
                error.is_nan() || error > f64::from(accuracy_px)
            }
            None => true,
        }
    })
}
