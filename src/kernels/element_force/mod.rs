//! Element kernel: stretches, crossover equilibrium, shear, failure and corner forces of one row of elements.
//!
//! Forces are P1 = N1 e1 + (q/Λ1) n2 and P2 = N2 e2 + (q/Λ2) n1 with unit vectors n2 ⟂ e1 and n1 ⟂ e2 in the
//! element's plane. On the difference of opposite edges x1 − x2 + x3 − x4 act the yarns, whose stretch is a mean over the element, and an
//! hourglass stiffness in total form.
//!
//! An element whose two yarns have failed carries nothing; with one yarn left the trellis is gone, so shear is
//! released with the first failure.

mod elements;
mod energies;
mod release;
mod row;
mod totals;

use std::ops::Range;

use crate::kernels::crossover::{LawKernel, UnitCellParameters};
use crate::kernels::element_geometry::ElementGeometry;
pub use crate::kernels::kinematics::TINY;
use crate::kernels::membrane::{membrane, mode_force, trellis_shear};
use crate::kernels::prefetch;
use crate::kernels::shear::ShearConstants;
use crate::num::scalar::{Mask, Real, Scalar, each};
use elements::{Elements, Forces, Motion, YarnsLeft, drag, equilibrium};
use energies::energies;
use release::release;
pub use row::{ElementRow, Extent, field};
pub use totals::{ElementTotals, YarnFailure};
use totals::{RowLanes, RowSums};

/// Life of a yarn that is to break in this step.
pub const MARKED_FOR_FAILURE: f64 = 0.75;
/// Stands for the strain of a piece of yarn that is broken or absent.
pub const BROKEN: f64 = -1.0;

/// Stretch of a yarn below which it counts as folded: its element's trellis energy fades with the stretch, so that a crumpled
/// element keeps a bounded stiffness and a force that is the slope of an energy. Enters the step bound.
pub const FOLDED_STRETCH: f64 = 0.5;
/// Largest fade(Λ)/Λ: the lever of shear in a folded element over 1.
pub const LONGEST_LEVER: f64 = 1.125 / FOLDED_STRETCH;

/// Constants of the element kernel; lengths are those of the finest elements.
#[derive(Clone, Copy, Debug)]
pub struct ElementConstants<R> {
    /// Unit cell.
    pub cell: UnitCellParameters<R>,
    /// Trellis shear.
    pub shear: ShearConstants<R>,
    /// 1/(2·Lx), 1/(2·Ly) [1/m].
    pub gradient: [R; 2],
    /// Tension to force: (Ly/2)/(2·w02) and (Lx/2)/(2·w01) [-].
    pub membrane: [R; 2],
    /// Shear resultant to force: Ly/2, Lx/2 [m].
    pub half_length: [R; 2],
    /// Hourglass stiffness contributed by each yarn while both are alive [N/m].
    pub hourglass: [R; 2],
    /// Shock viscosity of warp and weft over the stiffness, q1·L/c with c the wave speed of the straight yarn in the fabric [s].
    pub viscosity: [R; 2],
    /// Length of an element along x and y above which the shock viscosity of smooth waves grows no more, over that of the finest [-].
    pub viscous_length: [R; 2],
    /// 1 over the stretch that a front adds while it crosses an element, and from which the viscosity of the whole length acts, over the
    /// coefficient of the viscosity [-].
    pub per_steep: R,
    /// What |q|² has in Λ² [-]: ⅓ where stretches are means over the element, 0 where they are those at its centre.
    pub mode_share: R,
    /// Crossovers per element, and element area [m²], for energies.
    pub cells: R,
    /// [m²]
    pub area: R,
}

impl<S: Scalar> ElementConstants<S> {
    /// The same constants in every lane of numbers like `n`.
    pub fn spread<R: Real<Scalar = S>>(&self, n: R) -> ElementConstants<R> {
        let all = |value: S| n.broadcast(value);
        ElementConstants {
            cell: self.cell.spread(n),
            shear: self.shear.spread(n),
            gradient: self.gradient.map(all),
            membrane: self.membrane.map(all),
            half_length: self.half_length.map(all),
            hourglass: self.hourglass.map(all),
            viscosity: self.viscosity.map(all),
            viscous_length: self.viscous_length.map(all),
            per_steep: all(self.per_steep),
            mode_share: all(self.mode_share),
            cells: all(self.cells),
            area: all(self.area),
        }
    }
}

/// Computes `range` of one row of elements, from the last multiple of `R::LANES` before it on: columns beyond it are at rest and stay
/// so, or are padding.
///
/// `dt` is the time since the forces in the row were computed [s] (0 at the start, when there are none).
#[inline(always)]
pub fn element_force<R: Real, L: LawKernel>(
    c: &ElementConstants<R>,
    row: &mut ElementRow<'_, R::Scalar>,
    range: Range<usize>,
    dt: f64,
    extent: Extent,
    totals: &mut ElementTotals,
) {
    let Extent { shear, ledger } = extent;
    let n = c.area;
    let step = n.splat_like(dt);
    let tall = ElementGeometry::of_row(c, if row.is_even() { 1.0 } else { row.height });
    let mut sums = RowSums::default();
    let mut lanes = RowLanes::new(n);
    let mut column = range.start - range.start % R::LANES;
    while column < range.end {
        let at = column + 1;
        ask_ahead::<R>(row, column);
        let motion = Motion::read(n, row, &tall, column);
        let life = each!(i in 2 => n.load(row.element[field::ALIVE + i], at));
        let [warp, weft] = YarnsLeft::were_alive(life);
        let both = warp & weft;
        let cell = equilibrium::<R, L>(c, row, &motion, both, at, step);
        let yarns = YarnsLeft::judge(c, &motion.k.extension, life);
        let strain = yarns.keep_strains(&mut row.strain, &cell, at);
        lanes.strain = each!(i in 2 => lanes.strain[i].max(strain[i]));
        let elastic = yarns.elastic(&cell);
        let mut viscous = [n.zero(); 2];
        if let Some(fields) = &mut row.viscous {
            let (force, energy) = drag(c, fields, &motion, &elastic, at, step);
            sums.dissipated.add(energy, column);
            viscous = force;
        }
        let pull = each!(i in 2 => elastic[i] + viscous[i]);
        let any_failed = yarns.any_failed().any();
        let trellis = shear.then(|| trellis_shear(&c.shear, &motion.k, ledger | any_failed));
        let both_left = yarns.both_left();
        let left = trellis.map(|trellis| trellis.only(both_left));
        let (warp, weft) = membrane(&motion.size, &motion.k, &pull, left.as_ref());
        let on_mode = mode_force(&motion.size, &motion.k, &elastic, left.as_ref());
        let forces = Forces { drag: viscous, trellis, membrane: [warp, weft], on_mode };
        let elements = Elements { column, motion, cell, yarns, forces };
        // Work done on the element between the last positions and these, by the trapezoidal rule.
        sums.work.add(n.splat_like(0.5 * dt) * elements.keep(row), column);

        let counted = n.within(column, &range);
        totals.unconverged += (both & !cell.converged).count();
        totals.solved += f64::from((both & counted).count());
        lanes.iterations = lanes.iterations + R::select(counted, cell.iterations, n.zero());
        lanes.residual = lanes.residual.max(cell.residual);
        if any_failed {
            release(c, row, &elements, dt, &mut sums, totals);
        }
        if ledger {
            energies(c, row, &elements, &mut sums, &mut lanes);
        }
        column += R::LANES;
    }
    sums.add_to(totals, ledger);
    lanes.add_to(totals);
}

/// Asks for what the next rows have in these columns.
#[inline(always)]
fn ask_ahead<R: Real>(row: &ElementRow<'_, R::Scalar>, column: usize) {
    let [elements, nodes] = row.prefetch;
    for line in prefetch::lines::<R::Scalar>(column..column + R::LANES) {
        prefetch::ask(row.element.iter().map(|field| &**field), line + 1, elements);
        prefetch::ask(row.above, line, nodes);
    }
}
