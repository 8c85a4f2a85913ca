//! The page: what its script calls.

use super::accessible::Accessible;
use super::line::WorkerLine;
use catoptric::scene::Projection;
use catoptric_scenes::ENVIRONMENT_NAMES;
use catoptric_viewer::app::{FirstView, Start, Viewer, ViewerEvent, read_settings};
use catoptric_viewer::studio::order::{Beside, Opening, Source};
use eframe::{WebOptions, WebRunner};
use js_sys::{Function, Reflect};
use std::path::PathBuf;
use wasm_bindgen::prelude::wasm_bindgen;
use wasm_bindgen::{JsError, JsValue};
use web_sys::HtmlCanvasElement;

/// A viewer in a canvas of the page.
#[wasm_bindgen]
pub struct Page {
    runner: WebRunner,
}

#[wasm_bindgen]
impl Page {
    /// Shows a viewer in a canvas. `worker_url` is the address of the worker's script, `module` the compiled module.
    /// `options` is an object: `scene` (`builtin:NAME`, or a file's name with `content`, its bytes), `method`,
    /// `settings` (of that method: `KEY=VALUE, KEY=VALUE`), `against`, `camera`, `samples`, `order`, `panels` (`off`
    /// hides them), `processor` (`cpu` or `gpu` draws scenes; else the better one), `canvas` (`webgl` keeps WebGPU from
    /// drawing the window).
    ///
    /// # Errors
    /// The browser's error where neither WebGPU nor WebGL draws.
    pub async fn start(
        canvas: HtmlCanvasElement,
        worker_url: String,
        module: JsValue,
        options: JsValue,
    ) -> Result<Self, JsValue> {
        let start = read_start(&options)?;
        let mut web = WebOptions { dithering: false, ..WebOptions::default() };
        if text(&options, "canvas").as_deref() == Some("webgl")
            && let egui_wgpu::WgpuSetup::CreateNew(setup) = &mut web.wgpu_options.wgpu_setup
        {
            setup.instance_descriptor.backends = wgpu::Backends::GL;
        }
        let processor = text(&options, "processor").unwrap_or_default();
        let runner = WebRunner::new();
        let make = move |context: &eframe::CreationContext<'_>| {
            let line = WorkerLine::start(&worker_url, (&module, &processor), &context.egui_ctx);
            let line = line.map_err(|problem| format!("the worker cannot be started: {problem:?}"))?;
            let viewer = Viewer::new(Box::new(line), None, start);
            Ok(Box::new(viewer) as Box<dyn eframe::App>)
        };
        runner.start(canvas, web, Box::new(make)).await?;
        Ok(Self { runner })
    }

    /// Opens a scene: `builtin:NAME`, or a file's name and content.
    ///
    /// # Errors
    /// Viewers that have stopped.
    pub fn open(&self, name: &str, content: Option<Vec<u8>>) -> Result<(), JsError> {
        self.viewer()?.open(source(name, content));
        Ok(())
    }

    /// Chooses the method of a side: 0 is left, 1 right, where an empty name ends the split view.
    ///
    /// # Errors
    /// Methods that do not exist, with a list of those that do.
    pub fn choose(&self, side: usize, method: &str) -> Result<(), JsError> {
        self.viewer()?.choose(side, method).map_err(|error| JsError::new(&error.to_string()))
    }

    /// Gives the method of a side settings, `KEY=VALUE, KEY=VALUE`, in place of those that it was given before.
    ///
    /// # Errors
    /// Settings and values that the method does not have, with a list of those that it has.
    pub fn configure(&self, side: usize, settings: &str) -> Result<(), JsError> {
        self.viewer()?.configure(side, settings).map_err(|problem| JsError::new(&problem))
    }

    /// Calls a function with what happens from now on: `load` and a scene's name, `message` and its text, or `sharp`.
    ///
    /// # Errors
    /// Viewers that have stopped.
    pub fn listen(&self, told: Function) -> Result<(), JsError> {
        self.viewer()?.listen(Box::new(move |event| {
            let (kind, detail) = match event {
                ViewerEvent::Loaded(name) => ("load", name),
                ViewerEvent::Message(text) => ("message", text),
                ViewerEvent::Sharp => ("sharp", ""),
                // None are made in pages.
                ViewerEvent::Report(_) => return,
            };
            // Errors that the function throws are the page's to care for.
            let _ = told.call2(&JsValue::NULL, &kind.into(), &detail.into());
        }));
        Ok(())
    }

    /// Ends the viewer, its worker included.
    pub fn end(&self) {
        self.runner.destroy();
    }

    /// The state of the viewer, as JSON: `scene`, `method`, `settings` (over the method's defaults), `sharp`, `size`,
    /// `rect` (left, top, width and height in points), `eye`, `messages`, `remark` (which processor draws, and why),
    /// `processor` (the one that has drawn the left side).
    ///
    /// # Errors
    /// Viewers that have stopped.
    pub fn state(&self) -> Result<String, JsError> {
        let viewer = self.viewer()?;
        let wish = viewer.wish();
        let rect = viewer.picture_rect();
        let state = serde_json::json!({
            "scene": viewer.scene_name(),
            "method": wish.map(|wish| wish.sides[0].method.clone()),
            "settings": wish.map(|wish| wish.sides[0].settings.clone()),
            "sharp": viewer.is_sharp(),
            "pictures": viewer.pictures_shown(),
            "size": wish.map(|wish| wish.size),
            "rect": [rect.left(), rect.top(), rect.width(), rect.height()],
            "eye": viewer.eye().map(|eye| eye.to_array()),
            "messages": viewer.messages().collect::<Vec<_>>(),
            "remark": viewer.remarks(),
            "processor": viewer.processor(),
        });
        Ok(state.to_string())
    }

    /// The camera, as JSON: `place` (a matrix of twelve numbers, column by column, from the camera to the world), and
    /// `fov_y` in radians or `half_height`.
    ///
    /// # Errors
    /// Viewers that have stopped or show nothing yet.
    pub fn camera(&self) -> Result<String, JsError> {
        let viewer = self.viewer()?;
        let camera = &viewer.wish().ok_or_else(|| JsError::new("nothing is shown yet"))?.camera;
        let place = camera.world_from_camera.to_cols_array();
        let camera = match camera.projection {
            Projection::Perspective { fov_y } => serde_json::json!({ "place": place, "fov_y": fov_y }),
            Projection::Orthographic { half_height } => {
                serde_json::json!({ "place": place, "half_height": half_height })
            }
        };
        Ok(camera.to_string())
    }

    /// The window's widgets as assistive technology is told of them, as JSON, a list of objects: `role`, `label`,
    /// `value`, `rect` (left, top, width and height in points). Empty before the next frame when it is asked for the
    /// first time.
    ///
    /// # Errors
    /// Viewers that have stopped.
    pub fn widgets(&self) -> Result<String, JsError> {
        Ok(self.viewer()?.window().map_or_else(|| "[]".into(), Accessible::read))
    }

    /// The picture of a side, red, green, blue and 255 a pixel, rows from the top; undefined while there is none.
    ///
    /// # Errors
    /// Viewers that have stopped.
    pub fn pixels(&self, side: usize) -> Result<Option<Vec<u8>>, JsError> {
        Ok(self.viewer()?.pixels(side).map(<[u8]>::to_vec))
    }

    fn viewer(&self) -> Result<std::cell::RefMut<'_, Viewer>, JsError> {
        self.runner.app_mut::<Viewer>().ok_or_else(|| JsError::new("the viewer has stopped"))
    }
}

fn source(name: &str, content: Option<Vec<u8>>) -> Source {
    match content {
        Some(bytes) => Source::Bytes { name: name.into(), bytes: bytes.into(), beside: Beside::default() },
        None => Source::of_word(name),
    }
}

fn text(options: &JsValue, key: &str) -> Option<String> {
    Reflect::get(options, &key.into()).ok()?.as_string().filter(|text| !text.is_empty())
}

/// The light from infinity that is wanted: workers read no files, so it has a name.
fn environment(options: &JsValue) -> Result<Option<PathBuf>, JsError> {
    let Some(name) = text(options, "environment") else { return Ok(None) };
    match ENVIRONMENT_NAMES.contains(&name.as_str()) {
        true => Ok(Some(name.into())),
        false => Err(JsError::new(&format!("`environment` must be one of: {}", ENVIRONMENT_NAMES.join(", ")))),
    }
}

fn read_start(options: &JsValue) -> Result<Start, JsError> {
    let content = Reflect::get(options, &"content".into()).ok().filter(JsValue::is_object);
    let content = content.map(|content| js_sys::Uint8Array::new(&content).to_vec());
    let number = |key: &str| match text(options, key).map(|text| text.parse()) {
        None => Ok(None),
        Some(Ok(number)) => Ok(Some(number)),
        Some(Err(_)) => Err(JsError::new(&format!("`{key}` must be a whole number"))),
    };
    let (samples, order) = (number("samples")?.unwrap_or(4), number("order")?);
    let counts = catoptric::raster::SAMPLE_COUNTS;
    if !counts.contains(&samples) || order.is_some_and(|order: u32| order > 16) {
        return Err(JsError::new(&format!("`samples` must be one of {counts:?}, and `order` at most 16")));
    }
    let method = text(options, "method").unwrap_or_else(|| "auto".into());
    let against = text(options, "against");
    if let Some(id) = &against {
        catoptric::methods::find(id).map_err(|error| JsError::new(&error.to_string()))?;
    }
    let info = catoptric::methods::find(&method).map_err(|error| JsError::new(&error.to_string()))?;
    let settings = text(options, "settings").unwrap_or_default();
    let settings = read_settings(info, &settings).map_err(|problem| JsError::new(&problem))?;
    Ok(Start {
        source: source(&text(options, "scene").unwrap_or_else(|| "builtin:sphere_room".into()), content),
        method,
        settings,
        against,
        samples,
        order,
        opening: Opening { environment: environment(options)?, ..Opening::default() },
        view: FirstView { camera: text(options, "camera"), ..FirstView::default() },
        panels: text(options, "panels").as_deref() != Some("off"),
        bakes: Vec::new(),
        program: None,
    })
}
