//! The uniform stretch of a pre-tensioned pack.

use super::ModelError;
use crate::case::Pack;
use crate::kernels::crossover::{self, LawKernel, UnitCellParameters};

/// Stretch range searched, Λ − 1.
const RANGE: [f64; 2] = [-0.5, 0.5];

/// Uniform stretch of the pack before the shot, and the yarn heights that go with it.
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
pub fn solve<L: LawKernel>(pack: &Pack, cell: &UnitCellParameters<f64>) -> Result<InitialStretch, ModelError> {
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
#[path = "pretension_tests.rs"]
mod tests;
