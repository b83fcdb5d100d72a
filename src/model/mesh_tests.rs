use super::*;
#[test]
fn a_part_of_a_mesh_keeps_its_places_and_its_images_make_the_whole() {
    for angle in [0.0, 0.5, 1.0, -0.5].map(|quarters| quarters * std::f64::consts::PI) {
        let whole = Mesh::new(6, 4, [1.1, 2.3], angle);
        for planes in [[true, false], [false, true], [true, true]] {
            let part = whole.clone().part(MirrorPlanes(planes));
            assert_eq!(part.whole_counts(), [6, 4]);
            let [right, up] = part.first_in_whole();
            let mut seen = vec![0; whole.elements()];
            for row in 0..=part.rows {
                for column in 0..=part.columns {
                    let ([x, y], [p, q]) = (part.reference(row, column), whole.reference(row + up, column + right));
                    assert!((x - p).abs() < 1e-14 && (y - q).abs() < 1e-14, "{angle} {planes:?} {row} {column}");
                    let place = part.to_pack([x, y, 0.0]);
                    assert!((0..2).all(|a| !planes[a] || place[a] >= 0.0), "{angle} {planes:?} {place:?}");
                    if row < part.rows && column < part.columns {
                        part.images([column, row]).for_each(|[c, r]| seen[r * 6 + c] += 1);
                    }
                }
            }
            assert!(seen.iter().all(|count| *count == 1), "{angle} {planes:?} {seen:?}");
        }
    }
    assert_eq!(Mesh::new(6, 4, [1.0; 2], 0.4).own_axis(0), None);
}

#[test]
fn vectors_turn_there_and_back() {
    for angle in [0.0, 0.3, std::f64::consts::FRAC_PI_2, -std::f64::consts::PI, 5.0] {
        let mesh = Mesh::new(3, 2, [1.0, 2.0], angle);
        let v = mesh.to_ply(mesh.to_pack([0.3, -2.0, 7.0]));
        assert!((v[0] - 0.3).abs() < 1e-15 && (v[1] + 2.0).abs() < 1e-15 && v[2] == 7.0, "{angle}: {v:?}");
    }
    assert_eq!(Mesh::new(1, 1, [1.0; 2], std::f64::consts::FRAC_PI_2).rotation, [0.0, 1.0]);
    assert_eq!(Mesh::new(1, 1, [1.0; 2], -std::f64::consts::FRAC_PI_2).to_pack([1.0, 2.0, 0.0]), [2.0, -1.0, 0.0]);
}
