//! Animation of a run: few, coarse keyframes of what is computed, for the playback and the maps of the report.
//!
//! Grid lines lie dense around the point of impact and sparse far from it; of a thick pack some plies are shown; of a scene
//! that is its own mirror image there is the part that is computed. Keyframes are taken when frames are (`Schedule`), so that
//! they lie evenly over a run of any length. A checkpoint carries the animation so far.

use std::collections::HashSet;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::surface::SurfaceMesh;
use crate::case::Case;
use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::physics::rigid_body::MirrorPlanes;
use crate::physics::rigid_body::RigidBody;
use crate::run::frame::{Schedule, even};

use crate::run::{Observer, View, attached};
use crate::solver::element_totals::field as element;
use crate::solver::node_update::field as node;
use crate::solver::state::State;

/// Keyframes shown at most, the first and the last among them.
const KEYFRAMES: usize = 61;
/// Nodes of a keyframe at most, about.
const NODES: usize = 5000;
/// Plies shown at most.
const PLIES: usize = 8;
/// Squared force of a yarn that is broken.
const BROKEN: f64 = -1.0;
/// Grid lines on either side of the point of impact that are all kept.
const DENSE: usize = 8;

/// All plies shown at one time; nodes and cells follow each other ply by ply.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Keyframe {
    /// Steps done.
    pub step: u64,
    /// [s]
    pub time: f64,
    /// Largest deflection of each ply, of fabric that is attached to a support [m].
    pub deflections: Vec<f64>,
    /// Displacement of the nodes [m].
    pub displacement: Vec<[f32; 3]>,
    /// Largest force of a yarn in a cell, as its elements carry it, warp and weft [N]; `None` where no yarn of that direction
    /// goes through the cell from end to end.
    pub tension: Vec<[Option<f32>; 2]>,
    /// Position of the projectile's centre of mass [m], and its rotation as a quaternion w, x, y, z.
    pub pose: Option<[f64; 7]>,
}

impl Keyframe {
    /// Largest deflection of any ply shown, of fabric that is attached to a support [m].
    pub fn deflection(&self) -> f64 {
        self.deflections.iter().copied().fold(0.0, f64::max)
    }
}

/// A ply as the animation shows it: cells between the grid lines that are kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct AnimatedPly {
    /// Number, counted from the struck side.
    pub ply: usize,
    /// Grid lines kept along the warp and along the weft, counted in the whole ply.
    pub lines: [Vec<usize>; 2],
    /// Elements of the whole ply along warp and weft.
    pub elements: [usize; 2],
    /// Grid lines along the weft and along the warp nearest to the point of impact, among those kept.
    pub hit: [usize; 2],
    /// Reference positions of the nodes kept, in the axes of the pack, row by row [m].
    pub reference: Vec<[f32; 3]>,
    /// The lines, counted in the part that is computed.
    own: [Vec<usize>; 2],
}

impl AnimatedPly {
    fn new<S: Scalar>(model: &Model<S>, ply: usize, hit: [f64; 2], most: usize) -> Self {
        let mesh = &model.ply_type(ply).mesh;
        let place = mesh.to_ply([hit[0], hit[1], 0.0]);
        let (counts, first) = ([mesh.columns, mesh.rows], mesh.first_in_whole());
        let nearest = [0, 1].map(|a| mesh.nearest_line(a, place[a]));
        let own = [0, 1].map(|a| kept_lines(counts[a], nearest[a], (most as f64).sqrt() as usize));
        let reference = own[1].iter().flat_map(|row| own[0].iter().map(move |column| (*row, *column)));
        Self {
            ply,
            elements: mesh.whole_counts(),
            hit: [0, 1].map(|a| own[a].partition_point(|line| *line < nearest[a])),
            reference: reference.map(|(row, column)| model.reference(ply, row, column).map(|x| x as f32)).collect(),
            lines: [0, 1].map(|a| own[a].iter().map(|line| line + first[a]).collect()),
            own,
        }
    }

    /// A row of nodes at these places.
    #[cfg(test)]
    pub(super) fn for_tests(reference: Vec<[f32; 3]>) -> Self {
        let lines: [Vec<usize>; 2] = [(0..reference.len()).collect(), vec![0]];
        Self { ply: 0, elements: [reference.len(), 1], hit: [0; 2], reference, own: lines.clone(), lines }
    }

    /// Whether lists that belong together are of one length, and all places are within them.
    fn is_sound(&self) -> bool {
        self.reference.len() == self.lines[0].len() * self.lines[1].len()
            && (0..2).all(|a| {
                self.own[a].len() == self.lines[a].len()
                    && self.hit[a] < self.lines[a].len()
                    && self.lines[a].last().is_some_and(|last| *last <= self.elements[a])
                    && self.lines[a].is_sorted()
            })
    }

    /// Cells along warp and weft.
    pub fn counts(&self) -> [usize; 2] {
        self.own.each_ref().map(|lines| lines.len().saturating_sub(1))
    }

    /// Cells.
    pub fn cells(&self) -> usize {
        self.counts().iter().product()
    }

    /// Displacements of the nodes kept of a row.
    fn displacements<S: Scalar>(&self, model: &Model<S>, state: &State<S>, row: usize, out: &mut [[f32; 3]]) {
        let mesh = &model.ply_type(self.ply).mesh;
        let row = state.nodes.row(model.grid.first_node_row(self.ply) + row);
        let [x, y, z] = [0, 1, 2].map(|a| &row[(node::DISPLACEMENT + a) * state.nodes.stride..]);
        for (column, out) in self.own[0].iter().zip(out) {
            *out = mesh.to_pack([x, y, z].map(|u| u[*column].to_f64())).map(|u| u as f32);
        }
    }

    /// Tensions in a row of cells, between two rows of nodes.
    fn tensions<S: Scalar>(&self, model: &Model<S>, state: &State<S>, rows: &[usize], cells: &mut [[Option<f32>; 2]]) {
        // From the force of an element to that of one of its yarns.
        let per_yarn = model.ply_type(self.ply).element.membrane.map(|membrane| (1.0 / membrane) as f32);
        let first = model.grid.first_element_row(self.ply);
        let columns = self.own[0].last().map_or(0, |last| *last);
        let mut most = vec![[BROKEN; 2]; cells.len()];
        // A warp yarn goes through a cell along a row of elements, a weft yarn along a column.
        let mut wefts = vec![0.0; columns];
        for row in rows[0]..rows[1] {
            let [warps, here] = squares(state.elements.row(first + row), state.elements.stride, columns);
            for (cell, span) in most.iter_mut().zip(self.own[0].windows(2)) {
                cell[0] = warps[span[0]..span[1]].iter().copied().fold(0.0, end_to_end).max(cell[0]);
            }
            wefts.iter_mut().zip(here).for_each(|(all, one)| *all = end_to_end(*all, one));
        }
        for ((cell, most), span) in cells.iter_mut().zip(&mut most).zip(self.own[0].windows(2)) {
            most[1] = wefts[span[0]..span[1]].iter().copied().fold(BROKEN, f64::max);
            *cell = [0, 1].map(|yarn| (most[yarn] != BROKEN).then(|| per_yarn[yarn] * most[yarn].sqrt() as f32));
        }
    }
}

/// Squared force of the yarns in a row of elements, warp and weft [N²].
fn squares<S: Scalar>(row: &[S], stride: usize, columns: usize) -> [Vec<f64>; 2] {
    [element::WARP_FORCE, element::WEFT_FORCE].map(|force| {
        // Element c is at c + 1.
        let field = |field: usize| &row[field * stride + 1..field * stride + 1 + columns];
        let yarn = usize::from(force == element::WEFT_FORCE);
        let (alive, axes) = (field(element::ALIVE + yarn), [0, 1, 2].map(|axis| field(force + axis)));
        let square = |column: usize| {
            let [x, y, z] = axes.map(|axis| axis[column].to_f64());
            if alive[column].to_f64() > 0.5 { x * x + y * y + z * z } else { BROKEN }
        };
        (0..columns).map(square).collect()
    })
}

/// The larger of two squared forces along a yarn; a yarn that is broken in one place is broken. What is no number counts as none.
fn end_to_end(one: f64, other: f64) -> f64 {
    if one == BROKEN || other == BROKEN { BROKEN } else { one.max(other) }
}

/// Grid lines to keep, `most` at most, of those from 0 to `last`: gaps grow with the distance from the point of impact at `hit` as
/// little as need be.
fn kept_lines(last: usize, hit: usize, most: usize) -> Vec<usize> {
    let graded = |growth: f64| {
        let gap = |at: usize| 1 + (growth * at.abs_diff(hit).saturating_sub(DENSE) as f64) as usize;
        let down = |at: &usize| (*at > 0).then(|| at.saturating_sub(gap(*at)));
        let up = |at: &usize| (*at < last).then(|| (at + gap(*at)).min(last));
        let mut lines: Vec<usize> = std::iter::successors(Some(hit), down).skip(1).collect();
        lines.reverse();
        lines.extend(std::iter::successors(Some(hit), up));
        lines
    };
    let growths = (0..).map(|n| 0.02 * f64::from(n));
    growths.map(graded).find(|lines| lines.len() <= most.max(2 * DENSE + 8)).unwrap_or_default()
}

/// Plies to show, evenly from the first to the last.
pub(super) fn shown(plies: usize) -> Vec<usize> {
    if plies <= PLIES {
        return (0..plies).collect();
    }
    (0..PLIES).map(|n| (n * (plies - 1) + (PLIES - 1) / 2) / (PLIES - 1)).collect()
}

/// Animation of a run.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Animation {
    /// Plies shown, the struck one first; none before the first keyframe.
    pub plies: Vec<AnimatedPly>,
    /// Plies there are.
    pub ply_count: usize,
    /// In order of time.
    pub keyframes: Vec<Keyframe>,
    /// Mirror planes: shown is the part at x ≥ 0, y ≥ 0.
    pub planes: MirrorPlanes,
    /// Surface of the projectile.
    pub(super) body: Option<SurfaceMesh>,
    /// Point of impact [m].
    hit: [f64; 2],
    schedule: Schedule,
    /// The plies are those of the model; not known of an animation from a checkpoint before its next keyframe.
    begun: bool,
}

impl Animation {
    /// An empty animation of a case.
    pub fn new(case: &Case) -> Self {
        Self {
            plies: Vec::new(),
            ply_count: 0,
            keyframes: Vec::new(),
            planes: MirrorPlanes::NONE,
            body: None,
            hit: case.projectile.as_ref().map_or([0.0; 2], |p| p.offset),
            schedule: Schedule::new(KEYFRAMES, case.solver.end_time),
            begun: false,
        }
    }

    /// Bytes of it that a checkpoint carries.
    pub fn to_bytes(&self) -> Vec<u8> {
        // Writing to memory cannot fail.
        postcard::to_stdvec(&(&self.plies, self.ply_count, &self.keyframes, self.planes, &self.body))
            .unwrap_or_default()
    }

    /// The animation of a run that goes on before the step of this number, `dt` [s] long, from the bytes of a checkpoint; `None` where
    /// those are no animation.
    pub fn resume(case: &Case, bytes: &[u8], step: u64, dt: f64) -> Option<Self> {
        let (plies, ply_count, keyframes, planes, body) = postcard::from_bytes(bytes).ok()?;
        let schedule = Schedule::resume(KEYFRAMES, case.solver.end_time, step, dt);
        let mut animation = Self { plies, ply_count, keyframes, planes, body, schedule, ..Self::new(case) };
        animation.drop_unkept();
        animation.is_sound().then_some(animation)
    }

    /// Whether all parts have the sizes that they need to have.
    fn is_sound(&self) -> bool {
        let nodes: usize = self.plies.iter().map(|ply| ply.reference.len()).sum();
        let cells: usize = self.plies.iter().map(AnimatedPly::cells).sum();
        self.body.as_ref().is_none_or(SurfaceMesh::is_sound)
            && self.plies.iter().all(AnimatedPly::is_sound)
            && self.keyframes.iter().all(|keyframe| {
                let lengths = [keyframe.displacement.len(), keyframe.tension.len(), keyframe.deflections.len()];
                lengths == [nodes, cells, self.plies.len()]
            })
            && self.keyframes.windows(2).all(|pair| pair[0].time < pair[1].time)
    }

    fn take_from(&mut self, view: &View<'_>) {
        match view {
            View::Double(model, state) => self.take(model, state),
            View::Single(model, state) => self.take(model, state),
        }
    }

    fn take<S: Scalar>(&mut self, model: &Model<S>, state: &State<S>) {
        if !self.begun {
            self.begin(model);
        }
        let time = state.step as f64 * model.dt;
        if self.keyframes.last().is_some_and(|last| last.time >= time) {
            return; // the end of the run was due anyway
        }
        // This reads all elements, and the threads of the loop wait meanwhile.
        let of_ply = |ply: &AnimatedPly| {
            let mut displacement = vec![[0.0; 3]; ply.reference.len()];
            let mut tension = vec![[None; 2]; ply.cells()];
            let nodes = displacement.par_chunks_mut(ply.own[0].len().max(1)).zip(&ply.own[1]);
            nodes.for_each(|(nodes, row)| ply.displacements(model, state, *row, nodes));
            let cells = tension.par_chunks_mut(ply.counts()[0].max(1)).zip(ply.own[1].par_windows(2));
            cells.for_each(|(cells, rows)| ply.tensions(model, state, rows, cells));
            (attached(model, state, ply.ply).deflection, displacement, tension)
        };
        let all: Vec<_> = self.plies.par_iter().map(of_ply).collect();
        self.keyframes.push(Keyframe {
            step: state.step,
            time,
            deflections: all.iter().map(|ply| ply.0).collect(),
            displacement: all.iter().flat_map(|ply| ply.1.iter().copied()).collect(),
            tension: all.iter().flat_map(|ply| ply.2.iter().copied()).collect(),
            pose: state.body.as_ref().map(pose),
        });
    }

    fn begin<S: Scalar>(&mut self, model: &Model<S>) {
        self.begun = true;
        self.ply_count = model.plies.len();
        let shown = shown(self.ply_count);
        let nodes = NODES / shown.len().max(1);
        let plies: Vec<AnimatedPly> = shown.iter().map(|ply| AnimatedPly::new(model, *ply, self.hit, nodes)).collect();
        if plies != self.plies {
            self.keyframes.clear(); // of another model
        }
        self.plies = plies;
        self.planes = model.planes;
        let pack = self.plies.iter().flat_map(|ply| &ply.reference);
        self.body = model.projectile.as_ref().map(|projectile| SurfaceMesh::new(&projectile.body, pack));
    }

    /// The animation with this number of keyframes at most, evenly from the first to the last.
    #[must_use]
    pub(super) fn with(&self, keyframes: usize) -> Self {
        let times: Vec<f64> = self.keyframes.iter().map(|keyframe| keyframe.time).collect();
        let keyframes = even(&times, keyframes).into_iter().map(|at| self.keyframes[at].clone()).collect();
        Self { keyframes, ..self.clone() }
    }

    /// The animation with the keyframes that a page shows.
    #[must_use]
    pub fn shown(&self) -> Self {
        self.with(KEYFRAMES)
    }

    /// Largest deflection in any keyframe, of fabric that is attached to a support [m].
    pub fn deflection(&self) -> f64 {
        self.keyframes.iter().map(Keyframe::deflection).fold(0.0, f64::max)
    }

    /// Number of the keyframe of the largest deflection among those in which the projectile has not left the fabric behind.
    pub fn opening(&self) -> usize {
        let is_near = |keyframe: &Keyframe| keyframe.pose.is_none_or(|pose| self.tail(&pose) <= keyframe.deflection());
        let near = (0..self.keyframes.len()).filter(|at| is_near(&self.keyframes[*at]));
        let deflection = |at: usize| self.keyframes[at].deflection();
        near.max_by(|a, b| deflection(*a).total_cmp(&deflection(*b))).unwrap_or(0)
    }

    /// Height of the last part of the projectile, along the normal of the pack [m].
    fn tail(&self, [_, _, height, w, x, y, z]: &[f64; 7]) -> f64 {
        let normal = [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)];
        let points = self.body.iter().flat_map(|body| &body.points);
        let heights = points.map(|point| (0..3).map(|axis| normal[axis] * point[axis]).sum::<f64>());
        height + heights.fold(0.0, f64::min)
    }

    /// Largest tension in any keyframe [N].
    pub fn peak_tension(&self) -> f32 {
        let all = self.keyframes.iter().flat_map(|keyframe| &keyframe.tension).flatten();
        all.flatten().copied().filter(|tension| tension.is_finite()).fold(0.0, f32::max)
    }

    /// Drops the keyframes that the schedule has given up.
    fn drop_unkept(&mut self) {
        let kept: HashSet<u64> = self.schedule.kept().collect();
        self.keyframes.retain(|keyframe| kept.contains(&keyframe.step));
    }
}

impl Observer for Animation {
    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.schedule.is_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        self.take_from(view);
        self.schedule.pass(view.step(), view.clock()[1]);
        self.drop_unkept();
    }

    fn on_end(&mut self, view: &View<'_>) {
        // The last keyframe is that of the end, not of the step before.
        if !self.schedule.wants_end(view.step()) {
            self.keyframes.pop();
        }
        self.take_from(view);
    }
}

fn pose(body: &RigidBody) -> [f64; 7] {
    let (at, q) = (body.position, body.orientation.quaternion());
    [at.x, at.y, at.z, q.w, q.i, q.j, q.k]
}

#[cfg(test)]
#[path = "animation_tests.rs"]
mod tests;
