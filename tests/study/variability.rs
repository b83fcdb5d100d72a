//! Random numbers and what varies with them: the generator is the published one, shots are functions of seed and number, have the distributions they name, and a nominal case has none of it.

use ripstop::case::{self, Case};
use ripstop::num::random::{DrawKey, Weibull, normal, philox, uniform};
use ripstop::run::outcome::Outcome;
use ripstop::study::batch::{ShotOrder, order_case};

use super::{campaign::small, near};
use crate::support;

const ALL: &str = r#"/variability={"hit": "unit_cell", "velocity": {"scatter_m_s": 3}, "obliquity": {"scatter_deg": 2}, "yaw": {"scatter_deg": 1,
    "distribution": "uniform"}, "modulus": {"scatter": 0.04}, "crimp": {"scatter": 0.1}}"#;

fn drawn(case: &Case, shot: u32) -> Case {
    order_case(case, 5, ShotOrder { shot, velocity: None }).unwrap()
}

/// Kolmogorov and Smirnov: chance of values below 1.63/√n off in one of a hundred samples.
#[track_caller]
fn follows(name: &str, mut values: Vec<f64>, distribution: impl Fn(f64) -> f64) {
    values.sort_by(f64::total_cmp);
    let n = values.len() as f64;
    let off = values.iter().enumerate().map(|(i, value)| {
        let p = distribution(*value);
        (p - i as f64 / n).abs().max((p - (i as f64 + 1.0) / n).abs())
    });
    let off = off.fold(0.0, f64::max);
    assert!(off < 1.63 / n.sqrt(), "{name}: {off}");
}

#[test]
fn values_have_the_distributions_that_the_case_names() {
    let nominal = small(&[ALL]);
    let shots: Vec<Case> = (0..300).map(|shot| drawn(&nominal, shot)).collect();
    let column = |name: &str| -> Vec<f64> {
        let of = |shot: &Case| shot.drawn.iter().find(|drawn| drawn.column == name).unwrap().value;
        shots.iter().map(of).collect()
    };
    let normal = |mean: f64, sd: f64| move |x: f64| normal::probability((x - mean) / sd);
    let even = |low: f64, high: f64| move |x: f64| (x - low) / (high - low);
    let velocity = nominal.projectile.as_ref().unwrap().velocity;
    follows(
        "velocity",
        shots.iter().map(|shot| shot.projectile.as_ref().unwrap().velocity).collect(),
        normal(velocity, 3.0),
    );
    for (name, yarn) in [("offset_x_mm", &nominal.fabric.warp), ("offset_y_mm", &nominal.fabric.weft)] {
        let half = yarn.half_span() * 1e3;
        follows(name, column(name), even(-half, half));
    }
    follows("yaw", column("yaw_deg"), even(-1.0, 1.0));
    // Folded at zero: the angle is |N|.
    follows("obliquity", column("obliquity_deg"), |x| 2.0 * normal::probability(x / 2.0) - 1.0);
    follows("modulus", column("warp_modulus_gpa"), normal(96.0, 0.04 * 96.0));
    let crimp = nominal.fabric.weft.crimp;
    follows("crimp", column("weft_crimp"), normal(crimp, 0.1 * crimp));
    let [warp, weft] = [column("warp_modulus_gpa"), column("weft_modulus_gpa")];
    assert!(warp.iter().zip(&weft).all(|(warp, weft)| warp != weft));
    // What was drawn is what the shot has, and says where it is from.
    let shot = &shots[7];
    assert_eq!(shot.fabric.warp.modulus, warp[7] * 1e9);
    let field = shot.fields.iter().find(|field| field.pointer == "/fabric/warp/modulus_gpa").unwrap();
    assert!(field.source.contains("drawn, normal"), "{field:?}");
}

#[test]
fn a_modulus_that_varies_takes_all_stresses_of_a_curve_along() {
    let yarn = r#"/fabric/warp={"linear_density_denier":1420,"curve":[[0,0],[0.01,0.7],[0.04,4]],"failure_strain":0.035,
        "count_per_inch":20,"crimp":0.0218}"#;
    let nominal = small(&[ALL, yarn]);
    let shot = drawn(&nominal, 7);
    let modulus = shot.drawn.iter().find(|drawn| drawn.column == "warp_modulus_gpa").unwrap().value * 1e9;
    near(shot.fabric.warp.modulus, modulus, 1e-12 * modulus);
    let factor = modulus / nominal.fabric.warp.modulus;
    assert!((factor - 1.0).abs() > 1e-4, "{factor}");
    for (point, was) in shot.fabric.warp.curve.iter().zip(&nominal.fabric.warp.curve) {
        near(point[0], was[0], 0.0);
        near(point[1], factor * was[1], 1e-12 * modulus);
    }
}

#[test]
fn draws_depend_on_seed_and_number_and_on_nothing_else() {
    let nominal = small(&[ALL]);
    assert_eq!(drawn(&nominal, 3).drawn, drawn(&nominal, 3).drawn);
    assert_ne!(drawn(&nominal, 3).drawn, drawn(&nominal, 4).drawn);
    let other = order_case(&nominal, 6, ShotOrder { shot: 3, velocity: None }).unwrap();
    assert_ne!(drawn(&nominal, 3).drawn, other.drawn);
    // One thing less that varies leaves the others as they are.
    let less = small(&[ALL, "/variability/yaw=null"]);
    let kept = drawn(&less, 3).drawn;
    assert!(
        kept.iter().all(|value| drawn(&nominal, 3).drawn.contains(value))
            && kept.len() + 1 == drawn(&nominal, 3).drawn.len()
    );
    // The case as run is that shot again.
    let shot = drawn(&nominal, 3);
    let again = case::from_str("again", &shot.as_run.to_string(), &[]).unwrap();
    assert_eq!((again.drawn, again.projectile, again.fabric), (shot.drawn, shot.projectile, shot.fabric));
}

#[test]
fn a_nominal_case_runs_as_if_nothing_could_vary() {
    let strength = r#"/variability/yarn_strength={"shape": 8, "gauge_length_mm": 50}"#;
    let (plain, nominal) = (support::run(&small(&[])), support::run(&small(&[ALL, strength])));
    assert_eq!(plain.history, nominal.history);
    assert_eq!((plain.events, plain.planes), (nominal.events, nominal.planes));
}

#[test]
fn weak_yarns_let_pass_what_strong_ones_stop() {
    // Of a piece far longer than an element nearly all elements are stronger than the fabric's failure strain; of a far shorter one weaker.
    let run = |gauge: &str, shot: &str| {
        let strength = format!(r#"/variability/yarn_strength={{"shape": 10, "gauge_length_mm": {gauge}}}"#);
        support::run(&small(&[&strength, &format!("/variability/shot={shot}"), "/projectile/velocity_m_s=90"]))
    };
    let (strong, weak) = (run("100000", "1"), run("0.02", "1"));
    assert_eq!((strong.outcome, weak.outcome), (Outcome::Stopped, Outcome::Perforated));
    assert!(strong.planes.copies() == 1, "a scene whose yarns differ has no mirror planes");
    assert_ne!(weak.events, run("0.02", "2").events);
    // A shape so large that all elements are alike gives back the fabric's own strength, mirror planes or not.
    let even = r#"/variability/yarn_strength={"shape": 1000, "gauge_length_mm": 25}"#;
    let even = support::run(&small(&[even, "/variability/shot=1", "/projectile/velocity_m_s=110"]));
    let plain = support::run(&small(&["/projectile/velocity_m_s=110"]));
    assert_eq!(even.outcome, plain.outcome);
}

#[test]
fn a_yarn_as_woven_is_one_that_breaks_at_a_part_of_its_strain() {
    let run = |key: &str, values: [f64; 2]| {
        let [warp, weft] =
            [("warp", values[0]), ("weft", values[1])].map(|(yarn, value)| format!("/fabric/{yarn}/{key}={value}"));
        support::run(&small(&[&warp, &weft, "/projectile/velocity_m_s=110"]))
    };
    let (woven, weaker) =
        (run("strength_retention", [0.785, 0.9]), run("failure_strain", [0.035 * 0.785, 0.035 * 0.9]));
    assert!(!woven.events.is_empty() && woven.events == weaker.events && woven.history == weaker.history);
}

/// `kat_vectors` of Random123.
#[test]
fn the_generator_is_the_published_one() {
    for (counter, key, expected) in [
        ([0; 4], [0; 2], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
        ([u32::MAX; 4], [u32::MAX; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
        (
            [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
            [0xa409_3822, 0x299f_31d0],
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
        ),
    ] {
        assert_eq!(philox(counter, key), expected);
    }
}

#[test]
fn uniform_numbers_are_exact_in_single_precision_and_never_0_or_1() {
    assert_eq!(uniform(0), 0.5 / 8_388_608.0);
    assert_eq!(uniform(u32::MAX), 1.0 - 0.5 / 8_388_608.0);
    for n in 0..1000 {
        for value in (DrawKey { element: n, ..DrawKey::default() }).uniform() {
            assert_eq!(f64::from(value as f32), value);
            assert!(value > 0.0 && value < 1.0);
        }
    }
}

/// Kevlar 49 of a gauge length of 50 mm.
const YARN: Weibull = Weibull { scale: 1933.0, shape: 21.7, gauge: 50.0 };

#[test]
fn a_length_is_weaker_the_longer_it_is_and_draws_invert_the_chance() {
    let chance = |length: f64, stress: f64| -(-(length / YARN.gauge) * (stress / YARN.scale).powf(YARN.shape)).exp_m1();
    for length in [1.0, 50.0, 425.0] {
        for u in [1e-6, 0.1, 0.5, 0.999] {
            near(chance(length, YARN.strength(length, u)), u, 1e-9);
        }
    }
    let exponential = Weibull { scale: 2.0, shape: 1.0, gauge: 1.0 };
    near(exponential.mean(4.0), 0.5, 1e-12);
}
