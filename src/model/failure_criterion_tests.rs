use super::*;
use crate::case;
use crate::model::Model;
use crate::model::ply_type::PlyType;

/// The ply type of a case with changes, all of it or what mirror planes leave of it.
fn ply_type(part: bool, sets: &[&str]) -> PlyType<f64> {
    let case = case::shipped(&[&["/expect=[]"], sets].concat());
    let model = if part { Model::<f64>::part(&case) } else { Model::<f64>::new(&case) };
    model.unwrap_or_else(|error| unreachable!("{error}")).ply_types.swap_remove(0)
}

/// Windows of a ply type.
fn windows(part: bool, sets: &[&str]) -> [Windows; 2] {
    ply_type(part, sets).windows
}

#[test]
fn yarns_are_counted_from_the_hit_wherever_it_is() {
    let mesh = ["/pack/elements_per_crossover=2", "/pack/mesh_grading={\"fine_radius_mm\": 11}"];
    let aimed = windows(false, &mesh);
    for offset in ["[0.3, 0]", "[0.635, 0]", "[1.0, 0]"] {
        let offset = format!("/projectile/offset_mm={offset}");
        let shifted = windows(false, &[&mesh[..], &[&offset]].concat());
        // Around the hit the wefts, beside each other along warp, have the same elements.
        let of = |windows: &[Windows; 2]| {
            let wefts = &windows[1];
            let narrow = wefts.yarns().filter(|yarn| yarn.length.iter().all(|width| (width - 1.0).abs() < 1e-6));
            narrow.map(|yarn| yarn.length.len()).collect::<Vec<_>>()
        };
        let (aimed, shifted) = (of(&aimed), of(&shifted));
        assert!(aimed.len() > 10 && aimed.iter().all(|elements| *elements == 2), "{aimed:?}");
        assert!(shifted.len() > 10 && shifted.iter().all(|elements| *elements == 2), "{offset}: {shifted:?}");
    }
}

#[test]
fn a_yarn_is_as_broad_as_crossovers_across_it_are_apart() {
    let ply_type = ply_type(false, &["/fabric/warp/count_per_inch=20", "/fabric/weft/count_per_inch=10"]);
    let breadth = breadth(&ply_type.mesh, &ply_type.cell);
    // Warp yarns lie beside each other along weft, where the weft crosses them.
    let found = [breadth[0] * ply_type.mesh.length[1], breadth[1] * ply_type.mesh.length[0]];
    for (found, spacing) in found.into_iter().zip([25.4e-3 / 10.0, 25.4e-3 / 20.0]) {
        assert!((found / spacing - 1.0).abs() < 1e-12, "{found} instead of {spacing}");
    }
}

#[test]
fn what_breaks_together_lies_within_half_the_failure_length() {
    let mesh =
        ["/pack/elements_per_crossover=4", "/pack/mesh_grading={\"fine_radius_mm\": 3}", "/solver/failure_length_mm=2"];
    let ply_type = ply_type(false, &mesh);
    let windows = &ply_type.windows;
    for axis in 0..2 {
        let places = |at: usize| {
            let [row, column] = if axis == 0 { [0, at] } else { [at, 0] };
            let from = ply_type.mesh.reference(row, column)[axis];
            from + 0.5 * ply_type.mesh.size(row, column)[axis]
        };
        let breaking = &windows[axis].breaking;
        let mut several = 0;
        for (own, together) in breaking.iter().enumerate() {
            let near = |at: &usize| (places(*at) - places(own)).abs() < 0.9999e-3;
            let expected: Vec<_> = (0..breaking.len()).filter(near).collect();
            assert_eq!(together.clone().collect::<Vec<_>>(), expected, "{axis} {own}");
            several += usize::from(together.len() == 7);
        }
        // In coarse elements only the one in the middle does.
        assert!(several > 10 && breaking.iter().any(|together| together.len() == 1), "{several}");
    }
}

#[test]
fn a_part_of_a_ply_has_the_yarns_of_the_whole() {
    for sets in
        [&[][..], &["/pack/elements_per_crossover=3"], &["/pack/mesh_grading=none", "/pack/elements_per_crossover=2"]]
    {
        let (whole, part) = (windows(false, sets), windows(true, sets));
        for axis in 0..2 {
            let middle = part[axis].across.len();
            assert_eq!(whole[axis].across.len(), 2 * middle);
            // Past the mirror plane lie the images of those on this side of it.
            for (half, all) in part[axis].breaking.iter().zip(&whole[axis].breaking[middle..]) {
                let behind = all.start.max(middle) - middle..all.end - middle;
                assert_eq!(*half, behind, "{sets:?}");
            }
            for (half, all) in part[axis].across.iter().zip(&whole[axis].across[middle..]) {
                assert_eq!((half.first + middle, half.length.len()), (all.first, all.length.len()), "{sets:?}");
            }
        }
    }
}

fn model(sets: &[&str]) -> Model<f64> {
    let case = case::shipped(&[&["/expect=[]", "/pack/width_mm=60", "/pack/height_mm=60"], sets].concat());
    Model::part(&case).unwrap_or_else(|error| unreachable!("{error}"))
}

#[test]
fn nothing_varies_in_a_nominal_case() {
    let nominal = model(&["/variability/yarn_strength={\"shape\": 9, \"gauge_length_mm\": 50}"]);
    assert!(nominal.strength.is_none());
    assert_eq!(nominal.planes.copies(), 4);
}

/// Minimum over a yarn of its elements, over many shots, against the closed form: the chain rule.
#[test]
fn the_weakest_element_of_a_yarn_is_weibulls_with_the_length_of_the_yarn() {
    for mesh in ["/pack/elements_per_crossover=1", "/pack/elements_per_crossover=2"] {
        let mut weakest = Vec::new();
        let mut length = 0.0;
        for shot in 0..12 {
            let shot = format!("/variability/shot={shot}");
            let strength = "/variability/yarn_strength={\"shape\": 9, \"gauge_length_mm\": 50}";
            let model = model(&[mesh, &shot, strength]);
            let Some(strength) = &model.strength else { unreachable!("strength varies") };
            let ply_type = model.ply_type(0);
            let pieces = YarnLayout::new(ply_type);
            let mut last = u32::MAX;
            for row in 0..ply_type.mesh.rows {
                let piece = pieces.at(0, row, 0);
                if piece.yarn != last {
                    last = piece.yarn;
                    let of_row = (0..ply_type.mesh.columns).map(|column| strength.factor(row, 0, column));
                    weakest.push(of_row.fold(f64::INFINITY, f64::min));
                }
            }
            length = ply_type.mesh.whole_size()[0] * (1.0 + ply_type.cell.yarn[0].crimp);
        }
        let law = Weibull { scale: 1.0, shape: 9.0, gauge: 0.05 };
        let law = Weibull { scale: 1.0 / law.mean(0.05), ..law };
        // Kolmogorov and Smirnov: 1.63/√n is reached by chance once in a hundred times.
        weakest.sort_by(f64::total_cmp);
        let n = weakest.len() as f64;
        let off = weakest.iter().enumerate().map(|(i, weak)| {
            let p = law.probability(length, *weak);
            (p - i as f64 / n).abs().max((p - (i as f64 + 1.0) / n).abs())
        });
        let off = off.fold(0.0, f64::max);
        assert!(off < 1.63 / n.sqrt(), "{mesh}: {off} of {n} yarns");
    }
}

#[test]
fn elements_of_a_yarn_share_its_draws_and_shots_do_not() {
    let strength = "/variability/yarn_strength={\"shape\": 9, \"gauge_length_mm\": 50, \"yarn_shape\": 5}";
    let sets = ["/pack/elements_per_crossover=2", "/pack/mesh_grading=none", strength];
    let of = |shot: &str| model(&[&sets[..], &[shot]].concat()).strength;
    let (Some(one), Some(other)) = (of("/variability/shot=1"), of("/variability/shot=2")) else {
        unreachable!("strength varies")
    };
    // The middle of the ply, after 47 rows, lies between two yarns.
    assert_eq!(one.factor(9, 0, 7), one.factor(10, 0, 7));
    assert_ne!(one.factor(10, 0, 7), one.factor(11, 0, 7));
    assert_ne!(one.factor(10, 0, 7), one.factor(10, 0, 8));
    assert_ne!(one.factor(10, 0, 7), other.factor(10, 0, 7));
    assert!((0..40).all(|column| one.least(10, 0) <= one.factor(10, 0, column)));
}
