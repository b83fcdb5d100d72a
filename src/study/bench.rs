//! Run time against error: a case run in every way a user may choose, each against one reference.
//!
//! The reference is as good as this program can do: the processor in f64, Courant 0.25, one crossover per element (for which the published
//! failure strain holds), history four times as fine. The choices change one thing at a time from the case as it is.
//!
//! Failure of yarns makes a shot sensitive to anything, so the reference is run a second time with a time step a fifth
//! longer: errors smaller than the difference of the two are scatter and rank nothing.
//!
//! On a device, the time of a step: packs of more and more plies and batches of shots, each beside the processor, and the floors of the
//! device. Scenes are the case with other plies and one element per crossover. Nothing is skipped, so that every element counts.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use serde_json::{Value, json};

use crate::case::{Case, CaseError};
use crate::gpu::buffers::Sizes;
use crate::gpu::device::Floors;
use crate::gpu::stepper::DeviceStepper;
use crate::gpu::{Device, DeviceError};
use crate::model::Model;
use crate::output::{self, csv};
use crate::run::batch::{DeviceBatch, PreparedShot};
use crate::run::{self, Options, Precision, Progress, Run, RunError, Sample, Skips};
use crate::solver::state::State;

/// Description of the reference.
pub const REFERENCE: &str = "CPU, f64, Courant 0.25, one crossover per element everywhere, history four times as fine, otherwise \
                             the case as it is";
/// Names and Courant numbers [-] of the two references.
const REFERENCES: [(&str, f64); 2] = [("reference", 0.25), ("second reference", 0.3)];
/// Rows of the reference's history in one interval of the case's, so that reading between them adds no error.
const REFERENCE_ROWS: f64 = 4.0;
/// Courant numbers to choose from [-], the fastest first.
const COURANT: [f64; 4] = [0.95, 0.9, 0.8, 0.5];
/// Crossovers along each side of an element to choose from.
const MESH: [u32; 3] = [1, 2, 4];
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

/// Reader of the case with changes, each `/pointer=value`.
pub type ReadCase<'a> = &'a dyn Fn(&[String]) -> Result<Case, CaseError>;
/// Listener that hears what runs and where it is.
pub type Progressed<'a> = &'a mut (dyn FnMut(&str, &Progress) + Send);

/// One way to run a case.
#[derive(Clone, Debug, Default)]
struct Configuration {
    /// Difference to the case as it is, in words.
    name: String,
    precision: Precision,
    on_gpu: bool,
    skips: Skips,
    /// Changes of the case.
    sets: Vec<String>,
}

/// The reference, and a second one.
fn references(case: &Case) -> [Configuration; 2] {
    let interval = case.output.history_interval * 1e6 / REFERENCE_ROWS;
    REFERENCES.map(|(name, courant)| Configuration {
        name: name.to_owned(),
        skips: Skips::WHOLE,
        sets: vec![
            format!("/solver/courant={courant}"),
            "/pack/crossovers_per_element=1".to_owned(),
            "/pack/mesh_grading=none".to_owned(),
            format!("/output/history_interval_us={interval:?}"),
        ],
        ..Configuration::default()
    })
}

/// Every configuration for a case: one thing changed at a time.
fn configurations(case: &Case, gpu: bool) -> Vec<Configuration> {
    let (courant, mesh, graded) =
        (case.solver.courant, case.pack.crossovers_per_element, case.pack.mesh.grading.is_some());
    let with = |name: &str, set: &str| {
        let sets = Vec::from_iter((!set.is_empty()).then(|| set.to_owned()));
        Configuration { name: name.to_owned(), sets, ..Configuration::default() }
    };
    let single = Configuration { precision: Precision::F32, ..with("f32", "") };
    let words = if graded { " graded" } else { "" };
    let mut all = vec![with(&format!("default: f64, Courant {courant}, mesh {mesh}{words}"), ""), single.clone()];
    let other = COURANT.into_iter().filter(|value| *value != courant);
    all.extend(other.map(|value| with(&format!("Courant {value}"), &format!("/solver/courant={value}"))));
    let other = MESH.into_iter().filter(|count| *count != mesh);
    all.extend(other.map(|count| with(&format!("mesh {count}"), &format!("/pack/crossovers_per_element={count}"))));
    if graded {
        all.push(with("not graded", "/pack/mesh_grading=none"));
    } else if case.projectile.is_some() {
        all.push(with("graded", "/pack/mesh_grading=graded"));
    }
    all.push(Configuration { skips: Skips::WHOLE, ..with("no symmetry", "") });
    // Without the skip of the time after the outcome it would not be the same run.
    all.push(Configuration { skips: Skips { outcome: true, ..Skips::NONE }, ..with("no skip", "") });
    if gpu {
        all.push(Configuration { name: "gpu f32".to_owned(), on_gpu: true, ..single });
    }
    all
}

/// Cases of the references and of every configuration that can be read, each with what its run skips.
///
/// # Errors
/// When the case itself cannot be read.
pub fn plan(read: ReadCase<'_>, gpu: bool) -> Result<Vec<(Case, Skips)>, CaseError> {
    let base = read(&[])?;
    let all = references(&base).into_iter().chain(configurations(&base, gpu));
    Ok(all.filter_map(|one| Some((read(&one.sets).ok()?, one.skips))).collect())
}

/// Row of `bench.json`: a configuration or the reference, and its run.
fn row(name: &str, sets: &[String], case: &Case, run: &Run) -> Value {
    let divergence = run.divergence.as_ref();
    let unstable = divergence.map(|found| format!("unstable at {}: {}", output::place(found), found.quantity));
    json!({
        "name": name,
        "sets": sets,
        "backend": run.backend,
        "precision": run.precision,
        "courant": case.solver.courant,
        "elements": run.elements,
        "steps": run.steps,
        "loop_s": run.loop_seconds,
        "element_steps_per_s": run.elements as f64 * run.steps as f64 / run.loop_seconds,
        "outcome": run.outcome.word(),
        "energy_error": run.energy_error,
        "failed": unstable.or_else(|| run.lost.clone()),
    })
}

/// Runs the reference and every configuration, the graphics processor of `on` among them: what `bench.json` has of a case.
///
/// # Errors
/// When the reference is refused or does not start. A configuration that does not is left out with the reason.
pub fn measure(
    read: ReadCase<'_>,
    on: Options<'_>,
    interrupt: &AtomicBool,
    progressed: Progressed<'_>,
) -> Result<Value, RunError> {
    let base = read(&[])?;
    let mut shoot = |one: &Configuration, case: &Case| {
        let options = Options::default().threads(on.threads).precision(one.precision).skips(one.skips);
        let options = options.device(on.device.filter(|_| one.on_gpu));
        run::run(case, options, interrupt, &mut |at: &Progress| progressed(&one.name, at))
    };
    let [first, second] = references(&base);
    let case = read(&first.sets)?;
    let reference = shoot(&first, &case)?;
    let mut reference_row = row(REFERENCE, &first.sets, &case, &reference);
    let (mut choices, mut skipped) = (Vec::new(), Vec::new());
    let error = |run: &Run| velocity_error(&reference.history, &run.history).map(|error| error * 100.0);
    let is_whole = |run: &Run| run.divergence.is_none() && run.lost.is_none();
    if is_whole(&reference) && !reference.interrupted {
        let second = shoot(&second, &read(&second.sets)?)?;
        reference_row["scatter_percent"] = json!(error(&second).filter(|_| is_whole(&second)));
        for one in configurations(&base, on.device.is_some()) {
            if interrupt.load(Ordering::Relaxed) {
                break;
            }
            let refused =
                |error: CaseError| format!("{}: expected {}, found {}", error.location, error.expected, error.found);
            let done = read(&one.sets).map_err(refused).and_then(|case| {
                if crossovers(&base) != crossovers(&case) {
                    let each = case.pack.crossovers_per_element;
                    return Err(format!("the crossovers along warp or weft do not divide by {each}"));
                }
                let run = shoot(&one, &case).map_err(|error| error.to_string())?;
                Ok((row(&one.name, &one.sets, &case, &run), run))
            });
            match done {
                // An interrupted run says nothing about time or error.
                Ok((_, run)) if run.interrupted => {}
                Ok((mut row, run)) => {
                    row["velocity_error_percent"] = json!(error(&run).filter(|_| is_whole(&run)));
                    row["same_outcome"] = json!(is_whole(&run) && run.outcome == reference.outcome);
                    choices.push(row);
                }
                Err(reason) => skipped.push(json!({ "name": one.name, "reason": reason })),
            }
        }
    }
    Ok(json!({
        "case": case.name,
        "title": case.title,
        "interrupted": interrupt.load(Ordering::Relaxed),
        "reference": reference_row,
        "choices": choices,
        "skipped": skipped,
    }))
}

/// Crossovers of every layer along warp and weft: another mesh covers the same cloth where it has as many.
fn crossovers(case: &Case) -> Vec<[usize; 2]> {
    let each = [case.pack.crossovers_per_element, case.pack.elements_per_crossover].map(|count| count as usize);
    let layers = case.layers();
    layers.iter().map(|layer| layer.mesh.count.map(|count| count * each[0] / each[1])).collect()
}

/// Root mean square of the velocity difference over the time that both cover, over the velocity that the reference lost in that time [-];
/// `None` where it lost none, or where there is no common time.
fn velocity_error(reference: &[Sample], run: &[Sample]) -> Option<f64> {
    let at = |history: &[Sample], time: f64| csv::between(history, time, |row| row.projectile_velocity);
    let span = reference.last()?.time.min(run.last()?.time);
    let lost = at(reference, 0.0)? - at(reference, span)?;
    // Trapezoidal in time, over the rows of the run.
    let (mut integral, mut last) = (0.0, None);
    for time in run.iter().map(|row| row.time).filter(|time| *time < span).chain([span]) {
        let square = (at(run, time)? - at(reference, time)?).powi(2);
        if let Some((before, start)) = last {
            integral += 0.5 * (start + square) * (time - before);
        }
        last = Some((time, square));
    }
    (lost > 0.0 && span > 0.0).then(|| (integral / span).sqrt() / lost)
}

/// Measurements of a device with a case, as `gpu.json` has them: floors, time of the host for a step, scenes, and scenes left out.
///
/// # Errors
/// When the case cannot be run, or the device was lost.
pub fn measure_device(
    read: ReadCase<'_>,
    device: &Device,
    threads: Option<usize>,
    interrupt: &AtomicBool,
    progressed: Progressed<'_>,
) -> Result<Value, RunError> {
    let floors = Floors::measure(device)?;
    let (mut scenes, mut left_out) = (Vec::new(), Vec::new());
    let base = Options::default().threads(threads).precision(Precision::F32).skips(Skips::NONE);
    let goes_on = || !interrupt.load(Ordering::Relaxed);
    for plies in PACKS.into_iter().take_while(|_| goes_on()) {
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
        if !goes_on() {
            break; // a run that was cut short says little
        }
        let model = Model::<f32>::new(&read(&sets)?)?;
        let mut row = scene_row(&name, 1, &scene, Some(&beside));
        row["memory_bytes"] = Sizes::new(&model).planned().into();
        let bytes = SWEEP_BYTES[usize::from(model.strength.is_some())];
        let sweep = scene.run.kernel_seconds.iter().find(|(name, _)| *name == "sweep").map(|(_, seconds)| *seconds);
        let moved = (bytes * scene.run.elements as u64 * scene.run.steps) as f64;
        row["sweep_bytes_per_element"] = bytes.into();
        row["sweep_gb_per_s"] = json!(sweep.map(|seconds| 1e-9 * moved / seconds));
        scenes.push(row);
    }
    for shots in BATCHES.into_iter().take_while(|_| goes_on()) {
        let name = format!("{shots} shots of 1 ply");
        match fire(read, device, shots, interrupt)? {
            Ok(timed) => scenes.push(scene_row(&name, shots, &timed, None)),
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
        "interrupted": !goes_on(),
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
    let mut shoot = |end: f64| -> Result<Run, RunError> {
        let case = read(&[sets, &[format!("/solver/end_time_us={end:?}")]].concat())?;
        run::run(&case, options, interrupt, observer)
    };
    let (mut end, mut before) = (4.0 * FIRST, shoot(FIRST)?);
    loop {
        let run = shoot(end)?;
        let interrupted = interrupt.load(Ordering::Relaxed);
        let step = (run.loop_seconds - before.loop_seconds) / (run.steps as f64 - before.steps as f64);
        // Where something else slowed the shorter run down, a longer one tells.
        if interrupted || step > 0.0 && (run.loop_seconds > SECONDS || run.steps > STEPS) {
            return Ok(Timed { run, step });
        }
        (end, before) = (4.0 * end, run);
    }
}

/// Shots of one ply in a batch; the run of one of them, with the time of a step of all. Or why there is none.
fn fire(
    read: ReadCase<'_>,
    device: &Device,
    shots: usize,
    interrupt: &AtomicBool,
) -> Result<Result<Timed, String>, RunError> {
    let prepared = |end: f64| {
        let case = read(&[changes(1), vec![format!("/solver/end_time_us={end:?}")]].concat())?;
        (0..shots).map(|_| PreparedShot::new(case.clone())).collect::<Result<Vec<_>, _>>()
    };
    let short = prepared(FIRST)?;
    let room = short[0].room(device, u64::MAX);
    if room < shots as u64 {
        return Ok(Err(format!("the device has room for {room}")));
    }
    let mut batch = DeviceBatch::new(device, &short[0], shots as u64)?;
    let mut timed = |shots: &[PreparedShot]| -> Result<Option<Timed>, DeviceError> {
        let (start, mut last) = (Instant::now(), None);
        batch.fire(shots, interrupt, &mut |_, run| {
            last = Some(run.clone());
            true
        })?;
        Ok(last.map(|run| Timed { step: start.elapsed().as_secs_f64() / run.steps as f64, run }))
    };
    // Kernels are compiled in the first, the second says how many steps there is time for.
    timed(&short)?;
    let first = timed(&short)?;
    let times = first.as_ref().map_or(1.0, |first| SECONDS / (first.step * first.run.steps as f64));
    let last = if times < 2.0 { first } else { timed(&prepared(FIRST * times.min(STEPS as f64))?)? };
    Ok(last.ok_or_else(|| "interrupted".to_owned()))
}

/// A scene of `gpu.json`. `beside`: the run on the processor.
fn scene_row(name: &str, shots: usize, timed: &Timed, beside: Option<&Timed>) -> Value {
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
    // Steps of a submission, and submissions.
    let (steps, submissions) = (64, 20);
    let slot = |at: u64| at.is_multiple_of(4).then_some(at as u32 / 4);
    let batch: Vec<_> = (0..steps).map(|at| stepper.whole_step(at, slot(at), 4)).collect();
    stepper.submit(&batch);
    let start = Instant::now();
    (0..submissions).for_each(|_| drop(stepper.submit(&batch)));
    Ok(1e6 * start.elapsed().as_secs_f64() / (steps * submissions) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A history from 0 to `end` [µs] in steps of `step` [µs] with this velocity [m/s].
    fn history(step: f64, end: f64, velocity: impl Fn(f64) -> f64) -> Vec<Sample> {
        let rows = 0..=(end / step).round() as usize;
        let row = |time: f64| Sample { time: time * 1e-6, projectile_velocity: velocity(time), ..Sample::default() };
        rows.map(|n| row(n as f64 * step)).collect()
    }

    #[test]
    fn the_error_is_the_root_mean_square_over_the_velocity_lost() {
        let is = |found: Option<f64>, error: f64| found.is_some_and(|found| (found - error).abs() < 1e-6);
        // A constant difference; rows of the run that come later do not count.
        let reference = history(0.5, 10.0, |t| 100.0 - 2.0 * t);
        assert!(is(velocity_error(&reference, &history(0.7, 14.0, |t| 101.0 - 2.0 * t)), 1.0 / 20.0));
        // √(∫ (0.1 t)² dt / 10) = 1/√3 of 10, whichever of the two is faster.
        let reference = history(0.25, 10.0, |t| 50.0 - t);
        for slope in [1.1, 0.9] {
            assert!(is(velocity_error(&reference, &history(0.01, 10.0, |t| 50.0 - slope * t)), 0.1 / 3.0_f64.sqrt()));
        }
        assert!(is(velocity_error(&reference, &reference), 0.0));
        let flight = history(0.5, 10.0, |_| 100.0);
        assert_eq!([&flight[..], &[], &flight[..1]].map(|run| velocity_error(&flight, run)), [None; 3]);
    }
}
