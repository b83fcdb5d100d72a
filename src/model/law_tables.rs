//! Tables of what the unit-cell law makes of energy, kept for the next model that has the same cell.
//!
//! Most of the time that a model takes to build goes into its table, 15 ms of 19: shots of a batch share it. A table is a function of law and
//! cell, so that it does not matter which model made it.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use crate::kernels::crossover::{UnitCellParameters, Variant};
use crate::kernels::law_energy::LawEnergy;

/// Tables that are kept, of 13 kB each: a layup of several fabrics has one for each.
const KEPT: usize = 16;

/// A table, and what it is of.
#[derive(Debug)]
struct Entry {
    law: Variant,
    cell: UnitCellParameters<f64>,
    table: Arc<LawEnergy>,
}

/// The last one first.
static LAST: Mutex<VecDeque<Entry>> = Mutex::new(VecDeque::new());

/// The table of a cell; `None` where the law is the slope of an energy, or a yarn is absent.
pub(super) fn law_energy(law: Variant, cell: &UnitCellParameters<f64>) -> Option<Arc<LawEnergy>> {
    let entries = || LAST.lock().unwrap_or_else(PoisonError::into_inner);
    let known = entries().iter().find(|entry| entry.law == law && entry.cell == *cell).map(|entry| entry.table.clone());
    if known.is_some() {
        return known;
    }
    // Unlocked, for others to build theirs at the same time.
    let table = Arc::new(crate::with_law!(law, L => LawEnergy::new::<L>(law, cell))?);
    let mut entries = entries();
    entries.truncate(KEPT - 1);
    entries.push_front(Entry { law, cell: *cell, table: table.clone() });
    Some(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;
    use crate::kernels::crossover::PublishedTension;

    fn cell(set: &str) -> UnitCellParameters<f64> {
        UnitCellParameters::new(&case::shipped(&[set]).fabric)
    }

    #[test]
    fn models_share_the_table_of_their_cell_and_no_other() {
        let law = Variant::PublishedTension;
        for set in ["/fabric/warp/crimp=0.02", "/fabric/warp/crimp=0.021", "/fabric/weft/modulus_gpa=90"] {
            let cell = cell(set);
            let [first, again] = [law_energy(law, &cell), law_energy(law, &cell)];
            assert!(
                first.as_ref().zip(again.as_ref()).is_some_and(|(first, again)| Arc::ptr_eq(first, again)),
                "{set}"
            );
            assert_eq!(first.as_deref(), LawEnergy::new::<PublishedTension>(law, &cell).as_ref(), "{set}");
        }
        assert!(law_energy(Variant::Variational, &cell("/fabric/warp/crimp=0.02")).is_none());
    }
}
