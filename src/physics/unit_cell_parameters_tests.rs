use super::*;
use crate::case;

#[test]
fn the_least_stiffness_is_a_millionth_of_the_stiffer_yarn_over_half_a_warp_span() {
    for moduli in [[50.0, 100.0], [100.0, 50.0]] {
        let sets =
            [format!("/fabric/warp/modulus_gpa={}", moduli[0]), format!("/fabric/weft/modulus_gpa={}", moduli[1])];
        let fabric = case::shipped(&sets.each_ref().map(String::as_str)).fabric;
        let cell = UnitCellParameters::new(&fabric);
        let stiffer = 100e9 * fabric.warp.area(fabric.fibre_density);
        let expected = 1e-6 * stiffer / fabric.warp.half_span();
        assert!((cell.min_stiffness / expected - 1.0).abs() < 1e-12, "{moduli:?}: {}", cell.min_stiffness);
        assert_eq!(cell.pivot, usize::from(moduli[1] < moduli[0]));
    }
}

#[test]
fn what_a_fabric_lacks_leaves_no_trace_in_its_constants() {
    let of = |set: &str| UnitCellParameters::new(&case::shipped(&[set]).fabric);
    // Without one of the yarns nothing crosses.
    let absent = r#"{"absent": true, "count_per_inch": 20}"#;
    for yarn in ["warp", "weft"] {
        assert_eq!(of(&format!("/fabric/{yarn}={absent}")).height_sum, 0.0, "{yarn}");
    }
    let rigid = of("/fabric/crossover/compression=rigid");
    assert_eq!((rigid.compression, rigid.uncompressed_limit, rigid.per_b), ([0.0; 3], 1.0, 0.0));
}

/// A fabric whose yarns differ in everything.
fn uneven(more: &[&str]) -> Fabric {
    let sets = [
        "/fabric/warp/modulus_gpa=80",
        "/fabric/weft/modulus_gpa=50",
        "/fabric/warp/count_per_inch=24",
        "/fabric/weft/crimp=0.06",
        "/fabric/crossover/gap_mm=0.02",
        "/fabric/crossover/compression={\"a_mm\": 0.05, \"b_mm_n13\": 0.08}",
    ];
    case::shipped(&[&sets, more].concat()).fabric
}

fn assert_close(got: f64, expected: f64) {
    assert!((got - expected).abs() <= 1e-12 * expected.abs(), "{got} instead of {expected}");
}

/// Length over span of the line z = height·cos(πx/2w) over −w < x < w, by the midpoint rule.
fn length_of_a_cosine(height: f64, half_span: f64) -> f64 {
    let slope = height * std::f64::consts::FRAC_PI_2 / half_span;
    let at = |i: u32| (slope * (std::f64::consts::FRAC_PI_2 * (f64::from(i) + 0.5) / 400.0).sin()).hypot(1.0);
    (0..400).map(at).sum::<f64>() / 400.0
}

#[test]
fn the_constants_of_a_cell_follow_from_its_fabric() {
    let fabric = uneven(&[]);
    let cell = UnitCellParameters::new(&fabric);
    for (yarn, of, modulus) in [(&cell.yarn[0], &fabric.warp, 80e9), (&cell.yarn[1], &fabric.weft, 50e9)] {
        assert_close(yarn.stiffness, modulus * of.linear_density / 1440.0);
        assert_close(yarn.half_span, 0.5 / of.count);
        assert_close(length_of_a_cosine(yarn.height, yarn.half_span), 1.0 + of.crimp);
        assert_close(yarn.per_rest, 1.0 / (1.0 + of.crimp));
        // Twice the stiffness and the sine of the end slope: dF/dε of a yarn that is just taut.
        let slope = yarn.height * std::f64::consts::FRAC_PI_2 / yarn.half_span;
        assert_close(yarn.slack_slope, 2.0 * yarn.stiffness * slope.atan().sin());
        assert_eq!((yarn.crimp, yarn.failure_strain), (of.crimp, of.failure_strain));
    }
    assert_close(cell.height_sum, cell.yarn[0].height + cell.yarn[1].height - 2e-5);
    let [a, b] = [5e-5_f64, 8e-5];
    for (got, expected) in cell.compression.into_iter().zip([a, b, (b / a).powi(3)]) {
        assert_close(got, expected);
    }
    assert_close(cell.uncompressed_limit, a / b);
    assert_close(cell.per_b, 1.0 / b);
    assert_close(cell.tolerance, 1e-12 * cell.yarn[1].stiffness);
    assert_eq!((cell.roundoff_tolerance, cell.pivot), (0.0, 1));
    // Where no force is left nothing but the smallest one counts; a larger one has its own last digits.
    assert_eq!(cell.accepted(0.0), cell.tolerance);
    for force in [-3.0, 5.0] {
        assert_close(cell.accepted(force) - cell.tolerance, 8.0 * f64::EPSILON * force.abs());
    }
    // A gap wider than both yarns are high leaves no height, and a straight yarn the slope of a twentieth.
    let apart = UnitCellParameters::new(&uneven(&["/fabric/crossover/gap_mm=0.9", "/fabric/weft/crimp=0"]));
    assert_eq!((apart.height_sum, apart.yarn[1].height), (0.0, 0.0));
    assert_close(apart.yarn[1].slack_slope, 0.1 * apart.yarn[1].stiffness);
}
