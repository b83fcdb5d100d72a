use super::*;
use crate::case::{self, Case};
use crate::kernels::crossover::Published;

fn case(more: &[&str]) -> Case {
    case::shipped(&[&["/fabric/weft/count_per_inch=15", "/fabric/weft/modulus_gpa=60"], more].concat())
}

fn solved(case: &Case, asked: [Option<f64>; 2]) -> Result<InitialStretch, ModelError> {
    let pack = Pack { pretension: Some(asked), ..case.pack.clone() };
    solve::<Published>(&pack, &UnitCellParameters::new(&case.fabric))
}

#[test]
fn a_stretched_pack_carries_what_was_asked_and_keeps_its_length_elsewhere() {
    let absent = [&[][..], &[r#"/fabric/weft={"absent": true, "count_per_inch": 15}"#]];
    for (more, asked) in absent.into_iter().flat_map(|more| {
        [[Some(900.0), None], [None, Some(700.0)], [Some(900.0), Some(2500.0)], [Some(0.01), Some(1e4)]]
            .map(|asked| (more, asked))
    }) {
        let case = case(more);
        let cell = UnitCellParameters::new(&case.fabric);
        let both = more.is_empty();
        if !both && asked[1].is_some() {
            assert!(solved(&case, asked).is_err(), "a yarn that is not there carries nothing");
            continue;
        }
        let found = solved(&case, asked).unwrap_or_else(|error| unreachable!("{error}"));
        let cell_there = crossover::solve::<f64, Published>(&cell, found.stretch, found.height, both);
        // Yarns per length of the other direction's side.
        let counts = [case.fabric.weft.count, case.fabric.warp.count];
        for i in 0..2 {
            match asked[i] {
                Some(n) => {
                    let carried = cell_there.in_plane[i] * counts[i];
                    assert!((carried - n).abs() <= 1e-6 * n.max(1.0), "{asked:?}: {carried}");
                }
                None => assert_eq!(found.stretch[i], 0.0),
            }
        }
        if both {
            assert!((0..2).all(|i| (cell_there.height[i] / found.height[i] - 1.0).abs() < 1e-6), "{found:?}");
        }
    }
}

#[test]
fn no_yarn_is_stretched_to_where_it_breaks() {
    let case = case(&[]);
    let cell = UnitCellParameters::new(&case.fabric);
    let counts = [case.fabric.weft.count, case.fabric.warp.count];
    for (i, name) in ["warp", "weft"].into_iter().enumerate() {
        let with = |strain: f64| {
            let mut asked = [None; 2];
            asked[i] = Some(cell.yarn[i].stiffness * strain * counts[i]);
            solved(&case, asked)
        };
        assert!(with(0.0349).is_ok());
        let broken = with(0.0351);
        assert!(matches!(broken, Err(ModelError::PretensionBreaks { yarn, .. }) if yarn == name), "{broken:?}");
        let beyond = with(0.6);
        assert!(matches!(beyond, Err(ModelError::Pretension { yarn, .. }) if yarn == name), "{beyond:?}");
    }
}

#[test]
fn without_pretension_a_pack_rests() {
    let case = case(&[]);
    let cell = UnitCellParameters::new(&case.fabric);
    let rest = solve::<Published>(&case.pack, &cell);
    let heights = cell.yarn.map(|yarn| yarn.height);
    assert!(rest.is_ok_and(|rest| rest == InitialStretch { stretch: [0.0; 2], height: heights }));
}
