//! Rows on their way into the cache: hints to the processor, which change no number.
//!
//! The fields of a row are too short for the processor to see them coming, and waiting for them at once takes longer than a
//! row does; hints between the columns of the row before cost no time.

use std::ops::Range;

use prefetch_index::prefetch_index;

use crate::num::aligned::CACHE_LINE;

/// Asks for what lies `ahead` numbers after `at` in every field, which may be beyond its end.
#[inline(always)]
pub(super) fn ask<'a, S: 'a>(fields: impl IntoIterator<Item = &'a [S]>, at: usize, ahead: usize) {
    for field in fields {
        prefetch_index(field, at + ahead);
    }
}

/// Those of some columns with whose number a line of the cache begins.
#[inline(always)]
pub(super) fn lines<S>(columns: Range<usize>) -> impl Iterator<Item = usize> {
    let line = CACHE_LINE / size_of::<S>();
    (columns.start.next_multiple_of(line)..columns.end).step_by(line)
}

#[cfg(test)]
#[path = "prefetch_tests.rs"]
mod tests;
