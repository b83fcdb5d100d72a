//! One time step: the only place that knows the order of the kernels.
//!
//! 1. `element_force` on every row of elements, from the positions;
//! 2. `node_update` on every row of nodes: gather, kick, drift;
//! 3. `projectile_contact` on the nodes near the projectile, correcting their velocity and position;
//! 4. `rigid_body`: the projectile moves.
//!
//! Rows run in parallel; sums are kept by row and added in row order, so results do not depend on threads.

use nalgebra::Vector3;
use rayon::prelude::*;

use crate::kernels::crossover::LawKernel;
use crate::kernels::element_force::{self, ElementConstants, ElementRow, ElementTotals, field as element};
use crate::kernels::node_update::{self, Neighbours, NodeTotals, RowMass, field as node};
use crate::kernels::projectile_contact::{self, ContactPoint, ContactTotals};
use crate::kernels::rigid_body::RigidBody;
use crate::ledger::Ledger;
use crate::model::{Grid, Model};
use crate::number::{Real, Scalar};
use crate::state::{Rows, State, split, split_mut};

type ElementKernel<R> =
    fn(&ElementConstants<R>, &mut ElementRow<'_, <R as Real>::Scalar>, usize, f64, &mut ElementTotals);

type NodeKernel<R> = fn(
    &Neighbours<'_, <R as Real>::Scalar>,
    &RowMass<'_, <R as Real>::Scalar>,
    &mut [&mut [<R as Real>::Scalar]; node::COUNT],
    usize,
    bool,
    f64,
    f64,
) -> NodeTotals;

/// The kernels a scene needs, chosen once; what it lacks is not in them.
struct Kernels<R: Real> {
    constants: ElementConstants<R>,
    /// Plain, and with the ledger.
    element: [ElementKernel<R>; 2],
    node: [NodeKernel<R>; 2],
}

impl<R: Real> Kernels<R> {
    fn new<L: LawKernel>(model: &Model<R::Scalar>) -> Self {
        use element_force::element_force as kernel;
        let element: [ElementKernel<R>; 2] = if model.has_shear {
            [kernel::<R, L, true, false>, kernel::<R, L, true, true>]
        } else {
            [kernel::<R, L, false, false>, kernel::<R, L, false, true>]
        };
        let node: [NodeKernel<R>; 2] = [node_update::node_update::<R, false>, node_update::node_update::<R, true>];
        Self { constants: model.constants::<R, L>(), element, node }
    }
}

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
    /// Projectile contact.
    pub contact: ContactTotals,
    /// Deepest node inside the projectile at the start of the step [m].
    pub penetration: f64,
    /// Elements whose last yarn failed.
    pub eroded: u64,
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

/// Advances a state step by step.
pub struct Stepper<R: Real> {
    kernels: Kernels<R>,
    element_totals: Vec<ElementTotals>,
    node_totals: Vec<NodeTotals>,
    /// What a row of nodes without elements on one side reads.
    nothing: Vec<R::Scalar>,
    near: Vec<(u32, u32)>,
    /// How far nodes and body may still approach each other before `near` is stale [m].
    reserve: f64,
    points: Vec<ContactPoint>,
    /// Failures of the last step.
    pub failures: Vec<FailureEvent>,
}

/// Steps a list of nearby nodes is meant to last.
const NEAR_STEPS: f64 = 24.0;

impl<R: Real + Send + Sync> Stepper<R> {
    /// A stepper for a model.
    pub fn new(model: &Model<R::Scalar>) -> Self {
        let grid = &model.grid;
        let kernels = crate::with_law!(model.law, L => Kernels::new::<L>(model));
        Self {
            kernels,
            element_totals: vec![ElementTotals::default(); grid.element_rows()],
            node_totals: vec![NodeTotals::default(); grid.node_rows()],
            nothing: vec![R::Scalar::splat(0.0); element::COUNT * grid.element_stride],
            near: Vec::new(),
            reserve: 0.0,
            points: Vec::new(),
            failures: Vec::new(),
        }
    }

    /// One step from the positions at `state.step`·Δt. `ledger`: fill in the energies at that time.
    pub fn step(
        &mut self,
        model: &Model<R::Scalar>,
        state: &mut State<R::Scalar>,
        ledger: &mut Ledger,
        sample: bool,
    ) -> StepTotals {
        let mut totals = StepTotals::default();
        self.elements(model, state, ledger, &mut totals, sample);
        self.nodes(model, state, ledger, &mut totals, sample);
        self.projectile(model, state, ledger, &mut totals, sample);
        state.step += 1;
        totals
    }

    /// The first part of a step: forces of the elements.
    pub fn elements(
        &mut self,
        model: &Model<R::Scalar>,
        state: &mut State<R::Scalar>,
        ledger: &mut Ledger,
        totals: &mut StepTotals,
        sample: bool,
    ) {
        let span = if state.step == 0 { 0.0 } else { model.dt };
        self.element_pass(model, state, span, sample);
        self.collect_elements(model, state, ledger, totals, sample);
    }

    /// The second part: the nodes move.
    pub fn nodes(
        &mut self,
        model: &Model<R::Scalar>,
        state: &mut State<R::Scalar>,
        ledger: &mut Ledger,
        totals: &mut StepTotals,
        sample: bool,
    ) {
        self.node_pass(model, state, kick(model, state), sample);
        for row in &self.node_totals {
            totals.kinetic += row.kinetic;
            totals.max_speed = totals.max_speed.max(row.max_speed_squared);
            for a in 0..3 {
                ledger.support[a] += row.support[a];
            }
        }
        totals.max_speed = totals.max_speed.sqrt();
        if sample {
            ledger.sample_nodes(&self.node_totals);
        }
    }

    /// The third part: contact with the projectile, and its motion.
    pub fn projectile(
        &mut self,
        model: &Model<R::Scalar>,
        state: &mut State<R::Scalar>,
        ledger: &mut Ledger,
        totals: &mut StepTotals,
        sample: bool,
    ) {
        if let Some(mut body) = state.body.take() {
            self.contact(model, state, &mut body, totals, ledger, sample);
            if sample {
                ledger.sample_body(&body);
            }
            body.advance(model.dt);
            state.body = Some(body);
        }
    }

    /// Largest |z displacement| of standing fabric at the last sample [m].
    pub fn max_deflection(&self) -> f64 {
        self.element_totals.iter().map(|r| r.max_deflection).fold(0.0, f64::max)
    }

    fn element_pass(&mut self, model: &Model<R::Scalar>, state: &mut State<R::Scalar>, dt: f64, sample: bool) {
        let grid = &model.grid;
        let kernel = self.kernels.element[usize::from(sample)];
        let constants = &self.kernels.constants;
        let (nodes, stride) = (&state.nodes, state.elements.stride);
        let length = state.elements.row_length();
        let work = |(index, (storage, totals)): (usize, (&mut [R::Scalar], &mut ElementTotals))| {
            let (ply, row) = grid.element_row(index);
            let below = ply * (grid.rows + 1) + row;
            totals.clear();
            let mut row = ElementRow {
                below: split(nodes.row(below), nodes.stride),
                above: split(nodes.row(below + 1), nodes.stride),
                element: split_mut(storage, stride),
            };
            kernel(constants, &mut row, grid.columns, dt, totals);
        };
        let rows = state.elements.data.par_chunks_mut(length).zip(&mut self.element_totals);
        rows.enumerate().with_min_len(4).for_each(work);
    }

    /// Adds up what the rows did, in row order.
    fn collect_elements(
        &mut self,
        model: &Model<R::Scalar>,
        state: &State<R::Scalar>,
        ledger: &mut Ledger,
        totals: &mut StepTotals,
        sample: bool,
    ) {
        self.failures.clear();
        for (index, row) in self.element_totals.iter().enumerate() {
            ledger.work += row.internal_work;
            ledger.released[0] += row.released[0];
            ledger.released[1] += row.released[1];
            totals.unconverged += u64::from(row.unconverged);
            totals.iterations += row.iterations;
            totals.solved += row.solved;
            totals.max_residual = totals.max_residual.max(row.max_residual);
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
        if sample {
            ledger.sample_elements(&self.element_totals);
        }
    }

    fn node_pass(&mut self, model: &Model<R::Scalar>, state: &mut State<R::Scalar>, kick: f64, sample: bool) {
        let grid = &model.grid;
        let kernel = self.kernels.node[usize::from(sample)];
        let (elements, nothing) = (&state.elements, &self.nothing);
        let (stride, length) = (state.nodes.stride, state.nodes.row_length());
        let work = |(index, (storage, totals)): (usize, (&mut [R::Scalar], &mut NodeTotals))| {
            let (_, row) = grid.node_row(index);
            let around = neighbours(grid, elements, nothing, index);
            let m = model.row_mass(row);
            let mass = RowMass { inverse: [&m.inverse[0], &m.inverse[1], &m.inverse[2]], mass: &m.mass };
            let edge = row == 0 || row == grid.rows;
            let mut fields = split_mut(storage, stride);
            *totals = kernel(&around, &mass, &mut fields, grid.columns + 1, edge, kick, model.dt);
        };
        let rows = state.nodes.data.par_chunks_mut(length).zip(&mut self.node_totals);
        rows.enumerate().with_min_len(4).for_each(work);
    }

    fn contact(
        &mut self,
        model: &Model<R::Scalar>,
        state: &mut State<R::Scalar>,
        body: &mut RigidBody,
        totals: &mut StepTotals,
        ledger: &mut Ledger,
        sample: bool,
    ) {
        let kick = kick(model, state);
        let travel = model.dt * (totals.max_speed + body.speed_bound());
        if !travel.is_finite() {
            return; // the run stops on its own check of the numbers
        }
        self.reserve -= travel;
        if self.reserve < 0.0 {
            self.reserve = NEAR_STEPS * travel;
            self.near = near_nodes(model, state, body, self.reserve + travel);
        }
        self.gather_points(model, state, body, kick, totals);
        if self.points.is_empty() {
            return;
        }
        totals.contact = projectile_contact::resolve(body, &mut self.points, model.friction, model.dt);
        ledger.add_contact(&totals.contact);
        for p in self.points.iter().filter(|p| p.push > 0.0) {
            let velocity = p.velocity();
            for a in 0..3 {
                let change = velocity[a] - p.free[a];
                let u = state.nodes.get(p.row, node::DISPLACEMENT + a, p.column).to_f64();
                let moved = R::Scalar::splat(u + model.dt * change);
                state.nodes.set(p.row, node::DISPLACEMENT + a, p.column, moved);
                state.nodes.set(p.row, node::VELOCITY + a, p.column, R::Scalar::splat(velocity[a]));
            }
            if sample {
                ledger.correct_node(p, model.dt / kick);
            }
        }
    }

    /// The nodes that may touch the body in this step.
    fn gather_points(
        &mut self,
        model: &Model<R::Scalar>,
        state: &State<R::Scalar>,
        body: &RigidBody,
        kick: f64,
        totals: &mut StepTotals,
    ) {
        let grid = &model.grid;
        self.points.clear();
        for &(row, column) in &self.near {
            let (row, column) = (row as usize, column as usize);
            let (_, in_ply) = grid.node_row(row);
            if !node_stands(grid, state, row, column) {
                continue;
            }
            let free = Vector3::from(state.velocity(row, column));
            let [x, y] = grid.reference(in_ply, column);
            let moved = Vector3::from(state.displacement(row, column)) - free * model.dt;
            let position = Vector3::new(x, y, 0.0) + moved;
            let (gap, normal) = body.holding_gap(&position);
            totals.penetration = totals.penetration.max(-gap);
            let arm = position - body.position;
            let approach = (free - body.velocity_at(&arm)).dot(&normal);
            // A body that turns under impulses may reach a little further than its velocity now tells.
            if gap + model.dt * (approach - 0.1 * body.speed_bound()) > 0.0 {
                continue;
            }
            let m = model.row_mass(in_ply);
            let inverse = Vector3::from([0, 1, 2].map(|a| m.inverse[a][column].to_f64()));
            if body.prescribed && normal.dot(&inverse.component_mul(&normal)) <= 0.0 {
                continue; // both are held: neither can give way, and no finite impulse would change that
            }
            let around = neighbours(grid, &state.elements, &self.nothing, row);
            let force = node_update::gather::<R::Scalar>(&around, column).map(Scalar::to_f64);
            let mut point = ContactPoint {
                row,
                column,
                gap,
                normal,
                arm,
                before: free - inverse.component_mul(&Vector3::from(force)) * kick,
                free,
                inverse,
                mass: m.mass[column].to_f64(),
                kappa: 0.0,
                push: 0.0,
                drag: Vector3::zeros(),
                active: false,
            };
            point.set_kappa();
            self.points.push(point);
        }
    }
}

/// Time step of the velocities [s]: half a kick at the start puts them half a step after the positions.
fn kick<S: Scalar>(model: &Model<S>, state: &State<S>) -> f64 {
    if state.step == 0 { 0.5 * model.dt } else { model.dt }
}

/// Element rows around a row of nodes; `nothing` where the ply ends.
fn neighbours<'a, S: Scalar>(grid: &Grid, elements: &'a Rows<S>, nothing: &'a [S], row: usize) -> Neighbours<'a, S> {
    let (ply, in_ply) = grid.node_row(row);
    let index = ply * grid.rows + in_ply;
    let below = if in_ply > 0 { elements.row(index - 1) } else { nothing };
    let above = if in_ply < grid.rows { elements.row(index) } else { nothing };
    Neighbours { below: split(below, elements.stride), above: split(above, elements.stride) }
}

/// Whether any element around a node still carries load; debris no longer touches the projectile.
pub fn node_stands<S: Scalar>(grid: &Grid, state: &State<S>, row: usize, column: usize) -> bool {
    let (ply, in_ply) = grid.node_row(row);
    let rows = in_ply.saturating_sub(1)..(in_ply + 1).min(grid.rows);
    let mut columns = column.saturating_sub(1)..(column + 1).min(grid.columns);
    columns.any(|c| rows.clone().any(|r| state.standing(ply * grid.rows + r, c)))
}

/// Position of a node [m].
pub fn node_position<S: Scalar>(grid: &Grid, state: &State<S>, row: usize, column: usize) -> Vector3<f64> {
    let [x, y] = grid.reference(grid.node_row(row).1, column);
    Vector3::new(x, y, 0.0) + Vector3::from(state.displacement(row, column))
}

/// Nodes within `margin` of the body, in storage order.
fn near_nodes<S: Scalar>(model: &Model<S>, state: &State<S>, body: &RigidBody, margin: f64) -> Vec<(u32, u32)> {
    let grid = &model.grid;
    let bar = body.body.profile.bar;
    let found = (0..grid.node_rows()).into_par_iter().with_min_len(16).map(|row| {
        let mut out = Vec::new();
        for column in 0..=grid.columns {
            let position = node_position(grid, state, row, column);
            // Cheap test against the sphere around the body first.
            let far = !bar && (position - body.position).norm() > body.body.reach + margin;
            if !far && body.gap(&position).0 < margin {
                out.push((row as u32, column as u32));
            }
        }
        out
    });
    found.collect::<Vec<_>>().concat()
}

/// Ply, row and column of the fastest node, and its speed [m/s].
pub fn fastest_node<S: Scalar>(grid: &Grid, state: &State<S>) -> ([usize; 3], f64) {
    let mut fastest = ([0; 3], 0.0);
    for index in 0..grid.node_rows() {
        let (ply, row) = grid.node_row(index);
        for column in 0..=grid.columns {
            let speed = Vector3::from(state.velocity(index, column)).norm();
            if speed > fastest.1 {
                fastest = ([ply, row, column], speed);
            }
        }
    }
    fastest
}

/// Looks for numbers that are not finite: which kernel made them, and where.
pub fn find_trouble<S: Scalar>(model: &Model<S>, state: &State<S>) -> Option<Trouble> {
    let grid = &model.grid;
    let bad = |x: S| !x.to_f64().is_finite();
    let element_names = ["membrane force along warp", "membrane force along weft", "hourglass force", "yarn height"];
    for index in 0..grid.element_rows() {
        let (ply, row) = grid.element_row(index);
        for column in 0..grid.columns {
            for f in 0..element::ALIVE {
                let x = state.elements.get(index, f, column + 1);
                if bad(x) {
                    let quantity = format!("{} = {x:?}", element_names[f / 3]);
                    let place = [ply, row, column];
                    return Some(Trouble { step: state.step, kernel: "element_force", quantity, place });
                }
            }
        }
    }
    for index in 0..grid.node_rows() {
        let (ply, row) = grid.node_row(index);
        for column in 0..=grid.columns {
            for f in 0..node::COUNT {
                let x = state.nodes.get(index, f, column);
                if bad(x) {
                    let name = if f < node::VELOCITY { "displacement" } else { "velocity" };
                    let quantity = format!("{name} = {x:?}");
                    return Some(Trouble {
                        step: state.step,
                        kernel: "node_update",
                        quantity,
                        place: [ply, row, column],
                    });
                }
            }
        }
    }
    None
}
