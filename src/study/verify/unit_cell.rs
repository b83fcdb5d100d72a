//! Unit cell rows: S-720, weft held at its length.

use super::Check;
use crate::case::{Compression, Crossover, Fabric, Law, MembraneForce, Yarn};
use crate::kernels::crossover::Equilibrium;
use crate::model::unit_cell_curve::{CurveLaw, solve_with};

const GROUP: &str = "unit cell";
const SOURCE: &str = "independent 40-digit solution of (11)-(24)";

/// Law, whether compressible, warp stretch, and (quantity, value) pairs; mm and N.
type Entry = (CurveLaw, bool, f64, &'static [(&'static str, f64)]);

const TABLE: &[Entry] = &[
    (
        CurveLaw::Published,
        false,
        1.010,
        &[("h1", 0.105521), ("h2", 0.110638), ("T1", 50.0251), ("T2", 47.4183), ("F", 25.0347)],
    ),
    (
        CurveLaw::Published,
        false,
        1.040,
        &[("h1", 0.077421), ("h2", 0.138739), ("T1", 277.5448), ("T2", 154.8446), ("F", 100.5288)],
    ),
    (CurveLaw::Variational, false, 1.010, &[("T1", 50.0444), ("T2", 47.3978), ("F", 19.8285)]),
    (
        CurveLaw::Kawabata,
        false,
        1.010,
        &[("h1", 0.116967), ("h2", 0.122588), ("T1", 50.0246), ("T2", 47.3498), ("F", 17.9505)],
    ),
    (
        CurveLaw::Published,
        true,
        1.010,
        &[("h1", 0.0944415), ("h2", 0.1007695), ("T1", 16.2322), ("T2", 15.1238), ("F", 7.3160)],
    ),
];

/// S-720 as in Table I; compressible with the constants of the reference values.
fn fabric(compressible: bool) -> Fabric {
    let yarn = |crimp| Yarn {
        present: true,
        linear_density: 1420.0 / 9e6,
        modulus: 96e9,
        failure_strain: 0.035,
        count: 20.0 / 0.0254,
        crimp,
    };
    let compression = compressible.then_some(Compression { a: 1e-4, b: 0.192_585_679e-3 });
    Fabric {
        name: "S-720".into(),
        fibre_density: 1440.0,
        areal_density: 0.2552,
        warp: yarn(0.0218),
        weft: yarn(0.0139),
        crossover: Crossover { law: Law::Published, membrane_force: MembraneForce::Tension, gap: 0.0, compression },
        shear: None,
        thickness: 3e-4,
    }
}

/// Equilibrium of a fabric's unit cell under stretches beyond 1 along warp and weft, without a warm start.
pub(crate) fn solve(fabric: &Fabric, law: CurveLaw, [warp, weft]: [f64; 2]) -> Equilibrium<f64> {
    solve_with(fabric, law, &[1.0 + warp], &[1.0 + weft])[0].cell
}

/// The table, and the two closed forms of uniaxial extension with free weft.
pub(super) fn rows(keep: &mut dyn FnMut(Check)) {
    for (law, compressible, stretch, values) in TABLE {
        let e = solve(&fabric(*compressible), *law, [stretch - 1.0, 0.0]);
        for (name, expected) in *values {
            let got = match *name {
                "h1" => e.height[0] * 1e3,
                "h2" => e.height[1] * 1e3,
                "T1" => e.tension[0],
                "T2" => e.tension[1],
                _ => e.force,
            };
            let unit = if name.starts_with('h') { "mm" } else { "N" };
            let kind = if *compressible { "compressible" } else { "rigid" };
            let law = format!("{law:?}").to_lowercase();
            // Half a unit of the last digit tabulated, with room for its own rounding.
            let tolerance = if unit == "N" {
                6e-5
            } else if *compressible {
                6e-8
            } else {
                6e-7
            };
            let what = format!("{law}, {kind}, warp {stretch}: {name} [{unit}]");
            keep(number(&what, *expected, got, tolerance, SOURCE));
        }
    }
    let rigid = fabric(false);
    let what = "crimp interchange at warp 1.010: weft stretch where tension ends";
    keep(number(what, 0.989216, onset(&rigid), 6e-7, SOURCE));
    let strain = |x: f64| (x - 1.0218) / 1.0218;
    let stretch = 1.0218 * 1.035;
    let e = solve(&rigid, CurveLaw::Published, [stretch - 1.0, -0.1]);
    let what = "uniaxial, weft free: warp strain at stretch 1.057563";
    keep(number(what, 0.035, strain(stretch), 1e-9, "(14), (17)"));
    let tension = 0.035 * 96e9 * 1420.0 / 9e6 / 1440.0;
    keep(number("uniaxial, weft free: warp tension there [N]", tension, e.tension[0], 1e-6, "(17)"));
}

/// A number against an expected one.
fn number(name: &str, expected: f64, got: f64, tolerance: f64, source: &str) -> Check {
    Check {
        group: GROUP,
        name: name.to_owned(),
        expected: format!("{expected}"),
        got: format!("{got:.7}"),
        tolerance: format!("±{tolerance:.1e}"),
        source: source.to_owned(),
        pass: (got - expected).abs() <= tolerance,
    }
}

/// Weft stretch at which the cell stretched by 1.010 along the warp becomes slack, by bisection.
fn onset(fabric: &Fabric) -> f64 {
    let (mut slack, mut taut) = (0.9, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (slack + taut);
        if solve(fabric, CurveLaw::Published, [0.01, middle - 1.0]).tension[1] > 0.0 {
            taut = middle;
        } else {
            slack = middle;
        }
    }
    taut
}
