//! One time step: the only place that knows the order of the kernels.
//!
//! 0. the yarns that break in this step are marked;
//! 1. `sweep`: `element_force` on every row of elements, from the positions, and `node_update` on every row of nodes: gather, kick, drift;
//! 2. `ply_contact` between neighbouring plies, and
//! 3. `projectile_contact` on the nodes near the projectile, each correcting velocity and position of what it touches;
//! 4. `rigid_body`: the projectile moves.
//!
//! Rows run in parallel; sums are kept by row and added in row order, so results do not depend on threads. Rows and
//! columns that nothing has reached are left out.

/// Contact of the plies with one another and with the projectile: broad phase, narrow phase, contact impulses.
pub mod contact {
    pub mod broad_phase;
    pub(crate) mod candidate_edges;
    pub mod edge_contact;
    pub(crate) mod ply_impulse;
    pub(crate) mod ply_move;
    pub mod ply_search;
    pub mod projectile_contact;
    pub mod projectile_points;
}
pub mod element_force;
pub mod element_totals;
pub mod energy_balance;
pub mod failure;
pub mod node_update;
pub mod state;
pub mod sweep;

use std::time::Duration;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use web_time::Instant;

use crate::model::Model;
use crate::num::scalar::Scalar;
use crate::num::simd::Vectors;
use crate::solver::contact::ply_impulse::PlyContact;
use crate::solver::contact::projectile_points::ProjectileContact;
use crate::solver::element_totals::{ElementTotals, field as element};
use crate::solver::energy_balance::{EnergyBalance, add};
use crate::solver::failure::{evaluate_failure, yarn_loads};
use crate::solver::node_update::{NodeTotals, field as node};
use crate::solver::state::State;
use crate::solver::sweep::{KernelScalar, RowKernels};

/// A yarn failure, with its place in the pack.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
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

/// Totals of one step.
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

/// Place and number that a run went wrong with.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// Step.
    pub step: u64,
    /// Kernel that produced the number.
    pub kernel: &'static str,
    /// Quantity and its value.
    pub quantity: String,
    /// Ply, row, column of the node or element.
    pub place: [usize; 3],
}

/// Looks for numbers that are not finite: which kernel made them, and where.
fn find_divergence<S: Scalar>(model: &Model<S>, state: &State<S>) -> Option<Divergence> {
    let grid = &model.grid;
    let bad = |x: &S| !x.to_f64().is_finite();
    let divergence = |kernel, name: &str, x: S, place| {
        Some(Divergence { step: state.step, kernel, quantity: format!("{name} = {x:?}"), place })
    };
    let forces = ["membrane force along warp", "membrane force along weft", "hourglass force"];
    let name_of = |field: usize| forces.get(field / 3).copied().unwrap_or("yarn height, or what predicts it");
    for place @ [ply, row, column] in model.element_places() {
        let number = |f: usize| state.elements.get(grid.first_element_row(ply) + row, f, column + 1);
        if let Some(f) = (0..element::ALIVE).find(|f| bad(&number(*f))) {
            return divergence("element_force", name_of(f), number(f), place);
        }
    }
    for place @ [ply, row, column] in model.node_places() {
        let number = |f: usize| state.nodes.get(grid.first_node_row(ply) + row, f, column);
        if let Some(f) = (0..node::COUNT).find(|f| bad(&number(*f))) {
            let name = if f < node::VELOCITY { "displacement" } else { "velocity" };
            return divergence("node_update", name, number(f), place);
        }
    }
    None
}

/// Divergence and its place: a number that is not finite, or energy of some kind that was never put in [J].
pub(crate) fn diagnose<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    (name, energy): (&str, f64),
    available: f64,
) -> Divergence {
    let mut divergence = find_divergence(model, state).unwrap_or_else(|| {
        let speed = |[ply, row, column]: [usize; 3]| {
            Vector3::from(state.velocity(model.grid.first_node_row(ply) + row, column)).norm()
        };
        let speeds = model.node_places().map(|place| (place, speed(place)));
        let (place, speed) = speeds.fold(([0; 3], 0.0), |fastest, one| if one.1 > fastest.1 { one } else { fastest });
        let [energy, available] = [energy, available].map(|energy| energy * model.planes.copies() as f64);
        Divergence {
            step: state.step,
            kernel: "node_update",
            quantity: format!(
                "{name} {energy:.6e} J where at most {available:.6e} J was ever put in; fastest node {speed:.6e} m/s"
            ),
            place,
        }
    });
    divergence.place = model.place_in_whole(divergence.place);
    divergence
}

/// A phase of a step: a kernel with what is added up after it, or the record of what the step did.
#[derive(Clone, Copy, Debug)]
pub enum Phase {
    /// `element_force` and `node_update` in one sweep.
    Sweep,
    /// `ply_contact`
    PlyContact,
    /// `projectile_contact`, with the motion of the body.
    ProjectileContact,
    /// History, outcome, and the watch over the numbers.
    Record,
}

/// Adds up what each phase takes. A lap costs one reading of the clock.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Stopwatch {
    spent: [Duration; 4],
    #[serde(skip, default = "Instant::now")] // of this process alone
    last: Instant,
}

impl Stopwatch {
    /// Ends a lap: time since the last one belongs to this phase.
    pub fn lap(&mut self, phase: Phase) {
        let now = Instant::now();
        self.spent[phase as usize] += now - self.last;
        self.last = now;
    }

    /// Every phase by name, and its wall time [s].
    pub fn seconds(&self) -> Vec<(&'static str, f64)> {
        let names = ["sweep", "ply_contact", "projectile_contact", "record"];
        names.into_iter().zip(self.spent.map(|time| time.as_secs_f64())).collect()
    }
}

/// Model, state and sums that the stages of a step work on.
pub struct Context<'a, S> {
    /// Constant.
    pub model: &'a Model<S>,
    /// Varies.
    pub state: &'a mut State<S>,
    /// Takes note of work and losses.
    pub balance: &'a mut EnergyBalance,
    /// Totals of the step so far.
    pub totals: StepTotals,
    /// Whether the balance samples the energies at the time of the positions.
    pub sample: bool,
    /// Every element is known to be intact.
    pub whole: bool,
}

impl<'a, S: Scalar> Context<'a, S> {
    /// A step about to begin.
    pub fn new(model: &'a Model<S>, state: &'a mut State<S>, balance: &'a mut EnergyBalance, sample: bool) -> Self {
        Self { model, state, balance, totals: StepTotals::default(), sample, whole: false }
    }

    /// Time step of the velocities [s]: half a kick at the start puts them half a step after the positions.
    fn kick(&self) -> f64 {
        if self.state.step == 0 { 0.5 * self.model.dt } else { self.model.dt }
    }
}

/// Advances a state step by step.
pub struct Stepper<S: Scalar> {
    /// Kernels of each ply type.
    kernels: Vec<Box<dyn RowKernels<S>>>,
    element_totals: Vec<ElementTotals>,
    /// Whether those are of the last step.
    stepped: bool,
    node_totals: Vec<NodeTotals>,
    /// Zeros for a row of nodes without elements on one side.
    nothing: Vec<S>,
    plies: PlyContact,
    projectile: ProjectileContact,
    /// Every element is intact; `None`: not determined yet.
    whole: Option<bool>,
    /// Failures of the last step.
    pub failures: Vec<FailureEvent>,
    /// Time that the phases of the steps so far took.
    pub stopwatch: Stopwatch,
}

impl<S: KernelScalar> Stepper<S> {
    /// A stepper for a model, on the widest vectors there are.
    pub fn new(model: &Model<S>) -> Self {
        Self::with_vectors(model, Vectors::widest())
    }

    /// A stepper for a model.
    pub fn with_vectors(model: &Model<S>, vectors: Vectors) -> Self {
        let grid = &model.grid;
        Self {
            kernels: model.ply_types.iter().map(|ply_type| S::kernels(ply_type, vectors)).collect(),
            element_totals: vec![ElementTotals::default(); grid.element_rows()],
            stepped: false,
            node_totals: vec![NodeTotals::default(); grid.node_rows()],
            nothing: vec![S::splat(0.0); element::FORCES.end * grid.element_stride],
            plies: PlyContact::new(model),
            projectile: ProjectileContact::default(),
            whole: None,
            failures: Vec::new(),
            stopwatch: Stopwatch { spent: Default::default(), last: Instant::now() },
        }
    }

    /// One step from the positions at `state.step`·Δt. `sample`: fill in the energies at that time.
    pub fn step(
        &mut self,
        model: &Model<S>,
        state: &mut State<S>,
        balance: &mut EnergyBalance,
        sample: bool,
    ) -> StepTotals {
        let mut context = Context::new(model, state, balance, sample);
        self.stopwatch.last = Instant::now();
        self.sweep(&mut context);
        self.stopwatch.lap(Phase::Sweep);
        self.plies(&mut context);
        self.stopwatch.lap(Phase::PlyContact);
        self.projectile(&mut context);
        self.stopwatch.lap(Phase::ProjectileContact);
        context.state.step += 1;
        context.totals
    }

    /// The first part of a step on its own: forces of the elements, by which the nodes move.
    pub fn sweep(&mut self, context: &mut Context<'_, S>) {
        let last = self.stepped.then_some(&self.element_totals[..]);
        evaluate_failure(context.model, context.state, last);
        self.stepped = true;
        let Self { kernels, nothing, element_totals, node_totals, .. } = self;
        sweep::sweep(context, kernels, nothing, element_totals, node_totals);
        self.collect_elements(context);
        self.collect_nodes(context);
        if context.totals.eroded > 0 {
            self.whole = Some(false);
        }
        context.whole = *self.whole.get_or_insert_with(|| context.state.holes(context.model) == 0);
    }

    /// Adds up what the rows of nodes did, in row order.
    fn collect_nodes(&mut self, context: &mut Context<'_, S>) {
        for (ply, reach) in context.state.active.iter_mut().enumerate() {
            *reach = reach.grown(1, &context.model.ply_type(ply).mesh);
        }
        let work = |i: usize| self.node_totals.iter().map(|row| row.work[i]).sum::<f64>();
        context.balance.work += context.balance.half_step + work(0);
        context.balance.half_step = work(1);
        for (index, row) in self.node_totals.iter().enumerate() {
            context.totals.kinetic += row.kinetic;
            context.balance.backing += row.clay[0];
            context.totals.max_speed = context.totals.max_speed.max(row.max_speed_squared);
            add(&mut context.balance.support, to_pack(context.model, index, row.support));
        }
        context.totals.max_speed = context.totals.max_speed.sqrt();
        if context.sample {
            context.balance.sample_nodes(&self.node_totals, context.model);
        }
    }

    /// The second part: contact between the plies.
    pub fn plies(&mut self, context: &mut Context<'_, S>) {
        if context.model.plies.len() > 1 {
            self.plies.resolve(context, &*self.kernels[0], &self.nothing);
        }
    }

    /// The third part: contact with the projectile, and its motion.
    pub fn projectile(&mut self, context: &mut Context<'_, S>) {
        if let Some(mut body) = context.state.body.take() {
            sweep::beside_others(|| self.projectile.resolve(context, &mut body, &self.nothing));
            if context.sample {
                context.balance.sample_body(&body);
            }
            body.advance(context.model.dt);
            context.state.body = Some(body);
        }
    }

    /// Adds up what the rows of elements did, in row order.
    fn collect_elements(&mut self, context: &mut Context<'_, S>) {
        let Context { model, state, balance, totals, sample, .. } = context;
        self.failures.clear();
        for (index, row) in self.element_totals.iter().enumerate() {
            balance.viscous += row.viscous_work;
            balance.law_released += row.law_released;
            balance.released[0] += row.released[0];
            balance.released[1] += row.released[1];
            totals.unconverged += u64::from(row.unconverged);
            totals.iterations += row.iterations;
            totals.solved += row.solved;
            totals.max_residual = totals.max_residual.max(row.max_residual);
            totals.computed += row.computed as u64;
            let (ply, j) = model.grid.element_row(index);
            for (at, f) in row.failures.iter().enumerate() {
                self.failures.push(FailureEvent { step: state.step, ply: ply as u32, j: j as u32, ..*f });
                // The last failure of an element that has nothing left is its erosion.
                let last = row.failures.get(at + 1).is_none_or(|next| next.i != f.i);
                totals.eroded += u64::from(last && !state.is_intact(index, f.i as usize));
            }
        }
        if *sample {
            let loads = yarn_loads(model, state, Some(&self.element_totals));
            balance.sample_elements(&self.element_totals, &model.grid, loads);
        }
    }
}

/// A vector of a row of nodes in the axes of the pack.
fn to_pack<S: Scalar>(model: &Model<S>, row: usize, vector: [f64; 3]) -> [f64; 3] {
    model.ply_type(model.grid.node_row(row).0).mesh.to_pack(vector)
}

/// Everything in a stepper that later steps depend on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StepperState {
    /// Largest distance that any node may have gone so far [m].
    travel: f64,
    /// Ply, row, column of the nodes near the projectile.
    candidates: Vec<[usize; 3]>,
    /// Distance that they and the projectile may still approach each other before the list is stale [m].
    skin: f64,
    /// Which of them, and of the edges between them, did not push in the last step, though they might have touched.
    idle: Vec<bool>,
}

impl<S: Scalar> Stepper<S> {
    /// State of the stepper that the next steps depend on.
    pub(crate) fn memory(&self) -> StepperState {
        let projectile = &self.projectile;
        StepperState {
            travel: self.plies.travel,
            candidates: projectile.candidates.clone(),
            skin: projectile.skin,
            idle: projectile.idle.clone(),
        }
    }

    /// Goes on with the memory of another stepper of the same model.
    pub(crate) fn remember(&mut self, model: &Model<S>, memory: StepperState) {
        self.plies.travel = memory.travel;
        self.projectile.remember(model, memory.candidates, memory.skin);
        self.projectile.idle = memory.idle;
    }
}
