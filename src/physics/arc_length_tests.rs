use super::*;

/// S/(2w) by Gauss–Legendre quadrature of (13) in 64 panels: independent of the series.
fn by_quadrature(k: f64) -> f64 {
    let nodes = [-0.774_596_669_241_483_4, 0.0, 0.774_596_669_241_483_4];
    let weights = [5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0];
    let panels = 64;
    let width = std::f64::consts::FRAC_PI_2 / panels as f64;
    let mut sum = 0.0;
    for panel in 0..panels {
        for (x, w) in nodes.iter().zip(weights) {
            let angle = width * (panel as f64 + 0.5 + 0.5 * x);
            sum += 0.5 * width * w * (1.0 + (k * angle.sin()).powi(2)).sqrt();
        }
    }
    sum / std::f64::consts::FRAC_PI_2
}

#[test]
fn agrees_with_quadrature_and_with_the_small_slope_series() {
    for i in 0..=30 {
        let k = 0.05 * f64::from(i);
        let s = arc_length(k, MAX_TERMS);
        assert!((1.0 + s.excess - by_quadrature(k)).abs() < 1e-12, "k = {k}");
    }
    let k: f64 = 0.01;
    let series = k.powi(2) / 4.0 - 3.0 * k.powi(4) / 64.0 + 5.0 * k.powi(6) / 256.0;
    assert!((arc_length(k, MAX_TERMS).excess / series - 1.0).abs() < 1e-11);
}

#[test]
fn fewer_terms_are_exact_up_to_their_slope() {
    for k in [0.1_f64, 0.3, 0.6, 1.0] {
        let few = arc_length(k, terms_for(k, 1e-17)).excess;
        assert!((few - arc_length(k, MAX_TERMS).excess).abs() < 1e-16, "k = {k}");
    }
    assert!(terms_for(0.6, 1e-17) <= 6 && terms_for(3.0, 1e-17) == MAX_TERMS);
    for k in [0.1_f64, 0.3, 0.6, 1.0] {
        let few = terms_for(k, 1e-10);
        assert!((arc_length(k, few).excess - arc_length(k, MAX_TERMS).excess).abs() < 1e-10, "k = {k}");
        assert!(few < terms_for(k, 1e-17), "k = {k}");
    }
}

#[test]
fn derivatives_match_differences() {
    for k in [0.02, 0.3, 0.9, 1.4, -0.4] {
        let at = |k| arc_length(k, MAX_TERMS);
        let step = 1e-5;
        let (s, plus, minus) = (at(k), at(k + step), at(k - step));
        assert!((s.slope - (plus.excess - minus.excess) / (2.0 * step)).abs() < 1e-9, "k = {k}");
        assert!((s.curvature - (plus.slope - minus.slope) / (2.0 * step)).abs() < 1e-9, "k = {k}");
    }
}
