use super::*;
use crate::case;

fn cell() -> UnitCellParameters<f64> {
    UnitCellParameters::new(&case::shipped(&[]).fabric)
}

#[test]
fn heights_that_miss_their_sum_by_four_roundings_compress_nothing() {
    let cell = cell();
    let [a, b, _] = cell.compression;
    for steps in 0..12 {
        let sum = cell.height_sum * (1.0 - f64::from(steps) * 0.5 * f64::EPSILON);
        let q = opening(&cell, sum);
        if steps < 7 {
            assert_eq!(q, cell.uncompressed_limit, "{steps}");
        } else if steps > 9 {
            assert!(q < cell.uncompressed_limit, "{steps}");
        }
    }
    assert_eq!(opening(&cell, 2.0 * cell.height_sum), cell.uncompressed_limit);
    for d in [0.1 * a, 0.5 * a, 0.9 * a] {
        let q = opening(&cell, cell.height_sum - d);
        assert!((q / ((a - d) / b) - 1.0).abs() < 1e-12, "{d}");
        let other = other_height(&cell, 0.3 * cell.height_sum, q);
        assert!((other / (0.7 * cell.height_sum - d) - 1.0).abs() < 1e-12, "{d}");
    }
    let uncompressed = other_height(&cell, 0.3 * cell.height_sum, 1.5 * cell.uncompressed_limit);
    assert_eq!(uncompressed, cell.height_sum - 0.3 * cell.height_sum);
}

#[test]
fn tangents_meet_in_one_force() {
    let cell = cell();
    let top = cell.height_sum;
    let yarn = |force: f64, stiffness: f64| YarnResponse { strain: 0.01, force, stiffness, growth: 1.0 };
    for [first, second, force, compliance] in
        [[3.0, 2.0, 2.5, 1e-5], [1.0, 1.5, 1.7, 3e-6], [2.0, 2.0, 2.0, 1e-6], [2.5, 2.0, 2.2, 0.0]]
    {
        let (yarns, slopes) = ([yarn(first, 4e5), yarn(second, 7e5)], [4e5, 7e5]);
        let height = [0.4 * top, 0.5 * top];
        let q = opening(&cell, height[0] + height[1]);
        let (new, next) = along_tangents(&cell, &yarns, slopes, height, q, [force, compliance]);
        // The force of each tangent at its new height, the other one from the sum before it is rounded into q.
        let d = cell.compression[0] - cell.compression[1] * next;
        let common = first + slopes[0] * (new[0] - height[0]);
        let other = second + slopes[1] * (top - d - new[0] - height[1]);
        assert!((common - other).abs() < 1e-8, "{common} {other}");
        assert!((top - d - new[0] - new[1]).abs() < 1e-18, "{new:?}");
        // The crossover gives way to what the common force is more than its own.
        let given = -(new[0] + new[1] - height[0] - height[1]);
        assert!((given - compliance * (common - force)).abs() < 1e-15, "{given}");
    }
    // Never below nothing nor above the sum, and q no less than three tenths of what it was.
    let far = |first: f64, second: f64| {
        along_tangents(&cell, &[yarn(first, 4e5), yarn(second, 4e5)], [4e5; 2], [0.5 * top; 2], 0.9, [0.0, 0.0]).0[0]
    };
    assert_eq!([far(1e6, -1e6), far(-1e6, 1e6)], [0.0, top]);
    let (_, next) = along_tangents(&cell, &[yarn(5.0, 4e5); 2], [4e5; 2], [0.1 * top; 2], 0.9, [0.0, 1e-3]);
    assert!((next / 0.27 - 1.0).abs() < 1e-12, "{next}");
}
