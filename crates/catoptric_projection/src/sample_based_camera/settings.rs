//! The settings of sample-based cameras.

use crate::draw::work_limit::{BeyondWork, WORK_A_PIXEL, WORK_ALONE, WorkLimit};
use catoptric_engine::method::{declare_choices, declare_settings};
use glam::UVec3;
use globset::{Glob, GlobSet, GlobSetBuilder};

/// The margin of the ray map around the picture, in cells: triangles with corners there reach into the picture. Chosen,
/// not measured.
pub(super) const MARGIN_CELLS: f32 = 4.0;

/// Rays across a face at the most: all six take some gigabytes then.
pub(super) const MAX_RAYS: u32 = 2048;

/// Fewer nodes along an axis have no cell between them, and more are a mistake.
const NODES: std::ops::RangeInclusive<u32> = 2..=257;

declare_choices! {
    /// The places of cameras.
    pub enum Mode {
        /// At the eye: they are built for every view.
        Runtime = "runtime",
        /// At nodes of a grid around every reflector: appearances at four of them are blended (section VI).
        Morph = "morph",
    }
}

declare_choices! {
    /// The treatment of points that some nodes see and others do not.
    pub enum Ambiguous {
        /// They are followed beyond the horizons and borders of the others.
        Cured = "cured",
        /// They are left out, as in Figure 15a of the paper: holes show where they are.
        Discarded = "discarded",
    }
}

declare_choices! {
    /// The way in which a point's appearances at the nodes are blended.
    pub enum Blend {
        /// Ours: made exact, blended with what their derivatives say of the way, and solved from the eye where that is
        /// not accurate.
        Solved = "solved",
        /// The paper's: the mean of what the cameras say, by barycentric weights, and nothing but that.
        Mean = "mean",
    }
}

declare_choices! {
    /// The form of leaves.
    pub enum CameraKind {
        /// Ours: polynomials over surface coordinates, in blocks of the ray map.
        RayBundle = "ray_bundle",
        /// The paper's: pinholes with a quadratic map, in a tree of splitting planes.
        Pinhole = "pinhole",
    }
}

declare_choices! {
    /// A set of values that the other settings start from.
    pub enum Preset {
        /// A quarter of the resolution, one pixel: for previews.
        Fast = "fast",
        /// Half the resolution, a tenth of a pixel.
        Balanced = "balanced",
        /// As balanced, and every vertex made exact by the solver.
        Exact = "exact",
        /// As in the paper: pinholes, half the resolution, one pixel; with `mode=morph` the mean of four nodes.
        Faithful = "faithful",
    }
}

declare_settings! {
    /// Settings of sample-based cameras.
    pub struct SampleBasedCameraSettings of "sample_based_camera" {
        /// The set of values that the other settings start from.
        preset: Preset = Preset::Balanced;
        /// Where cameras stand.
        mode: Mode = Mode::Runtime, baked();
        /// The form of leaves.
        camera: CameraKind = CameraKind::RayBundle, baked();
        /// The largest error of a leaf at the points of its rays.
        accuracy_px: f32 = 0.1, range(0.01, 100.0), unit("pixels"), baked();
        /// Pinholes: rays are split by a plane unless its sides together have more than this many times the rays; 2:
        /// the paper's rule.
        max_shared: f32 = 1.5, range(1.0, 2.0), baked();
        /// Spacing of the rays of the map.
        downsampling: u32 = 2, range(1.0, 64.0), unit("pixels"), baked();
        /// Where no camera is accurate, rays between those of the map are traced, down to this spacing; 1000: none.
        finest_ray_px: f32 = 0.12, range(0.03, 1000.0), unit("pixels"), baked();
        /// The most steps of the solver that makes appearances exact; 0: none.
        polish: u32 = 0, range(0.0, 100.0);
        /// Edges of virtual geometry are divided until they are this near to where they belong.
        edge_error_px: f32 = 0.15, range(0.01, 100.0), unit("pixels");
        /// Pieces that appear in part are divided down to this size.
        piece_px: f32 = 0.75, range(0.1, 100.0), unit("pixels");
        /// Work that finding a picture's virtual points may take, in units of about 100 ns of one core, for every pixel
        /// of 720 x 480 or more.
        work: f32 = WORK_A_PIXEL, range(0.0, 1e6);
        /// The way to draw paths that are not done with that work.
        beyond_work: BeyondWork = BeyondWork::Tiles;
        /// Names of the reflectors and lenses that show environment maps: patterns with * and ?, separated by commas.
        environment: String = String::new(), baked();
        /// Reflectors and lenses that appear no larger than this in either direction show environment maps, too; 0:
        /// none.
        environment_below_px: f32 = 0.0, range(0.0, 1e5), unit("pixels");
        /// Side of a face of these maps.
        environment_size: u32 = 256, range(4.0, 4096.0), unit("texels");
        /// Morphing: nodes of the grid along x, z and y.
        grid: String = "17x17x8".into(), baked();
        /// Morphing: the grid reaches so far beyond its reflector.
        grid_reach: f32 = 2.0, range(0.1, 100.0), unit("diagonals of the reflector's box"), baked();
        /// Morphing: side of each of the six pictures about a node whose rays are mapped.
        node_size: u32 = 512, range(16.0, 4096.0), unit("pixels"), baked();
        /// Morphing: what becomes of a point's appearances at the nodes.
        blend: Blend = Blend::Solved, baked();
        /// Morphing: what becomes of points that some nodes see and others do not.
        ambiguous: Ambiguous = Ambiguous::Cured;
        /// Morphing: nodes that no view needs are forgotten beyond this.
        node_memory: u32 = 512, range(0.0, 1e6), unit("MiB");
    }

    fn start(&self) -> Self {
        Self::preset(self.preset)
    }

    fn check_rules(&self) -> Result<(), String> {
        patterns(&self.environment)?;
        node_counts(&self.grid)?;
        if self.mode == Mode::Morph {
            let most = MAX_RAYS.saturating_mul(self.downsampling);
            if self.node_size > most {
                let (size, apart) = (self.node_size, self.downsampling);
                return Err(format!("node_size = {size} with downsampling = {apart}: it may be {most} at the most"));
            }
            if self.beyond_work == BeyondWork::Coarse && self.blend == Blend::Solved {
                let message = "mode = \"morph\" has tiles draw what it cannot blend: leave `beyond_work` out, or have \
                               it blend everything (blend = \"mean\")";
                return Err(message.into());
            }
        }
        Ok(())
    }
}

impl SampleBasedCameraSettings {
    /// The limit of a frame's work.
    pub(super) fn work_limit(&self) -> WorkLimit {
        WorkLimit { a_pixel: self.work, beyond: self.beyond_work }
    }

    /// The settings of a preset.
    pub fn preset(preset: Preset) -> Self {
        let balanced = Self { preset, ..Self::default() };
        match preset {
            Preset::Fast => Self {
                accuracy_px: 1.0,
                downsampling: 4,
                finest_ray_px: 1.0,
                edge_error_px: 0.5,
                piece_px: 3.0,
                ..balanced
            },
            Preset::Balanced => balanced,
            Preset::Exact => Self { polish: 8, ..balanced },
            Preset::Faithful => Self {
                camera: CameraKind::Pinhole,
                accuracy_px: 1.0,
                max_shared: 2.0,
                edge_error_px: 0.5,
                blend: Blend::Mean,
                ambiguous: Ambiguous::Discarded,
                work: WORK_ALONE,
                beyond_work: BeyondWork::Coarse,
                ..balanced
            },
        }
    }
}

/// The given names as patterns.
///
/// # Errors
/// Says what is wrong with one of them.
pub(super) fn patterns(names: &str) -> Result<GlobSet, String> {
    let mut set = GlobSetBuilder::new();
    for name in names.split(',').map(str::trim).filter(|name| !name.is_empty()) {
        set.add(Glob::new(name).map_err(|error| format!("environment = \"{names}\": {error}"))?);
    }
    set.build().map_err(|error| format!("environment = \"{names}\": {error}"))
}

/// The numbers of nodes along x, z and y that a text such as `17x17x8` gives.
///
/// # Errors
/// Says what is wrong with the text.
pub fn node_counts(text: &str) -> Result<UVec3, String> {
    let parts: Vec<Option<u32>> = text.split('x').map(|part| part.trim().parse().ok()).collect();
    let allowed = |count: &u32| NODES.contains(count);
    match parts[..] {
        [Some(x), Some(z), Some(y)] if [x, y, z].iter().all(allowed) => Ok(UVec3::new(x, y, z)),
        _ => {
            let (least, most) = (NODES.start(), NODES.end());
            Err(format!(
                "grid = \"{text}\": wanted are the numbers of nodes along x, z and y, {least} to {most} each, such as \
                 \"17x17x8\""
            ))
        }
    }
}

/// How far the ray map of a view reaches beyond its picture, in pixels.
pub(super) fn margin_px(settings: &SampleBasedCameraSettings) -> f32 {
    MARGIN_CELLS * settings.downsampling as f32
}
