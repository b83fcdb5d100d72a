//! To come.

use libtest_mimic::Trial;

/// The tests.
pub(crate) fn tests() -> Vec<Trial> {
    Vec::new()
}
