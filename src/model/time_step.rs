//! The critical time step and what sets it.
//!
//! The highest frequency of the assembled mesh is bounded by that of one element. In a one-point quad with lumped
//! mass the patterns of ∂/∂X, ∂/∂Y and hourglass are orthogonal, and within each the directions e_i (yarn) and n_i
//! (shear) are too, so the bound is the largest of the terms below, for any stretch and shear angle. Contact is
//! kinematic and adds no stiffness.
//!
//! Where stretches are means over an element, both yarns act on the hourglass mode, too. Then the largest term is exceeded by b1·b2 at most,
//! with |b|² = |q|²/(3 Λ²): a twelfth where the edges differ from the centre by half of the stretch. A Courant number of 0.9 leaves a fifth.

use crate::case::{Edge, Edges, InitialDeflection, Pack};
use crate::model::ModelError;
use crate::physics::element_geometry::ElementConstants;
use crate::physics::membrane::LONGEST_LEVER;
use crate::physics::unit_cell_parameters::UnitCellParameters;
use crate::physics::yarn_law::LawKernel;
use crate::physics::{crossover, shear};

/// The step bound of a fabric's mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepBound {
    /// 2/ω of the stiffest element mode [s].
    pub critical_step: f64,
    /// Name of that mode.
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

    /// The bound of a ply that starts far from equilibrium. Tension leaves it in a front as steep as the mesh. Every yarn that goes slack
    /// there makes a little energy, the less the shorter the step. `set_by`: what the ply starts with.
    #[must_use]
    pub fn of_let_go(self, set_by: &'static str) -> Self {
        Self { critical_step: LET_GO * self.critical_step, set_by }
    }

    /// Bound of a ply of this number of elements that starts under tension. Where it is torn, it is let go. Over many elements what yarns make and
    /// lose as they go slack and taut evens out, over few it does not.
    #[must_use]
    pub fn of_tension_in(self, elements: usize) -> Self {
        if elements >= FEW {
            return self;
        }
        Self { critical_step: STEP_OF_FEW * self.critical_step, set_by: "initial tension in few elements" }
    }
}

/// Step of a ply that starts far from equilibrium, over the critical one [-]. Measured: a single element, the worst there is, gains at most
/// 0.4 % of its energy at a Courant number of 0.9; with half of the critical step it was 4.2 %.
const LET_GO: f64 = 0.15;

/// Elements of a ply under tension below which energy made and lost at slack does not even out [-]. Measured: plies of 32 to 512 elements that are
/// torn gain −7.1 to 1.9 % of their energy with the critical step, one of 1764 −0.6 to 0.5 %.
const FEW: usize = 1000;

/// Step of such a ply over the critical one [-]. The error falls with its square: with 0.5 it was −1.5 to 1.1 %, with 0.15 −0.3 to 0.1 %.
const STEP_OF_FEW: f64 = 1.0 / 3.0;

/// Stretch of yarns by the initial deflection above which a ply starts far from equilibrium [-]. Measured: plies of 4 to 20 elements whose yarns
/// it stretches by 2 to 12 % gain 1.0 to 1.7 % of their energy with the critical step.
const STEEP: f64 = 0.01;

/// Start of a ply of this size [m] that is far from equilibrium, if it is: tension that ends at a free edge (of its pre-tension, in
/// which a direction that keeps its length has one, too, or of its deflection), or a steep deflection.
pub fn let_go(
    pretension: Option<[Option<f64>; 2]>,
    deflection: Option<InitialDeflection>,
    edges: Edges,
    size: [f64; 2],
) -> Option<&'static str> {
    let Edges { left, right, bottom, top } = edges;
    let ends = [[left, right], [bottom, top]];
    let stretch = [0, 1].map(|i: usize| {
        let slope = |d: InitialDeflection| {
            std::f64::consts::PI * d.amplitude / size[i] * f64::from([d.warp_half_waves, d.weft_half_waves][i])
        };
        0.25 * deflection.map_or(0.0, slope).powi(2)
    });
    let stretched = |i: usize| stretch[i] > 0.0 || pretension.is_some_and(|forces| forces[i] != Some(0.0));
    if (0..2).any(|i| stretched(i) && ends[i].contains(&Edge::Free)) {
        return Some("initial tension at a free edge");
    }
    stretch.iter().any(|stretch| *stretch > STEEP).then_some("steep initial deflection")
}

/// Stretch range searched, Λ − 1.
const RANGE: [f64; 2] = [-0.5, 0.5];

/// Uniform stretch of the pack before the shot, and the yarn heights in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialStretch {
    /// Λ − 1 along warp and weft [-].
    pub stretch: [f64; 2],
    /// Yarn heights [m].
    pub height: [f64; 2],
}

/// Membrane forces per reference length N1, N2 [N/m], yarn strains and heights at a stretch.
fn membrane<L: LawKernel>(cell: &UnitCellParameters<f64>, stretch: [f64; 2]) -> ([f64; 2], [f64; 2], [f64; 2]) {
    let warm = [cell.yarn[0].height, cell.yarn[1].height];
    // Where a yarn is absent the heights sum up to nothing, and the other one straightens freely.
    let e = crossover::solve::<f64, L>(cell, stretch, warm, true);
    let force = [e.in_plane[0] / (2.0 * cell.yarn[1].half_span), e.in_plane[1] / (2.0 * cell.yarn[0].half_span)];
    (force, e.strain, e.height)
}

/// Finds the stretch that carries the pre-tension asked for; a direction without one keeps its length.
///
/// # Errors
/// When no stretch does, or when it would break a yarn.
pub fn stretch_of_pretension<L: LawKernel>(
    pack: &Pack,
    cell: &UnitCellParameters<f64>,
) -> Result<InitialStretch, ModelError> {
    let rest = InitialStretch { stretch: [0.0; 2], height: [cell.yarn[0].height, cell.yarn[1].height] };
    let Some(asked) = pack.pretension else { return Ok(rest) };
    let mut stretch = [0.0; 2];
    // Both membrane forces grow with both stretches, so each direction is bisected, the warp inside the weft.
    let warp = |weft: f64| match asked[0] {
        Some(n) => bisect(|s| membrane::<L>(cell, [s, weft]).0[0] <= n),
        None => 0.0,
    };
    if let Some(n) = asked[1] {
        stretch[1] = bisect(|s| membrane::<L>(cell, [warp(s), s]).0[1] <= n);
    }
    stretch[0] = warp(stretch[1]);
    let (force, strain, height) = membrane::<L>(cell, stretch);
    for (i, yarn) in ["warp", "weft"].into_iter().enumerate() {
        if let Some(n) = asked[i].filter(|n| (force[i] - n).abs() > 1e-6 * n.max(1.0)) {
            return Err(ModelError::Pretension { yarn, asked: n });
        }
        let limit = cell.yarn[i].failure_strain;
        if cell.yarn[i].stiffness > 0.0 && strain[i] >= limit {
            return Err(ModelError::PretensionBreaks { yarn, strain: strain[i], limit });
        }
    }
    Ok(InitialStretch { stretch, height })
}

/// The largest number in [`RANGE`] for which `below` holds, if it holds up to some point.
fn bisect(below: impl Fn(f64) -> bool) -> f64 {
    let [mut low, mut high] = RANGE;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
#[path = "time_step_tests.rs"]
mod tests;
