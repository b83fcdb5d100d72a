//! One time step: the only place that knows the order of the kernels.
//!
//! 1. `element_force` on every row of elements, from the positions;
//! 2. `node_update` on every row of nodes: gather, kick, drift;
//! 3. `ply_contact` between neighbouring plies, and
//! 4. `projectile_contact` on the nodes near the projectile, each correcting velocity and position of what it touches;
//! 5. `rigid_body`: the projectile moves.
//!
//! Rows run in parallel; sums are kept by row and added in row order, so results do not depend on threads. Rows and
//! columns that nothing has reached are left out.

mod kernels;
mod plies;
mod projectile;
mod trouble;

use rayon::prelude::*;

use crate::kernels::element_force::{ElementRow, ElementTotals, field as element};
use crate::kernels::node_update::{Neighbours, NodeTotals, Part, RowMass};
use crate::lanes::Vectors;
use crate::ledger::Ledger;
use crate::model::Model;
use crate::number::Scalar;
use crate::state::{Rows, State, split, split_mut};
pub use kernels::{HasKernels, RowKernels};
use plies::PlyContact;
use projectile::ProjectileContact;
pub use projectile::{fabric_between, node_position, node_stands};
pub use trouble::{elements, fastest_node, find_trouble, nodes};

/// A yarn failure, with its place in the pack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FailureEvent {
    /// Step it was found in.
    pub step: u64,
    /// Ply, counted from the struck side.
    pub ply: u32,
    /// Element column (along warp).
    pub i: u32,
    /// Element row (along weft).
    pub j: u32,
    /// 0 warp, 1 weft.
    pub yarn: u8,
    /// Axial strain [-].
    pub strain: f64,
}

/// What one step did.
#[derive(Clone, Debug, Default)]
pub struct StepTotals {
    /// ½ m v² of the fabric after the step [J].
    pub kinetic: f64,
    /// Largest node speed [m/s].
    pub max_speed: f64,
    /// Unit-cell solves that did not meet the residual.
    pub unconverged: u64,
    /// Residual evaluations.
    pub iterations: f64,
    /// Unit cells solved.
    pub solved: f64,
    /// Largest residual [N].
    pub max_residual: f64,
    /// Deepest node inside the projectile at the start of the step [m].
    pub penetration: f64,
    /// Deepest node inside a neighbouring ply at the start of the step [m].
    pub ply_penetration: f64,
    /// Contacts between plies that pushed.
    pub ply_contacts: u64,
    /// Elements whose last yarn failed.
    pub eroded: u64,
    /// Elements computed; the rest is at rest.
    pub computed: u64,
}

/// Where a run went wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct Trouble {
    /// Step.
    pub step: u64,
    /// Kernel that produced the number.
    pub kernel: &'static str,
    /// Quantity and its value.
    pub quantity: String,
    /// Ply, row, column of the node or element.
    pub place: [usize; 3],
}

/// What the stages of a step work on.
pub struct Frame<'a, S> {
    /// Constant.
    pub model: &'a Model<S>,
    /// Varies.
    pub state: &'a mut State<S>,
    /// Takes note of work and losses.
    pub ledger: &'a mut Ledger,
    /// What the step has done so far.
    pub totals: StepTotals,
    /// Whether the ledger takes the energies at the time of the positions.
    pub sample: bool,
}

impl<'a, S: Scalar> Frame<'a, S> {
    /// A step about to begin.
    pub fn new(model: &'a Model<S>, state: &'a mut State<S>, ledger: &'a mut Ledger, sample: bool) -> Self {
        Self { model, state, ledger, totals: StepTotals::default(), sample }
    }

    /// Time step of the velocities [s]: half a kick at the start puts them half a step after the positions.
    fn kick(&self) -> f64 {
        if self.state.step == 0 { 0.5 * self.model.dt } else { self.model.dt }
    }
}

/// Advances a state step by step.
pub struct Stepper<S: Scalar> {
    /// By sheet.
    kernels: Vec<Box<dyn RowKernels<S>>>,
    element_totals: Vec<ElementTotals>,
    node_totals: Vec<NodeTotals>,
    /// What a row of nodes without elements on one side reads.
    nothing: Vec<S>,
    plies: PlyContact,
    projectile: ProjectileContact,
    /// Failures of the last step.
    pub failures: Vec<FailureEvent>,
}

impl<S: Scalar> Stepper<S> {
    /// A stepper for a model, on the widest vectors there are.
    pub fn new(model: &Model<S>) -> Self {
        Self::with_vectors(model, Vectors::widest())
    }

    /// A stepper for a model.
    pub fn with_vectors(model: &Model<S>, vectors: Vectors) -> Self {
        let grid = &model.grid;
        Self {
            kernels: model.sheets.iter().map(|sheet| S::kernels(sheet, vectors)).collect(),
            element_totals: vec![ElementTotals::default(); grid.element_rows()],
            node_totals: vec![NodeTotals::default(); grid.node_rows()],
            nothing: vec![S::splat(0.0); element::COUNT * grid.element_stride],
            plies: PlyContact::new(model),
            projectile: ProjectileContact::default(),
            failures: Vec::new(),
        }
    }

    /// One step from the positions at `state.step`·Δt. `sample`: fill in the energies at that time.
    pub fn step(&mut self, model: &Model<S>, state: &mut State<S>, ledger: &mut Ledger, sample: bool) -> StepTotals {
        let mut frame = Frame::new(model, state, ledger, sample);
        self.elements(&mut frame);
        self.nodes(&mut frame);
        self.plies(&mut frame);
        self.projectile(&mut frame);
        frame.state.step += 1;
        frame.totals
    }

    /// The first part of a step: forces of the elements.
    pub fn elements(&mut self, frame: &mut Frame<'_, S>) {
        self.element_pass(frame);
        self.collect_elements(frame);
    }

    /// The second part: the nodes move.
    pub fn nodes(&mut self, frame: &mut Frame<'_, S>) {
        for (ply, reach) in frame.state.reach.iter_mut().enumerate() {
            *reach = reach.grown(1, &frame.model.sheet(ply).mesh);
        }
        self.node_pass(frame);
        for (index, row) in self.node_totals.iter().enumerate() {
            frame.totals.kinetic += row.kinetic;
            frame.totals.max_speed = frame.totals.max_speed.max(row.max_speed_squared);
            let support = to_pack(frame.model, index, row.support);
            for a in 0..3 {
                frame.ledger.support[a] += support[a];
            }
        }
        frame.totals.max_speed = frame.totals.max_speed.sqrt();
        if frame.sample {
            let model = frame.model;
            frame.ledger.sample_nodes(&self.node_totals, &model.grid, |row, v| to_pack(model, row, v));
        }
    }

    /// The third part: contact between the plies.
    pub fn plies(&mut self, frame: &mut Frame<'_, S>) {
        if frame.model.plies.len() > 1 {
            self.plies.resolve(frame, &self.nothing);
        }
    }

    /// The fourth part: contact with the projectile, and its motion.
    pub fn projectile(&mut self, frame: &mut Frame<'_, S>) {
        if let Some(mut body) = frame.state.body.take() {
            self.projectile.resolve(frame, &mut body, &self.nothing);
            if frame.sample {
                frame.ledger.sample_body(&body);
            }
            body.advance(frame.model.dt);
            frame.state.body = Some(body);
        }
    }

    fn element_pass(&mut self, frame: &mut Frame<'_, S>) {
        let (model, state, sample) = (frame.model, &mut *frame.state, frame.sample);
        let grid = &model.grid;
        let dt = if state.step == 0 { 0.0 } else { model.dt };
        let (nodes, stride, reach) = (&state.nodes, state.elements.stride, &state.reach);
        let length = state.elements.row_length();
        let all = state.step == 0;
        let work = |(index, (storage, totals)): (usize, (&mut [S], &mut ElementTotals))| {
            let (ply, in_ply) = grid.element_row(index);
            let sheet = model.sheet(ply);
            let mesh = &sheet.mesh;
            // The first step computes everything, so that yarn heights at rest are those the unit cell finds.
            let [rows, columns] = if all { [0..mesh.rows, 0..mesh.columns] } else { reach[ply].elements(mesh) };
            totals.clear();
            if !rows.contains(&in_ply) {
                return;
            }
            totals.computed = columns.len();
            let below = grid.first_node_row(ply) + in_ply;
            let mut row = ElementRow {
                below: split(nodes.row(below), nodes.stride),
                above: split(nodes.row(below + 1), nodes.stride),
                element: split_mut(storage, stride),
                height: mesh.widths(in_ply, 0)[1],
                width: &sheet.columns.width,
                per_width: &sheet.columns.per_width,
                viscosity: sheet.columns.viscosity(in_ply),
            };
            self.kernels[model.plies[ply].sheet].elements(&mut row, columns, dt, sample, totals);
        };
        let rows = state.elements.data.par_chunks_mut(length).zip(&mut self.element_totals);
        rows.enumerate().with_min_len(4).for_each(work);
    }

    /// Adds up what the rows did, in row order.
    fn collect_elements(&mut self, frame: &mut Frame<'_, S>) {
        let Frame { model, state, ledger, totals, sample } = frame;
        self.failures.clear();
        for (index, row) in self.element_totals.iter().enumerate() {
            ledger.work += row.internal_work;
            ledger.released[0] += row.released[0];
            ledger.released[1] += row.released[1];
            totals.unconverged += u64::from(row.unconverged);
            totals.iterations += row.iterations;
            totals.solved += row.solved;
            totals.max_residual = totals.max_residual.max(row.max_residual);
            totals.computed += row.computed as u64;
            let (ply, j) = model.grid.element_row(index);
            for (at, f) in row.failures.iter().enumerate() {
                self.failures.push(FailureEvent {
                    step: state.step,
                    ply: ply as u32,
                    i: f.column,
                    j: j as u32,
                    yarn: f.yarn,
                    strain: f.strain,
                });
                // The last failure of an element that has nothing left is its erosion.
                let last = row.failures.get(at + 1).is_none_or(|next| next.column != f.column);
                totals.eroded += u64::from(last && !state.standing(index, f.column as usize));
            }
        }
        if *sample {
            ledger.sample_elements(&self.element_totals, &model.grid);
        }
    }

    fn node_pass(&mut self, frame: &mut Frame<'_, S>) {
        let kick = frame.kick();
        let (model, state) = (frame.model, &mut *frame.state);
        let grid = &model.grid;
        let (kernels, sample) = (&self.kernels, frame.sample);
        let (elements, nothing, reach) = (&state.elements, &self.nothing, &state.reach);
        let (stride, length) = (state.nodes.stride, state.nodes.row_length());
        let work = |(index, (storage, totals)): (usize, (&mut [S], &mut NodeTotals))| {
            let (ply, row) = grid.node_row(index);
            *totals = NodeTotals::default();
            if !reach[ply].rows.contains(&row) {
                return;
            }
            let sheet = model.sheet(ply);
            let around = neighbours(model, elements, nothing, ply, row);
            let m = sheet.row_mass(row);
            let mass = RowMass { inverse: [&m.inverse[0], &m.inverse[1], &m.inverse[2]], mass: &m.mass };
            let mut fields = split_mut(storage, stride);
            let part = Part {
                range: reach[ply].columns.clone(),
                columns: sheet.mesh.columns + 1,
                edge_row: row == 0 || row == sheet.mesh.rows,
            };
            let kernels = &kernels[model.plies[ply].sheet];
            *totals = kernels.nodes(&around, &mass, &mut fields, &part, [kick, model.dt], sample);
        };
        let rows = state.nodes.data.par_chunks_mut(length).zip(&mut self.node_totals);
        rows.enumerate().with_min_len(4).for_each(work);
    }
}

/// A vector of a row of nodes in the axes of the pack.
fn to_pack<S: Scalar>(model: &Model<S>, row: usize, vector: [f64; 3]) -> [f64; 3] {
    model.sheet(model.grid.node_row(row).0).mesh.to_pack(vector)
}

/// Element rows around a row of nodes; `nothing` where the ply ends.
fn neighbours<'a, S: Scalar>(
    model: &Model<S>,
    elements: &'a Rows<S>,
    nothing: &'a [S],
    ply: usize,
    row: usize,
) -> Neighbours<'a, S> {
    let index = model.grid.first_element_row(ply) + row;
    let below = if row > 0 { elements.row(index - 1) } else { nothing };
    let above = if row < model.sheet(ply).mesh.rows { elements.row(index) } else { nothing };
    Neighbours { below: split(below, elements.stride), above: split(above, elements.stride) }
}
