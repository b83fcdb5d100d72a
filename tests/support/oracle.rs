//! The unit cell's equations by other means than the solver's: the complete elliptic integrals come from the
//! arithmetic–geometric mean (the solver sums a Gauss–Kummer series), and an answer is judged by putting it back
//! into (13)–(22) instead of solving again.

use ripstop::model::unit_cell::CurveLaw;

use super::{Cell, Solved};

/// Sinusoid at end slope k: s = S/(2w), ds/dk, and ∂S/∂(2w) at fixed height.
pub(crate) struct Sinusoid {
    pub(crate) length: f64,
    pub(crate) slope: f64,
    pub(crate) pull: f64,
}

/// E = K·(1 − Σ) and K = π/(2·AGM) at parameter −k², so s = 2E/π, ds/dk = 2(E − K)/(πk), s − k ds/dk = 2K/π.
pub(crate) fn sinusoid(k: f64) -> Sinusoid {
    if k == 0.0 {
        return Sinusoid { length: 1.0, slope: 0.0, pull: 1.0 };
    }
    let (mut a, mut b) = (1.0, k.hypot(1.0));
    let (mut power, mut sum) = (0.5, -0.5 * k * k);
    for _ in 0..8 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        power *= 2.0;
        sum += power * c * c;
    }
    Sinusoid { length: (1.0 - sum) / a, slope: -sum / (a * k), pull: 1.0 / a }
}

/// One yarn at a stretch and a height: strain, contact force over tension, in-plane force over tension.
pub(crate) struct Yarn {
    pub(crate) strain: f64,
    pub(crate) press: f64,
    pub(crate) pull: f64,
}

pub(crate) fn yarn(law: CurveLaw, half_span: f64, crimp: f64, stretch: f64, height: f64) -> Yarn {
    let w = stretch * half_span;
    let rest = half_span * (1.0 + crimp);
    if law == CurveLaw::Kawabata {
        let leg = w.hypot(height);
        return Yarn { strain: leg / rest - 1.0, press: 2.0 * height / leg, pull: w / leg };
    }
    let k = std::f64::consts::FRAC_PI_2 * height / w;
    let s = sinusoid(k);
    let strain = w * s.length / rest - 1.0;
    let (press, pull) = match law {
        CurveLaw::Published => (2.0 * k / k.hypot(1.0), 1.0),
        _ => (std::f64::consts::PI * s.slope, s.pull),
    };
    Yarn { strain, press, pull }
}

/// d(F), (21) regularised [m].
pub(crate) fn compression(a: f64, b: f64, force: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a - b / (force + (b / a).powi(3)).cbrt() }
}

/// Distance of a double-precision answer from the physical conditions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Misfit {
    /// Tensions and in-plane forces, over the yarn's breaking tension.
    pub(crate) tension: f64,
    /// Contact forces of the two yarns against each other and against the answer, over the softer's breaking tension.
    pub(crate) force: f64,
    /// Compatibility (22), over the sum of heights.
    pub(crate) height: f64,
}

/// Puts an answer for two living yarns back into (13)–(22).
pub(crate) fn misfit<R: ripstop::num::scalar::Scalar>(cell: &Cell<R>, stretch: [f64; 2], got: &Solved) -> Misfit {
    let exact = &cell.exact;
    let breaking = cell.breaking();
    let softer = cell.softer_breaking();
    let mut out = Misfit::default();
    let top = exact.height_sum;
    for i in [0, 1] {
        let y = &exact.yarn[i];
        // Without contact there is nothing to hold a yarn off the plane.
        let height = if top > 0.0 { got.height[i] } else { 0.0 };
        let ideal = yarn(cell.law, y.half_span, y.crimp, stretch[i], height);
        let tension = y.stiffness * ideal.strain.max(0.0);
        let pull = if top > 0.0 { ideal.pull } else { 1.0 };
        for error in [tension - got.tension[i], pull * tension - got.in_plane[i]] {
            out.tension = out.tension.max((error / breaking[i]).abs());
        }
        if top > 0.0 {
            out.force = out.force.max(((ideal.press * tension - got.force) / softer).abs());
        }
    }
    if top > 0.0 {
        let [a, b, _] = exact.compression;
        let sum = got.height[0] + got.height[1] + compression(a, b, got.force);
        out.height = (sum / top - 1.0).abs();
    }
    out
}
