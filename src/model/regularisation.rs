//! What meshes coarser than one crossover per element need to keep its outcome: the published failure strain belongs to it.
//!
//! **Even meshes of n crossovers per element.** Beyond the projectile's edge the strain of a yarn decays from its peak to that of
//! the fabric around. An element knows only the mean over its length and would let the yarn live too long. With a peak of which the
//! part a decays like exp(−x/ℓ) the mean over n crossovers is f(n) times that over one,
//!
//! ```text
//! f(n) = 1 − a (1 − (1 − e^(−n/ℓ)) / (n (1 − e^(−1/ℓ))))
//! ```
//!
//! so an element of n crossovers fails at f(n) times the published strain. a and ℓ are read from the membrane force along the
//! struck yarn of the S-720 shot, one crossover per element, just before its first failure: means over 2, 4 and 8
//! crossovers beyond the edge are 0.95, 0.88 and 0.79 of the peak; f gives 0.96, 0.89 and 0.80. It knows nothing of how few nodes
//! meet the projectile, which makes the fabric too soft once elements are more than half as long as that is wide.
//!
//! **Graded meshes.** Waves shorter than two elements cannot go on, so larger elements send what is short back to
//! the hit, where it piles up until yarns break too early. Those elements are viscous along the yarn, T = EA (ε + η dε/dt): η is
//! 0.07 times the logarithm of the growth (so that a wave loses as much where elements grow slowly, and are many) times the
//! time a wave takes over the element, and comes in over the first 0.3 of growth. Elements of the finest size have none. The work done
//! by it counts as internal work.
//!
//! **Nonlocal failure.** The strain of one element at a sharp rim depends on where in the element the rim is: with failure switched off
//! its peak in the S-720 shot at 144 m/s goes from 2.6 to 3.6 % over sub-cell shifts of the hit (contact at the rim), and from 3.2 to
//! 4.1 % on a mesh twice as fine. Its mean over a square of some crossovers hardly does: 2.22 to 2.28 % and 2.25 to 2.35 % over three by
//! three. Over four by four the ballistic limit depends least on shifts, mesh and time step. Yarns then fail at 0.622 times the published
//! strain, by which that limit is the one of the centred shot with one crossover per element and local failure. Where a yarn bears a
//! load alone the mean over those beside it says nothing, and it breaks at the published strain in its own mean over four crossovers:
//! without that single yarns bear many times their strength, the more the finer the mesh, and tow the projectile.

use crate::case::{FailureMeasure, Pack, Regularisation};

/// Side of the square over which nonlocal failure takes the mean strain, in crossovers.
pub const NEIGHBOURHOOD: f64 = 4.0;
/// Mean strain over the square at which yarns fail over the published strain, at which one alone does [-]; by the ballistic limit of S-720.
pub const MEAN_OVER_PEAK: f64 = 0.622;
/// Part a of the peak strain that decays away from the projectile [-].
const DECAYING: f64 = 0.45;
/// Length ℓ over which it does, in crossovers [-].
const LENGTH: f64 = 5.0;
/// η over the time a wave takes over the element and the logarithm of the growth [-]; by ballistic limit and residual velocities of S-720,
/// growth 1.15.
const VISCOSITY: f64 = 0.07;
/// Growth of an element over the finest at which its viscosity is all there [-].
const RAMP: f64 = 0.3;

/// What yarns of a pack fail at over the published strain [-].
pub fn failure_factor(pack: &Pack) -> f64 {
    match (pack.failure, pack.regularisation) {
        (FailureMeasure::Nonlocal, _) => MEAN_OVER_PEAK,
        (FailureMeasure::Local, Regularisation::Calibrated) => strain_factor(f64::from(pack.crossovers_per_element)),
        (FailureMeasure::Local, Regularisation::None) => 1.0,
    }
}

/// Failure strain of elements so many crossovers long over the published one [-]; 1 for one crossover, exactly.
pub fn strain_factor(crossovers: f64) -> f64 {
    let mean = |n: f64| -(-n / LENGTH).exp_m1() / n;
    1.0 - DECAYING * (1.0 - mean(crossovers) / mean(1.0))
}

/// η of an element over the time a wave takes over the finest, for a growth, before [`share`] [-].
pub(super) fn viscosity(growth: f64) -> f64 {
    VISCOSITY * growth.ln()
}

/// What an element as long as `width` of the finest has of it [-].
pub(super) fn share(width: f64) -> f64 {
    width * ((width - 1.0) / RAMP).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_crossover_fails_at_the_published_strain_and_longer_elements_before() {
        assert_eq!(strain_factor(1.0), 1.0);
        // Means over a profile summed crossover by crossover.
        for n in [2, 4, 8] {
            let at = |k: i32| 0.55 + 0.45 * (-0.2 * f64::from(k)).exp();
            let mean = (0..n).map(at).sum::<f64>() / f64::from(n);
            assert!((strain_factor(f64::from(n)) - mean).abs() < 1e-12, "{n}");
        }
        assert!(strain_factor(64.0) > 0.55 && strain_factor(64.0) < strain_factor(16.0));
    }

    #[test]
    fn the_finest_elements_and_even_meshes_have_no_viscosity() {
        assert_eq!((share(1.0), viscosity(1.0)), (0.0, 0.0));
        assert!(share(1.1) > 0.0 && (share(2.0) - 2.0).abs() < 1e-15 && viscosity(1.15) > 0.0);
    }
}
