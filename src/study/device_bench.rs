//! Time of a step on a device: packs of more and more plies and batches of shots, each beside the processor, and the floors of the device.
//!
//! Scenes are the case with other plies and one element per crossover. Nothing is skipped, so that every element counts.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use serde_json::{Value, json};

use super::bench::{Progressed, ReadCase};
use crate::case::CaseError;
use crate::gpu::buffers::Sizes;
use crate::gpu::device::Floors;
use crate::gpu::stepper::DeviceStepper;
use crate::gpu::{Device, DeviceError};
use crate::model::Model;
use crate::run::batch::{DeviceBatch, PreparedShot};
use crate::run::{self, Options, Precision, Progress, Run, RunError, Skips};
use crate::solver::state::State;

/// Plies of the packs.
const PACKS: [u32; 5] = [1, 4, 16, 32, 50];
/// Shots of the batches.
const BATCHES: [usize; 2] = [64, 1000];
/// Even mesh of one element per crossover; parts of a case that would refuse a short run.
const EVEN: [&str; 4] =
    ["/pack/mesh_grading=none", "/pack/elements_per_crossover=1", "/expect=[]", "/output/profile_times_us=[]"];
/// End of a first run: a few steps [µs].
const FIRST: f64 = 0.3;
/// A run is long enough to be timed after this time [s], or after more steps than this.
const SECONDS: f64 = 1.0;
const STEPS: u64 = 1000;
/// Bytes that `sweep` moves for an element in a step, with the ring around a tile; and where strength varies (docs/decisions/15).
const SWEEP_BYTES: [u64; 2] = [106, 115];
/// Steps of a submission whose recording is timed, and submissions.
const HOST: [u64; 2] = [64, 20];

/// Measurements of a device with a case, as `gpu.json` has them: floors, time of the host for a step, scenes, and scenes left out.
///
/// # Errors
/// When the case cannot be run, or the device was lost.
pub fn measure(
    read: ReadCase<'_>,
    device: &Device,
    threads: Option<usize>,
    interrupt: &AtomicBool,
    progressed: Progressed<'_>,
) -> Result<Value, RunError> {
    let floors = Floors::measure(device)?;
    let (mut scenes, mut left_out) = (Vec::new(), Vec::new());
    let base = Options::default().threads(threads).precision(Precision::F32).skips(Skips::NONE);
    for plies in PACKS.into_iter().take_while(|_| !interrupt.load(Ordering::Relaxed)) {
        let sets = changes(plies);
        let name = if plies == 1 { "1 ply".to_owned() } else { format!("{plies} plies") };
        let mut timed = |options: Options<'_>, on: &str| {
            let name = format!("{name}, {on}");
            time(read, &sets, options, interrupt, &mut |at: &Progress| progressed(&name, at))
        };
        let scene = match timed(base.device(Some(device)), "gpu") {
            Ok(timed) => timed,
            Err(RunError::Device(error @ DeviceError::Lost { .. })) => return Err(error.into()),
            Err(error) => {
                left_out.push(json!({ "name": name, "reason": error.to_string() }));
                continue;
            }
        };
        let beside = timed(base, "cpu")?;
        if interrupt.load(Ordering::Relaxed) {
            break; // a run that was cut short says little
        }
        let model = Model::<f32>::new(&read(&sets)?)?;
        let mut row = row(&name, 1, &scene, Some(&beside));
        row["memory_bytes"] = Sizes::new(&model).planned().into();
        let bytes = SWEEP_BYTES[usize::from(model.strength.is_some())];
        let sweep = scene.run.kernel_seconds.iter().find(|(name, _)| *name == "sweep").map(|(_, seconds)| *seconds);
        let moved = (bytes * scene.run.elements as u64 * scene.run.steps) as f64;
        row["sweep_bytes_per_element"] = bytes.into();
        row["sweep_gb_per_s"] = json!(sweep.map(|seconds| 1e-9 * moved / seconds));
        scenes.push(row);
    }
    for shots in BATCHES.into_iter().take_while(|_| !interrupt.load(Ordering::Relaxed)) {
        let name = format!("{shots} shots of 1 ply");
        match fire(read, device, shots, interrupt)? {
            Ok(timed) => scenes.push(row(&name, shots, &timed, None)),
            Err(reason) => left_out.push(json!({ "name": name, "reason": reason })),
        }
    }
    Ok(json!({
        "device": device.name(),
        "copy_gb_per_s": 1e-9 * floors.copy_rate,
        "dispatch_us": 1e6 * floors.dispatch,
        "storage_barrier_us": 1e6 * floors.barriers[0],
        "workgroup_barrier_us": 1e6 * floors.barriers[1],
        "dependent_read_us": 1e6 * floors.dependent_read,
        "host_us_per_step": host(read)?,
        "interrupted": interrupt.load(Ordering::Relaxed),
        "scenes": scenes,
        "left_out": left_out,
    }))
}

/// Changes of a case that make it a pack of this many plies.
fn changes(plies: u32) -> Vec<String> {
    EVEN.map(str::to_owned).into_iter().chain([format!("/pack/plies={plies}")]).collect()
}

/// A run, and the time of one of its steps [s].
struct Timed {
    run: Run,
    step: f64,
}

/// Runs of more and more steps, until one is long enough: the time of a step is that by which the last two differ. So what a run takes to
/// begin, when drivers compile kernels, does not count.
fn time(
    read: ReadCase<'_>,
    sets: &[String],
    options: Options<'_>,
    interrupt: &AtomicBool,
    observer: &mut dyn run::Observer,
) -> Result<Timed, RunError> {
    let (mut end, mut before): (f64, Option<Run>) = (FIRST, None);
    loop {
        let case = read(&[sets, &[format!("/solver/end_time_us={end:?}")]].concat())?;
        let run = run::run(&case, options, interrupt, observer)?;
        let long = run.loop_seconds > SECONDS || run.steps > STEPS || interrupt.load(Ordering::Relaxed);
        if let Some(before) = before.filter(|_| long) {
            let step = (run.loop_seconds - before.loop_seconds) / (run.steps as f64 - before.steps as f64);
            return Ok(Timed { run, step });
        }
        end *= 4.0;
        before = Some(run);
    }
}

/// Shots of one ply in a batch; the run of one of them, with the time of a step of all. Or why there is none.
fn fire(
    read: ReadCase<'_>,
    device: &Device,
    shots: usize,
    interrupt: &AtomicBool,
) -> Result<Result<Timed, String>, RunError> {
    let prepared = |end: f64| -> Result<Vec<PreparedShot>, CaseError> {
        let case = read(&[changes(1), vec![format!("/solver/end_time_us={end:?}")]].concat())?;
        (0..shots).map(|_| PreparedShot::new(case.clone())).collect()
    };
    let short = prepared(FIRST)?;
    let room = short[0].room(device, u64::MAX);
    if room < shots as u64 {
        return Ok(Err(format!("the device has room for {room}")));
    }
    let mut batch = DeviceBatch::new(device, &short[0], shots as u64)?;
    let mut timed = |shots: &[PreparedShot]| -> Result<Result<Timed, String>, DeviceError> {
        let (start, mut last) = (Instant::now(), None);
        batch.fire(shots, interrupt, &mut |_, run| {
            last = Some(run.clone());
            true
        })?;
        let timed = last.map(|run| Timed { step: start.elapsed().as_secs_f64() / run.steps as f64, run });
        Ok(timed.ok_or_else(|| "interrupted".to_owned()))
    };
    // Kernels are compiled in the first, the second says how many steps there is time for.
    timed(&short)?.ok();
    let first = timed(&short)?;
    let times = first.as_ref().map_or(1.0, |first| SECONDS / (first.step * first.run.steps as f64));
    if times < 2.0 {
        return Ok(first);
    }
    Ok(timed(&prepared(FIRST * times.min(STEPS as f64))?)?)
}

/// A scene of `gpu.json`. `beside`: the run on the processor.
fn row(name: &str, shots: usize, timed: &Timed, beside: Option<&Timed>) -> Value {
    let rate = |timed: &Timed| (timed.run.elements * shots) as f64 / timed.step;
    let run = &timed.run;
    let kernel = |(name, seconds): &(&str, f64)| json!({ "name": name, "us": 1e6 * seconds / run.steps as f64 });
    json!({
        "name": name,
        "shots": shots,
        "elements": run.elements * shots,
        "steps": run.steps,
        "step_us": 1e6 * timed.step,
        "element_steps_per_s": rate(timed),
        "kernels": run.kernel_seconds.iter().map(kernel).collect::<Vec<_>>(),
        "cpu": beside.map(|timed| json!({
            "threads": timed.run.threads,
            "precision": timed.run.precision,
            "step_us": 1e6 * timed.step,
            "element_steps_per_s": rate(timed),
        })),
    })
}

/// Time of the host for recording and submitting a step of one ply [µs], on a device that does nothing.
fn host(read: ReadCase<'_>) -> Result<f64, RunError> {
    let case = read(&changes(1))?;
    let model = Model::<f32>::new(&case)?;
    let device = Device::noop();
    let mut stepper = DeviceStepper::new(&device, &model)?;
    stepper.upload(&model, &State::new(&case, &model));
    let [steps, submissions] = HOST;
    let slot = |at: u64| at.is_multiple_of(4).then_some(at as u32 / 4);
    let batch: Vec<_> = (0..steps).map(|at| stepper.whole_step(at, slot(at), 4)).collect();
    stepper.submit(&batch);
    let start = Instant::now();
    (0..submissions).for_each(|_| drop(stepper.submit(&batch)));
    Ok(1e6 * start.elapsed().as_secs_f64() / (steps * submissions) as f64)
}
