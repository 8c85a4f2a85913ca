//! The pictures of devices against the processor's: every method, built-in scene, order and number of samples.
//!
//! Devices shade samples on their own in places where the processor shades several at once, and follow each one's own
//! rays where the processor's tiles may be off by half a pixel. So the reference is the judge where the two differ:
//! pixels count where the device is off from both, and its pictures may be no further from the reference.
//!
//! Every scene is drawn by `multiperspective` and by one other method, other qualities and methods for every scene:
//! drivers that draw on the processor compile shaders for seconds. `CATOPTRIC_PARITY=all` asks for all combinations.
//!
//! Without a device the tests show as ignored, with the reason. `CATOPTRIC_REQUIRE_GPU=1` makes them fail then.

use libtest_mimic::{Arguments, Trial};

fn main() {
    let arguments = Arguments::from_args();
    libtest_mimic::run(&arguments, trials()).exit();
}

/// A single test that says why there are no others.
fn ignored(reason: &str) -> Vec<Trial> {
    let is_required = std::env::var_os("CATOPTRIC_REQUIRE_GPU").is_some_and(|value| value == "1");
    let message = reason.to_owned();
    let trial = Trial::test(format!("parity ({reason})"), move || Err(message.into()));
    vec![trial.with_ignored_flag(!is_required)]
}

#[cfg(not(feature = "wgpu"))]
fn trials() -> Vec<Trial> {
    ignored("built without the feature wgpu")
}

#[cfg(feature = "wgpu")]
use catoptric_gpu::GpuError;

#[cfg(feature = "wgpu")]
fn trials() -> Vec<Trial> {
    match catoptric_gpu::Context::new(None) {
        Ok(context) => {
            let mut trials = pictures::trials(&context);
            trials.extend(lobes::trials(&context));
            trials.extend(motion::trials(&context));
            trials.extend(renderer::trials(&context));
            trials.extend(projected::trials(&context));
            trials
                .extend([twins::trial, twins_of_scene::trial, twins_of_encounters::trial].map(|trial| trial(&context)));
            trials
        }
        Err(error @ GpuError::NoAdapter) => ignored(&error.to_string()),
        // There is an adapter: that it cannot be used is a fault.
        Err(error) => vec![Trial::test("a device", move || Err(error.to_string().into()))],
    }
}

#[cfg(feature = "wgpu")]
mod lobes;
#[cfg(feature = "wgpu")]
mod motion;
#[cfg(feature = "wgpu")]
mod projected;
#[cfg(feature = "wgpu")]
mod renderer;
#[cfg(feature = "wgpu")]
mod resources;
#[cfg(feature = "wgpu")]
mod twins;
#[cfg(feature = "wgpu")]
mod twins_of_encounters;
#[cfg(feature = "wgpu")]
mod twins_of_scene;

#[cfg(feature = "wgpu")]
mod pictures {
    use catoptric::framebuffer::Framebuffer;
    use catoptric::light::visibility::cast_shadows;
    use catoptric::methods::{self, Method, MethodInfo, Quality, Report};
    use catoptric::progress::Silent;
    use catoptric::scene::{Environment, Scene};
    use catoptric::surface::{AnalyticSurface, Implicit, PlacedSurface};
    use catoptric_gpu::Context;
    use catoptric_scenes::builtin;
    use glam::DAffine3;
    use libtest_mimic::{Failed, Trial};
    use std::sync::{Arc, OnceLock};

    const SIZE: [u32; 2] = [240, 160];
    /// Pixels are wrong where a channel is off by more.
    const WRONG: f32 = 0.1;
    const MOST_WRONG: f64 = 0.001;

    pub(crate) fn trials(context: &Arc<Context>) -> Vec<Trial> {
        let mut trials = Vec::new();
        let asks_for_all = std::env::var_os("CATOPTRIC_PARITY").is_some_and(|value| value == "all");
        let by_turns = |info: &&MethodInfo| info.gpu && !["auto", "multiperspective"].contains(&info.id);
        let others: Vec<&str> = methods::all().iter().copied().filter(by_turns).map(|info| info.id).collect();
        for (number, scene) in builtin::all().iter().enumerate() {
            let name = scene.name;
            for (quality, (order, samples)) in [(1, 1), (1, 4), (2, 1), (2, 4)].into_iter().enumerate() {
                let case = Case::new(context, pose(name), Quality { samples, order });
                let is_chosen = |info: &MethodInfo| match info.id {
                    _ if asks_for_all => true,
                    "multiperspective" => quality == number % 4,
                    id if others[number % others.len()] != id => false,
                    id if PROJECTING.contains(&id) => true,
                    _ => order as usize == number % 2 + 1,
                };
                let is_possible = |info: &MethodInfo| match info.id {
                    "auto" => false,
                    // Geometry that has been found is drawn in the same way at all qualities.
                    id if PROJECTING.contains(&id) => (order, samples) == (2, 4),
                    // The processor shades the samples of a pixel that show one triangle of its mesh at once.
                    LAYERED => samples == 1,
                    "multiperspective" => true,
                    // Both orders and numbers of samples, but not every pair of them.
                    _ => order == samples.min(2),
                };
                let drawn = methods::all().iter().filter(|info| info.gpu && is_possible(info) && is_chosen(info));
                for info in drawn {
                    let case = case.clone();
                    let run = move || case.compare(info);
                    trials.push(Trial::test(format!("{}: {name}, order {order}, {samples} samples", info.id), run));
                }
            }
        }
        for (id, name, samples, order) in OTHER_QUALITIES {
            let case = Case::new(context, pose(name), Quality { samples, order });
            let info = methods::find(id).expect("it is there");
            let run = move || case.compare(info);
            trials.push(Trial::test(format!("{id}: {name}, order {order}, {samples} samples"), run));
        }
        for samples in [1, 4] {
            let others = [("a coarse mirror under a sky", under_sky()), ("a mirror by an expression", by_expression())];
            for (name, scene) in others {
                let case = Case::new(context, scene, Quality { samples, order: 2 });
                let info = methods::find("multiperspective").expect("it is there");
                let run = move || case.compare(info);
                trials.push(Trial::test(format!("{name}, {samples} samples"), run));
            }
        }
        let case = Case::new(context, ending_in_the_sky("glass_sphere"), Quality { samples: 1, order: 1 });
        let info = methods::find("multiperspective").expect("it is there");
        trials.push(Trial::test("glass whose paths end in a sky", move || case.compare(info)));
        trials
    }

    /// A scene whose paths show a sky where they end.
    fn ending_in_the_sky(name: &str) -> Result<Scene, Failed> {
        let mut scene = pose(name)?;
        let texel = |index: usize| [0.2 + (index % 64) as f32 / 80.0, 0.8 - (index / 64) as f32 / 50.0, 0.5];
        scene.environment = Some(Arc::new(Environment::new("sky", 64, 32, (0..64 * 32).map(texel).collect())));
        scene.ends_in_environment = true;
        Ok(scene)
    }

    /// Methods and scenes whose virtual geometry is found on the device; numbers of samples that are drawn one after
    /// the other; and long paths.
    const OTHER_QUALITIES: [(&str, &str, u32, u32); 9] = [
        ("explosion_map", "sphere_room", 1, 1),
        ("explosion_map", "two_spheres", 4, 2),
        ("reflector_search", "two_spheres", 1, 2),
        ("reflector_search", "sphere_room", 16, 2),
        ("reflector_search", "highlights", 4, 1),
        ("multiperspective", "planar_mirror", 16, 2),
        ("multiperspective", "two_spheres", 8, 16),
        ("planar_mirror", "planar_mirror", 2, 16),
        ("sample_based_camera", "sphere_room", 16, 1),
    ];

    /// Methods that draw virtual geometry.
    const PROJECTING: [&str; 4] = ["path_perturbation", "sample_based_camera", "explosion_map", "reflector_search"];

    const LAYERED: &str = "layered_environment_map";
    const LIGHT_FIELD: &str = "light_field";

    /// A scene and a quality, with the reference's picture.
    struct Case {
        context: Arc<Context>,
        scene: Result<Arc<Scene>, Failed>,
        quality: Quality,
        reference: OnceLock<Result<Framebuffer, Failed>>,
    }

    impl Case {
        fn new(context: &Arc<Context>, scene: Result<Scene, Failed>, quality: Quality) -> Arc<Self> {
            let (context, scene) = (context.clone(), scene.map(Arc::new));
            Arc::new(Self { context, scene, quality, reference: OnceLock::new() })
        }
    }

    /// A ball of few triangles with smooth normals, which shows nothing but a sky: from pixel to pixel what it shows
    /// changes much.
    fn under_sky() -> Result<Scene, Failed> {
        let mut scene = pose("sphere_room")?;
        let ball = scene.specular_objects()[0] as usize;
        let center = scene.objects[ball].bounds.center();
        let radius = scene.objects[ball].bounds.diagonal() / 12f32.sqrt();
        scene.objects[ball].surface = None;
        let of_ball = scene.objects[ball].triangles.clone();
        for (index, triangle) in (0..).zip(&scene.triangles) {
            for vertex in triangle.map(|vertex| vertex as usize) {
                if of_ball.contains(&index) {
                    let normal = ((scene.positions[vertex] - center).normalize() * 1.6).round().normalize();
                    (scene.positions[vertex], scene.normals[vertex]) = (center + normal * radius, normal);
                } else {
                    // Without extent nothing is seen of it.
                    scene.positions[vertex] = center;
                }
            }
        }
        let texel = |index: usize| match (index % 64 / 4 + index / 64 / 4) % 2 {
            0 => [0.1, 0.2, 0.9],
            _ => [0.9, 0.7, 0.1],
        };
        scene.environment = Some(Arc::new(Environment::new("sky", 64, 32, (0..64 * 32).map(texel).collect())));
        Ok(scene)
    }

    /// A wavy ball that is given by an expression.
    fn by_expression() -> Result<Scene, Failed> {
        let mut scene = pose("sphere_room?surface=analytic")?;
        let ball = scene.specular_objects()[0] as usize;
        let bounds = scene.objects[ball].bounds;
        let radius = f64::from(bounds.size().x) * 0.5;
        let corner = [1.1 * radius; 3];
        // All functions and operators.
        let wave = "sin(7 * x) * cos(9 * y) * exp(-z^2 / 4) * (1 + x^2)^0.7 * 2^sin(y) * abs(y - 9) / 9";
        let text = format!("sqrt(x^2 + y^2 + z^2) - {radius} * (1 + 0.003 * {wave})");
        let surface = AnalyticSurface::Implicit(Implicit::new(&text, corner.map(|side| -side), corner)?);
        let world_from_surface = DAffine3::from_translation(bounds.center().as_dvec3());
        scene.objects[ball].surface = Some(PlacedSurface { surface, world_from_surface });
        Ok(scene)
    }

    fn pose(name: &str) -> Result<Scene, Failed> {
        let mut scene = builtin::parse(name)?.pose(&Default::default())?;
        cast_shadows(&mut scene);
        Ok(scene)
    }

    impl Case {
        fn reference(&self, scene: &Arc<Scene>) -> Result<&Framebuffer, Failed> {
            let draw = || Ok(draw(&*methods::create("reference", &Default::default())?, scene, self.quality)?.0);
            self.reference.get_or_init(draw).as_ref().map_err(Clone::clone)
        }

        fn compare(&self, info: &MethodInfo) -> Result<(), Failed> {
            let (scene, quality) = (self.scene.as_ref().map_err(Clone::clone)?, self.quality);
            // As the methods' errors are measured: small and quick. Virtual geometry is as fine as by default, though:
            // places beside coarse geometry are looked for in other ways.
            let settings = if PROJECTING.contains(&info.id) { "" } else { info.limits.settings };
            let mut settings = settings.parse::<toml::Table>()?;
            if info.id == LAYERED {
                // A fine mesh, where devices trace the rays of every pixel.
                settings.extend([("tau".into(), 0.5.into()), ("angle_deg".into(), 1.0.into())]);
            }
            let on_device = catoptric_gpu::create(&self.context, info.id, &settings)?;
            let (on_device, report) = draw(&on_device.expect("it draws on devices"), scene, quality)?;
            let (on_processor, of_processor) = draw(&*methods::create(info.id, &settings)?, scene, quality)?;
            let compared = match is_smoothed(&of_processor) && !is_smoothed(&report) {
                // Bumps that the processor leaves out make another picture.
                true => Compared::WithTruth,
                false if PROJECTING.contains(&info.id) || info.id == LAYERED => Compared::WhereRight,
                // A few rays of each lobe: noise, on both.
                false if info.id == LIGHT_FIELD && spreads_light(scene) => Compared::WhereRight,
                false => Compared::Everywhere,
            };
            judge(&on_device, &on_processor, self.reference(scene)?, compared)
        }
    }

    /// True if something is rough or bumpy.
    fn spreads_light(scene: &Scene) -> bool {
        (0..scene.objects.len() as u32).any(|object| scene.material_of(object).may_spread_light())
    }

    /// True if a method has drawn rough or bumpy surfaces as smooth ones.
    fn is_smoothed(report: &Report) -> bool {
        report.warnings.iter().any(|warning| warning.contains("smooth ones"))
    }

    /// How pictures are compared with the processor's.
    #[derive(Clone, Copy, PartialEq)]
    enum Compared {
        Everywhere,
        /// Where a method only comes near the truth, what is wrong on the processor may be wrong in another way on
        /// devices: pixels count that are right on the processor.
        WhereRight,
        /// By their distances to the truth alone.
        WithTruth,
    }

    fn judge(
        on_device: &Framebuffer,
        on_processor: &Framebuffer,
        reference: &Framebuffer,
        compared: Compared,
    ) -> Result<(), Failed> {
        let share = |wrong: usize| wrong as f64 / on_device.pixels.len() as f64;
        let count = |pixels: &[bool]| share(pixels.iter().filter(|is_wrong| **is_wrong).count());
        let from_processor = wrong(on_device, on_processor);
        let from_truth = wrong(on_device, reference);
        let of_processor = wrong(on_processor, reference);
        let is_fault = |pixel: &usize| {
            let counts = match compared {
                Compared::Everywhere => true,
                Compared::WhereRight => !of_processor[*pixel],
                Compared::WithTruth => false,
            };
            from_processor[*pixel] && from_truth[*pixel] && counts
        };
        let both = share((0..from_truth.len()).filter(is_fault).count());
        let (truth, processor) = (count(&from_truth), count(&of_processor));
        if both > MOST_WRONG || truth > processor + MOST_WRONG {
            let problem = format!(
                "{:.3} % of pixels are off by more than {WRONG} from processor and reference, {:.3} % from the \
                 reference, where the processor has {:.3} %",
                both * 100.0,
                truth * 100.0,
                processor * 100.0
            );
            return Err(problem.into());
        }
        Ok(())
    }

    /// The pixels of which a channel is off.
    fn wrong(picture: &Framebuffer, other: &Framebuffer) -> Vec<bool> {
        // Channels that are not numbers are wrong, too.
        let is_right = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).all(|channel| (a[channel] - b[channel]).abs() <= WRONG);
        picture.pixels.iter().zip(&other.pixels).map(|pair| !is_right(pair)).collect()
    }

    fn draw(method: &dyn Method, scene: &Arc<Scene>, quality: Quality) -> Result<(Framebuffer, Report), Failed> {
        let mut prepared = method.prepare(scene, quality, None, &Silent)?;
        let mut report = prepared.report().clone();
        let mut picture = Framebuffer::new(SIZE[0], SIZE[1]);
        report.add(prepared.frame(&scene.default_view(SIZE[0], SIZE[1]), &Silent)?.draw(&mut picture, &Silent)?);
        Ok((picture, report))
    }
}
