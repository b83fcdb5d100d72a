//! The unit cell: equilibrium of warp and weft where they cross, (11)–(24).
//!
//! For given stretches the two heights are tied by compatibility (22) and the two contact forces by equilibrium
//! (16). With one height x as the only unknown the residual r(x) = F_p(x) − F_o(H − d(F_p) − x) never decreases
//! on [0, H], so a bracketed Newton iteration cannot fail (model.md §2). The unknown is the height of the softer
//! yarn ("pivot"), which keeps the other yarn's height well conditioned when one yarn is much stiffer.
//!
//! Heights in metres, forces in newtons; the stretch enters as Λ − 1 so that single precision keeps small strains.

use crate::case::{Fabric, Law, MembraneForce};
use crate::kernels::arc_length::{MAX_TERMS, arc_length, terms_for};
use crate::number::{Mask, Real};

/// Newton steps allowed; bisection alone needs about 55 in double precision.
pub const MAX_ITERATIONS: u32 = 80;

/// Span or leg over its rest length below which a collapsed cell is not followed: slack, but finite.
const SHORTEST: f64 = 1e-9;

/// Constants of one yarn in the cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct YarnConstants<R> {
    /// Axial stiffness E·A [N]; zero when the yarn is absent.
    pub stiffness: R,
    /// Half-span w0 [m].
    pub half_span: R,
    /// Crimp as this number type sees it, S0/(2w0) − 1 [-].
    pub crimp: R,
    /// Height h0 of the centreline at rest [m].
    pub height: R,
    /// Failure strain [-].
    pub failure_strain: R,
    /// Slope of the continuation of the contact force to slack yarns, dF/dε [N]; see [`YarnResponse::force`].
    pub slack: R,
    /// Terms of the arc length series that matter while this yarn can be taut.
    pub terms: usize,
}

/// Constants of the unit cell, rounded to the number type that uses them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellConstants<R> {
    /// Warp, weft.
    pub yarn: [YarnConstants<R>; 2],
    /// H = h01 + h02 − g, the sum of heights at zero contact force, at least 0 [m].
    pub height_sum: R,
    /// Compression constants a [m], b [m·N^(1/3)], (b/a)³ [N]; all zero when rigid.
    pub compression: [R; 3],
    /// Index of the yarn whose height is the unknown: the softer one.
    pub pivot: usize,
    /// Residual accepted by the iteration [N].
    pub tolerance: R,
}

/// Which formulas a law uses; resolved at compile time.
pub trait LawKernel: Copy + Send + Sync + 'static {
    /// Tension, contact force and their derivatives of one yarn at stretch Λ = 1 + `stretch` and height `h`.
    fn yarn<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> YarnResponse<R>;
    /// In-plane force over tension.
    fn in_plane_factor<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> R;
}

/// Response of one yarn at a given height.
#[derive(Clone, Copy, Debug)]
pub struct YarnResponse<R> {
    /// Axial strain S/S0 − 1 [-] (17).
    pub strain: R,
    /// Tension T ≥ 0 [N].
    pub tension: R,
    /// Contact force F [N], odd in h (18); of a slack yarn, which presses with nothing, a negative continuation that
    /// keeps growing with h. Newton steps over onsets of tension with it instead of bouncing between them.
    pub force: R,
    /// dF/dh of `force` [N/m].
    pub stiffness: R,
}

impl<R: Real> YarnResponse<R> {
    /// The contact force without its continuation: 0 where the yarn is slack.
    #[inline(always)]
    fn real_force(&self) -> R {
        R::select(R::zero().lt(self.strain), self.force, R::zero())
    }
}

/// The paper's law with the tension itself as in-plane force.
#[derive(Clone, Copy, Debug)]
pub struct PublishedTension;
/// The paper's law with T cos α as in-plane force.
#[derive(Clone, Copy, Debug)]
pub struct PublishedProjected;
/// Forces conjugate to the arc length.
#[derive(Clone, Copy, Debug)]
pub struct Variational;
/// Kawabata's saw-tooth cell.
#[derive(Clone, Copy, Debug)]
pub struct Kawabata;

/// State of the sinusoidal yarn shared by the published and variational laws.
struct Sinusoid<R: Real> {
    arc: crate::kernels::arc_length::ArcLength<R>,
    k: R,
    /// dk/dh [1/m].
    dk: R,
    strain: R,
    tension: R,
    taut: R::Mask,
    /// dε/dh [1/m].
    dstrain: R,
}

#[inline(always)]
fn sinusoid<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> Sinusoid<R> {
    let one = R::one();
    let length = (one + stretch).max(R::splat(SHORTEST));
    let dk = R::splat(std::f64::consts::FRAC_PI_2) / (yarn.half_span * length);
    let k = h * dk;
    let arc = arc_length(k, yarn.terms);
    let per_length = one / (one + yarn.crimp);
    let strain = (stretch + length * arc.excess - yarn.crimp) * per_length;
    let taut = R::zero().lt(strain);
    let tension = R::select(taut, yarn.stiffness * strain, R::zero());
    let dstrain = length * arc.slope * dk * per_length;
    Sinusoid { arc, k, dk, strain, tension, taut, dstrain }
}

impl<R: Real> Sinusoid<R> {
    /// The response with the contact force of a taut yarn, continued to slack ones.
    #[inline(always)]
    fn response(&self, yarn: &YarnConstants<R>, force: R, stiffness: R) -> YarnResponse<R> {
        YarnResponse {
            strain: self.strain,
            tension: self.tension,
            force: R::select(self.taut, force, yarn.slack * self.strain),
            stiffness: R::select(self.taut, stiffness, yarn.slack * self.dstrain),
        }
    }
}

#[inline(always)]
fn published_yarn<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> YarnResponse<R> {
    let s = sinusoid(yarn, stretch, h);
    let cosine = R::one() / s.arc.secant;
    let twice = R::splat(2.0) * cosine;
    let force = twice * s.tension * s.k;
    let stiffness = twice * (yarn.stiffness * s.dstrain * s.k + s.tension * cosine.squared() * s.dk);
    s.response(yarn, force, stiffness)
}

impl LawKernel for PublishedTension {
    #[inline(always)]
    fn yarn<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> YarnResponse<R> {
        published_yarn(yarn, stretch, h)
    }
    #[inline(always)]
    fn in_plane_factor<R: Real>(_: &YarnConstants<R>, _: R, _: R) -> R {
        R::one()
    }
}

impl LawKernel for PublishedProjected {
    #[inline(always)]
    fn yarn<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> YarnResponse<R> {
        published_yarn(yarn, stretch, h)
    }
    #[inline(always)]
    fn in_plane_factor<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> R {
        R::one() / sinusoid(yarn, stretch, h).arc.secant
    }
}

impl LawKernel for Variational {
    #[inline(always)]
    fn yarn<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> YarnResponse<R> {
        let s = sinusoid(yarn, stretch, h);
        let pi = R::splat(std::f64::consts::PI);
        let force = pi * s.arc.slope * s.tension;
        let growth = yarn.stiffness * s.dstrain;
        let stiffness = pi * (s.arc.curvature * s.dk * s.tension + s.arc.slope * growth);
        s.response(yarn, force, stiffness)
    }
    #[inline(always)]
    fn in_plane_factor<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> R {
        let s = sinusoid(yarn, stretch, h);
        R::one() + s.arc.excess - s.k * s.arc.slope
    }
}

/// Leg length l/w0 − 1 and l/w0 of the saw-tooth.
#[inline(always)]
fn leg<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> (R, R) {
    let one = R::one();
    let eta = h / yarn.half_span;
    let square_minus_1 = stretch * (R::splat(2.0) + stretch) + eta.squared();
    let leg = R::zero().max(one + square_minus_1).sqrt().max(R::splat(SHORTEST));
    (square_minus_1 / (leg + one), leg)
}

impl LawKernel for Kawabata {
    #[inline(always)]
    fn yarn<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> YarnResponse<R> {
        let one = R::one();
        let (excess, leg) = leg(yarn, stretch, h);
        let per_length = one / (one + yarn.crimp);
        let strain = (excess - yarn.crimp) * per_length;
        let taut = R::zero().lt(strain);
        let tension = R::select(taut, yarn.stiffness * strain, R::zero());
        let eta = h / yarn.half_span;
        let per_leg = one / leg;
        let sine = eta * per_leg;
        let two = R::splat(2.0);
        let dstrain = per_length * sine / yarn.half_span;
        let cosine = (one + stretch) * per_leg;
        let turning = tension * cosine.squared() * per_leg / yarn.half_span;
        let stiffness = two * (yarn.stiffness * dstrain * sine + turning);
        YarnResponse {
            strain,
            tension,
            force: R::select(taut, two * tension * sine, yarn.slack * strain),
            stiffness: R::select(taut, stiffness, yarn.slack * dstrain),
        }
    }
    #[inline(always)]
    fn in_plane_factor<R: Real>(yarn: &YarnConstants<R>, stretch: R, h: R) -> R {
        (R::one() + stretch) / leg(yarn, stretch, h).1
    }
}

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
    /// Contact force F [N].
    pub force: R,
    /// |r| at the end [N].
    pub residual: R,
    /// Evaluations of the residual.
    pub iterations: R,
    /// True where the residual was met.
    pub converged: R::Mask,
}

/// Transverse compression d(F) (21), regularised: 0 at F = 0, (21) for large F; and its derivative [m], [m/N].
/// The negative forces of slack yarns compress nothing.
#[inline(always)]
pub fn compression<R: Real>(cell: &CellConstants<R>, force: R) -> (R, R) {
    let [a, b, offset] = cell.compression;
    let rigid = a.le(R::zero());
    let sum = R::select(rigid, R::one(), R::zero().max(force) + offset);
    let left = b / sum.cube_root();
    let derivative = left / (R::splat(3.0) * sum);
    let none = rigid | force.le(R::zero());
    (R::select(none, R::zero(), a - left), R::select(none, R::zero(), derivative))
}

/// Energy stored in the crossover by compression to d [J]: ∫F dd of the regularised (21).
#[inline(always)]
pub fn compression_energy<R: Real>(cell: &CellConstants<R>, force: R) -> R {
    let [a, b, offset] = cell.compression;
    let rigid = a.le(R::zero());
    let one = R::one();
    let safe_a = R::select(rigid, one, a);
    // a − d = b/∛(F + (b/a)³)
    let root = R::select(rigid, one, R::zero().max(force) + offset).cube_root();
    let left = R::select(rigid, one, b) / root;
    let d = a - left;
    let cube = b * b * b;
    let half = R::splat(0.5);
    let energy = cube * (half * (one / left.squared() - one / safe_a.squared()) - d / (safe_a * safe_a * safe_a));
    R::select(rigid, R::zero(), energy)
}

/// Solves the cell for the stretches Λ_i = 1 + `stretch[i]`, from the heights `warm` of the last step.
///
/// `both` is true where both yarns are alive and present; elsewhere each yarn straightens freely.
#[inline(always)]
pub fn solve<R: Real, L: LawKernel>(
    cell: &CellConstants<R>,
    stretch: [R; 2],
    warm: [R; 2],
    both: R::Mask,
) -> Equilibrium<R> {
    let zero = R::zero();
    let (p, o) = (cell.pivot, 1 - cell.pivot);
    let (yp, yo) = (&cell.yarn[p], &cell.yarn[o]);
    let top = cell.height_sum;
    // Cells that cannot press are solved at F = 0 by the straight-yarn branch below.
    let pressing = both & zero.lt(top);
    let mut active = pressing;
    let mut x = zero.max(warm[p]).min(top);
    let (mut low, mut high) = (zero, top);
    // Ends of the bracket are known signs, not evaluated points, until the iteration goes there.
    let (mut low_seen, mut high_seen) = (R::Mask::splat(false), R::Mask::splat(false));
    let mut last = R::splat(f64::MAX.min(1e30));
    let mut best = CellPoint::at::<L>(cell, stretch, x);
    let mut iterations = R::select(active, R::one(), zero);
    for _ in 0..MAX_ITERATIONS {
        let size = best.residual.abs();
        let resolved = (high - low).abs().le(R::splat(2.0 * R::EPSILON) * high);
        let limit = cell.tolerance + R::splat(8.0 * R::EPSILON) * best.pivot.force.abs();
        active = active & !(size.le(limit) | resolved | best.slack());
        if !active.any() {
            break;
        }
        let above = zero.lt(best.residual);
        high = R::select(active & above, x, high);
        high_seen = high_seen | (active & above);
        low = R::select(active & !above, x, low);
        low_seen = low_seen | (active & !above);
        // A step that did not halve the residual is followed by a bisection once both ends are known.
        let slow = (R::splat(0.5) * last).lt(size) & low_seen & high_seen;
        last = size;
        let newton = x - best.residual / R::select(zero.lt(best.slope), best.slope, R::one());
        let flat = best.slope.le(zero);
        let newton = R::select(flat, R::select(above, low, high), newton);
        let middle = R::splat(0.5) * (low + high);
        let below_end = newton.le(low);
        let above_end = high.le(newton);
        let newton = R::select(below_end, R::select(low_seen, middle, low), newton);
        let newton = R::select(above_end, R::select(high_seen, middle, high), newton);
        let next = R::select(slow, middle, newton);
        x = R::select(active, next, x);
        let point = CellPoint::at::<L>(cell, stretch, x);
        best = CellPoint::select(active, point, best);
        iterations = iterations + R::select(active, R::one(), zero);
    }
    let best = polish::<R, L>(cell, stretch, pressing, best);
    let free = |y: &YarnConstants<R>, s: R| (s - y.crimp) / (R::one() + y.crimp);
    let straight = [free(&cell.yarn[0], stretch[0]), free(&cell.yarn[1], stretch[1])];
    let mut out = Equilibrium {
        tension: [zero; 2],
        in_plane: [zero; 2],
        strain: straight,
        height: [zero; 2],
        force: R::select(pressing, best.pivot.real_force(), zero),
        residual: R::select(pressing, best.real_residual().abs(), zero),
        iterations,
        converged: !active,
    };
    out.height[p] = R::select(pressing, x, zero);
    out.height[o] = R::select(pressing, best.other_height, zero);
    out.strain[p] = R::select(pressing, best.pivot.strain, straight[p]);
    out.strain[o] = R::select(pressing, best.other.strain, straight[o]);
    let pressed = [best.pivot.tension, best.other.tension];
    for (i, y, t) in [(p, yp, pressed[0]), (o, yo, pressed[1])] {
        let alone = y.stiffness * zero.max(straight[i]);
        out.tension[i] = R::select(pressing, t, alone);
        out.in_plane[i] =
            out.tension[i] * R::select(pressing, L::in_plane_factor(y, stretch[i], out.height[i]), R::one());
    }
    out
}

/// Lets the other yarn's height meet the force where the unknown's own resolution is too coarse for it.
///
/// A stiff crossover in single precision can use up the digits of x before the residual is met. Compatibility (22)
/// then holds to a rounding of the heights either way, and equilibrium (16) is what forces depend on.
#[inline(always)]
fn polish<R: Real, L: LawKernel>(
    cell: &CellConstants<R>,
    stretch: [R; 2],
    pressing: R::Mask,
    mut best: CellPoint<R>,
) -> CellPoint<R> {
    let o = 1 - cell.pivot;
    let zero = R::zero();
    for _ in 0..3 {
        let size = best.residual.abs();
        let limit = cell.tolerance + R::splat(8.0 * R::EPSILON) * best.pivot.force.abs();
        let rises = zero.lt(best.other.stiffness);
        let rough = pressing & !(size.le(limit) | best.slack()) & zero.lt(best.pivot.force) & rises;
        if !rough.any() {
            break;
        }
        let slope = R::select(rises, best.other.stiffness, R::one());
        let other_height = best.other_height + best.residual / slope;
        let other = L::yarn(&cell.yarn[o], stretch[o], other_height);
        let residual = best.pivot.force - other.force;
        let better = rough & residual.abs().lt(size);
        let point = CellPoint { pivot: best.pivot, other, other_height, residual, slope: best.slope };
        best = CellPoint::select(better, point, best);
    }
    best
}

/// The residual and what it is made of at one trial height.
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
    fn at<L: LawKernel>(cell: &CellConstants<R>, stretch: [R; 2], x: R) -> Self {
        let (p, o) = (cell.pivot, 1 - cell.pivot);
        let pivot = L::yarn(&cell.yarn[p], stretch[p], x);
        let (d, dd) = compression(cell, pivot.force);
        let other_height = cell.height_sum - d - x;
        let other = L::yarn(&cell.yarn[o], stretch[o], other_height);
        Self {
            pivot,
            other,
            other_height,
            residual: pivot.force - other.force,
            slope: pivot.stiffness + other.stiffness * (R::one() + dd * pivot.stiffness),
        }
    }

    /// Both yarns slack: nothing presses, whatever the heights.
    #[inline(always)]
    fn slack(&self) -> R::Mask {
        self.pivot.strain.le(R::zero()) & self.other.strain.le(R::zero())
    }

    /// The residual of the forces that are really there [N].
    #[inline(always)]
    fn real_residual(&self) -> R {
        self.pivot.real_force() - self.other.real_force()
    }

    #[inline(always)]
    fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        let pick = |a: YarnResponse<R>, b: YarnResponse<R>| YarnResponse {
            strain: R::select(mask, a.strain, b.strain),
            tension: R::select(mask, a.tension, b.tension),
            force: R::select(mask, a.force, b.force),
            stiffness: R::select(mask, a.stiffness, b.stiffness),
        };
        Self {
            pivot: pick(yes.pivot, no.pivot),
            other: pick(yes.other, no.other),
            other_height: R::select(mask, yes.other_height, no.other_height),
            residual: R::select(mask, yes.residual, no.residual),
            slope: R::select(mask, yes.slope, no.slope),
        }
    }
}

impl CellConstants<f64> {
    /// Constants of `fabric`'s cell in double precision. Heights at rest solve (15).
    pub fn new(fabric: &Fabric) -> Self {
        let law = fabric.crossover.law;
        let yarn = [&fabric.warp, &fabric.weft].map(|y| YarnConstants {
            stiffness: if y.present { y.modulus * y.area(fabric.fibre_density) } else { 0.0 },
            half_span: y.half_span(),
            crimp: y.crimp,
            height: y.half_span() * rest_height(law, y.crimp),
            failure_strain: y.failure_strain,
            slack: 0.0,
            terms: MAX_TERMS,
        });
        let both = fabric.warp.present && fabric.weft.present;
        let height_sum = if both { (yarn[0].height + yarn[1].height - fabric.crossover.gap).max(0.0) } else { 0.0 };
        let yarn = yarn.map(|y| {
            let rise = y.height * std::f64::consts::FRAC_PI_2 / y.half_span;
            let slack = 2.0 * y.stiffness * (rise / rise.hypot(1.0)).max(0.05);
            YarnConstants { slack, terms: terms_for(steepest_taut(&y, height_sum).max(rise)), ..y }
        });
        let [a, b] = fabric.crossover.compression.map_or([0.0; 2], |c| [c.a, c.b]);
        let offset = if a > 0.0 { (b / a).powi(3) } else { 0.0 };
        let softer = yarn[0].stiffness.min(yarn[1].stiffness);
        Self {
            yarn,
            height_sum,
            compression: [a, b, offset],
            pivot: usize::from(yarn[1].stiffness < yarn[0].stiffness),
            tolerance: 1e-12 * softer,
        }
    }
}

impl<R: Real> CellConstants<R> {
    /// The constants as another number type sees them.
    ///
    /// The crimp is taken from this type's own arc length at its own rest height, plus a few roundings, so that a
    /// fabric at rest is exactly tension-free: what no wave has reached stays at rest to the last bit.
    pub fn cast<L: LawKernel>(cell: &CellConstants<f64>) -> Self {
        let mut yarn = cell.yarn.map(|y| {
            let mut cast = YarnConstants {
                stiffness: R::splat(y.stiffness),
                half_span: R::splat(y.half_span),
                crimp: R::zero(),
                height: R::splat(y.height),
                failure_strain: R::splat(y.failure_strain),
                slack: R::splat(y.slack),
                terms: y.terms,
            };
            // At zero crimp the strain of the resting yarn is its length in excess of the span.
            let excess = L::yarn(&cast, R::zero(), cast.height).strain;
            cast.crimp = excess * R::splat(1.0 + 4.0 * R::EPSILON);
            cast
        });
        // The other yarn rests at what the pivot leaves of the height, a rounding away from its own.
        let (p, o) = (cell.pivot, 1 - cell.pivot);
        let left = R::splat(cell.height_sum) - yarn[p].height;
        let bare = YarnConstants { crimp: R::zero(), ..yarn[o] };
        let excess = L::yarn(&bare, R::zero(), left.max(yarn[o].height)).strain;
        yarn[o].crimp = excess * R::splat(1.0 + 4.0 * R::EPSILON);
        let noise = if R::EPSILON > 1e-10 { 2e4 } else { 1.0 };
        Self {
            yarn,
            height_sum: R::splat(cell.height_sum),
            compression: cell.compression.map(R::splat),
            pivot: cell.pivot,
            tolerance: R::splat(cell.tolerance * noise),
        }
    }
}

/// End slope at the shortest span at which the yarn is still taut at the greatest height there is: steeper yarns are
/// slack, and their length only has to be known to be too short.
fn steepest_taut(yarn: &YarnConstants<f64>, height_sum: f64) -> f64 {
    let slope = |length: f64| std::f64::consts::FRAC_PI_2 * height_sum / (yarn.half_span * length);
    let (mut slack, mut taut) = (0.01, 1.0 + yarn.crimp);
    for _ in 0..50 {
        let middle = 0.5 * (slack + taut);
        if middle * (1.0 + arc_length(slope(middle), MAX_TERMS).excess) < 1.0 + yarn.crimp {
            slack = middle;
        } else {
            taut = middle;
        }
    }
    slope(taut)
}

/// Height over half-span at rest for a crimp (15): Newton on s(k) = 1 + crimp, or the saw-tooth's closed form.
fn rest_height(law: Law, crimp: f64) -> f64 {
    if crimp <= 0.0 {
        return 0.0;
    }
    if law == Law::Kawabata {
        return (crimp * (2.0 + crimp)).sqrt();
    }
    let mut k = 2.0 * crimp.sqrt();
    for _ in 0..50 {
        let s = arc_length(k, MAX_TERMS);
        let step = (s.excess - crimp) / s.slope;
        k -= step;
        if step.abs() <= 1e-16 * k {
            break;
        }
    }
    k * std::f64::consts::FRAC_2_PI
}

/// Calls `$body` with `$law` bound to the kernel type of a [`Variant`]: the one place where the choice is made.
#[macro_export]
macro_rules! with_law {
    ($variant:expr, $law:ident => $body:expr) => {{
        use $crate::kernels::crossover as laws;
        match $variant {
            laws::Variant::PublishedTension => {
                type $law = laws::PublishedTension;
                $body
            }
            laws::Variant::PublishedProjected => {
                type $law = laws::PublishedProjected;
                $body
            }
            laws::Variant::Variational => {
                type $law = laws::Variational;
                $body
            }
            laws::Variant::Kawabata => {
                type $law = laws::Kawabata;
                $body
            }
        }
    }};
}

/// The four kernels a case can choose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// `published` with `"membrane_force": "tension"`.
    PublishedTension,
    /// `published` with `"membrane_force": "projected"`.
    PublishedProjected,
    /// `variational`.
    Variational,
    /// `kawabata`.
    Kawabata,
}

impl Variant {
    /// The kernel a crossover asks for.
    pub fn of(crossover: &crate::case::Crossover) -> Self {
        match (crossover.law, crossover.membrane_force) {
            (Law::Published, MembraneForce::Tension) => Self::PublishedTension,
            (Law::Published, MembraneForce::Projected) => Self::PublishedProjected,
            (Law::Variational, _) => Self::Variational,
            (Law::Kawabata, _) => Self::Kawabata,
        }
    }
}
