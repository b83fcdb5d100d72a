//! The piece of yarn over which failure is judged, and which breaks: the failure length along it, its own spacing across it.
//!
//! The strain of a single element under a sharp rim or a point grows as the mesh is refined; its mean along the yarn over a fixed length
//! converges. Elements narrower than a yarn are no yarns of their own: those side by side in a yarn are judged together, by the root mean
//! square of these means, and break together. Where they broke one by one, a yarn tore from side to side, and a finer mesh took up more
//! energy (docs/decisions/11).
//!
//! Along the yarn what lies in the piece breaks with it. Where one row of elements broke alone, yarns side by side that broke a row apart stayed
//! tied to each other by the node between them, and held on to a projectile or not by chance (docs/decisions/11).

use std::ops::Range;

use crate::case::{Case, Variability, YarnStrength};
use crate::model::Ply;
use crate::model::grid_lines::SAME;
use crate::model::mesh::Mesh;
use crate::model::ply_type::PlyType;
use crate::num::random::{DrawKey, Weibull};
use crate::physics::unit_cell_parameters::{NEVER, UnitCellParameters};

/// Elements that lie in a piece by half do not break with it. Share of half the failure length that rounding does not reach [-].
const HALF_WITHIN: f64 = 1e-4;

/// Elements within a length around the middle of one, or side by side in a yarn.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// The first of them: a column or a row.
    pub first: usize,
    /// Length of each within the window, in lengths of the finest element.
    pub length: Vec<f64>,
}

impl Window {
    /// Column or row of each element, with its length within the window.
    pub fn elements(&self) -> impl Iterator<Item = (usize, f64)> {
        (self.first..).zip(self.length.iter().copied())
    }
}

/// Windows of a yarn direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Windows {
    /// Along the yarn, by column for warp, by row for weft.
    pub along: Vec<Window>,
    /// Elements along the yarn that break with the one in the middle: they lie in the piece by more than half.
    pub breaking: Vec<Range<usize>>,
    /// Across the yarn, by row for warp, by column for weft: the whole yarn, the same for each of its elements.
    pub across: Vec<Window>,
}

impl Windows {
    /// The yarns side by side, each once.
    pub fn yarns(&self) -> impl Iterator<Item = &Window> {
        self.across.iter().enumerate().filter(|(at, window)| window.first == *at).map(|(_, window)| window)
    }
}

/// The spacing of warp and of weft yarns, in lengths of the finest element across them; across warp lies the crossovers' spacing along weft.
pub(super) fn breadth(mesh: &Mesh, cell: &UnitCellParameters<f64>) -> [f64; 2] {
    [1, 0].map(|axis| 2.0 * cell.yarn[axis].half_span / mesh.length[axis])
}

/// Half the length and the breadth of the piece, in lengths of the finest element; warp and weft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StencilRadius {
    /// Half of the failure length.
    pub along: [f64; 2],
    /// The yarns' spacing.
    pub breadth: [f64; 2],
}

impl StencilRadius {
    /// The element itself.
    const ELEMENT: Self = Self { along: [0.5; 2], breadth: [1.0; 2] };

    /// The piece of the failure length [m] and the [`breadth`] of a yarn; the element itself where none is smaller than that, or no length
    /// is given.
    pub(super) fn new(mesh: &Mesh, length: f64, breadth: [f64; 2]) -> Self {
        let along = mesh.length.map(|finest| 0.5 * length / finest);
        let smaller = along.iter().any(|half| *half > 0.5) || breadth.iter().any(|breadth| *breadth > 1.0 + SAME);
        if length > 0.0 && smaller { Self { along, breadth } } else { Self::ELEMENT }
    }

    /// The elements that lie side by side with one, along an axis, in the yarn across it.
    pub(crate) fn side_by_side(&self, mesh: &Mesh, axis: usize, element: usize) -> Range<usize> {
        mesh.side_by_side(axis, element, self.breadth[1 - axis])
    }

    /// Windows of warp and weft.
    pub(super) fn windows(&self, mesh: &Mesh) -> [Windows; 2] {
        let width = |axis: usize, at: usize| mesh.widths(at * axis, at * (1 - axis))[axis];
        let along = |axis: usize, reach: f64| {
            let overlaps = mesh.overlaps(axis, reach).into_iter();
            overlaps.map(|(first, length)| Window { first, length }).collect()
        };
        let across = |axis: usize, breadth: f64| {
            let count = [mesh.columns, mesh.rows][axis];
            let yarns = (0..count).map(|element| mesh.side_by_side(axis, element, breadth));
            yarns.map(|yarn| Window { first: yarn.start, length: yarn.map(|at| width(axis, at)).collect() }).collect()
        };
        [0, 1].map(|yarn| {
            let along: Vec<Window> = along(yarn, self.along[yarn]);
            let breaking = |(own, window): (usize, &Window)| {
                let is_within =
                    |at: usize, length: f64| length - 0.5 * width(yarn, at) > HALF_WITHIN * self.along[yarn];
                let within = window.elements().filter(|&(at, length)| is_within(at, length)).map(|(at, _)| at);
                let (first, last) = within.fold((own, own), |(first, last), at| (first.min(at), last.max(at)));
                first..last + 1
            };
            let breaking = along.iter().enumerate().map(breaking).collect();
            Windows { along, breaking, across: across(1 - yarn, self.breadth[yarn]) }
        })
    }
}

/// Failure strains of elements over the fabric's, of the whole pack.
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

    /// Strength of one for all elements but the warp of one.
    #[cfg(test)]
    pub(crate) fn of_one(rows: usize, columns: usize, [row, column]: [usize; 2], factor: f64) -> Self {
        let mut strength = Self { factors: vec![1.0; rows * 2 * columns], columns, least: vec![[1.0; 2]; rows] };
        strength.factors[2 * row * columns + column] = factor;
        strength.least[row][0] = factor.min(1.0);
        strength
    }

    /// Strength factor of a yarn (0 warp, 1 weft) of an element [-].
    #[inline]
    pub fn factor(&self, row: usize, yarn: usize, column: usize) -> f64 {
        self.factors[(2 * row + yarn) * self.columns + column]
    }

    /// Strength factor of the weakest element of a row [-].
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

/// Layout of the yarns of a ply type in its mesh.
struct YarnLayout<'a> {
    mesh: &'a Mesh,
    /// Breadth of the yarns of warp and of weft, in lengths of the finest element.
    breadth: [f64; 2],
    /// Crimp of warp and weft [-].
    crimp: [f64; 2],
}

impl<'a> YarnLayout<'a> {
    fn new<S>(ply_type: &'a PlyType<S>) -> Self {
        let (mesh, cell) = (&ply_type.mesh, &ply_type.cell);
        Self { mesh, breadth: breadth(mesh, cell), crimp: cell.yarn.map(|yarn| yarn.crimp) }
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

/// Source of the strengths.
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
#[path = "failure_criterion_tests.rs"]
mod tests;
