//! The unit cell alone over a grid of stretches: the curves of the paper's Figure 4.

use crate::case::Fabric;
use crate::kernels::crossover::{self, Equilibrium, LawKernel, UnitCellParameters, Variant};
use crate::with_law;

/// One solved cell.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct CurvePoint {
    /// Λ of warp and weft [-].
    pub stretch: [f64; 2],
    /// Tensions, heights, strains.
    #[doc(hidden)]
    pub cell: Equilibrium<f64>,
}

impl CurvePoint {
    /// The numbers of a point, in the order of `ripstop crossover`.
    pub fn numbers(&self) -> [(&'static str, f64); 11] {
        let cell = &self.cell;
        [
            ("warp_stretch", self.stretch[0]),
            ("weft_stretch", self.stretch[1]),
            ("warp_tension_n", cell.tension[0]),
            ("weft_tension_n", cell.tension[1]),
            ("contact_force_n", cell.force),
            ("warp_height_mm", cell.height[0] * 1e3),
            ("weft_height_mm", cell.height[1] * 1e3),
            ("warp_strain", cell.strain[0]),
            ("weft_strain", cell.strain[1]),
            ("iterations", cell.iterations),
            ("residual", cell.residual),
        ]
    }

    /// Whether warp (0) or weft (1) is strained beyond failure.
    pub fn is_broken(&self, fabric: &Fabric, yarn: usize) -> bool {
        let limit = [&fabric.warp, &fabric.weft][yarn];
        limit.present && self.cell.strain[yarn] >= limit.failure_strain
    }
}

/// Every pair of these stretches, each solved from the heights at rest, so that none depends on another.
pub fn solve(fabric: &Fabric, warp: &[f64], weft: &[f64]) -> Vec<CurvePoint> {
    let constants = UnitCellParameters::new(fabric);
    with_law!(Variant::of(&fabric.crossover), L => solve_as::<L>(fabric, &constants, warp, weft))
}

fn solve_as<L: LawKernel>(
    fabric: &Fabric,
    constants: &UnitCellParameters<f64>,
    warp: &[f64],
    weft: &[f64],
) -> Vec<CurvePoint> {
    let cell = UnitCellParameters::<f64>::cast::<L>(constants);
    let rest = [cell.yarn[0].height, cell.yarn[1].height];
    let both = fabric.warp.present && fabric.weft.present;
    let at = |stretch: [f64; 2]| {
        let excess = stretch.map(|stretch| stretch - 1.0);
        CurvePoint { stretch, cell: crossover::solve::<f64, L>(&cell, excess, rest, both) }
    };
    warp.iter().flat_map(|&warp| weft.iter().map(move |&weft| at([warp, weft]))).collect()
}
