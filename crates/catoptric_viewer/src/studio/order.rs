//! Orders and wishes of the window to the studio.

use catoptric::error::SceneError;
use catoptric::methods::Quality;
use catoptric::methods::overlay::OverlayKind;
use catoptric::scene::edits::{Look, LookRule, MoveRule};
use catoptric::scene::roles::RoleRule;
use catoptric::scene::{Camera, PoseOptions, Role};
use catoptric::tone::Display;
use catoptric_scenes::import::{EnvironmentEdit, Resolver};
use glam::Vec3;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A built-in scene: `NAME?key=value&...`.
    Builtin(String),
    /// A file with those that it names.
    File(PathBuf),
    /// A file that was dropped or downloaded, by its name, with those that came with it.
    Bytes {
        /// The file's name, whose extension tells its kind.
        name: String,
        /// The file's content.
        bytes: Arc<[u8]>,
        /// The files that came with it, which it may name.
        beside: Beside,
    },
}

/// Files by their names, without folders: browsers tell no more.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Beside(pub Arc<BTreeMap<String, Vec<u8>>>);

impl Resolver for Beside {
    fn read(&self, name: &str, limit: u64) -> Result<Vec<u8>, SceneError> {
        let plain = name.rsplit(['/', '\\']).next().unwrap_or(name);
        let Some(bytes) = self.0.get(plain) else {
            return Err(SceneError::invalid(name, "path", "is not among the files: open it together with the scene"));
        };
        if bytes.len() as u64 > limit {
            let problem = format!("has {} bytes; at most {limit} are allowed", bytes.len());
            return Err(SceneError::invalid(name, "file", problem));
        }
        Ok(bytes.clone())
    }
}

/// The file of several that is the scene: one that names others before those that are named.
pub fn scene_of<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<usize> {
    let rank = |name: &str| {
        let name = name.to_lowercase();
        [".toml", ".gltf", ".glb", ".obj", ".ply", ".stl"].into_iter().position(|end| name.ends_with(end)).unwrap_or(6)
    };
    names.into_iter().enumerate().min_by_key(|(_, name)| rank(name)).map(|(index, _)| index)
}

impl Source {
    /// The source that a word of a command line or of an address stands for: `builtin:NAME`, else a path.
    pub fn of_word(word: &str) -> Self {
        match word.strip_prefix("builtin:") {
            Some(spec) => Self::Builtin(spec.into()),
            None => Self::File(word.into()),
        }
    }

    /// The name without folders and parameters.
    pub fn short_name(&self) -> String {
        match self {
            Self::Builtin(spec) => spec.split('?').next().unwrap_or(spec).into(),
            Self::File(path) => path.file_name().map_or_else(|| self.word(), |name| name.display().to_string()),
            Self::Bytes { name, .. } => name.clone(),
        }
    }

    /// The word that stands for it.
    pub fn word(&self) -> String {
        match self {
            Self::Builtin(spec) => format!("builtin:{spec}"),
            Self::File(path) => path.display().to_string(),
            Self::Bytes { name, .. } => name.clone(),
        }
    }
}

/// How a scene is opened: what is wanted over its files, and choices among what they have several of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Opening {
    /// Light from infinity in place of the scene's own, by name or file.
    pub environment: Option<PathBuf>,
    /// How the environment is turned and scaled.
    pub environment_edit: EnvironmentEdit,
    /// The variant of a glTF file's materials.
    pub variant: Option<String>,
    /// Files that a scene names may lie anywhere.
    pub allow_outside: bool,
    /// Materials that let light pass and have no volume are taken for glass all through.
    pub has_solid_glass: bool,
    /// Nothing casts shadows.
    pub lacks_shadows: bool,
    /// Surfaces scatter no light onto each other.
    pub lacks_bounces: bool,
    /// Roles over the scene's own; later ones win.
    pub roles: Vec<RoleChange>,
}

/// A method with its settings and quality: what is drawn on one side of the divider.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// The method's id.
    pub method: String,
    /// Settings over the scene's own.
    pub settings: toml::Table,
    /// Samples and order.
    pub quality: Quality,
}

/// A role given to everything of a name.
#[derive(Clone, Debug, PartialEq)]
pub struct RoleChange {
    /// The node's or material's name, or a glob.
    pub name: String,
    /// The role; `Lens` with its index of refraction.
    pub role: Role,
    /// Index of refraction, for lenses.
    pub ior: Option<f32>,
}

/// The user's changes over the scene's file, by names of nodes or materials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// Roles; later ones win.
    pub roles: Vec<RoleChange>,
    /// Looks.
    pub looks: BTreeMap<String, Look>,
    /// Ways in the world.
    pub moves: BTreeMap<String, Vec3>,
}

impl From<&RoleRule> for RoleChange {
    fn from(rule: &RoleRule) -> Self {
        Self { name: rule.pattern().into(), role: rule.role(), ior: rule.ior() }
    }
}

impl Changes {
    /// True if nothing is different.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The scene's pose at a time with these changes.
    ///
    /// # Errors
    /// [`SceneError`] for numbers that are not allowed.
    pub fn pose_at(&self, time: f32) -> Result<PoseOptions, SceneError> {
        let role = |change: &RoleChange| RoleRule::new(&change.name, change.role, change.ior);
        Ok(PoseOptions {
            time,
            roles: self.roles.iter().map(role).collect::<Result<_, _>>()?,
            looks: self.looks.iter().map(|(name, look)| LookRule::new(name, *look)).collect::<Result<_, _>>()?,
            moves: self.moves.iter().map(|(name, by)| MoveRule::new(name, *by)).collect::<Result<_, _>>()?,
        })
    }
}

/// The picture or two that the window wants to show now.
#[derive(Clone, Debug, PartialEq)]
pub struct Wish {
    /// The number of the load that brought the scene.
    pub scene: u64,
    /// Time in the scene's animations, seconds.
    pub time: f32,
    /// The index of the animation that plays alone; `None`: all that the scene plays.
    pub clip: Option<usize>,
    /// The user's changes over the file.
    pub changes: Changes,
    /// The camera.
    pub camera: Camera,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The left side, and the right one where the view is split.
    pub sides: Vec<Drawn>,
    /// Their order is the one that the scene needs: paths that end there show light from infinity, not nothing.
    pub has_automatic_order: bool,
    /// The exposure and tone curve of both.
    pub display: Display,
    /// Both sides are to be compared once they are done.
    pub compares: bool,
    /// Overlays to be shown over the left side once its picture is done.
    pub overlays: Vec<OverlayKind>,
}

impl Wish {
    /// True if both wish for the same pictures, whatever is shown over them.
    pub fn shows_same(&self, other: &Self) -> bool {
        self.draws_same(other) && (self.display, self.compares) == (other.display, other.compares)
    }

    /// True if both wish for the same light, however it is displayed.
    pub fn draws_same(&self, other: &Self) -> bool {
        let drawn = |wish: &Self| (wish.size, wish.has_automatic_order);
        self.sees_same(other) && drawn(self) == drawn(other) && self.sides == other.sides
    }

    /// True if both look at the same things from the same place.
    pub fn sees_same(&self, other: &Self) -> bool {
        let seen = |wish: &'_ Self| (wish.scene, wish.time, wish.clip);
        seen(self) == seen(other) && (&self.changes, &self.camera) == (&other.changes, &other.camera)
    }
}

/// Anything that the window asks for.
#[derive(Clone, Debug)]
pub enum Order {
    /// Load a scene, which takes the place of the one before.
    Load {
        /// The number by which wishes name it.
        number: u64,
        /// Where it is.
        source: Source,
        /// How it is opened.
        opening: Opening,
    },
    /// Use a bake wherever it fits, from now on.
    UseBake {
        /// The bake's file.
        path: PathBuf,
    },
    /// Tell what is seen at a place of the picture (pixels) of the last wish.
    Pick {
        /// Told back with the answer.
        number: u64,
        /// Pixels from the top left corner.
        position_px: [f32; 2],
    },
}
