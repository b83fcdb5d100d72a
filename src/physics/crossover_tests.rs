use super::*;
use crate::case::{self, Compression, Law};
use crate::physics::projectile_shape::tests::Numbers;
use crate::physics::unit_cell_parameters::UnitCellParameters;
use crate::with_law;

const LAWS: [Law; 2] = [Law::Published, Law::Variational];

/// A cell with yarns and crossover at random, and its law.
struct Random {
    numbers: Numbers,
    fabric: case::Fabric,
}

impl Random {
    fn new(seed: u32) -> Self {
        Self { numbers: Numbers(seed), fabric: case::shipped(&[]).fabric }
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.numbers.unit() + 1.0) / 2.0
    }

    fn cell(&mut self, at: usize) -> (Law, UnitCellParameters<f64>) {
        let mut fabric = self.fabric.clone();
        fabric.crossover.law = LAWS[at % 2];
        for yarn in [&mut fabric.warp, &mut fabric.weft] {
            yarn.modulus *= self.between(0.3, 3.0);
            yarn.crimp = self.between(0.005, 0.1);
            yarn.count *= self.between(0.7, 1.4);
        }
        let a = self.between(2e-5, 2e-4);
        let compression = Compression { a, b: a * self.between(0.3, 3.0) };
        fabric.crossover.compression = (!(at / 4).is_multiple_of(3)).then_some(compression);
        (fabric.crossover.law, UnitCellParameters::new(&fabric))
    }

    fn stretches(&mut self) -> [f64; 2] {
        [self.between(-0.01, 0.06), self.between(-0.01, 0.06)]
    }
}

/// Contact force by halving the range of the pivot's height: 0 where both yarns are slack.
fn by_bisection<L: LawKernel>(cell: &UnitCellParameters<f64>, stretch: [f64; 2]) -> f64 {
    let (p, o) = (cell.pivot, 1 - cell.pivot);
    let (mut low, mut high) = (0.0, cell.height_sum);
    let respond = |yarn: usize, height: f64| L::yarn(&cell.yarn[yarn], stretch[yarn], height);
    for _ in 0..100 {
        let x = 0.5 * (low + high);
        let pivot = respond(p, x);
        let [a, b, offset] = cell.compression;
        let d = if a > 0.0 && pivot.force > 0.0 { a - b / (pivot.force + offset).cbrt() } else { 0.0 };
        if pivot.force > respond(o, cell.height_sum - d - x).force { high = x } else { low = x }
    }
    respond(p, 0.5 * (low + high)).force.max(0.0)
}

/// Solves cells from the last heights of slightly other stretches, or from anywhere, and hands over each with its
/// answer and the force by bisection.
fn solve_many(
    [seed, count]: [u32; 2],
    newton: bool,
    near: bool,
    mut see: impl FnMut(&UnitCellParameters<f64>, [YarnResponse<f64>; 2], Equilibrium<f64>, f64),
) {
    let mut random = Random::new(seed);
    for at in 0..count as usize {
        let (law, cell) = random.cell(at);
        let stretch = random.stretches();
        let anywhere = [0, 1].map(|_| random.between(-0.1, 1.1) * cell.height_sum);
        let moved = stretch.map(|s| s + random.between(-1e-4, 1e-4));
        with_law!(law, L => {
            let solve = if newton { solve::<f64, L> } else { solve_safeguarded::<f64, L> };
            let warm = if near { solve(&cell, moved, anywhere, true).height } else { anywhere };
            let got = solve(&cell, stretch, warm, true);
            let there = [0, 1].map(|i| L::yarn(&cell.yarn[i], stretch[i], got.height[i]));
            see(&cell, there, got, by_bisection::<L>(&cell, stretch));
        });
    }
}

#[test]
fn both_iterations_find_the_force_that_bisection_finds_and_are_off_by_what_they_say() {
    for (newton, near) in [(true, true), (true, false), (false, true), (false, false)] {
        solve_many([51, 3000], newton, near, |cell, there, got, force| {
            assert!(got.converged, "{got:?}");
            let stiff = cell.yarn[0].stiffness.max(cell.yarn[1].stiffness);
            assert!((got.force - force).abs() < 1e-12 * stiff, "{got:?} for {force}");
            if force == 0.0 {
                return;
            }
            // Compatibility (22), to a billionth of a thousandth of the heights; equilibrium (16), to what a force rounds to.
            let sum = got.height[0] + got.height[1] + compression(cell, got.force).0;
            assert!((sum / cell.height_sum - 1.0).abs() < 1.001e-12, "{got:?}");
            let accepted = 1.001 * cell.accepted(got.force);
            assert!(there.iter().all(|yarn| (yarn.real_force() - got.force).abs() < accepted), "{got:?} {there:?}");
            assert!((0.0..accepted).contains(&got.residual), "{got:?}");
        });
    }
}

#[test]
fn what_a_crossover_stores_is_the_work_of_its_force() {
    let mut random = Random::new(53);
    for at in 0..200 {
        let (_, cell) = random.cell(at);
        let [a, b, offset] = cell.compression;
        let force = offset.max(1e-3) * 10.0_f64.powf(random.between(-2.0, 3.0));
        let energy = |force: f64| compression_energy(&cell, force);
        let (d, slope) = compression(&cell, force);
        assert_eq!((compression(&cell, -force), energy(-force), energy(0.0)), ((0.0, 0.0), 0.0, 0.0));
        if a == 0.0 {
            assert_eq!((d, slope, energy(force)), (0.0, 0.0, 0.0), "rigid");
            continue;
        }
        // (21): F = (b/(a − d))³ − (b/a)³.
        assert!((((b / (a - d)).powi(3) - offset) / force - 1.0).abs() < 1e-9, "{d}");
        let step = 1e-4 * force;
        let along = |of: &dyn Fn(f64) -> f64| (of(force + step) - of(force - step)) / (2.0 * step);
        assert!((along(&|f| compression(&cell, f).0) / slope - 1.0).abs() < 1e-6, "{force}");
        assert!((along(&energy) / (force * slope) - 1.0).abs() < 1e-6, "{force}");
        assert!(0.0 < energy(force) && energy(force) < 0.5 * force * d, "a force that stiffens");
    }
}
