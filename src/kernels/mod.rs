//! The solver's arithmetic, one kernel or one piece of point physics per file.
//!
//! Kernels are generic over [`Real`](crate::num::scalar::Real), see slices of numbers and constants, and never files,
//! threads or devices. Point physics (`arc_length`, `yarn_law`, `crossover`, `shear`, `projectile_shape`, `projectile_chisel`) knows no mesh;
//! element and node kernels know no material law beyond calling it.

pub mod arc_length;
pub mod coupled_newton;
pub mod crossover;
pub mod element_force;
pub(crate) mod element_geometry;
pub(crate) mod kinematics;
pub mod law_energy;
mod membrane;
pub mod mirror_planes;
pub mod node_update;
pub mod ply_contact;
pub mod predictor;
mod prefetch;
pub mod projectile_body;
pub mod projectile_chisel;
pub mod projectile_contact;
pub mod projectile_rim;
pub mod projectile_shape;
pub mod rigid_body;
pub mod shear;
pub mod unit_cell_parameters;
pub mod yarn_law;
