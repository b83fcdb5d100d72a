//! Rows on their way into the cache: hints to the processor, which change no number.
//!
//! The fields of a row are too short for the processor to see them coming, and waiting for them at once takes longer than a
//! row does; hints between the columns of the row before cost no time.

use std::ops::Range;

use prefetch_index::prefetch_index;

use crate::aligned::CACHE_LINE;

/// A row of elements and one of nodes that are read next, all fields with the numbers per field; empty where there is none.
#[derive(Clone, Copy)]
pub struct Ahead<'a, S> {
    /// Elements, nodes.
    pub rows: [&'a [S]; 2],
    /// Numbers per field.
    pub stride: [usize; 2],
}

impl<S> Ahead<'_, S> {
    /// Nothing.
    pub fn nothing() -> Self {
        Self { rows: [&[]; 2], stride: [1; 2] }
    }

    /// Asks for every field of a cache line of columns, if one begins at `column`.
    #[inline(always)]
    pub fn ask(&self, column: usize) {
        if !column.is_multiple_of(CACHE_LINE / size_of::<S>()) {
            return;
        }
        // Element c is stored at c + 1.
        for ((row, stride), first) in self.rows.iter().zip(self.stride).zip([1, 0]) {
            let mut at = column + first;
            while at < row.len() {
                prefetch_index(row, at);
                at += stride;
            }
        }
    }

    /// Asks for all these columns.
    pub fn ask_for(&self, columns: &Range<usize>) {
        let line = CACHE_LINE / size_of::<S>();
        for column in (columns.start - columns.start % line..columns.end).step_by(line) {
            self.ask(column);
        }
    }
}
