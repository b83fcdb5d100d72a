//! Snapshots: copies of the state, which frames are made of.

use std::ops::Range;
use std::sync::Arc;

use super::frame::{Frame, PlyMesh, Pose, Scene};
use crate::model::Model;
use crate::model::mesh::{Mesh, corners};
use crate::model::ply_type::PlyType;
use crate::num::scalar::{Scalar, each};
use crate::physics::crossover::{self, Equilibrium};
use crate::physics::kinematics::{ElementConstants, ElementGeometry, Kinematics, differences, kinematics};
use crate::physics::membrane::arc_sine;
use crate::physics::yarn_law::Sinusoidal;
use crate::run::View;
use crate::solver::element_totals::field as element_field;
use crate::solver::node_update::field as node_field;
use crate::solver::state::State;

type Fill = Box<dyn Fn(&Scene, &mut Frame) + Send + Sync>;

/// State at the time of a frame: what has moved of the part that is computed.
pub struct Snapshot {
    scene: Arc<Scene>,
    step: u64,
    time: f64,
    projectile: Option<Pose>,
    /// Bytes of memory that it takes, about.
    pub(crate) bytes: usize,
    /// Fills a frame of zeros with what has moved, in whatever precision.
    fill: Fill,
}

impl Snapshot {
    /// Copy of the state in view. `scene`: constants of all frames of the run, made with the first.
    pub(crate) fn new(view: &View<'_>, scene: &mut Option<Arc<Scene>>) -> Self {
        match view {
            View::Double(model, state) => Self::of(model, state, scene),
            View::Single(model, state) => Self::of(model, state, scene),
        }
    }

    fn of<S: Scalar>(model: &Arc<Model<S>>, state: &State<S>, scene: &mut Option<Arc<Scene>>) -> Self {
        let plies: Vec<Patch<S>> = (0..model.plies.len()).map(|ply| Patch::new(model, state, ply)).collect();
        let bytes = plies.iter().map(|patch| size_of_val(&patch.nodes[..]) + size_of_val(&patch.elements[..]));
        let own = Arc::clone(model);
        Self {
            scene: scene.get_or_insert_with(|| Arc::new(Scene::new(model))).clone(),
            step: state.step,
            time: state.step as f64 * model.dt,
            projectile: state.body.as_ref().map(Pose::from),
            bytes: size_of::<Self>() + bytes.sum::<usize>(),
            fill: Box::new(move |scene, frame| fill(&own, &plies, scene, frame)),
        }
    }

    /// Constants that it shares with all others of its run.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Frame of the whole scene.
    pub fn frame(&self) -> Frame {
        let (nodes, elements) = (self.scene.reference.len(), self.scene.elements);
        let zeros = || [(); 2].map(|()| vec![0.0; elements]);
        let mut frame = Frame {
            step: self.step,
            time: self.time,
            displacement: vec![[0.0; 3]; nodes],
            velocity: vec![[0.0; 3]; nodes],
            tension: zeros(),
            strain: zeros(),
            height: zeros(),
            shear_angle: vec![0.0; elements],
            alive: [(); 2].map(|()| vec![0; elements]),
            projectile: self.projectile,
        };
        (self.fill)(&self.scene, &mut frame);
        frame
    }
}

/// Elements of a ply that may have moved, and their nodes, row by row.
struct Patch<S> {
    rows: Range<usize>,
    columns: Range<usize>,
    /// Displacement [m] and velocity [m/s].
    nodes: Vec<[[S; 3]; 2]>,
    elements: Vec<Before<S>>,
}

impl<S: Scalar> Patch<S> {
    fn new(model: &Model<S>, state: &State<S>, ply: usize) -> Self {
        let [rows, columns] = state.active[ply].elements(&model.ply_type(ply).mesh);
        let (first_node, first) = (model.grid.first_node_row(ply), model.grid.first_element_row(ply));
        let some = usize::from(!rows.is_empty());
        let node = |row: usize, column: usize| {
            let fields = [node_field::DISPLACEMENT, node_field::VELOCITY];
            fields.map(|field| [0, 1, 2].map(|a| state.nodes.get(first_node + row, field + a, column)))
        };
        let element = |row: usize, column: usize| Before::of(state, first + row, column);
        let nodes = places(rows.start..rows.end + some, columns.start..columns.end + some);
        let nodes = nodes.map(|(row, column)| node(row, column)).collect();
        let elements = places(rows.clone(), columns.clone()).map(|(row, column)| element(row, column)).collect();
        Self { rows, columns, nodes, elements }
    }

    /// Displacements of an element's corners, counter-clockwise.
    fn corners(&self, row: usize, column: usize) -> [[S; 4]; 3] {
        let node = |(row, column)| self.nodes[row * (self.columns.len() + 1) + column];
        [0, 1, 2].map(|a| corners([row, column]).map(|place| node(place)[0][a]))
    }
}

fn places(rows: Range<usize>, columns: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
    rows.flat_map(move |row| columns.clone().map(move |column| (row, column)))
}

/// Fills a frame of zeros with what has moved of every ply.
fn fill<S: Scalar>(model: &Model<S>, plies: &[Patch<S>], scene: &Scene, frame: &mut Frame) {
    for (ply, patch) in plies.iter().enumerate() {
        let (ply_type, whole) = (model.ply_type(ply), &scene.plies[ply]);
        let constants = ply_type.constants::<S>();
        let start = Before { height: ply_type.initial.height.map(S::splat), alive: ply_type.present };
        // What nothing has reached is flat; what started otherwise counts as reached.
        let rest = read(&constants, [1.0; 2], &[[S::splat(0.0); 4]; 3], start);
        (0..whole.elements()).for_each(|at| put(frame, whole.first_element + at, &rest, 1.0));
        let absent =
            places(0..ply_type.mesh.rows, 0..ply_type.mesh.columns).filter(|(r, c)| !ply_type.mesh.is_present(*r, *c));
        for (row, column) in absent {
            for ([column, row], _) in ply_type.mesh.images([column, row], 1) {
                put(frame, whole.first_element + row * whole.columns + column, &ElementReading::default(), 1.0);
            }
        }
        fill_elements(patch, ply_type, &rest, whole, frame);
        fill_nodes(patch, &ply_type.mesh, whole, frame);
    }
}

fn fill_elements<S: Scalar>(
    patch: &Patch<S>,
    ply_type: &PlyType<S>,
    rest: &ElementReading,
    whole: &PlyMesh,
    frame: &mut Frame,
) {
    let (constants, mesh) = (ply_type.constants::<S>(), &ply_type.mesh);
    let (first, columns) = ([patch.rows.start, patch.columns.start], patch.columns.len());
    let places = || places(patch.rows.clone(), patch.columns.clone());
    let read = |((row, column), before): ((usize, usize), &Before<S>)| {
        let corners = patch.corners(row - first[0], column - first[1]);
        read(&constants, mesh.widths(row, column), &corners, *before)
    };
    let readings: Vec<ElementReading> = places().zip(&patch.elements).map(read).collect();
    let tension = |yarn: usize, row: usize, column: usize| {
        let is_read = patch.rows.contains(&row) && patch.columns.contains(&column);
        let read = || &readings[(row - first[0]) * columns + column - first[1]];
        f64::from(if is_read { read() } else { rest }.tension[yarn])
    };
    for ((row, column), reading) in places().zip(&readings) {
        let of_yarns = [
            ply_type.windows[0].of_yarn(row, |beside| tension(0, beside, column)),
            ply_type.windows[1].of_yarn(column, |beside| tension(1, row, beside)),
        ];
        let tension = [0, 1].map(|yarn| if reading.alive[yarn] { of_yarns[yarn] as f32 } else { 0.0 });
        let reading = ElementReading { tension, ..*reading };
        for ([column, row], [x, y]) in mesh.images([column, row], 1) {
            put(frame, whole.first_element + row * whole.columns + column, &reading, y * x);
        }
    }
}

/// Puts an element, or its mirror image, in which the yarns turn towards each other the other way, into a frame.
fn put(frame: &mut Frame, at: usize, reading: &ElementReading, turn: f32) {
    for yarn in 0..2 {
        frame.tension[yarn][at] = reading.tension[yarn];
        frame.strain[yarn][at] = reading.strain[yarn];
        frame.height[yarn][at] = reading.height[yarn];
        frame.alive[yarn][at] = u8::from(reading.alive[yarn]);
    }
    frame.shear_angle[at] = turn * reading.shear_angle;
}

fn fill_nodes<S: Scalar>(patch: &Patch<S>, mesh: &Mesh, whole: &PlyMesh, frame: &mut Frame) {
    let (rows, columns) = (patch.rows.start..patch.rows.end + 1, patch.columns.start..patch.columns.end + 1);
    for ((row, column), node) in places(rows, columns).zip(&patch.nodes) {
        let [displacement, velocity] = node.map(|vector| vector.map(S::to_f64));
        for ([column, row], [x, y]) in mesh.images([column, row], 0) {
            let at = whole.first_node + row * (whole.columns + 1) + column;
            let image = |v: [f64; 3]| mesh.to_pack([f64::from(x) * v[0], f64::from(y) * v[1], v[2]]);
            frame.displacement[at] = image(displacement).map(|u| u as f32);
            frame.velocity[at] = image(velocity).map(|v| v as f32);
        }
    }
}

/// One element, rounded to what files hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct ElementReading {
    /// Force over the number of yarns that the element has of each; in a frame the tension of the yarn [N].
    tension: [f32; 2],
    /// Strain of the yarns [-].
    strain: [f32; 2],
    /// Crimp height of the yarns [m].
    height: [f32; 2],
    /// Shear angle [rad].
    shear_angle: f32,
    /// Yarns that carry load.
    alive: [bool; 2],
}

/// An element after the last step.
#[derive(Clone, Copy, Debug)]
struct Before<S> {
    /// Heights of the yarns [m].
    height: [S; 2],
    /// Yarns that carry load.
    alive: [bool; 2],
}

impl<S: Scalar> Before<S> {
    /// `row`: of the storage.
    fn of(state: &State<S>, row: usize, column: usize) -> Self {
        Self {
            height: [0, 1].map(|yarn| state.elements.get(row, element_field::HEIGHT + yarn, column + 1)),
            alive: [0, 1].map(|yarn| state.alive(row, column, yarn)),
        }
    }
}

/// Stretches of an element, and its unit cell solved there as the next step would. Its size is over that of the finest; the displacements of
/// its corners [m] are components of corners, counter-clockwise.
fn solved<S: Scalar>(
    constants: &ElementConstants<S>,
    [width, height]: [f64; 2],
    corners: &[[S; 4]; 3],
    before: Before<S>,
) -> (Kinematics<S>, Equilibrium<S>) {
    let [ux, uy, uz] = each!(a in 3 => differences(&corners[a]));
    let size = ElementGeometry::of_row(constants, height).of_columns(S::splat(width), S::splat(1.0 / width));
    let k = kinematics(&size, [&ux, &uy, &uz]);
    let both = before.alive[0] && before.alive[1];
    let cell = crossover::solve::<S, Sinusoidal>(&constants.cell, k.extension, before.height, both);
    (k, cell)
}

/// Elastic force of warp or weft in the plane of an element of the first ply [N/m].
pub(super) fn membrane_force<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    [row, column]: [usize; 2],
    yarn: usize,
) -> f64 {
    let ply_type = model.ply_type(0);
    let constants = ply_type.constants::<S>();
    let before = Before::of(state, row, column);
    if !before.alive[yarn] {
        return 0.0;
    }
    let displacement = |a, (row, column)| state.nodes.get(row, node_field::DISPLACEMENT + a, column);
    let corners = [0, 1, 2].map(|a| corners([row, column]).map(|place| displacement(a, place)));
    let (k, cell) = solved(&constants, ply_type.mesh.widths(row, column), &corners, before);
    let own = &constants.cell.yarn[yarn];
    let alone = own.tension(own.straight(k.extension[yarn]));
    let force = if before.alive[1 - yarn] { cell.in_plane[yarn] } else { alone };
    force.to_f64() * ply_type.element.membrane[yarn] / (0.5 * ply_type.mesh.length[1 - yarn])
}

/// An element at the positions of the frame; see [`solved`].
fn read<S: Scalar>(
    constants: &ElementConstants<S>,
    widths: [f64; 2],
    corners: &[[S; 4]; 3],
    before: Before<S>,
) -> ElementReading {
    let (alive, zero) = (before.alive, S::splat(0.0));
    if alive == [false; 2] {
        return ElementReading::default();
    }
    let (k, cell) = solved(constants, widths, corners, before);
    let yarn = &constants.cell.yarn;
    let both = alive[0] && alive[1];
    let free = [0, 1].map(|i| yarn[i].straight(k.extension[i]).max(zero));
    let of_living = |i: usize, crossing: S, alone: S| match (alive[i], both) {
        (true, true) => crossing.to_f64() as f32,
        (true, false) => alone.to_f64() as f32,
        _ => 0.0,
    };
    ElementReading {
        tension: [0, 1].map(|i| of_living(i, cell.tension[i], yarn[i].tension(free[i]))),
        strain: [0, 1].map(|i| of_living(i, cell.strain[i], free[i])),
        height: [0, 1].map(|i| of_living(i, cell.height[i], zero)),
        shear_angle: if both { arc_sine(k.sine).to_f64() as f32 } else { 0.0 },
        alive,
    }
}
