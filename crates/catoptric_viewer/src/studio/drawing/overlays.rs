//! Overlays of the left side.

use super::side::{Side, Tools};
use crate::studio::interrupt::{EndedBy, Interrupt};
use crate::studio::order::{Drawn, Wish};
use catoptric::error::RenderError;
use catoptric::methods::overlay::{Overlay, OverlayKind};
use catoptric::methods::{self, Prepared};
use catoptric::progress::Progress;
use catoptric::scene::{Scene, View};
use catoptric_bake::BakeChoice;
use std::sync::Arc;

/// Makes overlays, by what is ready to draw the picture, if that is on the CPU.
#[derive(Default)]
pub(in crate::studio) struct OverlayMaker {
    /// The method on the CPU, made ready for overlays alone: where the preparation that draws the picture does not
    /// serve for them.
    own: Option<(Drawn, Arc<Scene>, Box<dyn Prepared>)>,
}

impl OverlayMaker {
    /// Makes an overlay of a wish's left side; an empty one where the method has none of the kind.
    ///
    /// # Errors
    /// [`RenderError::Cancelled`] where something newer waits; else the reason why it cannot be made.
    pub(in crate::studio) fn draw(
        &mut self,
        side: &mut Side,
        wish: &Arc<Wish>,
        scene: &Arc<Scene>,
        kind: OverlayKind,
        tools: Tools<'_>,
    ) -> Result<Overlay, RenderError> {
        let Some(drawn) = wish.sides.first() else { return Ok(Overlay::new(kind, wish.size)) };
        let method = methods::create(&drawn.method, &drawn.settings)?;
        if !method.overlays().contains(&kind) {
            return Ok(Overlay::new(kind, wish.size));
        }
        let progress = Interrupt::new(tools.mailbox, tools.tell, (wish, 0), EndedBy::Anything);
        let view = scene.view(&wish.camera, wish.size[0], wish.size[1]);
        if let Some(prepared) = side.on_cpu(drawn, scene) {
            self.own = None;
            return of_frame(prepared, &view, kind, &progress);
        }
        let is_same = |(of, known, _): &(Drawn, Arc<Scene>, _)| of == drawn && Arc::ptr_eq(known, scene);
        let own = match self.own.take().filter(is_same) {
            Some(own) => own,
            None => {
                let info = methods::find(&drawn.method)?;
                let BakeChoice { settings, bake, .. } =
                    tools.bakes.choose(info, &drawn.settings, scene, drawn.quality)?;
                let method = methods::create(&drawn.method, &settings)?;
                (drawn.clone(), scene.clone(), method.prepare(scene, drawn.quality, bake, &progress)?)
            }
        };
        of_frame(&mut *self.own.insert(own).2, &view, kind, &progress)
    }
}

fn of_frame(
    prepared: &mut dyn Prepared,
    view: &View,
    kind: OverlayKind,
    progress: &dyn Progress,
) -> Result<Overlay, RenderError> {
    let found = prepared.frame(view, progress)?.overlay(kind, progress)?;
    Ok(found.unwrap_or_else(|| Overlay::new(kind, [view.width, view.height])))
}
