//! The case: what the user asked for, read from JSON, checked, in SI units.
//!
//! This is the only module that knows JSON keys and textile or ballistic units. Everything downstream
//! (`model`, `state`, `step`, …) sees the types below: SI numbers that are finite, in range and
//! consistent with each other.

use std::borrow::Cow;
use std::path::PathBuf;

mod build;
mod builder;
mod builtin;
mod check;
mod error;
mod expect;
mod fabric;
mod fabric_file;
mod fabric_keys;
mod fields;
mod grading;
mod hash;
mod json;
mod layup;
mod limits;
mod pack_keys;
mod pack_types;
mod places;
mod pointer;
mod projectile;
mod projectile_keys;
mod projectile_types;
mod read;
mod record;
mod reference;
mod report;
mod schema;
mod scope;
mod set;
mod solver_keys;
mod solver_types;
mod sources;
mod table;
mod units;
mod value;
mod variability;
mod variability_keys;
mod words;

pub use builder::CaseBuilder;
pub use builtin::{BuiltInFabric, builtin_fabric};
pub use error::CaseError;
pub use fabric::*;
pub use grading::Grading;
pub use hash::case_hash;
pub use pack_types::*;
pub use projectile_types::*;
pub(crate) use read::{converged, realisation};
pub use read::{from_str, from_text, read};
pub use reference::reference;
pub(crate) use report::mesh;
pub use report::report;
pub use schema::schema;
pub use solver_types::*;
pub(crate) use variability::RANGE_STREAM;
pub use variability::{Distribution, Drawn, HitPlace, Scattered, Variability, YarnStrength};
pub(crate) use words::Word;

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
    /// What strikes the pack, if anything does.
    pub projectile: Option<Projectile>,
    /// What varies from shot to shot; `None`: nothing does.
    pub variability: Option<Variability>,
    /// What was drawn for the shot that this case is; empty for the nominal case.
    pub drawn: Vec<Drawn>,
    /// Time integration.
    pub solver: Solver,
    /// What is written and how often.
    pub output: Output,
    /// Statements about the result that the run checks.
    pub expect: Vec<Expect>,
    /// Every field of the case with where its value came from, in schema order.
    pub fields: Vec<Field>,
    /// The case as run: file with its fabric inlined and every `--set` applied. Written to the output folder.
    pub as_run: serde_json::Value,
    /// What of the file was left out, and why, a line each.
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

    /// Memory set aside for frames that wait to be written [bytes].
    pub(crate) fn waiting_frame_bytes(&self) -> usize {
        limits::waiting_frame_bytes(self)
    }

    /// Frames that the memory set aside for making them holds, at least one.
    pub(crate) fn frames_at_once(&self) -> usize {
        limits::frames_at_once(self)
    }

    /// Elements over all plies.
    pub fn elements(&self) -> usize {
        self.layers().iter().map(|layer| layer.plies as usize * layer.columns * layer.rows).sum()
    }
}

/// What is written and how often.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Output {
    /// Interval of `history.csv` [s].
    pub history_interval: f64,
    /// Frames for ParaView, evenly from the start to the end time.
    pub frames: u32,
    /// Times at which a deflection profile is sampled [s], ascending.
    pub profile_times: Vec<f64>,
    /// Direction of the profile through the point of impact (pack centre without projectile).
    pub profile_along: Along,
}

/// A statement about the result, checked after the run.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Expect {
    /// Name of the quantity: any number or word of `summary.json`, any column of `history.csv` (with `at_us`),
    /// or a measured wave quantity.
    pub quantity: String,
    /// What is expected.
    pub bound: Bound,
    /// Time at which a history or profile quantity is read [s].
    pub at: Option<f64>,
    /// Interval over which a speed or frequency is measured [s].
    pub between: Option<[f64; 2]>,
    /// Where the statement comes from.
    pub source: String,
    /// Why it is known not to hold; empty: it must.
    pub known_difference: String,
}

/// The expectation itself.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Bound {
    /// A word, e.g. an outcome.
    Word(String),
    /// |got − value| ≤ tolerance (already absolute, in the quantity's own unit).
    Value {
        /// Expected.
        value: f64,
        /// Allowed absolute difference.
        tolerance: f64,
    },
    /// min ≤ got ≤ max.
    Range {
        /// −∞ when absent.
        min: f64,
        /// +∞ when absent.
        max: f64,
    },
}

/// One field of the case and where its value came from.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Field {
    /// JSON pointer, e.g. `/fabric/warp/modulus_gpa`.
    pub pointer: String,
    /// Value in the key's unit, as text.
    pub value: String,
    /// Unit, empty when dimensionless.
    pub unit: &'static str,
    /// Read, defaulted or derived.
    pub origin: Origin,
    /// Where the value comes from: the case's `sources`, the default's source, or the formula.
    pub source: String,
    /// True when the value is assumed rather than published.
    pub assumed: bool,
}

/// Where a field's value came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Origin {
    /// From the case file or `--set`.
    Read,
    /// Not given: the documented default.
    Default,
    /// Computed from other fields.
    Derived,
}

impl Origin {
    /// One word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Default => "default",
            Self::Derived => "derived",
        }
    }
}
