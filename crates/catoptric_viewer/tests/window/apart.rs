//! The studio with a device of its own, which nothing waits for: as it works in browsers.

use crate::session::{SCENE, expected, scene};
use catoptric::methods::Quality;
use catoptric_gpu::Context;
use catoptric_viewer::studio::news::{News, Picture};
use catoptric_viewer::studio::order::{Changes, Drawn, Order, Source, Wish};
use catoptric_viewer::studio::{Gpu, Mailbox, Studio, Turn};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

struct Bench {
    studio: Studio,
    mailbox: Arc<Mailbox>,
    news: Receiver<News>,
}

impl Bench {
    /// With a scene on the machine's device.
    fn new() -> Self {
        let (sender, news) = channel();
        let sender = Mutex::new(sender);
        let mailbox = Arc::new(Mailbox::default());
        let tell = Arc::new(move |news| sender.lock().unwrap().send(news).unwrap());
        let studio = Studio::new(mailbox.clone(), tell, Some(Gpu::apart(Context::new(None).unwrap())));
        let mut bench = Self { studio, mailbox, news };
        bench.mailbox.send(Order::Load {
            number: 1,
            source: Source::Builtin(SCENE.into()),
            opening: Default::default(),
        });
        bench.turn();
        bench
    }

    fn turn(&mut self) -> Turn {
        self.studio.turn(Some(Duration::ZERO))
    }

    /// The pictures until nothing is left to do, with a pause for the device between turns.
    fn pictures(&mut self) -> Vec<Picture> {
        let mut pictures = Vec::new();
        loop {
            let turn = self.turn();
            pictures.extend(self.news.try_iter().filter_map(|news| match news {
                News::Drawn(picture) => Some(*picture),
                News::NotDrawn { problem, .. } => panic!("{problem}"),
                News::Remark { text } => panic!("{text}"),
                _ => None,
            }));
            if turn == Turn::Idle {
                return pictures;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

fn wish(methods: &[&str], eye_up: f32) -> Wish {
    let quality = Quality { samples: 4, order: 2 };
    let drawn = |method: &&str| Drawn { method: (*method).into(), settings: toml::Table::new(), quality };
    let mut camera = scene(SCENE).cameras[0].clone();
    camera.world_from_camera.translation.y += eye_up;
    let sides = methods.iter().map(drawn).collect();
    // Rows that do not fill what devices copy.
    let (changes, overlays) = (Changes::default(), Vec::new());
    Wish {
        scene: 1,
        time: 0.0,
        clip: None,
        changes,
        camera,
        size: [97, 64],
        sides,
        has_automatic_order: false,
        display: Default::default(),
        compares: false,
        overlays,
    }
}

/// The share of a picture's pixels that are off by more than 0.1 from the library's on the processor.
fn off(picture: &Picture) -> f64 {
    let expected = expected(&scene(SCENE), &picture.wish, picture.side);
    crate::session::share_off(&picture.rgba, &expected.to_srgba8(), 4)
}

/// Pictures come from the device, drafts before whole ones; while it is busy another wish is not kept waiting.
pub(crate) fn draws_without_waiting() {
    let mut bench = Bench::new();
    bench.mailbox.wish(Arc::new(wish(&["multiperspective", "reference"], 0.0)));
    let pictures = bench.pictures();
    let by_device: Vec<&Picture> = pictures.iter().filter(|picture| picture.processor != "CPU").collect();
    assert_eq!(
        by_device.iter().map(|picture| (picture.side, picture.is_whole)).collect::<Vec<_>>(),
        [(0, false), (0, true)]
    );
    assert!(by_device.iter().all(|picture| picture.texture.is_none() && !picture.rgba.is_empty()));
    let whole = by_device[1];
    assert!(whole.linear.is_some() && off(whole) < 0.005, "{}", off(whole));
    assert!(whole.report.counts["tiles"] > 0, "what tiles did is counted");
    // The processor draws methods that devices do not.
    assert!(pictures.iter().any(|picture| picture.side == 1 && picture.samples == 16 && picture.is_whole));
    // Before its first picture the device makes programs of the shaders: until then the processor draws.
    let first_of_device = pictures.iter().position(|picture| picture.processor != "CPU").unwrap();
    let drafts = &pictures[..first_of_device];
    assert!(drafts.iter().all(|picture| picture.side == 0 && !picture.is_whole) && drafts.len() <= 1);
    // A wish that comes while the device draws for another one.
    bench.mailbox.wish(Arc::new(wish(&["multiperspective"], 0.0)));
    assert_eq!((bench.turn(), bench.turn()), (Turn::More, Turn::More));
    let next = wish(&["multiperspective"], 0.2);
    bench.mailbox.wish(Arc::new(next.clone()));
    let pictures = bench.pictures();
    let last = pictures.last().unwrap();
    assert!(*last.wish == next && last.is_whole && off(last) < 0.005, "{}", off(last));
    // A draft that was begun for the wish before is shown, too; nothing else of it is drawn.
    assert!(pictures.iter().filter(|picture| *picture.wish != next).count() <= 1);
    // Another scene: what is on its way is of no use.
    bench.mailbox.wish(Arc::new(wish(&["environment_map"], 0.0)));
    bench.turn();
    bench.turn();
    bench.mailbox.send(Order::Load {
        number: 2,
        source: Source::Builtin("planar_mirror".into()),
        opening: Default::default(),
    });
    assert!(bench.pictures().is_empty());
}
