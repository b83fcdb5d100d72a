//! The defects: what is wrong, the scene it shows in, a text of the kernel and what it becomes.

mod elements;
mod ledger;
mod nodes;
mod ply_impulse;
mod ply_move;
mod ply_search;
mod projectile;
mod projectile_shape;
mod rim;
mod unit_cell;

use super::Mutant;

/// By kernel, in the order of a step.
pub(super) const MUTANTS: [&[Mutant]; 10] = [
    elements::MUTANTS,
    unit_cell::MUTANTS,
    nodes::MUTANTS,
    ply_search::MUTANTS,
    ply_impulse::MUTANTS,
    ply_move::MUTANTS,
    projectile::MUTANTS,
    projectile_shape::MUTANTS,
    rim::MUTANTS,
    ledger::MUTANTS,
];
