//! Rows on their way into the cache: hints to the processor, which change no number.
//!
//! The fields of a row are too short for the processor to see them coming, and waiting for them at once takes longer than a
//! row does; hints between the columns of the row before cost no time.

use std::ops::Range;

use prefetch_index::prefetch_index;

use crate::math::aligned::CACHE_LINE;

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
mod tests {
    use super::lines;

    #[test]
    fn every_line_is_asked_for_once_however_many_columns_go_at_once() {
        for lanes in [1, 2, 4, 8, 16, 32] {
            let of = |columns: usize| (0..columns).step_by(lanes).map(move |column| column..column + lanes);
            let double: Vec<usize> = of(64).flat_map(lines::<f64>).collect();
            let single: Vec<usize> = of(64).flat_map(lines::<f32>).collect();
            assert_eq!(double, [0, 8, 16, 24, 32, 40, 48, 56], "{lanes}");
            assert_eq!(single, [0, 16, 32, 48], "{lanes}");
        }
    }
}
