//! The animation of a run: few, coarse pictures of what is computed, for the playback and the maps of the report.
//!
//! Lines of nodes lie dense around the point of impact and sparse far from it; of a thick pack some plies are shown; of a scene
//! that is its own mirror image there is the part that is computed. Pictures are taken when frames are (`Schedule`), so that
//! they lie evenly over a run of any length. A checkpoint carries the animation so far.

use std::collections::HashSet;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::super::surface::SurfaceMesh;
use super::animated_ply::AnimatedPly;
use crate::case::Case;
use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::physics::mirror_planes::MirrorPlanes;
use crate::physics::rigid_body::RigidBody;
use crate::run::frame::{Schedule, even};
use crate::run::{Observer, View, attached};
use crate::solver::state::State;

/// Pictures shown at most, the first and the last among them.
const PICTURES: usize = 61;
/// Nodes of a picture at most, about.
const NODES: usize = 5000;
/// Plies shown at most.
const PLIES: usize = 8;

/// All strips at one time; nodes and cells follow each other strip by strip.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Keyframe {
    /// Steps done.
    pub step: u64,
    /// [s]
    pub time: f64,
    /// Largest deflection of each strip's ply, of fabric that hangs on something [m].
    pub deflections: Vec<f64>,
    /// Of the nodes [m].
    pub displacement: Vec<[f32; 3]>,
    /// Largest force of a yarn in a cell, as its elements carry it, warp and weft [N]; `None` where no yarn of that direction
    /// goes through the cell from end to end.
    pub tension: Vec<[Option<f32>; 2]>,
    /// Position of the projectile's centre of mass [m], and its turn as a quaternion w, x, y, z.
    pub pose: Option<[f64; 7]>,
}

impl Keyframe {
    /// Largest deflection of any ply shown, of fabric that hangs on something [m].
    pub fn deflection(&self) -> f64 {
        self.deflections.iter().copied().fold(0.0, f64::max)
    }
}

/// Pictures of a run.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Animation {
    /// Plies shown, the struck one first; none before the first picture.
    pub strips: Vec<AnimatedPly>,
    /// Plies there are.
    pub plies: usize,
    /// In order of time.
    pub keyframes: Vec<Keyframe>,
    /// Mirror planes: shown is the part at x ≥ 0, y ≥ 0.
    pub planes: MirrorPlanes,
    /// Surface of the projectile.
    pub(super) body: Option<SurfaceMesh>,
    /// Where the projectile strikes [m].
    hit: [f64; 2],
    /// When pictures are due.
    schedule: Schedule,
    /// The strips are those of the model; not known of a animation from a checkpoint before its next picture.
    begun: bool,
}

impl Animation {
    /// An empty animation of a case.
    pub fn new(case: &Case) -> Self {
        Self {
            strips: Vec::new(),
            plies: 0,
            keyframes: Vec::new(),
            planes: MirrorPlanes::NONE,
            body: None,
            hit: case.projectile.as_ref().map_or([0.0; 2], |p| p.offset),
            schedule: Schedule::new(PICTURES, case.solver.end_time),
            begun: false,
        }
    }

    /// What a checkpoint carries of it.
    pub fn to_bytes(&self) -> Vec<u8> {
        // Writing to memory cannot fail.
        postcard::to_stdvec(&(&self.strips, self.plies, &self.keyframes, self.planes, &self.body)).unwrap_or_default()
    }

    /// The animation of a run that goes on before the step of this number, `dt` [s] long, from what a checkpoint carries; `None` where
    /// that is no animation.
    pub fn resume(case: &Case, bytes: &[u8], step: u64, dt: f64) -> Option<Self> {
        let (strips, plies, mut keyframes, planes, body) = postcard::from_bytes(bytes).ok()?;
        let schedule = Schedule::resume(PICTURES, case.solver.end_time, step, dt);
        keep(&mut keyframes, &schedule);
        let animation = Self { strips, plies, keyframes, planes, body, schedule, ..Self::new(case) };
        animation.is_sound().then_some(animation)
    }

    /// Whether all parts have the sizes that they need to have.
    fn is_sound(&self) -> bool {
        let nodes: usize = self.strips.iter().map(|strip| strip.reference.len()).sum();
        let cells: usize = self.strips.iter().map(AnimatedPly::cells).sum();
        let whole = |keyframe: &Keyframe| {
            keyframe.displacement.len() == nodes
                && keyframe.tension.len() == cells
                && keyframe.deflections.len() == self.strips.len()
        };
        self.body.as_ref().is_none_or(SurfaceMesh::is_sound)
            && self.strips.iter().all(AnimatedPly::is_sound)
            && self.keyframes.iter().all(whole)
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
        let [nodes, cells] = [|strip: &AnimatedPly| strip.reference.len(), AnimatedPly::cells]
            .map(|count| self.strips.iter().map(count).sum());
        let deflections = self.strips.par_iter().map(|strip| attached(model, state, strip.ply).deflection);
        let mut keyframe = Keyframe {
            step: state.step,
            time,
            deflections: deflections.collect(),
            displacement: vec![[0.0; 3]; nodes],
            tension: vec![[None; 2]; cells],
            pose: state.body.as_ref().map(pose),
        };
        let (mut displacement, mut tension) = (&mut keyframe.displacement[..], &mut keyframe.tension[..]);
        let (mut node_rows, mut cell_rows) = (Vec::new(), Vec::new());
        for strip in &self.strips {
            let (own, rest) = displacement.split_at_mut(strip.reference.len());
            let nodes = own.chunks_mut(strip.own[0].len().max(1));
            node_rows.extend(strip.own[1].iter().zip(nodes).map(|(row, nodes)| (strip, *row, nodes)));
            displacement = rest;
            let (own, rest) = tension.split_at_mut(strip.cells());
            let cells = own.chunks_mut(strip.counts()[0].max(1));
            cell_rows.extend(strip.own[1].windows(2).zip(cells).map(|(rows, cells)| (strip, rows, cells)));
            tension = rest;
        }
        // This reads all elements, and the threads of the loop wait meanwhile.
        cell_rows.into_par_iter().for_each(|(strip, rows, cells)| strip.tensions(model, state, rows, cells));
        node_rows.into_par_iter().for_each(|(strip, row, nodes)| strip.displacements(model, state, row, nodes));
        self.keyframes.push(keyframe);
    }

    fn begin<S: Scalar>(&mut self, model: &Model<S>) {
        self.begun = true;
        self.plies = model.plies.len();
        let shown = shown(self.plies);
        let nodes = NODES / shown.len().max(1);
        let strips: Vec<AnimatedPly> = shown.iter().map(|ply| AnimatedPly::new(model, *ply, self.hit, nodes)).collect();
        if strips != self.strips {
            self.keyframes.clear(); // of another model
        }
        self.strips = strips;
        self.planes = model.planes;
        let pack = self.strips.iter().flat_map(|strip| &strip.reference);
        self.body = model.projectile.as_ref().map(|projectile| SurfaceMesh::new(&projectile.body, pack));
    }

    /// The same with at most so many pictures, evenly from the first to the last.
    #[must_use]
    pub(super) fn with(&self, pictures: usize) -> Self {
        let times: Vec<f64> = self.keyframes.iter().map(|keyframe| keyframe.time).collect();
        let keyframes = even(&times, pictures).into_iter().map(|at| self.keyframes[at].clone()).collect();
        Self { keyframes, ..self.clone() }
    }

    /// The pictures that a page shows: evenly from the first to the last.
    #[must_use]
    pub fn shown(&self) -> Self {
        self.with(PICTURES)
    }

    /// Largest deflection in any picture, of fabric that hangs on something [m].
    pub fn deflection(&self) -> f64 {
        self.keyframes.iter().map(Keyframe::deflection).fold(0.0, f64::max)
    }

    /// The picture of the largest deflection among those in which the projectile has not left the fabric behind.
    pub fn opening(&self) -> usize {
        let is_near = |keyframe: &Keyframe| keyframe.pose.is_none_or(|pose| self.tail(&pose) <= keyframe.deflection());
        let near = (0..self.keyframes.len()).filter(|at| is_near(&self.keyframes[*at]));
        let deflection = |at: usize| self.keyframes[at].deflection();
        near.max_by(|a, b| deflection(*a).total_cmp(&deflection(*b))).unwrap_or(0)
    }

    /// How far the last part of the projectile has come, along the normal of the pack [m].
    fn tail(&self, [_, _, height, w, x, y, z]: &[f64; 7]) -> f64 {
        let normal = [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)];
        let points = self.body.iter().flat_map(|body| &body.points);
        let heights = points.map(|point| (0..3).map(|axis| normal[axis] * point[axis]).sum::<f64>());
        height + heights.fold(0.0, f64::min)
    }

    /// Largest tension in any picture [N].
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
        keep(&mut self.keyframes, &self.schedule);
    }

    fn on_end(&mut self, view: &View<'_>) {
        // The last picture is that of the end, not of the step before.
        if !self.schedule.wants_end(view.step()) {
            self.keyframes.pop();
        }
        self.take_from(view);
    }
}

/// Gives up the pictures that the schedule has given up.
fn keep(keyframes: &mut Vec<Keyframe>, schedule: &Schedule) {
    let kept: HashSet<u64> = schedule.kept().collect();
    keyframes.retain(|keyframe| kept.contains(&keyframe.step));
}

fn pose(body: &RigidBody) -> [f64; 7] {
    let (at, q) = (body.position, body.orientation.quaternion());
    [at.x, at.y, at.z, q.w, q.i, q.j, q.k]
}

/// Plies to show, evenly from the first to the last.
pub(super) fn shown(plies: usize) -> Vec<usize> {
    if plies <= PLIES {
        return (0..plies).collect();
    }
    (0..PLIES).map(|n| (n * (plies - 1) + (PLIES - 1) / 2) / (PLIES - 1)).collect()
}

#[cfg(test)]
#[path = "animation_tests.rs"]
mod tests;
