//! Grading of a mesh: elements of the finest size around the hit, growing away from it.

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::millimetres;
use super::keys::{WordOr, choices};
use super::provenance::Provenance;
use super::{Accuracy, Case, CaseError, Layer, MeshSize, Shape};

/// Fine elements reach this far from the projectile's wall by default, over its radius [-].
const FINE_RADII: f64 = 1.0;
/// Depth to which a point pushes a ply in before a yarn under it breaks, over the ply's smaller side [-]: slopes of a quarter stretch yarns by 3 %.
const PUSHED_IN: f64 = 0.125;
/// Crossovers along a side of the largest elements by default, and where the result is to be converged.
const LARGEST: [u32; 2] = [6, 2];
/// Places closer than this to a line of nodes are on it, over the element length [-].
const ON_LINE: f64 = 1e-6;

/// Region where a mesh is fine, and its growth beyond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grading {
    /// Where the projectile meets the pack's plane, in the pack's axes [m].
    pub hit: [f64; 2],
    /// Way along X and Y while the projectile is in the pack, or may slide over it [m].
    pub way: [f64; 2],
    /// Around that way elements are of the finest size, up to this distance along X and Y [m].
    pub fine: [f64; 2],
    /// Largest ratio of neighbouring elements' lengths.
    pub growth_ratio: f64,
    /// Largest length of an element over the finest.
    pub max_size: f64,
    /// Where lines are counted from.
    pub lines_from: LinesFrom,
}

choices! {
    /// Origin of the lines of nodes of a graded mesh.
    pub enum LinesFrom {
        /// Two lines cross where the projectile hits, so that the mesh around a hit does not depend on its place in the weave.
        Hit = "hit",
        /// Lines lie whole finest elements from the edges of the ply.
        Edges = "edges",
    }
    pub(super) enum GradingWord {
        None = "none",
        Graded = "graded",
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
pub(super) struct GradingKeys {
    /// Up to this distance from the projectile's way through the pack, along warp and weft, elements have
    /// crossovers_per_element. The way of a point that strikes obliquely goes on while it pushes the ply in, by an eighth of
    /// the smaller side, at most that far.
    ///
    /// Otherwise: two radii of the projectile, and as far as a yawed tail swings out.
    #[schemars(rename = "fine_radius_mm", range(min = 0, max = 1e5))]
    fine_radius: Option<f64>,
    /// Largest ratio of the lengths of neighbouring elements.
    ///
    /// Default: measured: smaller ones keep the outcome no better.
    #[schemars(range(min = 1, max = 2), extend("default" = 1.2))]
    growth_ratio: f64,
    /// Crossovers along a side of the largest elements. Waves lose energy in large ones: a limit is a few per cent low.
    ///
    /// Otherwise: numerics and accuracy: six (converged: two), no fewer than crossovers_per_element.
    #[schemars(range(min = 1, max = 64))]
    max_crossovers: Option<u32>,
    /// Where lines of nodes are counted from: the hit, at which two of them cross, or the edges of the ply.
    ///
    /// Default: measured: the result does not depend on where in a cell the projectile hits.
    #[schemars(extend("default" = "hit"))]
    lines_from: LinesFrom,
}

impl Case {
    /// The grading of the pack, which has this depth [m]. `graded`: whether it is graded where nothing is said.
    pub(super) fn graded(&self, graded: bool, depth: f64, record: &Provenance) -> Result<Option<Grading>, CaseError> {
        let (pack, projectile) = (&self.pack, self.projectile.as_ref());
        let at = |key: &str| format!("/pack/mesh_grading{key}");
        if pack.mesh_grading.is_none() {
            record.derive_text(&at(""), if graded { "graded" } else { "none" }, "", false);
        }
        let keys = match pack.mesh_grading {
            Some(WordOr::Keys(keys)) => keys,
            Some(WordOr::Word(GradingWord::Graded)) => record.defaults(&at(""))?,
            None if graded => record.defaults(&at(""))?,
            None | Some(WordOr::Word(GradingWord::None)) => return Ok(None),
        };
        let fine = match (keys.fine_radius, projectile) {
            (Some(radius), _) => radius,
            (None, Some(projectile)) => {
                let [diameter, length] = projectile.shape.sizes();
                let radius = 0.5 * diameter * (1.0 + FINE_RADII) + length * projectile.yaw.sin().abs();
                record.derive(&at("/fine_radius_mm"), radius, "", false)
            }
            (None, None) => {
                let found = "nothing, and no projectile to take it from";
                let help = "give fine_radius_mm: without a projectile the mesh is fine around the pack's centre";
                return Err(CaseError::at(at("/fine_radius_mm"), "a radius", found).help(help));
            }
        };
        let (side, finest) = (pack.crossovers_along_element(), pack.crossovers_per_element);
        let coarsest = f64::from(keys.max_crossovers.unwrap_or_else(|| {
            let largest = LARGEST[usize::from(self.solver.accuracy == Accuracy::Converged)].max(finest);
            record.derive_text(&at("/max_crossovers"), largest, "", false);
            largest
        }));
        if coarsest < side {
            let finest = "the crossovers along a side of the finest (crossovers_per_element), which are";
            let expected = format!("at least {finest} {side}");
            return Err(CaseError::at(at("/max_crossovers"), expected, coarsest.to_string()));
        }
        let GradingKeys { growth_ratio, lines_from, .. } = keys;
        let (hit, way, max_size) = ([0.0; 2], [0.0; 2], coarsest / side);
        let mut grading = Grading { hit, way, fine: [fine; 2], growth_ratio, max_size, lines_from };
        if let Some(p) = projectile {
            grading.hit = p.offset;
            // A point slides over the fabric as far as it moves sideways until the first yarn breaks, beyond 45° at most as far as it is
            // pushed in; a rim breaks yarns early, or holds them.
            let pushed_in = if p.shape.is_pointed() {
                PUSHED_IN * pack.opening().into_iter().fold(f64::INFINITY, f64::min)
            } else {
                0.0
            };
            let slope = p.obliquity.tan();
            let across = depth * slope + pushed_in * slope.min(1.0);
            grading.way = [across * p.azimuth.cos(), across * p.azimuth.sin()];
            if let Shape::Bar { along, .. } = p.shape {
                grading.fine[along as usize] = f64::INFINITY;
            }
        }
        Ok(Some(grading))
    }
}

impl Grading {
    /// From where to where elements are fine along the axes of a ply whose warp lies at the angle with this cosine and sine [m].
    fn range(&self, [c, s]: [f64; 2]) -> [[f64; 2]; 2] {
        let (from, way) = (turned([c, s], self.hit), turned([c, s], self.way));
        let part = |share: f64, axis: usize| if share.abs() > ON_LINE { share.abs() * self.fine[axis] } else { 0.0 };
        let reach = [part(c, 0) + part(s, 1), part(s, 0) + part(c, 1)];
        [0, 1].map(|a| [from[a] + way[a].min(0.0) - reach[a], from[a] + way[a].max(0.0) + reach[a]])
    }

    /// Lines over `last` finest elements, fine `from` … `to`, around a hit.
    fn lines(&self, last: f64, [from, to]: [f64; 2], hit: f64) -> Vec<f64> {
        // How far lines are off those that lie whole elements from the edges.
        let off = match self.lines_from {
            LinesFrom::Hit if from.is_finite() && (hit - hit.round()).abs() > ON_LINE => hit - hit.floor(),
            _ => 0.0,
        };
        // A line of the fine part. At an edge it ends there, or a whole element before it: none is shorter than the finest.
        let on_line = |place: f64, whole: fn(f64) -> f64| whole(place - off) + off;
        let mut from = on_line(from + ON_LINE, f64::floor).max(0.0);
        let mut to = on_line(to - ON_LINE, f64::ceil).min(last);
        if off > 0.0 {
            if from < 1.0 {
                from = 1.0 + off;
            }
            if to > last - 1.0 {
                to = last - 2.0 + off;
            }
        }
        if to - from < 1.0 || from < 0.0 || to > last {
            from = (from + ON_LINE).floor().clamp(0.0, last - 1.0);
            to = (to - ON_LINE).ceil().clamp(from + 1.0, last);
        }
        let before = growing(from, self.growth_ratio, self.max_size);
        let after = growing(last - to, self.growth_ratio, self.max_size);
        let fine = (0..=(to - from).round() as usize).map(|k| from + k as f64);
        before.iter().rev().map(|at| from - at).chain(fine).chain(after.iter().map(|at| to + at)).collect()
    }

    /// Reach of the fine part and growth beyond it, in words.
    pub(super) fn words(&self) -> String {
        let fine = millimetres(self.fine[0].min(self.fine[1]));
        let way = self.way[0].hypot(self.way[1]);
        let on = if way > 0.0 { format!(", {} further along the way", millimetres(way)) } else { String::new() };
        format!("fine up to {fine} from the hit{on}, growing by {} to {}", self.growth_ratio, self.max_size)
    }
}

impl Layer {
    /// Finest elements along warp and weft, and their length [m].
    fn axes(&self) -> [(f64, f64); 2] {
        let MeshSize { count, length, .. } = self.mesh;
        [0, 1].map(|axis| (count[axis] as f64, length[axis]))
    }

    /// Cosine and sine of the warp's angle.
    fn turn(&self) -> [f64; 2] {
        let (s, c) = self.orientation.sin_cos();
        [c, s]
    }

    /// Places of the lines of nodes along warp and weft, counted in finest elements from the first; `None` where they are even.
    /// `turn`: cosine and sine of the warp's angle.
    pub fn lines(&self, turn: [f64; 2]) -> Option<[Vec<f64>; 2]> {
        let grading = self.mesh.grading?;
        let (range, hit, axes) = (grading.range(turn), turned(turn, grading.hit), self.axes());
        Some([0, 1].map(|axis| {
            let (count, length) = axes[axis];
            let fine = range[axis].map(|at| at / length + 0.5 * count);
            grading.lines(count, fine, hit[axis] / length + 0.5 * count)
        }))
    }

    /// A place between two yarns, along warp and weft, counted in finest elements from the first line of nodes: the hit where lines of nodes
    /// cross there, else the middle of the ply. Yarns are counted from there, so that a result does not depend on where in a cell the projectile
    /// hits. `turn`: cosine and sine of the warp's angle.
    pub(crate) fn between_yarns(&self, turn: [f64; 2]) -> [f64; 2] {
        let axes = self.axes();
        match self.mesh.grading.filter(|grading| grading.lines_from == LinesFrom::Hit) {
            Some(grading) => {
                let hit = turned(turn, grading.hit);
                [0, 1].map(|axis| hit[axis] / axes[axis].1 + 0.5 * axes[axis].0)
            }
            None => axes.map(|(count, _)| (0.5 * count).floor()),
        }
    }

    /// Places of the lines of nodes along warp and weft, even or not, counted in finest elements from the first.
    pub(crate) fn node_lines(&self) -> [Vec<f64>; 2] {
        let even = || self.mesh.count.map(|count| (0..=count).map(|k| k as f64).collect());
        self.lines(self.turn()).unwrap_or_else(even)
    }

    /// Reference places of the middles of elements along warp and weft, from the middle of the ply, in its own axes [m].
    pub fn middles(&self) -> [Vec<f64>; 2] {
        let (lines, axes) = (self.node_lines(), self.axes());
        [0, 1].map(|axis: usize| {
            let (count, length) = axes[axis];
            lines[axis].windows(2).map(|pair| (0.5 * (pair[0] + pair[1]) - 0.5 * count) * length).collect()
        })
    }

    /// Elements along warp and weft.
    pub fn counts(&self) -> [usize; 2] {
        self.lines(self.turn()).map_or(self.mesh.count, |lines| lines.map(|lines| lines.len() - 1))
    }
}

/// A vector of the pack's axes in those of a ply.
fn turned([c, s]: [f64; 2], [x, y]: [f64; 2]) -> [f64; 2] {
    [c * x + s * y, c * y - s * x]
}

/// Ends of elements that grow by at most `growth` from 1 to `coarsest` and fill `room`: as few as that takes. None is shorter than 1 where
/// the room is not; in a room of a few elements they may be longer than the growth allows.
fn growing(room: f64, growth: f64, coarsest: f64) -> Vec<f64> {
    // Ends of more and more elements, each by what the one before was.
    let ends = |growth: f64| {
        std::iter::successors(Some((0.0, 1.0_f64)), move |(at, width)| {
            let width = (width * growth).min(coarsest);
            Some((at + width, width))
        })
        .map(|(at, _)| at)
    };
    let count = ends(growth).take_while(|at| *at < room).count();
    if count as f64 > room + ON_LINE {
        let count = room.max(1.0) as usize;
        return (1..=count).map(|end| room * end as f64 / count as f64).collect();
    }
    // The growth with which they fill it exactly.
    let is_short = |growth: f64| ends(growth).nth(count).is_some_and(|length| length < room);
    let (mut low, mut high) = (1.0, growth);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if is_short(middle) { low = middle } else { high = middle }
    }
    let mut ends: Vec<f64> = ends(if is_short(low) { high } else { low }).skip(1).take(count).collect();
    if let Some(last) = ends.last_mut() {
        *last = room;
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines of a mesh of 40 finest elements that is fine within 4 of a hit.
    fn lines_around(hit: f64, lines_from: LinesFrom) -> Vec<f64> {
        let grading =
            Grading { hit: [0.0; 2], way: [0.0; 2], fine: [0.0; 2], growth_ratio: 1.2, max_size: 3.0, lines_from };
        grading.lines(40.0, [hit - 4.0, hit + 4.0], hit)
    }

    fn widths(lines: &[f64]) -> Vec<f64> {
        lines.windows(2).map(|pair| pair[1] - pair[0]).collect()
    }

    #[test]
    fn a_line_goes_through_the_hit_and_no_element_is_shorter_than_the_finest() {
        for tenth in 0..=400 {
            let hit = f64::from(tenth) / 10.0;
            let lines = lines_around(hit, LinesFrom::Hit);
            assert_eq!((lines[0], lines[lines.len() - 1]), (0.0, 40.0), "{hit}");
            let widths = widths(&lines);
            assert!(widths.iter().all(|width| *width > 1.0 - 1e-9 && *width <= 3.0 + 1e-9), "{hit}: {widths:?}");
            // Closer to the edge than an element there is no room for a line of its own.
            let at_line = lines.iter().any(|line| (line - hit).abs() < 1e-9);
            assert!(at_line || !(1.0..=39.0).contains(&hit), "{hit}: {lines:?}");
        }
    }

    #[test]
    fn the_mesh_around_a_hit_does_not_depend_on_its_place_in_a_cell() {
        let around = |hit: f64| {
            let lines = lines_around(hit, LinesFrom::Hit);
            let near = lines.iter().filter(|line| (**line - hit).abs() < 4.0 + 1e-9);
            near.map(|line| ((line - hit) * 1e6).round()).collect::<Vec<_>>()
        };
        assert_eq!(around(20.0).len(), 9);
        assert!([20.25, 20.5, 19.9, 14.3].into_iter().all(|hit| around(hit) == around(20.0)));
        let [even, shifted] = [20.0, 20.5].map(|hit| lines_around(hit, LinesFrom::Edges));
        assert!(even.contains(&20.0) && shifted.contains(&20.0) && !shifted.contains(&20.5));
    }
}
