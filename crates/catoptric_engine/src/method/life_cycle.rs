//! A method: its declarations, and the states from its settings to a picture.

use crate::error::RenderError;
use crate::method::overlay::{Overlay, OverlayKind};
use crate::method::path_lists::PathLists;
use crate::method::path_query::PathSearch;
use crate::method::projector::{PathBeginnings, VertexProjector};
use crate::method::{Quality, Report, SettingInfo, bake, limits};
use catoptric_core::framebuffer::Framebuffer;
use catoptric_core::progress::Progress;
use catoptric_core::scene::{Scene, View};
use glam::DVec3;
use std::sync::Arc;

/// The way in which a method finds reflections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// The ray-traced truth.
    Reference,
    /// Scene points are projected to where they appear; moved geometry is drawn.
    Projection,
    /// Reflected rays fetch radiance.
    Lookup,
}

impl Family {
    /// The family's name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "reference",
            Self::Projection => "projection",
            Self::Lookup => "lookup",
        }
    }
}

/// Facts to know before a method is chosen, in sentences without their capital letter and full stop.
#[derive(Debug)]
pub struct About {
    /// The method's README, which begins with its idea.
    pub readme: &'static str,
    /// The parts of a picture that it draws, and how.
    pub draws: &'static str,
    /// The time and memory that it takes, before and in each frame.
    pub costs: &'static str,
    /// The faults that its pictures are known to have.
    pub cannot: &'static str,
    /// The names of those settings that change most.
    pub useful: &'static [&'static str],
}

impl About {
    /// The idea of the method: the paragraph of its README that begins with that word, as plain text of one line.
    pub fn idea(&self) -> String {
        let paragraph = self.readme.split("**Idea.** ").nth(1).and_then(|rest| rest.split("\n\n").next());
        let text = paragraph.unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ");
        let mut plain = String::new();
        for (index, part) in text.split('[').enumerate() {
            match part.split_once("](").and_then(|(name, rest)| Some((name, rest.split_once(')')?.1))) {
                Some((name, rest)) if index > 0 => plain.extend([name, rest]),
                _ if index > 0 => plain.extend(["[", part]),
                _ => plain.push_str(part),
            }
        }
        plain
    }
}

/// A method's name, abilities and declarations.
#[derive(Debug)]
pub struct MethodInfo {
    /// The name in the program: that of the method's folder.
    pub id: &'static str,
    /// The half of the problem that it solves.
    pub family: Family,
    /// One line for tables.
    pub summary: &'static str,
    /// Author, year and title of the source.
    pub paper: &'static str,
    /// The conditions under which its pictures are right.
    pub assumptions: &'static str,
    /// The words that explain it.
    pub about: About,
    /// Runs on the CPU.
    pub cpu: bool,
    /// Runs on GPUs, too, by the crate `catoptric_gpu`, in programs that are built with it.
    pub gpu: bool,
    /// The method's long precomputation, if it has any.
    pub bake: Option<bake::MakeBakeWork>,
    /// The method's settings with their defaults.
    pub settings: fn() -> Vec<SettingInfo>,
    /// All settings with the values that a table of some of them leads to, presets included.
    pub effective: fn(&toml::Table) -> Result<toml::Table, RenderError>,
    /// Errors that it must not exceed on built-in scenes.
    pub limits: &'static limits::ErrorLimits,
    /// Makes the method from a table of settings; unknown names and values that are not allowed are errors.
    pub create: fn(&toml::Table) -> Result<Box<dyn Method>, RenderError>,
}

impl MethodInfo {
    /// Checks that the method can take a number of samples a pixel: the reference any, others those that the
    /// rasteriser has patterns for.
    ///
    /// # Errors
    /// [`RenderError::Samples`] for the others.
    pub fn check_samples(&self, samples: u32) -> Result<(), RenderError> {
        match self.family {
            Family::Reference if samples > 0 => Ok(()),
            _ => crate::raster::sample_positions(samples).map(drop),
        }
    }

    /// Refuses a bake, for methods that precompute nothing.
    pub fn refuse_bake(&self, bake: Option<Arc<dyn bake::Baked>>) -> Result<(), RenderError> {
        match bake {
            None => Ok(()),
            Some(_) => Err(RenderError::Limit { method: self.id, problem: "it uses no baked files".into() }),
        }
    }
}

/// A method with its settings: makes what draws a scene.
///
/// States that must not be mixed up are types: a [`Method`] prepares a scene, what is [`Prepared`] makes frames, a
/// [`Frame`] draws. Each step can be cancelled through its [`Progress`] and then leaves what it started from usable.
pub trait Method: Send + Sync {
    /// The method's name and abilities.
    fn info(&self) -> &'static MethodInfo;

    /// The overlays that its frames can give ([`Frame::overlay`]).
    fn overlays(&self) -> &'static [OverlayKind] {
        &[]
    }

    /// Builds what depends on the scene alone, not on the view. `bake` replaces long precomputation
    /// ([`MethodInfo::bake`]).
    ///
    /// # Errors
    /// [`RenderError::Limit`] if the method cannot draw the scene, if the bake does not fit it, and if the
    /// method uses no bakes; [`RenderError::Cancelled`].
    fn prepare(
        &self,
        scene: &Arc<Scene>,
        quality: Quality,
        bake: Option<Arc<dyn bake::Baked>>,
        progress: &dyn Progress,
    ) -> Result<Box<dyn Prepared>, RenderError>;
}

/// A method prepared for a scene. Keeps tables that hold from frame to frame.
pub trait Prepared: Send {
    /// Times, counts and warnings of the preparation, or of the last update.
    fn report(&self) -> &Report;

    /// Replaces the scene after objects, reflectors or materials have changed, or the quality. Keeps tables that still
    /// hold.
    ///
    /// # Errors
    /// As [`Method::prepare`]; the earlier scene stays prepared then.
    fn update(&mut self, scene: &Arc<Scene>, quality: Quality, progress: &dyn Progress) -> Result<(), RenderError>;

    /// Builds what depends on the view, but for what only pictures need.
    ///
    /// # Errors
    /// [`RenderError::Limit`] if the method cannot draw the view; [`RenderError::Cancelled`].
    fn frame<'a>(&'a mut self, view: &View, progress: &dyn Progress) -> Result<Box<dyn Frame + 'a>, RenderError>;
}

/// One view of a prepared scene: can be drawn and queried, as often as needed.
pub trait Frame: Send + Sync {
    /// Times and counts of building the frame.
    fn report(&self) -> &Report;

    /// Draws the picture into `target`, which has the view's size.
    ///
    /// # Errors
    /// [`RenderError::Samples`], [`RenderError::Limit`] as the rasteriser's; [`RenderError::Cancelled`], the picture is
    /// then drawn in part.
    fn draw(&self, target: &mut Framebuffer, progress: &dyn Progress) -> Result<Report, RenderError>;

    /// The virtual geometry of the view's paths, for who draws it otherwise; `None` for methods that draw none.
    ///
    /// # Errors
    /// [`RenderError::Limit`] where the method's settings ask for more than geometry; [`RenderError::Cancelled`].
    fn path_lists(&self, progress: &dyn Progress) -> Result<Option<PathLists>, RenderError> {
        let _ = progress;
        Ok(None)
    }

    /// Something to be shown over the picture; `None` for kinds that the method does not have ([`Method::overlays`]).
    /// Making it takes about as long as a picture.
    ///
    /// # Errors
    /// As [`Frame::draw`] and [`Frame::path_lists`].
    fn overlay(&self, kind: OverlayKind, progress: &dyn Progress) -> Result<Option<Overlay>, RenderError> {
        let _ = (kind, progress);
        Ok(None)
    }

    /// The paths that the picture leaves to something else than the method's own geometry, as tiles: none for methods
    /// that draw all themselves. With the picture's geometry, which is made if it is not there.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`].
    fn paths_left(&self, progress: &dyn Progress) -> Result<PathBeginnings, RenderError> {
        let _ = progress;
        Ok(PathBeginnings::default())
    }

    /// Projects scene points to where they appear; `None` for methods that do not project points.
    fn projector(&self) -> Option<Box<dyn VertexProjector + '_>> {
        None
    }

    /// Finds paths on some objects from an eye (the view's, perhaps with more digits) to scene points by the method's
    /// own search; `None` where there is no better one than to complete the [`Frame::projector`]'s appearances
    /// (`catoptric_projection::find::projected_paths::path_search`).
    ///
    /// # Errors
    /// [`RenderError::Limit`] for paths of more bounces than the search can follow.
    fn path_search(&self, eye: DVec3, objects: &[u32]) -> Result<Option<Box<dyn PathSearch + '_>>, RenderError> {
        let _ = (eye, objects);
        Ok(None)
    }
}
