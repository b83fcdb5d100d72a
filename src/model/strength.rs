//! Strength of every piece of yarn of a shot: its failure strain over the fabric's.
//!
//! A yarn has a draw of its own, and on top each of its elements has one, so that the strength along it is Weibull's with the length of the
//! element ([`Weibull::strength`]): a chain of short elements is as strong as one long element. Elements that share a yarn share its draws.
//! An element that covers several yarns has those of the one in its middle.

use super::{Mesh, Ply, PlyType, failure_length};
use crate::case::{Case, Variability, YarnStrength};
use crate::kernels::unit_cell_parameters::NEVER;
use crate::num::counter_random::DrawKey;
use crate::num::weibull::Weibull;

/// CommandFailure strains of elements over the fabric's, of the whole pack.
#[derive(Clone, Debug, PartialEq)]
pub struct Strength {
    /// Shape (plies·rows, 2, columns): warp and weft of a row of elements one after the other \[-\].
    factors: Vec<f64>,
    columns: usize,
    /// Least of each row, of warp and weft \[-\].
    least: Vec<[f64; 2]>,
}

impl Strength {
    /// The draws of the shot that a case is; `None` where strength does not vary.
    pub(super) fn new<S>(
        case: &Case,
        ply_types: &[PlyType<S>],
        plies: &[Ply],
        rows: usize,
        columns: usize,
    ) -> Option<Self> {
        let draws = Draws::of(case)?;
        let mut factors = vec![1.0; plies.len() * rows * 2 * columns];
        let mut least = vec![[f64::INFINITY; 2]; plies.len() * rows];
        for (ply, ply_type) in plies.iter().enumerate().map(|(number, ply)| (number, &ply_types[ply.ply_type])) {
            let breaks = [0, 1].map(|yarn| ply_type.present[yarn] && ply_type.cell.yarn[yarn].failure_strain < NEVER);
            let pieces = YarnLayout::new(ply_type);
            for row in 0..ply_type.mesh.rows {
                let at = ply * rows + row;
                for yarn in (0..2).filter(|yarn| breaks[*yarn]) {
                    for column in 0..ply_type.mesh.columns {
                        let factor = draws.factor(ply, &pieces.at(yarn, row, column));
                        factors[(2 * at + yarn) * columns + column] = factor;
                        least[at][yarn] = least[at][yarn].min(factor);
                    }
                }
            }
        }
        Some(Self { factors, columns, least })
    }

    /// The same for all elements but the warp of one.
    #[cfg(test)]
    pub(crate) fn of_one(rows: usize, columns: usize, [row, column]: [usize; 2], factor: f64) -> Self {
        let mut strength = Self { factors: vec![1.0; rows * 2 * columns], columns, least: vec![[1.0; 2]; rows] };
        strength.factors[2 * row * columns + column] = factor;
        strength.least[row][0] = factor.min(1.0);
        strength
    }

    /// Of a yarn (0 warp, 1 weft) of an element.
    #[inline]
    pub fn factor(&self, row: usize, yarn: usize, column: usize) -> f64 {
        self.factors[(2 * row + yarn) * self.columns + column]
    }

    /// Of the weakest element of a row.
    #[inline]
    pub fn least(&self, row: usize, yarn: usize) -> f64 {
        self.least[row][yarn]
    }
}

/// A piece of yarn: an element of it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PieceOfYarn {
    /// 0 warp, 1 weft.
    direction: usize,
    /// The yarn, counted from the edge of the ply.
    yarn: u32,
    /// The element along it.
    element: u32,
    /// Length of yarn in it, undeformed [m].
    length: f64,
}

/// How the yarns of a ply type lie in its mesh.
struct YarnLayout<'a> {
    mesh: &'a Mesh,
    /// Of the yarns of warp and of weft, in lengths of the finest element.
    breadth: [f64; 2],
    /// Crimp of warp and weft [-].
    crimp: [f64; 2],
}

impl<'a> YarnLayout<'a> {
    fn new<S>(ply_type: &'a PlyType<S>) -> Self {
        let (mesh, cell) = (&ply_type.mesh, &ply_type.cell);
        Self { mesh, breadth: failure_length::breadth(mesh, cell), crimp: cell.yarn.map(|yarn| yarn.crimp) }
    }

    fn at(&self, direction: usize, row: usize, column: usize) -> PieceOfYarn {
        let (across, place) = (1 - direction, [column, row]);
        PieceOfYarn {
            direction,
            yarn: self.mesh.yarn(across, place[across], self.breadth[direction]),
            element: place[direction] as u32,
            length: self.mesh.size(row, column)[direction] * (1.0 + self.crimp[direction]),
        }
    }
}

/// Where strengths are drawn from.
#[derive(Clone, Copy, Debug)]
struct Draws {
    seed: u32,
    shot: u32,
    along: Weibull,
    between: Option<Weibull>,
}

impl Draws {
    fn of(case: &Case) -> Option<Self> {
        let Variability { seed, shot: Some(shot), yarn_strength: Some(strength), .. } = case.variability.as_ref()?
        else {
            return None;
        };
        let YarnStrength { shape, gauge_length, yarn_shape } = *strength;
        let of_mean_one = |shape: f64, gauge: f64| {
            let one = Weibull { scale: 1.0, shape, gauge };
            Weibull { scale: 1.0 / one.mean(gauge), ..one }
        };
        Some(Self {
            seed: *seed,
            shot: *shot,
            along: of_mean_one(shape, gauge_length),
            between: yarn_shape.map(|shape| of_mean_one(shape, 1.0)),
        })
    }

    fn factor(&self, ply: usize, piece: &PieceOfYarn) -> f64 {
        let yarn = 2 * piece.yarn + piece.direction as u32;
        let key =
            DrawKey { seed: u64::from(self.seed), shot: self.shot, ply: ply as u32, yarn, element: DrawKey::WHOLE };
        let whole = self.between.map_or(1.0, |between| between.strength(1.0, key.uniform()[0]));
        let [u, ..] = DrawKey { element: piece.element, ..key }.uniform();
        whole * self.along.strength(piece.length, u)
    }
}

#[cfg(test)]
#[path = "strength_tests.rs"]
mod tests;
