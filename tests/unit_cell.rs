//! The unit cell: tensions, in-plane forces, contact force and heights for given stretches.
//!
//! Promised: over all stretches in [0.5, 1.2], for every law, rigid and compressible, from any start, in double and single
//! precision, the answer is finite, pulls only, solves (13)–(22), grows with both stretches, and is exactly nothing at
//! rest; the conservative laws return all work and the published one does not.
//! Red when: a series coefficient, a sign or term of (17)–(22), the pivot, a stopping rule, the clipping of tension, or a branch
//! of dead yarns is wrong. Answers are compared with 40-digit references and put back into the equations with elliptic integrals
//! from another source (`domain::oracle`); neither knows the solver.

mod domain;

use ripstop::case::{Compression, Crossover, Fabric, Law, MembraneForce, Yarn};
use ripstop::model::unit_cell::{CurveLaw, parameters};
use ripstop::num::scalar::Scalar;
use ripstop::physics::crossover;
use ripstop::physics::unit_cell_parameters::UnitCellParameters;
use serde_json::Value;

use crate::support::{CROSSOVERS, FAILURE_STRAIN, Random, Worst, close, shipped};

/// Calls `$body` with `$law` bound to the kernel type of a [`CurveLaw`].
macro_rules! with_curve_law {
    ($which:expr, $law:ident => $body:expr) => {{
        if $which == CurveLaw::Kawabata {
            type $law = ripstop::model::unit_cell::Kawabata;
            $body
        } else {
            type $law = ripstop::physics::yarn_law::Sinusoidal;
            $body
        }
    }};
}

/// Every law kernel there is.
const LAWS: [CurveLaw; 3] = [CurveLaw::Published, CurveLaw::Variational, CurveLaw::Kawabata];

/// Axial stiffness of S-720: E = 96 GPa, 1420 denier, 1440 kg/m³ [N].
const S720_STIFFNESS: f64 = 96e9 * (1420.0 / 9e6) / 1440.0;
/// Half-span of S-720, 20 yarns per inch [m].
const S720_HALF_SPAN: f64 = 0.0254 / 40.0;
/// Crimps of S-720, warp and weft [-].
const S720_CRIMP: [f64; 2] = [0.0218, 0.0139];
/// A yarn of axial stiffness `stiffness` [N] and half-span `half_span` [m].
fn yarn(stiffness: f64, half_span: f64, crimp: f64) -> Yarn {
    // A section of exactly 1 m² (linear density = fibre density) makes the modulus the stiffness, unrounded.
    Yarn {
        present: true,
        linear_density: DENSITY,
        modulus: stiffness,
        curve: Vec::new(),
        failure_strain: FAILURE_STRAIN,
        strength_retention: 1.0,
        count: 0.5 / half_span,
        crimp,
    }
}

const DENSITY: f64 = 1440.0;

/// A fabric, and the law of its unit cell.
#[derive(Clone, Debug)]
struct Woven {
    fabric: Fabric,
    law: CurveLaw,
}

/// A fabric of two yarns.
fn fabric(yarns: [Yarn; 2], law: CurveLaw, gap: f64, compression: Option<Compression>) -> Woven {
    let [warp, weft] = yarns;
    let own = if law == CurveLaw::Variational { Law::Variational } else { Law::Published };
    let crossover = Crossover { law: own, membrane_force: MembraneForce::Tension, gap, compression };
    let fabric = Fabric {
        name: "test".to_owned(),
        fibre_density: DENSITY,
        areal_density: 0.2552,
        warp,
        weft,
        crossover,
        shear: None,
        thickness: 3e-4,
        rate: None,
    };
    Woven { fabric, law }
}

/// S-720 without a gap.
fn s720(law: CurveLaw, compression: Option<Compression>) -> Woven {
    let yarns = S720_CRIMP.map(|crimp| yarn(S720_STIFFNESS, S720_HALF_SPAN, crimp));
    fabric(yarns, law, 0.0, compression)
}

/// The unit cell of a fabric as one number type sees it.
struct Cell<R> {
    law: CurveLaw,
    /// In double precision.
    exact: UnitCellParameters<f64>,
    constants: UnitCellParameters<R>,
}

/// Equilibrium of one cell, in double precision whatever it was solved in.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Solved {
    tension: [f64; 2],
    in_plane: [f64; 2],
    strain: [f64; 2],
    height: [f64; 2],
    force: f64,
    residual: f64,
    iterations: f64,
    converged: bool,
}

impl<R: Scalar> Cell<R> {
    fn new(woven: &Woven) -> Self {
        let law = woven.law;
        let exact = parameters(&woven.fabric, law);
        let constants = with_curve_law!(law, L => UnitCellParameters::cast::<L>(&exact));
        Self { law, exact, constants }
    }

    /// Solves for stretches Λ from heights [m]; `both`: both yarns are alive and present.
    fn solve(&self, stretch: [f64; 2], warm: [f64; 2], both: bool) -> Solved {
        let excess = stretch.map(|s| R::splat(s - 1.0));
        let warm = warm.map(R::splat);
        let e = with_curve_law!(self.law, L => crossover::solve::<R, L>(&self.constants, excess, warm, both));
        let pair = |x: [R; 2]| x.map(|x| x.to_f64());
        Solved {
            tension: pair(e.tension),
            in_plane: pair(e.in_plane),
            strain: pair(e.strain),
            height: pair(e.height),
            force: e.force.to_f64(),
            residual: e.residual.to_f64(),
            iterations: e.iterations.to_f64(),
            converged: e.converged,
        }
    }

    /// Solves with both yarns alive from the heights at rest.
    fn solve_from_rest(&self, stretch: [f64; 2]) -> Solved {
        self.solve(stretch, self.rest_heights(), true)
    }

    /// Solves with one yarn dead or absent.
    fn solve_free(&self, stretch: [f64; 2]) -> Solved {
        self.solve(stretch, self.rest_heights(), false)
    }

    /// Heights at rest [m].
    fn rest_heights(&self) -> [f64; 2] {
        self.exact.yarn.map(|y| y.height)
    }

    /// Breaking tension EA·0.035 of each yarn [N].
    fn breaking(&self) -> [f64; 2] {
        self.exact.yarn.map(|y| y.stiffness * FAILURE_STRAIN)
    }

    /// Breaking tension of the softer yarn [N].
    fn softer_breaking(&self) -> f64 {
        let [one, two] = self.breaking();
        one.min(two)
    }
}

/// Axial stiffness [N], half-span [m] and crimp [-] of a yarn.
type YarnNumbers = (f64, f64, f64);

const S720: [YarnNumbers; 2] =
    [(S720_STIFFNESS, S720_HALF_SPAN, S720_CRIMP[0]), (S720_STIFFNESS, S720_HALF_SPAN, S720_CRIMP[1])];

fn cell<R: Scalar>(yarns: [YarnNumbers; 2], law: CurveLaw, gap: f64, compression: Option<Compression>) -> Cell<R> {
    Cell::new(&fabric(yarns.map(|(ea, w, c)| yarn(ea, w, c)), law, gap, compression))
}

/// Every law with every kind of crossover.
fn kinds() -> impl Iterator<Item = (CurveLaw, Option<Compression>)> {
    LAWS.into_iter().flat_map(|law| CROSSOVERS.map(|compression| (law, compression)))
}

/// Tension of a yarn that nothing presses [N].
fn free((stiffness, _, crimp): YarnNumbers, stretch: f64) -> f64 {
    stiffness * (stretch / (1.0 + crimp) - 1.0).max(0.0)
}

/// `printed` must be `got` rounded to its last digit.
#[track_caller]
fn digits(got: f64, printed: &str) {
    let places = printed.split_once('.').unwrap().1.len();
    let expected: f64 = printed.parse().unwrap();
    assert!((got - expected).abs() <= 0.500_001 * 10_f64.powi(-(places as i32)), "{got} is not {printed}");
}

#[test]
fn derived_values_of_both_fabrics() {
    for (fabric, printed) in [
        ("s-720", ["10518.5", "0.63500", "0.120343", "0.095816"]),
        ("s-728", ["11111.1", "0.74706", "0.127017", "0.092545"]),
    ] {
        let case = shipped("cases/s720-1ply-155.json", &[&format!("/fabric/file=fabrics/{fabric}.json"), "/expect=[]"]);
        let yarn = Cell::<f64>::new(&Woven { fabric: case.fabric, law: CurveLaw::Published }).exact.yarn;
        let got = [yarn[0].stiffness, 1e3 * yarn[0].half_span, 1e3 * yarn[0].height, 1e3 * yarn[1].height];
        got.into_iter().zip(printed).for_each(|(got, printed)| digits(got, printed));
    }
}

/// Heights [mm], tensions and contact force [N] of the verification table, to their last digit.
#[test]
fn biaxial_rows() {
    let soft = Some(Compression { a: 1e-4, b: 0.192_585_679e-3 });
    let rows = [
        (CurveLaw::Published, None, 1.010, ["0.105521", "0.110638", "50.0251", "47.4183", "25.0347"]),
        (CurveLaw::Published, None, 1.040, ["0.077421", "0.138739", "277.5448", "154.8446", "100.5288"]),
        (CurveLaw::Variational, None, 1.010, ["", "", "50.0444", "47.3978", "19.8285"]),
        (CurveLaw::Kawabata, None, 1.010, ["0.116967", "0.122588", "50.0246", "47.3498", "17.9505"]),
        (CurveLaw::Published, soft, 1.010, ["0.0944415", "0.1007695", "16.2322", "15.1238", "7.3160"]),
    ];
    for (law, compression, warp, printed) in rows {
        let got = Cell::<f64>::new(&s720(law, compression)).solve_from_rest([warp, 1.0]);
        let numbers = [1e3 * got.height[0], 1e3 * got.height[1], got.tension[0], got.tension[1], got.force];
        numbers.into_iter().zip(printed).filter(|(_, p)| !p.is_empty()).for_each(|(got, p)| digits(got, p));
    }
}

/// Weft stretch at which the weft of a rigid cell becomes taut.
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
            close(e.tension[0], free(S720[0], warp), 1e-12);
            assert_eq!((e.tension[1], e.force), (0.0, 0.0), "{law:?} {warp}");
        }
        // The warp's own strain reaches the failure strain there, and no sooner.
        let strain = |warp| cell.solve_from_rest([warp, 0.9]).strain[0];
        assert!((strain(1.0218 * (1.0 + FAILURE_STRAIN)) - FAILURE_STRAIN).abs() < 1e-14);
        assert!(strain(1.057_562) < FAILURE_STRAIN && FAILURE_STRAIN < strain(1.057_564));
    }
}

/// Largest errors of tensions, contact force and heights against `tests/reference/unit_cell.json`, 40-digit solutions by another
/// method in another language, each solved from the heights at rest and from bad starts.
fn reference_errors<R: Scalar>() -> [Worst; 3] {
    let list: Vec<Value> = serde_json::from_str(include_str!("reference/unit_cell.json")).unwrap();
    assert_eq!(list.len(), 726);
    let (mut out, mut random) = (<[Worst; 3]>::default(), Random(7));
    for (index, value) in list.iter().enumerate() {
        let number = |key: &str| value[key].as_f64().unwrap();
        let pair = |suffix: &str| ["warp", "weft"].map(|y| number(&format!("{y}_{suffix}")));
        let law = match value["law"].as_str().unwrap() {
            "published" => CurveLaw::Published,
            "variational" => CurveLaw::Variational,
            _ => CurveLaw::Kawabata,
        };
        let yarns = ["warp", "weft"].map(|y| {
            let of = |key: &str| value[y][key].as_f64().unwrap();
            (of("ea_n"), of("w0_mm") * 1e-3, of("crimp"))
        });
        let rigid = value["rigid"].as_bool().unwrap();
        let compression = (!rigid).then(|| Compression { a: number("a_mm") * 1e-3, b: number("b_mm_n13") * 1e-3 });
        // No height where both yarns are slack.
        let height = (!value["warp_height_mm"].is_null()).then(|| pair("height_mm").map(|h| h * 1e-3));
        let cell = cell::<R>(yarns, law, number("gap_mm") * 1e-3, compression);
        let (top, breaking) = (cell.exact.height_sum, cell.breaking());
        let lost = [random.between(-top, 2.0 * top), random.between(-top, 2.0 * top)];
        let within = [random.between(0.0, top), random.between(0.0, top)];
        for warm in [cell.rest_heights(), [0.0; 2], [top; 2], within, lost] {
            let got = cell.solve(pair("stretch"), warm, true);
            let place = || format!("record {index}: {law:?} from {warm:?}: {got:?}");
            assert!(got.converged, "{}", place());
            for i in [0, 1] {
                out[0].see((got.tension[i] - pair("tension_n")[i]) / breaking[i], place);
                out[0].see((got.in_plane[i] - pair("in_plane_n")[i]) / breaking[i], place);
                if let Some(height) = height {
                    out[2].see((got.height[i] - height[i]) / top, place);
                }
            }
            out[1].see((got.force - number("contact_force_n")) / cell.softer_breaking(), place);
        }
    }
    out
}

#[test]
fn every_reference_record() {
    // The accepted residual, 1e-12 EA or 3e-11 of the breaking force, is the error of F; that of T is up to
    // 1/(2 sin α) times as large. The residual moves a height most where compression is softest, at F → 0.
    let double = [1.5e-10, 5e-11, 1.5e-10];
    // 1e-5 of the breaking tension is what single precision owes. Heights are known to 2^-23 of their sum times the softness.
    let single = [1e-5, 1e-5, 1e-4];
    for (errors, limits) in [(reference_errors::<f64>(), double), (reference_errors::<f32>(), single)] {
        errors.iter().zip(limits).for_each(|(error, limit)| error.assert_at_most(limit));
    }
}

/// Rest to the last bit, in both precisions: waves must not start in fabric that nothing has reached.
#[test]
fn fabric_at_rest_is_exactly_free_of_tension() {
    let s728 = 0.0254 / 34.0;
    let mut fabrics = vec![
        S720,
        [S720[1], S720[0]],
        [(11111.1, s728, 0.0176), (11111.1, s728, 0.0094)],
        [(1e6, 6e-4, 0.01), (1e3, 9e-4, 0.03)],
        [(1e4, 6e-4, 0.0), (1e4, 6e-4, 0.02)],
        [(1e4, 6e-4, 0.02), (1e4, 6e-4, 0.0)],
        [(1e4, 6e-4, 0.0), (1e4, 6e-4, 0.0)],
        [(1e4, 5e-4, 0.25), (5.6e4, 1.8e-4, 0.0019)],
        [(1e4, 5e-4, 0.0166), (2e6, 4.9e-4, 1.5e-6)],
    ];
    let mut random = Random(11);
    for _ in 0..100 {
        let (any, small) = (random.between(0.01, 0.25), 10_f64.powf(random.between(-9.0, -2.0)));
        // Heights within a factor of about three of each other, and one almost straight yarn.
        fabrics.push([(1e4, 6e-4, random.between(0.05, 0.25)), (2e4, 6e-4, random.between(0.03, 0.25))]);
        fabrics.push([(1e4, 6e-4, any), (2e4, 6e-4, small)]);
        fabrics.push([(1e4, 6e-4, small), (2e3, 6e-4, any)]);
    }
    for yarns in fabrics {
        for ((law, compression), gap) in kinds().flat_map(|kind| [0.0, 5e-6].map(|gap| (kind, gap))) {
            let double = cell::<f64>(yarns, law, gap, compression).solve_from_rest([1.0; 2]);
            let single = cell::<f32>(yarns, law, gap, compression).solve_from_rest([1.0; 2]);
            for got in [double, single] {
                let exact = (got.tension, got.in_plane, got.force, got.residual, got.converged);
                assert_eq!(exact, ([0.0; 2], [0.0; 2], 0.0, 0.0, true), "{law:?} {yarns:?} {gap} {got:?}");
            }
        }
    }
}

#[test]
fn where_a_yarn_is_absent_or_dead_the_other_straightens_freely() {
    for ((law, compression), absent) in kinds().flat_map(|kind| [(kind, 0), (kind, 1)]) {
        let other = 1 - absent;
        let mut yarns = S720.map(|(ea, w, c)| yarn(ea, w, c));
        let dead = Cell::<f64>::new(&fabric(yarns.clone(), law, 0.0, compression));
        yarns[absent].present = false;
        let gone = Cell::<f64>::new(&fabric(yarns, law, 0.0, compression));
        assert_eq!(gone.exact.yarn[absent].stiffness, 0.0);
        for stretch in [0.7, 1.0, 1.0138, 1.0219, 1.05, 1.2] {
            let mut pair = [1.1; 2];
            pair[other] = stretch;
            for got in [gone.solve_free(pair), dead.solve_free(pair)] {
                // The allowance that keeps the resting yarn slack: a few roundings of its crimp.
                let error = got.tension[other] - free(S720[other], stretch);
                assert!(error.abs() <= 1e-15 * S720_STIFFNESS, "{law:?} {stretch}: {error:e}");
                assert_eq!(got.in_plane[other], got.tension[other]);
                assert_eq!((got.force, got.iterations, got.residual, got.converged), (0.0, 0.0, 0.0, true), "{law:?}");
            }
            let got = gone.solve_free(pair);
            assert_eq!((got.tension[absent], got.in_plane[absent]), (0.0, 0.0), "{law:?}");
        }
    }
}

/// Crossovers that hardly resist at first touch: there a rounding of a yarn's strain moves the heights by as much as they are.
#[test]
fn a_crossover_soft_at_first_touch_keeps_forces_to_roundings_in_single_precision() {
    let weft = (10_518.5, 6.35e-4, 0.0139);
    let soft = [
        ([(10_518.5, 8.37e-4, 0.135), weft], Compression { a: 1.637e-4, b: 9.587e-6 }),
        ([(10_518.5, 8.236e-4, 0.1785), weft], Compression { a: 1.637e-4, b: 5e-6 }),
        ([(5382.0, 1.1556e-3, 0.179), weft], Compression { a: 2.262e-4, b: 1.309e-5 }),
    ];
    let small = [-1e-6, -1e-8, 0.0, 3e-9, 2e-8, 5e-8, 8e-8, 2e-7, 7e-7, 3e-6, 2e-5, 1e-4];
    let mut worst = Worst::default();
    for ((yarns, compression), law) in soft.into_iter().flat_map(|soft| LAWS.map(|law| (soft, law))) {
        let single = cell::<f32>(yarns, law, 0.0, Some(compression));
        let double = cell::<f64>(yarns, law, 0.0, Some(compression));
        let mut warm = single.rest_heights();
        for stretch in small.iter().flat_map(|warp| small.map(|weft| [1.0 + warp, 1.0 + weft])) {
            let exact = double.solve(stretch, warm, true);
            let got = single.solve(stretch, warm, true);
            assert!(got.converged, "{law:?} {stretch:?} {got:?}");
            for i in 0..2 {
                worst.see((got.in_plane[i] - exact.in_plane[i]) / yarns[i].0, || format!("{law:?} {stretch:?}"));
            }
            warm = got.height;
        }
    }
    // In strains. Half a unit in the last place each of the crimp, the arc's length and their difference, and of the heights.
    worst.assert_at_most(3.0 * f64::from(f32::EPSILON));
}
