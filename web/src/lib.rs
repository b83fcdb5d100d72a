//! ripstop for a page of a browser: a case goes in, the report and the history of the velocity come out.
//!
//! It computes by WebGPU where the page asks for that, else on the processor in single precision: WebAssembly has no fused multiply-add,
//! without which double precision takes many times as long.
#![cfg(target_family = "wasm")]

use std::sync::atomic::AtomicBool;

use ripstop::gpu::device::{Device, choose, find_adapters};
use ripstop::output::report::report;
use ripstop::output::{self, Animation};
use ripstop::run::{Observer, Options, Precision, Progress, View, run_here};
use ripstop::{DeviceError, case};
use wasm_bindgen::prelude::*;
use web_time::Instant;

#[wasm_bindgen]
extern "C" {
    /// Shows how far a run is: time and end [µs], velocity [m/s].
    #[wasm_bindgen(js_name = showProgress)]
    fn show_progress(time: f64, end: f64, velocity: f64);
    /// Says why the program ends where it should not.
    #[wasm_bindgen(js_name = showPanic)]
    fn show_panic(text: String);
}

/// Results of a shot.
#[wasm_bindgen(getter_with_clone)]
pub struct Shot {
    /// The page `report.html`.
    pub report: String,
    /// `summary.json`
    pub summary: String,
    /// Times of the history [µs].
    pub time: Vec<f64>,
    /// Velocity of the projectile at these [m/s].
    pub velocity: Vec<f64>,
}

/// Follows a run: its progress, and what its report plays back.
struct Follower {
    animation: Animation,
}

impl Observer for Follower {
    fn on_progress(&mut self, at: &Progress) {
        show_progress(at.time * 1e6, at.end_time * 1e6, at.velocity);
    }

    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.animation.snapshot_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        self.animation.on_snapshot(view);
    }

    fn on_end(&mut self, view: &View<'_>) {
        self.animation.on_end(view);
    }
}

/// Runs a case. `gpu`: by WebGPU.
///
/// # Errors
/// A case that is refused; no WebGPU.
#[wasm_bindgen]
pub async fn run(text: String, gpu: bool) -> Result<Shot, JsError> {
    std::panic::set_hook(Box::new(|info| show_panic(info.to_string())));
    let start = Instant::now();
    let case = case::from_str("case.json", &text, &[])?;
    let device = if gpu { Some(open().await?) } else { None };
    let options = Options::default().precision(Precision::F32).device(device.as_ref());
    let mut follower = Follower { animation: Animation::new(&case) };
    let run = run_here(&case, options, &AtomicBool::new(false), &mut follower).await?;
    let summary = output::summary(&case, &run, start.elapsed().as_secs_f64());
    Ok(Shot {
        report: report(&case, &run, &summary, &follower.animation),
        summary: summary.to_string(),
        time: run.history.iter().map(|row| row.time * 1e6).collect(),
        velocity: run.history.iter().map(|row| row.projectile_velocity).collect(),
    })
}

/// The device that the browser gives.
async fn open() -> Result<Device, DeviceError> {
    Device::request(&choose(&find_adapters().await, None)?).await
}
