//! The case: a user's wish, read from JSON, checked, in SI units.
//!
//! This is the only module that knows JSON keys and textile or ballistic units. Everything downstream
//! (`model`, `state`, `step`, …) sees the types below: SI numbers that are finite, in range and
//! consistent with each other.
//!
//! A document becomes a case in five steps: [`read`] parses it, `set` changes it and `fabric_file` puts fabrics of files in their place,
//! `check` checks it against the types of its keys, `provenance` completes it with defaults and keeps where each value came from, and
//! these types become those below.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value;

mod builder;
mod check;
mod error;
mod fabric;
mod fabric_file;
mod grading;
mod keys;
mod limits;
mod pack;
mod projectile;
mod provenance;
mod read;
mod schema;
mod set;
mod shape;
mod solver;
mod variability;

pub use builder::CaseBuilder;
pub use error::CaseError;
pub use fabric::{Compression, Crossover, Fabric, Law, MembraneForce, Shear, ShearModulus, Yarn};
pub use fabric_file::{BuiltInFabric, builtin_fabric};
pub use grading::{Grading, LinesFrom};
pub use pack::{Edge, Edges, InitialDeflection, Layer, Pack};
pub use projectile::{Along, Motion, Projectile, Rotation};
pub(crate) use provenance::mesh;
pub use provenance::{Field, Origin, report};
pub(crate) use read::{converged, realisation};
pub use read::{from_str, from_text, read};
pub use schema::{reference, schema};
pub use shape::Shape;
pub use solver::{
    Accuracy, Bound, ContactSampling, Expect, Numerics, Output, RunUntil, Solver, StretchSampling, Symmetry,
};

pub(crate) use keys::Word;
pub(crate) use variability::RANGE_STREAM;
pub use variability::{Distribution, Drawn, HitPlace, Scattered, Variability, YarnStrength};

/// The README's shot with some keys set, for unit tests.
#[cfg(test)]
pub(crate) fn shipped(sets: &[&str]) -> Case {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    read(std::path::Path::new("cases/s720-1ply-155.json"), &sets).unwrap_or_else(|error| unreachable!("{error}"))
}

/// A complete, validated case in SI units.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Case {
    /// File stem of the case; names the default output folder.
    pub name: String,
    /// Free text for people.
    pub title: String,
    /// The fabric of every ply.
    pub fabric: Fabric,
    /// Plies, size, edges and initial state of the pack.
    pub pack: Pack,
    /// The projectile, if anything strikes the pack.
    pub projectile: Option<Projectile>,
    /// Variability from shot to shot; `None`: nothing varies.
    pub variability: Option<Variability>,
    /// Values drawn for the shot that this case is; empty for the nominal case.
    pub drawn: Vec<Drawn>,
    /// Time integration.
    pub solver: Solver,
    /// Output and its intervals.
    pub output: Output,
    /// Statements about the result that the run checks.
    pub expect: Vec<Expect>,
    /// Every field of the case with where its value came from, in schema order.
    pub fields: Vec<Field>,
    /// The case as run: file with its fabric inlined and every `--set` applied. Written to the output folder.
    pub as_run: serde_json::Value,
    /// Parts of the file that were left out, and why, a line each.
    pub notes: Vec<String>,
    /// The file the case was read from (empty for a built-in case).
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

    /// Elements over all plies.
    pub fn elements(&self) -> usize {
        self.layers().iter().map(|layer| layer.plies as usize * layer.columns * layer.rows).sum()
    }
}

/// The whole case file.
#[derive(Debug, Deserialize, JsonSchema)]
#[allow(dead_code, reason = "some keys are for people")]
struct CaseKeys {
    /// The JSON Schema of case files, for editors; ripstop writes one with `ripstop schema`.
    #[serde(rename = "$schema")]
    #[schemars(length(min = 1))]
    schema: Option<String>,
    /// Title of the case, for people.
    #[schemars(length(min = 1))]
    title: String,
    /// The fabric of every ply that pack.layup gives no other; a file is named relative to the case's folder.
    fabric: Fabric,
    /// Plies, size, edges and initial state.
    pack: Pack,
    /// Body that strikes the pack; null or absent: none does.
    ///
    /// Left out: nothing strikes the pack.
    #[schemars(with = "Option<projectile::ProjectileKeys>")]
    projectile: Option<Projectile>,
    /// Variability from shot to shot; nothing varies in a case that names no shot.
    variability: Option<Variability>,
    /// Time integration.
    #[schemars(extend("default" = {}))]
    solver: Solver,
    /// Output and its intervals.
    #[schemars(extend("default" = {}))]
    output: Output,
    /// Statements about the result that the run checks.
    #[schemars(length(min = 0, max = 1000))]
    expect: Option<Vec<solver::ExpectKeys>>,
    /// Where values come from: JSON pointer of a value or of an object around it, and text; a text that begins with "assumed" marks
    /// its values as assumed.
    #[schemars(extend("propertyNames" = {"pattern": "^(/.*)?$"}))]
    sources: Option<BTreeMap<String, String>>,
    /// Notes for people.
    #[schemars(length(min = 1))]
    notes: Option<String>,
}

impl CaseKeys {
    /// The case; its name, path, notes, document and draws are the caller's.
    fn case(self, record: provenance::Provenance) -> Result<Case, CaseError> {
        let Self { title, mut fabric, mut pack, mut projectile, variability, mut solver, output, .. } = self;
        fabric.complete("/fabric", &record)?;
        projectile.as_mut().map_or(Ok(()), |projectile| projectile.complete(&record))?;
        variability.as_ref().map_or(Ok(()), |variability| variability.check(projectile.as_ref()))?;
        pack.complete(&fabric, projectile.as_ref(), &solver, &record)?;
        solver.complete_end(projectile.as_ref(), &pack, &record)?;
        output.check(&record)?;
        let statement = |(index, keys): (usize, solver::ExpectKeys)| {
            let at = format!("/expect/{index}");
            let expect = keys.expect(&at)?;
            record.summarise(&at, expect.in_words(), &expect.source);
            Ok(expect)
        };
        let expect = self.expect.into_iter().flatten().enumerate().map(statement).collect::<Result<_, _>>()?;
        let fields = record.into_fields();
        let (name, as_run, path, notes, drawn) = Default::default();
        Ok(Case {
            name,
            title,
            fabric,
            pack,
            projectile,
            variability,
            drawn,
            solver,
            output,
            expect,
            fields,
            as_run,
            notes,
            path,
        })
    }
}

/// Keys of a case that say nothing about what it computes.
const CASE_WORDS: [&str; 5] = ["$schema", "title", "sources", "notes", "expect"];

/// Fingerprint of what a case computes: 64-bit FNV-1a of the case as run, with keys sorted and numbers in one form,
/// without the words around it (title, sources, notes) and what is expected of it.
pub fn case_hash(as_run: &Value) -> String {
    let mut text = String::new();
    match as_run.as_object() {
        Some(map) => object_text(map.iter().filter(|(key, _)| !CASE_WORDS.contains(&key.as_str())), &mut text),
        None => canonical(as_run, &mut text),
    }
    let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
    format!("{:016x}", text.bytes().fold(0xcbf2_9ce4_8422_2325, mix))
}

fn canonical(value: &Value, text: &mut String) {
    match value {
        Value::Number(number) => match number.as_f64() {
            Some(number) => *text += &format!("{number:?}"),
            None => *text += &number.to_string(),
        },
        Value::Array(items) => {
            text.push('[');
            for item in items {
                canonical(item, text);
                text.push(',');
            }
            text.push(']');
        }
        Value::Object(map) => object_text(map, text),
        other => *text += &other.to_string(),
    }
}

fn object_text<'a>(entries: impl IntoIterator<Item = (&'a String, &'a Value)>, text: &mut String) {
    let mut entries: Vec<_> = entries.into_iter().collect();
    entries.sort_by_key(|(key, _)| *key);
    text.push('{');
    for (key, value) in entries {
        *text += &format!("{key:?}:");
        canonical(value, text);
        text.push(',');
    }
    text.push('}');
}
