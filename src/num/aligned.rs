//! Numbers in memory so that vectors of them do not straddle lines of the cache, which takes the processor twice as long.

use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};

use bytemuck::{Pod, Zeroable};

/// Bytes that come into the cache at once; no register is longer.
pub(crate) const CACHE_LINE: usize = size_of::<CacheLine>();

/// A line of the cache.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C, align(64))]
struct CacheLine([u64; 8]);

/// Numbers, one of which begins a line of the cache, and so does every one a whole number of lines away from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Aligned<S> {
    lines: Vec<CacheLine>,
    /// Numbers to spare before the first.
    start: usize,
    length: usize,
    numbers: PhantomData<S>,
}

impl<S: Pod> Aligned<S> {
    /// `length` zeros; the number at `first` begins a line.
    pub fn zeros(length: usize, first: usize) -> Self {
        let line = CACHE_LINE / size_of::<S>();
        let start = (line - first % line) % line;
        // A page of zeros that has only been read is shared until it is written, and then every core has to be told: written here,
        // while one thread runs, and not, as zeros else would be, when a wave comes by.
        let mut lines = Vec::with_capacity((start + length).div_ceil(line));
        lines.resize(lines.capacity(), std::hint::black_box(CacheLine::zeroed()));
        Self { lines, start, length, numbers: PhantomData }
    }
}

impl<S: Pod> Deref for Aligned<S> {
    type Target = [S];

    fn deref(&self) -> &[S] {
        &bytemuck::cast_slice(&self.lines)[self.start..self.start + self.length]
    }
}

impl<S: Pod> DerefMut for Aligned<S> {
    fn deref_mut(&mut self) -> &mut [S] {
        &mut bytemuck::cast_slice_mut(&mut self.lines)[self.start..self.start + self.length]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begins_a_line<S>(number: &S) -> bool {
        std::ptr::from_ref(number).addr().is_multiple_of(CACHE_LINE)
    }

    #[test]
    fn the_number_asked_for_begins_a_line_in_copies_too() {
        for first in [0, 1, 7, 8, 17] {
            let mut numbers = Aligned::<f64>::zeros(100, first);
            assert!(begins_a_line(&numbers[first]), "{first}");
            numbers[99] = 3.0;
            let copy = numbers.clone();
            assert!(begins_a_line(&copy[first]) && copy == numbers && copy.len() == 100, "{first}");
            let singles = Aligned::<f32>::zeros(40, first);
            assert!(begins_a_line(&singles[first]) && singles.len() == 40);
        }
    }
}
