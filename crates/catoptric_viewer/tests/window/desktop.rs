//! The program in a real window of a desktop, without a graphics driver: on Xvfb, a server that shows nothing.

use libtest_mimic::Trial;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ClientMessageEvent, ConfigureWindowAux, ConnectionExt as _,
    EventMask, ImageFormat, MOTION_NOTIFY_EVENT, Window,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;

const WIDTH: u16 = 1500;
const HEIGHT: u16 = 900;

/// A test that waits longer gives up: far longer than anything takes on a machine at work.
const PATIENCE: Duration = Duration::from_secs(120);

/// Where the panels end, at their first size.
const PANELS: usize = 310;

pub(crate) fn trials() -> Vec<Trial> {
    let name = "a window without a graphics driver is drawn, turned, resized and closed";
    if Command::new("Xvfb").arg("-help").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok() {
        return vec![crate::trial(name, window)];
    }
    vec![crate::lacking(name, "Xvfb is not installed".to_owned(), false)]
}

/// A program that ends with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        // The program may have ended of itself.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A desktop with the program's window.
struct Desktop {
    connection: RustConnection,
    root: Window,
    viewer: Running,
    // Ends after the program.
    _server: Running,
}

impl Desktop {
    /// Starts the program; what it says goes into a file.
    fn start(said: &Path) -> Self {
        let screen = format!("{WIDTH}x{HEIGHT}x24");
        let mut server = Command::new("Xvfb");
        server.args(["-displayfd", "1", "-nolisten", "tcp", "-screen", "0", &screen]);
        let mut server = Running(server.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap());
        let mut number = String::new();
        BufReader::new(server.0.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());
        let mut viewer = Command::new(env!("CARGO_BIN_EXE_catoptric_viewer"));
        viewer.arg(format!("builtin:{}", crate::session::SCENE)).env("DISPLAY", &display);
        viewer.env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET").env("WINIT_X11_SCALE_FACTOR", "1");
        for drivers in ["VK_ICD_FILENAMES", "VK_DRIVER_FILES", "LIBGL_DRIVERS_PATH"] {
            viewer.env(drivers, "/nonexistent");
        }
        let viewer = Running(viewer.stderr(std::fs::File::create(said).unwrap()).spawn().unwrap());
        let (connection, screen) = x11rb::connect(Some(&display)).unwrap();
        let root = connection.setup().roots[screen].root;
        Self { connection, root, viewer, _server: server }
    }

    /// All pixels of the desktop, as words of red, green and blue.
    fn pixels(&self) -> Vec<u32> {
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, self.root, 0, 0, WIDTH, HEIGHT, !0).unwrap();
        let bytes = image.reply().unwrap().data;
        bytes.chunks_exact(4).map(|pixel| u32::from_le_bytes([pixel[0], pixel[1], pixel[2], 0])).collect()
    }

    /// The same once nothing changes any more and something is so.
    fn settled(&self, what: &str, is_so: impl Fn(&[u32]) -> bool) -> Vec<u32> {
        let start = Instant::now();
        let mut before = Vec::new();
        while start.elapsed() < PATIENCE {
            std::thread::sleep(Duration::from_millis(700));
            let pixels = self.pixels();
            if pixels == before && is_so(&pixels) {
                return pixels;
            }
            before = pixels;
        }
        save(&before, "given up");
        panic!("it never came to be: {what}");
    }

    /// The program's window.
    fn window(&self) -> Window {
        let children = self.connection.query_tree(self.root).unwrap().reply().unwrap().children;
        let is_named = |window: &Window| {
            let name = self.connection.get_property(false, *window, AtomEnum::WM_NAME, AtomEnum::ANY, 0, 99).unwrap();
            name.reply().is_ok_and(|name| name.value.ends_with(b"catoptric"))
        };
        children.into_iter().find(is_named).unwrap()
    }

    fn pointer(&self, kind: u8, button: u8, [x, y]: [i16; 2]) {
        self.connection.xtest_fake_input(kind, button, 0, self.root, x, y, 0).unwrap();
        self.connection.flush().unwrap();
        std::thread::sleep(Duration::from_millis(40));
    }

    fn drag(&self, [x, y]: [i16; 2], by: i16) {
        self.pointer(MOTION_NOTIFY_EVENT, 0, [x, y]);
        self.pointer(BUTTON_PRESS_EVENT, 1, [x, y]);
        for step in 1..=10 {
            self.pointer(MOTION_NOTIFY_EVENT, 0, [x + by * step / 10, y]);
        }
        self.pointer(BUTTON_RELEASE_EVENT, 1, [x + by, y]);
    }

    /// Asks the window to close, as a window manager does.
    fn close(&self, window: Window) {
        let atom = |name: &[u8]| self.connection.intern_atom(false, name).unwrap().reply().unwrap().atom;
        let data = [atom(b"WM_DELETE_WINDOW"), 0, 0, 0, 0];
        let event = ClientMessageEvent::new(32, window, atom(b"WM_PROTOCOLS"), data);
        self.connection.send_event(false, window, EventMask::NO_EVENT, event).unwrap();
        self.connection.flush().unwrap();
    }
}

/// Saves a screenshot where one is wanted.
fn save(pixels: &[u32], name: &str) {
    if let Some(folder) = std::env::var_os("CATOPTRIC_SCREENSHOTS") {
        let bytes = pixels.iter().flat_map(|pixel| pixel.to_be_bytes()[1..].to_vec()).collect();
        let image = image::RgbImage::from_raw(WIDTH.into(), HEIGHT.into(), bytes).unwrap();
        image.save(Path::new(&folder).join(format!("desktop {name}.png"))).unwrap();
    }
}

/// Some of the pixels of columns and rows.
fn part(pixels: &[u32], columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> Vec<u32> {
    rows.flat_map(|row| &pixels[row * usize::from(WIDTH)..][columns.clone()]).copied().collect()
}

fn is_colorful(pixels: &[u32]) -> bool {
    pixels.iter().collect::<std::collections::HashSet<_>>().len() > 1000
}

fn changed(one: &[u32], other: &[u32]) -> f64 {
    one.iter().zip(other).filter(|(one, other)| one != other).count() as f64 / one.len() as f64
}

fn window() {
    let folder = tempfile::tempdir().unwrap();
    let said = folder.path().join("said");
    let mut desktop = Desktop::start(&said);
    let picture = |pixels: &[u32]| part(pixels, PANELS..1430, 30..820);
    let before = desktop.settled("a picture", |pixels| is_colorful(&picture(pixels)));
    save(&before, "before");
    // Panels are dark, with bright letters.
    let panel = part(&before, 0..PANELS - 20, 0..180);
    assert!(panel.iter().filter(|pixel| **pixel == 0x001b_1b1b).count() > panel.len() / 2);
    assert!(panel.iter().any(|pixel| pixel & 255 > 180));
    let window = desktop.window();

    desktop.drag([900, 400], 120);
    let is_turned = |pixels: &[u32]| changed(&picture(pixels), &picture(&before)) > 0.3;
    let turned = desktop.settled("another view", is_turned);
    save(&turned, "turned");
    assert!(changed(&part(&turned, 0..PANELS - 20, 0..100), &part(&before, 0..PANELS - 20, 0..100)) < 0.02);

    let size = ConfigureWindowAux::new().width(900).height(600);
    desktop.connection.configure_window(window, &size).unwrap().check().unwrap();
    let is_small = |pixels: &[u32]| {
        let status = part(pixels, 0..900, 580..598);
        part(pixels, 900..1500, 0..900).iter().all(|pixel| *pixel == 0)
            && is_colorful(&part(pixels, PANELS..890, 30..560))
            && status.iter().filter(|pixel| **pixel == 0x001b_1b1b).count() > status.len() / 2
    };
    save(&desktop.settled("a smaller picture", is_small), "small");

    desktop.close(window);
    let start = Instant::now();
    let mut ended = None;
    while ended.is_none() && start.elapsed() < PATIENCE {
        std::thread::sleep(Duration::from_millis(50));
        ended = desktop.viewer.0.try_wait().unwrap();
    }
    assert!(ended.unwrap().success());
    let said = std::fs::read_to_string(said).unwrap();
    // Drivers' loaders may say more.
    assert_eq!(said.lines().filter(|line| line.starts_with("no graphics driver")).count(), 1, "{said}");
}
