//! Point physics: what a yarn, a crossover, an element or a point of contact does, without a mesh.
//!
//! Generic over [`Real`](crate::num::scalar::Real), of numbers and constants alone: no files, threads or devices. A file has the name of its
//! twin in `shaders/`.

pub mod coupled_newton;
pub mod crossover;
pub mod kinematics;
pub mod membrane;
pub mod ply_contact;
pub mod projectile_body;
pub mod projectile_shape;
pub mod rigid_body;
pub mod unit_cell_parameters;
pub mod viscous_force;
pub mod yarn_law;
