//! The case: a user's wish, read from JSON, checked, in SI units.
//!
//! This is the only module that knows JSON keys and textile or ballistic units. Everything downstream
//! (`model`, `state`, `step`, …) sees the types below: SI numbers that are finite, in range and
//! consistent with each other.
//!
//! A document becomes a case in five steps: [`read`] parses it, `changes` changes it and `fabric` puts fabrics of files in their place,
//! `error` checks it against the keys that the types below have, `provenance` completes it with defaults and keeps where each value came
//! from, and the types read it and check what goes together.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value;

mod changes;
mod error;
mod fabric;
mod grading;
mod keys;
mod limits;
mod pack;
mod projectile;
mod provenance;
mod read;
mod solver;
mod variability;

pub use changes::CaseBuilder;
pub use error::CaseError;
pub use fabric::{
    BuiltInFabric, Compression, Crossover, Fabric, Law, MembraneForce, Shear, ShearModulus, Yarn, builtin_fabric,
};
pub use grading::{Grading, LinesFrom};
pub use pack::{Edge, Edges, InitialDeflection, Layer, Pack};
pub use projectile::{Along, Motion, Projectile, Rotation, Shape};
use provenance::Provenance;
pub(crate) use provenance::mesh;
pub use provenance::{Field, Origin, report};
pub(crate) use read::{converged, realisation};
pub use read::{from_str, from_text, read};
pub use solver::{
    Accuracy, Bound, ContactSampling, Expect, Numerics, Output, RunUntil, Solver, StretchSampling, Symmetry,
};

pub use keys::{reference, schema};
pub(crate) use variability::RANGE_STREAM;
pub use variability::{Distribution, Drawn, HitPlace, Scattered, Variability, YarnStrength};

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
            initial_velocity: pack.initial_velocity,
            columns: pack.columns,
            rows: pack.rows,
            element_length_x: pack.element_length_x,
            element_length_y: pack.element_length_y,
            grading: pack.grading,
        }])
    }

    /// Completes and checks what depends on several keys.
    fn complete(&mut self, record: &Provenance) -> Result<(), CaseError> {
        let (fabric, pack, solver) = (&mut self.fabric, &mut self.pack, &mut self.solver);
        fabric.complete("/fabric", record)?;
        self.projectile.as_mut().map_or(Ok(()), |projectile| projectile.complete(record))?;
        let projectile = self.projectile.as_ref();
        self.variability.as_ref().map_or(Ok(()), |variability| variability.check(projectile))?;
        pack.complete(fabric, projectile, solver, record)?;
        solver.complete_end(projectile, pack, record)?;
        self.output.check()?;
        self.expect.iter_mut().enumerate().try_for_each(|(index, expect)| expect.complete(index, record))
    }

    /// Elements over all plies.
    pub fn elements(&self) -> usize {
        self.layers().iter().map(|layer| layer.plies as usize * layer.columns * layer.rows).sum()
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
