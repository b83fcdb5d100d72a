//! Active region: a rectangle of nodes of a ply that may have moved. It grows by one ring a step.
//!
//! A node feels only its own elements, and they only their corners, so motion spreads by at most one ring of nodes a
//! step; contact adds what it touches. Everything outside is exactly at rest, to the last bit, and leaving it out
//! changes nothing.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::model::mesh::Mesh;

/// Rows and columns of nodes of a ply that may have moved or move.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActiveRegion {
    /// Rows of nodes.
    pub rows: Range<usize>,
    /// Columns of nodes.
    pub columns: Range<usize>,
}

impl ActiveRegion {
    /// Nothing has moved.
    pub fn nothing() -> Self {
        Self { rows: 0..0, columns: 0..0 }
    }

    /// Everything may have moved.
    pub fn whole(mesh: &Mesh) -> Self {
        Self { rows: 0..mesh.rows + 1, columns: 0..mesh.columns + 1 }
    }

    /// Whether nothing has moved.
    pub fn is_nothing(&self) -> bool {
        self.rows.is_empty() || self.columns.is_empty()
    }

    /// Takes a node in.
    pub fn activate(&mut self, row: usize, column: usize) {
        *self = self.union(&Self { rows: row..row + 1, columns: column..column + 1 });
    }

    /// The smallest rectangle around both.
    #[must_use]
    pub(crate) fn union(&self, other: &Self) -> Self {
        if self.is_nothing() {
            return other.clone();
        }
        if other.is_nothing() {
            return self.clone();
        }
        let join = |a: &Range<usize>, b: &Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        Self { rows: join(&self.rows, &other.rows), columns: join(&self.columns, &other.columns) }
    }

    /// With `rings` more nodes on every side, within the ply.
    #[must_use]
    pub fn grown(&self, rings: usize, mesh: &Mesh) -> Self {
        if self.is_nothing() {
            return Self::nothing();
        }
        let grow = |r: &Range<usize>, last: usize| r.start.saturating_sub(rings)..(r.end + rings).min(last + 1);
        Self { rows: grow(&self.rows, mesh.rows), columns: grow(&self.columns, mesh.columns) }
    }

    /// Rows and columns of the elements that have a corner in it.
    pub fn elements(&self, mesh: &Mesh) -> [Range<usize>; 2] {
        if self.is_nothing() {
            return [0..0, 0..0];
        }
        let span = |r: &Range<usize>, count: usize| r.start.saturating_sub(1)..r.end.min(count);
        [span(&self.rows, mesh.rows), span(&self.columns, mesh.columns)]
    }

    /// The nodes of another ply that lie over it or within `slack` [m] of that, by their reference positions.
    #[must_use]
    pub(crate) fn seen_from(&self, own: &Mesh, other: &Mesh, slack: f64) -> Self {
        if self.is_nothing() {
            return Self::nothing();
        }
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for row in [self.rows.start, self.rows.end - 1] {
            for column in [self.columns.start, self.columns.end - 1] {
                let [x, y] = own.reference(row, column);
                let [x, y, _] = other.to_ply(own.to_pack([x, y, 0.0]));
                for (a, at) in [x, y].into_iter().enumerate() {
                    low[a] = low[a].min(at);
                    high[a] = high[a].max(at);
                }
            }
        }
        let slack = slack + 1.5 * own.longest();
        let span = |a: usize| other.lines_between(a, [low[a] - slack, high[a] + slack]);
        Self { rows: span(1), columns: span(0) }
    }
}

#[cfg(test)]
#[path = "active_region_tests.rs"]
mod tests;
