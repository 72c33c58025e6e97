//! Chromium, driven over its own protocol: JSON over a WebSocket (<https://chromedevtools.github.io/devtools-protocol/>).

use serde_json::{Value, json};
use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(60);

/// Names of the program.
const PROGRAMS: [&str; 4] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
];

/// A browser with one page.
pub struct Browser {
    child: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    session: String,
    last: u64,
    /// Errors that the page has written to the console or has not caught.
    pub errors: Vec<String>,
    _profile: tempfile::TempDir,
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Browser {
    /// Starts it without a window, with an empty page of `size` pixels.
    ///
    /// # Errors
    /// If there is none.
    pub fn start(size: [u32; 2]) -> Result<Browser, String> {
        let profile = tempfile::tempdir().map_err(|e| e.to_string())?;
        let start = |program: &str| {
            Command::new(program)
                .args([
                    "--headless=new",
                    "--no-sandbox",
                    "--disable-dev-shm-usage",
                    "--hide-scrollbars",
                ])
                .args([
                    "--use-gl=angle",
                    "--use-angle=swiftshader",
                    "--enable-unsafe-swiftshader",
                ])
                .args([
                    "--remote-debugging-port=0",
                    "--no-first-run",
                    "--disable-extensions",
                ])
                .arg(format!("--user-data-dir={}", profile.path().display()))
                .arg("about:blank")
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
        };
        let child = PROGRAMS.iter().find_map(|p| start(p).ok());
        let mut child = child.ok_or("there is no Chromium (Debian: apt-get install chromium)")?;
        let address = address(&mut child);
        let socket = address.and_then(|a| tungstenite::connect(a).map_err(|e| e.to_string()));
        let socket = match socket {
            Ok((socket, _)) => socket,
            Err(error) => {
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("Chromium does not start: {error}"));
            }
        };
        if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
            stream
                .set_read_timeout(Some(PATIENCE))
                .map_err(|e| e.to_string())?;
        }
        let mut browser = Browser {
            child,
            socket,
            session: String::new(),
            last: 0,
            errors: Vec::new(),
            _profile: profile,
        };
        let target = browser.call("Target.createTarget", json!({"url": "about:blank"}));
        let target = json!({"targetId": target["targetId"], "flatten": true});
        let session = browser.call("Target.attachToTarget", target);
        browser.session = session["sessionId"].as_str().expect("a session").to_owned();
        for domain in ["Runtime", "Log", "Page"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        let [width, height] = size;
        let metrics =
            json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": false});
        browser.call("Emulation.setDeviceMetricsOverride", metrics);
        Ok(browser)
    }

    /// Sends a message and waits for its answer.
    fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let id = self.last;
        let mut message = json!({"id": id, "method": method, "params": parameters});
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        let text = Message::text(message.to_string());
        self.socket.send(text).expect("Chromium listens");
        loop {
            let Message::Text(text) = self.socket.read().expect("Chromium answers") else {
                continue;
            };
            let mut found: Value = serde_json::from_str(&text).expect("JSON");
            self.note(&found);
            if found["id"] == id {
                assert!(found["error"].is_null(), "{method}: {}", found["error"]);
                return found["result"].take();
            }
        }
    }

    /// Keeps what is an error.
    fn note(&mut self, event: &Value) {
        let parameters = &event["params"];
        let is_error = match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => true,
            Some("Runtime.consoleAPICalled") => {
                parameters["type"] == "error" || parameters["type"] == "assert"
            }
            Some("Log.entryAdded") => parameters["entry"]["level"] == "error",
            _ => false,
        };
        if is_error {
            self.errors.push(parameters.to_string());
        }
    }

    /// Opens a file, behind whose address stands `fragment`.
    pub fn open(&mut self, file: &Path, fragment: &str) {
        // A change of what stands behind # alone would load nothing.
        self.call("Page.navigate", json!({"url": "about:blank"}));
        let path = file.canonicalize().expect("a file");
        let url = format!("file://{}{fragment}", path.display());
        self.call("Page.navigate", json!({"url": url}));
        self.wait("location.protocol === 'file:' && window.halflight !== undefined");
    }

    /// The value of an expression of JavaScript.
    pub fn value(&mut self, expression: &str) -> Value {
        let request =
            json!({"expression": expression, "awaitPromise": true, "returnByValue": true});
        let found = self.call("Runtime.evaluate", request);
        let wrong = &found["exceptionDetails"];
        assert!(wrong.is_null(), "{expression}: {wrong}");
        found["result"]["value"].clone()
    }

    /// Waits until an expression is true.
    pub fn wait(&mut self, expression: &str) {
        let start = Instant::now();
        while self.value(expression) != true {
            assert!(
                start.elapsed() < PATIENCE,
                "{expression}: never true; {:?}",
                self.errors
            );
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Two frames later, when everything is drawn.
    pub fn settle(&mut self) {
        self.value(
            "new Promise(r => requestAnimationFrame(() => requestAnimationFrame(() => r(true))))",
        );
    }

    /// Presses a key.
    pub fn key(&mut self, key: &str) {
        let mut down = json!({"type": "keyDown", "key": key});
        if key.chars().count() == 1 {
            down["text"] = json!(key);
        }
        self.call("Input.dispatchKeyEvent", down);
        self.call(
            "Input.dispatchKeyEvent",
            json!({"type": "keyUp", "key": key}),
        );
    }

    /// Writes text where the focus is.
    pub fn write(&mut self, text: &str) {
        self.call("Input.insertText", json!({"text": text}));
    }

    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], buttons: u32) {
        let event = json!({"type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1});
        self.call("Input.dispatchMouseEvent", event);
    }

    /// Presses the left button at one place and lets it go at another.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        self.mouse("mousePressed", from, 1);
        self.mouse("mouseMoved", to, 1);
        self.mouse("mouseReleased", to, 0);
    }

    /// Clicks.
    pub fn click(&mut self, at: [f64; 2]) {
        self.drag(at, at);
    }

    /// The middle of the element that a selector finds.
    pub fn middle(&mut self, selector: &str) -> [f64; 2] {
        let script = format!(
            "(() => {{ const b = document.querySelector({}).getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; }})()",
            json!(selector)
        );
        let found = self.value(&script);
        [0, 1].map(|i| found[i].as_f64().expect("a place"))
    }

    /// What an element looks like.
    pub fn picture(&mut self, selector: &str) -> image::RgbImage {
        self.settle();
        let script = format!(
            "(() => {{ const b = document.querySelector({}).getBoundingClientRect(); return {{x: b.x, y: b.y, width: b.width, height: b.height, scale: 1}}; }})()",
            json!(selector)
        );
        let clip = self.value(&script);
        let shot = self.call(
            "Page.captureScreenshot",
            json!({"format": "png", "clip": clip}),
        );
        use base64::Engine;
        let bytes = base64::engine::general_purpose::STANDARD
            .decode(shot["data"].as_str().expect("a picture"));
        image::load_from_memory(&bytes.expect("base64"))
            .expect("a PNG")
            .to_rgb8()
    }
}

/// Where the browser listens, which it writes to its standard error.
fn address(child: &mut Child) -> Result<String, String> {
    let stream = child.stderr.take().ok_or("no standard error")?;
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || {
        // Reads on after the address, or the browser would wait for room in the pipe.
        for line in BufReader::new(stream).lines().map_while(Result::ok) {
            if let Some(address) = line.strip_prefix("DevTools listening on ") {
                let _ = sender.send(address.trim().to_owned());
            }
        }
    });
    receiver
        .recv_timeout(PATIENCE)
        .map_err(|_| "it says no address".to_owned())
}
