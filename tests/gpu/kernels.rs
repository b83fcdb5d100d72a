//! Every kernel against its twin, from the same state.

use libtest_mimic::Trial;

use super::harness::trial;

/// The tests.
pub(crate) fn tests() -> Vec<Trial> {
    vec![trial("kernels::adapter", |_| Ok(()))]
}
