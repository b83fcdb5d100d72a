//! Grid lines of a ply along one of its axes: evenly spaced, or graded.

use std::ops::Range;

/// Difference of places that rounding makes [-].
pub(super) const SAME: f64 = 1e-9;

/// Lines of nodes across an axis of a ply.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lines {
    /// Place of each line, counted in finest elements from the first line; at least two.
    places: Vec<f64>,
    /// Whether elements may differ in length.
    pub(super) graded: bool,
}

impl Lines {
    pub(super) fn even(elements: usize) -> Self {
        Self { places: (0..=elements).map(|line| line as f64).collect(), graded: false }
    }

    /// Lines at these places.
    pub(super) fn graded(places: Vec<f64>) -> Self {
        Self { places, graded: true }
    }

    pub(super) fn elements(&self) -> usize {
        self.places.len() - 1
    }

    /// Place of a line.
    #[inline]
    pub(super) fn at(&self, line: usize) -> f64 {
        self.places[line]
    }

    /// Length of the element after a line.
    #[inline]
    pub(super) fn width(&self, element: usize) -> f64 {
        self.places[element + 1] - self.places[element]
    }

    pub(super) fn widest(&self) -> f64 {
        (0..self.elements()).map(|element| self.width(element)).fold(0.0, f64::max)
    }

    /// The line in the middle of the elements of the finest length, the later of two.
    pub(super) fn middle_of_finest(&self) -> usize {
        let mut finest = (0..self.elements()).filter(|element| self.width(*element) < 1.0 + SAME);
        let first = finest.next().unwrap_or(0);
        (first + finest.next_back().unwrap_or(first)).div_ceil(2)
    }

    /// Half of each element beside a line.
    pub(crate) fn share(&self, line: usize) -> f64 {
        let before = if line > 0 { self.width(line - 1) } else { 0.0 };
        let after = if line < self.elements() { self.width(line) } else { 0.0 };
        0.5 * (before + after)
    }

    /// The element that a place lies in, or the nearest.
    pub(super) fn element_at(&self, place: f64) -> usize {
        self.places.partition_point(|line| *line <= place).saturating_sub(1).min(self.elements() - 1)
    }

    /// Lines between two places, and the next on either side.
    pub(super) fn between(&self, from: f64, to: f64) -> Range<usize> {
        let first = self.places.partition_point(|line| *line <= from).saturating_sub(1);
        first..(self.places.partition_point(|line| *line < to) + 1).min(self.places.len())
    }

    /// The line nearest to a place.
    pub(super) fn nearest(&self, place: f64) -> usize {
        let element = self.element_at(place);
        element + usize::from(place - self.at(element) >= 0.5 * self.width(element))
    }

    /// Elements within `reach`, a whole number, of an element; the element too.
    pub(crate) fn within(&self, element: usize, reach: f64) -> Range<usize> {
        let (from, to) = (self.places[element] - reach, self.places[element + 1] + reach);
        // A part of an element counts.
        let first = self.places.partition_point(|line| *line <= from + SAME).saturating_sub(1);
        first..self.places.partition_point(|line| *line < to - SAME).min(self.elements())
    }

    /// Lengths of the elements that lie within `reach` of the middle of one, from the first of them on; past a mirror plane at the
    /// first or last line their images count.
    pub(super) fn overlaps(&self, element: usize, reach: f64, mirrored: [bool; 2]) -> (usize, Vec<f64>) {
        let end = self.at(self.elements());
        let middle = self.at(element) + 0.5 * self.width(element);
        let (from, to) = (middle - reach, middle + reach);
        let common = |a: f64, b: f64| (b.min(to) - a.max(from)).max(0.0);
        let length = |k: usize| {
            let (a, b) = (self.at(k), self.at(k) + self.width(k));
            let before = if mirrored[0] { common(-b, -a) } else { 0.0 };
            let behind = if mirrored[1] { common(2.0 * end - b, 2.0 * end - a) } else { 0.0 };
            common(a, b) + before + behind
        };
        let first = (self.element_at(from)..=element).find(|k| length(*k) > SAME).unwrap_or(element);
        let lengths = (first..self.elements()).map(length);
        (first, lengths.take_while(|length| *length > SAME).collect())
    }

    /// Number of the yarn as wide as `breadth` that the middle of an element lies in, from the first on. `between`: a place between two yarns.
    pub(super) fn yarn(&self, element: usize, between: f64, breadth: f64) -> u32 {
        let number = |place: f64| ((place - between) / breadth + SAME).floor();
        (number(self.at(element) + 0.5 * self.width(element)) - number(0.0)).max(0.0) as u32
    }

    /// Whether they are their own mirror image, with a line in the middle.
    pub(super) fn is_mirrored(&self) -> bool {
        let elements = self.elements();
        let length = self.at(elements);
        let pairs = (0..=elements).all(|line| (self.at(line) + self.at(elements - line) - length).abs() < SAME);
        elements.is_multiple_of(2) && pairs
    }

    /// The half of mirrored lines behind the middle, or before it.
    pub(super) fn half(&self, behind: bool) -> Self {
        let middle = self.elements() / 2;
        let places = &self.places;
        let half = |line: &f64| line - places[middle];
        let places = if behind { places[middle..].iter().map(half).collect() } else { places[..=middle].to_vec() };
        Self { places, ..*self }
    }

    /// The lines of which these are the half behind the middle, or before it.
    pub(super) fn doubled(&self, behind: bool) -> Self {
        let length = self.at(self.elements());
        let mirrored = self.places.iter().rev().map(|place| if behind { length - place } else { 2.0 * length - place });
        let own = self.places.iter().map(|place| if behind { length + place } else { *place });
        let places = if behind { mirrored.chain(own.skip(1)).collect() } else { own.chain(mirrored.skip(1)).collect() };
        Self { places, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_lines_lie_at_whole_numbers() {
        let even = Lines::even(6);
        assert_eq!([0, 3, 6].map(|line| (even.at(line), even.share(line))), [(0.0, 0.5), (3.0, 1.0), (6.0, 0.5)]);
        assert_eq!(
            [-1.0, 0.99, 4.01, 8.0].map(|place| (even.element_at(place), even.nearest(place))),
            [(0, 0), (0, 1), (4, 4), (5, 6)]
        );
        assert_eq!((even.within(2, 0.0), even.within(2, 1.0), even.within(5, 9.0)), (2..3, 1..4, 0..6));
        assert_eq!((even.between(1.5, 3.2), even.between(-2.0, 9.0)), (1..5, 0..7));
        assert!(even.is_mirrored() && !Lines::even(5).is_mirrored() && even.half(true) == Lines::even(3));
    }

    #[test]
    fn lines_of_different_elements_know_their_sizes() {
        let lines = Lines::graded(vec![0.0, 2.0, 3.0, 4.0, 6.0]);
        assert!(lines.is_mirrored() && !Lines::graded(vec![0.0, 2.0, 3.0]).is_mirrored());
        assert_eq!([0, 1, 2, 3, 4].map(|line| lines.share(line)), [1.0, 1.5, 1.0, 1.5, 1.0]);
        assert_eq!([-1.0, 1.9, 2.0, 3.5, 7.0].map(|place| lines.element_at(place)), [0, 0, 1, 2, 3]);
        assert_eq!([0.9, 1.1, 2.4, 5.1].map(|place| lines.nearest(place)), [0, 1, 1, 4]);
        assert_eq!((lines.within(1, 0.0), lines.within(1, 1.0), lines.within(2, 2.5)), (1..2, 0..3, 0..4));
        assert_eq!(lines.half(false), Lines::graded(vec![0.0, 2.0, 3.0]));
        assert!([true, false].into_iter().all(|behind| lines.half(behind).doubled(behind) == lines));
        assert_eq!((lines.widest(), lines.elements()), (2.0, 4));
    }

    #[test]
    fn what_lies_around_an_element_is_that_of_the_whole_in_its_half() {
        assert_eq!(Lines::even(9).overlaps(4, 1.5, [false; 2]), (3, vec![1.0, 1.0, 1.0]));
        assert_eq!(Lines::even(9).overlaps(4, 3.0, [false; 2]), (1, vec![0.5, 1.0, 1.0, 1.0, 1.0, 1.0, 0.5]));
        assert_eq!(Lines::even(9).overlaps(0, 1.5, [false; 2]), (0, vec![1.0, 1.0]));
        // The image of the first element lies beside it, that of the second half a length within reach.
        assert_eq!(Lines::even(9).overlaps(0, 2.0, [true, false]), (0, vec![2.0, 1.5, 0.5]));
        assert_eq!(Lines::even(9).overlaps(8, 2.0, [false, true]), (6, vec![0.5, 1.5, 2.0]));
        let lines = Lines::graded(vec![0.0, 2.0, 3.0, 4.0, 6.0]);
        assert_eq!(lines.overlaps(1, 1.5, [false; 2]), (0, vec![1.0, 1.0, 1.0]));
        assert_eq!(lines.overlaps(3, 1.5, [false; 2]), (2, vec![0.5, 2.0]));
    }
}
