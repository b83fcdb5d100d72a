//! Broken yarns: which, and where.

use std::collections::BTreeSet;

use crate::case::{Case, Edge, Layer};
use crate::run::Run;
use crate::run::outcome::Outcome;

/// Pieces of yarn this near to the line of flight broke at the hit [diameters].
const HIT: f64 = 2.0;
/// Pieces of yarn this near to the side of a ply broke at its edge [crossovers].
const EDGE: f64 = 2.0;

/// Broken yarns of a run. A yarn that broke in several places is one yarn and as many pieces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Breakage {
    /// Yarns, warp and weft.
    pub yarns: [usize; 2],
    /// Pieces within two diameters of the line of flight.
    pub at_hit: usize,
    /// Other pieces within two crossovers of the side of a ply.
    pub at_edges: usize,
    /// All other pieces.
    pub elsewhere: usize,
    /// Pieces at edges that are held, so far as they decide: in a perforation those that broke before the last piece at the hit, else all.
    pub torn_off: usize,
}

impl Breakage {
    /// Pieces of yarn in all.
    pub fn pieces(&self) -> usize {
        self.at_hit + self.at_edges + self.elsewhere
    }

    /// Whether more broke at the edges than at the hit, so far as it decides.
    pub fn tore_off(&self) -> bool {
        self.torn_off > self.at_hit
    }

    /// Broken yarns of a run of a case.
    pub fn of(case: &Case, run: &Run) -> Self {
        let layers = case.layers();
        let plies: Vec<PlyLayout> =
            layers.iter().flat_map(|layer| vec![PlyLayout::new(case, layer); layer.plies as usize]).collect();
        let hit = case.projectile.as_ref().map(|p| (p.offset, HIT * p.shape.diameter()));
        let mut broken: [BTreeSet<(u32, usize)>; 2] = Default::default();
        let mut found = Self::default();
        let (mut last_at_hit, mut at_held) = (0, Vec::new());
        for event in &run.events {
            let Some(ply) = plies.get(event.ply as usize) else { continue };
            let element = [event.i as usize, event.j as usize];
            // A warp yarn runs along X: its number is that of its place along Y.
            let yarn = usize::from(event.yarn.min(1));
            let across = 1 - yarn;
            broken[yarn].extend(ply.yarns(across, element[across]).map(|number| (event.ply, number)));
            let near_hit = hit.is_some_and(|(aim, reach)| ply.distance(element, aim) <= reach);
            if near_hit {
                found.at_hit += 1;
                last_at_hit = last_at_hit.max(event.step);
            } else if ply.is_at_edge(element, |_| true) {
                found.at_edges += 1;
                if ply.is_at_edge(element, |edge| edge != Edge::Free) {
                    at_held.push(event.step);
                }
            } else {
                found.elsewhere += 1;
            }
        }
        let decides = |step: &&u64| run.outcome != Outcome::Perforated || **step < last_at_hit;
        found.torn_off = at_held.iter().filter(decides).count();
        found.yarns = broken.map(|yarns| yarns.len());
        found
    }
}

/// Places of the elements of a ply.
#[derive(Clone)]
struct PlyLayout {
    /// Lines of nodes along warp and weft [crossovers from the first].
    lines: [Vec<f64>; 2],
    /// Middles of elements along warp and weft, from the middle of the ply [m].
    middles: [Vec<f64>; 2],
    /// Cosine and sine of the warp's angle.
    turn: [f64; 2],
    /// Left and right, bottom and top.
    sides: [[Edge; 2]; 2],
}

impl PlyLayout {
    fn new(case: &Case, layer: &Layer) -> Self {
        let side = case.pack.crossovers_along_element();
        let lines = layer.node_lines().map(|lines| lines.into_iter().map(|line| line * side).collect());
        let (s, c) = layer.orientation.sin_cos();
        let edges = layer.edges;
        let sides = [[edges.left, edges.right], [edges.bottom, edges.top]];
        Self { lines, middles: layer.middles(), turn: [c, s], sides }
    }

    /// Numbers of the yarns that cross an element of this column or row. An element no wider than a yarn has the one at its middle.
    fn yarns(&self, axis: usize, index: usize) -> std::ops::Range<usize> {
        let [from, to] = [0, 1].map(|end| self.lines[axis].get(index + end).copied().unwrap_or(0.0));
        if to - from <= 1.0 + 1e-6 {
            let only = (0.5 * (from + to)) as usize;
            return only..only + 1;
        }
        let first = (from + 1e-6).floor() as usize;
        first..((to - 1e-6).ceil() as usize).max(first + 1)
    }

    /// Distance of an element from a place in the pack's plane [m].
    fn distance(&self, [i, j]: [usize; 2], place: [f64; 2]) -> f64 {
        let [x, y] = [self.middles[0][i], self.middles[1][j]];
        let [c, s] = self.turn;
        (c * x - s * y - place[0]).hypot(s * x + c * y - place[1])
    }

    /// Whether an element begins near a side of the ply that `counts`. The outermost always does, however long it is.
    fn is_at_edge(&self, element: [usize; 2], counts: impl Fn(Edge) -> bool) -> bool {
        [0, 1].into_iter().any(|axis: usize| {
            let (lines, [low, high]) = (&self.lines[axis], self.sides[axis]);
            let (first, last) = (lines[0], lines[lines.len() - 1]);
            (counts(low) && lines[element[axis]] < first + EDGE - 1e-6)
                || (counts(high) && lines[element[axis] + 1] > last - EDGE + 1e-6)
        })
    }
}

#[cfg(test)]
#[path = "breakage_tests.rs"]
mod tests;
