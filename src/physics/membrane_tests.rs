use super::*;
use crate::case;
use crate::model::Model;
use crate::physics::kinematics::kinematics;
use crate::physics::yarn_law::Published;

fn constants() -> ElementConstants<f64> {
    let model = Model::<f64>::new(&case::shipped(&["/expect=[]"]));
    model.unwrap_or_else(|error| unreachable!("{error}")).ply_types[0].constants::<f64, Published>()
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
            let got = viscous(&c, &size, &k, &v.map(|v| v.map(|v| sign * v)), &[1e9; 2], [0.0; 2], dt).force;
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
        viscous(&c, &size, &k, &v, &[elastic; 2], before, dt).work
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
    let got = viscous(&c, &size, &k, &v, &[1e9; 2], before, dt);
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
