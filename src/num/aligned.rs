//! Numbers in memory so that vectors of them do not straddle lines of the cache, which takes the processor twice as long.

use std::ops::{Deref, DerefMut, Range};

use prefetch_index::prefetch_index;

/// Bytes that come into the cache at once; no register is longer.
pub(crate) const CACHE_LINE: usize = 64;

/// Numbers, one of which begins a line of the cache, and so does every one a whole number of lines away from it.
#[derive(Debug)]
pub struct Aligned<S> {
    /// Storage, with numbers to spare on both sides.
    numbers: Vec<S>,
    start: usize,
    length: usize,
    /// Number of the one that begins a line.
    first: usize,
}

impl<S: Clone> Aligned<S> {
    /// `length` times the same number; the one at `first` begins a line.
    pub fn new(number: S, length: usize, first: usize) -> Self {
        let line = CACHE_LINE / size_of::<S>();
        // A page of zeros that has only been read is shared until it is written, and then every core has to be told: written here,
        // while one thread runs, and not, as zeros else would be, when a wave comes by.
        let mut numbers = Vec::with_capacity(length + line);
        numbers.resize(length + line, std::hint::black_box(number));
        // Where the platform cannot say, the numbers lie as they come.
        let ahead = numbers.as_ptr().align_offset(CACHE_LINE) % line;
        let start = (ahead + line - first % line) % line;
        Self { numbers, start, length, first }
    }
}

impl<S> Aligned<S> {
    /// Place of the number that begins a line.
    pub fn first(&self) -> usize {
        self.first
    }
}

impl<S: Clone> Clone for Aligned<S> {
    fn clone(&self) -> Self {
        let mut copy = Self::new(self.numbers[0].clone(), self.length, self.first);
        copy.clone_from_slice(self);
        copy
    }
}

impl<S> Deref for Aligned<S> {
    type Target = [S];

    fn deref(&self) -> &[S] {
        &self.numbers[self.start..self.start + self.length]
    }
}

impl<S> DerefMut for Aligned<S> {
    fn deref_mut(&mut self) -> &mut [S] {
        &mut self.numbers[self.start..self.start + self.length]
    }
}

impl<S: PartialEq> PartialEq for Aligned<S> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

/// Asks for what lies `ahead` numbers after `at` in every field, which may be beyond its end.
#[inline(always)]
pub(crate) fn ask<'a, S: 'a>(fields: impl IntoIterator<Item = &'a [S]>, at: usize, ahead: usize) {
    for field in fields {
        prefetch_index(field, at + ahead);
    }
}

/// Columns whose number begins a line of the cache.
#[inline(always)]
pub(crate) fn lines<S>(columns: Range<usize>) -> impl Iterator<Item = usize> {
    let line = CACHE_LINE / size_of::<S>();
    (columns.start.next_multiple_of(line)..columns.end).step_by(line)
}

#[cfg(test)]
#[path = "aligned_tests.rs"]
mod tests;
