//! Rows on their way into the cache: hints to the processor, which change no number.
//!
//! The fields of a row are too short for the processor to see them coming, and waiting for them at once takes longer than a
//! row does; hints between the columns of the row before cost no time.

use prefetch_index::prefetch_index;

use crate::aligned::CACHE_LINE;

/// Asks for what lies `ahead` numbers after `at` in every field, which may be beyond its end.
#[inline(always)]
pub(super) fn ask<'a, S: 'a>(fields: impl IntoIterator<Item = &'a [S]>, at: usize, ahead: usize) {
    for field in fields {
        prefetch_index(field, at + ahead);
    }
}

/// Whether a line of the cache begins with the number of `column`.
#[inline(always)]
pub(super) fn begins_line<S>(column: usize) -> bool {
    column.is_multiple_of(CACHE_LINE / size_of::<S>())
}
