//! Warp and weft exchanged; mirrored.

use super::*;

fn random_patch(case: &Case, random: &mut Random) -> Patch<f64> {
    let mut patch = Patch::<f64>::new(case);
    let u = rough(&patch, [1.03, 0.2, 0.2], [0.3, 1.02, -0.1], 0.05 * CELL, random);
    patch.set_displacements(&u);
    patch
}

#[test]
fn exchanging_warp_and_weft_exchanges_the_forces() {
    let mut random = Random(4);
    for law in LAWS {
        let one = unbreakable(with_law(case(4, 3), law));
        let mut patch = random_patch(&one, &mut random);
        let mut other = Patch::<f64>::new(&swapped(&one));
        patch.kill(2, 1, 0);
        patch.kill(0, 3, 1);
        other.kill(1, 2, 1);
        other.kill(3, 0, 0);
        let exchange = |v: Vector| [v[1], v[0], v[2]];
        // Node (row, column) of one patch is node (column, row) of the other.
        let order: Vec<usize> = other.nodes().into_iter().map(|(row, column)| column * 5 + row).collect();
        let u = patch.displacements();
        let moved: Vec<Vector> = order.iter().map(|at| exchange(u[*at])).collect();
        other.set_displacements(&moved);
        let (forces, energy) = patch.solve();
        let (got, after) = other.solve();
        let expected: Vec<Vector> = order.iter().map(|at| exchange(forces[*at])).collect();
        // The iteration may stop elsewhere inside its tolerance of 1e-12 EA.
        let off = difference(&got, &expected);
        assert!(off < 1e-9, "{law:?}: {off:e}");
        assert!((after.stored / energy.stored - 1.0).abs() < 1e-9);
        assert!((after.hourglass / energy.hourglass - 1.0).abs() < 1e-12);
    }
}

#[test]
fn mirroring_the_patch_mirrors_the_forces() {
    let mut random = Random(5);
    for law in LAWS {
        for axis in 0..3 {
            let one = unbreakable(with_law(case(4, 3), law));
            let mut patch = random_patch(&one, &mut random);
            let mut other = Patch::<f64>::new(&one);
            patch.kill(1, 1, 0);
            let at = [(1, 2), (1, 1), (1, 1)][axis];
            other.kill(at.0, at.1, 0);
            let flip = |v: Vector| {
                let mut v = v;
                v[axis] = -v[axis];
                v
            };
            let image = |(row, column): (usize, usize)| match axis {
                0 => row * 5 + 4 - column,
                1 => (3 - row) * 5 + column,
                _ => row * 5 + column,
            };
            let order: Vec<usize> = other.nodes().into_iter().map(image).collect();
            let u = patch.displacements();
            let moved: Vec<Vector> = order.iter().map(|at| flip(u[*at])).collect();
            other.set_displacements(&moved);
            let (forces, energy) = patch.solve();
            let (got, after) = other.solve();
            let expected: Vec<Vector> = order.iter().map(|at| flip(forces[*at])).collect();
            // Only sums of four corners are taken in another order.
            let off = difference(&got, &expected);
            assert!(off < 1e-12, "{law:?} {axis}: {off:e}");
            assert!((after.stored / energy.stored - 1.0).abs() < 1e-12);
        }
    }
}
