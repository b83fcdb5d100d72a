//! The places where the equations change their form.

use super::*;

const S720: [(f64, f64, f64); 2] =
    [(S720_STIFFNESS, S720_HALF_SPAN, S720_CRIMP[0]), (S720_STIFFNESS, S720_HALF_SPAN, S720_CRIMP[1])];

fn cell<R: Scalar>(yarns: [(f64, f64, f64); 2], law: CurveLaw, gap: f64, compression: Option<Compression>) -> Cell<R> {
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
                        // The allowance that keeps the resting yarn slack: a few roundings of its crimp.
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

/// Newton from one side of the root only, a rounding at a time, must not use up the iterations.
#[test]
fn roundings_do_not_let_the_iteration_creep() {
    let nearly_straight = [
        (31_686.735_122_676_78, 5e-4, 0.208_536_406_515_824_3),
        (216.314_161_433_585_35, 4.466_083_533_542_356e-4, 3.572_300_402_113_822e-5),
    ];
    let c = cell::<f32>(nearly_straight, CurveLaw::Kawabata, 0.0, None);
    let start = [3.185_016_678_025_338e-4, -5.815_455_311_736_267e-5];
    let got = c.solve([0.996_408_302_935_984_3, 1.008_075_040_568_850_1], start, true);
    assert!(got.converged, "{got:?}");
}

/// A crossover that hardly resists at first touch: there a rounding of a yarn's strain moves the heights by as much as they are.
#[test]
fn a_crossover_soft_at_first_touch_keeps_forces_to_roundings_in_single_precision() {
    let weft = (10_518.5, 6.35e-4, 0.0139);
    let soft = [
        ([(10_518.5, 8.37e-4, 0.135), weft], Compression { a: 1.637e-4, b: 9.587e-6 }),
        ([(10_518.5, 8.236e-4, 0.1785), weft], Compression { a: 1.637e-4, b: 5e-6 }),
        ([(5382.0, 1.1556e-3, 0.179), weft], Compression { a: 2.262e-4, b: 1.309e-5 }),
    ];
    let small = [-1e-6, -1e-8, 0.0, 3e-9, 2e-8, 5e-8, 8e-8, 2e-7, 7e-7, 3e-6, 2e-5, 1e-4];
    let mut worst = 0.0_f64;
    for (yarns, compression) in soft {
        for law in LAWS {
            let single = cell::<f32>(yarns, law, 0.0, Some(compression));
            let double = cell::<f64>(yarns, law, 0.0, Some(compression));
            let mut warm = single.rest_heights();
            for stretch in small.iter().flat_map(|warp| small.map(|weft| [1.0 + warp, 1.0 + weft])) {
                let exact = double.solve(stretch, warm, true);
                let got = single.solve(stretch, warm, true);
                assert!(got.converged, "{law:?} {stretch:?} {got:?}");
                let off = (0..2).map(|i| (got.in_plane[i] - exact.in_plane[i]).abs() / yarns[i].0);
                worst = off.fold(worst, f64::max);
                warm = got.height;
            }
        }
    }
    // In strains. Half a unit in the last place each of the crimp, the arc's length and their difference, and of the heights.
    assert!(worst <= 3.0 * f64::from(f32::EPSILON), "{worst:e}");
}
