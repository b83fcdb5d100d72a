//! The critical time step and what sets it.
//!
//! The highest frequency of the assembled mesh is bounded by that of one element. In a one-point quad with lumped
//! mass the patterns of ∂/∂X, ∂/∂Y and hourglass are orthogonal, and within each the directions e_i (yarn) and n_i
//! (shear) are too, so the bound is the largest of the terms below, for any stretch and shear angle. Contact is
//! kinematic and adds no stiffness.

use crate::kernels::element_force::{ElementConstants, LONGEST_LEVER};
use crate::kernels::shear;

/// The step bound of a fabric's mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepBound {
    /// 2/ω of the stiffest element mode [s].
    pub critical_step: f64,
    /// What that mode is.
    pub set_by: &'static str,
}

impl StepBound {
    /// The bound of a fabric. Yarn waves give min(Lx √(Ad/C1), Ly √(Ad/C2)).
    /// `length`: of an element [m]; `areal_density` [kg/m²]; `viscosity`: the coefficient q of the shock viscosity [-], which acts half a
    /// step late, so that a wave's step is shorter by √(1 + q²) − q.
    pub fn new([lx, ly]: [f64; 2], areal_density: f64, element: &ElementConstants<f64>, viscosity: f64) -> Self {
        let yarn = &element.cell.yarn;
        let c1 = yarn[0].stiffness / (2.0 * yarn[1].half_span);
        let c2 = yarn[1].stiffness / (2.0 * yarn[0].half_span);
        let levers = (LONGEST_LEVER / lx).powi(2) + (LONGEST_LEVER / ly).powi(2);
        // Tension stiffens the directions across the yarns, where shear acts, by at most its value at failure.
        let limit = [0, 1].map(|i| yarn[i].failure_strain.min(1.0));
        let tension = (c1 * limit[0] / (lx * lx)).max(c2 * limit[1] / (ly * ly));
        let damped = ((1.0 + viscosity * viscosity).sqrt() - viscosity).powi(-2);
        let terms = [
            (4.0 * damped * c1 / (lx * lx), "wave along the warp"),
            (4.0 * damped * c2 / (ly * ly), "wave along the weft"),
            (4.0 * (shear::largest_tangent(&element.shear) * levers + tension), "trellis shear"),
            ((element.hourglass[0] + element.hourglass[1]) / (lx * ly), "hourglass stiffness"),
        ];
        let (stiffest, set_by) = terms.into_iter().fold((0.0, ""), |a, b| if b.0 > a.0 { b } else { a });
        Self { critical_step: 2.0 / (stiffest / areal_density).sqrt(), set_by }
    }
}
