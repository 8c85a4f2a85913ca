//! The studio turn by turn, without a thread and without a window.

use super::news::{Compared, News, Picture, SceneSummary};
use super::order::{Beside, Changes, Drawn, Opening, Order, RoleChange, Source, Wish};
use super::*;
use catoptric::framebuffer::Framebuffer;
use catoptric::methods::overlay::{Overlay, OverlayKind};
use catoptric::methods::{self, Quality};
use catoptric::progress::Silent;
use catoptric::scene::{Camera, PoseOptions, Role, Scene};
use catoptric::tone::{Display, ToneCurve};
use catoptric_scenes::builtin;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, channel};

const SCENE: &str = "sphere_room?tess=16";

struct Bench {
    studio: Studio,
    mailbox: Arc<Mailbox>,
    news: Receiver<News>,
}

impl Bench {
    fn new() -> Self {
        let (sender, news) = channel();
        let sender = Mutex::new(sender);
        let mailbox = Arc::new(Mailbox::default());
        let tell = Arc::new(move |news| sender.lock().unwrap().send(news).unwrap());
        Self { studio: Studio::new(mailbox.clone(), tell, None), mailbox, news }
    }

    /// One with a scene.
    fn with_scene() -> (Self, SceneSummary) {
        let mut bench = Self::new();
        bench.mailbox.send(Order::Load {
            number: 1,
            source: Source::Builtin(SCENE.into()),
            opening: Default::default(),
        });
        bench.turn();
        let summary = bench.all().into_iter().find_map(|news| match news {
            News::Loaded(summary) => Some(*summary),
            _ => None,
        });
        (bench, summary.unwrap())
    }

    fn turn(&mut self) -> Turn {
        self.studio.turn(Some(Duration::ZERO))
    }

    /// Turns until nothing is left to do.
    fn run(&mut self) {
        for _ in 0..100 {
            if self.turn() == Turn::Idle && self.turn() == Turn::Idle {
                return;
            }
        }
        panic!("it never rests");
    }

    fn all(&self) -> Vec<News> {
        self.news.try_iter().collect()
    }

    fn pictures(&self) -> Vec<Picture> {
        let picture = |news| match news {
            News::Drawn(picture) => Some(*picture),
            _ => None,
        };
        self.all().into_iter().filter_map(picture).collect()
    }
}

fn drawn(method: &str) -> Drawn {
    Drawn { method: method.into(), settings: toml::Table::new(), quality: Quality { samples: 4, order: 2 } }
}

fn wish(camera: &Camera, methods: &[&str]) -> Wish {
    let sides = methods.iter().copied().map(drawn).collect();
    let (camera, changes) = (camera.clone(), Changes::default());
    let (size, overlays) = ([96, 64], Vec::new());
    Wish {
        scene: 1,
        time: 0.0,
        clip: None,
        changes,
        camera,
        size,
        sides,
        has_automatic_order: false,
        display: Default::default(),
        compares: false,
        overlays,
    }
}

/// The scene with its shadows.
fn lit(options: &PoseOptions) -> Scene {
    let mut scene = builtin::parse(SCENE).unwrap().pose(options).unwrap();
    catoptric::light::visibility::cast_shadows(&mut scene);
    catoptric::light::visibility::shadow_sky(&mut scene, catoptric::light::visibility::DIFFUSE_BOUNCES, &Silent)
        .unwrap();
    scene
}

/// The same picture by the library alone.
fn expected(wish: &Wish, side: usize, samples: u32, options: &PoseOptions) -> Framebuffer {
    let scene = Arc::new(lit(options));
    let quality = Quality { samples, ..wish.sides[side].quality };
    let method = methods::create(&wish.sides[side].method, &wish.sides[side].settings).unwrap();
    let mut prepared = method.prepare(&scene, quality, None, &Silent).unwrap();
    let mut picture = Framebuffer::new(wish.size[0], wish.size[1]);
    let view = scene.view(&wish.camera, wish.size[0], wish.size[1]);
    prepared.frame(&view, &Silent).unwrap().draw(&mut picture, &Silent).unwrap();
    picture
}

#[test]
fn drafts_come_first_and_whole_pictures_are_the_librarys() {
    let (mut bench, summary) = Bench::with_scene();
    let wish = wish(&summary.cameras[0], &["auto", "reference"]);
    bench.mailbox.wish(Arc::new(wish.clone()));
    bench.run();
    let pictures = bench.pictures();
    let order: Vec<(usize, u32, bool)> =
        pictures.iter().map(|picture| (picture.side, picture.samples, picture.size[0] < 96)).collect();
    assert_eq!(order, [(0, 1, true), (1, 1, true), (0, 4, false), (1, 1, false), (1, 4, false), (1, 16, false)]);
    let options = PoseOptions::default();
    assert_eq!(**pictures[2].linear.as_ref().unwrap(), expected(&wish, 0, 4, &options));
    assert_eq!(**pictures[5].linear.as_ref().unwrap(), expected(&wish, 1, 16, &options));
    assert!(pictures[2].is_whole && pictures[5].is_whole && !pictures[0].is_whole && !pictures[3].is_whole);
}

/// Another exposure shows the light that is there, and draws nothing.
#[test]
fn another_exposure_draws_nothing_anew() {
    let (mut bench, summary) = Bench::with_scene();
    assert_eq!(summary.display, Display::default(), "the room is bright enough as it is");
    let first = wish(&summary.cameras[0], &["auto"]);
    bench.mailbox.wish(Arc::new(first.clone()));
    bench.run();
    let linear = bench.pictures().pop().unwrap().linear.unwrap();
    let display = Display { exposure_stops: -2.0, curve: ToneCurve::Aces };
    bench.mailbox.wish(Arc::new(Wish { display, ..first }));
    bench.run();
    let pictures = bench.pictures();
    assert_eq!(pictures.len(), 1, "drawn again");
    assert_eq!(pictures[0].wish.display, display);
    assert_eq!(pictures[0].rgba, display.of(&linear).to_srgba8());
}

#[test]
fn a_moving_eye_ends_what_sharpens_and_keeps_what_is_prepared() {
    let (mut bench, summary) = Bench::with_scene();
    let first = wish(&summary.cameras[0], &["auto"]);
    let mut second = first.clone();
    second.camera.world_from_camera.translation.x += 0.1;
    bench.mailbox.wish(Arc::new(first.clone()));
    // The wish, then its draft.
    assert_eq!((bench.turn(), bench.turn()), (Turn::More, Turn::More));
    bench.mailbox.wish(Arc::new(second.clone()));
    bench.run();
    let pictures = bench.pictures();
    assert_eq!(pictures.len(), 3);
    assert!(*pictures[0].wish == first && pictures[1..].iter().all(|picture| *picture.wish == second));
    // Prepared once: later frames have no stages of preparation.
    let stages = |picture: &Picture| picture.report.stages_ms.len();
    assert!(stages(&pictures[1]) < stages(&pictures[0]), "{:?}", pictures[1].report.stages_ms);
    assert_eq!(**pictures[2].linear.as_ref().unwrap(), expected(&second, 0, 4, &PoseOptions::default()));
}

#[test]
fn roles_change_what_is_drawn() {
    let (mut bench, summary) = Bench::with_scene();
    let mirror = summary.objects.iter().find(|object| object.role == Role::Reflector).unwrap();
    let mut wish = wish(&summary.cameras[0], &["auto"]);
    wish.changes.roles.push(RoleChange { name: mirror.name.clone(), role: Role::Lens, ior: Some(1.4) });
    bench.mailbox.wish(Arc::new(wish.clone()));
    bench.run();
    wish.changes.moves.insert(mirror.name.clone(), glam::Vec3::new(0.2, 0.1, 0.0));
    bench.mailbox.wish(Arc::new(wish.clone()));
    bench.run();
    let options = wish.changes.pose_at(0.0).unwrap();
    assert_eq!(*bench.pictures().pop().unwrap().linear.unwrap(), expected(&wish, 0, 4, &options));
}

#[test]
fn overlays_are_made_at_rest_and_pictures_stay() {
    let (mut bench, summary) = Bench::with_scene();
    let mut wanted = wish(&summary.cameras[0], &["auto"]);
    bench.mailbox.wish(Arc::new(wanted.clone()));
    bench.run();
    assert_eq!(bench.pictures().len(), 2);
    let overlaid = |bench: &Bench| -> Vec<Overlay> {
        let all = bench.all();
        assert!(!all.iter().any(|news| matches!(news, News::Drawn(_))), "a picture was drawn again");
        all.into_iter()
            .filter_map(|news| match news {
                News::Overlaid(overlaid) => Some(overlaid.overlay),
                _ => None,
            })
            .collect()
    };
    wanted.overlays = vec![OverlayKind::Tiles];
    bench.mailbox.wish(Arc::new(wanted.clone()));
    bench.run();
    let tiles = overlaid(&bench);
    // Overlays that are there are not made again.
    wanted.overlays = vec![OverlayKind::Paths, OverlayKind::Tiles, OverlayKind::Layers];
    bench.mailbox.wish(Arc::new(wanted.clone()));
    bench.run();
    let others = overlaid(&bench);
    let scene = Arc::new(lit(&PoseOptions::default()));
    let mut prepared = methods::create("auto", &toml::Table::new())
        .unwrap()
        .prepare(&scene, wanted.sides[0].quality, None, &Silent)
        .unwrap();
    let frame = prepared.frame(&scene.view(&wanted.camera, 96, 64), &Silent).unwrap();
    assert_eq!(tiles, [frame.overlay(OverlayKind::Tiles, &Silent).unwrap().unwrap()]);
    let paths = frame.overlay(OverlayKind::Paths, &Silent).unwrap().unwrap();
    assert_eq!(others, [paths, Overlay::new(OverlayKind::Layers, [96, 64])]);
    // Another eye is drawn first.
    wanted.camera.world_from_camera.translation.x += 0.1;
    bench.mailbox.wish(Arc::new(wanted));
    bench.run();
    let order: Vec<char> = bench
        .all()
        .iter()
        .filter_map(|news| match news {
            News::Drawn(_) => Some('d'),
            News::Overlaid(_) => Some('o'),
            _ => None,
        })
        .collect();
    assert_eq!(order, ['d', 'd', 'o', 'o', 'o']);
}

#[test]
fn what_cannot_be_loaded_or_drawn_is_told_in_words() {
    let (mut bench, summary) = Bench::with_scene();
    let broken = Source::Bytes { name: "broken.glb".into(), bytes: vec![1, 2, 3].into(), beside: Beside::default() };
    bench.mailbox.send(Order::Load { number: 2, source: broken, opening: Default::default() });
    bench.turn();
    let told = bench.all();
    let problem = told.iter().find_map(|news| match news {
        News::NotLoaded { number: 2, problem } => Some(problem),
        _ => None,
    });
    assert!(problem.unwrap().contains("broken.glb"), "{problem:?}");
    // The scene before is still on.
    let mut wrong = wish(&summary.cameras[0], &["auto", "environment_map"]);
    wrong.sides[1].settings.insert("parallax".into(), "cone".into());
    bench.mailbox.wish(Arc::new(wrong));
    bench.run();
    let told = bench.all();
    let not_drawn = |news: &News| matches!(news, News::NotDrawn { side: 1, problem, .. } if problem.contains("cone"));
    assert_eq!(told.iter().filter(|news| not_drawn(news)).count(), 1);
    assert!(told.iter().any(|news| matches!(news, News::Drawn(picture) if picture.is_whole)));
    // Wishes for scenes that are not on are not drawn.
    let late = Wish { scene: 7, ..wish(&summary.cameras[0], &["auto"]) };
    bench.mailbox.wish(Arc::new(late));
    bench.run();
    assert!(bench.all().is_empty());
}

#[test]
fn sides_are_compared_and_pixels_are_picked() {
    let (mut bench, summary) = Bench::with_scene();
    let mut both = wish(&summary.cameras[0], &["reference", "reference"]);
    both.compares = true;
    bench.mailbox.wish(Arc::new(both.clone()));
    bench.run();
    let compared = |bench: &Bench| -> Compared {
        loop {
            if let News::Compared(compared) = bench.news.recv_timeout(Duration::from_secs(60)).unwrap() {
                return *compared;
            }
        }
    };
    assert_eq!(compared(&bench).flip_mean, 0.0);
    both.sides[0] = drawn("environment_map");
    bench.mailbox.wish(Arc::new(both));
    bench.run();
    let error = compared(&bench);
    assert!(error.flip_mean > 0.01 && error.over_0_1 > 0.01 && error.size == [96, 64], "{}", error.flip_mean);
    bench.mailbox.send(Order::Pick { number: 5, position_px: [48.0, 32.0] });
    bench.run();
    let told = bench.all();
    // Then where its end appears by other methods, one after the other.
    let last = told.iter().rev().find_map(|news| match news {
        News::Placed(places) => Some(places.clone()),
        _ => None,
    });
    let last = last.unwrap();
    assert!(last.number == 5 && last.is_done && last.is_solved && last.list.len() >= 4, "{last:?}");
    // In a picture of another size it is asked again, and from another place not.
    let mut other = (*last.wish).clone();
    let (wish_before, truth) = (last.wish.clone(), last.truth_px);
    other.size = [192, 128];
    bench.mailbox.wish(Arc::new(other.clone()));
    bench.run();
    let again = bench.all().into_iter().rev().find_map(|news| match news {
        News::Placed(places) => Some(places),
        _ => None,
    });
    let again = again.unwrap();
    assert!(again.is_done && again.wish.sees_same(&wish_before) && again.wish.size == [192, 128]);
    let off = glam::Vec2::from(again.truth_px).distance(2.0 * glam::Vec2::from(truth));
    assert!(off < 0.01, "{off}");
    other.camera.world_from_camera.translation.x += 0.1;
    bench.mailbox.wish(Arc::new(other));
    bench.run();
    assert!(!bench.all().iter().any(|news| matches!(news, News::Placed(_))));
    let path = told.into_iter().find_map(|news| match news {
        News::Picked { number: 5, path } => Some(path),
        _ => None,
    });
    let path = path.unwrap();
    assert!(path.len() == 2 && path[0].kind.is_some() && path[1].kind.is_none(), "{path:?}");
}

#[test]
fn what_goes_over_the_wire_arrives() {
    let (mut bench, summary) = Bench::with_scene();
    let mut sent = wish(&summary.cameras[0], &["auto", "environment_map"]);
    sent.sides[1].settings = toml::from_str("parallax = 'box'\nsize = 64").unwrap();
    sent.changes.roles.push(RoleChange { name: "sphere".into(), role: Role::Lens, ior: Some(1.4) });
    sent.changes.looks.insert("floor".into(), catoptric::scene::edits::Look { ior: Some(2.0), ..Default::default() });
    sent.changes.moves.insert("sphere".into(), glam::Vec3::new(0.1, 0.2, 0.3));
    sent.compares = true;
    sent.display = Display { exposure_stops: 1.5, curve: ToneCurve::Agx };
    sent.overlays = vec![OverlayKind::Paths, OverlayKind::VirtualTriangles, OverlayKind::Tiles];
    let message = wire::request(&wire::Request::Wish(Arc::new(sent.clone()))).unwrap();
    match wire::read_request(message).unwrap() {
        wire::Request::Wish(read) => assert_eq!(*read, sent),
        other => panic!("{other:?}"),
    }
    let named = [("a.bin".to_owned(), vec![4, 5]), ("b.png".to_owned(), vec![6])];
    let with_others = Beside(Arc::new(named.into()));
    let source = Source::Bytes { name: "a.glb".into(), bytes: vec![1, 2, 3].into(), beside: with_others.clone() };
    let roles = vec![RoleChange { name: "B*".into(), role: Role::Lens, ior: Some(1.4) }];
    let opened = Opening { environment: Some("sky".into()), lacks_shadows: true, roles, ..Opening::default() };
    let load = Order::Load { number: 3, source, opening: opened.clone() };
    match wire::read_request(wire::request(&wire::Request::Order(load)).unwrap()).unwrap() {
        wire::Request::Order(Order::Load { number: 3, source: Source::Bytes { name, bytes, beside }, opening }) => {
            assert_eq!(opening, opened);
            assert_eq!((name.as_str(), &*bytes, beside), ("a.glb", &[1, 2, 3][..], with_others));
        }
        other => panic!("{other:?}"),
    }
    // All news of a wish, as they are printed; linear colours of what is not whole stay behind.
    bench.mailbox.wish(Arc::new(sent));
    bench.run();
    bench.mailbox.send(Order::Pick { number: 5, position_px: [48.0, 32.0] });
    bench.run();
    let mut all = bench.all();
    while !all.iter().any(|news| matches!(news, News::Compared(_))) {
        all.push(bench.news.recv_timeout(Duration::from_secs(60)).unwrap());
    }
    all.push(News::Loaded(Box::new(summary)));
    for mut news in all {
        if let News::Drawn(picture) = &mut news {
            let linear = picture.linear.take().filter(|_| picture.is_whole);
            // The samples of pixels at edges stay behind, too.
            let pixels = |linear: Arc<Framebuffer>| {
                Arc::new(Framebuffer::of_pixels(linear.width, linear.height, linear.pixels.clone()))
            };
            picture.linear = linear.map(pixels);
            (picture.report.bytes, picture.report.choices) = (Default::default(), Vec::new());
            (picture.report.error_px, picture.report.noise) = (None, None);
        }
        let printed = format!("{news:?}");
        let arrived = format!("{:?}", wire::read_news(wire::news(news).unwrap()).unwrap());
        assert!(arrived == printed, "{}", printed.chars().take(200).collect::<String>());
    }
    let short = wire::Message { text: "{\"Nothing\":1}".into(), bytes: Vec::new() };
    assert!(wire::read_news(short).is_err());
}

/// A scene that names another file, both from memory; a file that is missing is named.
#[test]
fn files_that_come_together_find_each_other() {
    use super::order::scene_of;
    assert_eq!(scene_of(["a.bin", "A.GLTF", "a.png"]), Some(1));
    assert_eq!(scene_of(["b.glb", "b.toml"]), Some(1));
    assert_eq!(scene_of([]), None);
    let object = "mtllib ball.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let materials = b"newmtl red\nKd 1 0 0\n".to_vec();
    let load = |beside: Beside| {
        let mut bench = Bench::new();
        let source = Source::Bytes { name: "ball.obj".into(), bytes: object.as_bytes().into(), beside };
        bench.mailbox.send(Order::Load { number: 1, source, opening: Default::default() });
        bench.turn();
        bench.all()
    };
    let told = |all: &[News], word: &str| all.iter().any(|news| format!("{news:?}").contains(word));
    let alone = load(Beside::default());
    assert!(told(&alone, "open it together with the scene") && told(&alone, "ball.mtl"), "{alone:?}");
    let together = load(Beside(Arc::new([("ball.mtl".to_owned(), materials)].into())));
    assert!(told(&together, "Loaded") && !told(&together, "together"), "{together:?}");
}
