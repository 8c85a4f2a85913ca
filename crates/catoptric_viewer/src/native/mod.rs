//! The program in a window of the desktop.

mod args;
mod program;

use args::{BackendChoice, Wanted};
use catoptric_viewer::app::{Start, StudioThread, Viewer, ViewerEvent};
use catoptric_viewer::memory;
use catoptric_viewer::studio::Gpu;
use eframe::UserEvent;
use eframe::egui;
use eframe::egui_wgpu::{RenderState, WgpuSetup};
use softbuffer_painter::winit::event_loop::EventLoop;
use softbuffer_painter::winit::platform::run_on_demand::EventLoopExtRunOnDemand;
use std::cell::RefCell;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Said where the window has no device.
const NO_DRIVER: &str = "no graphics driver that can draw in this window (on Debian one for all machines is in \
                         mesa-vulkan-drivers, with libvulkan1)";

/// Reads the command line and shows the window.
pub(super) fn main() -> ExitCode {
    memory::keep_little();
    let wanted = match args::read() {
        Ok(wanted) => wanted,
        Err(problem) => {
            eprintln!("error: {problem}\n\nFor more information, try '--help'.");
            return ExitCode::from(2);
        }
    };
    match run(wanted) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("error: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn run(wanted: Wanted) -> Result<(), String> {
    let Wanted { start, size, backend, adapter, is_software } = wanted;
    let mut event_loop = EventLoop::with_user_event().build().map_err(|error| format!("no window: {error}"))?;
    let remark = if is_software {
        "window drawn by the processor, as asked"
    } else {
        let is_needed = backend == BackendChoice::Gpu || adapter.is_some();
        match on_device(&mut event_loop, size, (backend, adapter), start.clone())? {
            Outcome::Shown => return Ok(()),
            Outcome::NoDevice(problem) if is_needed => return Err(problem),
            Outcome::NoDevice(problem) => eprintln!("{problem}; the window is drawn by the processor"),
        }
        "no graphics driver: window drawn by the processor"
    };
    let make = |window: &egui::Context| {
        let mut viewer = Viewer::new(Box::new(studio(window, None)), None, start);
        viewer.listen(Box::new(show_reports));
        viewer.remark(remark);
        move |ui: &mut egui::Ui| viewer.show(ui)
    };
    softbuffer_painter::run(&mut event_loop, wake_up, viewport(size), make).map_err(|error| error.to_string())
}

/// An event without content, which wakes the window up.
fn wake_up() -> UserEvent {
    let (viewport_id, when, cumulative_pass_nr) = (egui::ViewportId::ROOT, Instant::now(), 0);
    UserEvent::RequestRepaint { viewport_id, when, cumulative_pass_nr }
}

/// The window as it is asked for.
fn viewport(size: [u32; 2]) -> egui::ViewportBuilder {
    egui::ViewportBuilder::default().with_inner_size(size.map(|length| length as f32)).with_title("catoptric")
}

/// A studio that wakes up a window.
fn studio(window: &egui::Context, gpu: Option<Gpu>) -> StudioThread {
    let window = window.clone();
    StudioThread::start(gpu, Box::new(move || window.request_repaint()))
}

/// Opens reports in the browser.
fn show_reports(event: ViewerEvent<'_>) {
    // Where there is none, the window says where the report is.
    if let ViewerEvent::Report(page) = event {
        let _ = open::that_detached(page);
    }
}

/// The end of a window on a device.
enum Outcome {
    /// The window was there, and was closed.
    Shown,
    /// There never was a window: the reason.
    NoDevice(String),
}

/// Shows the window on a device, if there is one that can draw on it.
fn on_device(
    event_loop: &mut EventLoop<UserEvent>,
    size: [u32; 2],
    (backend, adapter): (BackendChoice, Option<String>),
    start: Start,
) -> Result<Outcome, String> {
    let mut options = eframe::NativeOptions { viewport: viewport(size), ..Default::default() };
    let missing = Arc::new(Mutex::new(NO_DRIVER.to_owned()));
    if let (Some(name), WgpuSetup::CreateNew(setup)) = (adapter, &mut options.wgpu_options.wgpu_setup) {
        let missing = missing.clone();
        let select = move |adapters: &[wgpu::Adapter], _: Option<&wgpu::Surface<'_>>| {
            let found = named(adapters, &name);
            if let Err(problem) = &found {
                missing.lock().unwrap_or_else(PoisonError::into_inner).clone_from(problem);
            }
            found
        };
        setup.native_adapter_selector = Some(Arc::new(select));
    }
    // Set once there is a device: the library alone knows whether one can draw on this window, and tells nobody else.
    let made = RefCell::new(None);
    let make = |context: &eframe::CreationContext<'_>| {
        let device = context.wgpu_render_state.clone().filter(|device| draws(backend, device));
        let gpu = device
            .as_ref()
            .map(|RenderState { adapter, device, queue, .. }| Gpu::of_window(adapter, device.clone(), queue.clone()));
        let gpu = gpu.transpose();
        *made.borrow_mut() = Some(gpu.as_ref().map(|_| ()).map_err(ToString::to_string));
        let studio = studio(&context.egui_ctx, gpu?);
        let mut viewer = Viewer::new(Box::new(studio), device, start);
        viewer.listen(Box::new(show_reports));
        Ok(Box::new(viewer) as Box<dyn eframe::App>)
    };
    let mut window = eframe::create_native("catoptric", options, Box::new(make), event_loop);
    let ended = event_loop.run_app_on_demand(&mut window);
    drop(window);
    ended.map_err(|error| format!("no window: {error}"))?;
    match made.into_inner() {
        Some(made) => made.map(|()| Outcome::Shown),
        None => {
            let problem = missing.lock().unwrap_or_else(PoisonError::into_inner).clone();
            Ok(Outcome::NoDevice(problem))
        }
    }
}

/// The adapter whose name has a part.
fn named(adapters: &[wgpu::Adapter], name: &str) -> Result<wgpu::Adapter, String> {
    let is_named = |adapter: &&wgpu::Adapter| adapter.get_info().name.to_lowercase().contains(&name.to_lowercase());
    let known = || adapters.iter().map(|adapter| adapter.get_info().name).collect::<Vec<_>>().join(", ");
    let found = adapters.iter().find(is_named).cloned();
    found.ok_or_else(|| format!("--adapter: no adapter is named `{name}`; there are: {}", known()))
}

/// True if the window's device is to draw the scene: where nothing was chosen, only a real GPU does.
fn draws(backend: BackendChoice, device: &RenderState) -> bool {
    match backend {
        BackendChoice::Cpu => false,
        BackendChoice::Gpu => true,
        BackendChoice::Auto => device.adapter.get_info().device_type != wgpu::DeviceType::Cpu,
    }
}
