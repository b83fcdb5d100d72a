//! The uniform stretch of a pre-tensioned pack.

use super::ModelError;
use crate::case::Pack;
use crate::kernels::crossover::{self, LawKernel, UnitCellParameters};

/// Stretch range searched, Λ − 1.
const RANGE: [f64; 2] = [-0.5, 0.5];

/// Uniform stretch of the pack before the shot, and the yarn heights that go with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialStretch {
    /// Λ − 1 along warp and weft [-].
    pub stretch: [f64; 2],
    /// Yarn heights [m].
    pub height: [f64; 2],
}

/// Membrane forces per reference length N1, N2 [N/m], yarn strains and heights at a stretch.
fn membrane<L: LawKernel>(cell: &UnitCellParameters<f64>, stretch: [f64; 2]) -> ([f64; 2], [f64; 2], [f64; 2]) {
    let warm = [cell.yarn[0].height, cell.yarn[1].height];
    // Where a yarn is absent the heights sum up to nothing, and the other one straightens freely.
    let e = crossover::solve::<f64, L>(cell, stretch, warm, true);
    let force = [e.in_plane[0] / (2.0 * cell.yarn[1].half_span), e.in_plane[1] / (2.0 * cell.yarn[0].half_span)];
    (force, e.strain, e.height)
}

/// Finds the stretch that carries the pre-tension asked for; a direction without one keeps its length.
///
/// # Errors
/// When no stretch does, or when it would break a yarn.
pub fn solve<L: LawKernel>(pack: &Pack, cell: &UnitCellParameters<f64>) -> Result<InitialStretch, ModelError> {
    let rest = InitialStretch { stretch: [0.0; 2], height: [cell.yarn[0].height, cell.yarn[1].height] };
    let Some(asked) = pack.pretension else { return Ok(rest) };
    let mut stretch = [0.0; 2];
    // Both membrane forces grow with both stretches, so each direction is bisected, the warp inside the weft.
    let warp = |weft: f64| match asked[0] {
        Some(n) => bisect(|s| membrane::<L>(cell, [s, weft]).0[0] <= n),
        None => 0.0,
    };
    if let Some(n) = asked[1] {
        stretch[1] = bisect(|s| membrane::<L>(cell, [warp(s), s]).0[1] <= n);
    }
    stretch[0] = warp(stretch[1]);
    let (force, strain, height) = membrane::<L>(cell, stretch);
    for (i, yarn) in ["warp", "weft"].into_iter().enumerate() {
        if let Some(n) = asked[i].filter(|n| (force[i] - n).abs() > 1e-6 * n.max(1.0)) {
            return Err(ModelError::Pretension { yarn, asked: n });
        }
        let limit = cell.yarn[i].failure_strain;
        if cell.yarn[i].stiffness > 0.0 && strain[i] >= limit {
            return Err(ModelError::PretensionBreaks { yarn, strain: strain[i], limit });
        }
    }
    Ok(InitialStretch { stretch, height })
}

/// The largest number in [`RANGE`] for which `below` holds, if it holds up to some point.
fn bisect(below: impl Fn(f64) -> bool) -> f64 {
    let [mut low, mut high] = RANGE;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::{self, Case};
    use crate::kernels::crossover::PublishedTension;

    fn case(more: &[&str]) -> Case {
        case::shipped(&[&["/fabric/weft/count_per_inch=15", "/fabric/weft/modulus_gpa=60"], more].concat())
    }

    fn solved(case: &Case, asked: [Option<f64>; 2]) -> Result<InitialStretch, ModelError> {
        let pack = Pack { pretension: Some(asked), ..case.pack.clone() };
        solve::<PublishedTension>(&pack, &UnitCellParameters::new(&case.fabric))
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
            let cell_there = crossover::solve::<f64, PublishedTension>(&cell, found.stretch, found.height, both);
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
        let rest = solve::<PublishedTension>(&case.pack, &cell);
        let heights = cell.yarn.map(|yarn| yarn.height);
        assert!(rest.is_ok_and(|rest| rest == InitialStretch { stretch: [0.0; 2], height: heights }));
    }
}
