//! The unit cell: equilibrium of warp and weft where they cross, (11)–(24).
//!
//! For given stretches the two heights are tied by compatibility (22) and the two contact forces by equilibrium
//! (16). With one height x as the only unknown the residual r(x) = F_p(x) − F_o(H − d(F_p) − x) never decreases
//! on [0, H], so a bracketed Newton iteration cannot fail. The unknown is the height of the softer
//! yarn ("pivot"), which keeps the other yarn's height well conditioned when one yarn is much stiffer.
//!
//! Heights in metres, forces in newtons; the stretch enters as Λ − 1 so that single precision keeps small strains.

use crate::num::scalar::{Mask, Real, each};
use crate::physics::coupled_newton::{self, Predictor};

pub use crate::physics::unit_cell_parameters::UnitCellParameters;
pub use crate::physics::yarn_law::{LawKernel, Sinusoidal, StretchResponse, YarnConstants, YarnResponse};

/// Newton steps allowed; bisection alone needs about 55 in double precision.
pub const MAX_ITERATIONS: u32 = 80;

/// More than any residual, before there is one [N].
const UNKNOWN: f64 = 1e30;

/// Steps allowed where the height of the other yarn alone meets the force.
pub const REFINEMENTS: u32 = 8;

/// Equilibrium of one cell.
#[derive(Clone, Copy, Debug)]
pub struct Equilibrium<R: Real> {
    /// Tensions [N], warp and weft.
    pub tension: [R; 2],
    /// In-plane forces [N], warp and weft.
    pub in_plane: [R; 2],
    /// Axial strains [-], warp and weft.
    pub strain: [R; 2],
    /// Heights [m], warp and weft; where nothing presses, the last ones found.
    pub height: [R; 2],
    /// Predictor of the heights.
    pub predictor: Predictor<R>,
    /// Contact force F [N].
    pub force: R,
    /// Difference of the yarns' contact forces at the end [N].
    pub residual: R,
    /// Evaluations of the residual.
    pub iterations: R,
    /// True where the residual was met.
    pub converged: R::Mask,
}

/// Transverse compression d(F) (21), regularised: 0 at F = 0, (21) for large F; and its derivative [m], [m/N].
/// The negative forces of slack yarns compress nothing.
#[inline(always)]
pub fn compression<R: Real>(cell: &UnitCellParameters<R>, force: R) -> (R, R) {
    let [a, b, offset] = cell.compression;
    let zero = force.zero();
    let rigid = a.le(zero);
    let sum = R::select(rigid, force.one(), zero.max(force) + offset);
    let root = sum.inverse_cube_root();
    let left = b * root;
    let derivative = left * force.splat_like(1.0 / 3.0) * (root * root * root);
    let none = rigid | force.le(zero);
    (R::select(none, zero, a - left), R::select(none, zero, derivative))
}

/// Energy stored in the crossover by compression to d [J]: ∫F dd of the regularised (21).
#[inline(always)]
pub fn compression_energy<R: Real>(cell: &UnitCellParameters<R>, force: R) -> R {
    let [a, b, offset] = cell.compression;
    let n = force;
    let rigid = a.le(n.zero());
    let one = n.one();
    let safe_a = R::select(rigid, one, a);
    // a − d = b/∛(F + (b/a)³)
    let root = R::select(rigid, one, n.zero().max(force) + offset).inverse_cube_root();
    let left = R::select(rigid, one, b) * root;
    let d = a - left;
    let cube = b * b * b;
    let half = n.splat_like(0.5);
    let energy = cube * (half * (one / left.squared() - one / safe_a.squared()) - d / (safe_a * safe_a * safe_a));
    R::select(rigid | force.le(n.zero()), n.zero(), energy)
}

/// Energy stored in a cell [J]: yarns at their tensions [N] and strains [-], and the crossover under its contact force [N].
#[inline(always)]
pub(crate) fn cell_energy<R: Real>(cell: &UnitCellParameters<R>, tension: &[R; 2], strain: &[R; 2], force: R) -> R {
    let yarn = each!(i in 2 => {
        let y = &cell.yarn[i];
        y.twice_energy(tension[i], strain[i]) * y.half_span * (tension[i].one() + y.crimp)
    });
    yarn[0] + yarn[1] + compression_energy(cell, force)
}

/// Solves the cell for the stretches Λ_i = 1 + `stretch[i]`, from the heights `warm` of the last step.
///
/// `both` is true where both yarns are alive and present; elsewhere each yarn straightens freely.
#[inline(always)]
pub fn solve<R: Real, L: LawKernel>(
    cell: &UnitCellParameters<R>,
    stretch: [R; 2],
    warm: [R; 2],
    both: R::Mask,
) -> Equilibrium<R> {
    let n = cell.height_sum;
    let zero = n.zero();
    let (p, o) = (cell.pivot, 1 - cell.pivot);
    let top = cell.height_sum;
    // Cells that cannot press are solved at F = 0 by the straight-yarn branch below.
    let pressing = both & zero.lt(top);
    let span = each!(i in 2 => L::span(&cell.yarn[i], stretch[i]));
    let start = [zero.max(warm[p]).min(top), zero.max(warm[o]).min(top)];
    let newton = coupled_newton::iterate::<R, L>(cell, &span, start, pressing);
    let met = pressing & newton.met;
    let mut active = pressing & !newton.met;
    let mut x = R::select(active, start[0], newton.height[0]);
    let mut iterations = newton.iterations;
    let mut predictor = Predictor { dh_dstretch: [zero; 2], force_share: [zero; 2] };
    for (at, i) in [p, o].into_iter().enumerate() {
        predictor.dh_dstretch[i] = R::select(met, newton.predictor.dh_dstretch[at], zero);
        predictor.force_share[i] = R::select(met, newton.predictor.force_share[at], zero);
    }
    let residual = newton.yarn[0].force - newton.yarn[1].force;
    let [pivot, other] = newton.yarn;
    let mut best = CellPoint { pivot, other, other_height: newton.height[1], residual, slope: n.one() };
    if active.any() {
        // Copies: what a call sees by reference would lie in memory in the fast path too.
        let (responses, mut open, mut count) = (span, active, iterations);
        (x, best) = fall_back::<R, L>(cell, &responses, (x, best), &mut open, &mut count);
        (active, iterations) = (open, count);
    }
    let force = best.pivot.real_force();
    let residual = (force - best.other.real_force()).abs() + newton.bound;
    let straight = each!(i in 2 => cell.yarn[i].straight(stretch[i]));
    let mut out = Equilibrium {
        tension: [zero; 2],
        in_plane: [zero; 2],
        strain: straight,
        height: [zero; 2],
        predictor,
        force: R::select(pressing, force, zero),
        residual: R::select(pressing, residual, zero),
        iterations,
        converged: !active,
    };
    out.height[p] = R::select(pressing, x, zero);
    out.height[o] = R::select(pressing, best.other_height, zero);
    out.strain[p] = R::select(pressing, best.pivot.strain, straight[p]);
    out.strain[o] = R::select(pressing, best.other.strain, straight[o]);
    for i in 0..2 {
        let y = &cell.yarn[i];
        out.tension[i] = y.tension(out.strain[i]);
        out.in_plane[i] = out.tension[i] * R::select(pressing, L::in_plane_factor(y, &span[i], out.height[i]), n.one());
    }
    out
}

/// Safeguarded iteration out of line: few cells ever need it, and the fast path is smaller without it.
#[cold]
#[inline(never)]
fn fall_back<R: Real, L: LawKernel>(
    cell: &UnitCellParameters<R>,
    span: &[StretchResponse<R>; 2],
    (start, best): (R, CellPoint<R>),
    active: &mut R::Mask,
    iterations: &mut R,
) -> (R, CellPoint<R>) {
    cell.height_sum.vectorize(
        #[inline(always)]
        || safeguarded::<R, L>(cell, span, start, best, active, iterations),
    )
}

/// Solves the cells of `active` by the safeguarded iteration, the pivot's height from `x`; the rest keep what is `best`.
#[inline(always)]
fn safeguarded<R: Real, L: LawKernel>(
    cell: &UnitCellParameters<R>,
    span: &[StretchResponse<R>; 2],
    start: R,
    mut best: CellPoint<R>,
    active: &mut R::Mask,
    iterations: &mut R,
) -> (R, CellPoint<R>) {
    let n = cell.height_sum;
    let (zero, top) = (n.zero(), cell.height_sum);
    let rough = *active;
    let mut x = start;
    let (mut low, mut high) = (zero, top);
    // Ends of the bracket are known signs, not evaluated points, until the iteration goes there.
    let (mut low_seen, mut high_seen) = (n.never(), n.never());
    let mut last = n.splat_like(UNKNOWN);
    best = CellPoint::select(*active, CellPoint::at::<L>(cell, span, x), best);
    *iterations = *iterations + R::select(*active, n.one(), zero);
    for _ in 0..MAX_ITERATIONS {
        let size = best.residual.abs();
        let resolved = (high - low).abs().le(n.splat_like(2.0 * R::EPSILON) * high);
        let limit = cell.accepted(best.pivot.force);
        *active = *active & !(size.le(limit) | resolved | best.slack());
        if !active.any() {
            break;
        }
        let above = zero.lt(best.residual);
        high = R::select(*active & above, x, high);
        high_seen = high_seen | (*active & above);
        low = R::select(*active & !above, x, low);
        low_seen = low_seen | (*active & !above);
        // A step that did not halve the residual is followed by a bisection, or by a look at the end not seen yet.
        let slow = (n.splat_like(0.5) * last).lt(size);
        last = size;
        let newton = x - best.residual / R::select(zero.lt(best.slope), best.slope, n.one());
        let flat = best.slope.le(zero);
        let newton = R::select(flat, R::select(above, low, high), newton);
        let middle = n.splat_like(0.5) * (low + high);
        let below_end = newton.le(low);
        let above_end = high.le(newton);
        let newton = R::select(below_end, R::select(low_seen, middle, low), newton);
        let newton = R::select(above_end, R::select(high_seen, middle, high), newton);
        let roundoff = R::select(above, R::select(low_seen, middle, low), R::select(high_seen, middle, high));
        let next = R::select(slow, roundoff, newton);
        x = R::select(*active, next, x);
        best = CellPoint::select(*active, CellPoint::at::<L>(cell, span, x), best);
        *iterations = *iterations + R::select(*active, n.one(), zero);
    }
    (x, refine::<R, L>(cell, span, x, rough, best))
}

/// Lets the other yarn's height meet the force where the unknown's own resolution is too coarse for it.
///
/// A stiff crossover in single precision can use up the digits of x before the residual is met. Compatibility (22)
/// then holds to a rounding of the heights either way, and equilibrium (16) is what forces depend on.
#[inline(always)]
fn refine<R: Real, L: LawKernel>(
    cell: &UnitCellParameters<R>,
    span: &[StretchResponse<R>; 2],
    x: R,
    pressing: R::Mask,
    mut best: CellPoint<R>,
) -> CellPoint<R> {
    let o = 1 - cell.pivot;
    // Without compression: the root lies below. A slack yarn that is nearly flat hardly rises, and its steps go far beyond.
    let highest = cell.height_sum - x;
    let n = cell.height_sum;
    let zero = n.zero();
    let mut trial = best;
    for _ in 0..REFINEMENTS {
        let limit = cell.accepted(trial.pivot.force);
        let rises = zero.lt(trial.other.stiffness);
        // A pivot slack by a rounding has lost the force the other yarn still has.
        let lost = trial.pivot.strain.le(zero) & zero.lt(trial.other.force);
        let met = trial.residual.abs().le(limit) | trial.slack();
        let rough = pressing & !met & (zero.lt(trial.pivot.force) | lost) & rises;
        if !rough.any() {
            break;
        }
        let slope = R::select(rises, trial.other.stiffness, n.one());
        let other_height = (trial.other_height + trial.residual / slope).min(highest);
        let other = L::respond(&cell.yarn[o], &span[o], other_height);
        let residual = trial.pivot.force - other.force;
        let point = CellPoint { other, other_height, residual, ..trial };
        trial = CellPoint::select(rough, point, trial);
        // The first step may leave a yarn slack, further off than before: the next one brings it back.
        let better = rough & residual.abs().lt(best.residual.abs());
        best = CellPoint::select(better, point, best);
    }
    best
}

/// The residual and what it is made of at one trial height.
#[derive(Clone, Copy)]
struct CellPoint<R: Real> {
    pivot: YarnResponse<R>,
    other: YarnResponse<R>,
    other_height: R,
    /// r with the continued forces [N].
    residual: R,
    /// dr/dx [N/m].
    slope: R,
}

impl<R: Real> CellPoint<R> {
    #[inline(always)]
    fn at<L: LawKernel>(cell: &UnitCellParameters<R>, span: &[StretchResponse<R>; 2], x: R) -> Self {
        let (p, o) = (cell.pivot, 1 - cell.pivot);
        let pivot = L::respond(&cell.yarn[p], &span[p], x);
        let (d, dd) = compression(cell, pivot.force);
        let other_height = cell.height_sum - d - x;
        let other = L::respond(&cell.yarn[o], &span[o], other_height);
        Self {
            pivot,
            other,
            other_height,
            residual: pivot.force - other.force,
            slope: pivot.stiffness + other.stiffness * (x.one() + dd * pivot.stiffness),
        }
    }

    /// Both yarns slack: nothing presses, whatever the heights.
    #[inline(always)]
    fn slack(&self) -> R::Mask {
        let zero = self.residual.zero();
        self.pivot.strain.le(zero) & self.other.strain.le(zero)
    }

    #[inline(always)]
    fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        Self {
            pivot: YarnResponse::select(mask, yes.pivot, no.pivot),
            other: YarnResponse::select(mask, yes.other, no.other),
            other_height: R::select(mask, yes.other_height, no.other_height),
            residual: R::select(mask, yes.residual, no.residual),
            slope: R::select(mask, yes.slope, no.slope),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{self, Compression, Law};
    use crate::physics::projectile_shape::tests::Numbers;

    /// A cell with yarns and crossover at random, and its law.
    struct Random {
        numbers: Numbers,
        fabric: case::Fabric,
    }

    impl Random {
        fn between(&mut self, low: f64, high: f64) -> f64 {
            low + (high - low) * (self.numbers.unit() + 1.0) / 2.0
        }

        fn cell(&mut self, at: usize) -> UnitCellParameters<f64> {
            let mut fabric = self.fabric.clone();
            fabric.crossover.law = [Law::Published, Law::Variational][at % 2];
            for yarn in [&mut fabric.warp, &mut fabric.weft] {
                yarn.modulus *= self.between(0.3, 3.0);
                yarn.crimp = self.between(0.005, 0.1);
                yarn.count *= self.between(0.7, 1.4);
            }
            let a = self.between(2e-5, 2e-4);
            let compression = Compression { a, b: a * self.between(0.3, 3.0) };
            fabric.crossover.compression = (!(at / 4).is_multiple_of(3)).then_some(compression);
            UnitCellParameters::new(&fabric)
        }
    }

    /// Contact force by halving the range of the pivot's height: 0 where both yarns are slack.
    fn by_bisection(cell: &UnitCellParameters<f64>, stretch: [f64; 2]) -> f64 {
        let (p, o) = (cell.pivot, 1 - cell.pivot);
        let (mut low, mut high) = (0.0, cell.height_sum);
        let respond = |yarn: usize, height: f64| Sinusoidal::yarn(&cell.yarn[yarn], stretch[yarn], height);
        for _ in 0..100 {
            let x = 0.5 * (low + high);
            let pivot = respond(p, x);
            let [a, b, offset] = cell.compression;
            let d = if a > 0.0 && pivot.force > 0.0 { a - b / (pivot.force + offset).cbrt() } else { 0.0 };
            if pivot.force > respond(o, cell.height_sum - d - x).force { high = x } else { low = x }
        }
        respond(p, 0.5 * (low + high)).force.max(0.0)
    }

    /// Heights, contact force and residual by the safeguarded iteration alone, which [`solve`] takes where the fast one fails.
    fn by_safeguarded(cell: &UnitCellParameters<f64>, stretch: [f64; 2], warm: [f64; 2]) -> ([f64; 2], f64, f64) {
        let span = [0, 1].map(|i: usize| Sinusoidal::span(&cell.yarn[i], stretch[i]));
        let (mut active, mut iterations) = (true, 0.0);
        let start = warm[cell.pivot].clamp(0.0, cell.height_sum);
        let best = CellPoint::at::<Sinusoidal>(cell, &span, start);
        let (x, best) = safeguarded::<f64, Sinusoidal>(cell, &span, start, best, &mut active, &mut iterations);
        assert!(!active, "{stretch:?} from {warm:?} does not converge");
        let mut height = [x; 2];
        height[1 - cell.pivot] = best.other_height;
        let force = best.pivot.real_force();
        (height, force, (force - best.other.real_force()).abs())
    }

    /// From the last heights of slightly other stretches, or from anywhere.
    #[test]
    fn the_safeguarded_iteration_finds_the_force_that_bisection_finds_and_is_off_by_what_it_says() {
        for near in [true, false] {
            let mut random = Random { numbers: Numbers(51), fabric: case::shipped(&[]).fabric };
            for at in 0..3000 {
                let cell = random.cell(at);
                let stretch = [0, 1].map(|_| random.between(-0.01, 0.06));
                let anywhere = [0, 1].map(|_| random.between(-0.1, 1.1) * cell.height_sum);
                let moved = stretch.map(|s| s + random.between(-1e-4, 1e-4));
                let warm = if near { by_safeguarded(&cell, moved, anywhere).0 } else { anywhere };
                let (height, got, residual) = by_safeguarded(&cell, stretch, warm);
                let force = by_bisection(&cell, stretch);
                let stiff = cell.yarn[0].stiffness.max(cell.yarn[1].stiffness);
                assert!((got - force).abs() < 1e-12 * stiff, "{got} for {force}");
                if force > 0.0 {
                    // Compatibility (22), to a billionth of a thousandth of the heights; equilibrium (16), to what a force rounds to.
                    let sum = height[0] + height[1] + compression(&cell, got).0;
                    assert!((sum / cell.height_sum - 1.0).abs() < 1.001e-12, "{height:?} at {got}");
                    let accepted = 1.001 * cell.accepted(got);
                    let there = [0, 1].map(|i| Sinusoidal::yarn(&cell.yarn[i], stretch[i], height[i]).real_force());
                    assert!(there.iter().all(|yarn| (yarn - got).abs() < accepted), "{got} {there:?}");
                    assert!((0.0..accepted).contains(&residual), "{got}: {residual}");
                }
            }
        }
    }
}
