//! Settings of layered environment maps.

use catoptric_engine::method::{declare_choices, declare_settings};

declare_choices! {
    /// The shape that stands in for the things of a layer.
    pub enum Shells {
        /// The best fitting one of the others, layer by layer.
        Auto = "auto",
        /// A sphere.
        Sphere = "sphere",
        /// A box along the axes.
        Box = "box",
        /// An upright cylinder with a top and a bottom.
        Cylinder = "cylinder",
        /// A rectangle where a layer's things are on one side, else a sphere.
        Quad = "quad",
    }
}

declare_choices! {
    /// The property by which things share a layer.
    pub enum Clustering {
        /// The shapes that stand in for them: the walls of a room belong together, whatever their distances.
        Shape = "shape",
        /// Their distances from the group (the paper's).
        Distance = "distance",
    }
}

declare_choices! {
    /// The way in which paths from the eye out of a group of reflectors and lenses are traced.
    pub enum Transfer {
        /// At the vertices of a mesh that is refined in every frame (the paper's).
        Adaptive = "adaptive",
        /// For every fragment: for comparison.
        Exact = "exact",
    }
}

declare_choices! {
    /// The paths in the smallest triangles of the adaptive mesh where those of the corners differ in their surfaces.
    pub enum Edges {
        /// Traced for each fragment: samples of a pixel in several triangles of the mesh are several fragments.
        Traced = "traced",
        /// Traced once for each pixel.
        Once = "once",
        /// The nearest corner's.
        Nearest = "nearest",
    }
}

declare_choices! {
    /// The source of the layers' textures.
    pub enum Textures {
        /// The view from the middle of the shells.
        Projected = "projected",
        /// A least-squares fit to pictures from viewpoints (the paper's).
        Inferred = "inferred",
    }
}

declare_choices! {
    /// The viewpoints for which textures are inferred.
    pub enum Viewpoints {
        /// A circle about the group, at the height of the scene's first camera (the paper's).
        Circle = "circle",
        /// A line across the view of the scene's first camera.
        Line = "line",
        /// Circles at several heights, as far apart as the viewpoints on them.
        Grid = "grid",
    }
}

declare_choices! {
    /// The source of the parts of inferred textures that no picture of a viewpoint shows.
    pub enum Direct {
        /// They stay empty.
        None = "none",
        /// The view from the middle of the shells.
        Center = "center",
        /// The view from the viewpoint, past the reflectors and lenses, of what is behind these.
        Viewpoint = "viewpoint",
        /// The view from the viewpoint, and else from the middle of the shells.
        Both = "both",
    }
}

impl Direct {
    /// The view from the middle of the shells is used.
    pub(super) fn is_from_center(self) -> bool {
        matches!(self, Self::Center | Self::Both)
    }

    /// The view from the viewpoint is used.
    pub(super) fn is_from_viewpoint(self) -> bool {
        matches!(self, Self::Viewpoint | Self::Both)
    }
}

declare_choices! {
    /// A set of values that the other settings start from.
    pub enum Preset {
        /// The view from the middle of the shells, with depths.
        Balanced = "balanced",
        /// As in the paper: textures inferred from viewpoints on a circle, on spheres and rectangles at clustered
        /// distances, looked up by paths that are 3 degrees apart at most or no longer than `tau`.
        Faithful = "faithful",
    }
}

declare_settings! {
    /// Settings of layered environment maps.
    pub struct LayeredEnvironmentMapSettings of "layered_environment_map" {
        /// The set of values that the other settings start from.
        preset: Preset = Preset::Balanced;
        /// The most layers about a group of reflectors and lenses.
        layers: u32 = 3, range(1.0, 16.0), baked();
        /// The property by which things share a layer.
        clustering: Clustering = Clustering::Shape, baked();
        /// The shape that stands in for the things of a layer.
        shells: Shells = Shells::Auto, baked();
        /// Side of a layer's texture, or of each face of its cube; 0: by what a view reads, from 64 to 512, but 256 in
        /// bakes and where textures are inferred.
        size: u32 = 0, one_of(&[0, 8, 16, 32, 64, 128, 256, 512, 1024]), unit("texels"), baked();
        /// Rays a texel, or a pixel of the pictures that textures are inferred from.
        capture_samples: u32 = 4, one_of(&[1, 4, 9, 16]), baked();
        /// Each texel has the distance of what it shows; without, all is on its shell (the paper's).
        depth: bool = true, baked();
        /// All groups of reflectors and lenses share one farthest layer.
        share_far: bool = false, baked();
        /// Layers have what nearer layers hide, and inferred ones also what is seen of them where a group hides itself;
        /// without, they have the first hits alone.
        continued: bool = true, baked();
        /// The source of the layers' textures.
        textures: Textures = Textures::Projected, baked();
        /// The viewpoints for which textures are inferred.
        viewpoints: Viewpoints = Viewpoints::Circle, baked();
        /// Viewpoints on a circle or line; 45 on a circle are 8 degrees apart.
        viewpoint_count: u32 = 45, range(1.0, 360.0), baked();
        /// Circles of a grid of viewpoints.
        viewpoint_rows: u32 = 3, range(2.0, 16.0), baked();
        /// Length of a line of viewpoints; 0: the distance of the scene's first camera from the group.
        line_length: f32 = 0.0, at_least(0.0), unit("scene units"), baked();
        /// Side of the pictures that textures are inferred from.
        picture_size: u32 = 384, range(16.0, 2048.0), unit("pixels"), baked();
        /// Pictures on either side of a viewpoint, up to half way to the next one, that are used for it too.
        neighbours: u32 = 1, range(0.0, 4.0), baked();
        /// The source of the parts of inferred textures that no picture of a viewpoint shows.
        direct: Direct = Direct::Center, baked();
        /// The way in which paths from the eye out of a group of reflectors and lenses are traced.
        transfer: Transfer = Transfer::Adaptive;
        /// The paths in the smallest triangles of the adaptive mesh where those of the corners differ in their
        /// surfaces.
        edges: Edges = Edges::Traced;
        /// Edges of the adaptive mesh that are no longer than this in the picture are not divided.
        tau: f32 = 3.0, range(0.5, 100.0), unit("pixels");
        /// Rays that leave in directions no further apart than this are not divided. The paper has 3 degrees, for
        /// look-ups at vertices; rays that are interpolated in every fragment come out as well with 6.
        angle_deg: f32 = 6.0, range(0.1, 90.0), unit("degrees");
        /// Reports a frame's tests of rays against triangles and surfaces, which takes longer.
        count_tests: bool = false;
    }

    fn start(&self) -> Self {
        Self::preset(self.preset)
    }
}

/// The size of textures that are not made for a view. Chosen, not measured.
const SIZE_FOR_ALL_VIEWS: u32 = 256;

impl LayeredEnvironmentMapSettings {
    /// These settings with a size of textures.
    pub(super) fn sized(&self) -> Self {
        Self { size: if self.size == 0 { SIZE_FOR_ALL_VIEWS } else { self.size }, ..self.clone() }
    }

    /// The settings of a preset.
    pub fn preset(preset: Preset) -> Self {
        let balanced = Self { preset, ..Self::default() };
        match preset {
            Preset::Balanced => balanced,
            Preset::Faithful => Self {
                clustering: Clustering::Distance,
                shells: Shells::Quad,
                depth: false,
                textures: Textures::Inferred,
                edges: Edges::Nearest,
                angle_deg: 3.0,
                ..balanced
            },
        }
    }
}
