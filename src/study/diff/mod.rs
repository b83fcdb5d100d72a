//! `ripstop diff`: runs and measured curves, each held against the first.
//!
//! ```text
//! input ──► pair ──► draw, page, text
//! folder    summary  files
//! or CSV    keys
//!           curves
//! ```
//!
//! - [`input`] reads a run's folder or a table of numbers over time; `table` is the CSV reader, `quantity` knows names and units.
//! - [`curve`] compares two curves within the time that both cover. Between their rows curves are straight; nothing is extrapolated.
//! - [`pair`] puts together what differs between two inputs: `summary.json`, keys of the case, curves.
//! - `draw`, `page` and `text` make `diff.svg`, `diff.html`, `diff.csv` and JSON of it.
//!
//! A difference is the other one less the first. It is relative to the first: to its value, or to the largest magnitude of its curve
//! in the common time. What is a share already, of energy or momentum, is not made relative.

pub mod curve;
mod draw;
mod error;
pub mod input;
mod keys;
mod page;
pub mod pair;
mod quantity;
mod request;
mod summary;
mod table;
mod text;

use crate::study::StudyError;
pub use draw::svg;
pub(crate) use error::{few, quoted};
pub(crate) use input::bounded;
pub use input::{Input, InputKind};
pub use keys::KeyDifference;
pub use page::html;
pub use pair::{CurveRow, RunPair};
pub use request::{DiffOptions, DiffRequest};
pub use summary::SummaryRow;
pub use table::{TableColumn, TimeSeries};
pub(crate) use table::{one_line, separator, text as plain_text};
pub use text::{csv, json, word};

/// Inputs at most: so many lines can be told apart in one figure.
pub const MAX_INPUTS: usize = 8;

/// What was compared.
#[derive(Clone, Debug)]
pub struct Diff {
    /// What was read; the first is what the others are held against.
    pub inputs: Vec<Input>,
    /// One for each input but the first.
    pub pairs: Vec<RunPair>,
    /// What was asked for.
    pub options: DiffOptions,
}

impl Diff {
    /// Whether everything judged is within what was asked for; `None` where nothing was asked.
    pub fn pass(&self) -> Option<bool> {
        self.options.within.map(|_| self.pairs.iter().all(|pair| pair.failures().next().is_none()))
    }

    /// Every compared column once.
    fn names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for row in self.pairs.iter().flat_map(|pair| &pair.curves) {
            if !names.contains(&row.name.as_str()) {
                names.push(&row.name);
            }
        }
        names
    }
}

/// `A` for the first input, `B` for the second.
pub fn letter(input: usize) -> char {
    (b'A'..=b'Z').nth(input).map_or('?', char::from)
}

/// Compares every input with the first.
///
/// # Errors
/// Where two have nothing in common: no column, or no time; or where a column asked for is not in both.
pub fn diff(mut inputs: Vec<Input>, request: &DiffRequest) -> Result<Diff, StudyError> {
    request.check(&inputs.iter().map(|input| &input.table).collect::<Vec<_>>())?;
    for input in inputs.iter_mut().skip(1) {
        input.table.shift(request.options.shift_us);
    }
    let pairs = match inputs.split_first() {
        Some((first, others)) => others.iter().map(|other| pair::pair(first, other, request)).collect::<Result<_, _>>(),
        None => Ok(Vec::new()),
    }?;
    Ok(Diff { inputs, pairs, options: request.options })
}
