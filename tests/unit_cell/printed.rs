//! The numbers printed in the verification table, to their last digit.

use super::*;

/// `printed` must be `got` rounded to its last digit.
#[track_caller]
fn digits(got: f64, printed: &str) {
    let places = printed.split_once('.').unwrap().1.len();
    let expected: f64 = printed.parse().unwrap();
    let half = 0.500_001 * 10_f64.powi(-(places as i32));
    assert!((got - expected).abs() <= half, "{got} is not {printed}");
}

const MM: f64 = 1e3;

#[track_caller]
fn row(got: &Solved, heights: Option<[&str; 2]>, tensions: [&str; 2], force: &str) {
    for i in [0, 1] {
        if let Some(heights) = heights {
            digits(got.height[i] * MM, heights[i]);
        }
        digits(got.tension[i], tensions[i]);
    }
    digits(got.force, force);
}

#[test]
fn derived_values_of_both_fabrics() {
    let s720 = Cell::<f64>::new(&s720(CurveLaw::Published, None)).exact;
    let y = [1500.0, 1500.0].map(|denier: f64| 96e9 * (denier / 9e6) / 1440.0);
    let yarns = [yarn(y[0], 0.0254 / 34.0, 0.0176), yarn(y[1], 0.0254 / 34.0, 0.0094)];
    let s728 = Cell::<f64>::new(&fabric(yarns, CurveLaw::Published, 0.0, None)).exact;
    for (cell, [ea, w0, h1, h2]) in
        [(s720, ["10518.5", "0.63500", "0.120343", "0.095816"]), (s728, ["11111.1", "0.74706", "0.127017", "0.092545"])]
    {
        digits(cell.yarn[0].stiffness, ea);
        digits(cell.yarn[0].half_span * MM, w0);
        digits(cell.yarn[0].height * MM, h1);
        digits(cell.yarn[1].height * MM, h2);
    }
}

#[test]
fn biaxial_rows() {
    let at = |law, compression, warp| Cell::<f64>::new(&s720(law, compression)).solve_from_rest([warp, 1.0]);
    let published = at(CurveLaw::Published, None, 1.010);
    row(&published, Some(["0.105521", "0.110638"]), ["50.0251", "47.4183"], "25.0347");
    let published = at(CurveLaw::Published, None, 1.040);
    row(&published, Some(["0.077421", "0.138739"]), ["277.5448", "154.8446"], "100.5288");
    row(&at(CurveLaw::Variational, None, 1.010), None, ["50.0444", "47.3978"], "19.8285");
    let kawabata = at(CurveLaw::Kawabata, None, 1.010);
    row(&kawabata, Some(["0.116967", "0.122588"]), ["50.0246", "47.3498"], "17.9505");
    let soft = Some(Compression { a: 1e-4, b: 0.192_585_679e-3 });
    let compressible = at(CurveLaw::Published, soft, 1.010);
    row(&compressible, Some(["0.0944415", "0.1007695"]), ["16.2322", "15.1238"], "7.3160");
}

/// The weft stretch at which the weft of a rigid cell becomes taut.
fn free_weft(cell: &Cell<f64>, warp: f64) -> f64 {
    let (mut slack, mut taut) = (0.6, 1.2);
    for _ in 0..60 {
        let middle = 0.5 * (slack + taut);
        if cell.solve_from_rest([warp, middle]).tension[1] > 0.0 { taut = middle } else { slack = middle }
    }
    0.5 * (slack + taut)
}

#[test]
fn uniaxial_extension_with_a_free_weft() {
    for law in [CurveLaw::Published, CurveLaw::Variational] {
        let cell = Cell::<f64>::new(&s720(law, None));
        // Crimp interchange: the warp takes nothing while the weft can follow.
        digits(free_weft(&cell, 1.010), "0.989216");
        for warp in [1.002, 1.010, 1.0217] {
            let e = cell.solve_from_rest([warp, free_weft(&cell, warp) - 1e-9]);
            assert_eq!((e.tension, e.force), ([0.0; 2], 0.0), "{law:?} {warp}");
        }
        // Straight, then linear; the weft lies slack.
        for warp in [1.03, 1.05, 1.057] {
            let e = cell.solve_from_rest([warp, 0.9]);
            let expected = S720_STIFFNESS * (warp / 1.0218 - 1.0);
            assert!((e.tension[0] / expected - 1.0).abs() < 1e-12, "{law:?} {warp}: {e:?}");
            assert_eq!((e.tension[1], e.force), (0.0, 0.0), "{law:?} {warp}");
        }
        // The warp's own strain reaches the failure strain there, and no sooner.
        let strain = |warp| cell.solve_from_rest([warp, 0.9]).strain[0];
        digits(1.0218 * (1.0 + FAILURE_STRAIN), "1.057563");
        assert!((strain(1.0218 * (1.0 + FAILURE_STRAIN)) - FAILURE_STRAIN).abs() < 1e-14);
        assert!(strain(1.057_562) < FAILURE_STRAIN && FAILURE_STRAIN < strain(1.057_564));
    }
}

#[test]
fn the_resting_rigid_cell_is_softer_than_the_straight_yarn() {
    let cell = Cell::<f64>::new(&s720(CurveLaw::Published, None));
    // Small-strain wave along one yarn over the straight-yarn wave, √(dN/dε/EA).
    let stretch = 1e-6;
    let slope = cell.solve_from_rest([1.0 + stretch, 1.0]).tension[0] / stretch;
    assert!(((slope / S720_STIFFNESS).sqrt() - 0.62).abs() < 0.005);
}
