//! A real Chromium, told what to do by its own protocol (CDP).

use anyhow::{Context, Result, bail};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Names under which it may be installed.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// The time after which something that has not come is a failure.
const PATIENCE: Duration = Duration::from_secs(120);

/// The graphics that a browser draws with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Graphics {
    /// WebGPU, by a driver that draws on the processor.
    WebGpu,
    /// WebGL 2 alone, by the same.
    WebGl,
    /// Neither.
    None,
}

impl Graphics {
    /// The kind that a word of the command line names.
    pub(super) fn parse(word: &str) -> Result<Self> {
        match word {
            "webgpu" => Ok(Self::WebGpu),
            "webgl" => Ok(Self::WebGl),
            "none" => Ok(Self::None),
            other => bail!("--graphics {other}: kinds are webgpu, webgl and none"),
        }
    }

    fn flags(self) -> &'static [&'static str] {
        match self {
            Self::WebGpu => &[
                "--use-angle=swiftshader",
                "--enable-unsafe-swiftshader",
                "--enable-unsafe-webgpu",
                "--ignore-gpu-blocklist",
                "--enable-gpu",
                "--enable-features=Vulkan",
                "--use-vulkan=swiftshader",
                "--disable-gpu-watchdog",
            ],
            Self::WebGl => &[
                "--use-angle=swiftshader",
                "--enable-unsafe-swiftshader",
                "--ignore-gpu-blocklist",
                "--disable-gpu-watchdog",
            ],
            Self::None => &["--disable-gpu", "--disable-software-rasterizer"],
        }
    }
}

/// The installed browser, if there is one.
pub(crate) fn installed() -> Option<&'static str> {
    let answers = |name: &&&str| {
        let asked = Command::new(name).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        asked.is_ok_and(|status| status.success())
    };
    NAMES.iter().find(answers).copied()
}

/// A page in a browser.
pub(super) struct Page {
    browser: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    session: String,
    /// Sessions with the workers that live, the newest last.
    workers: Vec<String>,
    commands: u64,
    /// The errors that the page has printed since it was last visited.
    pub(super) complaints: Vec<String>,
    _profile: TempDir,
}

impl Page {
    /// Opens a page of a size.
    pub(super) fn open(graphics: Graphics, [width, height]: [u32; 2]) -> Result<Self> {
        let profile = tempfile::tempdir().context("no folder for a profile")?;
        let program = installed().context("Chromium is not installed")?;
        let mut browser = Command::new(program)
            .args(["--headless=new", "--no-sandbox", "--no-first-run", "--disable-background-networking"])
            .args(["--disable-component-update", "--disable-sync", "--disable-quic", "--remote-debugging-port=0"])
            .arg(format!("--window-size={width},{height}"))
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .args(graphics.flags())
            .arg("about:blank")
            // Without a display it makes pictures of WebGPU in software, too.
            .env_remove("DISPLAY")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .with_context(|| format!("cannot start {program}"))?;
        let address = address(&mut browser)?;
        let (socket, _) = tungstenite::connect(&address).with_context(|| format!("cannot connect to {address}"))?;
        if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
            stream.set_read_timeout(Some(PATIENCE)).context("no time limit")?;
        }
        let (session, workers, complaints) = (String::new(), Vec::new(), Vec::new());
        let mut page = Self { browser, socket, session, workers, commands: 0, complaints, _profile: profile };
        let target = page.command("Target.createTarget", json!({ "url": "about:blank" }))?;
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let attached = page.command("Target.attachToTarget", attach)?;
        page.session = attached["sessionId"].as_str().context("no session")?.into();
        for domain in ["Page.enable", "Runtime.enable", "Log.enable"] {
            page.command(domain, json!({}))?;
        }
        let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        page.command("Emulation.setDeviceMetricsOverride", metrics)?;
        let workers = json!({ "autoAttach": true, "waitForDebuggerOnStart": false, "flatten": true });
        page.command("Target.setAutoAttach", workers)?;
        Ok(page)
    }

    /// Sends a command and waits for its result.
    pub(super) fn command(&mut self, method: &str, parameters: Value) -> Result<Value> {
        let session = self.session.clone();
        self.command_to(&session, method, parameters)
    }

    /// The same, to the page or a worker of it by its session.
    fn command_to(&mut self, session: &str, method: &str, parameters: Value) -> Result<Value> {
        self.commands += 1;
        let mut message = json!({ "id": self.commands, "method": method, "params": parameters });
        if !session.is_empty() {
            message["sessionId"] = json!(session);
        }
        self.socket.send(Message::text(message.to_string())).with_context(|| format!("cannot send {method}"))?;
        loop {
            let text = match self.socket.read().with_context(|| format!("no answer to {method}"))? {
                Message::Text(text) => text,
                _ => continue,
            };
            let mut answer: Value = serde_json::from_str(&text).context("an answer is no JSON")?;
            self.note(&answer);
            if answer["id"] == json!(self.commands) {
                if let Some(error) = answer.get("error") {
                    bail!("{method}: {error}");
                }
                return Ok(answer["result"].take());
            }
        }
    }

    /// Runs something in the page's newest worker.
    pub(super) fn in_worker(&mut self, expression: &str) -> Result<()> {
        let worker = self.workers.last().cloned().context("there is no worker")?;
        let result = self.command_to(&worker, "Runtime.evaluate", json!({ "expression": expression }))?;
        match result.get("exceptionDetails") {
            Some(details) => bail!("{expression} in the worker: {details}"),
            None => Ok(()),
        }
    }

    /// Keeps errors that the page prints, and its workers.
    fn note(&mut self, event: &Value) {
        let parameters = &event["params"];
        match event["method"].as_str() {
            Some("Runtime.consoleAPICalled") if parameters["type"] == "error" => {
                self.complaints.push(parameters["args"].to_string());
            }
            Some("Runtime.exceptionThrown") => self.complaints.push(parameters["exceptionDetails"].to_string()),
            Some("Log.entryAdded") if parameters["entry"]["level"] == "error" => {
                self.complaints.push(parameters["entry"].to_string());
            }
            Some("Target.attachedToTarget") if parameters["targetInfo"]["type"] == "worker" => {
                self.workers.extend(parameters["sessionId"].as_str().map(str::to_owned));
            }
            Some("Target.detachedFromTarget") => {
                self.workers.retain(|worker| parameters["sessionId"] != json!(worker));
            }
            _ => {}
        }
    }

    /// Goes to an address.
    pub(super) fn visit(&mut self, url: &str) -> Result<()> {
        self.complaints.clear();
        self.command("Page.navigate", json!({ "url": url })).map(drop)
    }

    /// The value of an expression, which may be a promise.
    pub(super) fn value(&mut self, expression: &str) -> Result<Value> {
        let parameters = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut result = self.command("Runtime.evaluate", parameters)?;
        if let Some(details) = result.get("exceptionDetails") {
            bail!("{expression}: {details}");
        }
        Ok(result["result"]["value"].take())
    }

    /// Waits until an expression is true: until then it may also fail, where the page is not that far.
    pub(super) fn wait_for(&mut self, expression: &str) -> Result<()> {
        let start = Instant::now();
        while !self.value(expression).is_ok_and(|value| value == json!(true)) {
            if start.elapsed() > PATIENCE {
                let words = self.value("document.getElementById('words')?.textContent ?? ''")?;
                bail!("it never came to be: {expression}; the page says {words}; {:?}", self.complaints);
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        Ok(())
    }

    /// Something that the mouse does: `mousePressed`, `mouseMoved`, `mouseReleased`; the left button is `held` after.
    pub(super) fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], held: bool) -> Result<()> {
        let button = if kind == "mouseMoved" && !held { "none" } else { "left" };
        let parameters = json!({
            "type": kind, "x": x, "y": y, "button": button, "buttons": u8::from(held), "clickCount": 1
        });
        self.command("Input.dispatchMouseEvent", parameters).map(drop)
    }

    /// A click with the left button.
    pub(super) fn click(&mut self, at: [f64; 2]) -> Result<()> {
        self.mouse("mouseMoved", at, false)?;
        self.mouse("mousePressed", at, true)?;
        self.mouse("mouseReleased", at, false)
    }

    /// The wheel turns, by points that the page is to go down.
    pub(super) fn wheel(&mut self, [x, y]: [f64; 2], down: f64) -> Result<()> {
        let parameters = json!({ "type": "mouseWheel", "x": x, "y": y, "deltaX": 0, "deltaY": down });
        self.command("Input.dispatchMouseEvent", parameters).map(drop)
    }

    /// A text is typed.
    pub(super) fn write(&mut self, text: &str) -> Result<()> {
        for letter in text.chars() {
            let parameters = json!({ "type": "char", "text": letter.to_string() });
            self.command("Input.dispatchKeyEvent", parameters)?;
        }
        Ok(())
    }

    /// A key that writes nothing is pressed and released.
    pub(super) fn key(&mut self, key: &str) -> Result<()> {
        for kind in ["rawKeyDown", "keyUp"] {
            self.command("Input.dispatchKeyEvent", json!({ "type": kind, "key": key, "code": key }))?;
        }
        Ok(())
    }

    /// Something that fingers do, which are then at these places: `touchStart`, `touchMove`, `touchEnd`.
    pub(super) fn touch(&mut self, kind: &str, fingers: &[[f64; 2]]) -> Result<()> {
        let point = |(id, [x, y]): (usize, &[f64; 2])| json!({ "x": x, "y": y, "id": id });
        let points: Vec<Value> = fingers.iter().enumerate().map(point).collect();
        self.command("Input.dispatchTouchEvent", json!({ "type": kind, "touchPoints": points })).map(drop)
    }

    /// A picture of the page, as it is on the screen: a PNG file.
    pub(super) fn screenshot(&mut self) -> Result<Vec<u8>> {
        use base64::Engine;
        let shot = self.command("Page.captureScreenshot", json!({ "format": "png" }))?;
        let data = shot["data"].as_str().context("no picture")?;
        base64::engine::general_purpose::STANDARD.decode(data).context("no picture")
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        // The browser may have gone by itself.
        let _ = self.browser.kill();
        let _ = self.browser.wait();
    }
}

/// Where a browser listens, as it prints when it starts.
fn address(browser: &mut Child) -> Result<String> {
    let printed = BufReader::new(browser.stderr.take().context("its messages are not read")?);
    let mut lines = printed.lines();
    let mut seen = Vec::new();
    for line in lines.by_ref() {
        let line = line.context("its messages cannot be read")?;
        if let Some((_, address)) = line.split_once("DevTools listening on ") {
            let address = address.trim().to_owned();
            // Who does not read on stops it.
            std::thread::spawn(move || lines.for_each(drop));
            return Ok(address);
        }
        seen.push(line);
    }
    bail!("it does not start: {}", seen.join("\n"))
}
