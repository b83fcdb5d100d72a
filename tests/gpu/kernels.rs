//! Every kernel against its twin on the processor, both in single precision and from the same state.
//!
//! Red when: a shader and its twin disagree by more than rounding explains. That it can is proved by the
//! [mutants](super::mutants).

pub(crate) mod compare;
mod packs;
pub(crate) mod scenes;
mod struck;

use std::collections::BTreeMap;

use libtest_mimic::Trial;
use nalgebra::Vector3;
use ripstop::gpu::Device;
use ripstop::gpu::shader::Kernel;
use ripstop::model::ply_type::PlyType;
use ripstop::solver::contact::projectile_contact::HELD;
use ripstop::solver::state::State;

use super::harness::{Outcome, trial};
use crate::support::Worst;
use compare::Part;
use scenes::Scene;

/// Largest differences seen, by line of the table.
pub(crate) struct Seen {
    worst: BTreeMap<usize, Worst>,
    /// Whether they are of a card.
    hardware: bool,
}

impl Seen {
    /// Takes in a pair of numbers of a kernel and a quantity. `scale`: size of which an error is a fraction.
    fn see(&mut self, kernel: &str, quantity: &str, [got, expected, scale]: [f64; 3], place: impl FnOnce() -> String) {
        let line = TOLERANCES.iter().position(|line| line.kernel == kernel && line.quantity == quantity);
        let line = line.unwrap_or_else(|| panic!("{quantity} of {kernel} is in no table"));
        let error = if got == expected { 0.0 } else { (got - expected) / scale };
        self.worst.entry(line).or_default().see(error, || format!("{}: {got:e} for {expected:e}", place()));
    }

    fn verdict(&self) -> Outcome {
        let over = self.worst.iter().filter(|(line, worst)| worst.error > TOLERANCES[**line].limit(self.hardware));
        let lines: Vec<String> = over
            .map(|(line, Worst { error, place })| {
                let line = &TOLERANCES[*line];
                let limit = line.limit(self.hardware);
                format!("{}, {}: {error:.2e} > {limit:.1e} at {place}", line.kernel, line.quantity)
            })
            .collect();
        if lines.is_empty() { Ok(()) } else { Err(lines.join("\n")) }
    }
}

/// One scene, some parts of a step.
pub(crate) fn check(device: &Device, scene: &Scene, parts: &[Part], source: &dyn Fn(&Kernel) -> String) -> Outcome {
    compare::differences(device, scene, parts, source)?.verdict().map_err(|e| format!("{}: {e}", scene.name))
}

/// Every scene, by the kernels it is for.
fn groups() -> [(&'static str, Vec<Scene>); 3] {
    [("elements", scenes::element_scenes()), ("contact", struck::scenes()), ("plies", packs::scenes())]
}

/// Every scene.
pub(crate) fn all_scenes() -> Vec<Scene> {
    groups().into_iter().flat_map(|(_, scenes)| scenes).collect()
}

/// The tests.
pub(crate) fn tests() -> Vec<Trial> {
    let word = |scene: &Scene| scene.name.replace(", ", "_").replace(' ', "_");
    let mut out = Vec::new();
    for (kind, scene) in groups().into_iter().flat_map(|(kind, scenes)| scenes.into_iter().map(move |s| (kind, s))) {
        let name = format!("kernels::{kind}::{}", word(&scene));
        out.push(trial(name, move |device| check(device, &scene, &Part::ALL, &Kernel::source)));
    }
    out.push(trial("kernels::nothing_happens_after_a_bad_step", compare::bad_step));
    out
}

/// Largest relative error of a rounding to single precision [-].
pub(crate) const ROUNDING: f64 = 0.5 * f32::EPSILON as f64;
/// Roundings of a card for each of a device that rounds to the nearest: a division may be off by five of them, a root by four, and a
/// product and a sum may be one rounding or two (WGSL, accuracy of expressions).
const CARD: f64 = 5.0;
/// Growth of a rounding in a strain, the small difference of a stretch and one, over the strain that breaks a yarn.
const STRAIN: f64 = 1.0 / 0.035;

/// Allowed difference of a quantity of a kernel.
pub(crate) struct Tolerance {
    pub(crate) kernel: &'static str,
    pub(crate) quantity: &'static str,
    /// Roundings that add up, each with its growth; 0: no difference.
    roundings: f64,
    /// Factor on a card.
    card: f64,
}

impl Tolerance {
    /// Allowed difference over the scale [-]. `hardware`: the device is a card.
    pub(crate) fn limit(&self, hardware: bool) -> f64 {
        self.roundings * ROUNDING * if hardware { self.card } else { 1.0 }
    }
}

const fn allow(kernel: &'static str, quantity: &'static str, roundings: f64) -> Tolerance {
    Tolerance { kernel, quantity, roundings, card: CARD }
}

/// A tolerance with more on a card than its operations explain: measured, for a solver that ends elsewhere.
const fn measured(kernel: &'static str, quantity: &'static str, roundings: f64, card: f64) -> Tolerance {
    Tolerance { kernel, quantity, roundings, card }
}

/// The table, in the order of a step.
pub(crate) const TOLERANCES: [Tolerance; 44] = [
    allow("sweep", "yarn alive", 0.0),
    allow("sweep", "failures", 0.0),
    allow("sweep", "viscous force", 8.0), // a sum of four velocities, by a length
    measured("sweep", "rate of strain", 100.0, 40.0), // three powers, 67 here; not seen on a card
    // The misfit of compatibility at which the unit cell's solver ends, 4 roundings on either backend, twice as much in a height.
    // A start that the device rounds to 24 bits of the sum ends elsewhere where a contact force next to nothing settles it.
    measured("sweep", "yarn height", 3200.0, 1.0),
    allow("sweep", "strain", 0.5 * STRAIN), // half of the roundings of a stretch: the other is common
    allow("sweep", "failure strain", 0.5 * STRAIN),
    allow("sweep", "residual", 11.0),
    measured("sweep", "evaluations", 8.4e4, 40.0), // in one of 200 a rounding costs or spares a step of Newton's
    allow("sweep", "displacement", 3.0),           // velocity by step, added: 2 roundings, and those of the velocity
    // Forces of four elements, by step and mass, added. A stretch is the root of squares over the length at rest: one rounding of the
    // root, one of the quotient.
    allow("sweep", "velocity", 8.0 + 2.0 * STRAIN),
    allow("sweep", "support", 16.0), // a sum of forces in another order, over two steps
    allow("ply_contact", "contacts", 0.0),
    allow("ply_contact", "cells", 0.0), // or where cells share an edge one beside them
    allow("ply_contact", "reach", 0.0),
    // A gap: positions of a node and four corners, over and along a normal, closed in counts.
    allow("ply_contact", "displacement", 16.0),
    allow("ply_contact", "velocity", 12.0),
    allow("ply_contact", "penetration", 4.0),
    allow("ply_contact", "energy", 6.0 * 19.0), // squares of velocities as above, of all nodes: of energies that are larger
    allow("ply_contact", "support", 6.0 * 11.0), // differences of velocities as above, of held nodes
    allow("projectile_contact", "reach", 0.0),
    // A gap: positions of node and body, 2 roundings each, over and along the normal, 4 each with a division; closed.
    allow("projectile_contact", "displacement", 24.0),
    allow("projectile_contact", "velocity", 12.0),
    allow("projectile_contact", "body velocity", 13.0), // a sum of impulses of either sign, rounded once
    allow("projectile_contact", "body position", 13.0), // counted in 6e-11 m; and the velocity's
    allow("projectile_contact", "body orientation", 3.0), // a product of quaternions, made one long
    allow("projectile_contact", "angular momentum", 6.0),
    allow("projectile_contact", "impulse", 18.0),
    allow("projectile_contact", "energy", 2.0 * 21.0),
    allow("projectile_contact", "penetration", 16.0),
    allow("step", "counters", 0.0),
    allow("step", "cleared", 0.0), // marks and sums that begin anew
    allow("energy_balance", "covered", 0.0),
    allow("energy_balance", "work", 12.0), // forces by displacements: 8 roundings, and 4 of the sum
    allow("energy_balance", "released energy", 8.0), // squares of strains
    measured("energy_balance", "stored energy", 12.0, 10.0), // squares of strains, and 4 of the sum; on a card with heights as above
    allow("energy_balance", "law energy", 12.0),
    allow("energy_balance", "tension", 8.0),
    allow("energy_balance", "load", 8.0),
    allow("energy_balance", "deflection", 3.0),
    allow("energy_balance", "support", 25.0), // impulses of two steps, and 9 of the sum
    allow("energy_balance", "kinetic energy", 16.0), // squares of velocities, and 4 of the sum
    allow("energy_balance", "largest square of speed", 16.0 * 2.7), // of a velocity that may be the difference of larger ones
    allow("energy_balance", "momentum", 16.0 * 10.0), // velocities, that contact may have rounded ten times as much
];

/// Sizes of a scene whose roundings a difference is counted in.
pub(crate) struct Scales {
    /// Force of an element whose stronger yarn is about to break [N].
    pub(crate) force: f64,
    /// Tension of that yarn, as shock viscosity is stored per weight of the element [N].
    pub(crate) viscous_force: f64,
    /// Energy of an element whose yarns are about to break [J].
    pub(crate) energy: f64,
    /// Half a span of a yarn, or the sum of heights if that is more [m].
    pub(crate) height: f64,
    /// Smallest failure strain [-].
    pub(crate) failure_strain: f64,
    /// Largest displacement of a node, an element's length at least, and that of contact between plies [m].
    pub(crate) length: [f64; 2],
    /// Largest speed [m/s].
    pub(crate) speed: f64,
    /// Velocity that a node gets in a step from an element whose stronger yarn is about to break [m/s].
    pub(crate) kick: f64,
    /// Velocity that closes a gap of `length` in a step: by the projectile, and by plies [m/s].
    pub(crate) closing: [f64; 2],
    /// Way of a node that meets the projectile in a step [m].
    pub(crate) way: f64,
    /// Velocity [m/s] and way in a step [m] of the projectile by such an impulse.
    pub(crate) body: [f64; 2],
    /// Impulse of a node that closes a gap [kg·m/s], its angular momentum at the body's reach [kg·m²/s], and its energy [J].
    pub(crate) impulse: f64,
    pub(crate) angular_momentum: f64,
    pub(crate) contact_energy: f64,
    /// Momentum of a node at the largest speed [kg·m/s], and the energy of contact of a free one [J].
    pub(crate) node_momentum: f64,
    pub(crate) kinetic: f64,
}

impl Scales {
    /// Scales of a scene: small ones, so that differences are held tight. Displacements, gaps and energies count up to a multiple of
    /// an element's length and of the largest speed.
    pub(crate) fn of(scene: &Scene) -> Self {
        let (model, state, speed) = (&scene.model, &scene.state, scene.speed);
        let most = |of: &dyn Fn(&PlyType<f32>) -> f64| model.ply_types.iter().map(of).fold(0.0, f64::max);
        let strain = |of: &PlyType<f32>, yarn: usize| of.cell.yarn[yarn].failure_strain.min(0.05);
        let tension = |of: &PlyType<f32>, yarn: usize| of.cell.yarn[yarn].stiffness * strain(of, yarn);
        let energy =
            |of: &PlyType<f32>, yarn: usize| tension(of, yarn) * strain(of, yarn) * of.cell.yarn[yarn].half_span;
        let shortest = model.ply_types.iter().map(|of| of.mesh.shortest()).fold(f64::INFINITY, f64::min);
        let dt = model.dt;
        let far = farthest(scene, state).max(shortest);
        let gap = speed + far / dt;
        let mass = f64::from(model.ply_types[0].row_mass(1).mass[1]);
        let (body_mass, reach) = model.projectile.as_ref().map_or((0.0, 0.0), |b| (b.mass, b.body.bounding_radius));
        let free = [gap.min(73.0 * speed), 0.5 * mass * speed * gap.min(12.8 * speed)];
        // Held nodes count as many bodies. They bring a free one from its speed to rest: a third of that speed in the mean.
        let held = scene.held;
        let closing = if held { free[0].max(0.35 * HELD * speed) } else { free[0] };
        let node_mass = if held { mass.max(body_mass) } else { mass };
        let impulse = node_mass * closing;
        let body = impulse / body_mass.max(f64::MIN_POSITIVE);
        let force = most(&|of| (0..2).map(|i| tension(of, i) * of.element.membrane[i]).fold(0.0, f64::max));
        Self {
            force,
            kick: force * dt / mass,
            viscous_force: most(&|of| tension(of, 0).max(tension(of, 1))),
            energy: most(&|of| of.element.cells * (energy(of, 0) + energy(of, 1))),
            height: most(&|of| of.cell.height_sum.max(of.cell.yarn[0].half_span)),
            failure_strain: model.ply_types.iter().map(|of| strain(of, 0).min(strain(of, 1))).fold(1.0, f64::min),
            length: [far.min(2.75 * shortest), far.min(104.0 * speed * dt)],
            speed,
            closing: [closing, gap.min(20.0 * speed)],
            way: closing.min(if held { 250.0 } else { 48.0 } * speed) * dt,
            body: [speed + body, shortest.min(12.0 * speed * dt).max(dt * body)],
            impulse,
            angular_momentum: mass * free[0] * reach,
            contact_energy: if held { 0.5 * node_mass * closing * speed } else { free[1] },
            node_momentum: mass * speed,
            kinetic: free[1],
        }
    }
}

/// Largest displacement of a node [m].
fn farthest(scene: &Scene, state: &State<f32>) -> f64 {
    let first = |ply| scene.model.grid.first_node_row(ply);
    let displacement = |[ply, row, column]: [usize; 3]| Vector3::from(state.displacement(first(ply) + row, column));
    scene.model.node_places().map(|place| displacement(place).norm()).fold(0.0, f64::max)
}
