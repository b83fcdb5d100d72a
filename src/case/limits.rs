//! Limits on the fields of a case together: times within the run, mesh, number of steps, memory.

use super::error::{CaseError, number_text, short_number_text};
use super::{Case, Layer};

/// More steps than this are a mistake in the units of the case.
const MAX_STEPS: f64 = 1e9;
/// Elements are counted in 32 bits on the GPU.
const MAX_ELEMENTS: f64 = 2_147_483_648.0;
/// State and forces of one element with its node [bytes].
const ELEMENT_BYTES: f64 = 400.0;
/// Memory of contact between plies for one node [bytes].
const CONTACT_BYTES: f64 = 350.0;
/// Memory for making and compressing a frame, of one element with its node [bytes].
const FRAME_BYTES: usize = 400;
/// Memory of a frame that waits to be written, of one element with its node [bytes].
const SNAPSHOT_BYTES: usize = 80;
/// Memory that frames in the making may take, and those that wait [bytes]; one may always be made, and two wait.
const FRAMES_BYTES: usize = 128 << 20;
/// One row of the history [bytes].
const ROW_BYTES: f64 = 200.0;

/// Columns and rows nearest to a size [m], from the length of an element along each direction [m], in whole multiples of `fine`;
/// `pointer` is what has that size.
pub(super) fn mesh(pointer: &str, size: [f64; 2], element: [f64; 2], fine: f64) -> Result<[usize; 2], CaseError> {
    let [columns, rows] = [0, 1].map(|i| fine * (size[i] / (fine * element[i])).round().max(1.0));
    if columns * rows > MAX_ELEMENTS {
        let expected = format!("at most {MAX_ELEMENTS:.2e} elements in a ply");
        let found = format!("{columns} × {rows} elements");
        return Err(CaseError::at(pointer, expected, found).help(SMALLER));
    }
    Ok([columns as usize, rows as usize])
}

const SMALLER: &str = "reduce width_mm and height_mm, or raise crossovers_per_element";

/// Refuses what cannot be run: too many elements or steps, too much memory.
pub(super) fn check(case: &Case) -> Result<(), CaseError> {
    elements(case)?;
    steps(case)?;
    memory(memory_needed(case), memory_available())
}

/// Leaves out what would come after the end of the run, and notes it in the case.
pub(super) fn fit(case: &mut Case) {
    let end = case.solver.end_time;
    // The end, and a time like it computed from another unit, may differ in the last digit.
    let reached = |time: f64| time <= end * (1.0 + 1e-12);
    let us = |time: f64| format!("{} µs", short_number_text(time * 1e6));
    let note = |what: String| format!("{what}: after the end of the run, /solver/end_time_us = {}", us(end));
    let output = &mut case.output;
    if !reached(output.history_interval) {
        case.notes
            .push(note(format!("/output/history_interval_us = {} is taken as the end", us(output.history_interval))));
        output.history_interval = end;
    }
    let late: Vec<String> = output.profile_times.iter().filter(|time| !reached(**time)).map(|time| us(*time)).collect();
    if !late.is_empty() {
        case.notes.push(note(format!("/output/profile_times_us: {} left out", late.join(", "))));
        output.profile_times.retain(|time| reached(*time));
    }
    let mut index = 0;
    case.expect.retain(|expect| {
        let last = expect.at.or(expect.between.map(|[_, last]| last));
        let kept = last.is_none_or(reached);
        if let (false, Some(last)) = (kept, last) {
            case.notes.push(note(format!("/expect/{index} at {} left out", us(last))));
        }
        index += 1;
        kept
    });
}

fn elements(case: &Case) -> Result<(), CaseError> {
    let of_layer =
        |layer: &Layer| f64::from(layer.plies) * layer.counts().into_iter().map(|n| n as f64).product::<f64>();
    let count: f64 = case.layers().iter().map(of_layer).sum();
    if count <= MAX_ELEMENTS {
        return Ok(());
    }
    let expected = format!("at most {MAX_ELEMENTS:.2e} elements over all plies");
    Err(CaseError::at("/pack", expected, format!("{count:.2e} elements")).help(SMALLER))
}

/// Critical step of the one-point orthotropic quad, min(Lx √(Ad/C1), Ly √(Ad/C2)) [s].
fn critical_step(layer: &Layer) -> f64 {
    let fabric = &layer.fabric;
    let area = |linear_density: f64| linear_density / fabric.fibre_density;
    let stiffness_x = fabric.warp.modulus * area(fabric.warp.linear_density) * fabric.weft.count;
    let stiffness_y = fabric.weft.modulus * area(fabric.weft.linear_density) * fabric.warp.count;
    let step_x = layer.element_length_x * (fabric.areal_density / stiffness_x).sqrt();
    let step_y = layer.element_length_y * (fabric.areal_density / stiffness_y).sqrt();
    step_x.min(step_y)
}

fn steps(case: &Case) -> Result<(), CaseError> {
    let critical = case.layers().iter().map(critical_step).fold(f64::INFINITY, f64::min);
    let step = case.solver.courant * critical;
    let steps = (case.solver.end_time / step).ceil();
    if steps <= MAX_STEPS {
        return Ok(());
    }
    let longest = short_number_text(MAX_STEPS * step * 1e6);
    let expected = format!("at most 1e9 time steps: up to {longest} µs with steps of {:.3e} µs", step * 1e6);
    Err(CaseError::at("/solver/end_time_us", expected, format!("{steps:.3e} steps")))
}

/// Bytes that the run will hold, about.
fn memory_needed(case: &Case) -> f64 {
    let contact = if case.pack.plies > 1 { CONTACT_BYTES } else { 0.0 };
    let of_layer = |layer: &Layer| {
        let [columns, rows] = layer.counts().map(|count| count as f64);
        f64::from(layer.plies) * (columns * rows * ELEMENT_BYTES + (columns + 1.0) * (rows + 1.0) * contact)
    };
    let rows = case.solver.end_time / case.output.history_interval + 2.0;
    case.layers().iter().map(of_layer).sum::<f64>() + rows * ROW_BYTES + frames_bytes(case)
}

/// Bytes that writing frames takes: those being written, and those that wait for it.
fn frames_bytes(case: &Case) -> f64 {
    if case.output.frames == 0 {
        return 0.0;
    }
    (of_frames(case, case.output.frames as usize, FRAME_BYTES, 1) + case.waiting_frame_bytes()) as f64
}

/// Bytes of frames with `of_element` bytes per element: of all of them if they are small, of `always` of them at least.
fn of_frames(case: &Case, frames: usize, of_element: usize, always: usize) -> usize {
    let one = of_element.saturating_mul(case.elements());
    one.saturating_mul(frames).min(FRAMES_BYTES).max(one.saturating_mul(always))
}

impl Case {
    /// Memory set aside for frames that wait to be written [bytes].
    pub(crate) fn waiting_frame_bytes(&self) -> usize {
        // Up to twice as many as asked for are kept until the end of the run is known.
        of_frames(self, 2 * self.output.frames as usize, SNAPSHOT_BYTES, 2)
    }

    /// Frames that the memory set aside for making them holds, at least one.
    pub(crate) fn frames_at_once(&self) -> usize {
        (FRAMES_BYTES / FRAME_BYTES.saturating_mul(self.elements()).max(1)).max(1)
    }
}

/// Bytes that this machine, or the container around the process, has left; `None` where it does not say.
fn memory_available() -> Option<f64> {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let machine = system.available_memory();
    let available = system.cgroup_limits().map_or(machine, |limits| limits.free_memory.min(machine));
    (machine > 0).then_some(available as f64)
}

fn memory(needed: f64, available: Option<f64>) -> Result<(), CaseError> {
    match available {
        Some(available) if needed > available => {
            let expected = format!("a case that fits into the memory available, {}", bytes(available));
            let found = format!("{} needed", bytes(needed));
            Err(CaseError::at("/pack", expected, found)
                .help(format!("{SMALLER}, raise history_interval_us, or write no frames")))
        }
        _ => Ok(()),
    }
}

fn bytes(count: f64) -> String {
    let (size, unit) =
        [(1e12, "TB"), (1e9, "GB"), (1e6, "MB")].into_iter().find(|(size, _)| count >= *size).unwrap_or((1e3, "kB"));
    let number = count / size;
    if number < 1e4 { format!("{number:.1} {unit}") } else { format!("{} {unit}", number_text(number.round())) }
}

#[cfg(test)]
#[path = "limits_tests.rs"]
mod tests;
