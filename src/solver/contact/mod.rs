//! Contact of the plies with one another and with the projectile: broad phase, narrow phase, contact impulses.

pub mod broad_phase;
mod contact_candidates;
pub mod edge_contact;
pub(crate) mod ply_impulse;
pub mod ply_search;
pub mod projectile_contact;
pub mod projectile_points;
