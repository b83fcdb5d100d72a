//! Two steps of a scene on both backends from the same state, and everything that the parts of a step leave behind.

mod results;

use nalgebra::Vector3;
use ripstop::gpu::Device;
use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::layout::{self, CONTACT_WORDS, MARKS, StepInfo, status};
use ripstop::gpu::shader::Kernel;
use ripstop::gpu::stepper::{DeviceStepper, Stage};
use ripstop::model::Model;
use ripstop::model::layup;
use ripstop::model::layup::{PENETRATING, SIDES, neighbour};
use ripstop::num::simd::Vectors;
use ripstop::solver;
use ripstop::solver::energy_balance::EnergyBalance;
use ripstop::solver::node_update::field as node;
use ripstop::solver::state::ActiveRegion;
use ripstop::solver::state::State;
use ripstop::solver::{Context, FailureEvent, StepTotals};

use super::scenes::Scene;
use super::{Scales, Seen};
use crate::gpu::harness::Outcome;

/// Steps compared: the second shows whether sums go on and warm starts are used.
const STEPS: u64 = 2;
/// Name of contact with the projectile in the table.
const CONTACT: &str = "projectile_contact";

/// Output of one kernel, with the kernels that must run before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Sweep,
    Plies,
    Contact,
    EnergyBalance,
}

impl Part {
    pub(crate) const ALL: [Self; 4] = [Self::Sweep, Self::Plies, Self::Contact, Self::EnergyBalance];

    /// Whether a scene has it.
    fn is_in(self, scene: &Scene) -> bool {
        match self {
            Self::Sweep => scene.elements,
            Self::Plies => scene.pack,
            Self::Contact => scene.model.projectile.is_some(),
            Self::EnergyBalance => !scene.elements || is_whole(scene),
        }
    }

    /// Stages of a step.
    fn stages(self, scene: &Scene) -> Vec<Stage> {
        // In a pack both contacts would share the processor's sums of losses; whole shots hold their sum.
        let body = scene.model.projectile.is_some() && !scene.pack;
        let all = [
            (Stage::Sweep, true),
            (Stage::Plies, self == Self::Plies || self == Self::EnergyBalance && scene.pack),
            (Stage::Projectile, self == Self::Contact || self == Self::EnergyBalance && body),
            (Stage::EnergyBalance, self == Self::EnergyBalance),
        ];
        all.into_iter().filter_map(|(stage, has)| has.then_some(stage)).collect()
    }

    /// Whether it runs a kernel.
    fn needs(self, kernel: &Kernel, scene: &Scene) -> bool {
        self.stages(scene).contains(&kernel.stage)
    }
}

/// Whether everything may move: without a projectile the device never lets what may have moved grow.
fn is_whole(scene: &Scene) -> bool {
    let whole = |ply: usize| ActiveRegion::whole(&scene.model.ply_type(ply).mesh);
    scene.state.active.iter().enumerate().all(|(ply, reach)| *reach == whole(ply))
}

/// A kernel's source without the body of its entry point: drivers take long to compile what will not run.
fn idle(kernel: &Kernel) -> String {
    let own = kernel.sources[0];
    let head = &own[..own.find("@compute").unwrap_or(own.len())];
    let rest = kernel.sources[1..].concat();
    format!("{head}@compute @workgroup_size(64) fn {}() {{}}\n{rest}", kernel.name)
}

/// Mass of a node [kg] and its velocity in the axes of the pack [m/s].
fn motion(model: &Model<f32>, state: &State<f32>, [ply, row, column]: [usize; 3]) -> (f64, Vector3<f64>) {
    let ply_type = model.ply_type(ply);
    let velocity = state.velocity(model.grid.first_node_row(ply) + row, column);
    (f64::from(ply_type.row_mass(row).mass[column]), Vector3::from(ply_type.mesh.to_pack(velocity)))
}

fn bits(model: &Model<f32>, state: &State<f32>, [ply, row, column]: [usize; 3]) -> [u32; node::COUNT] {
    let row = model.grid.first_node_row(ply) + row;
    std::array::from_fn(|field| state.nodes.get(row, field, column).to_bits())
}

/// A scene on both backends.
struct Pair<'a> {
    scene: &'a Scene,
    gpu: DeviceStepper<'a>,
    cpu: solver::Stepper<f32>,
    balance: EnergyBalance,
    /// Sums of the last step, and over the steps: evaluations, cells without a solution, elements computed.
    totals: StepTotals,
    counts: [f64; 3],
    /// State of the processor.
    expected: State<f32>,
    /// Nodes that the device must take to have moved.
    reach: Vec<ActiveRegion>,
    failures: Vec<FailureEvent>,
    /// Deepest node inside the projectile, inside a neighbouring ply [m].
    penetration: [f64; 2],
    scales: Scales,
    seen: Seen,
}

impl<'a> Pair<'a> {
    fn new(device: &'a Device, scene: &'a Scene, source: &dyn Fn(&Kernel) -> String) -> Result<Self, String> {
        Ok(Self {
            scene,
            gpu: DeviceStepper::with_sources(device, &scene.model, 1, source).map_err(|e| e.to_string())?,
            cpu: solver::Stepper::with_vectors(&scene.model, Vectors::None),
            balance: EnergyBalance::default(),
            totals: StepTotals::default(),
            counts: [0.0; 3],
            expected: scene.state.clone(),
            reach: scene.state.active.clone(),
            failures: Vec::new(),
            penetration: [0.0; 2],
            scales: Scales::of(scene),
            seen: Seen { worst: Default::default(), hardware: device.is_hardware() },
        })
    }

    /// Both backends begin again from the scene's state.
    fn begin(&mut self) {
        let model = &self.scene.model;
        self.gpu.upload(model, &self.scene.state);
        self.cpu = solver::Stepper::with_vectors(model, Vectors::None);
        (self.balance, self.failures) = (EnergyBalance::default(), Vec::new());
        (self.expected, self.reach) = (self.scene.state.clone(), self.scene.state.active.clone());
        (self.counts, self.penetration) = ([0.0; 3], [0.0; 2]);
    }

    /// One step of some stages on both.
    fn advance(&mut self, stages: &[Stage], slot: Option<u32>) -> Outcome {
        let model = &self.scene.model;
        let info = self.gpu.whole_step(self.expected.step, slot, STEPS as u32);
        self.gpu.run_stages(&info, stages).map_err(|e| e.to_string())?;
        let computed = |(ply, reach): (usize, &ActiveRegion)| {
            let [rows, columns] = reach.elements(&model.ply_type(ply).mesh);
            rows.len() * columns.len()
        };
        let first = self.expected.step == 0;
        let reached = if first { model.elements() } else { self.reach.iter().enumerate().map(computed).sum() };
        let mut context = Context::new(model, &mut self.expected, &mut self.balance, slot.is_some());
        for stage in stages {
            let before = context.state.clone();
            match stage {
                Stage::Sweep => {
                    self.cpu.sweep(&mut context);
                    self.failures.extend(self.cpu.failures.iter().copied());
                }
                Stage::Plies => self.cpu.plies(&mut context),
                Stage::Projectile => self.cpu.projectile(&mut context),
                Stage::EnergyBalance => {}
            }
            // The device lets its rectangles grow by a ring at the end of a step, in the projectile's kernel; the processor does
            // so where the nodes move. Contact takes in whatever it changed.
            if *stage == Stage::Projectile && model.projectile.is_some() {
                for (ply, reach) in self.reach.iter_mut().enumerate() {
                    *reach = reach.grown(1, &model.ply_type(ply).mesh);
                }
            }
            for place in model.node_places().filter(|_| matches!(stage, Stage::Plies | Stage::Projectile)) {
                if bits(model, &before, place) != bits(model, context.state, place) {
                    self.reach[place[0]].activate(place[1], place[2]);
                }
            }
        }
        self.totals = std::mem::take(&mut context.totals);
        for (sum, of_step) in
            self.counts.iter_mut().zip([self.totals.iterations, self.totals.unconverged as f64, reached as f64])
        {
            *sum += of_step;
        }
        self.penetration[0] = self.penetration[0].max(self.totals.penetration);
        self.penetration[1] = self.penetration[1].max(self.totals.ply_penetration);
        self.expected.step += 1;
        Ok(())
    }

    fn read(&self, name: BufferId) -> Result<Vec<u32>, String> {
        pollster::block_on(self.gpu.read(name)).map_err(|e| e.to_string())
    }

    /// Sum over nodes of the impulses that held nodes take, by direction [kg·m/s].
    fn supports(&self) -> Result<[f64; 3], String> {
        let words = self.read(BufferId::Supports)?;
        let field = |a: usize| words.iter().skip(a * words.len() / 3).take(words.len() / 3);
        Ok([0, 1, 2].map(|a| field(a).map(|word| f64::from(f32::from_bits(*word))).sum()))
    }

    fn download(&self) -> Result<State<f32>, String> {
        let mut got = State { step: self.expected.step, ..self.scene.state.clone() };
        pollster::block_on(self.gpu.download(0, &self.scene.model, &mut got)).map_err(|e| e.to_string())?;
        Ok(got)
    }

    /// Takes in a pair of numbers of a kernel.
    fn see(&mut self, kernel: &str, quantity: &str, numbers: [f64; 3], place: impl FnOnce() -> String) {
        self.seen.see(kernel, quantity, numbers, place);
    }

    /// Takes in a count that must be the same.
    fn count(&mut self, quantity: &str, got: impl Into<f64>, expected: f64, place: &str) {
        self.see("step", quantity, [got.into(), expected, 1.0], || place.to_owned());
    }

    /// Displacement and velocity of every node after a kernel, by their scales.
    fn compare_nodes(&mut self, got: &State<f32>, kernel: &str, scales: [f64; 2]) {
        let (model, expected) = (&self.scene.model, &self.expected);
        for [ply, in_ply, column] in model.node_places() {
            let row = model.grid.first_node_row(ply) + in_ply;
            for field in 0..node::COUNT {
                let number = |state: &State<f32>| f64::from(state.nodes.get(row, field, column));
                let place = || format!("step {}, {:?}, field {field}", expected.step - 1, [ply, in_ply, column]);
                let quantity = ["displacement", "velocity"][field / 3];
                self.seen.see(kernel, quantity, [number(got), number(expected), scales[field / 3]], place);
            }
        }
    }

    /// The device's rectangles, the cells that nodes are over, and everything that nothing has reached, which must keep every bit.
    fn compare_reach(&mut self, got: &State<f32>, kernel: &str) {
        let model = &self.scene.model;
        for (ply, (got, expected)) in got.active.iter().zip(&self.reach).enumerate() {
            let differs = f64::from(u8::from(got != expected));
            self.seen.see(kernel, "reach", [differs, 0.0, 1.0], || format!("ply {ply}, {got:?} for {expected:?}"));
        }
        // Cells share their edge: over a ridge rounding says which of them a node is over, which moves no impulse.
        let mut beside = 0;
        for (at, (got, expected)) in got.over.iter().zip(&self.expected.over).enumerate() {
            let (ply, side) = (at / model.nodes_per_ply() / SIDES, at / model.nodes_per_ply() % SIDES);
            let Some(other) = neighbour(ply, side, model.plies.len()) else { continue };
            let columns = model.ply_type(other).mesh.columns;
            let cell = |over: u32| [layup::element(over) / columns, layup::element(over) % columns];
            let near = [0, 1].into_iter().all(|i| cell(*got)[i].abs_diff(cell(*expected)[i]) <= 1);
            if near && got & PENETRATING == expected & PENETRATING {
                beside += usize::from(got != expected);
            } else {
                let numbers = [(*got).into(), (*expected).into(), 1.0];
                self.seen.see("ply_contact", "cells", numbers, || format!("place {at}"));
            }
        }
        let many = f64::from(u8::from(beside * 50 > got.over.len()));
        self.seen.see("ply_contact", "cells", [many, 0.0, 1.0], || format!("{beside} cells beside"));
    }

    fn plies(&mut self) -> Outcome {
        if self.totals.ply_contacts == 0 {
            return Err("no ply touches another: the scene shows nothing".into());
        }
        let contacts = self.read(BufferId::Contacts)?;
        let found =
            contacts.chunks_exact(CONTACT_WORDS as usize).filter(|words| f32::from_bits(words[7]) != 0.0).count();
        let numbers = [found as f64, self.totals.ply_contacts as f64, 1.0];
        self.see("ply_contact", "contacts", numbers, String::new);
        for name in [BufferId::Shares, BufferId::Impulses] {
            let left = self.read(name)?.iter().filter(|word| **word != 0).count();
            self.count("cleared", left as f64, 0.0, "impulses of plies");
        }
        let depth = f32::from_bits(self.read(BufferId::Status)?[status::PLY_DEPTH]);
        let numbers = [depth.into(), self.penetration[1], self.scales.length[0]];
        self.see("ply_contact", "penetration", numbers, String::new);
        Ok(())
    }

    /// The projectile and its contact.
    fn contact(&mut self) -> Outcome {
        self.count("counters", self.read(BufferId::Status)?[status::COMPUTED], self.counts[2], "elements computed");
        let words = self.read(BufferId::Candidates)?;
        let marks: u32 = words[..words.len() / MARKS as usize].iter().map(|word| word.count_ones()).sum();
        self.count("cleared", marks, 0.0, "candidates");
        let start = self.scene.model.projectile.as_ref().ok_or("no projectile")?;
        let got = layout::read_body(&self.read(BufferId::Body)?, start, &layout::device_origin(&self.scene.model));
        let expected = self.expected.body.clone().ok_or("no projectile")?;
        let supports = self.supports()?;
        let (balance, [speed, way]) = (self.balance.clone(), self.scales.body);
        let (impulse, energy) = (self.scales.impulse, self.scales.contact_energy);
        let turning = self.scales.angular_momentum + expected.angular_momentum.norm();
        for a in 0..3 {
            let (given, held) = (-balance.contact_impulse[a], balance.support[a]);
            for (quantity, numbers) in [
                ("body velocity", [got.body.velocity[a], expected.velocity[a], speed]),
                ("body position", [got.body.position[a], expected.position[a], way]),
                ("angular momentum", [got.body.angular_momentum[a], expected.angular_momentum[a], turning]),
                ("impulse", [got.impulse[a], given, impulse + given.abs()]),
                ("impulse", [supports[a] + got.support[a], held, impulse + held.abs()]),
            ] {
                self.see(CONTACT, quantity, numbers, || format!("direction {a}"));
            }
        }
        for (got, expected) in got.energy.into_iter().zip([balance.contact, balance.friction, balance.external]) {
            self.see(CONTACT, "energy", [got, expected, energy + expected.abs()], String::new);
        }
        let depth = [got.penetration, self.penetration[0], self.scales.length[0]];
        self.see(CONTACT, "penetration", depth, String::new);
        let turn = (got.body.orientation.coords - expected.orientation.coords).norm();
        self.see(CONTACT, "body orientation", [turn, 0.0, 1.0], String::new);
        Ok(())
    }

    /// Two steps of a part.
    fn compare(&mut self, part: Part) -> Outcome {
        self.begin();
        let stages = part.stages(self.scene);
        let steps = if part == Part::Sweep && !is_whole(self.scene) { 1 } else { STEPS };
        for step in 0..steps {
            let slot = match part {
                Part::Sweep | Part::EnergyBalance => (step > 0).then_some(1),
                Part::Plies | Part::Contact => None,
            };
            self.advance(&stages, slot)?;
            let got = self.download()?;
            let Scales { length, speed, closing, way, force, .. } = self.scales;
            match part {
                Part::Sweep => {
                    let words = self.read(BufferId::Status)?;
                    let residual = f32::from_bits(words[status::RESIDUAL]).into();
                    if step == 0 {
                        self.see("sweep", "residual", [residual, self.totals.max_residual, force], String::new);
                        self.count("counters", words[status::ERODED], self.totals.eroded as f64, "eroded");
                        let holes = self.expected.holes(&self.scene.model);
                        self.count("counters", words[status::HOLES] + words[status::ERODED], holes as f64, "holes");
                    }
                    self.compare_elements(&got);
                    self.compare_nodes(&got, "sweep", [length[0], speed + self.scales.kick]);
                }
                Part::Plies => {
                    self.compare_nodes(&got, "ply_contact", [length[1], closing[1]]);
                    self.compare_reach(&got, "ply_contact");
                    self.plies()?;
                }
                Part::Contact => {
                    self.compare_nodes(&got, CONTACT, [way, closing[0]]);
                    self.compare_reach(&got, CONTACT);
                }
                Part::EnergyBalance => {}
            }
        }
        match part {
            Part::Sweep => self.elements(),
            Part::Plies => Ok(()),
            Part::Contact => self.contact(),
            Part::EnergyBalance => self.energy_balance(),
        }
    }
}

/// Largest differences of a scene in some parts.
pub(crate) fn differences(
    device: &Device,
    scene: &Scene,
    parts: &[Part],
    source: &dyn Fn(&Kernel) -> String,
) -> Result<Seen, String> {
    let parts: Vec<Part> = parts.iter().copied().filter(|part| part.is_in(scene)).collect();
    let sources = |kernel: &Kernel| {
        if parts.iter().any(|part| part.needs(kernel, scene)) { source(kernel) } else { idle(kernel) }
    };
    let mut pair = Pair::new(device, scene, &sources)?;
    parts.iter().try_for_each(|part| pair.compare(*part))?;
    Ok(pair.seen)
}

/// A number that is not finite stops everything after its step, on the spot.
pub(crate) fn bad_step(device: &Device) -> Outcome {
    let scenes = super::struck::scenes();
    for name in ["sphere on turned plies, friction", "between nodes on turned plies, friction"] {
        let scene = scenes.iter().find(|scene| scene.name == name).ok_or("no such scene")?;
        let mut pair = Pair::new(device, scene, &Kernel::source)?;
        let mut spoilt = scene.state.clone();
        spoilt.nodes.set(3, node::VELOCITY + 1, 2, f32::NAN);
        pair.gpu.upload(&scene.model, &spoilt);
        let index = scene.state.step;
        let all = [Stage::Sweep, Stage::Plies, Stage::Projectile];
        let advance = |index| {
            let info = StepInfo { index, ..pair.gpu.whole_step(0, None, 1) };
            pair.gpu.run_stages(&info, &all).map_err(|e| e.to_string())
        };
        let everything = || BufferId::ALL.map(|name| pair.read(name));
        advance(index)?;
        if u64::from(pair.read(BufferId::Status)?[status::BAD_STEP]) != index {
            return Err("a velocity that is no number goes unnoticed".into());
        }
        let before = everything();
        advance(index + 1)?;
        if everything() != before {
            return Err("the steps after a bad one change something".into());
        }
    }
    Ok(())
}
