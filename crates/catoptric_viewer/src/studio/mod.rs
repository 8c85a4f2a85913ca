//! The studio, which draws apart from the window: it takes orders and wishes, and tells news. Neither waits for the
//! other.
//!
//! A wish is drawn as a draft first, as fine as time allows, so that the picture moves; once nothing newer waits it is
//! drawn whole, and given up as soon as something does.

mod drawing;
mod interrupt;
mod mailbox;
pub mod news;
pub mod order;
pub mod pick;
pub mod places;
mod stage;
#[cfg(test)]
mod tests;
pub mod wire;

pub use drawing::Gpu;
pub use mailbox::Mailbox;
pub use news::Tell;

use catoptric::error::RenderError;
use catoptric::methods::overlay::{Overlay, OverlayKind};
use catoptric_bake::Shelf;
use drawing::{Fineness, OnItsWay, Outcome, OverlayMaker, Side, Tools};
use mailbox::Mail;
use news::{News, Overlaid, Picture};
use order::{Opening, Order, Source, Wish};
use places::{PlaceSearch, ReadyMethods, SearchedScene};
use stage::Stage;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// The time after the last arrival before pictures are made sharp: within it a moving eye has moved on.
const REST: Duration = Duration::from_millis(60);

/// The time between looks at a device that draws.
const GLANCE: Duration = Duration::from_millis(1);

/// The part of the viewer that draws, on a thread or in a worker of its own.
pub struct Studio {
    mailbox: Arc<Mailbox>,
    tell: Tell,
    gpu: Option<Gpu>,
    bakes: Shelf,
    stage: Option<Stage>,
    sides: [Side; 2],
    overlay_maker: OverlayMaker,
    /// Where the picked point appears is still being found out.
    place_search: Option<PlaceSearch>,
    ready_methods: ReadyMethods,
    /// The path that was picked, with its number, as long as it is seen so.
    picked: Option<(u64, Vec<pick::Bounce>)>,
    /// The wish that is drawn now.
    current: Option<Current>,
    /// A picture that a device is drawing: one at a time, so that they do not pile up.
    on_its_way: Option<Box<OnItsWay>>,
}

/// A wish and how far it has come.
struct Current {
    wish: Arc<Wish>,
    /// Pictures that are still to be drawn: side and fineness, the next one last.
    left: Vec<(usize, Fineness)>,
    /// The finest pictures so far: without their bytes, which are copied for nobody, and textures.
    done: [Option<Box<Picture>>; 2],
    /// The sides of which the processor has drawn a draft while a device was not ready.
    has_draft: [bool; 2],
    /// Overlays that were made, or could not be.
    made: Vec<OverlayKind>,
}

/// The end of a turn of the studio: how things go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// There is more to do.
    More,
    /// There is nothing to do until something arrives.
    Idle,
    /// The mailbox was closed.
    Over,
}

impl Studio {
    /// A studio without a scene.
    pub fn new(mailbox: Arc<Mailbox>, tell: Tell, gpu: Option<Gpu>) -> Self {
        Self {
            mailbox,
            tell,
            gpu,
            bakes: Shelf::default(),
            stage: None,
            sides: Default::default(),
            overlay_maker: Default::default(),
            place_search: None,
            ready_methods: ReadyMethods::default(),
            picked: None,
            current: None,
            on_its_way: None,
        }
    }

    /// Works until the mailbox is closed.
    pub fn run(&mut self) {
        while self.turn(self.patience()) != Turn::Over {}
    }

    /// How long the next turn is to wait for something newer before it goes on: not at all for drafts, and for ever
    /// (`None`) if there is nothing to do.
    pub fn patience(&self) -> Option<Duration> {
        if self.on_its_way.is_some() {
            return Some(GLANCE);
        }
        let current = self.current.as_ref()?;
        match current.left.last() {
            _ if self.searches_next() => Some(Duration::ZERO),
            None => current.next_overlay().map(|_| Duration::ZERO),
            Some((_, Fineness::Draft)) => Some(Duration::ZERO),
            Some((_, Fineness::Whole { .. })) => Some(REST),
        }
    }

    /// Takes what has arrived, waiting for it as long as is given, else does the next piece of work.
    pub fn turn(&mut self, patience: Option<Duration>) -> Turn {
        match self.mailbox.take(patience) {
            Mail::Closed => return Turn::Over,
            Mail::Order(Order::Load { number, source, opening }) => self.load(number, &source, &opening),
            Mail::Order(Order::UseBake { path }) => self.use_bake(&path),
            Mail::Order(Order::Pick { number, position_px }) => self.pick(number, position_px),
            Mail::Wish(wish) => self.begin(wish),
            Mail::Nothing if self.searches_next() => self.search_places(),
            Mail::Nothing => self.work(),
        }
        match &self.current {
            Some(_) if self.place_search.is_some() => Turn::More,
            Some(current) if !current.left.is_empty() || current.next_overlay().is_some() => Turn::More,
            _ if self.on_its_way.is_some() => Turn::More,
            _ => Turn::Idle,
        }
    }

    fn load(&mut self, number: u64, source: &Source, opening: &Opening) {
        (self.tell)(News::Busy { stage: format!("loading {}", source.word()), share: None });
        match Stage::load(number, source, opening) {
            Ok((stage, summary)) => {
                // Before the window can wish for anything of it.
                self.sides.iter_mut().for_each(Side::clear);
                (self.overlay_maker, self.place_search) = (OverlayMaker::default(), None);
                (self.ready_methods, self.picked) = (ReadyMethods::default(), None);
                (self.stage, self.current, self.on_its_way) = (Some(stage), None, None);
                crate::memory::give_back();
                (self.tell)(News::Loaded(Box::new(summary)));
            }
            Err(error) => (self.tell)(News::NotLoaded { number, problem: error.to_string() }),
        }
        (self.tell)(News::Idle);
    }

    /// Opens a bake. What is shown is drawn again, with it where it fits.
    fn use_bake(&mut self, path: &Path) {
        (self.tell)(News::Busy { stage: format!("reading {}", path.display()), share: None });
        let text = match self.bakes.open(path) {
            Ok(file) => {
                let method = file.identity().method.clone();
                self.sides.iter_mut().for_each(Side::clear);
                (self.overlay_maker, self.on_its_way) = (OverlayMaker::default(), None);
                if let Some(current) = self.current.take() {
                    self.begin(current.wish);
                }
                format!("{}: a bake of {method}, used where it fits", path.display())
            }
            Err(problem) => problem.to_string(),
        };
        (self.tell)(News::Message { text });
        (self.tell)(News::Idle);
    }

    fn pick(&mut self, number: u64, position_px: [f32; 2]) {
        let mut path = Vec::new();
        self.place_search = None;
        if let (Some(stage), Some(Current { wish, .. })) = (&mut self.stage, &self.current)
            && let Ok(scene) = stage.scene_of(wish)
        {
            let view = scene.view(&wish.camera, wish.size[0], wish.size[1]);
            let order = wish.sides.iter().map(|side| side.quality.order).max().unwrap_or_default();
            path = pick::follow(&scene, &stage.tracer(&scene), &view, position_px, order);
            let settings = &stage.model.method_settings;
            self.place_search = PlaceSearch::new(number, wish, position_px, &path, settings);
        }
        self.picked = Some((number, path.clone()));
        (self.tell)(News::Picked { number, path });
    }

    /// True if the next thing to do is to find out where the picked point appears: drafts come before that.
    fn searches_next(&self) -> bool {
        let next = self.current.as_ref().and_then(|current| current.left.last());
        self.place_search.is_some() && !matches!(next, Some((_, Fineness::Draft)))
    }

    /// Asks the next method where the picked point appears.
    fn search_places(&mut self) {
        let (Some(search), Some(stage), Some(Current { wish, .. })) =
            (&mut self.place_search, &mut self.stage, &self.current)
        else {
            return;
        };
        let Ok(scene) = stage.scene_of(wish) else { return self.place_search = None };
        let tracer = stage.tracer(&scene);
        let searched = SearchedScene { scene: &scene, tracer: &tracer };
        let found = search.step(&searched, &mut self.ready_methods, &self.mailbox);
        if search.is_over() {
            self.place_search = None;
        }
        if let Some(places) = found {
            (self.tell)(News::Placed(Box::new(places)));
        }
    }

    /// Asks again where the picked point appears if only the picture's size or methods are others; from elsewhere it is
    /// another path.
    fn search_places_again(&mut self, wish: &Arc<Wish>) {
        self.place_search = None;
        let (Some((number, path)), Some(stage), Some(current)) = (&self.picked, &mut self.stage, &self.current) else {
            return;
        };
        let is_same_path = current.wish.sees_same(wish);
        let first = path.first().filter(|_| is_same_path).zip(stage.scene_of(wish).ok());
        let seen = first
            .and_then(|(first, scene)| scene.view(&wish.camera, wish.size[0], wish.size[1]).pixel_of(first.position));
        match seen {
            Some(px) => {
                let settings = &stage.model.method_settings;
                self.place_search = PlaceSearch::new(*number, wish, px.to_array(), path, settings);
            }
            None => self.picked = None,
        }
    }

    /// Begins with a wish. Wishes for other scenes than the one that is on are out of date.
    fn begin(&mut self, wish: Arc<Wish>) {
        let is_on = self.stage.as_ref().is_some_and(|stage| stage.number == wish.scene);
        if !is_on || wish.size.contains(&0) {
            return;
        }
        if let Some(current) = self.current.as_mut().filter(|current| current.wish.shows_same(&wish)) {
            // Something else is to be shown over the same pictures.
            current.made.retain(|kind| wish.overlays.contains(kind));
            current.wish = wish;
            return;
        }
        self.search_places_again(&wish);
        if self.current.as_ref().is_some_and(|current| current.has_light_of(&wish)) && self.on_its_way.is_none() {
            return self.display_again(wish);
        }
        // Coarse before fine, and left before right.
        let mut left: Vec<(usize, usize, Fineness)> = Vec::new();
        for (side, drawn) in wish.sides.iter().take(2).enumerate() {
            left.extend(drawing::steps(drawn).into_iter().enumerate().map(|(step, fineness)| (step, side, fineness)));
        }
        left.sort_by_key(|(step, side, _)| (*step, *side));
        let left = left.into_iter().rev().map(|(_, side, fineness)| (side, fineness)).collect();
        self.current = Some(Current { wish, left, done: [None, None], has_draft: [false; 2], made: Vec::new() });
    }

    /// Tells the pictures that are there in another exposure or tone, or compares them.
    fn display_again(&mut self, wish: Arc<Wish>) {
        let Some(current) = &mut self.current else { return };
        (current.wish, current.made) = (wish.clone(), Vec::new());
        for known in current.done.iter_mut().take(wish.sides.len()).flatten() {
            known.wish = wish.clone();
            let rgba = known.linear.as_ref().map(|linear| wish.display.of(linear).to_srgba8());
            let picture = Picture { rgba: rgba.unwrap_or_default(), ..(**known).clone() };
            (self.tell)(News::Drawn(Box::new(picture)));
        }
        self.finish();
    }

    /// Draws the next picture of the wish, or receives one.
    fn work(&mut self) {
        match self.on_its_way.take() {
            Some(on_its_way) if on_its_way.is_ready() => return self.receive(*on_its_way),
            Some(on_its_way) => {
                let side = on_its_way.plan.side;
                self.on_its_way = Some(on_its_way);
                return self.draw_meanwhile(side);
            }
            None => {}
        }
        let Some(current) = &mut self.current else { return };
        let Some((side, fineness)) = current.left.pop() else { return self.draw_overlay() };
        if fineness != Fineness::Draft && current.has(side, fineness) {
            return self.finish();
        }
        match self.draw(side, fineness) {
            Ok(Some(Outcome::Picture(picture))) => self.deliver(*picture),
            Ok(Some(Outcome::OnItsWay(on_its_way))) => self.on_its_way = Some(on_its_way),
            Ok(None) => {}
            // The newer thing that waits is begun in the next turn; if that changes nothing, this is done again.
            Err(RenderError::Cancelled(_)) => self.put_back(side, fineness),
            Err(error) => self.fail(side, error.to_string()),
        }
    }

    /// Draws a side of the wish; nothing where its scene cannot be.
    fn draw(&mut self, side: usize, fineness: Fineness) -> Result<Option<Outcome>, RenderError> {
        let (Some(stage), Some(Current { wish, .. })) = (&mut self.stage, &self.current) else { return Ok(None) };
        let scene = match stage.scene_of(wish) {
            Ok(scene) => scene,
            Err(error) => {
                self.fail(side, error.to_string());
                return Ok(None);
            }
        };
        let tools = Tools { mailbox: &self.mailbox, tell: &*self.tell, gpu: self.gpu.as_ref(), bakes: &self.bakes };
        self.sides[side].draw((wish, side), &scene, fineness, tools).map(Some)
    }

    /// Draws a draft by the processor, once a wish, while a device makes its first picture of a side.
    fn draw_meanwhile(&mut self, side: usize) {
        let (Some(stage), Some(current)) = (&mut self.stage, &mut self.current) else { return };
        // The wish may have fewer sides by now.
        if side >= current.wish.sides.len() || std::mem::replace(&mut current.has_draft[side], true) {
            return;
        }
        let tools = Tools { mailbox: &self.mailbox, tell: &*self.tell, gpu: None, bakes: &self.bakes };
        let scene = stage.scene_of(&current.wish);
        let drawn = scene.map(|scene| self.sides[side].draw_meanwhile((&current.wish, side), &scene, tools));
        // The device will tell what is wrong, if anything is.
        if let Ok(Ok(Some(picture))) = drawn {
            (self.tell)(News::Drawn(Box::new(picture)));
        }
    }

    /// Receives what a device has drawn.
    fn receive(&mut self, on_its_way: OnItsWay) {
        let (wish, side, fineness) = (on_its_way.plan.wish.clone(), on_its_way.plan.side, on_its_way.plan.fineness);
        match self.sides[side].receive(on_its_way) {
            Ok(picture) => self.deliver(picture),
            Err(error) => {
                // A device that has failed once is not asked again.
                self.gpu = None;
                self.sides.iter_mut().for_each(Side::clear);
                (self.tell)(News::Remark { text: format!("drawn by the CPU: {error}") });
                if self.is_current(&wish) {
                    self.put_back(side, fineness);
                }
            }
        }
    }

    /// True if pictures of a wish are those that are wanted now, even if other overlays are.
    fn is_current(&self, wish: &Wish) -> bool {
        self.current.as_ref().is_some_and(|current| current.wish.shows_same(wish))
    }

    /// Tells a picture.
    fn deliver(&mut self, mut picture: Picture) {
        let is_current = self.is_current(&picture.wish);
        if let Some(current) = self.current.as_mut().filter(|_| is_current) {
            let (rgba, texture) = (std::mem::take(&mut picture.rgba), picture.texture.take());
            current.done[picture.side] = Some(Box::new(picture.clone()));
            (picture.rgba, picture.texture) = (rgba, texture);
        }
        (self.tell)(News::Drawn(Box::new(picture)));
        self.finish();
    }

    /// Puts a picture that was given up back: it is the next one to be drawn.
    fn put_back(&mut self, side: usize, fineness: Fineness) {
        if let Some(current) = &mut self.current {
            current.left.push((side, fineness));
        }
    }

    /// Makes the next overlay of the left side.
    fn draw_overlay(&mut self) {
        let Some(current) = &mut self.current else { return };
        let Some(kind) = current.next_overlay() else { return };
        let wish = current.wish.clone();
        let tools = Tools { mailbox: &self.mailbox, tell: &*self.tell, gpu: self.gpu.as_ref(), bakes: &self.bakes };
        let made = match self.stage.as_mut().map(|stage| stage.scene_of(&wish)) {
            Some(Ok(scene)) => self.overlay_maker.draw(&mut self.sides[0], &wish, &scene, kind, tools),
            _ => return current.made.push(kind),
        };
        let (overlay, problem) = match made {
            // The newer thing that waits is begun in the next turn.
            Err(RenderError::Cancelled(_)) => return,
            Err(error) => (Overlay::new(kind, wish.size), Some(error.to_string())),
            Ok(overlay) => (overlay, None),
        };
        current.made.push(kind);
        (self.tell)(News::Overlaid(Box::new(Overlaid { wish, overlay, problem })));
        (self.tell)(News::Idle);
    }

    /// Gives a side of the wish up.
    fn fail(&mut self, side: usize, problem: String) {
        let Some(current) = &mut self.current else { return };
        current.left.retain(|(other, _)| *other != side);
        (self.tell)(News::NotDrawn { wish: current.wish.clone(), side, problem });
        self.finish();
    }

    /// Compares the sides and tells that nothing is left to do, if that is so.
    fn finish(&mut self) {
        let Some(current) = &self.current else { return };
        if !current.left.is_empty() {
            return;
        }
        let [left, right] = current.done.each_ref().map(|done| done.as_ref()?.linear.clone());
        if let (true, Some(left), Some(right)) = (current.wish.compares, left, right) {
            drawing::compare(&current.wish, [left, right], self.tell.clone());
        }
        (self.tell)(News::Idle);
    }
}

impl Current {
    /// True if all light that a wish wants to show is there.
    fn has_light_of(&self, wish: &Wish) -> bool {
        let has_light = |picture: &Option<Box<Picture>>| picture.as_ref().is_some_and(|known| known.linear.is_some());
        let sides = &self.done[..wish.sides.len().min(2)];
        self.left.is_empty() && self.wish.draws_same(wish) && sides.iter().all(has_light)
    }

    /// The next overlay to be made, of a left side that was drawn.
    fn next_overlay(&self) -> Option<OverlayKind> {
        let wanted = || self.wish.overlays.iter().copied();
        wanted().find(|kind| !self.made.contains(kind)).filter(|_| self.done[0].is_some())
    }

    /// True if the side's picture is as fine already.
    fn has(&self, side: usize, fineness: Fineness) -> bool {
        let Fineness::Whole { samples } = fineness else { return false };
        self.done[side].as_ref().is_some_and(|done| done.size == self.wish.size && done.samples >= samples)
    }
}
