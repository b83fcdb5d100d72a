use super::*;
fn mesh(angle: f64) -> Mesh {
    Mesh::new(20, 10, [1e-3, 2e-3], angle)
}

#[test]
fn it_grows_by_a_ring_to_the_edges() {
    let mesh = mesh(0.0);
    let mut reach = ActiveRegion::nothing();
    assert!(reach.grown(1, &mesh).is_nothing());
    reach.activate(4, 7);
    reach.activate(5, 6);
    assert_eq!(reach, ActiveRegion { rows: 4..6, columns: 6..8 });
    assert_eq!(reach.grown(2, &mesh), ActiveRegion { rows: 2..8, columns: 4..10 });
    assert_eq!(reach.grown(50, &mesh), ActiveRegion::whole(&mesh));
    assert_eq!(reach.elements(&mesh), [3..6, 5..8]);
    assert_eq!(ActiveRegion::whole(&mesh).elements(&mesh), [0..10, 0..20]);
}

#[test]
fn another_ply_sees_it_where_it_lies() {
    let (flat, turned) = (mesh(0.0), mesh(std::f64::consts::FRAC_PI_2));
    let mut reach = ActiveRegion::nothing();
    reach.activate(5, 10); // the centre
    let seen = reach.seen_from(&flat, &turned, 0.0);
    assert!(seen.rows.contains(&5) && seen.columns.contains(&10) && seen.rows.len() < 8, "{seen:?}");
    let corner = ActiveRegion { rows: 0..1, columns: 0..1 };
    // The corner (-10, -10) mm of a ply lies at (-10, 10) mm of one turned by 90 degrees.
    let seen = corner.seen_from(&flat, &turned, 0.0);
    assert!(seen.rows.contains(&10) && seen.columns.contains(&0) && !seen.rows.contains(&0), "{seen:?}");
}
