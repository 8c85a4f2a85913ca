//! Figures and tables of layered environment maps, in `builtin:colonnade`: a glass pot and a mirror cup in a ring of
//! columns.

use crate::commands::{self, Line, settings_of};
use crate::panels::{below, beside_of_width, save_small};
use crate::repository::root;
use crate::stage::{self, median, print, rgb, timed};
use anyhow::{Context, Result, bail};
use catoptric::framebuffer::Framebuffer;
use catoptric::light::path_tracer::specular_mask;
use catoptric::methods::lookup::layered_environment_map::{
    InferredLayer, LayeredEnvironmentMapSettings, Textures, inferred_layers, subdivision,
};
use catoptric::methods::{Job, Quality, Report};
use catoptric::progress::Silent;
use catoptric::scene::{Camera, PoseOptions, Scene, View};
use catoptric_scenes::builtin;
use catoptric_testkit::{Drawn, Session};
use glam::{Quat, Vec3};
use image::RgbImage;

const SCENE: &str = "colonnade";

/// Enough events for glass behind glass.
const QUALITY: Quality = Quality { samples: 8, order: 6 };

const TRUTH: (&str, &str) = ("reference", "paths = \"two_path\"");

/// The reference for methods without the paper's model of two paths.
const TREE: (&str, &str) = ("reference", "");

/// The settings of the paper's sizes.
const INFERRED: &str = "textures = \"inferred\"";

/// The method of this page, and its settings in the figures.
const LAYERED: &str = "layered_environment_map";
const ONE: &str = "textures = \"inferred\"\ndepth = false\nlayers = 1";
const SHELLS: &str = "textures = \"inferred\"\ndepth = false";
const BARE: &str = "textures = \"inferred\"\ndepth = false\ncontinued = false\nneighbours = 0\ndirect = \"none\"";
const SLOW: &str = "textures = \"inferred\"\ntau = 3";
const FAST: &str = "textures = \"inferred\"\ntau = 5";

/// A figure of pictures in a row: its name, how far the eye is turned about the pot (in degrees) and lifted, and the
/// methods with their settings.
type Pictures = (&'static str, f32, f32, &'static [(&'static str, &'static str)]);

const ROWS: [Pictures; 5] = [
    ("layered-2", 0.0, 0.0, &[("reference", ""), TRUTH]),
    ("layered-8a", 4.0, 0.0, &[TRUTH, (LAYERED, INFERRED), (LAYERED, SHELLS), (LAYERED, ONE)]),
    ("layered-8b", 4.0, 0.8, &[TRUTH, (LAYERED, INFERRED), (LAYERED, SHELLS), (LAYERED, ONE)]),
    ("layered-9", 4.0, 0.0, &[TRUTH, (LAYERED, SHELLS), (LAYERED, BARE)]),
    ("layered-10", 4.0, 0.0, &[TRUTH, (LAYERED, SLOW), (LAYERED, FAST)]),
];

/// The number of frames of a median.
const FRAMES: usize = 5;

fn posed() -> Result<Scene> {
    Ok(builtin::parse(SCENE)?.pose(&PoseOptions::default())?)
}

/// The first camera, turned about the pot and lifted.
fn view(scene: &Scene, [width, height]: [u32; 2], turn_deg: f32, lift: f32) -> Result<View> {
    let first = scene.camera(None, 1.0)?;
    let pot = scene.specular_objects().into_iter().map(|object| &scene.objects[object as usize]);
    let center = pot.clone().find(|object| object.name == "pot").context("the scene has a pot")?.bounds.center();
    let arm = Vec3::from(first.world_from_camera.translation) - center;
    let eye = center + Quat::from_rotation_y(turn_deg.to_radians()) * arm + Vec3::Y * lift;
    Ok(scene.view(&Camera::look_at("", eye, center, Vec3::Y, 30.0), width, height))
}

/// The line of a picture from a place about the pot.
fn line(scene: &Scene, size: [u32; 2], (turn_deg, lift): (f32, f32), (id, settings): (&str, &str)) -> Result<Line> {
    let view = view(scene, size, turn_deg, lift)?;
    let settings = settings_of(settings);
    let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
    let Quality { samples, order } = QUALITY;
    let mut line = commands::Shot { scene: "builtin:colonnade", size, samples, order }.drawn(id, &settings);
    let words = |place: Vec3| place.to_array().map(|along| format!("{along:.4}")).join(",");
    let ahead = view.eye() - Vec3::from(view.world_from_view.matrix3.z_axis);
    line.add(&["--eye", &words(view.eye()), "--target", &words(ahead), "--fov", "30"]);
    Ok(line)
}

/// The lines of the table's first column and of the figures with rows of pictures.
pub(crate) fn commands() -> Result<Vec<commands::Figure>> {
    let (page, scene) = ("figures-layered-environment-map.md", &posed()?);
    let table = ways_of_table();
    let ways = table.iter().map(|(_, id, settings)| line(scene, TABLE_SIZE, (0.0, 0.0), (id, settings)));
    let ways = ways.collect::<Result<_>>()?;
    let mut all = vec![commands::Figure { page, name: "layered-table".into(), lines: ways }];
    for (name, turn, lift, ways) in ROWS {
        let lines = ways.iter().map(|way| line(scene, TABLE_SIZE, (turn, lift), *way)).collect::<Result<_>>()?;
        all.push(commands::Figure { page, name: name.into(), lines });
    }
    Ok(all)
}

fn draw_with(scene: &Scene, view: &View, way: (&str, &str)) -> Result<Drawn> {
    draw_at(scene, view, QUALITY, way)
}

fn draw_at(scene: &Scene, view: &View, quality: Quality, (id, settings): (&str, &str)) -> Result<Drawn> {
    Ok(Session::new(id, settings, scene, quality)?.draw(view)?)
}

/// FLIP over the pot and the cup.
fn flip(scene: &Scene, view: &View, found: &Framebuffer, truth: &Framebuffer) -> Result<f64> {
    stage::flip(found, truth, &specular_mask(scene, view))
}

/// The size of pictures in rows, and of the table's.
const TABLE_SIZE: [u32; 2] = [480, 360];

/// The rows of the table of errors: a name, a method, its settings.
fn ways_of_table() -> [(&'static str, &'static str, String); 18] {
    let layered = LAYERED;
    let set = |settings: &str| format!("{INFERRED}\n{settings}");
    let bare = "depth = false";
    let large = "size = 512\npicture_size = 512";
    [
        ("environment map", "environment_map", String::new()),
        ("environment map, box", "environment_map", "parallax = \"box\"".into()),
        ("light field", "light_field", String::new()),
        ("layers, projected", layered, String::new()),
        ("layers of 512, projected", layered, large.into()),
        ("six layers of 512, projected", layered, format!("{large}\nlayers = 6")),
        ("layers on their shells, projected", layered, bare.into()),
        ("one layer on its shell, projected", layered, format!("{bare}\nlayers = 1")),
        ("layers, inferred", layered, set("")),
        ("layers of 512, inferred", layered, set(large)),
        ("six layers of 512, inferred", layered, set(&format!("{large}\nlayers = 6"))),
        ("layers on their shells, inferred", layered, set(bare)),
        ("layers by distance on their shells, inferred", layered, set("depth = false\nclustering = \"distance\"")),
        ("one layer on its shell, inferred", layered, set("depth = false\nlayers = 1")),
        ("layers, inferred, direct images from centre and viewpoint", layered, set("direct = \"both\"")),
        (
            "layers on their shells, inferred, direct images from the viewpoint alone against disocclusion",
            layered,
            set("depth = false\ncontinued = false\nneighbours = 0\ndirect = \"viewpoint\""),
        ),
        (
            "layers on their shells, inferred, nothing against disocclusion",
            layered,
            set("depth = false\ncontinued = false\nneighbours = 0\ndirect = \"none\""),
        ),
        ("the paper's own settings", layered, "preset = \"faithful\"".into()),
    ]
}

/// The table of errors: on a viewpoint, between two, and above them.
fn table() -> Result<()> {
    let (scene, layered) = (posed()?, LAYERED);
    let ways = ways_of_table();
    let views = [("on a viewpoint", 0.0, 0.0), ("between", 4.0, 0.0), ("above", 4.0, 0.8)];
    let titles = views.map(|(name, ..)| format!(" {name} |")).concat();
    print(&format!("| FLIP, order {} |{titles}\n|---|---|---|---|", QUALITY.order))?;
    let mut frames = Vec::new();
    for (_, turn, lift) in views {
        let view = view(&scene, TABLE_SIZE, turn, lift)?;
        let truths = [TRUTH, TREE].map(|way| draw_with(&scene, &view, way).map(|drawn| drawn.picture));
        let [two_path, tree] = truths;
        frames.push((view, two_path?, tree?));
    }
    for (name, id, settings) in ways {
        let mut session = Session::new(id, &settings, &scene, QUALITY)?;
        let mut line = format!("| {name} |");
        for (view, two_path, tree) in &frames {
            // Each against the model that it draws.
            let truth = if id == layered { two_path } else { tree };
            let found = session.draw(view)?.picture;
            line += &format!(" {:.3} |", flip(&scene, view, &found, truth)?);
        }
        print(&line)?;
    }
    Ok(())
}

/// The tables of times and rays, with 8 and 16 samples a pixel in the plane of viewpoints and with 16 above it: frames
/// by the reference with two paths, and by layers with two sizes of the smallest triangles.
fn performance() -> Result<()> {
    let scene = posed()?;
    let layered = |settings: &str| ("layered_environment_map", format!("{INFERRED}\n{settings}"));
    let once = "edges = \"once\"";
    // Fine enough for such pictures.
    let large = "size = 1024\npicture_size = 1024";
    let mut ways = vec![(TRUTH.0, TRUTH.1.to_string())];
    for settings in ["", once, "edges = \"nearest\""] {
        ways.extend([3, 5].map(|tau| layered(&format!("tau = {tau}\n{settings}"))));
    }
    ways.push(layered(&format!("tau = 3\n{once}\ndepth = false")));
    ways.extend(["", once].map(|settings| layered(&format!("tau = 3\n{settings}\n{large}"))));
    ways.push(("layered_environment_map", format!("tau = 3\n{once}\nlayers = 6\nsize = 1024")));
    for (samples, lifts) in [(8, &[0.0][..]), (16, &[0.0, 0.8])] {
        let quality = Quality { samples, ..QUALITY };
        let create = |(id, settings): &(&str, String)| Ok(Session::new(id, settings, &scene, quality)?);
        let mut sessions = ways.iter().map(create).collect::<Result<Vec<_>>>()?;
        for lift in lifts {
            let view = view(&scene, [1280, 720], 4.0, *lift)?;
            performance_at(&scene, &view, quality, &ways, &mut sessions)?;
        }
    }
    Ok(())
}

/// One of the tables. The ways take turns, so that what else the machine does slows them alike.
fn performance_at(
    scene: &Scene,
    view: &View,
    quality: Quality,
    ways: &[(&str, String)],
    sessions: &mut [Session],
) -> Result<()> {
    let mut frames = vec![(Framebuffer::new(view.width, view.height), Report::default(), Vec::new()); ways.len()];
    // The first ones infer what they need.
    for frame in 0..=FRAMES {
        for (session, (picture, report, times_ms)) in sessions.iter_mut().zip(&mut frames) {
            let (drawn, time_ms) = timed(session, view, picture)?;
            *report = drawn;
            if frame > 0 {
                times_ms.push(time_ms);
            }
        }
    }
    let medians: Vec<f64> = frames.iter_mut().map(|(.., times_ms)| median(times_ms)).collect();
    let truth = &frames[0].0;
    let rays = frames[0].1.counts["rays_traced"];
    // Work that slows frames down is counted apart.
    let tests_of = |(id, settings): &(&str, String)| -> Result<u64> {
        // The course of rays does not depend on textures.
        let settings = settings.replace(INFERRED, "").replace("size = 1024", "size = 64");
        let counted = format!("{settings}\ncount_tests = true");
        Ok(draw_at(scene, view, quality, (id, &counted))?.report.counts["triangle_tests"])
    };
    let tests = ways.iter().map(tests_of).collect::<Result<Vec<_>>>()?;
    print(&format!(
        "| {} samples | frame | time reduction | rays | ray reduction | tests | test reduction | mesh | FLIP |\n\
         |---|---|---|---|---|---|---|---|---|",
        quality.samples
    ))?;
    for ((((id, settings), (picture, report, _)), own_tests), time) in
        ways.iter().zip(&frames).zip(&tests).zip(&medians)
    {
        let own = report.counts["rays_traced"];
        let settings = settings.split('\n').filter(|line| !line.is_empty()).collect::<Vec<_>>();
        let name = format!("`{id}` {}", settings.join(", ").replace('"', ""));
        let triangles = report.counts.get("mesh_triangles").map_or(String::new(), u64::to_string);
        let reduction = [medians[0] / time, rays as f64 / own as f64, tests[0] as f64 / *own_tests as f64];
        let flip = flip(scene, view, picture, truth)?;
        print(&format!(
            "| {name} | {time:.0} ms | {:.1} | {own} | {:.1} | {own_tests} | {:.1} | {triangles} | {flip:.3} |",
            reduction[0], reduction[1], reduction[2]
        ))?;
        let stages: Vec<String> = report.stages_ms.iter().map(|(name, ms)| format!("{name} {ms:.0}")).collect();
        eprintln!("{name}: {}", stages.join(", "));
    }
    Ok(())
}

/// The change of the pictures from frame to frame beyond the reference's, on a walk around the pot.
fn popping() -> Result<()> {
    const STEPS: u32 = 120;
    let scene = posed()?;
    let ways = [
        TRUTH,
        ("layered_environment_map", ""),
        ("layered_environment_map", "textures = \"inferred\"\nsize = 128\npicture_size = 192"),
    ];
    let create = |(id, settings): (&str, &str)| Ok(Session::new(id, settings, &scene, QUALITY)?);
    let mut sessions = ways.into_iter().map(create).collect::<Result<Vec<_>>>()?;
    let mut last: Option<Vec<Framebuffer>> = None;
    // For every method the step beyond the reference's, on an average and at most.
    let mut excess = vec![(0.0f64, f64::NEG_INFINITY); sessions.len()];
    for step in 0..=STEPS {
        let view = view(&scene, [160, 120], 360.0 * step as f32 / STEPS as f32, 0.0)?;
        let draw = |session: &mut Session| Ok(session.draw(&view)?.picture);
        let pictures = sessions.iter_mut().map(draw).collect::<Result<Vec<_>>>()?;
        if let Some(last) = &last {
            let changes = pictures.iter().zip(last).map(|(found, last)| flip(&scene, &view, found, last));
            let changes = changes.collect::<Result<Vec<_>>>()?;
            for ((sum, most), change) in excess.iter_mut().zip(&changes) {
                *sum += change - changes[0];
                *most = most.max(change - changes[0]);
            }
        }
        last = Some(pictures);
    }
    print("| frame to frame FLIP above the reference's own | mean | most |\n|---|---|---|")?;
    for ((id, settings), (sum, most)) in ways.iter().zip(&excess).skip(1) {
        let settings = settings.replace('\n', ", ").replace('"', "");
        print(&format!("| `{id}` {settings} | {:.4} | {most:.4} |", sum / f64::from(STEPS)))?;
    }
    Ok(())
}

/// Pictures in a row.
fn row(name: &str, turn: f32, lift: f32, ways: &[(&str, &str)]) -> Result<()> {
    let scene = posed()?;
    let view = view(&scene, TABLE_SIZE, turn, lift)?;
    let image = |way: &(&str, &str)| rgb(&draw_with(&scene, &view, *way)?.picture);
    let panels = ways.iter().map(image).collect::<Result<Vec<_>>>()?;
    save_small(&beside_of_width(&panels, 400), &root().join(format!("docs/pictures/{name}.png")))
}

/// Pictures at 3 and 5 pixels, and below them how often the triangles of their meshes were divided.
fn tessellation() -> Result<()> {
    let scene = posed()?;
    let view = view(&scene, [480, 360], 4.0, 0.0)?;
    let job = Job { scene: &scene, view: &view, quality: QUALITY, progress: &Silent };
    let (mut drawn, mut divided) = (Vec::new(), Vec::new());
    for tau in [3.0, 5.0] {
        let settings = LayeredEnvironmentMapSettings { tau, ..LayeredEnvironmentMapSettings::default() };
        let mut levels = Framebuffer::new(view.width, view.height);
        subdivision(&settings, &job, &mut levels)?;
        divided.push(rgb(&levels)?);
        let table = format!("tau = {tau:.1}");
        drawn.push(rgb(&draw_with(&scene, &view, ("layered_environment_map", &table))?.picture)?);
    }
    let rows = [drawn, divided].map(|row| beside_of_width(&row, 480));
    save_small(&below(&rows), &root().join("docs/pictures/layered-5.png"))
}

/// Layer by layer what a viewpoint shows by reflection and by refraction, and what is inferred from that.
fn inference() -> Result<()> {
    let scene = posed()?;
    let settings = LayeredEnvironmentMapSettings { textures: Textures::Inferred, ..Default::default() };
    let layers = inferred_layers(&settings, &scene, QUALITY, [0, 0], &Silent)?;
    let panel = |picture: &Framebuffer| {
        // Before grey: texels that are not there differ from black ones.
        let over = |[red, green, blue, alpha]: [f32; 4]| {
            let passes = 0.2 * (1.0 - alpha).clamp(0.0, 1.0);
            [red, green, blue].map(|channel| (channel + passes).max(0.0))
        };
        let pixels = picture.pixels.iter().map(|pixel| glam::Vec3::from(over(*pixel)).extend(1.0).to_array());
        rgb(&Framebuffer { pixels: pixels.collect(), ..Framebuffer::new(picture.width, picture.height) })
    };
    let row = |layer: &InferredLayer| -> Result<RgbImage> {
        let panels = [&layer.reflected, &layer.refracted, &layer.texture].map(panel);
        Ok(beside_of_width(&panels.into_iter().collect::<Result<Vec<_>>>()?, 400))
    };
    let rows = layers.iter().map(row).collect::<Result<Vec<_>>>()?;
    save_small(&below(&rows), &root().join("docs/pictures/layered-7.png"))
}

/// Draws the figures and tables whose names begin so; `layered` is all of them.
pub(crate) fn draw(name: &str) -> Result<()> {
    let all: [(&str, &dyn Fn() -> Result<()>); 5] = [
        ("layered-table", &table),
        ("layered-performance", &performance),
        ("layered-popping", &popping),
        ("layered-5", &tessellation),
        ("layered-7", &inference),
    ];
    let mut found = false;
    for (_, make) in all.iter().filter(|(known, _)| known.starts_with(name)) {
        make()?;
        found = true;
    }
    for (known, turn, lift, ways) in ROWS.iter().filter(|(known, ..)| known.starts_with(name)) {
        row(known, *turn, *lift, ways)?;
        found = true;
    }
    if !found {
        let names = all.iter().map(|(name, _)| *name).chain(ROWS.iter().map(|(name, ..)| *name));
        bail!("there is no figure `{name}`; there are {}", names.collect::<Vec<_>>().join(", "));
    }
    Ok(())
}
