//! Cancelled work: every step of every method stops when its progress asks for that, and leaves what was prepared as it
//! was.

use catoptric::error::RenderError;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::{self, MethodInfo, Prepared, Quality};
use catoptric::progress::{Cancelled, Progress, Silent};
use catoptric::scene::{Scene, View};
use catoptric_testkit::drawing::scene;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

const QUALITY: Quality = Quality { samples: 1, order: 1 };

/// Small tables: enough to have every stage.
const SETTINGS: [(&str, &str); 3] = [
    ("environment_map", "size = 16"),
    ("light_field", "st = 2\nuv = 8\ntransfer = 'stored'\ntransfer_st = 2\ntransfer_uv = 4"),
    ("layered_environment_map", "size = 16\ntextures = 'inferred'\npicture_size = 32"),
];

/// Progress that cancels from its `limit`-th report on.
struct CancelAt {
    reports: AtomicU64,
    limit: u64,
}

impl CancelAt {
    fn new(limit: u64) -> Self {
        Self { reports: AtomicU64::new(0), limit }
    }
}

impl Progress for CancelAt {
    fn at(&self, _stage: &str, _done: u64, _of: u64) -> Result<(), Cancelled> {
        match self.reports.fetch_add(1, Ordering::Relaxed) < self.limit {
            true => Ok(()),
            false => Err(Cancelled),
        }
    }
}

fn prepare(info: &MethodInfo, scene: &Arc<Scene>, progress: &dyn Progress) -> Result<Box<dyn Prepared>, RenderError> {
    let settings = SETTINGS.iter().find(|(id, _)| *id == info.id).map_or("", |(_, settings)| settings);
    let table = toml::from_str(settings).expect("the test's settings are valid");
    methods::create(info.id, &table)?.prepare(scene, QUALITY, None, progress)
}

fn draw(prepared: &mut dyn Prepared, view: &View, progress: &dyn Progress) -> Result<Framebuffer, RenderError> {
    let mut picture = Framebuffer::new(view.width, view.height);
    prepared.frame(view, progress)?.draw(&mut picture, progress)?;
    Ok(picture)
}

/// The number of reports of a piece of work that nobody cancels.
fn reports_of<R>(work: impl FnOnce(&dyn Progress) -> R) -> u64 {
    let counting = CancelAt::new(u64::MAX);
    work(&counting);
    counting.reports.into_inner()
}

/// The first, the last and some reports between.
fn moments(reports: u64) -> impl Iterator<Item = u64> {
    (0..4).map(move |part| part * reports.saturating_sub(1) / 3)
}

fn is_cancelled<T>(result: &Result<T, RenderError>) -> bool {
    matches!(result, Err(RenderError::Cancelled(_)))
}

#[test]
fn every_step_can_be_cancelled_and_leaves_what_was_prepared() {
    let first = Arc::new(scene("sphere_room?tess=8&blend=none"));
    let second = Arc::new(scene("two_spheres?tess=8"));
    let view = first.default_view(32, 24);
    for info in methods::all() {
        let id = info.id;
        let reports = reports_of(|progress| prepare(info, &first, progress).map(|_| ()).expect("it is drawn"));
        for limit in moments(reports).filter(|limit| *limit < reports) {
            assert!(is_cancelled(&prepare(info, &first, &CancelAt::new(limit))), "{id}: preparing, {limit}");
        }
        let mut prepared = prepare(info, &first, &Silent).expect("it is drawn");
        let expected = draw(prepared.as_mut(), &view, &Silent).expect("it is drawn");

        // A frame that is cancelled anywhere is drawn the next time, from a view that nothing is kept of.
        let fresh = || prepare(info, &first, &Silent).expect("it is drawn");
        let reports = reports_of(|progress| draw(fresh().as_mut(), &view, progress).expect("it is drawn"));
        assert!(reports > 0, "{id}: a frame reports no progress");
        for limit in moments(reports) {
            let mut prepared = fresh();
            assert!(is_cancelled(&draw(prepared.as_mut(), &view, &CancelAt::new(limit))), "{id}: drawing, {limit}");
            assert!(draw(prepared.as_mut(), &view, &Silent).expect("it is drawn") == expected, "{id}: {limit}");
        }

        // An update that is cancelled leaves the earlier scene.
        let update = |prepared: &mut dyn Prepared, progress: &dyn Progress| prepared.update(&second, QUALITY, progress);
        let reports = reports_of(|progress| update(fresh().as_mut(), progress).expect("it is drawn"));
        for limit in moments(reports).filter(|limit| *limit < reports) {
            let mut prepared = fresh();
            assert!(is_cancelled(&update(prepared.as_mut(), &CancelAt::new(limit))), "{id}: updating, {limit}");
            assert!(draw(prepared.as_mut(), &view, &Silent).expect("it is drawn") == expected, "{id}: {limit}");
        }
    }
}
