//! A shot whose report is looked at, and a page that shows it.

use std::fs;
use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;
use std::thread;
use std::time::{Duration, Instant};

use base64::Engine;
use serde_json::{Value, json};
use tempfile::TempDir;

use super::chromium::Chromium;

/// A folder with the results of a run.
pub(crate) struct Shot {
    folder: TempDir,
}

impl Shot {
    /// The shot that most checks look at: 24 × 24 elements, 600 m/s.
    pub(crate) fn small() -> &'static Self {
        static SHOT: OnceLock<Shot> = OnceLock::new();
        SHOT.get_or_init(|| Self::new("a small shot"))
    }

    /// The same under another title.
    pub(crate) fn new(title: &str) -> Self {
        let folder = TempDir::new().unwrap();
        let case = json!({
            "title": title,
            "fabric": {"file": "fabrics/s-720.json"},
            "pack": {"width_mm": 30, "height_mm": 30},
            "projectile": {"shape": "cylinder", "diameter_mm": 5.5, "length_mm": 12, "mass_g": 3, "velocity_m_s": 600},
            "solver": {"end_time_us": 20},
        });
        fs::write(folder.path().join("shot.json"), case.to_string()).unwrap();
        fs::create_dir(folder.path().join("fabrics")).unwrap();
        fs::write(folder.path().join("fabrics/s-720.json"), include_str!("../../cases/fabrics/s-720.json")).unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_ripstop"));
        command.current_dir(folder.path()).args(["run", "shot.json", "--backend", "cpu", "--quiet", "--out", "out"]);
        assert!(command.status().unwrap().success());
        Self { folder }
    }

    fn page(&self) -> PathBuf {
        self.folder.path().join("out/report.html")
    }
}

/// A page of the browser.
pub(crate) struct Page<'a> {
    chromium: &'a Chromium,
    session: String,
    target: Value,
}

impl Drop for Page<'_> {
    fn drop(&mut self) {
        self.chromium.call(None, "Target.closeTarget", &json!({ "targetId": self.target }));
    }
}

impl<'a> Page<'a> {
    /// Opens a report. `first`: script that runs before any of the page's own.
    pub(crate) fn open(chromium: &'a Chromium, shot: &Shot, first: &str) -> Self {
        let page = Self::blank(chromium, first);
        page.call("Page.navigate", json!({ "url": format!("file://{}", shot.page().display()) }));
        page.wait("document.readyState == 'complete' && document.documentElement.dataset.playback");
        page
    }

    fn blank(chromium: &'a Chromium, first: &str) -> Self {
        let target = chromium.call(None, "Target.createTarget", &json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session = chromium.call(None, "Target.attachToTarget", &attach);
        let session = session["sessionId"].as_str().unwrap().to_owned();
        let page = Self { chromium, session, target: target["targetId"].clone() };
        for domain in ["Page", "Runtime", "Log", "Network"] {
            page.call(&format!("{domain}.enable"), json!({}));
        }
        page.call("Page.addScriptToEvaluateOnNewDocument", json!({ "source": first }));
        page.window(1200, 900);
        page
    }

    pub(crate) fn call(&self, method: &str, parameters: Value) -> Value {
        self.chromium.call(Some(&self.session), method, &parameters)
    }

    /// Value of a script.
    pub(crate) fn value(&self, script: &str) -> Value {
        let asked = json!({ "expression": script, "awaitPromise": true, "returnByValue": true });
        let answer = self.call("Runtime.evaluate", asked);
        assert!(answer.get("exceptionDetails").is_none(), "{script}: {answer}");
        answer["result"]["value"].clone()
    }

    pub(crate) fn number(&self, script: &str) -> f64 {
        self.value(script).as_f64().unwrap_or_else(|| panic!("{script} is no number"))
    }

    pub(crate) fn text(&self, script: &str) -> String {
        self.value(script).as_str().unwrap_or_else(|| panic!("{script} is no text")).to_owned()
    }

    /// Waits until a script gives something true.
    pub(crate) fn wait(&self, script: &str) {
        let start = Instant::now();
        while !self.value(&format!("Boolean({script})")).as_bool().unwrap() {
            assert!(start.elapsed() < Duration::from_secs(60), "{script} does not come true");
            thread::sleep(Duration::from_millis(20));
        }
    }

    /// Size of the window in pixels.
    pub(crate) fn window(&self, width: u32, height: u32) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600 });
        self.call("Emulation.setDeviceMetricsOverride", size);
    }

    /// Medium (screen or print) and colour scheme.
    pub(crate) fn media(&self, media: &str, scheme: &str) {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        self.call("Emulation.setEmulatedMedia", json!({ "media": media, "features": features }));
    }

    /// Presses and lets go of a key, as a user would.
    pub(crate) fn press(&self, key: &str) {
        let code = match key {
            " " => 32,
            "Tab" => 9,
            "Home" => 36,
            "ArrowLeft" => 37,
            "ArrowRight" => 39,
            _ => 0,
        };
        let mut event = json!({ "type": "keyDown", "key": key, "windowsVirtualKeyCode": code });
        if key.chars().count() == 1 {
            event["text"] = json!(key);
        }
        self.call("Input.dispatchKeyEvent", event.clone());
        event["type"] = json!("keyUp");
        self.call("Input.dispatchKeyEvent", event);
    }

    /// What the canvas shows after the next picture, as text.
    pub(crate) fn pixels(&self) -> String {
        self.text(
            "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(scene.toDataURL()))))",
        )
    }

    /// What a page must not do: errors, warnings, anything asked of a network.
    pub(crate) fn complaints(&self) -> Vec<Value> {
        let asks = |event: &Value| {
            let url = event["params"]["request"]["url"].as_str().unwrap_or_default();
            !["file:", "data:", "about:"].iter().any(|own| url.starts_with(own))
        };
        let is_bad = |event: &Value| match event["method"].as_str().unwrap_or_default() {
            "Runtime.consoleAPICalled" | "Runtime.exceptionThrown" => true,
            // A driver in software warns that it is slow.
            "Log.entryAdded" => event["params"]["entry"]["source"] != "rendering",
            "Network.requestWillBeSent" => asks(event),
            _ => false,
        };
        let own = |event: &Value| event["sessionId"] == json!(self.session);
        self.chromium.events().into_iter().filter(|event| own(event) && is_bad(event)).collect()
    }

    /// Leaves a picture of the whole page, where pictures are wanted.
    pub(crate) fn picture(&self, name: &str) {
        let Ok(folder) = std::env::var("RIPSTOP_SCREENSHOTS") else { return };
        let taken = self.call("Page.captureScreenshot", json!({ "captureBeyondViewport": true }));
        keep(&folder, name, taken["data"].as_str().unwrap());
    }

    /// Prints the page; gives the number of ply types.
    pub(crate) fn print(&self) -> usize {
        let printed = self.call("Page.printToPDF", json!({ "preferCSSPageSize": true }));
        let pdf = printed["data"].as_str().unwrap();
        if let Ok(folder) = std::env::var("RIPSTOP_SCREENSHOTS") {
            keep(&folder, "print.pdf", pdf);
        }
        let bytes = base64::prelude::BASE64_STANDARD.decode(pdf).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        text.matches("/Type /Page").count() - text.matches("/Type /Pages").count()
    }
}

fn keep(folder: &str, name: &str, base64: &str) {
    fs::create_dir_all(folder).unwrap();
    fs::write(PathBuf::from(folder).join(name), base64::prelude::BASE64_STANDARD.decode(base64).unwrap()).unwrap();
}
