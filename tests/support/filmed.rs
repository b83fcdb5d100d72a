//! A watcher that keeps the frames of a run in memory.

use ripstop::run::frame::{self, Frame, Scene, SnapshotTaker};
use ripstop::run::{Observer, View};

/// Every frame that a camera takes.
pub(crate) struct Frames {
    pub(crate) camera: SnapshotTaker,
    taken: Vec<Frame>,
    end: Option<Frame>,
    pub(crate) scene: Option<Scene>,
}

impl Frames {
    pub(crate) fn new(camera: SnapshotTaker) -> Self {
        Self { camera, taken: Vec::new(), end: None, scene: None }
    }

    /// So many of those that the camera has kept, and of the end.
    pub(crate) fn chosen(self, count: usize) -> (Vec<Frame>, Option<Scene>) {
        let kept: Vec<u64> = self.camera.kept().collect();
        let mut all = self.taken;
        all.retain(|frame| kept.contains(&frame.step));
        all.extend(self.end);
        let times: Vec<f64> = all.iter().map(|frame| frame.time).collect();
        let chosen = frame::even(&times, count);
        (
            all.into_iter().enumerate().filter(|(at, _)| chosen.contains(at)).map(|(_, frame)| frame).collect(),
            self.scene,
        )
    }
}

impl Observer for Frames {
    fn snapshot_due(&self, time: f64, dt: f64) -> bool {
        self.camera.is_due(time, dt)
    }

    fn on_snapshot(&mut self, view: &View<'_>) {
        let snapshot = self.camera.take(view);
        self.taken.push(snapshot.frame());
        self.scene = Some(snapshot.scene().clone());
    }

    fn on_end(&mut self, view: &View<'_>) {
        self.end = self.camera.end(view).map(|snapshot| snapshot.frame());
    }
}
