//! The processor's part of a view of a method that projects: made when it is needed.

use catoptric::error::RenderError;
use catoptric::methods::{Frame, Prepared, Quality};
use catoptric::progress::{Progress, Silent};
use catoptric::scene::{Scene, View};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// The data that a method that projects has prepared, perhaps for an earlier moment of the scene.
pub(super) struct PreparedProjection {
    prepared: Box<dyn Prepared>,
    /// The moment that it is to follow.
    pending: Option<(Arc<Scene>, Quality)>,
}

impl PreparedProjection {
    pub(super) fn new(prepared: Box<dyn Prepared>) -> Self {
        Self { prepared, pending: None }
    }

    /// Has the data follow the scene when it is needed: where devices find virtual geometry, perhaps never.
    pub(super) fn update_later(&mut self, scene: &Arc<Scene>, quality: Quality) {
        self.pending = Some((scene.clone(), quality));
    }

    /// The data at the moment of the scene that it is to follow.
    pub(super) fn updated(&mut self, progress: &dyn Progress) -> Result<&mut dyn Prepared, RenderError> {
        if let Some((scene, quality)) = &self.pending {
            self.prepared.update(scene, *quality, progress)?;
            self.pending = None;
        }
        Ok(&mut *self.prepared)
    }
}

/// The processor's part of a view, if there is one.
pub(super) struct Projection<'a> {
    prepared: Mutex<Option<&'a mut PreparedProjection>>,
    frame: OnceLock<Result<Option<Box<dyn Frame + 'a>>, RenderError>>,
}

impl<'a> Projection<'a> {
    /// Not made yet; `prepared` is there for methods that project.
    pub(super) fn new(prepared: Option<&'a mut PreparedProjection>) -> Self {
        Self { prepared: Mutex::new(prepared), frame: OnceLock::new() }
    }

    fn made(&self, view: &View, progress: &dyn Progress) -> Result<Option<Box<dyn Frame + 'a>>, RenderError> {
        let taken = self.prepared.lock().unwrap_or_else(PoisonError::into_inner).take();
        taken.map(|prepared| prepared.updated(progress)?.frame(view, progress)).transpose()
    }

    /// Makes it.
    pub(super) fn build(&mut self, view: &View, progress: &dyn Progress) -> Result<(), RenderError> {
        self.frame = OnceLock::from(Ok(self.made(view, progress)?));
        Ok(())
    }

    /// The frame of that part, if it has been made.
    pub(super) fn frame(&self) -> Option<&(dyn Frame + 'a)> {
        self.frame.get()?.as_ref().ok()?.as_deref()
    }

    /// The frame of that part, made now if need be.
    pub(super) fn frame_of(&self, view: &View) -> Result<Option<&(dyn Frame + 'a)>, &RenderError> {
        self.frame.get_or_init(|| self.made(view, &Silent)).as_ref().map(Option::as_deref)
    }
}
