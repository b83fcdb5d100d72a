use super::*;

fn cell(twist: f64) -> [Vector3<f64>; 4] {
    // A sheared, tilted cell; its last corner may be lifted out of the plane.
    [[0.0, 0.0, 0.0], [2.0, 0.2, 0.4], [2.5, 1.2, 0.9], [0.5, 1.0, 0.5 + twist]].map(Vector3::from)
}

#[test]
fn a_foot_is_found_where_the_point_was_put() {
    for twist in [0.0, 0.05] {
        let corner = cell(twist);
        for at in [[0.0, 0.0], [0.3, -0.4], [-0.5, 0.5], [0.7, 0.1]] {
            let on: Vector3<f64> = corner.iter().zip([0, 1, 2, 3]).map(|(c, i)| c * unclamped(at)[i]).sum();
            let flat = closest_point(&corner, &on, 2.0, NO_PLANES).map(|f| f.normal).unwrap_or_default();
            let found = closest_point(&corner, &(on + flat * 0.1), 2.0, NO_PLANES);
            let Some(f) = found else { unreachable!("a sound cell") };
            let allowed = 1e-12 + 0.1 * twist;
            assert!((f.at[0] - at[0]).abs() < allowed && (f.at[1] - at[1]).abs() < allowed, "{at:?}: {f:?}");
            assert!((f.height - 0.1).abs() < allowed, "{f:?}");
            assert!(f.normal.z > 0.0);
        }
    }
}

fn unclamped([x, y]: [f64; 2]) -> [f64; 4] {
    [(0.5 - x) * (0.5 - y), (0.5 + x) * (0.5 - y), (0.5 + x) * (0.5 + y), (0.5 - x) * (0.5 + y)]
}

#[test]
fn the_place_on_an_edge_is_the_nearest_one() {
    let corner = cell(0.0);
    let on = |at: [f64; 2]| -> Vector3<f64> { corner.iter().zip(unclamped(at)).map(|(c, w)| c * w).sum() };
    for point in
        [[3.5, 0.9, 2.0], [-1.0, 0.4, 0.1], [1.3, -2.0, 0.3], [1.0, 3.0, 0.0], [4.0, 2.0, 1.0], [-1.0, -1.0, 3.0]]
    {
        let point = Vector3::from(point);
        let Some(foot) = closest_point(&corner, &point, 2.0, NO_PLANES) else { unreachable!("a sound cell") };
        let (arm, at) = on_edge(&corner, &point, foot.at);
        assert!((point - on(at) - arm).norm() < 1e-12 && at.iter().any(|x| x.abs() == 0.5), "{at:?}");
        for i in 0..=1000 {
            let x = f64::from(i) * 1e-3 - 0.5;
            for other in [[x, -0.5], [x, 0.5], [-0.5, x], [0.5, x]] {
                assert!(arm.norm() < (point - on(other)).norm() + 1e-12, "{point}: {at:?}, but {other:?}");
            }
        }
    }
}

#[test]
fn a_folded_cell_has_no_surface() {
    let line = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.01, 0.0], [0.0, 0.01, 0.0]].map(Vector3::from);
    assert!(closest_point(&line, &Vector3::zeros(), 1.0, NO_PLANES).is_none());
    assert!(closest_point(&line, &Vector3::zeros(), 0.01, NO_PLANES).is_some());
}

#[test]
fn a_walk_stops_over_its_cell_and_at_the_edge() {
    assert_eq!(next_cell([3, 4], [0.2, -0.4], 8, 9), [3, 4]);
    assert_eq!(next_cell([3, 4], [1.2, -0.6], 8, 9), [2, 5]);
    assert_eq!(next_cell([7, 0], [-1.2, 3.0], 8, 9), [7, 0]);
    let whole = |at, cell| is_over(at, cell, 8, 9, [Cut::Nowhere; 2]);
    assert!(whole([0.5, -0.7], [0, 4]) && !whole([0.5, -0.8], [0, 4]));
    assert!(whole([0.7, 0.0], [3, 8]) && !whole([-0.7, 0.0], [3, 8]));
    assert!(!whole([0.0, 0.6], [6, 4]) && whole([0.0, 0.6], [7, 4]));
    let cut = |at, cell| is_over(at, cell, 8, 9, [Cut::Last, Cut::First]);
    assert!(!cut([0.5, -0.7], [0, 4]) && !cut([0.7, 0.0], [3, 8]), "the ply goes on beyond a mirror plane");
    assert!(cut([-0.7, 0.7], [7, 0]) && cut([0.5, -0.5], [0, 8]));
}

#[test]
fn an_impulse_stops_the_approach_and_rubs_at_most_by_coulomb() {
    let push = Vector3::z();
    let coming = Vector3::new(3.0, 4.0, -10.0);
    let (normal, drag) = impulse(&coming, &push, 0.0, 2.0, 0.1);
    assert_eq!(normal, 20.0);
    assert!((drag - Vector3::new(-1.2, -1.6, 0.0)).norm() < 1e-15);
    let (_, drag) = impulse(&coming, &push, 0.0, 2.0, 1.0);
    assert!((drag - Vector3::new(-6.0, -8.0, 0.0)).norm() < 1e-15, "sticks: {drag}");
    assert_eq!(impulse(&-coming, &push, 0.0, 2.0, 0.1), (0.0, Vector3::zeros()));
    assert_eq!(closing_limit(2.0, 0.5), -4.0);
    assert_eq!(closing_limit(-2.0, 0.5), 0.0);
    let full = (POSITION_CORRECTION * (1.0 - SLOP) + DEEP_RECOVERY * (1.0 - SLOP - DEEP)) * 2.0;
    assert!((recovery(-1.0, 1.0, -1.0, 0.5) - full).abs() < 1e-15);
    assert!((recovery(-1.0, 1.0, 0.1, 0.5) - (full - 0.1)).abs() < 1e-15);
    assert_eq!(recovery(-3.0, 1.0, 2.0, 1e-6), PASSED_SPEED - 2.0);
    let near = recovery(-PASSED + 1e-9, 1.0, -1.0, 1e-6);
    assert!(near < FASTEST && (near / FASTEST - 1.0).abs() < 1e-3, "{near}");
    assert_eq!(recovery(-0.4, 1.0, 2.0, 1e-6), RECOVERY_SPEED - 2.0);
    assert_eq!((recovery(2.0, 0.5, -1.0, 0.5), recovery(-2.0, 0.5, 9.0, 0.5)), (0.0, 0.0));
}

#[test]
fn a_point_is_apart_above_a_flat_cell_alone() {
    let flat = |rise: f64| [[0.0, 0.0, 0.0], [1.0, 0.0, rise], [1.0, 1.0, rise], [0.0, 1.0, 0.0]].map(Vector3::from);
    let above = |z: f64| Vector3::new(0.5, 0.5, z);
    assert!(is_apart(&flat(0.0), &above(0.4), 1.0, 0.3, 1.0));
    assert!(is_apart(&flat(0.0), &above(-0.4), -1.0, 0.3, 1.0), "on the other side");
    assert!(!is_apart(&flat(0.0), &above(0.2), 1.0, 0.3, 1.0), "near");
    assert!(!is_apart(&flat(0.0), &Vector3::new(1.5, 0.5, 0.4), 1.0, 0.3, 1.0), "beside the cell");
    // A slope is flat to a twentieth of its length.
    assert!(is_apart(&flat(0.04), &above(0.5), 1.0, 0.3, 1.0));
    assert!(!is_apart(&flat(0.06), &above(0.9), 1.0, 0.3, 1.0), "steep");
    // Nearer than the cell's own rise.
    assert!(!is_apart(&flat(0.04), &above(0.37), 1.0, 0.3, 1.0));
}
