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

    /// Whether the fabric tore off its frame rather than broke at the hit.
    pub fn is_torn_off(&self) -> bool {
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
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use std::sync::atomic::AtomicBool;

    use super::*;
    use crate::output::checks::{Level, checks};
    use crate::run::{self, Options};
    use crate::solver::FailureEvent;

    /// A 20 × 20 mm ply of S-720 (1.27 mm a crossover: 16 × 16) with this number of elements a crossover.
    fn ply(mesh: &str) -> PlyLayout {
        let text = format!(
            r#"{{"title": "t", "fabric": {{"file": "fabrics/s-720.json"}}, "solver": {{"end_time_us": 1}},
                "pack": {{"width_mm": 20.32, "height_mm": 20.32, {mesh}}}}}"#
        );
        let case = crate::case::from_str("t", &text, &[]).unwrap();
        PlyLayout::new(&case, &case.layers()[0])
    }

    #[test]
    fn elements_of_a_crossover_are_one_yarn_and_an_element_of_several_has_several() {
        let fine = ply(r#""elements_per_crossover": 2"#);
        assert_eq!((fine.yarns(1, 0), fine.yarns(1, 1), fine.yarns(1, 2)), (0..1, 0..1, 1..2));
        // Lines of a mesh around a hit lie anywhere in a yarn.
        let shifted = PlyLayout { lines: [vec![0.0, 0.7, 1.2, 1.7], vec![0.0]], ..fine };
        assert_eq!((shifted.yarns(0, 0), shifted.yarns(0, 1), shifted.yarns(0, 2)), (0..1, 0..1, 1..2));
        let coarse = ply(r#""crossovers_per_element": 4"#);
        assert_eq!((coarse.yarns(0, 0), coarse.yarns(0, 3)), (0..4, 12..16));
    }

    #[test]
    fn places_are_at_the_edge_or_so_far_from_the_hit() {
        let even = ply(r#""elements_per_crossover": 1"#);
        let at_edge = |ply: &PlyLayout, element| ply.is_at_edge(element, |_| true);
        assert!(at_edge(&even, [0, 8]) && at_edge(&even, [1, 8]) && at_edge(&even, [8, 15]));
        assert!(!at_edge(&even, [2, 8]) && !at_edge(&even, [8, 13]));
        // An element of four crossovers lies at the edge too.
        let coarse = ply(r#""crossovers_per_element": 4"#);
        assert!(at_edge(&coarse, [0, 1]) && at_edge(&coarse, [2, 3]) && !at_edge(&coarse, [1, 2]));
        // The middle of the element beside the centre is half a crossover off both ways.
        assert!((even.distance([8, 8], [0.0, 0.0]) - 0.635e-3 * 2.0_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn fabric_that_tears_off_its_frame_before_it_breaks_at_the_hit_is_warned_of() {
        let sets = [
            "/pack/width_mm=30",
            "/pack/height_mm=30",
            "/solver/end_time_us=1",
            "/solver/numerics=paper",
            "/expect=[]",
        ];
        let case = crate::case::shipped(&sets);
        let run = run::run(&case, Options::default(), &AtomicBool::new(false), &mut ()).unwrap();
        let middle = [case.pack.mesh.count[0] as u32 / 2, case.pack.mesh.count[1] as u32 / 2];
        let hit = |step| FailureEvent { step, ply: 0, i: middle[0], j: middle[1], yarn: 0, strain: 0.04 };
        let edge = |step| FailureEvent { i: 0, ..hit(step) };
        let with = |outcome: Outcome, events: &[FailureEvent]| {
            let mut run = run.clone();
            (run.outcome, run.events) = (outcome, events.to_vec());
            let check = checks(&case, &run).into_iter().find(|check| check.name == "broken at the edges").unwrap();
            let warned = check.warning.is_some_and(|warning| warning.kind.code == "W8");
            assert_eq!(check.level, if warned { Level::Look } else { Level::Fine });
            (warned, check.value)
        };
        assert_eq!(with(Outcome::Stopped, &[]), (false, "0".to_owned()));
        assert_eq!(with(Outcome::Stopped, &[hit(1), edge(2)]), (false, "1".to_owned()));
        assert_eq!(with(Outcome::Stopped, &[hit(1), edge(2), edge(3)]), (true, "2".to_owned()));
        // What breaks behind a projectile that is through decides nothing.
        assert_eq!(with(Outcome::Perforated, &[hit(1), edge(2), edge(3)]), (false, "0".to_owned()));
        assert_eq!(with(Outcome::Perforated, &[edge(2), edge(3), hit(4), edge(5)]), (true, "2".to_owned()));
        // No frame is there to tear off where a side is free.
        let free = crate::case::shipped(&[&sets[..], &[r#"/pack/edges={"left": "free"}"#]].concat());
        let broken = Breakage::of(&free, &Run { events: vec![hit(1), edge(2), edge(3)], ..run.clone() });
        assert_eq!((broken.at_edges, broken.torn_off), (2, 0));
    }
}
