//! Broken yarns: which, and where.

use std::collections::BTreeSet;

use crate::case::{Case, Edge, Frame, Layer, Opening, Projectile, Shape};
use crate::physics::projectile_body::Body;
use crate::run::outcome::Outcome;
use crate::run::{Run, Sample};

/// Pieces of yarn this near to the line of flight broke at the hit, if no side of the ply is nearer [diameters].
const HIT: f64 = 2.0;
/// Pieces of yarn this near to the side of a ply broke at its edge, if the line of flight is no nearer [crossovers].
const EDGE: f64 = 2.0;
/// Share of what a projectile loses in all after which it is through, and what breaks then decides nothing [-].
const THROUGH: f64 = 0.99;
/// Distance from a clamped side within which a line of flight ends on the frame [m].
const ON_FRAME: f64 = 1e-6;

/// Broken yarns of a run. A yarn that broke in several places is one yarn and as many pieces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Breakage {
    /// Yarns, warp and weft.
    pub yarns: [usize; 2],
    /// Pieces within two diameters of the line of flight, and nearer to it than to a side of the ply.
    pub at_hit: usize,
    /// Other pieces within two crossovers of the side of a ply.
    pub at_edges: usize,
    /// All other pieces.
    pub elsewhere: usize,
    /// Yarns that broke first at an edge that is held, and those that broke first at the hit, until the projectile is through: when the edges
    /// led by most; the final counts where they never led.
    pub torn_first: [usize; 2],
}

impl Breakage {
    /// Pieces of yarn in all.
    pub fn pieces(&self) -> usize {
        self.at_hit + self.at_edges + self.elsewhere
    }

    /// Whether more yarns had broken first at held edges than at the hit, at any time before the projectile was through.
    pub fn is_torn_off(&self) -> bool {
        self.torn_first[0] > self.torn_first[1]
    }

    /// Broken yarns of a run of a case.
    pub fn of(case: &Case, run: &Run) -> Self {
        let layers = case.layers();
        let plies: Vec<PlyLayout> =
            layers.iter().flat_map(|layer| vec![PlyLayout::new(case, layer); layer.plies as usize]).collect();
        let reach = case.projectile.as_ref().map_or(0.0, |p| HIT * p.shape.diameter());
        let decided = through(run);
        let mut broken: [BTreeSet<(u32, usize)>; 2] = Default::default();
        let (mut found, mut now) = (Self::default(), [0; 2]);
        for event in &run.events {
            let (ply, element) = (&plies[event.ply as usize], [event.i as usize, event.j as usize]);
            // A warp yarn runs along X: its number is that of its place along Y.
            let yarn = usize::from(event.yarn.min(1));
            let across = 1 - yarn;
            let numbers = ply.yarns(across, element[across]);
            let new = numbers.filter(|number| broken[yarn].insert((event.ply, *number))).count();
            let to_hit = case.projectile.as_ref().map_or(f64::INFINITY, |p| ply.distance(element, p));
            let is_nearer_to_hit = to_hit <= ply.to_side(element);
            let counts = event.step as f64 * run.time_step <= decided;
            if is_nearer_to_hit && to_hit <= reach {
                found.at_hit += 1;
                now[1] += if counts { new } else { 0 };
            } else if !is_nearer_to_hit && ply.is_at_edge(element, |_| true) {
                found.at_edges += 1;
                let is_held = ply.is_at_edge(element, |edge| edge != Edge::Free);
                now[0] += if counts && is_held { new } else { 0 };
            } else {
                found.elsewhere += 1;
            }
            let lead = |[torn, cut]: [usize; 2]| torn.saturating_sub(cut);
            if lead(now) > lead(found.torn_first) {
                found.torn_first = now;
            }
        }
        if found.torn_first == [0; 2] {
            found.torn_first = now;
        }
        found.yarns = broken.map(|yarns| yarns.len());
        found
    }
}

/// Distance of the hit, at `aim` [m], from the nearest clamped side of any ply [m].
pub(super) fn clearance(case: &Case, aim: [f64; 2]) -> f64 {
    let layers = case.layers();
    let sides = layers.iter().flat_map(|layer| PlyLayout::new(case, layer).inwards(aim));
    sides.filter(|(edge, _)| *edge == Edge::Clamped).map(|(_, from)| from).fold(f64::INFINITY, f64::min)
}

/// Whether no ply has free fabric in the way: the line of flight ends on its frame, or the body passes beside it.
pub(super) fn is_missed(case: &Case, projectile: &Projectile) -> bool {
    let mut aim = projectile.offset;
    if let Shape::Bar { along, .. } = projectile.shape {
        aim[along as usize] = 0.0; // it is as long as the pack
    }
    // What flies or lies aslant sweeps over more of the plane.
    let body = Body::new(projectile).filter(|_| [projectile.obliquity, projectile.yaw] != [0.0; 2]);
    let reach = body.map_or(0.5 * projectile.shape.diameter(), |b| b.bounding_radius / projectile.obliquity.cos());
    let is_off = |(edge, from): (Edge, f64)| from <= if edge == Edge::Clamped { ON_FRAME } else { -reach };
    case.layers().iter().all(|layer| PlyLayout::new(case, layer).inwards(aim).into_iter().any(is_off))
}

/// Time from which on what breaks decides nothing: the projectile has lost nearly all it will lose to the pack that it perforates [s].
fn through(run: &Run) -> f64 {
    let lost = |row: &Sample| run.impact_energy - row.balance.projectile;
    let all = run.history.last().map_or(0.0, lost);
    let is_through = |row: &&Sample| run.outcome == Outcome::Perforated && all > 0.0 && lost(row) >= THROUGH * all;
    run.history.iter().find(is_through).map_or(f64::INFINITY, |row| row.time)
}

/// Places of the elements of a ply.
#[derive(Clone)]
struct PlyLayout {
    /// Lines of nodes along warp and weft [crossovers from the first].
    lines: [Vec<f64>; 2],
    /// Middles of elements along warp and weft, from the middle of the ply [m].
    middles: [Vec<f64>; 2],
    /// Half the size along warp and weft [m].
    half_size: [f64; 2],
    /// Cosine and sine of the warp's angle.
    turn: [f64; 2],
    /// Left and right, bottom and top.
    sides: [[Edge; 2]; 2],
    /// Length of a crossover, the longer one [m].
    crossover: f64,
    frame: Frame,
}

impl PlyLayout {
    fn new(case: &Case, layer: &Layer) -> Self {
        let side = case.pack.crossovers_along_element();
        let lines = layer.node_lines().map(|lines| lines.into_iter().map(|line| line * side).collect());
        let (s, c) = layer.orientation.sin_cos();
        let edges = layer.edges;
        let sides = [[edges.left, edges.right], [edges.bottom, edges.top]];
        let half_size = [0, 1].map(|axis| 0.5 * layer.mesh.count[axis] as f64 * layer.mesh.length[axis]);
        let (frame, crossover) = (layer.mesh.frame, layer.mesh.length[0].max(layer.mesh.length[1]) / side);
        Self { lines, middles: layer.middles(), half_size, turn: [c, s], sides, crossover, frame }
    }

    /// Numbers of the yarns that cross an element of this column or row. An element no wider than a yarn has the one at its middle.
    fn yarns(&self, axis: usize, index: usize) -> std::ops::Range<usize> {
        let [from, to] = [0, 1].map(|end| self.lines[axis][index + end]);
        if to - from <= 1.0 + 1e-6 {
            let only = (0.5 * (from + to)) as usize;
            return only..only + 1;
        }
        let first = (from + 1e-6).floor() as usize;
        first..((to - 1e-6).ceil() as usize).max(first + 1)
    }

    /// Place of the middle of an element in the pack's plane [m].
    fn place(&self, [i, j]: [usize; 2]) -> [f64; 2] {
        let ([x, y], [c, s]) = ([self.middles[0][i], self.middles[1][j]], self.turn);
        [c * x - s * y, s * x + c * y]
    }

    /// Distance of an element from where a projectile strikes: from a bar across it [m].
    fn distance(&self, element: [usize; 2], projectile: &Projectile) -> f64 {
        let [x, y] = self.place(element);
        let mut from = [x - projectile.offset[0], y - projectile.offset[1]];
        if let Shape::Bar { along, .. } = projectile.shape {
            from[along as usize] = 0.0;
        }
        from[0].hypot(from[1])
    }

    /// Distance of an element from the nearest side of the ply, or clamp [m].
    fn to_side(&self, element: [usize; 2]) -> f64 {
        self.inwards(self.place(element)).into_iter().map(|(_, from)| from).fold(f64::INFINITY, f64::min)
    }

    /// Distances of a place in the pack's plane from the sides of the ply, less than nothing beyond them, and from clamps at its corners [m].
    fn inwards(&self, place: [f64; 2]) -> Vec<(Edge, f64)> {
        let ([x, y], [c, s], frame) = (place, self.turn, &self.frame);
        let at = [c * x + s * y, c * y - s * x];
        let [left, right, bottom, top] = match frame.opening {
            Opening::Mesh => {
                [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)].map(|(axis, end)| self.half_size[axis] + at[axis] * end)
            }
            _ => frame.inwards(place),
        };
        let [[a, b], [c, d]] = self.sides;
        let corner = (frame.corner > 0.0).then(|| (Edge::Clamped, left.min(right).max(bottom.min(top)) - frame.corner));
        [(a, left), (b, right), (c, bottom), (d, top)].into_iter().chain(corner).collect()
    }

    /// Whether an element begins near a side of the ply, or a clamp, that `counts`. The outermost always does, however long it is.
    fn is_at_edge(&self, element: [usize; 2], counts: impl Fn(Edge) -> bool) -> bool {
        if !self.frame.is_plain() {
            let widths =
                [0, 1].map(|axis: usize| self.lines[axis][element[axis] + 1] - self.lines[axis][element[axis]]);
            let near = self.crossover * (EDGE + 0.5 * widths[0].max(widths[1]));
            return self.inwards(self.place(element)).into_iter().any(|(edge, from)| counts(edge) && from < near);
        }
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
    use super::*;

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
        let mut projectile = crate::case::shipped(&[]).projectile.unwrap();
        projectile.offset = [0.0; 2];
        assert!((even.distance([8, 8], &projectile) - 0.635e-3 * 2.0_f64.sqrt()).abs() < 1e-9);
        projectile.shape = Shape::Bar { diameter: 4e-3, along: crate::case::Along::Weft };
        assert!((even.distance([8, 0], &projectile) - 0.635e-3).abs() < 1e-9);
        assert!((even.to_side([2, 8]) - 2.5 * 1.27e-3).abs() < 1e-9);
    }
}
