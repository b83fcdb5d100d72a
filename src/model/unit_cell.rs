//! The unit cell alone over a grid of stretches: its curves, and the energy that the published law does not conserve by itself.
//!
//! Curves are those of the paper's Figure 4, with a law that no run uses beside the two that one may.
//!
//! The contact force (18) is not the slope of an energy: what its in-plane forces take up on the way to a pair of stretches, W, is not
//! what yarns and crossover hold there, U. The share (U − W)/U is tabulated over both stretches, W along the straight way from rest.
//! Other ways differ by 0.05 to 0.3 % of what is stored. The energy balance takes share times U as a state of its own, so that the energy which
//! nothing accounts for is that of the arithmetic alone.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use crate::case::{Fabric, Law};
use crate::num::scalar::{Real, Scalar, WIDEST, each};
use crate::num::simd::Vectors;
use crate::physics::crossover::{self, Equilibrium, cell_energy};
use crate::physics::unit_cell_parameters::UnitCellParameters;
use crate::physics::yarn_law::{LawKernel, SHORTEST, Sinusoidal, StretchResponse, YarnConstants, YarnResponse};

/// Places along each axis of a table of the law's energy.
pub const PLACES: usize = 40;
/// Points of the midpoint rule along the taut part of the way to a place.
const POINTS: u32 = 16;
/// Halvings that find where the way grows taut.
const HALVINGS: u32 = 12;
/// Axial strain that the table reaches where yarns do not fail.
const NO_FAILURE: f64 = 0.1;

/// (U − W)/U of a crossover over the stretches of warp and weft; nothing for laws that conserve energy.
#[derive(Clone, Debug, PartialEq)]
pub struct LawEnergy {
    /// Λ − 1 of the first place [-], warp and weft.
    pub low: [f64; 2],
    /// Places per stretch [-].
    pub per_stretch: [f64; 2],
    /// Share [-], 0 where both yarns are slack, shape (PLACES warp, PLACES weft).
    pub values: Vec<f64>,
}

impl LawEnergy {
    /// Table of a cell with the published law; `None` where a yarn is absent.
    pub fn new(cell: &UnitCellParameters<f64>) -> Option<Self> {
        if cell.height_sum <= 0.0 || cell.yarn.iter().any(|yarn| yarn.stiffness <= 0.0) {
            return None;
        }
        let range = cell.yarn.map(|yarn| {
            // Below, the yarn is slack at the largest height it can have; above, it is broken.
            let slope = std::f64::consts::FRAC_PI_2 * cell.height_sum / yarn.half_span;
            let limit = if yarn.failure_strain < 1.0 { yarn.failure_strain } else { NO_FAILURE };
            [(yarn.crimp - 0.25 * slope * slope).max(-0.5), (1.0 + yarn.crimp) * (1.0 + limit) - 1.0]
        });
        let steps = (PLACES - 1) as f64;
        let low = range.map(|[low, _]| low);
        let per_stretch = range.map(|[low, high]| steps / (high - low));
        let places = |axis: usize| (0..PLACES).map(move |index| low[axis] + index as f64 / per_stretch[axis]);
        let (warp, weft): (Vec<f64>, Vec<f64>) = (places(0).collect(), places(1).collect());
        let (mut values, vectors) = (vec![0.0; PLACES * PLACES], Vectors::widest());
        values.par_chunks_mut(PLACES).zip(warp).for_each(|(row, warp)| match vectors {
            Vectors::None => row_of(0.0, cell, warp, &weft, row),
            #[cfg(target_arch = "x86_64")]
            Vectors::Avx512(simd) => row_of(f64::lanes(simd), cell, warp, &weft, row),
            #[cfg(all(target_arch = "x86_64", not(feature = "quick-build")))]
            Vectors::Avx2(simd) => row_of(f64::lanes(simd), cell, warp, &weft, row),
            #[cfg(target_arch = "aarch64")]
            Vectors::Neon(simd) => row_of(f64::lanes(simd), cell, warp, &weft, row),
            // Double precision is slow there: see `web/`.
            #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
            Vectors::Wasm(_) => row_of(0.0, cell, warp, &weft, row),
        });
        Some(Self { low, per_stretch, values })
    }

    /// The share at the stretches Λ − 1 of warp and weft [-], bilinear between the places.
    pub fn at(&self, stretch: [f64; 2]) -> f64 {
        let [(i, x), (j, y)] = [0, 1].map(|axis: usize| {
            let place = ((stretch[axis] - self.low[axis]) * self.per_stretch[axis]).clamp(0.0, (PLACES - 1) as f64);
            let index = (place as usize).min(PLACES - 2);
            (index, place - index as f64)
        });
        let value = |i: usize, j: usize| self.values[i * PLACES + j];
        let low = value(i, j) + y * (value(i, j + 1) - value(i, j));
        let high = value(i + 1, j) + y * (value(i + 1, j + 1) - value(i + 1, j));
        low + x * (high - low)
    }

    /// The shares of some cells.
    #[inline(always)]
    pub(crate) fn shares<R: Real>(&self, stretch: &[R; 2]) -> R {
        let mut values = [R::Scalar::splat(0.0); WIDEST];
        for lane in 0..R::LANES {
            let at = [0, 1].map(|i: usize| stretch[i].lane(lane).to_f64());
            values[lane] = R::Scalar::splat(self.at(at));
        }
        stretch[0].load(&values, 0)
    }
}

/// The shares of one stretch of the warp and those of the weft, as many at once as `n` holds.
fn row_of<R: Real<Scalar = f64>>(n: R, cell: &UnitCellParameters<f64>, warp: f64, weft: &[f64], row: &mut [f64]) {
    let cell = cell.map(|x| n.broadcast(x));
    n.vectorize(
        #[inline(always)]
        || {
            for first in (0..PLACES).step_by(R::LANES) {
                law_share(&cell, [n.broadcast(warp), n.load(weft, first)]).store(row, first);
            }
        },
    );
}

/// (U − W)/U on the straight way from rest.
#[inline(always)]
fn law_share<R: Real>(cell: &UnitCellParameters<R>, stretch: [R; 2]) -> R {
    let n = cell.height_sum;
    let [zero, half, one] = [0.0, 0.5, 1.0].map(|x| n.splat_like(x));
    let rest = each!(i in 2 => cell.yarn[i].height);
    // First the end of the way. Then halvings: nothing works before a yarn is taut. Then points along what is left.
    let (mut part, mut warm) = (one, rest);
    let (mut slack, mut taut) = (zero, one);
    let (mut stored, mut work, mut step) = (zero, zero, zero);
    for turn in 0..=HALVINGS + POINTS {
        let there = crossover::solve::<R, Sinusoidal>(cell, each!(i in 2 => part * stretch[i]), warm, !n.never());
        if turn == 0 {
            stored = cell_energy(cell, &there.tension, &there.strain, there.force);
        } else if turn <= HALVINGS {
            let works = zero.lt(there.tension[0]) | zero.lt(there.tension[1]);
            (slack, taut) = (R::select(works, slack, part), R::select(works, part, taut));
            step = (one - slack) * n.splat_like(1.0 / f64::from(POINTS));
        } else {
            warm = there.height;
            let along = each!(i in 2 => there.in_plane[i] * n.splat_like(2.0) * cell.yarn[i].half_span * stretch[i]);
            work = work + (along[0] + along[1]) * step;
        }
        part = if turn < HALVINGS {
            half * (slack + taut)
        } else {
            slack + n.splat_like(f64::from(turn - HALVINGS) + 0.5) * step
        };
    }
    let share = one - work / stored;
    R::select(stored.le(zero), zero, share.max(-one).min(one))
}

/// Tables that are kept, of 13 kB each: a layup of several fabrics has one for each.
const KEPT: usize = 16;

/// Cells and their tables, the last one first.
static LAST: Mutex<VecDeque<(UnitCellParameters<f64>, Arc<LawEnergy>)>> = Mutex::new(VecDeque::new());

/// Table of a cell; `None` where the law is the slope of an energy, or a yarn is absent.
pub(super) fn table_of(cell: &UnitCellParameters<f64>) -> Option<Arc<LawEnergy>> {
    if cell.yarn[0].law != Law::Published {
        return None;
    }
    let entries = || LAST.lock().unwrap_or_else(PoisonError::into_inner);
    let known = entries().iter().find(|(of, _)| of == cell).map(|(_, table)| table.clone());
    if known.is_some() {
        return known;
    }
    // Unlocked, for others to build theirs at the same time.
    let table = Arc::new(LawEnergy::new(cell)?);
    let mut entries = entries();
    entries.truncate(KEPT - 1);
    entries.push_front((*cell, table.clone()));
    Some(table)
}

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;

    fn cell() -> UnitCellParameters<f64> {
        UnitCellParameters::new(&crate::case::shipped(&[]).fabric)
    }

    #[test]
    fn a_law_that_is_a_slope_has_none_and_the_published_one_has() {
        let (cell, variational) = (cell(), cell_of("/fabric/crossover/law=variational"));
        assert!(table_of(&variational).is_none());
        for stretch in [[0.01, 0.0], [0.02, 0.02], [0.04, 0.01]] {
            let conserved = law_share(&variational, stretch).abs();
            let published = law_share(&cell, stretch).abs();
            assert!(conserved < 0.05 * published && published < 0.3, "{stretch:?}: {conserved} {published}");
        }
    }

    #[test]
    fn the_table_is_what_it_tabulates() {
        let cell = cell();
        let Some(table) = LawEnergy::new(&cell) else { unreachable!("the published law has a table") };
        for stretch in [[0.004, 0.003], [0.011, 0.002], [0.013, 0.017], [0.03, 0.012], [0.05, -0.01]] {
            let exact = law_share(&cell, stretch);
            assert!((table.at(stretch) - exact).abs() < 0.02, "{stretch:?}: {} {exact}", table.at(stretch));
        }
        // At its places to the bit, whatever the registers.
        for (i, j) in [(0, 0), (7, 31), (20, 3), (38, 39)] {
            let place = [i, j].map(|index| index as f64);
            let stretch = [0, 1].map(|axis: usize| table.low[axis] + place[axis] / table.per_stretch[axis]);
            assert_eq!(table.values[i * PLACES + j], law_share(&cell, stretch), "{i} {j}");
        }
        // Slack, and beyond the table: what is nearest.
        assert!(table.at([-0.2, -0.2]) == 0.0 && table.at([9.0, 9.0]).abs() <= 1.0);
    }

    fn cell_of(set: &str) -> UnitCellParameters<f64> {
        UnitCellParameters::new(&case::shipped(&[set]).fabric)
    }
}
