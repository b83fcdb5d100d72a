//! Forces of yarns that depend on rates: shock viscosity, and what the rate of strain adds to a stress.

use crate::num::scalar::{Real, each};
use crate::physics::coupled_newton::LEAST_STRAIN;
use crate::physics::kinematics::{ElementConstants, ElementGeometry, Growth, Kinematics, RateConstants, TINY, dot};
use crate::physics::yarn_law::YarnConstants;

/// Forces of the yarns that depend on rates: what they are now, and the work of those at the last and at this step on the stretch in between.
pub(crate) struct Viscous<R> {
    /// Of shock viscosity and of the rate of strain, now [N].
    pub(crate) force: [R; 2],
    /// Overstress of the rate of strain over the tension [-].
    pub(crate) rate: [R; 2],
    /// Work since the last step over ½ of the element's length times its yarns [N], warp and weft: (V⁻ ΔΛ⁻ + V⁺ ΔΛ⁺).
    pub(crate) work: [R; 2],
}

/// Viscous forces of warp and weft [N]: stiffness times viscosity [s] times the rate of stretch, so large at a shock and small
/// elsewhere. In coarse elements the viscosity grows with the steepness of the front. With them what the rate of strain adds. A slack yarn
/// has none, and a yarn never pushes. `elastic`: in-plane forces of the yarns [N]; `before`: viscous forces at the last step [N], and what
/// the rate of strain added then [-]; `v`: differences of velocities over the element; `dt` [s].
#[inline(always)]
pub(crate) fn viscous_forces<R: Real>(
    c: &ElementConstants<R>,
    size: &ElementGeometry<R>,
    k: &Kinematics<R>,
    v: &[[R; 3]; 3],
    elastic: &[R; 2],
    [before, rate_before]: [[R; 2]; 2],
    dt: R,
) -> Viscous<R> {
    // Kept from the prediction of heights it would have to leave its registers.
    let grown = Growth::new(size, k, v, dt);
    let parts = each!(i in 2 => {
        let zero = dt.zero();
        let rate = dot(&k.direction[i], &each!(a in 3 => v[a][i])) * size.gradient[i];
        let steepness = (rate.abs() * size.steep_viscosity[i] * c.per_steep).min(dt.one());
        let viscosity = size.viscosity[i] + (size.steep_viscosity[i] - size.viscosity[i]) * steepness;
        let yarn = &c.cell.yarn[i];
        let shock = yarn.stiffness * viscosity * rate;
        let (force, added) = match &c.rate {
            Some(law) => {
                let added = overstress(law, yarn, elastic[i], grown.along[i], rate_before[i], dt);
                (added.fused(elastic[i], shock), added)
            }
            None => (shock, zero),
        };
        let force = R::select(elastic[i].le(zero), zero, force.max(-elastic[i]));
        // The same rate along the direction of the last step, from Λ² − 1 there.
        let now = dt.one() + k.extension[i];
        let more = k.extension[i] * (now + dt.one()) - dt.splat_like(2.0) * now * grown.whole[i] + grown.whole_square[i];
        let last = (dt.one() + more).max(dt.splat_like(TINY)).sqrt();
        // A yarn that went slack since dissipates on its way to slack, and no further: more than it stored would be booked.
        let extension = more / (dt.one() + last);
        let taut = (extension / (extension - k.extension[i]).max(dt.splat_like(TINY))).min(dt.one());
        let taut = R::select(elastic[i].le(zero), R::select(extension.le(zero), dt.one(), taut), dt.one());
        let before = taut * before[i] * ((now * grown.along[i] - grown.square[i]) / last);
        (force, force * grown.along[i] + before, added)
    });
    Viscous { force: each!(i in 2 => parts[i].0), work: each!(i in 2 => parts[i].1), rate: each!(i in 2 => parts[i].2) }
}

/// Newton steps for the part of the rate of strain. The first ends at the root or above it; what is missed then is made up in the next time step.
pub const RATE_ITERATIONS: usize = 3;

/// Overstress of the rate of strain over the tension T, x [-]. The force x T yields at the rate C x^P, so that at a steady rate ε̇ it is
/// T (ε̇/C)^(1/P), and reaches that over a spring k, the most that it adds to the stiffness: ẋ = k/T (ε̇ − C x^P). So no rate, however it
/// changes from step to step, makes a yarn stiffer than the time step is for, and over any cycle it takes energy: a yarn that shortens loses x
/// at least as fast with the strain as it has got it. `growth` of the stretch in this step [-]; `before`: x at the last step.
#[inline(always)]
fn overstress<R: Real>(law: &RateConstants<R>, yarn: &YarnConstants<R>, tension: R, growth: R, before: R, dt: R) -> R {
    let (zero, one) = (dt.zero(), dt.one());
    let stiffness = law.most * yarn.stiffness / tension.max(yarn.stiffness * dt.splat_like(LEAST_STRAIN));
    // x + B x^P = trial, implicitly.
    let trial = (stiffness * yarn.per_rest).fused(growth, before).max(zero);
    let yielding = stiffness * dt * law.c;
    let mut x = before.min(trial);
    for _ in 0..RATE_ITERATIONS {
        let slope = yielding * x.power(law.power - 1.0);
        let missed = trial - x - slope * x;
        x = (x + missed / (one + dt.splat_like(law.power) * slope)).max(zero);
    }
    R::select(tension.le(zero), zero, x.min(law.most))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;
    use crate::model::Model;
    use crate::physics::kinematics::kinematics;

    fn constants() -> ElementConstants<f64> {
        let model = Model::<f64>::new(&case::shipped(&["/expect=[]"]));
        model.unwrap_or_else(|error| unreachable!("{error}")).ply_types[0].constants::<f64>()
    }

    #[test]
    fn what_the_rate_adds_is_a_spring_all_at_once_and_yields_held() {
        let c = constants();
        let law = RateConstants { c: 1e3, power: 5.0, most: 2.5 };
        let yarn = &c.cell.yarn[0];
        let of = |growth: f64, dt: f64, before: f64| overstress(&law, yarn, 100.0, growth, before, dt);
        let spring = 2.5 * yarn.stiffness / 100.0;
        for growth in [1e-4, -1e-4] {
            assert!((of(growth, 1e-15, 0.5) / (0.5 + spring * yarn.per_rest * growth) - 1.0).abs() < 1e-6);
        }
        assert_eq!([of(-1.0, 1e-15, 0.5), overstress(&law, yarn, 0.0, 1e-4, 0.5, 1e-15)], [0.0; 2]);
        // Held, x^−4 grows by 4 k C t/T.
        let mut held = 0.8;
        (0..20_000).for_each(|_| held = of(0.0, 1e-10, held));
        let wanted = (0.8_f64.powi(-4) + 4.0 * spring * 1e3 * 2e-6).powf(-0.25);
        assert!((held / wanted - 1.0).abs() < 1e-3, "{held} instead of {wanted}");
    }

    #[test]
    fn viscosity_of_a_coarse_element_grows_with_the_steepness_of_the_front() {
        let c = constants();
        let (size, dt) = (ElementGeometry::of_row(&c, 16.0).of_columns(8.0, 0.125), 1e-8);
        let k = kinematics(&size, [&[0.0; 3]; 3]);
        // Four elements per crossover: elements of two crossovers along warp and four along weft. q = 0.3, in proportion to the length of the
        // finest; a front that adds 3.5 % while it crosses an element at the speed of its wave has all of the length.
        for (added, share) in [(0.0035, 0.1), (0.0175, 0.5), (0.035, 1.0), (0.35, 1.0)] {
            let period = [c.viscosity[0] * 8.0 / 0.3, c.viscosity[1] * 16.0 / 0.3];
            let rate = period.map(|period| added / period);
            let v = [[rate[0] / size.gradient[0], 0.0, 0.0], [0.0, rate[1] / size.gradient[1], 0.0], [0.0; 3]];
            for sign in [1.0, -1.0] {
                let got =
                    viscous_forces(&c, &size, &k, &v.map(|v| v.map(|v| sign * v)), &[1e9; 2], [[0.0; 2]; 2], dt).force;
                for (i, length) in [8.0, 16.0].into_iter().enumerate() {
                    let wanted =
                        sign * c.cell.yarn[i].stiffness * c.viscosity[i] * (4.0 + (length - 4.0) * share) * rate[i];
                    assert!((got[i] / wanted - 1.0).abs() < 1e-9, "{added} {i}: {} instead of {wanted}", got[i]);
                }
            }
        }
    }

    #[test]
    fn a_yarn_that_goes_slack_dissipates_on_its_way_to_slack() {
        let c = constants();
        let size = ElementGeometry::of_row(&c, 1.0);
        let (dt, before) = (1e-8, [-7.0, -5.0]);
        // By components along warp and weft: each yarn shortens along itself, from a stretch to another.
        let work = |from: [f64; 2], to: [f64; 2], elastic: f64| {
            let along =
                |by: [f64; 2]| [[by[0] / size.gradient[0], 0.0, 0.0], [0.0, by[1] / size.gradient[1], 0.0], [0.0; 3]];
            let v = along([0, 1].map(|i: usize| (to[i] - from[i]) / dt));
            let k = kinematics(&size, along(to).each_ref());
            viscous_forces(&c, &size, &k, &v, &[elastic; 2], [before, [0.0; 2]], dt).work
        };
        // Slack at a stretch of 0: the warp a third of the way, the weft three quarters of it.
        let slack = work([0.001, 0.003], [-0.002, -0.001], 0.0);
        for (got, wanted) in slack.into_iter().zip([7.0 * 0.001, 5.0 * 0.003]) {
            assert!((got / wanted - 1.0).abs() < 1e-9, "{got} instead of {wanted}");
        }
        // One that broke while it was stretched, and one whose crossing yarn held it taut below: all of the way.
        for (from, to) in [([0.004; 2], [0.001; 2]), ([-0.001; 2], [-0.004; 2])] {
            for (got, before) in work(from, to, 0.0).into_iter().zip(before) {
                assert!((got / (-0.003 * before) - 1.0).abs() < 1e-9, "{got}");
            }
        }
    }

    #[test]
    fn viscous_forces_work_on_the_stretch_of_their_own_step() {
        let c = constants();
        let size = ElementGeometry::of_row(&c, 1.0);
        let (dt, before) = (2e-6, [7.0, -3.0]);
        // By component: along warp and weft, and of opposite edges.
        let u = [[3e-4, 4e-4, -2e-4], [-2e-4, 1e-4, 3e-4], [5e-4, -6e-4, 4e-4]];
        let v = [[30.0, -20.0, 25.0], [14.0, 35.0, -31.0], [-25.0, 40.0, 18.0]];
        let k = kinematics(&size, u.each_ref());
        let got = viscous_forces(&c, &size, &k, &v, &[1e9; 2], [before, [0.0; 2]], dt);
        for i in 0..2 {
            // What a yarn spans at its centre, now and a step ago, over the mean stretch that it has as a whole.
            let of = |time: f64| {
                let at = |a: usize, which: usize| size.gradient[i] * (u[a][which] - time * v[a][which]);
                let centre = [0, 1, 2].map(|a: usize| f64::from(u8::from(a == i)) + at(a, i));
                let mode: f64 = (0..3).map(|a| at(a, 2).powi(2)).sum();
                let length = (dot(&centre, &centre) + size.mode_share * mode).sqrt();
                centre.map(|x| x / length)
            };
            let step = [0, 1, 2].map(|a: usize| size.gradient[i] * dt * v[a][i]);
            let force = c.cell.yarn[i].stiffness * size.viscosity[i] * dot(&of(0.0), &step) / dt;
            assert!((got.force[i] / force - 1.0).abs() < 1e-12, "{i}: {:?} {force}", got.force);
            let work = force * dot(&of(0.0), &step) + before[i] * dot(&of(dt), &step);
            assert!((got.work[i] / work - 1.0).abs() < 1e-9, "{i}: {:?} {work}", got.work);
        }
    }
}
