//! The film of a run: few, coarse pictures of the whole, for the playback and the maps of the report.
//!
//! Lines of nodes lie dense around the point of impact and sparse far from it. Of a scene that is its own mirror image
//! one part is kept, of a thick pack some plies. Of many frames every second one is dropped as often as need be.

use super::outline;
use crate::case::Case;
use crate::frame::{Frame, PlyMesh, Pose, Scene};
use crate::model::MirrorPlanes;

/// Frames asked of a run: enough where it ends early.
pub const FRAMES: usize = 128;
/// Pictures kept at most.
const STILLS: usize = 64;
/// Nodes of a picture at most, about.
const NODES: usize = 9000;
/// Plies shown at most.
const PLIES: usize = 8;
/// Lines of nodes on either side of the point of impact that are all kept.
const DENSE: usize = 8;

/// A ply as the film shows it: cells between the lines of nodes that were kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// Counted from the struck side.
    pub ply: usize,
    /// Nodes kept along the warp and along the weft, counted in the whole ply.
    pub lines: [Vec<usize>; 2],
    /// Elements of the whole ply along warp and weft.
    pub elements: [usize; 2],
    /// Line of nodes along the weft, and along the warp, nearest to the point of impact: among those kept.
    pub hit: [usize; 2],
    /// Reference positions of the nodes kept, in the axes of the pack, row by row [m].
    pub reference: Vec<[f32; 3]>,
    /// The same among the nodes of the scene.
    nodes: Vec<usize>,
    /// Elements of each cell: first and behind the last row, and column.
    cells: Vec<[[usize; 2]; 2]>,
    first_element: usize,
}

/// All strips at one time; nodes and cells follow each other strip by strip.
#[derive(Clone, Debug, PartialEq)]
pub struct Still {
    /// [s]
    pub time: f64,
    /// Of the nodes [m].
    pub displacement: Vec<[f32; 3]>,
    /// Largest tension in a cell, warp and weft [N]; `None` where the yarn is broken in all of it.
    pub tension: Vec<[Option<f32>; 2]>,
    /// The projectile.
    pub projectile: Option<Pose>,
}

/// Pictures of a run.
#[derive(Clone, Debug)]
pub struct Film {
    /// Plies shown, the struck one first.
    pub strips: Vec<Strip>,
    /// Plies there are.
    pub plies: usize,
    /// In order of time.
    pub stills: Vec<Still>,
    /// Crossovers along the side of an element.
    pub crossovers: u32,
    /// Mirror planes: shown is the part at x ≥ 0, y ≥ 0.
    pub planes: MirrorPlanes,
    /// Surface of the projectile.
    pub(super) outline: Option<outline::Outline>,
    /// Of the frames every so many-th is a picture.
    stride: usize,
}

impl Film {
    /// An empty film of a scene.
    pub fn new(case: &Case, scene: &Scene) -> Self {
        let hit = case.projectile.as_ref().map_or([0.0; 2], |p| p.offset);
        let shown = shown(scene.plies.len());
        let nodes = NODES / shown.len().max(1);
        let strip = |ply: &usize| Strip::new(scene, *ply, hit, nodes);
        Self {
            strips: shown.iter().map(strip).collect(),
            plies: scene.plies.len(),
            stills: Vec::new(),
            crossovers: case.pack.crossovers_per_element,
            planes: scene.planes,
            outline: scene.projectile.as_ref().map(|body| outline::outline(body, half_width(scene))),
            stride: 1,
        }
    }

    /// Whether a frame of this number is to become a picture.
    pub fn wants(&self, index: usize) -> bool {
        index.is_multiple_of(self.stride)
    }

    /// Takes a picture of a frame.
    pub fn take(&mut self, frame: &Frame) {
        if self.stills.len() == STILLS {
            self.halve();
            if !self.wants(frame.index) {
                return;
            }
        }
        let nodes = self.strips.iter().flat_map(|strip| &strip.nodes);
        self.stills.push(Still {
            time: frame.time,
            displacement: nodes.map(|node| frame.displacement[*node]).collect(),
            tension: self.strips.iter().flat_map(|strip| strip.tensions(frame)).collect(),
            projectile: frame.projectile,
        });
    }

    /// Drops every second picture.
    pub(super) fn halve(&mut self) {
        let mut index = 0;
        self.stills.retain(|_| {
            index += 1;
            index % 2 == 1
        });
        self.stride *= 2;
    }

    /// Largest tension in any picture [N].
    pub fn peak_tension(&self) -> f32 {
        let all = self.stills.iter().flat_map(|still| &still.tension).flatten();
        all.flatten().copied().filter(|tension| tension.is_finite()).fold(0.0, f32::max)
    }
}

/// Plies to show, evenly from the first to the last.
fn shown(plies: usize) -> Vec<usize> {
    if plies <= PLIES {
        return (0..plies).collect();
    }
    (0..PLIES).map(|n| (n * (plies - 1) + (PLIES - 1) / 2) / (PLIES - 1)).collect()
}

/// Half the extent of the pack [m].
fn half_width(scene: &Scene) -> f64 {
    scene.reference.iter().map(|at| at[0].abs().max(at[1].abs())).fold(0.0, f32::max).into()
}

impl Strip {
    fn new(scene: &Scene, ply: usize, hit: [f64; 2], most: usize) -> Self {
        let mesh = &scene.plies[ply];
        let counts = [mesh.columns, mesh.rows];
        let side = (most as f64).sqrt() as usize;
        let axes = [0, 1].map(|own| Axis::new(scene, mesh, own, hit));
        let lines = axes.map(|axis| axis.lines(side));
        let hit = [0, 1].map(|own| nearest(&lines[own], axes[own].hit));
        let nodes: Vec<usize> = lines[1]
            .iter()
            .flat_map(|row| lines[0].iter().map(move |column| mesh.first_node + row * (mesh.columns + 1) + column))
            .collect();
        let pairs = |own: usize| lines[own].windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>();
        let (columns, rows) = (pairs(0), pairs(1));
        Self {
            ply,
            elements: counts,
            hit,
            reference: nodes.iter().map(|node| scene.reference[*node]).collect(),
            cells: rows.iter().flat_map(|row| columns.iter().map(move |column| [*row, *column])).collect(),
            nodes,
            lines,
            first_element: mesh.first_element,
        }
    }

    /// Cells along warp and weft.
    pub fn counts(&self) -> [usize; 2] {
        [0, 1].map(|own| self.lines[own].len().saturating_sub(1))
    }

    fn tensions(&self, frame: &Frame) -> impl Iterator<Item = [Option<f32>; 2]> {
        self.cells.iter().map(move |[rows, columns]| {
            [0, 1].map(|yarn| {
                let elements = (rows[0]..rows[1])
                    .flat_map(|row| (columns[0]..columns[1]).map(move |column| (row, column)))
                    .map(|(row, column)| self.first_element + row * self.elements[0] + column);
                let whole = elements.filter(|at| frame.alive[yarn][*at] > 0);
                whole.map(|at| frame.tension[yarn][at]).reduce(f32::max)
            })
        })
    }
}

/// Nodes of a ply along one of its own axes.
#[derive(Clone, Copy)]
struct Axis {
    /// First and last that are kept: all of them, or those on one side of a mirror plane.
    ends: [usize; 2],
    /// Nearest to the point of impact, among those.
    hit: usize,
}

impl Axis {
    fn new(scene: &Scene, mesh: &PlyMesh, own: usize, hit: [f64; 2]) -> Self {
        let count = [mesh.columns, mesh.rows][own];
        let place = |node: usize| scene.reference[mesh.first_node + node].map(f64::from);
        let from = place(0);
        let to = place([1, mesh.columns + 1][own]);
        let step = [to[0] - from[0], to[1] - from[1]];
        let length = step[0].hypot(step[1]);
        let at = ((hit[0] - from[0]) * step[0] + (hit[1] - from[1]) * step[1]) / (length * length);
        let cut = (0..2).find(|axis| scene.planes.0[*axis] && step[*axis].abs() > 0.5 * length);
        let ends = match cut {
            Some(axis) if step[axis] > 0.0 => [count / 2, count],
            Some(_) => [0, count / 2],
            None => [0, count],
        };
        Self { ends, hit: (at.round().max(0.0) as usize).clamp(ends[0], ends[1]) }
    }

    /// Lines to keep, at most so many: gaps grow with the distance from the point of impact as little as need be.
    fn lines(self, most: usize) -> Vec<usize> {
        let growths = (0..).map(|n| 0.02 * f64::from(n));
        let found = growths.map(|growth| self.graded(growth)).find(|lines| lines.len() <= most.max(2 * DENSE + 8));
        found.unwrap_or_default()
    }

    fn graded(self, growth: f64) -> Vec<usize> {
        let [first, last] = self.ends;
        let gap = |at: usize| 1 + (growth * at.abs_diff(self.hit).saturating_sub(DENSE) as f64) as usize;
        let next = |at: &usize, end: usize| {
            (*at != end).then(|| {
                let step = gap(*at).min(at.abs_diff(end));
                if end > *at { at + step } else { at - step }
            })
        };
        let down = std::iter::successors(Some(self.hit), |at| next(at, first)).skip(1);
        let up = std::iter::successors(Some(self.hit), |at| next(at, last));
        let mut lines: Vec<usize> = down.chain(up).collect();
        lines.sort_unstable();
        lines
    }
}

/// Index of the line that is a node, or lies next to it.
fn nearest(lines: &[usize], node: usize) -> usize {
    lines.partition_point(|line| *line < node).min(lines.len().saturating_sub(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_dense_around_the_impact_and_end_at_the_edges() {
        let axis = Axis { ends: [0, 160], hit: 80 };
        assert_eq!(axis.lines(161).len(), 161);
        let few = axis.lines(60);
        assert!(few.len() <= 60 && few.len() > 50, "{}", few.len());
        assert_eq!((few[0], few[few.len() - 1]), (0, 160));
        let dense = few.iter().filter(|line| line.abs_diff(80) <= DENSE).count();
        assert_eq!(dense, 2 * DENSE + 1);
        assert!(few.windows(2).all(|pair| pair[0] < pair[1]));
        let half = Axis { ends: [80, 160], hit: 80 }.lines(30);
        assert_eq!((half[0], half[half.len() - 1]), (80, 160));
    }

    #[test]
    fn first_and_last_of_many_plies_are_shown() {
        assert_eq!(shown(3), [0, 1, 2]);
        assert_eq!(shown(50), [0, 7, 14, 21, 28, 35, 42, 49]);
        for plies in 9..65 {
            let shown = shown(plies);
            assert!(shown.len() == PLIES && shown[0] == 0 && shown[PLIES - 1] == plies - 1, "{plies}");
            assert!(shown.windows(2).all(|pair| pair[0] < pair[1]), "{plies}");
        }
    }
}
