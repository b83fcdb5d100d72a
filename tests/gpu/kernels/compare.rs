//! Runs the parts of two steps on both backends from the same state, and compares everything they leave behind.

mod bad_step;
mod conservation;
mod elements;
mod ledger;
mod nodes;
mod plies;
mod projectile;
mod reach;
mod rim;

use super::scales::Scales;
use nalgebra::Vector3;
use ripstop::gpu::Device;
use ripstop::gpu::buffers::BufferId;
use ripstop::gpu::shader::Kernel;
use ripstop::gpu::stepper::{DeviceStepper, Stage};
use ripstop::kernels::element_force::field as element;
use ripstop::model::Model;
use ripstop::num::simd::Vectors;
use ripstop::solver::active_region::ActiveRegion;
use ripstop::solver::energy_balance::EnergyBalance;
use ripstop::solver::state::State;
use ripstop::solver::{self, Context, FailureEvent, StepTotals};

use super::scenes::Scene;
use super::seen::Seen;
use crate::gpu::harness::Outcome;
pub(crate) use bad_step::bad_step;
pub(crate) use conservation::{cancels, keeps_momentum};
pub(crate) use rim::{crowded, restless};

/// What is compared: what one kernel leaves behind, with the kernels that must run before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Elements,
    Nodes,
    Plies,
    Contact,
    Ledger,
}

impl Part {
    pub(crate) const ALL: [Self; 5] = [Self::Elements, Self::Nodes, Self::Plies, Self::Contact, Self::Ledger];

    /// Whether a scene has it.
    fn is_in(self, scene: &Scene) -> bool {
        match self {
            Self::Elements => scene.elements,
            Self::Plies => scene.pack,
            Self::Contact => scene.model.projectile.is_some(),
            // Without a projectile the device never lets what may have moved grow: then nothing does, or all of it.
            Self::Nodes | Self::Ledger => !is_partly_reached(scene),
        }
    }

    /// Whether it runs a kernel.
    fn needs(self, kernel: &Kernel) -> bool {
        let node = kernel.name == "node_update";
        match self {
            Self::Elements => kernel.name == "element_force",
            Self::Nodes => node,
            Self::Plies => node || is_ply_kernel(kernel),
            Self::Contact => node || kernel.name.starts_with("projectile_"),
            Self::Ledger => true,
        }
    }
}

/// Whether elements are evaluated, but not all of them.
fn is_partly_reached(scene: &Scene) -> bool {
    let part = |(ply, reach): (usize, &ActiveRegion)| *reach != ActiveRegion::whole(&scene.model.ply_type(ply).mesh);
    scene.elements && scene.state.active.iter().enumerate().any(part)
}

/// Whether a kernel belongs to contact between plies.
fn is_ply_kernel(kernel: &Kernel) -> bool {
    kernel.name.starts_with("ply_")
}

/// A kernel's source without what its entry point does: drivers take long to compile what will not run.
fn idle(kernel: &Kernel) -> String {
    let own = kernel.sources[0];
    let head = &own[..own.find("@compute").unwrap_or(own.len())];
    let rest = kernel.sources[1..].concat();
    format!("{head}@compute @workgroup_size(64) fn {}() {{}}\n{rest}", kernel.name)
}

/// Steps compared: the second shows whether sums go on and warm starts are used.
const STEPS: u64 = 2;

/// A scene on both backends.
struct Pair<'a> {
    scene: &'a Scene,
    gpu: DeviceStepper<'a>,
    cpu: solver::Stepper<f32>,
    ledger: EnergyBalance,
    totals: StepTotals,
    /// The processor's state.
    expected: State<f32>,
    /// What the device must take to have moved.
    reach: Vec<ActiveRegion>,
    failures: Vec<FailureEvent>,
    evaluations: f64,
    /// Deepest node inside the projectile, inside a neighbouring ply [m].
    penetration: [f64; 2],
    /// What differences are measured by, and what where held nodes do not count.
    scales: Scales,
    free: Scales,
    /// What displacements of plies are measured by [m].
    ply_length: f64,
}

/// Velocity that closes a gap in a scene, at most, over the speed of the scene: where displacements are large and steps short, a gap rounds
/// to more than contact makes of it.
const CLOSING: f64 = 73.0;
/// The same of plies.
const PLY_CLOSING: f64 = 20.0;
/// The same of a displacement by contact in a step, and where held nodes count.
const CONTACT_DISPLACEMENT: [f64; 2] = [48.0, 250.0];
/// The same of the energy of an impulse, and of the way of the projectile in a step.
const CONTACT_ENERGY: f64 = 12.8;
const WAY: f64 = 12.0;
/// Displacement in a scene, at most, over the length of the shortest element; of plies over the way at the largest speed in a step.
const DISPLACEMENT: f64 = 2.75;
const PLY_DISPLACEMENT: f64 = 104.0;

/// The sizes of a scene of that speed and with inner nodes of that mass: small ones, so that differences are held tighter than in a whole run.
fn bounded(scales: Scales, inner_mass: f64, speed: f64) -> Scales {
    let node_mass = scales.node_mass.min(inner_mass);
    let closing = scales.closing.min(CLOSING * speed);
    Scales {
        node_mass,
        speed,
        closing,
        length: scales.length.min(DISPLACEMENT * scales.shortest),
        cell: scales.shortest.min(WAY * speed * scales.time_step),
        spin: node_mass * closing * scales.reach,
        contact_energy: 0.5 * node_mass * speed * scales.closing.min(CONTACT_ENERGY * speed),
        ..scales
    }
}

impl<'a> Pair<'a> {
    /// Way of a node that meets the projectile in a step, at most [m].
    fn contact_way(&self) -> f64 {
        let most = CONTACT_DISPLACEMENT[usize::from(self.scene.held)];
        self.scales.closing.min(most * self.scales.speed) * self.scales.time_step
    }

    /// Velocity that closes a gap between plies, at most [m/s].
    fn ply_closing(&self) -> f64 {
        self.scales.closing.min(PLY_CLOSING * self.scales.speed)
    }

    /// Momentum of a node at the largest speed [N·s].
    fn node_momentum(&self) -> f64 {
        self.free.node_mass * self.free.speed
    }

    fn new(device: &'a Device, scene: &'a Scene, source: &dyn Fn(&Kernel) -> String) -> Result<Self, String> {
        let gpu = DeviceStepper::with_sources(device, &scene.model, source).map_err(|e| e.to_string())?;
        let whole = Scales::of(&scene.model, &scene.state, scene.speed);
        let inner = f64::from(scene.model.ply_types[0].row_mass(1).mass[1]);
        let free = bounded(whole, inner, scene.speed);
        Ok(Self {
            scene,
            gpu,
            scales: if scene.held { free.held() } else { free },
            free,
            ply_length: whole.length.min(PLY_DISPLACEMENT * scene.speed * whole.time_step),
            cpu: solver::Stepper::with_vectors(&scene.model, Vectors::None),
            ledger: EnergyBalance::default(),
            totals: StepTotals::default(),
            expected: scene.state.clone(),
            reach: scene.state.active.clone(),
            failures: Vec::new(),
            evaluations: 0.0,
            penetration: [0.0; 2],
        })
    }

    /// Both backends begin again from the scene's state.
    fn begin(&mut self) {
        let model = &self.scene.model;
        self.gpu.upload(model, &self.scene.state);
        self.cpu = solver::Stepper::with_vectors(model, Vectors::None);
        self.ledger = EnergyBalance::default();
        self.expected = self.scene.state.clone();
        self.reach = self.scene.state.active.clone();
        self.failures.clear();
        (self.evaluations, self.penetration) = (0.0, [0.0; 2]);
    }

    /// One step of some stages on both.
    fn advance(&mut self, stages: &[Stage], slot: Option<u32>) -> Result<(), String> {
        let model = &self.scene.model;
        let info = self.gpu.whole_step(self.expected.step, slot, STEPS as u32);
        self.gpu.run_stages(&info, stages).map_err(|e| e.to_string())?;
        let mut context = Context::new(model, &mut self.expected, &mut self.ledger, slot.is_some());
        for stage in stages {
            let before = context.state.clone();
            match stage {
                Stage::Elements => {
                    self.cpu.elements(&mut context);
                    self.failures.extend(self.cpu.failures.iter().copied());
                    self.evaluations += context.totals.iterations;
                }
                Stage::Nodes => self.cpu.nodes(&mut context),
                Stage::Plies => self.cpu.plies(&mut context),
                Stage::Projectile => self.cpu.projectile(&mut context),
                Stage::Ledger => {}
            }
            reach::follow(&mut self.reach, model, *stage, &before, context.state);
        }
        self.totals = std::mem::take(&mut context.totals);
        self.penetration[0] = self.penetration[0].max(self.totals.penetration);
        self.penetration[1] = self.penetration[1].max(self.totals.ply_penetration);
        self.expected.step += 1;
        Ok(())
    }

    fn read(&self, name: BufferId) -> Result<Vec<u32>, String> {
        self.gpu.read(name).map_err(|e| e.to_string())
    }

    fn read_floats(&self, name: BufferId) -> Result<Vec<f64>, String> {
        Ok(self.read(name)?.into_iter().map(|word| f64::from(f32::from_bits(word))).collect())
    }

    fn download(&self) -> Result<State<f32>, String> {
        let mut got = self.scene.state.clone();
        self.gpu.download(&self.scene.model, &mut got).map_err(|e| e.to_string())?;
        self.download_strains(&mut got)?;
        Ok(got)
    }

    /// Strains of the last step, which a run never needs.
    fn download_strains(&self, got: &mut State<f32>) -> Outcome {
        let yarns = self.read_floats(BufferId::Yarns)?;
        let columns = self.scene.model.grid.columns;
        let elements = self.gpu.sizes().elements as usize;
        let first = got.elements.fields - element::STRAIN;
        let slot = 2 + 2 * ((self.expected.step as usize + 1) % 2);
        for (at, yarn) in (0..elements).flat_map(|at| [(at, 0), (at, 1)]) {
            let strain = yarns[(slot + yarn) * elements + at] as f32;
            got.elements.set(at / columns, first + yarn, at % columns + 1, strain);
        }
        Ok(())
    }
}

/// Ply, row in it and column of every node.
fn places(model: &Model<f32>) -> impl Iterator<Item = [usize; 3]> + '_ {
    (0..model.grid.plies).flat_map(|ply| {
        let mesh = &model.ply_type(ply).mesh;
        (0..=mesh.rows).flat_map(move |row| (0..=mesh.columns).map(move |column| [ply, row, column]))
    })
}

/// Mass of a node [kg] and its velocity in the axes of the pack [m/s].
fn motion(model: &Model<f32>, state: &State<f32>, [ply, row, column]: [usize; 3]) -> (f64, Vector3<f64>) {
    let ply_type = model.ply_type(ply);
    let velocity = state.velocity(model.grid.first_node_row(ply) + row, column);
    (f64::from(ply_type.row_mass(row).mass[column]), Vector3::from(ply_type.mesh.to_pack(velocity)))
}

/// Largest differences of a scene in some parts.
pub(crate) fn differences(
    device: &Device,
    scene: &Scene,
    parts: &[Part],
    source: &dyn Fn(&Kernel) -> String,
) -> Result<Seen, String> {
    let parts: Vec<Part> = parts.iter().copied().filter(|part| part.is_in(scene)).collect();
    let runs = |kernel: &Kernel| {
        let idle = (kernel.name == "element_force" && !scene.elements) || (is_ply_kernel(kernel) && !scene.pack);
        !idle && parts.iter().any(|part| part.needs(kernel))
    };
    let sources = |kernel: &Kernel| if runs(kernel) { source(kernel) } else { idle(kernel) };
    let mut pair = Pair::new(device, scene, &sources)?;
    let mut seen = Seen::on(device);
    for part in parts {
        let compare: fn(&mut Pair<'_>, &mut Seen) -> Outcome = match part {
            Part::Elements => elements::compare,
            Part::Nodes => nodes::compare,
            Part::Plies => plies::compare,
            Part::Contact => projectile::compare,
            Part::Ledger => ledger::compare,
        };
        compare(&mut pair, &mut seen)?;
    }
    Ok(seen)
}
