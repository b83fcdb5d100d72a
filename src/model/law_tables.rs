//! Tables of what the unit-cell law makes of energy, kept for the next model that has the same cell.
//!
//! Most of the time that a model takes to build goes into its table, 15 ms of 19: shots of a batch share it. A table is a function of law and
//! cell, so that it does not matter which model made it.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use crate::case::Law;
use crate::kernels::crossover::UnitCellParameters;
use crate::kernels::law_energy::LawEnergy;

/// Tables that are kept, of 13 kB each: a layup of several fabrics has one for each.
const KEPT: usize = 16;

/// A table, and what it is of.
#[derive(Debug)]
struct Entry {
    law: Law,
    cell: UnitCellParameters<f64>,
    table: Arc<LawEnergy>,
}

/// The last one first.
static LAST: Mutex<VecDeque<Entry>> = Mutex::new(VecDeque::new());

/// The table of a cell; `None` where the law is the slope of an energy, or a yarn is absent.
pub(super) fn law_energy(law: Law, cell: &UnitCellParameters<f64>) -> Option<Arc<LawEnergy>> {
    let entries = || LAST.lock().unwrap_or_else(PoisonError::into_inner);
    let known = entries().iter().find(|entry| entry.law == law && entry.cell == *cell).map(|entry| entry.table.clone());
    if known.is_some() {
        return known;
    }
    // Unlocked, for others to build theirs at the same time.
    let table = Arc::new(LawEnergy::new(law, cell)?);
    let mut entries = entries();
    entries.truncate(KEPT - 1);
    entries.push_front(Entry { law, cell: *cell, table: table.clone() });
    Some(table)
}

#[cfg(test)]
#[path = "law_tables_tests.rs"]
mod tests;
