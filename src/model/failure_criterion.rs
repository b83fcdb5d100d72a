//! The piece of yarn over which failure is judged, and which breaks: the failure length along it, its own spacing across it.
//!
//! The strain of a single element under a sharp rim or a point grows as the mesh is refined; its mean along the yarn over a fixed length
//! converges. Elements narrower than a yarn are no yarns of their own: those side by side in a yarn are judged together, by the root mean
//! square of these means, and break together. Where they broke one by one, a yarn tore from side to side, and a finer mesh took up more
//! energy (docs/decisions/09).
//!
//! Along the yarn what lies in the piece breaks with it. Where one row of elements broke alone, yarns side by side that broke a row apart stayed
//! tied to each other by the node between them, and held on to a projectile or not by chance (docs/decisions/09).

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

    /// Mean over the breadth of a yarn of a quantity of its elements side by side, one of which is given.
    pub(crate) fn of_yarn(&self, element: usize, of: impl Fn(usize) -> f64) -> f64 {
        let window = &self.across[element];
        let sum: f64 = window.elements().map(|(beside, breadth)| breadth * of(beside)).sum();
        sum / window.length.iter().sum::<f64>()
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
            for row in 0..ply_type.mesh.rows {
                let at = ply * rows + row;
                for yarn in (0..2).filter(|yarn| breaks[*yarn]) {
                    for column in 0..ply_type.mesh.columns {
                        let factor = draws.factor(ply, ply_type, yarn, [row, column]);
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

/// Source of the strengths.
#[derive(Clone, Copy, Debug)]
struct Draws {
    /// Of the shot.
    key: DrawKey,
    along: Weibull,
    /// Shortest length of yarn that differs in strength from its neighbours [m].
    shortest: f64,
    between: Option<Weibull>,
}

impl Draws {
    fn of(case: &Case) -> Option<Self> {
        let Variability { seed, shot: Some(shot), yarn_strength: Some(strength), .. } = case.variability.as_ref()?
        else {
            return None;
        };
        let YarnStrength { shape, gauge_length, shortest_gauge, yarn_shape } = *strength;
        let of_mean_one = |shape: f64, gauge: f64| {
            let one = Weibull { scale: 1.0, shape, gauge };
            Weibull { scale: 1.0 / one.mean(gauge), ..one }
        };
        Some(Self {
            key: DrawKey { seed: u64::from(*seed), shot: *shot, element: DrawKey::WHOLE, ..DrawKey::default() },
            along: of_mean_one(shape, gauge_length),
            shortest: shortest_gauge,
            between: yarn_shape.map(|shape| of_mean_one(shape, 1.0)),
        })
    }

    /// Strength of an element of a yarn (0 warp, 1 weft). Nothing is known of lengths below the shortest gauge: elements of a piece of
    /// that length share its strength, so that the weakest piece is that of the whole yarn on every mesh.
    fn factor<S>(&self, ply: usize, ply_type: &PlyType<S>, direction: usize, [row, column]: [usize; 2]) -> f64 {
        let (mesh, cell, along, across) = (&ply_type.mesh, &ply_type.cell, [column, row], [row, column]);
        let number = mesh.yarn(1 - direction, across[direction], breadth(mesh, cell)[direction]);
        let yarn = 2 * number + direction as u32;
        let key = DrawKey { ply: ply as u32, yarn, ..self.key };
        let whole = self.between.map_or(1.0, |between| between.strength(1.0, key.uniform()[0]));
        let crimped = 1.0 + cell.yarn[direction].crimp;
        let [element, yarn] = [mesh.size(row, column), mesh.whole_size()].map(|size| size[direction] * crimped);
        // Pieces of one length, as many as go into the yarn.
        let piece = yarn / (yarn / self.shortest).floor().max(1.0);
        let from = crimped * (mesh.reference(row, column)[direction] - mesh.reference(0, 0)[direction]);
        let number = if element < piece { ((from + 0.5 * element) / piece) as usize } else { along[direction] };
        let [u, ..] = DrawKey { element: number as u32, ..key }.uniform();
        whole * self.along.strength(element.max(piece).max(self.shortest), u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case;
    use crate::model::Model;

    #[test]
    fn what_breaks_together_lies_within_half_the_failure_length() {
        let mesh = [
            "/pack/elements_per_crossover=4",
            "/pack/mesh_grading={\"fine_radius_mm\": 3}",
            "/solver/failure_length_mm=2",
        ];
        let case = case::shipped(&[&["/expect=[]"], &mesh[..]].concat());
        let model = Model::<f64>::new(&case).unwrap_or_else(|error| unreachable!("{error}"));
        let ply_type = model.ply_type(0);
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

    fn model(sets: &[&str]) -> Model<f64> {
        let case = case::shipped(&[&["/expect=[]", "/pack/width_mm=60", "/pack/height_mm=60"], sets].concat());
        Model::part(&case).unwrap_or_else(|error| unreachable!("{error}"))
    }

    /// Minimum over a yarn of its elements, over many shots, against the closed form: the chain rule.
    #[test]
    fn the_weakest_element_of_a_yarn_is_weibulls_with_the_length_of_the_yarn() {
        for (mesh, shortest) in [("1", 25.0), ("2", 25.0), ("2", 8.0), ("1", 0.01)] {
            let mesh = &format!("/pack/elements_per_crossover={mesh}");
            let (mut weakest, mut strongest) = (Vec::new(), 0.0_f64);
            let mut length = 0.0;
            for shot in 0..12 {
                let shot = format!("/variability/shot={shot}");
                let strength = format!(
                    "/variability/yarn_strength={{\"shape\": 9, \"gauge_length_mm\": 50, \"shortest_gauge_mm\": {shortest}}}"
                );
                let model = model(&[mesh, &shot, &strength]);
                let Some(strength) = &model.strength else { unreachable!("strength varies") };
                let ply_type = model.ply_type(0);
                let mut last = u32::MAX;
                for row in 0..ply_type.mesh.rows {
                    let yarn = ply_type.mesh.yarn(1, row, breadth(&ply_type.mesh, &ply_type.cell)[0]);
                    if yarn != last {
                        last = yarn;
                        let of_row = (0..ply_type.mesh.columns).map(|column| strength.factor(row, 0, column));
                        weakest.push(of_row.clone().fold(f64::INFINITY, f64::min));
                        strongest = of_row.fold(strongest, f64::max);
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
                let p = -(-(length / law.gauge) * (weak / law.scale).powf(law.shape)).exp_m1();
                (p - i as f64 / n).abs().max((p - (i as f64 + 1.0) / n).abs())
            });
            let off = off.fold(0.0, f64::max);
            assert!(off < 1.63 / n.sqrt(), "{mesh}, {shortest}: {off} of {n} yarns");
            // No element is stronger than pieces of the shortest gauge are: but by chance once in 1e8 draws.
            let bound = law.strength(1e-3 * shortest, 1.0 - 1e-8);
            assert!(strongest < bound && strongest > 1.0, "{mesh}, {shortest}: {strongest} {bound}");
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
        // The ply is 61 mm long: two pieces of yarn, none shorter than 25 mm. The middle, after 47 rows, lies between two yarns.
        assert_eq!(one.factor(9, 0, 7), one.factor(10, 0, 7));
        assert_ne!(one.factor(10, 0, 7), one.factor(11, 0, 7));
        assert_eq!(one.factor(10, 0, 7), one.factor(10, 0, 40));
        assert_ne!(one.factor(10, 0, 7), one.factor(10, 0, 60));
        assert_ne!(one.factor(10, 0, 7), other.factor(10, 0, 7));
        assert!((0..40).all(|column| one.least(10, 0) <= one.factor(10, 0, column)));
    }
}
