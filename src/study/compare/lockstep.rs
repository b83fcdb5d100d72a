//! The three runs that are compared, step by step.

use std::ops::Range;

use crate::case::Case;
use crate::gpu::layout::{self, WorkgroupSums, sum};
use crate::gpu::stepper::{DeviceStepper, Stage};
use crate::gpu::{Device, DeviceError};
use crate::kernels::element_force::field as element;
use crate::kernels::node_update::field as node;
use crate::kernels::rigid_body::RigidBody;
use crate::model::Model;
use crate::run::RunError;
use crate::solver::energy_balance::EnergyBalance;
use crate::solver::state::{Rows, State};
use crate::solver::{self, Context, KernelScalar, StepTotals};

use super::scales::Scales;
use super::tolerances::line;
use super::{BackendDifference, Comparison};

/// Speeds below that are not measured [m/s].
const LEAST_SPEED: f64 = 1e-3;

/// A run on the processor, stage by stage.
pub(super) struct Twin<S: KernelScalar> {
    pub(super) model: Model<S>,
    pub(super) state: State<S>,
    pub(super) stepper: solver::Stepper<S>,
    pub(super) ledger: EnergyBalance,
    /// Of the step at hand.
    totals: StepTotals,
}

impl<S: KernelScalar> Twin<S> {
    fn new((model, state): (Model<S>, State<S>)) -> Self {
        let stepper = solver::Stepper::new(&model);
        Self { model, state, stepper, ledger: EnergyBalance::default(), totals: StepTotals::default() }
    }

    fn run(&mut self, stage: fn(&mut solver::Stepper<S>, &mut Context<'_, S>)) {
        let mut context = Context::new(&self.model, &mut self.state, &mut self.ledger, true);
        context.totals = std::mem::take(&mut self.totals);
        stage(&mut self.stepper, &mut context);
        self.totals = std::mem::take(&mut context.totals);
    }
}

/// The three runs.
pub(super) struct Lockstep<'a> {
    /// In single precision.
    pub(super) leader: Twin<f32>,
    /// In double precision, from the leader's state before every stage.
    follower: Twin<f64>,
    gpu: State<f32>,
    device: DeviceStepper<'a>,
    pub(super) comparison: Comparison,
}

impl<'a> Lockstep<'a> {
    pub(super) fn new(case: &Case, device: &'a Device) -> Result<Self, RunError> {
        let leader = Twin::new(solver::set_up::<f32>(case, false)?);
        let wide = Model::<f64>::new(case).map_err(RunError::Model)?;
        Ok(Self {
            device: DeviceStepper::new(device, &leader.model)?,
            gpu: leader.state.clone(),
            follower: Twin::new((wide, widen(&leader.state))),
            leader,
            comparison: Comparison::new(device.is_hardware()),
        })
    }

    pub(super) fn compare_step(&mut self) -> Result<(), DeviceError> {
        let step = self.leader.state.step;
        let info = self.device.whole_step(step, Some(0), 1);
        self.leader.totals = StepTotals::default();
        self.follower.totals = StepTotals::default();
        self.follower.state = widen(&self.leader.state);
        self.follower.ledger = EnergyBalance::default();
        let work_before = self.leader.ledger.work;

        self.device.upload(&self.leader.model, &self.leader.state);
        self.leader.run(solver::Stepper::elements);
        self.follower.run(solver::Stepper::elements);
        self.device.run_stages(&info, &[Stage::Elements])?;
        self.device.download(0, &self.leader.model, &mut self.gpu)?;
        let scales = self.scales();
        self.elements(&scales);

        // The accounts of the elements stay on the device for the ledger; all else is the leader's.
        self.device.upload_but_accounts(&self.leader.model, &self.leader.state);
        // Contact between plies adds to the work of the membrane later: on the device that is another sum.
        let work = [self.leader.ledger.work - work_before, self.follower.ledger.work];
        self.follower.state = widen(&self.leader.state);
        self.leader.run(solver::Stepper::nodes);
        self.follower.run(solver::Stepper::nodes);
        self.device.run_stages(&info, &[Stage::Nodes])?;
        self.device.download(0, &self.leader.model, &mut self.gpu)?;
        let scales = self.scales();
        self.nodes("node_update", &scales);

        if self.leader.model.plies.len() > 1 {
            self.leader.run(solver::Stepper::plies);
            self.follower.run(solver::Stepper::plies);
            self.device.run_stages(&info, &[Stage::Plies])?;
            self.device.download(0, &self.leader.model, &mut self.gpu)?;
            self.nodes("ply_contact", &scales);
        }

        self.leader.run(solver::Stepper::projectile);
        self.follower.run(solver::Stepper::projectile);
        self.device.run_stages(&info, &[Stage::Projectile, Stage::EnergyBalance])?;
        self.device.download(0, &self.leader.model, &mut self.gpu)?;
        if self.leader.state.body.is_some() {
            self.nodes("projectile_contact", &scales);
            self.body("projectile_contact", &scales);
        }
        self.leader.state.step += 1;
        let sample = self.device.read_sample()?;
        self.sums(&scales, step, &sample, work);
        self.comparison.compared += 1;
        Ok(())
    }

    /// Scales of the leader's state.
    fn scales(&self) -> Scales {
        Scales::of(&self.leader.model, &self.leader.state, LEAST_SPEED)
    }

    fn elements(&mut self, scales: &Scales) {
        let mut fields = vec![
            ("membrane force", element::WARP_FORCE..element::HOURGLASS, scales.force),
            ("hourglass force", element::HOURGLASS..element::FORCES.end, scales.force),
            ("yarn height", element::HEIGHT..element::ALIVE, scales.height),
            ("yarn alive", element::ALIVE..element::COUNT, 1.0),
        ];
        if self.leader.model.features().viscous {
            fields.push(("viscous force", element::COUNT..element::COUNT + element::VISCOUS, scales.viscous_force));
        }
        self.element_fields("element_force", &fields);
    }

    /// Fields of every element after a kernel: the quantity, which fields, their scale.
    fn element_fields(&mut self, kernel: &str, fields: &[(&str, Range<usize>, f64)]) {
        let Self {
            leader: Twin { model, state: cpu, .. }, follower: Twin { state: wide, .. }, gpu, comparison, ..
        } = self;
        for &(quantity, ref fields, scale) in fields {
            let what = line(kernel, quantity);
            let own = if fields.start < element::FORCES.end { 1.0 } else { 0.0 };
            for (field, row) in
                fields.clone().flat_map(|field| (0..model.grid.element_rows()).map(move |row| (field, row)))
            {
                let (ply, in_ply) = model.grid.element_row(row);
                for column in 0..model.grid.columns {
                    if fields.start == element::HEIGHT && !cpu.is_intact(row, column) {
                        continue; // nobody reads the heights of an eroded element
                    }
                    let pick = |rows: &Rows<f32>| f64::from(rows.get(row, field, column + 1));
                    let [on_cpu, on_gpu] = [&cpu.elements, &gpu.elements].map(pick);
                    let values = [on_cpu, on_gpu, wide.elements.get(row, field, column + 1)];
                    let (place, scale) = ([ply, in_ply, column], scale + own * on_cpu.abs());
                    comparison.see(difference(cpu.step, what, place, field - fields.start, values, scale));
                }
            }
        }
    }

    fn nodes(&mut self, kernel: &str, scales: &Scales) {
        let Self {
            leader: Twin { model, state: cpu, .. }, follower: Twin { state: wide, .. }, gpu, comparison, ..
        } = self;
        for field in 0..node::COUNT {
            let (quantity, scale) = match field {
                node::VELOCITY.. if kernel == "node_update" => ("velocity", scales.speed),
                node::VELOCITY.. => ("velocity", scales.pushed()),
                _ if kernel.starts_with("projectile") => ("displacement", scales.closed()),
                _ => ("displacement", scales.length),
            };
            let what = line(kernel, quantity);
            for row in 0..model.grid.node_rows() {
                let (ply, in_ply) = model.grid.node_row(row);
                for column in 0..=model.grid.columns {
                    let [on_cpu, on_gpu] = [&cpu.nodes, &gpu.nodes].map(|rows| f64::from(rows.get(row, field, column)));
                    let values = [on_cpu, on_gpu, wide.nodes.get(row, field, column)];
                    comparison.see(difference(cpu.step, what, [ply, in_ply, column], field % 3, values, scale));
                }
            }
        }
    }

    fn body(&mut self, kernel: &str, scales: &Scales) {
        let step = self.leader.state.step;
        let (Some(cpu), Some(gpu), Some(wide)) = (&self.leader.state.body, &self.gpu.body, &self.follower.state.body)
        else {
            return;
        };
        type Pick = fn(&RigidBody) -> [f64; 4];
        let vectors: [(&str, Pick, f64); 4] = [
            ("body velocity", |b| [b.velocity.x, b.velocity.y, b.velocity.z, 0.0], scales.body_velocity()),
            ("body position", |b| [b.position.x, b.position.y, b.position.z, 0.0], scales.body_position()),
            ("body orientation", |b| [b.orientation.i, b.orientation.j, b.orientation.k, b.orientation.w], 1.0),
            (
                "angular momentum",
                |b| [b.angular_momentum.x, b.angular_momentum.y, b.angular_momentum.z, 0.0],
                scales.spin + cpu.angular_momentum.norm(),
            ),
        ];
        for (quantity, pick, scale) in vectors {
            let what = line(kernel, quantity);
            let values = [pick(cpu), pick(gpu), pick(wide)];
            for a in 0..4 {
                self.comparison.see(difference(step, what, [0; 3], a, values.map(|v| v[a]), scale));
            }
        }
    }

    /// Sums of the ledger: fabric only.
    fn sums(&mut self, scales: &Scales, step: u64, sample: &[u32], [work, wide_work]: [f64; 2]) {
        let (sums, rest) = sample.split_at(self.device.body_at());
        let sums = WorkgroupSums(sums);
        let (cpu, wide) = (self.leader.ledger.fabric(), self.follower.ledger.fabric());
        let mut see = |quantity: &str, component: usize, values: [f64; 3], scale: f64| {
            self.comparison.see(difference(step, line("ledger", quantity), [0; 3], component, values, scale));
        };
        let kinetic = cpu.kinetic + scales.contact_energy;
        see("kinetic energy now", 0, [cpu.kinetic, sums.add(sum::KINETIC_NOW), wide.kinetic], kinetic);
        // The processor's ledger holds fabric and projectile together; the device's sums are the fabric's.
        let body = self
            .leader
            .model
            .projectile
            .as_ref()
            .filter(|p| !p.prescribed)
            .map(|p| layout::read_body(rest, p, &layout::device_origin(&self.leader.model)).body.velocity * p.mass);
        for a in 0..3 {
            let flying = body.map_or(0.0, |b| b[a]);
            let gpu = sums.add(sum::MOMENTUM + a) + flying;
            see("momentum", a, [cpu.momentum[a], gpu, wide.momentum[a]], scales.momentum);
        }
        see("stored energy", 0, [cpu.stored, sums.add(sum::STORED), wide.stored], scales.energy + cpu.stored.abs());
        see("work", 0, [work, sums.add(sum::WORK), wide_work], scales.energy + work.abs());
    }
}

fn difference(
    step: u64,
    what: usize,
    place: [usize; 3],
    component: usize,
    [cpu, gpu, wide]: [f64; 3],
    scale: f64,
) -> BackendDifference {
    let relative = (gpu - cpu).abs() / scale;
    let rounding = (cpu - wide).abs() / scale;
    BackendDifference { step, what, place, component, cpu, gpu, wide, relative, rounding, limit: 0.0 }
}

/// The same state in double precision.
fn widen(state: &State<f32>) -> State<f64> {
    State {
        nodes: state.nodes.widened(),
        elements: state.elements.widened(),
        active: state.active.clone(),
        over: state.over.clone(),
        body: state.body.clone(),
        step: state.step,
    }
}
