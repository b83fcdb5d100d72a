use super::*;

#[test]
fn a_scatter_is_that_of_its_shots() {
    let scatter = Scatter::of(&[180.0, 184.0, 182.0, 186.0]).unwrap_or_else(|| unreachable!());
    assert_eq!((scatter.mean, scatter.range, scatter.shots), (183.0, [180.0, 186.0], 4));
    // Squares 9, 1, 1, 9 over three.
    assert!((scatter.deviation - (20.0_f64 / 3.0).sqrt()).abs() < 1e-12);
    assert!((scatter.error() - (20.0_f64 / 12.0).sqrt()).abs() < 1e-12);
    assert_eq!(Scatter::of(&[180.0]), None);
}

#[test]
fn shifts_fill_the_square_and_leave_out_its_middle() {
    let all: Vec<[f64; 2]> = shifts(SHOTS).collect();
    for quarter in [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]] {
        let inside = all.iter().filter(|[x, y]| x * quarter[0] > 0.0 && y * quarter[1] > 0.0).count();
        assert!((3..=5).contains(&inside), "{quarter:?}: {inside} of {SHOTS}");
    }
    assert!(all.iter().flatten().all(|shift| shift.abs() <= OFF && shift.abs() > 1e-2 * OFF));
    for (at, one) in all.iter().enumerate() {
        assert!(all[..at].iter().all(|other| one.map(f64::abs) != other.map(f64::abs)));
    }
}
