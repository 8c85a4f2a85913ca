//! Begins with a scene: how it is opened, and what is seen of it first.

use super::state::Viewer;
use super::state::navigator::Navigator;
use super::state::start::FirstView;
use crate::studio::news::SceneSummary;
use crate::studio::order::{Opening, Source};

impl Viewer {
    /// How a scene is opened: the one that the window begins with as is wanted, others as they are.
    pub(in crate::app) fn opening_of(&self, source: &Source) -> Opening {
        if *source == self.start.source { self.start.opening.clone() } else { Opening::default() }
    }

    /// Begins to look at a scene: the first one as is wanted, others as they have it.
    pub(in crate::app) fn begin_view(&mut self, scene: &SceneSummary) {
        let is_first = self.source == self.start.source;
        let first = if is_first { std::mem::take(&mut self.start.view) } else { FirstView::default() };
        let (camera, index, remark) = first.camera(scene);
        self.navigator = camera.map(|camera| Navigator::new(camera, &scene.bounds));
        self.camera = index;
        remark.into_iter().for_each(|remark| self.say(remark));
        self.display = first.display(scene);
        self.clip = None;
        if let Some(wanted) = &first.animation {
            let named = scene.clips.iter().position(|clip| clip.name == *wanted && !clip.name.is_empty());
            self.clip = named.or_else(|| wanted.parse().ok()).filter(|index| *index < scene.clips.len());
            if self.clip.is_none() {
                let names = scene.clips.iter().map(|clip| format!("`{}`", clip.name)).collect::<Vec<_>>();
                let names = if names.is_empty() { "none".into() } else { names.join(", ") };
                self.say(format!("there is no animation `{wanted}`; there are: {names}"));
            }
        }
        self.clock.begin(scene.duration(self.clip));
        self.clock.set(first.time);
        if self.clock.time() != first.time {
            let (asked, end) = (first.time, self.clock.duration());
            self.say(format!("--time {asked}: the animation goes from 0 to {end} s; shown is {} s", self.clock.time()));
        }
    }

    /// Has an animation play alone, or all of them, from the beginning.
    pub(in crate::app) fn choose_clip(&mut self, clip: Option<usize>) {
        self.clip = clip;
        if let Some(scene) = &self.scene {
            self.clock.begin(scene.duration(clip));
        }
    }
}
