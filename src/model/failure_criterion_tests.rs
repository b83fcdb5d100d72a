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
