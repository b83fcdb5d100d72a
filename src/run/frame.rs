//! Frames: the whole scene at one time, to draw or to write.
//!
//! A [`FrameCollector`] takes a [`Snapshot`] when one is due, a copy of what has moved. What costs time, tensions and strains of every
//! element and the mirror images of a scene that is computed in part, is left to [`Snapshot::frame`].
//!
//! N frames lie evenly between the start and the end of a run, both included. The end of a run is not known before it comes: frames
//! are taken more often than asked for. Each time there are twice as many as asked for, every second one is given up, and those to
//! come lie twice as far apart. So at any time between half and all of twice as many lie evenly from the start on, and `even` chooses
//! from them.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::snapshot::Snapshot;
use crate::case::Case;
use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::physics::rigid_body::RigidBody;
use crate::run::{Observer, View};

/// Ratio of the frames taken at first to those asked for: a run that ends after this part of its end time has as many frames
/// as asked for. A power of two, so that a run that reaches its end time has frames at even times to the step.
const FINEST: f64 = 64.0;

/// The whole scene at one time, in the axes of the pack. Nodes and elements run over (ply, row, column); [`Scene`] has
/// their numbers and what does not change.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Frame {
    /// Steps done.
    pub step: u64,
    /// Time [s].
    pub time: f64,
    /// Displacement of the nodes [m].
    pub displacement: Vec<[f32; 3]>,
    /// Velocity of the nodes, half a time step before (leapfrog) [m/s].
    pub velocity: Vec<[f32; 3]>,
    /// Warp and weft tension of the yarns in the elements, which is what all elements side by side in a yarn carry; of broken yarns 0 [N].
    pub tension: [Vec<f32>; 2],
    /// Warp and weft axial strain of the elements; of broken yarns 0 [-].
    pub strain: [Vec<f32>; 2],
    /// Warp and weft crimp height of the elements; 0 where the yarns do not cross any more [m].
    pub height: [Vec<f32>; 2],
    /// Shear angle of the elements; 0 where the yarns do not cross any more [rad].
    pub shear_angle: Vec<f32>,
    /// 1 where the warp, the weft of an element carries load, 0 where it is broken or missing.
    pub alive: [Vec<u8>; 2],
    /// The projectile, where there is one.
    pub projectile: Option<Pose>,
}

/// A projectile at one time, in the axes of the pack.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Pose {
    /// Centre of mass [m].
    pub position: [f64; 3],
    /// Rotation from the body's axes to those of the pack: quaternion w, x, y, z of length one.
    pub rotation: [f64; 4],
    /// Velocity of the centre of mass, half a time step before (leapfrog) [m/s].
    pub velocity: [f64; 3],
    /// Angular velocity [rad/s].
    pub angular_velocity: [f64; 3],
}

impl From<&RigidBody> for Pose {
    fn from(body: &RigidBody) -> Self {
        let q = body.orientation.quaternion();
        Self {
            position: body.position.into(),
            rotation: [q.w, q.i, q.j, q.k],
            velocity: body.velocity.into(),
            angular_velocity: body.angular_velocity().into(),
        }
    }
}

/// Constants of the frames of a run: the whole pack at rest.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Scene {
    /// The plies, the struck one first.
    pub plies: Vec<PlyMesh>,
    /// Reference positions of the nodes in the axes of the pack [m].
    pub reference: Vec<[f32; 3]>,
    /// Elements over all plies.
    pub elements: usize,
}

/// One ply among the nodes and elements of a scene; element (row, column) lies between the nodes (row, column) and
/// (row + 1, column + 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PlyMesh {
    /// Elements along the warp.
    pub columns: usize,
    /// Elements along the weft.
    pub rows: usize,
    /// First node.
    pub first_node: usize,
    /// First element.
    pub first_element: usize,
}

impl PlyMesh {
    /// Elements of the ply.
    pub fn elements(&self) -> usize {
        self.columns * self.rows
    }

    /// Corners of an element among the nodes of the scene, counter-clockwise.
    pub fn corners(&self, row: usize, column: usize) -> [usize; 4] {
        let below = self.first_node + row * (self.columns + 1) + column;
        let above = below + self.columns + 1;
        [below, below + 1, above + 1, above]
    }
}

impl Scene {
    /// The whole of the part that a model computes.
    pub(crate) fn new<S: Scalar>(model: &Model<S>) -> Self {
        let mut scene = Self { plies: Vec::new(), reference: Vec::new(), elements: 0 };
        for ply in &model.plies {
            let mesh = model.ply_types[ply.ply_type].mesh.whole();
            let (rows, columns) = (mesh.rows, mesh.columns);
            let own = PlyMesh { columns, rows, first_node: scene.reference.len(), first_element: scene.elements };
            for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
                let [x, y] = mesh.reference(row, column);
                scene.reference.push(mesh.to_pack([x, y, ply.z]).map(|at| at as f32));
            }
            scene.elements += own.elements();
            scene.plies.push(own);
        }
        scene
    }
}

/// Observer that takes frames of a run, evenly from start to end, and keeps them in memory.
///
/// ```
/// # let case = ripstop::Case::builder("a ply").fabric(ripstop::BuiltInFabric::S720).size_mm(15.0, 15.0)
/// #     .sphere_mm(6.0).mass_g(1.0).velocity_m_s(50.0).end_time_us(3.0).build()?;
/// use ripstop::{FrameCollector, Options};
///
/// let mut collector = FrameCollector::new(&case, 5);
/// Options::default().observe(&case, &mut collector)?;
/// for frame in collector.frames() {
///     let highest = frame.displacement.iter().map(|node| node[2]).fold(0.0, f32::max);
///     println!("{:.1} µs: {:.3} mm", frame.time * 1e6, highest * 1e3);
/// }
/// # assert_eq!(collector.frames().len(), 5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FrameCollector {
    schedule: Schedule,
    scene: Option<Arc<Scene>>,
    /// Time [s] and snapshot of the frames so far, by the steps done before them. Without a snapshot a frame lies on the disk.
    pub(crate) taken: BTreeMap<u64, (f64, Option<Snapshot>)>,
}

impl FrameCollector {
    /// For frames of a case, evenly from the start to the end: so many where the run reaches its end time, at most twice as many where it
    /// ends before. A single one is that of the start.
    pub fn new(case: &Case, frames: usize) -> Self {
        Self { schedule: Schedule::new(frames, case.solver.end_time), scene: None, taken: BTreeMap::new() }
    }

    /// For a run that goes on before the step of this number, `dt` [s] long; no frame is in memory.
    pub(crate) fn resume(case: &Case, frames: usize, step: u64, dt: f64) -> Self {
        let mut collector = Self::new(case, frames);
        (0..step).for_each(|past| collector.schedule.pass(past, dt));
        collector.taken = collector.schedule.kept.iter().map(|[_, step]| (*step, (*step as f64 * dt, None))).collect();
        collector
    }

    /// Constants of the frames; `None` before the run.
    pub fn scene(&self) -> Option<&Scene> {
        self.scene.as_deref()
    }

    /// The frames, ascending in time. They are made anew by every call.
    pub fn frames(&self) -> Vec<Frame> {
        let snapshots = self.chosen().into_iter().filter_map(|step| self.taken[&step].1.as_ref());
        snapshots.map(Snapshot::frame).collect()
    }

    /// Steps done before the frames that are given: as far apart as they can be and still be as many as asked for, and the last.
    pub(crate) fn chosen(&self) -> Vec<u64> {
        let gaps = [self.schedule.kept.len(), self.schedule.wanted].map(|count| count.saturating_sub(1));
        let apart = (gaps[0] / gaps[1].max(1)).max(1);
        let mut steps: Vec<u64> = self.taken.keys().copied().step_by(apart).collect();
        if let (Some(end), [first, second, .., before]) = (self.taken.keys().next_back(), &steps[..]) {
            // A frame just before the last one shows the same.
            steps.truncate(steps.len() - usize::from(2 * (end - before) < second - first));
        }
        steps.extend(self.taken.keys().next_back().filter(|end| steps.last() != Some(end)));
        steps
    }

    fn take(&mut self, view: &View<'_>) {
        let snapshot = Snapshot::new(view, &mut self.scene);
        self.taken.insert(view.step(), (view.clock()[0], Some(snapshot)));
    }
}

impl Observer for FrameCollector {
    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.schedule.is_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        self.take(view);
        self.schedule.pass(view.step(), view.clock()[1]);
        self.taken.retain(|step, _| self.schedule.keeps(*step));
    }

    fn on_end(&mut self, view: &View<'_>) {
        if self.schedule.wants_end(view.step()) {
            self.take(view);
        }
    }
}

/// Times at which frames are due, and those of them that are kept.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Schedule {
    /// Frames asked for.
    wanted: usize,
    /// Interval of the frames of a run that reaches its end time [s].
    widest: f64,
    /// Interval now [s].
    interval: f64,
    /// Multiples of the interval whose time has come.
    passed: u64,
    /// Multiple of the interval, and steps done, of the frames kept.
    kept: Vec<[u64; 2]>,
}

impl Schedule {
    /// Schedule of `wanted` frames from 0 to the end of a run, at `end_time` [s] or before.
    pub(crate) fn new(wanted: usize, end_time: f64) -> Self {
        let widest = end_time / wanted.saturating_sub(1).max(1) as f64;
        Self { wanted, widest, interval: widest / FINEST, passed: 0, kept: Vec::new() }
    }

    /// The interval [s]: no finer than the time step `dt` [s].
    fn interval(&self, dt: f64) -> f64 {
        let mut interval = self.interval;
        while interval < dt && interval < self.widest {
            interval *= 2.0;
        }
        interval
    }

    /// Whether a frame is due at `time` [s], or nearer to it than to the next step `dt` [s] later.
    pub(crate) fn is_due(&self, time: f64, dt: f64) -> bool {
        (self.wanted > 1 || self.passed < self.wanted as u64)
            && time >= self.passed as f64 * self.interval(dt) - 0.5 * dt
    }

    /// The frame before this step, `dt` [s] long, is taken; others may be given up.
    pub(crate) fn pass(&mut self, step: u64, dt: f64) {
        let time = step as f64 * dt;
        if !self.is_due(time, dt) {
            return;
        }
        while self.is_due(time, dt) {
            self.passed += 1;
        }
        self.kept.push([self.passed - 1, step]);
        if self.wanted > 1 && self.kept.len() > 2 * (self.wanted - 1) + 1 {
            self.interval = 2.0 * self.interval(dt);
            self.passed = self.passed.div_ceil(2);
            self.kept.retain(|[number, _]| number % 2 == 0);
            self.kept.iter_mut().for_each(|[number, _]| *number /= 2);
        }
    }

    /// Whether the state after the last step is one more frame: not where it is the last frame or the step after that.
    pub(crate) fn wants_end(&self, step: u64) -> bool {
        self.wanted > 1 && self.kept.last().is_none_or(|[_, last]| last + 1 < step)
    }

    /// Whether the frame before this step is kept.
    pub(crate) fn keeps(&self, step: u64) -> bool {
        self.kept.iter().any(|kept| kept[1] == step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-6;

    /// Steps before the frames of a run.
    fn chosen(wanted: usize, end_time: f64, steps: u64) -> Vec<u64> {
        let mut schedule = Schedule::new(wanted, end_time);
        (0..=steps).for_each(|step| schedule.pass(step, DT));
        let end = schedule.wants_end(steps).then_some(steps);
        let taken = schedule.kept.iter().map(|[_, step]| *step).chain(end).map(|step| (step, (0.0, None))).collect();
        FrameCollector { schedule, scene: None, taken }.chosen()
    }

    #[test]
    fn whenever_a_run_ends_all_frames_but_the_last_are_equally_far_apart() {
        for steps in 64..=4000 {
            let frames = chosen(61, 4e-3, steps);
            assert!((61..=121).contains(&frames.len()), "{} after {steps} steps", frames.len());
            let gaps: Vec<u64> = frames.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let Some((last, gaps)) = gaps.split_last() else { unreachable!("there are frames") };
            assert!(
                gaps.iter().all(|gap| gap.abs_diff(gaps[0]) <= 1) && *last <= gaps[0] + gaps[0] / 2 + 2,
                "{frames:?}"
            );
            assert!(frames[0] == 0 && steps - frames[frames.len() - 1] <= 1, "the last of {steps}: {frames:?}");
        }
    }
}
