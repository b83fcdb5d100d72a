//! The case: a user's wish, read from JSON, checked, in SI units.
//!
//! This is the only module that knows JSON keys and textile or ballistic units. Everything downstream
//! (`model`, `state`, `step`, …) sees the types below: SI numbers that are finite, in range and
//! consistent with each other.
//!
//! A document becomes a case in five steps: [`read`] parses it, `changes` changes it and `fabric` puts fabrics of files in their place,
//! `error` checks it against the keys that the types below have, `provenance` completes it with defaults and keeps where each value came
//! from, and the types read it and check what goes together. Limits on all of it together, such as memory, stand here.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value;

mod changes;
mod error;
mod fabric;
mod fixture;
mod grading;
mod keys;
mod pack;
mod projectile;
mod provenance;
mod read;
mod solver;
mod units;
mod variability;
mod yarn;

pub use changes::{BuiltInFabric, CaseBuilder, builtin_fabric, with_velocity};
pub use error::CaseError;
pub use fabric::{Compression, Crossover, Fabric, Law, MembraneForce, Rate, Shear, ShearModulus, fabric_from_str};
pub use fixture::{Backing, BackingMaterial, Frame, Opening, Window};
pub use grading::{Grading, LinesFrom};
pub use pack::{Edge, Edges, InitialDeflection, Layer, MeshSize, Pack};
pub use projectile::{Along, Motion, Projectile, Rotation, Shape};
pub(crate) use provenance::mesh;
pub use provenance::{Field, Origin, reference, report, schema};
pub(crate) use read::{as_woven, at_nominal_velocity, converged, realisation};
pub use read::{from_str, read};
pub use solver::{
    Accuracy, Bound, ContactSampling, Expect, Numerics, Output, RunUntil, Solver, StretchSampling, Symmetry,
};

pub(crate) use units::in_words;
pub use units::value_in;
pub(crate) use variability::RANGE_STREAM;
pub use variability::{Distribution, Drawn, HitPlace, Scattered, Variability, YarnStrength};
pub use yarn::Yarn;

use error::short_number_text;
use provenance::Provenance;

/// The README's shot with some keys set, for unit tests.
#[cfg(test)]
pub(crate) fn shipped(sets: &[&str]) -> Case {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    read(std::path::Path::new("cases/s720-1ply-155.json"), &sets).unwrap_or_else(|error| unreachable!("{error}"))
}

/// A complete, validated case in SI units. Its fields are the keys of a case file, and what reading it adds.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct Case {
    /// The JSON Schema of case files, for editors; ripstop writes one with `ripstop schema`.
    #[serde(rename = "$schema")]
    #[schemars(length(min = 1))]
    #[allow(dead_code, reason = "for editors")]
    schema: Option<String>,
    /// Title of the case, for people.
    #[schemars(length(min = 1))]
    pub title: String,
    /// The fabric of every ply that pack.layup gives no other; a file is named relative to the case's folder.
    pub fabric: Fabric,
    /// Plies, size, edges and initial state.
    pub pack: Pack,
    /// Block behind the pack; null or absent: there is none.
    ///
    /// Left out: nothing stands behind the pack.
    pub backing: Option<Backing>,
    /// Body that strikes the pack; null or absent: none does.
    ///
    /// Left out: nothing strikes the pack.
    pub projectile: Option<Projectile>,
    /// Variability from shot to shot; nothing varies in a case that names no shot.
    pub variability: Option<Variability>,
    /// Time integration.
    #[schemars(extend("default" = {}))]
    pub solver: Solver,
    /// Output and its intervals.
    #[schemars(extend("default" = {}))]
    pub output: Output,
    /// Statements about the result that the run checks.
    #[serde(default)]
    #[schemars(with = "Option<Vec<Expect>>", length(min = 0, max = 1000))]
    pub expect: Vec<Expect>,
    /// Where values come from: JSON pointer of a value or of an object around it, and text; a text that begins with "assumed" marks
    /// its values as assumed.
    #[schemars(extend("propertyNames" = {"pattern": "^(/.*)?$"}))]
    #[allow(dead_code, reason = "read from the document")]
    sources: Option<BTreeMap<String, String>>,
    /// Notes for people.
    #[serde(rename = "notes")]
    #[schemars(length(min = 1))]
    #[allow(dead_code, reason = "for people")]
    remarks: Option<String>,
    /// File stem of the case; names the default output folder.
    #[serde(skip)]
    pub name: String,
    /// Values drawn for the shot that this case is; empty for the nominal case.
    #[serde(skip)]
    pub drawn: Vec<Drawn>,
    /// Every field of the case with where its value came from, in schema order.
    #[serde(skip)]
    pub fields: Vec<Field>,
    /// The case as run: file with its fabric inlined and every `--set` applied. Written to the output folder.
    #[serde(skip)]
    pub as_run: Value,
    /// Parts of the file that were left out, and why, a line each.
    #[serde(skip)]
    pub notes: Vec<String>,
    /// The file the case was read from (empty for a built-in case).
    #[serde(skip)]
    pub path: PathBuf,
}

impl Case {
    /// Whether anything varies from shot to shot.
    pub fn varies(&self) -> bool {
        self.variability.as_ref().is_some_and(Variability::varies)
    }

    /// The plies in groups of alike ones, from the struck side: the layup, or the whole pack where it has none.
    pub fn layers(&self) -> Cow<'_, [Layer]> {
        let pack = &self.pack;
        if !pack.layup.is_empty() {
            return Cow::Borrowed(&pack.layup);
        }
        Cow::Owned(vec![Layer {
            plies: pack.plies,
            fabric: self.fabric.clone(),
            orientation: 0.0,
            edges: pack.edges,
            standoff: 0.0,
            initial_velocity: pack.initial_velocity,
            mesh: pack.mesh,
        }])
    }

    /// Completes and checks what depends on several keys.
    fn complete(&mut self, record: &Provenance) -> Result<(), CaseError> {
        self.fabric.complete("/fabric", record)?;
        self.projectile.as_mut().map_or(Ok(()), |projectile| projectile.complete(record))?;
        let (variability, projectile) = (self.variability.as_mut(), self.projectile.as_ref());
        variability.map_or(Ok(()), |variability| variability.complete(projectile, record))?;
        self.complete_pack(record)?;
        self.complete_backing(record)?;
        self.complete_end(record)?;
        self.output.check()?;
        self.expect.iter_mut().enumerate().try_for_each(|(index, expect)| expect.complete(index, record))
    }

    /// Elements over all plies.
    pub fn elements(&self) -> usize {
        self.layers().iter().map(|layer| layer.plies as usize * layer.mesh.count.iter().product::<usize>()).sum()
    }

    /// Frames that the memory set aside for making them holds, at least one.
    pub(crate) fn frames_at_once(&self) -> usize {
        (FRAMES_BYTES / FRAME_BYTES.saturating_mul(self.elements()).max(1)).max(1)
    }
}

/// Keys of a case that say nothing about what it computes.
const CASE_WORDS: [&str; 5] = ["$schema", "title", "sources", "notes", "expect"];

/// Fingerprint of what a case computes: 64-bit FNV-1a of the case as run, with keys sorted and numbers in one form,
/// without the words around it (title, sources, notes) and what is expected of it.
pub fn case_hash(as_run: &Value) -> String {
    let mut computed = as_run.clone();
    if let Some(keys) = computed.as_object_mut() {
        keys.retain(|key, _| !CASE_WORDS.contains(&key.as_str()));
    }
    computed.sort_all_objects();
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    format!("{:016x}", canonical(&computed).bytes().fold(0xcbf2_9ce4_8422_2325, mix))
}

fn canonical(value: &Value) -> String {
    match value {
        Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), |number| format!("{number:?}")),
        Value::Array(items) => format!("[{}]", items.iter().map(|item| canonical(item) + ",").collect::<String>()),
        Value::Object(map) => {
            let entry = |(key, value)| format!("{key:?}:{},", canonical(value));
            format!("{{{}}}", map.iter().map(entry).collect::<String>())
        }
        other => other.to_string(),
    }
}

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
/// Memory that frames in the making may take, and those that wait [bytes], one more in each place.
pub(crate) const FRAMES_BYTES: usize = 128 << 20;
/// One row of the history [bytes].
const ROW_BYTES: f64 = 200.0;
/// Bytes of a page of a browser that a run may take: addresses have 32 bits.
const WASM_BYTES: f64 = 2e9;
/// Remedy for a mesh that is too large.
const SMALLER: &str = "reduce width_mm and height_mm, or raise crossovers_per_element";

/// Columns and rows nearest to a size [m], from the length of an element along each direction [m], in whole multiples of `fine`;
/// `pointer` is what has that size.
fn whole_elements(pointer: &str, size: [f64; 2], element: [f64; 2], fine: f64) -> Result<[usize; 2], CaseError> {
    let [columns, rows] = [0, 1].map(|i| fine * (size[i] / (fine * element[i])).round().max(1.0));
    at_most(columns * rows, pointer, "in a ply", || format!("{columns} × {rows} elements"))?;
    Ok([columns as usize, rows as usize])
}

/// Refuses more elements than can be counted.
fn at_most(count: f64, pointer: &str, place: &str, found: impl Fn() -> String) -> Result<(), CaseError> {
    let error = || CaseError::at(pointer, format!("at most {MAX_ELEMENTS:.2e} elements {place}"), found());
    if count > MAX_ELEMENTS { Err(error().help(SMALLER)) } else { Ok(()) }
}

/// Refuses what cannot be run: too many elements or steps, too much memory.
fn check_limits(case: &Case) -> Result<(), CaseError> {
    let count = sum(case, |elements, _| elements);
    at_most(count, "/pack", "over all plies", || format!("{count:.2e} elements"))?;
    let critical = case.layers().iter().map(critical_step).fold(case.clay_step(), f64::min);
    let step = case.solver.courant * critical;
    let steps = (case.solver.end_time / step).ceil();
    if steps > MAX_STEPS {
        let longest = short_number_text(MAX_STEPS * step * 1e6);
        let expected = format!("at most 1e9 time steps: up to {longest} µs with steps of {:.3e} µs", step * 1e6);
        return Err(CaseError::at("/solver/end_time_us", expected, format!("{steps:.3e} steps")));
    }
    let needed = memory_needed(case);
    let Some(available) = memory_available().filter(|available| needed > *available) else { return Ok(()) };
    let expected = format!("a case that fits into the memory available, {}", bytes(available));
    let error = CaseError::at("/pack", expected, format!("{} needed", bytes(needed)));
    Err(error.help(format!("{SMALLER}, raise history_interval_us, or write no frames")))
}

/// Sum over the plies of a number that follows from the elements and the nodes of one.
fn sum(case: &Case, of: impl Fn(f64, f64) -> f64) -> f64 {
    let of_layer = |layer: &Layer| {
        let [columns, rows] = layer.counts().map(|count| count as f64);
        f64::from(layer.plies) * of(columns * rows, (columns + 1.0) * (rows + 1.0))
    };
    case.layers().iter().map(of_layer).sum()
}

/// Leaves out what would come after the end of the run, and notes it in the case.
fn fit_to_end(case: &mut Case) {
    let end = case.solver.end_time;
    // The end, and a time like it computed from another unit, may differ in the last digit.
    let is_late = |time: f64| time > end * (1.0 + 1e-12);
    let us = |time: f64| format!("{} µs", short_number_text(time * 1e6));
    let mut note =
        |what: String| case.notes.push(format!("{what}: after the end of the run, /solver/end_time_us = {}", us(end)));
    let output = &mut case.output;
    if is_late(output.history_interval) {
        note(format!("/output/history_interval_us = {} is taken as the end", us(output.history_interval)));
        output.history_interval = end;
    }
    let late: Vec<String> = output.profile_times.extract_if(.., |time| is_late(*time)).map(us).collect();
    if !late.is_empty() {
        note(format!("/output/profile_times_us: {} left out", late.join(", ")));
    }
    let mut index = 0..;
    case.expect.retain(|expect| {
        let late = expect.at.or(expect.between.map(|[_, last]| last)).filter(|time| is_late(*time));
        let index = index.next().unwrap_or_default();
        late.inspect(|time| note(format!("/expect/{index} at {} left out", us(*time)))).is_none()
    });
}

/// Critical step of the one-point orthotropic quad, min(Lx √(Ad/C1), Ly √(Ad/C2)) [s].
fn critical_step(layer: &Layer) -> f64 {
    let fabric = &layer.fabric;
    let step = |length: f64, yarn: &Yarn, other: &Yarn| {
        let stiffness = yarn.modulus * (yarn.linear_density / fabric.fibre_density) * other.count;
        length * (fabric.areal_density / stiffness).sqrt()
    };
    let [x, y] = layer.mesh.length;
    step(x, &fabric.warp, &fabric.weft).min(step(y, &fabric.weft, &fabric.warp))
}

/// Bytes that the run will hold, about.
fn memory_needed(case: &Case) -> f64 {
    let contact = if case.pack.plies > 1 { CONTACT_BYTES } else { 0.0 };
    let frames = match case.output.frames {
        0 => 0,
        _ => 2 * FRAMES_BYTES + case.elements() * (FRAME_BYTES + SNAPSHOT_BYTES),
    };
    let rows = case.solver.end_time / case.output.history_interval + 2.0;
    sum(case, |elements, nodes| elements * ELEMENT_BYTES + nodes * contact) + rows * ROW_BYTES + frames as f64
}

/// Bytes that this machine, or the container around the process, has left; `None` where it does not say.
fn memory_available() -> Option<f64> {
    if cfg!(target_family = "wasm") {
        return Some(WASM_BYTES);
    }
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let machine = system.available_memory();
    let available = system.cgroup_limits().map_or(machine, |limits| limits.free_memory.min(machine));
    (machine > 0).then_some(available as f64)
}

/// Bytes in the unit that suits.
pub fn bytes(count: f64) -> String {
    let units = [(1e12, "TB"), (1e9, "GB"), (1e6, "MB")];
    let (size, unit) = units.into_iter().find(|(size, _)| count >= *size).unwrap_or((1e3, "kB"));
    format!("{:.1} {unit}", count / size)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn the_mesh_is_the_nearest_whole_number_and_never_overflows() {
        assert_eq!(whole_elements("/pack", [0.203, 0.001], [0.00127, 0.00127], 1.0).unwrap(), [160, 1]);
        assert_eq!(whole_elements("/pack", [0.0305, 0.0294], [0.000635, 0.000635], 2.0).unwrap(), [48, 46]);
        assert!(whole_elements("/pack", [f64::MAX, f64::MAX], [1e-300, 1e-300], 1.0).is_err());
    }

    /// Memory for a case of these plies and frames, its two rows of history aside, and its elements.
    fn needed(pack: &str, frames: u32) -> (f64, f64) {
        let text = format!(
            r#"{{"title": "t", "fabric": {{"file": "fabrics/s-720.json"}}, "solver": {{"end_time_us": 100}},
                "output": {{"history_interval_us": 100, "frames": {frames}}}, "pack": {{"width_mm": 14, "height_mm": 25.4, {pack}}}}}"#
        );
        let case = crate::case::from_str("t", &text, &[]).unwrap();
        (memory_needed(&case) - 3.0 * ROW_BYTES, case.elements() as f64)
    }

    #[test]
    fn memory_counts_every_ply_its_contact_and_its_frames() {
        let (one, two) = (220.0 * ELEMENT_BYTES, 2.0 * (220.0 * ELEMENT_BYTES + 252.0 * CONTACT_BYTES));
        // 14 mm are 9.4 crossovers of S-728 and 11.0 of S-720, 25.4 mm 17 and 20.
        let own = 9.0 * 17.0 * ELEMENT_BYTES + 10.0 * 18.0 * CONTACT_BYTES;
        for (pack, bytes) in [
            (r#""plies": 1"#, one),
            (r#""plies": 2"#, two),
            (r#""layup": [{}, {"orientation_deg": 90}]"#, two),
            (r#""layup": [{}, {"fabric": {"file": "fabrics/s-728.json"}}]"#, 0.5 * two + own),
        ] {
            assert_eq!(needed(pack, 0).0, bytes, "{pack}");
        }
        let [(without, elements), (with, _)] = [0, 10].map(|frames| needed(r#""plies": 16"#, frames));
        let one = (FRAME_BYTES + SNAPSHOT_BYTES) as f64;
        assert_eq!(with - without, 2.0 * FRAMES_BYTES as f64 + elements * one);
    }
}
