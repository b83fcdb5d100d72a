//! Element kernel: stretches, crossover equilibrium, shear, failure and corner forces of one row of elements.
//!
//! Forces are P1 = N1 e1 + (q/Λ1) n2 and P2 = N2 e2 + (q/Λ2) n1 with unit vectors n2 ⟂ e1 and n1 ⟂ e2 in the
//! element's plane. One-point quads get an hourglass stiffness in total form on ¼(x1 − x2 + x3 − x4).
//!
//! An element whose two yarns have failed carries nothing; with one yarn left the trellis is gone, so shear is
//! released with the first failure.

use std::ops::Range;

use crate::kernels::ahead;
use crate::kernels::crossover::{self, CellConstants, LawKernel};
use crate::kernels::element_size::Size;
use crate::kernels::guide::Guide;
use crate::kernels::kinematics::{Kinematics, Vector, differences, dot, kinematics, stretching};
use crate::kernels::shear::{self, ShearConstants};
use crate::number::{Mask, Real, Scalar, each};
use crate::tally::Tally;

/// Fields of an element row, in storage order.
pub mod field {
    /// P1·Ly/2 [N], three components.
    pub const WARP_FORCE: usize = 0;
    /// P2·Lx/2 [N], three components.
    pub const WEFT_FORCE: usize = 3;
    /// Hourglass force per corner [N], three components.
    pub const HOURGLASS: usize = 6;
    /// All forces.
    pub const FORCES: std::ops::Range<usize> = 0..9;
    /// What foretells the next heights: `fall` [m] of warp and weft, `share` [-] of both; see [`Guide`](super::Guide).
    pub const GUIDE: usize = 9;
    /// Yarn heights h1, h2 [m].
    pub const HEIGHT: usize = 13;
    /// 1 while the yarn carries load, [`BREAKING`](super::BREAKING) when it is about to fail, 0 once it did or where it is absent;
    /// warp, weft.
    pub const ALIVE: usize = 15;
    /// Number of fields.
    pub const COUNT: usize = 17;
    /// Further fields where failure is nonlocal: strains of warp and weft [-].
    pub const STRAINS: usize = 2;
}

/// Mark of a yarn that fails in the next step: nonlocal failure is judged when all elements are computed.
pub const BREAKING: f64 = 0.75;

/// Stretch below which the lever of shear is not shortened further, so that a collapsed, slack element keeps a
/// bounded stiffness. Enters the step bound.
pub const STRETCH_FLOOR: f64 = 0.3;
/// Cosine of the shear angle below which the plane of the yarns is no longer resolved.
pub const COSINE_FLOOR: f64 = 1e-3;

/// Constants of the element kernel; lengths are those of the finest elements.
#[derive(Clone, Copy, Debug)]
pub struct ElementConstants<R> {
    /// Unit cell.
    pub cell: CellConstants<R>,
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
    /// Crossovers per element, and element area [m²], for energies.
    pub cells: R,
    /// [m²]
    pub area: R,
}

impl<S: Scalar> ElementConstants<S> {
    /// The same constants in every lane of numbers like `n`.
    pub fn spread<R: Real<Scalar = S>>(&self, n: R) -> ElementConstants<R> {
        let all = |value: S| n.spread(value);
        ElementConstants {
            cell: self.cell.spread(n),
            shear: self.shear.spread(n),
            gradient: self.gradient.map(all),
            membrane: self.membrane.map(all),
            half_length: self.half_length.map(all),
            hourglass: self.hourglass.map(all),
            cells: all(self.cells),
            area: all(self.area),
        }
    }
}

/// Node rows below and above a row of elements, and the row's own storage.
pub struct ElementRow<'a, S> {
    /// Displacement x, y, z then velocity x, y, z of the row of nodes below.
    pub below: [&'a [S]; 6],
    /// The same above.
    pub above: [&'a [S]; 6],
    /// Element fields; column c is stored at c + 1 so that node c finds its left neighbour at c.
    pub element: [&'a mut [S]; field::COUNT],
    /// Where the strains of warp and weft go if failure is nonlocal, stored as the fields are.
    pub strain: Option<[&'a mut [S]; field::STRAINS]>,
    /// Height of the row, over that of a row of the finest elements [-].
    pub height: f64,
    /// Lengths of the elements along X over the finest, and 1 over that [-].
    pub width: &'a [S],
    /// See `width`.
    pub per_width: &'a [S],
    /// Viscosity along X of each element and along Y of the row, over the stiffness [s]; `None`: an even mesh has none.
    pub viscosity: Option<(&'a [S], f64)>,
    /// How many numbers further on the next row of elements has its fields, and the next row of nodes those of the one above.
    pub ahead: [usize; 2],
}

impl<S> ElementRow<'_, S> {
    /// Whether all elements of the ply are alike.
    #[inline(always)]
    fn is_even(&self) -> bool {
        self.width.is_empty()
    }
}

/// What of the kernel a step needs.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// The fabric resists trellis shear.
    pub shear: bool,
    /// The energies of the state are asked for.
    pub ledger: bool,
}

/// A yarn that failed in this step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Failure {
    /// Element column.
    pub column: u32,
    /// 0 warp, 1 weft.
    pub yarn: u8,
    /// Axial strain that broke it [-].
    pub strain: f64,
}

/// Sums of one row of elements over one step.
#[derive(Clone, Debug, Default)]
pub struct ElementTotals {
    /// Work of the membrane forces on the element since the last step [J].
    pub internal_work: f64,
    /// Energy released by failures in this step: membrane, hourglass [J].
    pub released: [f64; 2],
    /// Elastic energy stored now (state function) [J]; only in ledger steps.
    pub stored: f64,
    /// Hourglass energy now [J]; only in ledger steps.
    pub hourglass: f64,
    /// Unit-cell solves that did not meet the residual.
    pub unconverged: u32,
    /// Residual evaluations, and cells that needed any.
    pub iterations: f64,
    /// Cells solved.
    pub solved: f64,
    /// Largest residual [N].
    pub max_residual: f64,
    /// Largest yarn tension now [N]; only in ledger steps.
    pub max_tension: f64,
    /// Largest |z displacement| of a corner of a standing element [m]; only in ledger steps.
    pub max_deflection: f64,
    /// Largest strain of warp and weft [-]; only where failure is nonlocal.
    pub largest_strain: [f64; 2],
    /// Elements computed.
    pub computed: usize,
    /// Yarn failures in column order.
    pub failures: Vec<Failure>,
}

impl ElementTotals {
    /// Ready for the next step; keeps the capacity of the failure list.
    pub fn clear(&mut self) {
        let mut failures = std::mem::take(&mut self.failures);
        failures.clear();
        *self = Self { failures, ..Self::default() };
    }
}

/// P1·Ly/2 and P2·Lx/2 [N] from in-plane yarn forces and shear resultant.
#[inline(always)]
fn membrane<R: Real>(c: &Size<R>, k: &Kinematics<R>, pull: &[R; 2], q: R, shear: bool) -> (Vector<R>, Vector<R>) {
    let [e1, e2] = k.direction;
    let (n1, n2) = (pull[0] * c.membrane[0], pull[1] * c.membrane[1]);
    if !shear {
        return (each!(a in 3 => n1 * e1[a]), each!(a in 3 => n2 * e2[a]));
    }
    let n = q;
    let floor = n.with(COSINE_FLOOR * COSINE_FLOOR);
    let cosine = (-k.sine).fused(k.sine, n.one()).max(floor).sqrt();
    let most = n.with(1.0 / STRETCH_FLOOR);
    let q = q / cosine;
    let q1 = q * c.half_length[0] * k.per_stretch[0].min(most);
    let q2 = q * c.half_length[1] * k.per_stretch[1].min(most);
    (
        each!(a in 3 => n1.fused(e1[a], q1 * (-k.sine).fused(e1[a], e2[a]))),
        each!(a in 3 => n2.fused(e2[a], q2 * (-k.sine).fused(e2[a], e1[a]))),
    )
}

/// Viscous forces of warp and weft [N]: stiffness times `viscosity` [s] times the rate of stretch along the yarn. `v`: differences of
/// velocities over the element.
#[inline(always)]
fn drag<R: Real>(
    c: &ElementConstants<R>,
    size: &Size<R>,
    k: &Kinematics<R>,
    v: [&[R; 3]; 3],
    viscosity: [R; 2],
) -> [R; 2] {
    each!(i in 2 => {
        let e = &k.direction[i];
        let rate = (e[0] * v[0][i] + e[1] * v[1][i] + e[2] * v[2][i]) * size.gradient[i];
        c.cell.yarn[i].stiffness * viscosity[i] * rate
    })
}

/// In-plane force of a yarn with its viscous force: none where it is slack, and never one that pushes.
#[inline(always)]
fn viscous<R: Real>(force: R, drag: R) -> R {
    R::select(drag.abs().le(drag.zero()) | force.le(drag.zero()), force, (force + drag).max(drag.zero()))
}

/// Energy of one element [J]: yarns, crossover compression, shear.
#[inline(always)]
fn stored_energy<R: Real>(
    cell: &CellConstants<R>,
    size: &Size<R>,
    tension: &[R; 2],
    strain: &[R; 2],
    force: R,
    shear: R,
) -> R {
    let yarn = each!(i in 2 => {
        let y = &cell.yarn[i];
        tension[i] * strain[i] * y.half_span * (tension[i].one() + y.crimp)
    });
    size.cells * (yarn[0] + yarn[1] + crossover::compression_energy(cell, force)) + size.area * shear
}

/// A field of the nodes at the corners of elements from `column` on, counter-clockwise.
#[inline(always)]
fn corners<R: Real>(n: R, row: &ElementRow<'_, R::Scalar>, field: usize, column: usize) -> [R; 4] {
    let (below, above) = (row.below[field], row.above[field]);
    [n.load(below, column), n.load(below, column + 1), n.load(above, column + 1), n.load(above, column)]
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
    let zero = n.zero();
    let half_dt = n.with(0.5 * dt);
    let graded = !row.is_even();
    let tall = Size::of_row(c, if graded { row.height } else { 1.0 });
    let mut work = Tally::default();
    let mut stored = Tally::default();
    let mut hourglass = Tally::default();
    // Whole numbers add up exactly in any order.
    let mut iterations = zero;
    let mut released = [Tally::default(); 2];
    let mut largest_strain = [zero; 2];
    let (mut residual, mut largest, mut deflection) = (zero, zero, zero);
    let mut column = range.start - range.start % R::LANES;
    while column < range.end {
        let at = column + 1;
        for line in ahead::lines::<R::Scalar>(column..column + R::LANES) {
            let [elements, nodes] = row.ahead;
            ahead::ask(row.element.iter().map(|field| &**field), line + 1, elements);
            ahead::ask(row.above, line, nodes);
        }
        let [ux, uy, uz] = each!(f in 3 => differences(&corners(n, row, f, column)));
        let [vx, vy, vz] = each!(f in 3 => differences(&corners(n, row, 3 + f, column)));
        let size =
            if graded { tall.of_columns(n.load(row.width, column), n.load(row.per_width, column)) } else { tall };
        let k = kinematics(&size, &[ux[0], uy[0], uz[0]], &[ux[1], uy[1], uz[1]]);

        let half = n.with(0.5);
        let life = each!(i in 2 => n.load(row.element[field::ALIVE + i], at));
        let was_alive = each!(i in 2 => half.lt(life[i]));
        let both = was_alive[0] & was_alive[1];
        let any = was_alive[0] | was_alive[1];
        let warm = each!(i in 2 => n.load(row.element[field::HEIGHT + i], at));
        let guide = Guide {
            fall: each!(i in 2 => n.load(row.element[field::GUIDE + i], at)),
            share: each!(i in 2 => n.load(row.element[field::GUIDE + 2 + i], at)),
        };
        let warm = guide.heights(warm, stretching(&size, &k, [&vx, &vy, &vz], n.with(dt)));
        let cell = crossover::solve::<R, L>(&c.cell, k.stretch, warm, both);
        for i in 0..2 {
            cell.guide.fall[i].store(row.element[field::GUIDE + i], at);
            cell.guide.share[i].store(row.element[field::GUIDE + 2 + i], at);
        }

        let failed = each!(i in 2 => {
            was_alive[i] & (c.cell.yarn[i].failure_strain.le(cell.strain[i]) | life[i].le(n.with(BREAKING)))
        });
        if let Some(strains) = &mut row.strain {
            for i in 0..2 {
                let strain = R::select(was_alive[i], cell.strain[i], zero);
                strain.store(strains[i], at);
                largest_strain[i] = largest_strain[i].max(strain);
            }
        }
        let alive = [was_alive[0] & !failed[0], was_alive[1] & !failed[1]];
        let both_left = alive[0] & alive[1];
        let any_failed = failed[0] | failed[1];
        let straight = each!(i in 2 => c.cell.yarn[i].straight(k.stretch[i]));
        let free_strain = each!(i in 2 => straight[i].max(zero));
        let free = each!(i in 2 => c.cell.yarn[i].tension(straight[i]));
        let mut pull = each!(i in 2 => R::select(both_left, cell.in_plane[i], free[i]));
        let mut intact = cell.in_plane;
        if let Some((along, across)) = row.viscosity {
            let drag = drag(c, &size, &k, [&vx, &vy, &vz], [n.load(along, column), n.with(across)]);
            pull = each!(i in 2 => viscous(pull[i], drag[i]));
            intact = each!(i in 2 => viscous(intact[i], drag[i]));
        }
        let pull = each!(i in 2 => R::select(alive[i], pull[i], zero));

        let gamma = if shear { shear::arc_sine(k.sine) } else { zero };
        let trellis = if shear { shear::resultant(&c.shear, gamma) } else { zero };
        let q = R::select(both_left, trellis, zero);
        let (warp, weft) = membrane(&size, &k, &pull, q, shear);

        // Work done on the element between the last positions and these (trapezoid), and the new forces.
        let mut power = zero;
        let v = [vx, vy, vz];
        for a in 0..3 {
            let warp_new = R::select(any, warp[a], zero);
            let weft_new = R::select(any, weft[a], zero);
            let warp_sum = n.load(row.element[field::WARP_FORCE + a], at) + warp_new;
            let weft_sum = n.load(row.element[field::WEFT_FORCE + a], at) + weft_new;
            power = weft_sum.fused(v[a][1], warp_sum.fused(v[a][0], power));
            warp_new.store(row.element[field::WARP_FORCE + a], at);
            weft_new.store(row.element[field::WEFT_FORCE + a], at);
        }
        work.add(half_dt * power, column);

        let stiffness = size.hourglass[0] + size.hourglass[1];
        let quarter = n.with(0.25);
        let mode = [quarter * ux[2], quarter * uy[2], quarter * uz[2]];
        let kh = R::select(both_left, stiffness, zero);
        for a in 0..3 {
            let force = R::select(any, quarter * kh * mode[a], zero);
            force.store(row.element[field::HOURGLASS + a], at);
        }

        R::select(any, cell.height[0], zero).store(row.element[field::HEIGHT], at);
        R::select(any, cell.height[1], zero).store(row.element[field::HEIGHT + 1], at);
        let counted = n.within(column, &range);
        totals.unconverged += (both & !cell.converged).count();
        totals.solved += f64::from((both & counted).count());
        iterations = iterations + R::select(counted, cell.iterations, zero);
        residual = residual.max(cell.residual);

        if any_failed.any() {
            let shear_energy = if shear { shear::energy(&c.shear, gamma) } else { zero };
            let shear_before = R::select(both, shear_energy, zero);
            let tension = each!(i in 2 => R::select(was_alive[i], cell.tension[i], zero));
            let before = stored_energy(&c.cell, &size, &tension, &cell.strain, cell.force, shear_before);
            let left = each!(i in 2 => R::select(alive[i], free[i], zero));
            let after = stored_energy(&c.cell, &size, &left, &free_strain, zero, zero);
            // Forces that break in this step never act, so the last half step's work on them was not done either.
            let intact = each!(i in 2 => R::select(was_alive[i], intact[i], zero));
            let (warp_intact, weft_intact) = membrane(&size, &k, &intact, R::select(both, trellis, zero), shear);
            let mut undone = zero;
            for a in 0..3 {
                undone = undone + (warp_intact[a] - warp[a]) * v[a][0] + (weft_intact[a] - weft[a]) * v[a][1];
            }
            let loss = before - after - half_dt * undone;
            released[0].add(R::select(any_failed, loss, zero), column);
            // The part of the hourglass work that the state function ½k|q|² does not hold once k dropped.
            let last = each!(a in 3 => quarter * v[a][2] * n.with(dt));
            let product = mode[0] * (mode[0] - last[0]) + mode[1] * (mode[1] - last[1]) + mode[2] * (mode[2] - last[2]);
            let drop = half * (R::select(both, stiffness, zero) - kh) * product;
            released[1].add(R::select(any_failed, drop, zero), column);
            for lane in 0..R::LANES {
                for yarn in 0..2 {
                    if failed[yarn].lane(lane) {
                        row.element[field::ALIVE + yarn][at + lane] = R::Scalar::splat(0.0);
                        totals.failures.push(Failure {
                            column: (column + lane) as u32,
                            yarn: yarn as u8,
                            strain: cell.strain[yarn].lane(lane).to_f64(),
                        });
                    }
                }
            }
        }

        if ledger {
            let tension = each!(i in 2 => R::select(alive[i], R::select(both_left, cell.tension[i], free[i]), zero));
            let strain = each!(i in 2 => R::select(both_left, cell.strain[i], free_strain[i]));
            let force = R::select(both_left, cell.force, zero);
            let shear_energy = if shear { shear::energy(&c.shear, gamma) } else { zero };
            let shear_energy = R::select(both_left, shear_energy, zero);
            let energy = stored_energy(&c.cell, &size, &tension, &strain, force, shear_energy);
            stored.add(R::select(any, energy, zero), column);
            hourglass.add(R::select(any, half * kh * dot(&mode, &mode), zero), column);
            largest = largest.max(tension[0].max(tension[1]));
            let [p, q, r, s] = corners(n, row, 2, column);
            deflection = deflection.max(R::select(any, p.abs().max(q.abs()).max(r.abs().max(s.abs())), zero));
        }
        column += R::LANES;
    }
    totals.max_residual = totals.max_residual.max(residual.largest());
    totals.max_tension = totals.max_tension.max(largest.largest());
    for i in 0..2 {
        totals.largest_strain[i] = totals.largest_strain[i].max(largest_strain[i].largest());
    }
    totals.max_deflection = totals.max_deflection.max(deflection.largest());
    totals.internal_work += work.total();
    totals.iterations += (0..R::LANES).map(|lane| iterations.lane(lane).to_f64()).sum::<f64>();
    if !totals.failures.is_empty() {
        totals.released = each!(i in 2 => released[i].total());
    }
    if ledger {
        totals.stored += stored.total();
        totals.hourglass += hourglass.total();
    }
}
