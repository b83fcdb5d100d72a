//! Frames in memory, for whoever looks at them when the run is over.

use super::{Frame, Scene, Snapshot, SnapshotTaker, even};
use crate::case::Case;
use crate::run::{Observer, View};

/// Takes frames of a run that it watches, evenly from start to end, and keeps them in memory.
///
/// ```
/// # let case = ripstop::Case::builder("a ply").fabric(ripstop::BuiltInFabric::S720).size_mm(15.0, 15.0)
/// #     .sphere_mm(6.0).mass_g(1.0).velocity_m_s(50.0).end_time_us(3.0).build()?;
/// use ripstop::{FrameCollector, Options};
///
/// let mut collector = FrameCollector::new(&case, 5);
/// Options::default().watch(&case, &mut collector)?;
/// for frame in collector.frames() {
///     let highest = frame.displacement.iter().map(|node| node[2]).fold(0.0, f32::max);
///     println!("{:.1} µs: {:.3} mm", frame.time * 1e6, highest * 1e3);
/// }
/// # assert_eq!(collector.frames().len(), 5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FrameCollector {
    wanted: usize,
    taker: SnapshotTaker,
    /// More than wanted: when a run ends is not known before.
    taken: Vec<Snapshot>,
    end: Option<Snapshot>,
}

impl FrameCollector {
    /// For so many frames of a case; a single one is that of the start.
    pub fn new(case: &Case, frames: usize) -> Self {
        let taker = SnapshotTaker::new(frames, case.solver.end_time);
        Self { wanted: frames, taker, taken: Vec::new(), end: None }
    }

    /// What does not change from frame to frame; `None` before the run.
    pub fn scene(&self) -> Option<&Scene> {
        self.taken.first().or(self.end.as_ref()).map(Snapshot::scene)
    }

    /// The frames, ascending in time. They are made anew by every call.
    pub fn frames(&self) -> Vec<Frame> {
        let all: Vec<&Snapshot> = self.taken.iter().chain(&self.end).collect();
        let times: Vec<f64> = all.iter().map(|snapshot| snapshot.time()).collect();
        even(&times, self.wanted).into_iter().map(|at| all[at].frame()).collect()
    }
}

impl Observer for FrameCollector {
    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.taker.is_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        let snapshot = self.taker.take(view);
        self.taken.push(snapshot);
        let kept: Vec<u64> = self.taker.kept().collect();
        self.taken.retain(|snapshot| kept.contains(&snapshot.step()));
    }

    fn on_end(&mut self, view: &View<'_>) {
        self.end = self.taker.end(view);
    }
}
