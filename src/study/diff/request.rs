//! What was asked for.

use super::error::{few, quoted};
use super::quantity::{self, Quantity};
use super::table::{TimeSeries, one_line};
use crate::case::nearest;
use crate::study::StudyError;

/// Share from which on curves count as parted, where no other was asked for.
const PART: f64 = 0.01;

/// What is judged, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DiffOptions {
    /// Relative difference that is still good; nothing is judged without.
    pub within: Option<f64>,
    /// Added to the times of every input but the first [µs].
    pub shift_us: f64,
}

impl DiffOptions {
    /// Share of its largest magnitude that a curve must differ by to have parted from another.
    pub fn part(&self) -> f64 {
        self.within.unwrap_or(PART)
    }
}

/// A heading of a measured table, and what it stands for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mapping {
    pub(super) heading: String,
    pub(super) quantity: Quantity,
}

/// What was asked for, once checked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DiffRequest {
    /// What is judged, and how.
    pub options: DiffOptions,
    pub(super) mappings: Vec<Mapping>,
    /// Columns that are compared; all common ones where none is named.
    pub(super) columns: Vec<String>,
}

impl DiffRequest {
    /// Reads the columns: `NAME` limits the comparison to it, `HEADING=NAME` says what a heading stands for.
    ///
    /// # Errors
    /// Where the part after `=` is no quantity of `history.csv`, or a heading stands for two.
    pub fn new(options: DiffOptions, columns: &[String]) -> Result<Self, StudyError> {
        let mut request = Self { options, ..Self::default() };
        for text in columns {
            match text.rsplit_once('=') {
                Some((heading, name)) => {
                    let (heading, quantity) = (one_line(heading), known(name)?);
                    if request.mappings.iter().any(|mapping| mapping.heading == heading) {
                        let found = format!("{} twice", quoted(&heading));
                        return Err(StudyError::new("--column", "one name for a heading", found, "leave out one"));
                    }
                    request.mappings.push(Mapping { heading, quantity });
                }
                None => request
                    .columns
                    .push(quantity::of(text).map_or_else(|| one_line(text), |known| known.name.to_owned())),
            }
        }
        Ok(request)
    }

    /// Refuses what stands for a heading that no table has.
    pub(super) fn check(&self, tables: &[&TimeSeries]) -> Result<(), StudyError> {
        let headings = || tables.iter().flat_map(|table| &table.headings);
        let missing = self.mappings.iter().find(|mapping| !headings().any(|heading| *heading == mapping.heading));
        missing.map_or(Ok(()), |mapping| {
            let place = format!("--column {}", quoted(&mapping.heading));
            let found = few(headings().map(String::as_str));
            let help = "write the heading as the file has it";
            Err(StudyError::new(place, "a heading of one of the files", found, help))
        })
    }
}

fn known(name: &str) -> Result<Quantity, StudyError> {
    quantity::of(name).ok_or_else(|| {
        let names = quantity::names();
        let help = nearest(name.trim(), names.iter().map(String::as_str))
            .map_or_else(String::new, |near| format!("did you mean {near}?"));
        let expected = "after = a column of history.csv, in its unit or another: projectile_velocity_m_s, time_ms";
        StudyError::new("--column", expected, quoted(name), help)
    })
}
