//! The unit cell: tensions, in-plane forces, contact force and heights for given stretches.
//!
//! Promised: over all stretches in [0.5, 1.2], for every law, rigid and compressible, from any start, in double and single
//! precision, the answer is finite, pulls only, solves (13)–(22), grows with both stretches, and is exactly nothing at
//! rest; the conservative laws return all work and the published one does not.
//!
//! How it goes red: answers are compared with 40-digit references and put back into the equations with elliptic
//! integrals from another source (`support::oracle`); neither knows the solver. Mutants seen to fail: series
//! coefficients and derivatives of the arc length, (17)–(22) with a sign, factor or term changed, swapped pivot, bracket
//! and stopping rules of the iteration, tension not clipped, rest heights, the crimp margin at rest, branches of dead yarns.

#![allow(clippy::print_stderr, reason = "the loss of the published law is shown with --nocapture")]

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use ripstop::case::Compression;
use ripstop::kernels::crossover::{self, Variant};
use ripstop::number::Scalar;

use crate::support::{
    CROSSOVERS, Cell, FAILURE_STRAIN, LAWS, Random, S720_CRIMP, S720_HALF_SPAN, S720_STIFFNESS, Solved, Worst, fabric,
    oracle, s720, yarn,
};

/// Against `tests/reference/unit_cell.json`: 40-digit solutions by another method in another language.
mod reference {
    use super::*;
    use serde_json::Value;

    struct Record {
        place: String,
        fabric: ripstop::case::Fabric,
        stretch: [f64; 2],
        tension: [f64; 2],
        in_plane: [f64; 2],
        force: f64,
        /// None where both yarns are slack.
        height: Option<[f64; 2]>,
    }

    /// Every record; one of the published law gives two, one for each choice of in-plane force.
    fn records() -> Vec<Record> {
        let list: Vec<Value> = serde_json::from_str(include_str!("reference/unit_cell.json")).unwrap();
        assert_eq!(list.len(), 726);
        list.iter().enumerate().flat_map(|(index, value)| record(index, value)).collect()
    }

    fn record(index: usize, value: &Value) -> Vec<Record> {
        let number = |key: &str| value[key].as_f64().unwrap();
        let pair = |suffix: &str| ["warp", "weft"].map(|y| number(&format!("{y}_{suffix}")));
        let laws: &[(Variant, &str)] = match value["law"].as_str().unwrap() {
            "published" => &[(Variant::PublishedTension, "in_plane_n"), (Variant::PublishedProjected, "projected_n")],
            "variational" => &[(Variant::Variational, "in_plane_n")],
            "kawabata" => &[(Variant::Kawabata, "in_plane_n")],
            other => panic!("record {index}: law {other}"),
        };
        let yarns = ["warp", "weft"].map(|y| {
            let of = |key: &str| value[y][key].as_f64().unwrap();
            yarn(of("ea_n"), of("w0_mm") * 1e-3, of("crimp"))
        });
        let rigid = value["rigid"].as_bool().unwrap();
        let compression = (!rigid).then(|| Compression { a: number("a_mm") * 1e-3, b: number("b_mm_n13") * 1e-3 });
        let slack = value["warp_height_mm"].is_null();
        let build = |&(law, in_plane): &(Variant, &str)| Record {
            place: format!("record {index}: {law:?} {} {:?} rigid {rigid}", value["fabric"], pair("stretch")),
            fabric: fabric(yarns.clone(), law, number("gap_mm") * 1e-3, compression),
            stretch: pair("stretch"),
            tension: pair("tension_n"),
            in_plane: pair(in_plane),
            force: number("contact_force_n"),
            height: (!slack).then(|| pair("height_mm").map(|h| h * 1e-3)),
        };
        laws.iter().map(build).collect()
    }

    /// Largest errors over all records, each solved from the heights at rest and from bad starts.
    #[derive(Default)]
    struct Errors {
        tension: Worst,
        force: Worst,
        height: Worst,
    }

    fn errors<R: Scalar>(wanted: impl Fn(&Record) -> bool) -> Errors {
        let mut out = Errors::default();
        let mut random = Random(7);
        for r in records().iter().filter(|r| wanted(r)) {
            let cell = Cell::<R>::new(&r.fabric);
            let top = cell.exact.height_sum;
            let breaking = cell.breaking();
            let lost = [random.between(-top, 2.0 * top), random.between(-top, 2.0 * top)];
            let within = [random.between(0.0, top), random.between(0.0, top)];
            for warm in [cell.rest_heights(), [0.0; 2], [top; 2], within, lost] {
                let got = cell.solve(r.stretch, warm, true);
                let place = || format!("{} from {warm:?}: {got:?}", r.place);
                assert!(got.converged, "{}", place());
                for i in [0, 1] {
                    out.tension.see((got.tension[i] - r.tension[i]) / breaking[i], place);
                    out.tension.see((got.in_plane[i] - r.in_plane[i]) / breaking[i], place);
                    if let Some(height) = r.height {
                        out.height.see((got.height[i] - height[i]) / top, place);
                    }
                }
                out.force.see((got.force - r.force) / cell.softer_breaking(), place);
            }
        }
        out
    }

    #[test]
    fn every_record_in_double_precision() {
        let e = errors::<f64>(|_| true);
        // The accepted residual, 1e-12 EA or 3e-11 of the breaking force, is the error of F; that of T is up to
        // 1/(2 sin α) times as large. The residual moves a height most where compression is softest, at F → 0.
        e.tension.assert_at_most(1.5e-10);
        e.force.assert_at_most(5e-11);
        e.height.assert_at_most(1.5e-10);
    }

    /// Tolerance: what single precision owes, 1e-5 of the breaking tension. Heights are known to 2^-23 of their sum
    /// times the softness of the crossover at F → 0.
    fn single_precision(fabrics: &[&str]) {
        let e = errors::<f32>(|r| fabrics.iter().any(|name| r.place.contains(name)));
        e.tension.assert_at_most(1e-5);
        e.force.assert_at_most(1e-5);
        e.height.assert_at_most(1e-4);
    }

    #[test]
    fn every_record_in_single_precision() {
        single_precision(&["S-720", "S-728", "unbalanced"]);
    }

    #[test]
    fn every_record_of_the_high_crimp_fabric_in_single_precision() {
        single_precision(&["high-crimp"]);
    }
}

/// The numbers printed in the verification table, to their last digit.
mod printed {
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
        let s720 = Cell::<f64>::new(&s720(Variant::PublishedTension, None)).exact;
        let y = [1500.0, 1500.0].map(|denier: f64| 96e9 * (denier / 9e6) / 1440.0);
        let yarns = [yarn(y[0], 0.0254 / 34.0, 0.0176), yarn(y[1], 0.0254 / 34.0, 0.0094)];
        let s728 = Cell::<f64>::new(&fabric(yarns, Variant::PublishedTension, 0.0, None)).exact;
        for (cell, [ea, w0, h1, h2]) in [
            (s720, ["10518.5", "0.63500", "0.120343", "0.095816"]),
            (s728, ["11111.1", "0.74706", "0.127017", "0.092545"]),
        ] {
            digits(cell.yarn[0].stiffness, ea);
            digits(cell.yarn[0].half_span * MM, w0);
            digits(cell.yarn[0].height * MM, h1);
            digits(cell.yarn[1].height * MM, h2);
        }
    }

    #[test]
    fn biaxial_rows() {
        let at = |law, compression, warp| Cell::<f64>::new(&s720(law, compression)).solve_from_rest([warp, 1.0]);
        let published = at(Variant::PublishedTension, None, 1.010);
        row(&published, Some(["0.105521", "0.110638"]), ["50.0251", "47.4183"], "25.0347");
        let published = at(Variant::PublishedTension, None, 1.040);
        row(&published, Some(["0.077421", "0.138739"]), ["277.5448", "154.8446"], "100.5288");
        row(&at(Variant::Variational, None, 1.010), None, ["50.0444", "47.3978"], "19.8285");
        let kawabata = at(Variant::Kawabata, None, 1.010);
        row(&kawabata, Some(["0.116967", "0.122588"]), ["50.0246", "47.3498"], "17.9505");
        let soft = Some(Compression { a: 1e-4, b: 0.192_585_679e-3 });
        let compressible = at(Variant::PublishedTension, soft, 1.010);
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
        for law in [Variant::PublishedTension, Variant::Variational] {
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
        let cell = Cell::<f64>::new(&s720(Variant::PublishedTension, None));
        // Small-strain wave along one yarn over the straight-yarn wave, √(dN/dε/EA).
        let stretch = 1e-6;
        let slope = cell.solve_from_rest([1.0 + stretch, 1.0]).tension[0] / stretch;
        assert!(((slope / S720_STIFFNESS).sqrt() - 0.62).abs() < 0.005);
    }
}

/// The whole domain Λ1, Λ2 ∈ [0.5, 1.2].
mod domain {
    use super::*;

    /// What a tension may fall by where it should rise, over the breaking tension: the residual accepted, 1e-12 EA,
    /// over 2 sin α, for two solutions (double); the roundings of a strain near 1 (single).
    const RIPPLE: [f64; 2] = [3e-10, 1e-5];

    struct Sweep<R> {
        cell: Cell<R>,
        ripple: f64,
        rising: Worst,
        misfit: [Worst; 3],
    }

    impl<R: Scalar> Sweep<R> {
        fn new(law: Variant, compression: Option<Compression>) -> Self {
            let ripple = RIPPLE[usize::from(R::EPSILON > 1e-10)];
            let cell = Cell::new(&s720(law, compression));
            Self { cell, ripple, rising: Worst::default(), misfit: Default::default() }
        }

        /// Solves one point and checks it against the points left of and below it.
        fn visit(&mut self, stretch: [f64; 2], warm: [f64; 2], before: [Option<&Solved>; 2]) -> Solved {
            let got = self.cell.solve(stretch, warm, true);
            let place = || format!("{:?} {stretch:?} {got:?}", self.cell.law);
            assert!(sound(&got), "{}", place());
            let breaking = self.cell.breaking();
            for earlier in before.into_iter().flatten() {
                for i in [0, 1] {
                    self.rising.see(((earlier.tension[i] - got.tension[i]) / breaking[i]).max(0.0), place);
                }
            }
            let m = oracle::misfit(&self.cell, stretch, &got);
            for (worst, error) in self.misfit.iter_mut().zip([m.tension, m.force, m.height]) {
                worst.see(error, place);
            }
            got
        }

        fn assert_rising(&self) {
            self.rising.assert_at_most(self.ripple);
        }
    }

    fn sound(got: &Solved) -> bool {
        let numbers = [got.tension, got.in_plane, got.strain, got.height, [got.force, got.residual]];
        let finite = numbers.iter().flatten().all(|x| x.is_finite());
        let pulling = [got.tension, got.in_plane].iter().flatten().all(|t| *t >= 0.0);
        finite && pulling && got.force >= 0.0 && got.converged
    }

    /// 141 × 141 points, each started from the solution beside it as in a run.
    #[test]
    fn grid_of_the_whole_domain() {
        const POINTS: usize = 141;
        for law in LAWS {
            for compression in CROSSOVERS {
                let mut double = Sweep::<f64>::new(law, compression);
                let mut single = Sweep::<f32>::new(law, compression);
                let mut apart = Worst::default();
                let breaking = double.cell.breaking();
                let mut below: Vec<(Solved, Solved)> = Vec::new();
                for j in 0..POINTS {
                    let mut row: Vec<(Solved, Solved)> = Vec::with_capacity(POINTS);
                    for i in 0..POINTS {
                        let stretch = [i, j].map(|n| 0.5 + 0.7 * n as f64 / (POINTS - 1) as f64);
                        let (left, under) = (row.last(), below.get(i));
                        let warm = left.map_or(double.cell.rest_heights(), |p| p.0.height);
                        let d = double.visit(stretch, warm, [left.map(|p| &p.0), under.map(|p| &p.0)]);
                        let warm = left.map_or(single.cell.rest_heights(), |p| p.1.height);
                        let s = single.visit(stretch, warm, [left.map(|p| &p.1), under.map(|p| &p.1)]);
                        for y in [0, 1] {
                            let place = || format!("{law:?} {compression:?} {stretch:?} {d:?} {s:?}");
                            apart.see((d.tension[y] - s.tension[y]) / breaking[y], place);
                            apart.see((d.in_plane[y] - s.in_plane[y]) / breaking[y], place);
                        }
                        row.push((d, s));
                    }
                    below = row;
                }
                double.assert_rising();
                single.assert_rising();
                // Residual of 1e-12 EA; tensions follow from the heights to rounding; heights add up to rounding.
                double.misfit[0].assert_at_most(1e-13);
                double.misfit[1].assert_at_most(5e-11);
                double.misfit[2].assert_at_most(1e-15);
                // What single precision owes (the verification table).
                apart.assert_at_most(1e-5);
            }
        }
    }

    /// A fabric and where to look at it.
    #[derive(Clone, Debug)]
    struct Probe {
        fabric: ripstop::case::Fabric,
        stretch: [f64; 2],
        /// Where the iteration starts, over the sum of heights.
        warm: [f64; 2],
        /// Further stretch.
        more: f64,
    }

    fn crimp() -> impl Strategy<Value = f64> {
        prop_oneof![1 => Just(0.0), 6 => 0.0..0.25, 2 => (-4.0..-0.6_f64).prop_map(|e| 10_f64.powf(e)), 1 => Just(0.25)]
    }

    fn compressions() -> impl Strategy<Value = Option<Compression>> {
        let soft = (1e-5..2e-4, 0.5..3.0).prop_map(|(a, ratio): (f64, f64)| Some(Compression { a, b: ratio * a }));
        prop_oneof![1 => Just(None), 2 => soft]
    }

    fn any_fabric() -> impl Strategy<Value = ripstop::case::Fabric> {
        let stiffness = (3.0..5.0_f64, -3.0..3.0_f64).prop_map(|(e, r)| [10_f64.powf(e), 10_f64.powf(e + r)]);
        let span = (3e-4..1e-3, -1.0..1.0_f64).prop_map(|(w, r)| [w, w * 3_f64.powf(r)]);
        let gap = prop_oneof![1 => Just(0.0), 1 => 0.0..5e-5];
        let law = prop::sample::select(LAWS.to_vec());
        (stiffness, span, [crimp(), crimp()], law, gap, compressions()).prop_map(|(ea, w, c, law, gap, compression)| {
            fabric([0, 1].map(|i| yarn(ea[i], w[i], c[i])), law, gap, compression)
        })
    }

    fn any_probe() -> impl Strategy<Value = Probe> {
        let stretch = prop_oneof![[0.5..1.2, 0.5..1.2], [0.95..1.06, 0.95..1.06]];
        let more = (-9.0..-1.0_f64).prop_map(|e| 10_f64.powf(e));
        (any_fabric(), stretch, [-0.5..1.5, -0.5..1.5], more).prop_map(|(fabric, stretch, warm, more)| Probe {
            fabric,
            stretch,
            warm,
            more,
        })
    }

    /// Everything that must hold at one probe in one precision; the tensions there and further out.
    fn hold<R: Scalar>(probe: &Probe, ripple: f64) -> Result<Solved, TestCaseError> {
        let cell = Cell::<R>::new(&probe.fabric);
        let warm = probe.warm.map(|w| w * cell.exact.height_sum);
        let here = cell.solve(probe.stretch, warm, true);
        prop_assert!(sound(&here), "{} {here:?}", R::NAME);
        for grown in 0..2 {
            let mut stretch = probe.stretch;
            stretch[grown] += probe.more;
            let there = cell.solve(stretch, here.height, true);
            prop_assert!(sound(&there), "{} {there:?}", R::NAME);
            for i in [0, 1] {
                let fall = (here.tension[i] - there.tension[i]) / cell.breaking()[i];
                prop_assert!(fall <= ripple, "{} yarn {i} falls {fall:e}: {here:?} {there:?}", R::NAME);
            }
        }
        Ok(here)
    }

    fn config(cases: u32) -> ProptestConfig {
        ProptestConfig {
            cases,
            failure_persistence: None,
            rng_seed: RngSeed::Fixed(20_060_720),
            ..ProptestConfig::default()
        }
    }

    proptest! {
        #![proptest_config(config(20_000))]

        #[test]
        fn any_fabric_in_double_precision(probe in any_probe()) {
            let got = hold::<f64>(&probe, 1e-8)?;
            let cell = Cell::<f64>::new(&probe.fabric);
            let m = oracle::misfit(&cell, probe.stretch, &got);
            // Up to an end slope of 1.5 the arc length is exact; beyond, its twelve terms leave what they leave. A soft
            // crossover turns the rounding of F into 1e-15 m of height, and a taut straight yarn that into a force.
            let steepest = [0, 1].map(|i| got.height[i] / cell.exact.yarn[i].half_span / probe.stretch[i]);
            let exact = steepest.iter().all(|k| std::f64::consts::FRAC_PI_2 * k.abs() <= 1.5);
            let limit = if exact { [1e-9, 1e-7] } else { [1e-5, 1e-5] };
            prop_assert!(m.tension <= limit[0] && m.force <= limit[1] && m.height <= 1e-11, "{m:?} {got:?}");
        }

        #[test]
        fn any_fabric_in_single_precision(probe in any_probe()) {
            hold::<f32>(&probe, 1e-4)?;
        }

        #[test]
        fn any_s720_in_single_precision_agrees_with_double(
            stretch in [0.5..1.2, 0.5..1.2],
            law in prop::sample::select(LAWS.to_vec()),
            compression in prop::sample::select(CROSSOVERS.to_vec()),
            warm in [-0.5..1.5, -0.5..1.5],
        ) {
            let fabric = s720(law, compression);
            let (double, single) = (Cell::<f64>::new(&fabric), Cell::<f32>::new(&fabric));
            let warm = warm.map(|w| w * double.exact.height_sum);
            let (d, s) = (double.solve(stretch, warm, true), single.solve(stretch, warm, true));
            for i in [0, 1] {
                let limit = 1e-5 * double.breaking()[i];
                prop_assert!((d.tension[i] - s.tension[i]).abs() < limit, "{d:?} {s:?}");
                prop_assert!((d.in_plane[i] - s.in_plane[i]).abs() < limit, "{d:?} {s:?}");
            }
        }
    }
}

/// The places where the equations change their form.
mod branches {
    use super::*;

    const S720: [(f64, f64, f64); 2] =
        [(S720_STIFFNESS, S720_HALF_SPAN, S720_CRIMP[0]), (S720_STIFFNESS, S720_HALF_SPAN, S720_CRIMP[1])];

    fn cell<R: Scalar>(
        yarns: [(f64, f64, f64); 2],
        law: Variant,
        gap: f64,
        compression: Option<Compression>,
    ) -> Cell<R> {
        Cell::new(&fabric(yarns.map(|(ea, w, c)| yarn(ea, w, c)), law, gap, compression))
    }

    /// Tension of a yarn that nothing presses [N].
    fn free(yarn: (f64, f64, f64), stretch: f64) -> f64 {
        yarn.0 * (stretch / (1.0 + yarn.2) - 1.0).max(0.0)
    }

    #[track_caller]
    fn close(got: f64, expected: f64, relative: f64) {
        assert!((got - expected).abs() <= relative * expected.abs(), "{got} is not {expected}");
    }

    /// Bit for bit, in both precisions: waves must not start in fabric that nothing has reached.
    fn assert_rests(yarns: [(f64, f64, f64); 2]) {
        for law in LAWS {
            for compression in CROSSOVERS {
                for gap in [0.0, 5e-6] {
                    let double = cell::<f64>(yarns, law, gap, compression).solve_from_rest([1.0; 2]);
                    let single = cell::<f32>(yarns, law, gap, compression).solve_from_rest([1.0; 2]);
                    for got in [double, single] {
                        let place = || format!("{law:?} {yarns:?} {gap} {got:?}");
                        assert_eq!((got.tension, got.in_plane), ([0.0; 2], [0.0; 2]), "{}", place());
                        assert_eq!((got.force, got.residual, got.converged), (0.0, 0.0, true), "{}", place());
                    }
                }
            }
        }
    }

    #[test]
    fn fabric_at_rest_is_exactly_free_of_tension() {
        let s728 = 0.0254 / 34.0;
        assert_rests(S720);
        assert_rests([S720[1], S720[0]]);
        assert_rests([(11111.1, s728, 0.0176), (11111.1, s728, 0.0094)]);
        assert_rests([(1e4, 6.35e-4, 0.25), (1e4, 6.35e-4, 0.12)]);
        assert_rests([(1e6, 6e-4, 0.01), (1e3, 9e-4, 0.03)]);
        assert_rests([(1e4, 6e-4, 0.0), (1e4, 6e-4, 0.02)]);
        assert_rests([(1e4, 6e-4, 0.02), (1e4, 6e-4, 0.0)]);
        assert_rests([(1e4, 6e-4, 0.0), (1e4, 6e-4, 0.0)]);
        let mut random = Random(11);
        for _ in 0..200 {
            // Heights within a factor of about three of each other.
            assert_rests([(1e4, 6e-4, random.between(0.05, 0.25)), (2e4, 6e-4, random.between(0.03, 0.25))]);
        }
    }

    #[test]
    fn fabric_of_one_almost_straight_yarn_rests_too() {
        assert_rests([(1e4, 5e-4, 0.25), (5.6e4, 1.8e-4, 0.0019)]);
        assert_rests([(1e4, 5e-4, 0.0166), (2e6, 4.9e-4, 1.5e-6)]);
        let mut random = Random(12);
        for _ in 0..200 {
            let small = 10_f64.powf(random.between(-9.0, -2.0));
            assert_rests([(1e4, 6e-4, random.between(0.01, 0.25)), (2e4, 6e-4, small)]);
            assert_rests([(1e4, 6e-4, small), (2e3, 6e-4, random.between(0.01, 0.25))]);
        }
    }

    #[test]
    fn slack_yarns_carry_nothing_at_all() {
        for law in LAWS {
            for compression in CROSSOVERS {
                for stretch in [[0.5, 0.5], [0.99, 0.99], [1.005, 0.97], [0.97, 1.002]] {
                    let d = cell::<f64>(S720, law, 0.0, compression).solve_from_rest(stretch);
                    let s = cell::<f32>(S720, law, 0.0, compression).solve_from_rest(stretch);
                    for got in [d, s] {
                        assert_eq!((got.tension, got.force), ([0.0; 2], 0.0), "{law:?} {stretch:?}");
                        assert!(got.strain.iter().all(|e| *e < 0.0), "{law:?} {stretch:?} {got:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_straight_taut_yarn_beside_a_slack_one_carries_tension_without_contact() {
        for law in LAWS {
            for compression in CROSSOVERS {
                let c = cell::<f64>(S720, law, 0.0, compression);
                for (pulled, other, stretch) in [(0, 1, [1.05, 0.8]), (1, 0, [0.8, 1.05])] {
                    let got = c.solve_from_rest(stretch);
                    close(got.tension[pulled], free(S720[pulled], 1.05), 1e-13);
                    close(got.in_plane[pulled], got.tension[pulled], 1e-13);
                    assert_eq!((got.tension[other], got.in_plane[other], got.force), (0.0, 0.0, 0.0), "{law:?}");
                    assert_eq!(got.height[pulled], 0.0, "{law:?}");
                    assert!(got.strain[other] < 0.0, "{law:?}");
                }
            }
        }
    }

    #[test]
    fn without_crimp_or_with_a_gap_wider_than_the_heights_nothing_presses() {
        for law in LAWS {
            for compression in CROSSOVERS {
                let straight = [(1e4, 6e-4, 0.0), (2e4, 9e-4, 0.0)];
                let heights = cell::<f64>(S720, law, 0.0, None).rest_heights();
                let wide = 1.001 * (heights[0] + heights[1]);
                for (yarns, gap) in [(straight, 0.0), (straight, 1e-5), (S720, wide), (S720, 1e-3)] {
                    let (d, s) = (cell::<f64>(yarns, law, gap, compression), cell::<f32>(yarns, law, gap, compression));
                    assert_eq!(d.exact.height_sum, 0.0);
                    for stretch in [[1.03, 1.02], [0.9, 1.04], [1.06, 0.5], [0.99, 0.98]] {
                        let (d, s) = (d.solve_from_rest(stretch), s.solve_from_rest(stretch));
                        assert_eq!((d.force, s.force, d.iterations), (0.0, 0.0, 0.0), "{law:?} {stretch:?}");
                        for i in [0, 1] {
                            let expected = free(yarns[i], stretch[i]);
                            close(d.tension[i], expected, 1e-12);
                            assert_eq!(d.in_plane[i], d.tension[i]);
                            // 2^-24 of the length, and the crimp's allowance at rest.
                            assert!((s.tension[i] - expected).abs() < 3e-6 * FAILURE_STRAIN * yarns[i].0, "{s:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_gap_wider_than_one_height_leaves_the_arc_length_exact() {
        // H < h0 of the crimped yarn.
        let yarns = [(8e4, 5e-4, 0.0), (7e5, 1.841e-4, 0.0409)];
        for law in LAWS {
            let got = cell::<f64>(yarns, law, 4.537e-5, None).solve_from_rest([0.987, 1.1686]);
            close(got.tension[1], free(yarns[1], 1.1686), 1e-12);
        }
    }

    #[test]
    fn one_yarn_without_crimp_is_pressed_by_the_other() {
        for law in LAWS {
            for yarns in [[(1e4, 6e-4, 0.02), (1e4, 6e-4, 0.0)], [(1e4, 6e-4, 0.0), (1e4, 6e-4, 0.02)]] {
                for stretch in [[1.03, 1.03], [1.01, 1.002], [1.002, 1.01], [1.015, 0.999]] {
                    let c = cell::<f64>(yarns, law, 0.0, None);
                    let got = c.solve_from_rest(stretch);
                    let m = oracle::misfit(&c, stretch, &got);
                    assert!(got.converged && m.tension < 1e-13 && m.force < 5e-11 && m.height < 1e-15, "{got:?} {m:?}");
                }
                // The straight yarn holds the crimped one up, which therefore pulls at once.
                let straight = usize::from(yarns[1].2 == 0.0);
                let mut stretch = [1.001; 2];
                stretch[straight] = 1.01;
                let got = cell::<f64>(yarns, law, 0.0, None).solve_from_rest(stretch);
                assert!(got.tension[1 - straight] > 1.0 && got.force > 0.1, "{law:?} {got:?}");
            }
        }
    }

    #[test]
    fn where_a_yarn_is_absent_or_dead_the_other_straightens_freely() {
        for law in LAWS {
            for compression in CROSSOVERS {
                for absent in 0..2 {
                    let other = 1 - absent;
                    let mut yarns = S720.map(|(ea, w, c)| yarn(ea, w, c));
                    let dead = Cell::<f64>::new(&fabric(yarns.clone(), law, 0.0, compression));
                    yarns[absent].present = false;
                    let gone = Cell::<f64>::new(&fabric(yarns, law, 0.0, compression));
                    assert_eq!(gone.exact.yarn[absent].stiffness, 0.0);
                    for stretch in [0.7, 1.0, 1.0138, 1.0219, 1.05, 1.2] {
                        let mut pair = [1.1; 2];
                        pair[other] = stretch;
                        let expected = free(S720[other], stretch);
                        for got in [gone.solve(pair, gone.rest_heights(), false), dead.solve_free(pair)] {
                            // The allowance that keeps the resting yarn slack, 16 roundings of its crimp.
                            let error = got.tension[other] - expected;
                            assert!(error.abs() <= 1e-15 * S720_STIFFNESS, "{law:?} {stretch}: {error:e}");
                            assert_eq!(got.in_plane[other], got.tension[other]);
                            assert_eq!((got.force, got.iterations, got.residual), (0.0, 0.0, 0.0), "{law:?}");
                            assert!(got.converged);
                        }
                        let got = gone.solve_free(pair);
                        assert_eq!((got.tension[absent], got.in_plane[absent]), (0.0, 0.0), "{law:?}");
                    }
                }
            }
        }
    }
}

/// Work and stored energy of one cell.
mod energy {
    use super::*;

    /// Energy stored in the cell [J].
    fn stored(cell: &Cell<f64>, got: &Solved) -> f64 {
        let yarns: f64 = (0..2)
            .map(|i| {
                let y = &cell.exact.yarn[i];
                got.tension[i] * got.strain[i] * y.half_span * (1.0 + y.crimp)
            })
            .sum();
        yarns + crossover::compression_energy(&cell.exact, got.force)
    }

    /// Force conjugate to Λ_i, N_i·2w0_i [J].
    fn conjugate(cell: &Cell<f64>, got: &Solved) -> [f64; 2] {
        [0, 1].map(|i| got.in_plane[i] * 2.0 * cell.exact.yarn[i].half_span)
    }

    fn cells(law: Variant) -> Vec<Cell<f64>> {
        let unequal = [yarn(2e4, 6e-4, 0.05), yarn(5e3, 9e-4, 0.02)];
        CROSSOVERS
            .into_iter()
            .flat_map(|c| [s720(law, c), fabric(unequal.clone(), law, 4e-6, c)])
            .map(|f| Cell::new(&f))
            .collect()
    }

    #[test]
    fn in_plane_forces_of_the_conservative_laws_are_derivatives_of_the_energy() {
        let mut random = Random(5);
        for law in [Variant::Variational, Variant::Kawabata] {
            let mut worst = Worst::default();
            for cell in cells(law) {
                let at = |stretch: [f64; 2]| cell.solve_from_rest(stretch);
                for _ in 0..300 {
                    let stretch = [random.between(1.0, 1.06), random.between(1.0, 1.06)];
                    let got = at(stretch);
                    for i in [0, 1] {
                        // Five points: truncation 1e-13, rounding of U over the step 1e-12 of the energy scale.
                        let step = 1e-4;
                        let u = |n: f64| {
                            let mut moved = stretch;
                            moved[i] += n * step;
                            stored(&cell, &at(moved))
                        };
                        if [-2.0, 2.0].iter().any(|n| {
                            let mut moved = stretch;
                            moved[i] += n * step;
                            at(moved).tension.iter().any(|t| *t < 1.0)
                        }) {
                            continue;
                        }
                        let slope = (8.0 * (u(1.0) - u(-1.0)) - (u(2.0) - u(-2.0))) / (12.0 * step);
                        let scale = cell.breaking()[i] * 2.0 * cell.exact.yarn[i].half_span;
                        let error = (slope - conjugate(&cell, &got)[i]) / scale;
                        worst.see(error, || format!("{law:?} {stretch:?} {got:?}"));
                    }
                }
            }
            worst.assert_at_most(1e-8);
        }
    }

    /// Work of the in-plane forces along a straight line of stretch, by Simpson's rule [J]. No yarn may become taut
    /// or slack in between: the integrand is smooth and 2000 intervals are exact to 1e-11 of the energy.
    fn work(cell: &Cell<f64>, from: [f64; 2], to: [f64; 2]) -> f64 {
        const STEPS: usize = 2000;
        let along = [to[0] - from[0], to[1] - from[1]];
        let term = |n: usize| {
            let t = n as f64 / STEPS as f64;
            let f = conjugate(cell, &cell.solve_from_rest([from[0] + along[0] * t, from[1] + along[1] * t]));
            let weight = if n == 0 || n == STEPS { 1.0 } else { 2.0 + 2.0 * (n % 2) as f64 };
            weight * (f[0] * along[0] + f[1] * along[1])
        };
        (0..=STEPS).map(term).sum::<f64>() / (3.0 * STEPS as f64)
    }

    /// Work over one round: stretch the warp, then the weft, release the warp, then the weft; over the largest energy.
    fn loop_work(cell: &Cell<f64>) -> f64 {
        let corners = [[1.004, 1.004], [1.036, 1.004], [1.036, 1.034], [1.004, 1.034]];
        let round: f64 = (0..4).map(|n| work(cell, corners[n], corners[(n + 1) % 4])).sum();
        round / stored(cell, &cell.solve_from_rest(corners[2]))
    }

    #[test]
    fn a_closed_strain_path_returns_all_work_for_the_conservative_laws() {
        for law in [Variant::Variational, Variant::Kawabata] {
            for cell in cells(law) {
                let lost = loop_work(&cell);
                assert!(lost.abs() < 1e-9, "{law:?}: {lost:e}");
            }
        }
    }

    /// (18) is not conjugate to the sinusoid: the published law gains or loses a little on every closed
    /// path. That is a property of the law; who removes it has changed the law.
    #[test]
    fn the_published_law_does_not_return_all_work() {
        // Tension as in-plane force: 0.05–0.3 %. Its projection loses a hundredth of that.
        for (law, least, most) in [(Variant::PublishedTension, 5e-4, 3e-3), (Variant::PublishedProjected, 5e-6, 5e-4)] {
            for compression in CROSSOVERS {
                let lost = loop_work(&Cell::new(&s720(law, compression))).abs();
                eprintln!("{law:?}, compression {}: {:.4} % of the stored energy", compression.is_some(), 100.0 * lost);
                assert!((least..most).contains(&lost), "{law:?}: {lost:e}");
            }
        }
    }

    #[test]
    fn work_from_rest_is_the_stored_energy_for_the_conservative_laws_only() {
        let far = [1.035, 1.03];
        let gap = |cell: &Cell<f64>| work(cell, [1.0; 2], far) / stored(cell, &cell.solve_from_rest(far)) - 1.0;
        for compression in CROSSOVERS {
            for law in [Variant::Variational, Variant::Kawabata] {
                let gap = gap(&Cell::new(&s720(law, compression)));
                assert!(gap.abs() < 1e-9, "{law:?}: {gap:e}");
            }
            let gap = gap(&Cell::new(&s720(Variant::PublishedTension, compression)));
            assert!((1e-3..5e-2).contains(&gap.abs()), "{gap:e}");
        }
    }
}
