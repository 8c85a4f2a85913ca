//! A window of the desktop whose pixels are drawn here, without a graphics driver.

use crate::Painter;
use egui::{Context, FullOutput, RequestRepaintInfo, Ui, ViewportBuilder, ViewportId, ViewportInfo};
use egui_winit::winit::application::ApplicationHandler;
use egui_winit::winit::error::{EventLoopError, OsError};
use egui_winit::winit::event::WindowEvent;
use egui_winit::winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, OwnedDisplayHandle};
use egui_winit::winit::platform::run_on_demand::EventLoopExtRunOnDemand;
use egui_winit::winit::window::{Window, WindowId};
use egui_winit::{State, create_window, process_viewport_commands, update_viewport_info};
use softbuffer::{SoftBufferError, Surface};
use std::num::{NonZeroU32, NonZeroUsize};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The shortest time from a frame to the next: nothing here waits for the screen, and the program needs the processor,
/// too.
const FRAME: Duration = Duration::from_millis(16);

/// The longest side of a texture. Pictures and letters have less.
const TEXTURE_SIDE: usize = 16_384;

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// The desktop's events do not come.
    #[error("no events of a desktop: {0}")]
    Events(#[from] EventLoopError),
    /// The desktop gives no window.
    #[error("no window: {0}")]
    Window(#[from] OsError),
    /// The window takes no pixels.
    #[error("the window takes no pixels: {0}")]
    Pixels(#[from] SoftBufferError),
}

/// Shows the window's content for a frame.
type Show<'a> = Box<dyn FnMut(&mut Ui) + 'a>;

/// Makes the window's content.
type Make<'a> = Box<dyn FnOnce(&Context) -> Show<'a> + 'a>;

/// Shows a window until it is closed, and returns then.
///
/// `make` is called once the window is there, and returns what shows the content for a frame, as egui wants it.
/// `wake_up` makes an event of the loop's own type, which is sent when a repaint is asked for, on any thread; its
/// content is not looked at. The loop may show another window afterwards, but for systems where winit allows it once.
///
/// # Errors
/// [`WindowError`] if the desktop gives no events, no window or no pixels.
pub fn run<'a, Event: Send + 'static, Content: FnMut(&mut Ui) + 'a>(
    event_loop: &mut EventLoop<Event>,
    wake_up: impl Fn() -> Event + Send + Sync + 'static,
    viewport: ViewportBuilder,
    make: impl FnOnce(&Context) -> Content + 'a,
) -> Result<(), WindowError> {
    let context = Context::default();
    // As in eframe: what is measured in one pass may be laid out in a second one.
    context.options_mut(|options| options.max_passes = NonZeroUsize::MIN.saturating_add(1));
    let proxy = Mutex::new(event_loop.create_proxy());
    let (sender, requests) = channel();
    context.set_request_repaint_callback(move |request| {
        let Some(when) = Instant::now().checked_add(request.delay) else { return };
        // Nobody listens any more while the window closes.
        let _ = sender.send((when, request));
        let _ = proxy.lock().unwrap_or_else(PoisonError::into_inner).send_event(wake_up());
    });
    let make: Make<'a> = Box::new(|context| Box::new(make(context)));
    let (make, schedule) = (Some(make), Schedule::default());
    let mut desktop = Desktop { context, viewport, make, shown: None, problem: None, requests, schedule };
    event_loop.run_app_on_demand(&mut desktop)?;
    desktop.problem.map_or(Ok(()), Err)
}

/// When the next frame is to be drawn.
#[derive(Debug, Default)]
struct Schedule {
    next: Option<Instant>,
    /// The start of the last frame.
    last: Option<Instant>,
}

impl Schedule {
    /// Wants a frame at a time, or before.
    fn want(&mut self, when: Instant) {
        let earliest = self.last.map_or(when, |last| when.max(last + FRAME));
        self.next = Some(self.next.map_or(earliest, |next| next.min(earliest)));
    }

    /// True once for every frame whose time has come.
    fn is_due(&mut self, now: Instant) -> bool {
        self.next.take_if(|next| *next <= now).is_some()
    }
}

/// The application that answers the desktop's events.
struct Desktop<'a> {
    context: Context,
    viewport: ViewportBuilder,
    /// Taken when the window is there.
    make: Option<Make<'a>>,
    shown: Option<Shown<'a>>,
    problem: Option<WindowError>,
    /// Repaints that were asked for, with their times.
    requests: Receiver<(Instant, RequestRepaintInfo)>,
    schedule: Schedule,
}

impl Desktop<'_> {
    /// Ends the program's part in the desktop's events. The window goes while they still come.
    fn end(&mut self, event_loop: &ActiveEventLoop, problem: Option<WindowError>) {
        self.shown = None;
        self.problem = problem;
        event_loop.exit();
    }

    fn draw(&mut self, event_loop: &ActiveEventLoop) {
        let Some(shown) = &mut self.shown else { return };
        self.schedule.last = Some(Instant::now());
        match shown.draw(event_loop) {
            Ok(Next::Wait) => {}
            Ok(Next::End) => self.end(event_loop, None),
            Err(problem) => self.end(event_loop, Some(problem)),
        }
    }
}

impl<Event: 'static> ApplicationHandler<Event> for Desktop<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let Some(make) = self.make.take() else { return };
        match Shown::new(event_loop, &self.context, &self.viewport, make) {
            Ok(shown) => {
                let window = self.shown.insert(shown).window.clone();
                // Drawn before it is seen, and again once it is: what hidden windows are given may be lost.
                self.draw(event_loop);
                window.set_visible(true);
                window.request_redraw();
            }
            Err(problem) => self.end(event_loop, Some(problem)),
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, _: Event) {
        for (when, RequestRepaintInfo { viewport_id, current_cumulative_pass_nr: asked, .. }) in
            self.requests.try_iter()
        {
            let passed = self.context.cumulative_pass_nr_for(viewport_id);
            // A request from before the last frame has been met.
            if passed == asked || passed == asked + 1 {
                self.schedule.want(when);
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, id: WindowId, event: WindowEvent) {
        // There may have been another window, whose last events come late.
        let Some(shown) = self.shown.as_mut().filter(|shown| shown.window.id() == id) else { return };
        match event {
            WindowEvent::RedrawRequested => return self.draw(event_loop),
            WindowEvent::CloseRequested | WindowEvent::Destroyed => return self.end(event_loop, None),
            WindowEvent::Resized(_) => self.schedule.want(Instant::now()),
            _ => {}
        }
        if shown.state.on_window_event(&shown.window, &event).repaint {
            self.schedule.want(Instant::now());
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if let Some(shown) = &self.shown
            && self.schedule.is_due(Instant::now())
        {
            shown.window.request_redraw();
        }
        event_loop.set_control_flow(self.schedule.next.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}

/// The step after a frame.
enum Next {
    Wait,
    End,
}

/// A window that is there.
struct Shown<'a> {
    context: Context,
    show: Show<'a>,
    window: Arc<Window>,
    surface: Surface<OwnedDisplayHandle, Arc<Window>>,
    /// The events of the window since the last frame.
    state: State,
    info: ViewportInfo,
    painter: Painter,
}

impl<'a> Shown<'a> {
    fn new(
        event_loop: &ActiveEventLoop,
        context: &Context,
        viewport: &ViewportBuilder,
        make: Make<'a>,
    ) -> Result<Self, WindowError> {
        let window = Arc::new(create_window(context, event_loop, &viewport.clone().with_visible(false))?);
        let display = softbuffer::Context::new(event_loop.owned_display_handle())?;
        let surface = Surface::new(&display, window.clone())?;
        let state = State::new(
            context.clone(),
            ViewportId::ROOT,
            event_loop,
            Some(window.scale_factor() as f32),
            event_loop.system_theme(),
            Some(TEXTURE_SIDE),
        );
        let mut info = ViewportInfo::default();
        update_viewport_info(&mut info, context, &window, true);
        let show = make(context);
        Ok(Self { context: context.clone(), show, window, surface, state, info, painter: Painter::default() })
    }

    /// Shows a frame.
    fn draw(&mut self, event_loop: &ActiveEventLoop) -> Result<Next, WindowError> {
        update_viewport_info(&mut self.info, &self.context, &self.window, false);
        let mut input = self.state.take_egui_input(&self.window);
        input.viewports = std::iter::once((ViewportId::ROOT, self.info.clone())).collect();
        let FullOutput { platform_output, mut textures_delta, shapes, pixels_per_point, viewport_output } =
            self.context.run_ui(input, &mut self.show);
        self.info.events.clear();
        self.state.handle_platform_output_with_event_loop(&self.window, event_loop, platform_output);
        self.painter.update(&textures_delta);
        let size = self.window.inner_size();
        // Small windows may have no pixels.
        if let (Some(width), Some(height)) = (NonZeroU32::new(size.width), NonZeroU32::new(size.height)) {
            self.surface.resize(width, height)?;
            let mut buffer = self.surface.buffer_mut()?;
            let primitives = self.context.tessellate(shapes, pixels_per_point);
            let size = [width, height].map(|length| length.get() as usize);
            self.painter.paint(&mut buffer, size, pixels_per_point, &primitives);
            self.window.pre_present_notify();
            buffer.present()?;
        }
        self.painter.free(&textures_delta);
        textures_delta.clear();
        let commands = viewport_output.into_values().flat_map(|viewport| viewport.commands);
        process_viewport_commands(&self.context, &mut self.info, commands, &self.window, &mut Vec::new());
        Ok(if self.info.close_requested() { Next::End } else { Next::Wait })
    }
}
