//! A Chromium of our own: a process with a fresh profile, and its DevTools protocol.

use std::cell::RefCell;
use std::fs;
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::{Message, WebSocket};

/// Names it goes by.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// No window, no sandbox (tests run as root in containers), no network of its own, WebGL in software.
const FLAGS: [&str; 12] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--remote-debugging-port=0",
];
/// A machine that builds at the same time is slow.
const PATIENCE: Duration = Duration::from_secs(60);

/// A running browser.
pub(crate) struct Chromium {
    process: Child,
    socket: RefCell<WebSocket<TcpStream>>,
    next: RefCell<u64>,
    events: RefCell<Vec<Value>>,
    _profile: TempDir,
}

impl Drop for Chromium {
    fn drop(&mut self) {
        drop(self.process.kill());
        drop(self.process.wait());
    }
}

impl Chromium {
    /// Starts one; `None` where there is none.
    pub(crate) fn start() -> Option<Self> {
        let profile = TempDir::new().unwrap();
        let start = |name: &&str| {
            let mut command = Command::new(name);
            command.args(FLAGS).arg(format!("--user-data-dir={}", profile.path().display())).arg("about:blank");
            // It brings a driver in software of its own, which these would hide.
            command.env_remove("VK_DRIVER_FILES").env_remove("VK_ICD_FILENAMES");
            command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().ok()
        };
        let process = NAMES.iter().find_map(start)?;
        let [port, path] = address(&profile.path().join("DevToolsActivePort"));
        let stream = TcpStream::connect(format!("127.0.0.1:{port}")).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let (socket, _) = tungstenite::client(format!("ws://127.0.0.1:{port}{path}"), stream).unwrap();
        Some(Self {
            process,
            socket: RefCell::new(socket),
            next: RefCell::new(0),
            events: RefCell::default(),
            _profile: profile,
        })
    }

    /// Calls a method, of the browser or of a page, and waits for its answer.
    pub(crate) fn call(&self, session: Option<&str>, method: &str, parameters: &Value) -> Value {
        let id = *self.next.borrow();
        *self.next.borrow_mut() += 1;
        let mut message = json!({ "id": id, "method": method, "params": parameters });
        if let Some(session) = session {
            message["sessionId"] = json!(session);
        }
        self.socket.borrow_mut().send(Message::text(message.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.borrow_mut().read().unwrap() else { continue };
            let answer: Value = serde_json::from_str(&text).unwrap();
            if answer["id"] == json!(id) {
                assert!(answer.get("error").is_none(), "{method}: {answer}");
                return answer["result"].clone();
            }
            self.events.borrow_mut().push(answer);
        }
    }

    /// Everything it said unasked so far.
    pub(crate) fn events(&self) -> Vec<Value> {
        self.events.borrow().clone()
    }
}

/// Port and path of the protocol, once the browser has written them down.
fn address(file: &Path) -> [String; 2] {
    let start = Instant::now();
    loop {
        let text = fs::read_to_string(file).unwrap_or_default();
        if let Some((port, path)) = text.split_once('\n').filter(|(_, path)| !path.is_empty()) {
            return [port.to_owned(), path.trim().to_owned()];
        }
        assert!(start.elapsed() < PATIENCE, "Chromium does not answer");
        thread::sleep(Duration::from_millis(20));
    }
}
