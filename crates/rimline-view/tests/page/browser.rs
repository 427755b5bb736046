//! Chromium without a window, steered by its protocol for debuggers over two pipes. Over pipes a message ends with a zero byte, so no
//! crate for sockets of the web is needed.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread::{self, sleep};
use std::time::{Duration, Instant};

pub(crate) use rimline_testkit::on_gpu::text as say;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::server;

/// A software driver on a busy machine compiles for long.
pub(crate) const PATIENCE: Duration = Duration::from_secs(400);

/// WebGPU by software, and Vulkan for what puts the page together: it must show what WebGPU drew.
const FLAGS: [&str; 14] = [
    "--headless",
    "--no-sandbox",
    "--enable-unsafe-webgpu",
    "--enable-unsafe-swiftshader",
    "--use-webgpu-adapter=swiftshader",
    "--use-angle=swiftshader",
    "--ignore-gpu-blocklist",
    "--enable-gpu",
    "--enable-features=Vulkan",
    "--use-vulkan=swiftshader",
    "--remote-debugging-pipe",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-dev-shm-usage",
];

/// Width and height of the page.
pub(crate) const SIZE: [u32; 2] = [900, 700];

/// A browser with one page.
pub(crate) struct Browser {
    child: Child,
    display: Child,
    input: ChildStdin,
    messages: Receiver<Value>,
    session: Option<String>,
    last: u64,
    /// Errors that the page wrote to its console.
    errors: Vec<String>,
    folder: TempDir,
}

/// Starts a display without a screen, without which the browser has no Vulkan.
fn display() -> Result<(Child, String), String> {
    let mut command = Command::new("Xvfb");
    command.args(["-displayfd", "1", "-screen", "0", "1000x800x24", "-nolisten", "tcp"]);
    let server = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
    let server = server.map_err(|error| format!("Xvfb cannot be started: {error}; `cargo xtask test` installs it"));
    let mut server = server?;
    let mut number = String::new();
    BufReader::new(server.stdout.take().ok_or("Xvfb says nothing")?).read_line(&mut number).map_err(say)?;
    Ok((server, format!(":{}", number.trim())))
}

impl Browser {
    /// Opens the page that `RIMLINE_PAGE` names, at an address with this query.
    pub(crate) fn open(query: &str) -> Result<Self, String> {
        Self::open_after(query, "")
    }

    /// The same after a script of the page's own.
    pub(crate) fn open_after(query: &str, script: &str) -> Result<Self, String> {
        let page = PathBuf::from(std::env::var_os("RIMLINE_PAGE").ok_or("RIMLINE_PAGE is not set")?);
        let program = std::env::var_os("CHROMIUM").unwrap_or_else(|| "chromium".into());
        let folder = tempfile::tempdir().map_err(say)?;
        let (display, name) = display()?;
        let mut command = Command::new("sh");
        // The browser reads from descriptor 3 and writes to 4.
        command.args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null"]).arg(program).args(FLAGS);
        command.arg(format!("--user-data-dir={}", folder.path().join("profile").display()));
        command.env("DISPLAY", name).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().map_err(say)?;
        let (Some(input), Some(output)) = (child.stdin.take(), child.stdout.take()) else {
            return Err("no pipes to the browser".into());
        };
        let (sender, messages) = channel();
        thread::spawn(move || {
            let parsed = BufReader::new(output).split(0).map_while(Result::ok);
            for message in parsed.filter_map(|bytes| serde_json::from_slice(&bytes).ok()) {
                // Nobody hears what comes after the end.
                let _ = sender.send(message);
            }
        });
        let mut browser = Self { child, display, input, messages, session: None, last: 0, errors: Vec::new(), folder };
        browser.start(&format!("{}{query}", server::serve(page)?), script)?;
        Ok(browser)
    }

    fn start(&mut self, address: &str, script: &str) -> Result<(), String> {
        let downloads = self.folder.path().to_owned();
        self.call("Browser.setDownloadBehavior", &json!({ "behavior": "allow", "downloadPath": downloads }))?;
        let target = self.call("Target.createTarget", &json!({ "url": "about:blank" }))?;
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        self.session = self.call("Target.attachToTarget", &attach)?["sessionId"].as_str().map(str::to_owned);
        for domain in ["Runtime", "Log", "Page", "DOM"] {
            self.call(&format!("{domain}.enable"), &json!({}))?;
        }
        let [width, height] = SIZE;
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", &size)?;
        self.call("Page.addScriptToEvaluateOnNewDocument", &json!({ "source": script }))?;
        self.call("Page.navigate", &json!({ "url": address }))?;
        Ok(())
    }

    /// A folder for files of the test, where downloads go, too.
    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Calls a method of the protocol, and returns its result.
    pub(crate) fn call(&mut self, method: &str, parameters: &Value) -> Result<Value, String> {
        self.last += 1;
        let mut message = json!({ "id": self.last, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.input.write_all(format!("{message}\0").as_bytes()).map_err(say)?;
        self.input.flush().map_err(say)?;
        loop {
            let message = self.messages.recv_timeout(PATIENCE).map_err(|error| format!("{method}: {error}"))?;
            if message["id"] == self.last {
                let error = message.get("error").map(|error| format!("{method}: {error}"));
                return error.map_or_else(|| Ok(message["result"].clone()), Err);
            }
            self.hear(&message);
        }
    }

    /// Keeps what the page complains about.
    fn hear(&mut self, message: &Value) {
        let parameters = &message["params"];
        let is_error = match message["method"].as_str() {
            Some("Runtime.exceptionThrown") => true,
            Some("Runtime.consoleAPICalled") => ["error", "assert"].iter().any(|kind| parameters["type"] == *kind),
            Some("Log.entryAdded") => parameters["entry"]["level"] == "error",
            _ => false,
        };
        if is_error {
            self.errors.push(parameters.to_string());
        }
    }

    /// Fails if the page has written an error to its console.
    pub(crate) fn expect_no_errors(&mut self) -> Result<(), String> {
        self.evaluate("0")?;
        if self.errors.is_empty() { Ok(()) } else { Err(self.errors.join("\n")) }
    }

    /// The value of an expression of JavaScript in the page.
    pub(crate) fn evaluate(&mut self, expression: &str) -> Result<Value, String> {
        let parameters = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        Ok(self.call("Runtime.evaluate", &parameters)?["result"]["value"].clone())
    }

    /// The text of an element.
    pub(crate) fn text(&mut self, id: &str) -> Result<String, String> {
        let text = self.evaluate(&format!("document.getElementById('{id}')?.textContent ?? ''"))?;
        Ok(text.as_str().unwrap_or_default().to_owned())
    }

    /// Waits until the text of an element fulfils a condition, and returns it. Ends where the page gave up.
    pub(crate) fn wait_for(&mut self, id: &str, is_there: impl Fn(&str) -> bool) -> Result<String, String> {
        let until = Instant::now() + PATIENCE;
        loop {
            let given_up = self.text("why")? + &self.text("reason")?;
            let text = self.text(id)?;
            if is_there(&text) {
                return Ok(text);
            }
            if !given_up.is_empty() || Instant::now() > until {
                return Err(format!("`{id}` says `{text}`; {given_up}; {}", self.errors.join("; ")));
            }
            sleep(Duration::from_millis(100));
        }
    }

    /// Presses a key, by its name and the text that it types.
    pub(crate) fn press(&mut self, key: &str) -> Result<(), String> {
        for kind in ["keyDown", "keyUp"] {
            self.call("Input.dispatchKeyEvent", &json!({ "type": kind, "key": key }))?;
        }
        Ok(())
    }

    /// Drags with the left button.
    pub(crate) fn drag(&mut self, from: [f32; 2], to: [f32; 2]) -> Result<(), String> {
        let mut mouse = |kind: &str, [x, y]: [f32; 2], buttons: u32| {
            let parameters =
                json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": buttons, "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", &parameters)
        };
        mouse("mouseMoved", from, 0)?;
        mouse("mousePressed", from, 1)?;
        for step in 1..=4 {
            let part = step as f32 / 4.0;
            mouse("mouseMoved", [0, 1].map(|axis| (from[axis] + part * (to[axis] - from[axis])).round()), 1)?;
        }
        mouse("mouseReleased", to, 0)?;
        Ok(())
    }

    /// Drops files onto the page.
    pub(crate) fn drop_files(&mut self, files: &[&Path]) -> Result<(), String> {
        let data = json!({ "items": [], "files": files, "dragOperationsMask": 1 });
        for kind in ["dragEnter", "dragOver", "drop"] {
            self.call("Input.dispatchDragEvent", &json!({ "type": kind, "x": 300, "y": 300, "data": data }))?;
        }
        Ok(())
    }

    /// Chooses a file in the page's dialog.
    pub(crate) fn choose_file(&mut self, file: &Path) -> Result<(), String> {
        let document = self.call("DOM.getDocument", &json!({}))?;
        let query = json!({ "nodeId": document["root"]["nodeId"], "selector": "#files" });
        let node = self.call("DOM.querySelector", &query)?;
        self.call("DOM.setFileInputFiles", &json!({ "files": [file], "nodeId": node["nodeId"] }))?;
        Ok(())
    }

    /// A file that the page gives to download, once it is whole.
    pub(crate) fn downloaded(&mut self, name: &str) -> Result<Vec<u8>, String> {
        let (path, until) = (self.folder.path().join(name), Instant::now() + PATIENCE);
        while !path.exists() {
            if Instant::now() > until {
                return Err(format!("no {name} was downloaded; the page says `{}`", self.text("said")?));
            }
            sleep(Duration::from_millis(100));
        }
        fs::read(path).map_err(say)
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // It may have ended already.
        for child in [&mut self.child, &mut self.display] {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
