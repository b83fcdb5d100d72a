//! The unit cell alone over a grid of stretches: the curves of the paper's Figure 4, with a law that no run uses beside the two that one may.

use crate::case::{Fabric, Law};
use crate::num::scalar::Real;
use crate::physics::crossover::{self, Equilibrium};
use crate::physics::unit_cell_parameters::UnitCellParameters;
use crate::physics::yarn_law::{LawKernel, SHORTEST, Sinusoidal, StretchResponse, YarnConstants, YarnResponse};

/// Unit-cell law of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum CurveLaw {
    /// The paper's, with the tension T in the plane.
    Published,
    /// Sinusoidal yarns, forces conjugate to the arc length.
    Variational,
    /// Saw-tooth cell of Kawabata (1973).
    Kawabata,
}

impl From<Law> for CurveLaw {
    fn from(law: Law) -> Self {
        match law {
            Law::Published => Self::Published,
            Law::Variational => Self::Variational,
        }
    }
}

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
}

/// Every pair of these stretches with the fabric's own law, each solved from the heights at rest, so that none depends on another.
pub fn solve(fabric: &Fabric, warp: &[f64], weft: &[f64]) -> Vec<CurvePoint> {
    solve_with(fabric, fabric.crossover.law.into(), warp, weft)
}

/// Every pair of these stretches with a law of choice.
pub fn solve_with(fabric: &Fabric, law: CurveLaw, warp: &[f64], weft: &[f64]) -> Vec<CurvePoint> {
    let curve = if law == CurveLaw::Kawabata { curve::<Kawabata> } else { curve::<Sinusoidal> };
    curve(&parameters(fabric, law), fabric.warp.present && fabric.weft.present, warp, weft)
}

fn curve<L: LawKernel>(exact: &UnitCellParameters<f64>, both: bool, warp: &[f64], weft: &[f64]) -> Vec<CurvePoint> {
    let cell = UnitCellParameters::<f64>::cast::<L>(exact);
    let rest = cell.yarn.map(|yarn| yarn.height);
    let at = |stretch: [f64; 2]| {
        let excess = stretch.map(|stretch| stretch - 1.0);
        CurvePoint { stretch, cell: crossover::solve::<f64, L>(&cell, excess, rest, both) }
    };
    warp.iter().flat_map(|&warp| weft.iter().map(move |&weft| [warp, weft])).map(at).collect()
}

/// Constants of a fabric's cell under a law.
pub fn parameters(fabric: &Fabric, law: CurveLaw) -> UnitCellParameters<f64> {
    let law = match law {
        CurveLaw::Kawabata => {
            return UnitCellParameters::with_rest_height(fabric, |crimp| (crimp * (2.0 + crimp)).sqrt());
        }
        CurveLaw::Published => Law::Published,
        CurveLaw::Variational => Law::Variational,
    };
    let cell = UnitCellParameters::new(fabric);
    UnitCellParameters { yarn: cell.yarn.map(|yarn| YarnConstants { law, ..yarn }), ..cell }
}

/// Kawabata's saw-tooth cell.
#[derive(Clone, Copy, Debug)]
pub struct Kawabata;

/// Leg length l/w0 − 1 and l/w0 of the saw-tooth.
fn leg<R: Real>(yarn: &YarnConstants<R>, span: &StretchResponse<R>, h: R) -> (R, R) {
    let one = h.one();
    let stretch = span.stretch;
    let eta = h / yarn.half_span;
    let square_minus_1 = stretch * (h.splat_like(2.0) + stretch) + eta.squared();
    let leg = h.zero().max(one + square_minus_1).sqrt().max(h.splat_like(SHORTEST));
    (square_minus_1 / (leg + one), leg)
}

impl LawKernel for Kawabata {
    fn respond<R: Real>(yarn: &YarnConstants<R>, span: &StretchResponse<R>, h: R) -> YarnResponse<R> {
        let (n, one) = (h, h.one());
        let (excess, leg) = leg(yarn, span, h);
        let per_length = yarn.per_rest;
        let strain = (excess - yarn.crimp) * per_length;
        let taut = n.zero().lt(strain);
        let tension = yarn.tension(strain);
        let eta = h / yarn.half_span;
        let per_leg = one / leg;
        let sine = eta * per_leg;
        let two = n.splat_like(2.0);
        let dstrain = per_length * sine / yarn.half_span;
        let cosine = (one + span.stretch) * per_leg;
        let turning = tension * cosine.squared() * per_leg / yarn.half_span;
        let stiffness = two * (yarn.modulus(strain) * dstrain * sine + turning);
        YarnResponse {
            strain,
            force: R::select(taut, two * tension * sine, yarn.slack_slope * strain),
            stiffness: R::select(taut, stiffness, yarn.slack_slope * dstrain),
            growth: dstrain,
        }
    }

    fn in_plane_factor<R: Real>(yarn: &YarnConstants<R>, span: &StretchResponse<R>, h: R) -> R {
        (h.one() + span.stretch) / leg(yarn, span, h).1
    }
}
