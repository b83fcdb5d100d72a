//! Animation of a run: few, coarse keyframes of what is computed, for the playback of the report.
//!
//! Grid lines lie dense around the point of impact and sparse far from it; of a thick pack some plies are shown; of a scene
//! that is its own mirror image there is the part that is computed. Keyframes are taken when frames are (`Schedule`), so that
//! they lie evenly over a run of any length. A checkpoint carries the animation so far.

use std::ops::Range;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::surface::SurfaceMesh;
use crate::case::Case;
use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::physics::rigid_body::MirrorPlanes;
use crate::run::frame::{Pose, Schedule};
use crate::run::{Observer, View, attached};
use crate::solver::failure::yarn_tension;
use crate::solver::state::State;

/// Keyframes at least, where a run has as many steps; twice as many at most.
pub(crate) const KEYFRAMES: usize = 41;
/// Nodes of a keyframe at most, about.
const NODES: usize = 5000;
/// Plies shown at most.
const PLIES: usize = 8;
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
    /// Largest tension of a yarn in a cell, warp and weft, in the step before [N]; `None` where no yarn of that direction goes through the
    /// cell from end to end.
    pub tension: Vec<[Option<f32>; 2]>,
    /// The projectile, where there is one.
    pub pose: Option<Pose>,
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
    /// Reference positions of the nodes kept, in the axes of the pack, row by row [m].
    pub reference: Vec<[f32; 3]>,
    /// The lines, counted in the part that is computed.
    pub(crate) own: [Vec<usize>; 2],
}

impl AnimatedPly {
    fn new<S: Scalar>(model: &Model<S>, ply: usize, hit: [f64; 2], most: usize) -> Self {
        let mesh = &model.ply_type(ply).mesh;
        let place = mesh.to_ply([hit[0], hit[1], 0.0]);
        let (counts, first) = ([mesh.columns, mesh.rows], mesh.first_in_whole());
        let nearest = [0, 1].map(|a| mesh.nearest_line(a, place[a]));
        let own = [0, 1].map(|a| kept_lines(counts[a], nearest[a], (most as f64).sqrt() as usize));
        let lines = [0, 1].map(|a| own[a].iter().map(|line| line + first[a]).collect());
        let mut new = Self { ply, reference: Vec::new(), lines, own };
        new.reference = new.of_nodes(|row, column| model.reference(ply, row, column));
        new
    }

    /// Vectors of the nodes kept, row by row.
    fn of_nodes(&self, of: impl Fn(usize, usize) -> [f64; 3]) -> Vec<[f32; 3]> {
        let nodes = self.own[1].iter().flat_map(|row| self.own[0].iter().map(move |column| (*row, *column)));
        nodes.map(|(row, column)| of(row, column).map(|x| x as f32)).collect()
    }

    /// Displacements of the nodes kept.
    fn displacement<S: Scalar>(&self, model: &Model<S>, state: &State<S>) -> Vec<[f32; 3]> {
        let (mesh, first) = (&model.ply_type(self.ply).mesh, model.grid.first_node_row(self.ply));
        self.of_nodes(|row, column| mesh.to_pack(state.displacement(first + row, column)))
    }

    /// Tensions in the cells. A yarn that is broken in one place is broken from end to end of a cell.
    fn tension<S: Scalar>(&self, model: &Model<S>, state: &State<S>) -> Vec<[Option<f32>; 2]> {
        let first = model.grid.first_element_row(self.ply);
        let tension = |yarn: usize, row: usize, column: usize| {
            let is_alive = state.alive(first + row, column, yarn);
            is_alive.then(|| yarn_tension(model, state, self.ply, yarn, (row, column)) as f32)
        };
        // A warp yarn goes through a cell along a row of elements, a weft yarn along a column.
        let cell = |rows: Range<usize>, columns: Range<usize>| {
            let warp = |row| columns.clone().try_fold(0.0_f32, |most, column| Some(most.max(tension(0, row, column)?)));
            let weft = |column| rows.clone().try_fold(0.0_f32, |most, row| Some(most.max(tension(1, row, column)?)));
            [rows.clone().filter_map(warp).reduce(f32::max), columns.clone().filter_map(weft).reduce(f32::max)]
        };
        let of_row = |rows: &[usize]| {
            let spans = self.own[0].windows(2);
            spans.map(|columns| cell(rows[0]..rows[1], columns[0]..columns[1])).collect::<Vec<_>>()
        };
        // This reads all elements, and the threads of the loop wait meanwhile.
        self.own[1].par_windows(2).flat_map_iter(of_row).collect()
    }
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
pub(crate) fn shown(plies: usize) -> Vec<usize> {
    if plies <= PLIES {
        return (0..plies).collect();
    }
    (0..PLIES).map(|n| (n * (plies - 1) + (PLIES - 1) / 2) / (PLIES - 1)).collect()
}

/// Animation of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
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
    pub(crate) body: Option<SurfaceMesh>,
    /// Point of impact [m].
    hit: [f64; 2],
    schedule: Schedule,
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
        }
    }

    /// Bytes of it that a checkpoint carries.
    pub fn to_bytes(&self) -> Vec<u8> {
        // Writing to memory cannot fail.
        postcard::to_stdvec(self).unwrap_or_default()
    }

    /// The animation so far from the bytes of a checkpoint; `None` where those are none.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        postcard::from_bytes(bytes).ok()
    }

    fn take_from(&mut self, view: &View<'_>) {
        match view {
            View::Double(model, state) => self.take(model, state),
            View::Single(model, state) => self.take(model, state),
        }
    }

    fn take<S: Scalar>(&mut self, model: &Model<S>, state: &State<S>) {
        if self.plies.is_empty() {
            self.begin(model);
        }
        let time = state.step as f64 * model.dt;
        if self.keyframes.last().is_some_and(|last| last.time >= time) {
            return; // the end of the run was due anyway
        }
        let plies = || self.plies.par_iter();
        let keyframe = Keyframe {
            step: state.step,
            time,
            deflections: plies().map(|ply| attached(model, state, ply.ply).deflection).collect(),
            displacement: plies().flat_map_iter(|ply| ply.displacement(model, state)).collect(),
            tension: plies().flat_map_iter(|ply| ply.tension(model, state)).collect(),
            pose: state.body.as_ref().map(Pose::from),
        };
        self.keyframes.push(keyframe);
    }

    fn begin<S: Scalar>(&mut self, model: &Model<S>) {
        self.ply_count = model.plies.len();
        let shown = shown(self.ply_count);
        let nodes = NODES / shown.len().max(1);
        self.plies = shown.iter().map(|ply| AnimatedPly::new(model, *ply, self.hit, nodes)).collect();
        self.planes = model.planes;
        let pack = self.plies.iter().flat_map(|ply| &ply.reference);
        self.body = model.projectile.as_ref().map(|projectile| SurfaceMesh::new(&projectile.body, pack));
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
    fn tail(&self, pose: &Pose) -> f64 {
        let ([w, x, y, z], height) = (pose.rotation, pose.position[2]);
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
}

impl Observer for Animation {
    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.schedule.is_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        self.take_from(view);
        self.schedule.pass(view.step(), view.clock()[1]);
        self.keyframes.retain(|keyframe| self.schedule.keeps(keyframe.step));
    }

    fn on_end(&mut self, view: &View<'_>) {
        // The last keyframe is that of the end, not of the step before.
        if !self.schedule.wants_end(view.step()) {
            self.keyframes.pop();
        }
        self.take_from(view);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_dense_around_the_impact_and_end_at_the_edges() {
        assert_eq!(kept_lines(160, 80, 161).len(), 161);
        let few = kept_lines(160, 80, 60);
        assert!(few.len() <= 60 && few.len() > 50, "{}", few.len());
        assert_eq!((few[0], few[few.len() - 1]), (0, 160));
        let dense = few.iter().filter(|line| line.abs_diff(80) <= DENSE).count();
        assert_eq!(dense, 2 * DENSE + 1);
        assert!(few.windows(2).all(|pair| pair[0] < pair[1]));
        let half = kept_lines(80, 0, 30);
        assert_eq!((half[0], half[half.len() - 1]), (0, 80));
    }

    #[test]
    fn an_animation_opens_at_the_largest_deflection_that_the_projectile_is_near() {
        let mut animation = Animation::new(&crate::case::shipped(&["/expect=[]"]));
        let upright =
            Pose { position: [0.0; 3], rotation: [1.0, 0.0, 0.0, 0.0], velocity: [0.0; 3], angular_velocity: [0.0; 3] };
        let of = |(step, [deflection, height]): (u64, [f64; 2])| {
            let pose = Some(Pose { position: [0.0, 0.0, height], ..upright });
            let deflections = vec![0.0, deflection];
            Keyframe { step, time: step as f64, deflections, displacement: Vec::new(), tension: Vec::new(), pose }
        };
        animation.keyframes = (0..).zip([[0.0, 0.0], [2.0, 1.0], [3.0, 3.5], [4.0, 9.0]]).map(of).collect();
        assert_eq!(animation.opening(), 1);
        // A body that reaches 1 m back from its centre of mass.
        let body = SurfaceMesh { points: vec![[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], faces: Vec::new() };
        animation.body = Some(body);
        assert_eq!(animation.opening(), 2);
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
