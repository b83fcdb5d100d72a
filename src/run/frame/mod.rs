//! Frames: the whole scene at one time, to draw or to write.
//!
//! A [`SnapshotTaker`] takes a [`Snapshot`] when one is due, a copy of what has moved. What costs time, tensions and strains of every
//! element and the mirror images of a scene that is computed in part, is left to [`Snapshot::frame`], which may be called on another thread
//! while the solver goes on.
//!
//! N frames lie evenly between the start and the end of a run, both included. The end of a run is not known before it comes: frames
//! are taken more often, and N of them are chosen in the end ([`even`]).

mod schedule;
mod snapshot;

use serde::{Deserialize, Serialize};

use crate::case::Case;
use crate::model::{Model, ModelError};
use crate::num::scalar::Scalar;
use crate::physics::projectile_body::Body;
use crate::run::{Observer, View};
pub(crate) use schedule::Schedule;
pub use schedule::even;
pub use snapshot::{Snapshot, SnapshotTaker};

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
    /// Warp and weft tension of the elements; of broken yarns 0 [N].
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

impl Frame {
    /// Frame of zeros.
    pub(crate) fn empty(scene: &Scene) -> Self {
        let (nodes, elements) = (scene.reference.len(), scene.elements);
        let zeros = || std::array::from_fn(|_| vec![0.0; elements]);
        Self {
            step: 0,
            time: 0.0,
            displacement: vec![[0.0; 3]; nodes],
            velocity: vec![[0.0; 3]; nodes],
            tension: zeros(),
            strain: zeros(),
            height: zeros(),
            shear_angle: vec![0.0; elements],
            alive: std::array::from_fn(|_| vec![0; elements]),
            projectile: None,
        }
    }
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

/// Constants of the frames of a run: the whole pack at rest, and the shape of the projectile.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Scene {
    /// The plies, the struck one first.
    pub plies: Vec<PlyMesh>,
    /// Reference positions of the nodes in the axes of the pack [m].
    pub reference: Vec<[f32; 3]>,
    /// Elements over all plies.
    pub elements: usize,
    /// Surface of the projectile in its own axes, where there is one.
    pub projectile: Option<Body>,
    /// Time step [s].
    pub time_step: f64,
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
    /// Nodes of the ply.
    pub fn nodes(&self) -> usize {
        (self.columns + 1) * (self.rows + 1)
    }

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
    /// Scene of a case, whatever part of it is computed.
    ///
    /// # Errors
    /// When the case cannot become a model.
    pub fn of(case: &Case) -> Result<Self, ModelError> {
        Model::<f32>::part(case).map(|model| Self::new(&model))
    }

    /// The whole of the part that a model computes.
    fn new<S: Scalar>(model: &Model<S>) -> Self {
        let mut scene = Self {
            plies: Vec::with_capacity(model.plies.len()),
            reference: Vec::new(),
            elements: 0,
            projectile: model.projectile.as_ref().map(|projectile| projectile.body),
            time_step: model.dt,
        };
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
    wanted: usize,
    taker: SnapshotTaker,
    /// More than wanted: the end of a run is not known before it comes.
    taken: Vec<Snapshot>,
    end: Option<Snapshot>,
}

impl FrameCollector {
    /// For a number of frames of a case; a single one is that of the start.
    pub fn new(case: &Case, frames: usize) -> Self {
        let taker = SnapshotTaker::new(frames, case.solver.end_time);
        Self { wanted: frames, taker, taken: Vec::new(), end: None }
    }

    /// Constants of the frames; `None` before the run.
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
