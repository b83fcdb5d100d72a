//! What predicts the heights of the next step: right to first order, and worth an evaluation.

use super::*;

/// A cell before its stretches change; heights predicted and solved after; and the evaluations from the heights before.
struct Step {
    before: Solved,
    predicted: [f64; 2],
    solved: Solved,
    cold: f64,
}

fn step(cell: &Cell<f64>, stretch: [f64; 2], change: [f64; 2]) -> Step {
    let before = cell.solve_from_rest(stretch);
    let predicted = cell.predict(stretch, before.height, change, true);
    let after = [0, 1].map(|i| stretch[i] + change[i]);
    let solved = cell.solve(after, predicted, true);
    let cold = cell.solve(after, before.height, true).iterations;
    Step { before, predicted, solved, cold }
}

#[test]
fn heights_are_foretold_to_first_order_in_every_law() {
    for law in LAWS {
        let mut taut = 0;
        for compression in CROSSOVERS {
            let cell = Cell::<f64>::new(&s720(law, compression));
            for stretch in [[1.005, 1.004], [1.03, 1.01], [1.01, 1.03], [1.025, 1.025]] {
                if cell.solve_from_rest(stretch).strain.iter().any(|strain| *strain < 1e-3) {
                    continue;
                }
                taut += 1;
                for direction in [[1.0, 0.0], [0.0, 1.0], [1.0, -1.0], [-0.5, 1.0]] {
                    let place = format!("{law:?} {compression:?} {stretch:?} {direction:?}");
                    let miss = |size: f64| {
                        let step = step(&cell, stretch, direction.map(|d| d * size));
                        let moved = (0..2).map(|i| (step.solved.height[i] - step.before.height[i]).abs());
                        let missed = (0..2).map(|i| (step.solved.height[i] - step.predicted[i]).abs());
                        (missed.fold(0.0, f64::max), moved.fold(0.0, f64::max))
                    };
                    let ((coarse, far), (fine, near)) = (miss(1e-4), miss(1e-5));
                    assert!(near > 1e-11 && far > 8.0 * near, "{place}: {far} {near}");
                    // A tenth of the way, a hundredth of the miss, but for what heights are solved to.
                    assert!(fine < 0.015 * coarse + 2e-15, "{place}: {fine} {coarse} of {near} {far}");
                    assert!(coarse < 0.1 * far, "{place}: {coarse} of {far}");
                }
            }
        }
        assert!(taut >= 5, "{law:?}: {taut}");
    }
}

#[test]
fn a_guided_step_takes_an_evaluation_less_and_finds_the_same() {
    let cell = Cell::<f64>::new(&s720(CurveLaw::Published, CROSSOVERS[1]));
    let mut random = Random(7);
    let (mut guided, mut cold) = (0.0, 0.0);
    for _ in 0..1000 {
        let stretch = [random.between(1.0, 1.03), random.between(1.0, 1.03)];
        let change = [random.between(-3e-4, 3e-4), random.between(-3e-4, 3e-4)];
        let one = step(&cell, stretch, change);
        let after = [0, 1].map(|i| stretch[i] + change[i]);
        let other = cell.solve_from_rest(after);
        for i in 0..2 {
            let parted = (one.solved.tension[i] - other.tension[i]).abs();
            assert!(parted < 1e-7, "{stretch:?} {change:?}: {parted}");
        }
        guided += one.solved.iterations;
        cold += one.cold;
    }
    assert!(guided < cold - 700.0, "{guided} {cold}");
}

#[test]
fn what_is_slack_or_broken_foretells_nothing() {
    for law in LAWS {
        let cell = Cell::<f64>::new(&s720(law, CROSSOVERS[1]));
        for (stretch, both) in [([0.9, 0.9], true), ([1.0, 1.0], true), ([1.02, 1.02], false)] {
            let heights = cell.rest_heights();
            let warm = if both { cell.solve_from_rest(stretch).height } else { heights };
            let predicted = cell.predict(stretch, warm, [1e-3, 1e-3], both);
            assert_eq!(predicted, warm, "{law:?} {stretch:?} {both}");
        }
    }
}
