//! Attachment of torn fabric: the pieces that a ply is in, which of them are attached, and the largest deflection of those.
//!
//! A piece is attached where it reaches a held edge of its ply; of a ply without one, where it is at least half of the ply. Debris flies
//! ahead of the fabric that it came from, and its deflection must not count. The pieces follow from the whole state, which is too much for
//! every sample. Before anything is detached every sample counts; so the state is looked at from time to time, and pieces never grow
//! together again. From the first detached piece on, samples have the deflection of the last look; those since the look before it have at
//! most that of the look that finds the piece.

use serde::{Deserialize, Serialize};

use crate::case::{Case, Opening};
use crate::model::Model;
use crate::model::mesh::corners;
use crate::model::ply_type::PlyType;
use crate::num::scalar::Scalar;
use crate::physics::rigid_body::Cut;
use crate::solver::contact::edge_contact::root;
use crate::solver::energy_balance::PlyMoment;
use crate::solver::state::State;

/// Least share of a ply without a held edge that is still the ply, and no debris of it [-].
const SUBSTANTIAL: f64 = 0.5;
/// Looks between the start and the end time.
const LOOKS: f64 = 80.0;

/// Root node of the piece of every node of a ply, row by row. An unbroken yarn links the nodes before an element with those behind it, on
/// both sides of the element: across the yarn it resists nothing.
fn pieces<S: Scalar>(model: &Model<S>, state: &State<S>, ply: usize) -> Vec<usize> {
    let (mesh, first) = (&model.ply_type(ply).mesh, model.grid.first_element_row(ply));
    let stride = mesh.columns + 1;
    // A forest: each node points to another of its piece, the root to itself.
    let mut parent: Vec<usize> = (0..stride * (mesh.rows + 1)).collect();
    for (row, column) in (0..mesh.rows).flat_map(|row| (0..mesh.columns).map(move |column| (row, column))) {
        let [a, b, c, d] = corners([row, column]).map(|(row, column)| row * stride + column);
        for (yarn, links) in [[[a, b], [d, c]], [[a, d], [b, c]]].into_iter().enumerate() {
            for link in links.into_iter().filter(|_| state.alive(first + row, column, yarn)) {
                let [one, other] = link.map(|node| root(&mut parent, node));
                parent[one.max(other)] = one.min(other);
            }
        }
    }
    (0..parent.len()).map(|node| root(&mut parent, node)).collect()
}

/// Whether the piece of fabric of a node (row, column) can hold a projectile that flies at `speed` along the normal [m/s].
pub(crate) fn supporting<S: Scalar>(
    model: &Model<S>,
    state: &State<S>,
    ply: usize,
    speed: f64,
) -> impl Fn(usize, usize) -> bool {
    let (ply_type, roots) = (model.ply_type(ply), pieces(model, state, ply));
    let stride = ply_type.mesh.columns + 1;
    let hold = match held_nodes(ply_type).next() {
        None => are_the_ply(model, state, ply, &roots, speed),
        Some(_) => reach_a_clamp(ply_type, &roots),
    };
    move |row, column| hold[roots[row * stride + column]]
}

/// Attached fabric of a ply.
pub(crate) struct Attached {
    /// Largest deflection of it [m].
    pub(crate) deflection: f64,
    /// Some other fabric of the ply is detached.
    pub(crate) debris: bool,
}

/// Attached fabric of a ply.
pub(crate) fn attached<S: Scalar>(model: &Model<S>, state: &State<S>, ply: usize) -> Attached {
    let (mesh, grid) = (&model.ply_type(ply).mesh, &model.grid);
    let (nodes, elements) = (grid.first_node_row(ply), grid.first_element_row(ply));
    // Almost always the ply is one piece.
    if is_unbroken(model, state, ply) {
        let all = (0..=mesh.rows).flat_map(|row| (0..=mesh.columns).map(move |column| (row, column)));
        let deflections = all.map(|(row, column)| state.displacement(nodes + row, column)[2].abs());
        return Attached { deflection: deflections.fold(0.0, f64::max), debris: false };
    }
    let holds = supporting(model, state, ply, f64::INFINITY);
    let mut found = Attached { deflection: 0.0, debris: false };
    for (row, column) in (0..mesh.rows).flat_map(|row| (0..mesh.columns).map(move |column| (row, column))) {
        for (row, column) in corners([row, column]).into_iter().filter(|_| state.is_intact(elements + row, column)) {
            found.debris |= !holds(row, column);
            if holds(row, column) {
                found.deflection = found.deflection.max(state.displacement(nodes + row, column)[2].abs());
            }
        }
    }
    found
}

/// Whether no yarn of a ply is broken anywhere. One that the fabric does not have links nothing, and counts as broken.
fn is_unbroken<S: Scalar>(model: &Model<S>, state: &State<S>, ply: usize) -> bool {
    let (mesh, first) = (&model.ply_type(ply).mesh, model.grid.first_element_row(ply));
    let stands = |row: usize, column, yarn| state.alive(row, column, yarn) || !mesh.is_present(row - first, column);
    let is_whole = |row: usize, yarn| (0..mesh.columns).all(|column| stands(row, column, yarn));
    (first..first + mesh.rows).all(|row| is_whole(row, 0) && is_whole(row, 1))
}

/// Nodes of fabric that a clamp holds: row, column. A mirror plane does not, nor does the symmetry plane of a roller: behind it the image of
/// a piece reaches the images of the clamps that the piece itself reaches.
fn held_nodes<S: Scalar>(ply_type: &PlyType<S>) -> impl Iterator<Item = (usize, usize)> {
    let is_held = |&(row, column): &(usize, usize)| {
        ply_type.is_clamped(row, column) && ply_type.row_mass(row).mass[column].to_f64() > 0.0
    };
    ply_type.nodes().filter(is_held)
}

/// Mass of the whole pack [kg] and its momentum along the normal at the start [N·s], if no clamp and no clay holds any of its plies.
pub(crate) fn free_pack<S: Scalar>(model: &Model<S>) -> Option<[f64; 2]> {
    if model.backing.is_some() {
        return None;
    }
    (0..model.plies.len()).try_fold([0.0; 2], |[mass, momentum], ply| {
        let ply_type = model.ply_type(ply);
        let mesh = &ply_type.mesh;
        let more = match mesh.frame.opening {
            Opening::Mesh => ply_type.areal_density * mesh.whole_size().iter().product::<f64>(),
            _ => ply_type.fabric_mass() * model.planes.copies() as f64,
        };
        held_nodes(ply_type).next().is_none().then_some([mass + more, momentum + more * ply_type.initial_velocity[2]])
    })
}

/// Whether the piece of each root reaches a clamp.
fn reach_a_clamp<S: Scalar>(ply_type: &PlyType<S>, roots: &[usize]) -> Vec<bool> {
    let mut reach = vec![false; roots.len()];
    held_nodes(ply_type).for_each(|(row, column)| reach[roots[row * (ply_type.mesh.columns + 1) + column]] = true);
    reach
}

/// Whether the piece of each root of a ply without a held edge has with its mirror images at least half of the mass of the ply, and is not
/// faster than `speed` along the normal [m/s].
fn are_the_ply<S: Scalar>(model: &Model<S>, state: &State<S>, ply: usize, roots: &[usize], speed: f64) -> Vec<bool> {
    let ply_type = model.ply_type(ply);
    let mesh = &ply_type.mesh;
    let (mut mass, mut momentum) = (vec![0.0; roots.len()], vec![0.0; roots.len()]);
    // Whether it reaches the mirror plane across X, across Y: what does is one with its image.
    let mut reaches = vec![[false; 2]; roots.len()];
    for (node, root) in roots.iter().enumerate() {
        let (row, column) = (node / (mesh.columns + 1), node % (mesh.columns + 1));
        let part = ply_type.row_mass(row).mass[column].to_f64();
        mass[*root] += part;
        momentum[*root] += part * state.velocity(model.grid.first_node_row(ply) + row, column)[2];
        for (reach, cut) in reaches[*root].iter_mut().zip(mesh.cut_across(row, column)) {
            *reach |= cut;
        }
    }
    let copies: f64 = mesh.cut.iter().map(|cut| if *cut == Cut::Nowhere { 1.0 } else { 2.0 }).product();
    let whole = copies * mass.iter().sum::<f64>();
    let holds = |root: usize| {
        let images: f64 = reaches[root].iter().map(|reaches| if *reaches { 2.0 } else { 1.0 }).product();
        images * mass[root] >= SUBSTANTIAL * whole && momentum[root] <= mass[root] * speed
    };
    (0..roots.len()).map(holds).collect()
}

/// Deflections of plies with detached pieces, of attached fabric, and the looks that find them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Deflections {
    /// At the last look [m]; `None` where nothing is detached.
    torn: Vec<Option<f64>>,
    /// Looks taken or missed so far.
    looks: u64,
}

impl Deflections {
    pub(crate) fn new(plies: usize) -> Self {
        Self { torn: vec![None; plies], looks: 0 }
    }

    /// Time of a look [s].
    fn time_of(case: &Case, look: u64) -> f64 {
        look as f64 * (case.solver.end_time / LOOKS)
    }

    /// Whether a look is due before the step from `time` [s]. Time alone decides, so that every backend looks at the same states.
    pub(crate) fn is_due(&self, case: &Case, time: f64, dt: f64) -> bool {
        case.projectile.is_some() && time >= Self::time_of(case, self.looks) - 0.5 * dt
    }

    /// Gives what is torn the deflection of its attached fabric, in a sample in which all fabric counts.
    pub(crate) fn correct(&self, plies: &mut [PlyMoment]) {
        for (torn, ply) in self.torn.iter().zip(plies) {
            ply.deflection = torn.unwrap_or(ply.deflection);
        }
    }

    /// Looks at the attached fabric at `time` [s], of plies with failures alone. Gives the time from which on samples have too much [s], and the
    /// plies in which a piece is detached now, with the most that these had [m].
    pub(crate) fn look(
        &mut self,
        case: &Case,
        time: f64,
        dt: f64,
        failed: &[[u64; 2]],
        attached: impl Fn(usize) -> Attached,
    ) -> (f64, Vec<(usize, f64)>) {
        let since = Self::time_of(case, self.looks.saturating_sub(1)) + 0.5 * dt;
        while self.is_due(case, time, dt) {
            self.looks += 1;
        }
        let mut found = Vec::new();
        for (ply, torn) in self.torn.iter_mut().enumerate().filter(|(ply, _)| failed[*ply] != [0; 2]) {
            let Attached { deflection, debris } = attached(ply);
            if torn.is_none() && debris {
                found.push((ply, deflection));
            }
            *torn = (debris || torn.is_some()).then_some(deflection);
        }
        (since, found)
    }
}
