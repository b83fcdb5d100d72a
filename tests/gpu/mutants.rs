//! Shaders broken on purpose, each of which the kernel tests must catch.

use libtest_mimic::Trial;

/// The tests.
pub(crate) fn tests() -> Vec<Trial> {
    Vec::new()
}
