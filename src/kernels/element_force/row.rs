//! A row of elements and the rows of nodes around it.

use crate::kernels::law_energy::LawEnergy;
use crate::num::scalar::Real;

/// Fields of an element row, in storage order.
pub mod field {
    /// P1·Ly/2 [N], three components.
    pub(crate) const WARP_FORCE: usize = 0;
    /// P2·Lx/2 [N], three components.
    pub(crate) const WEFT_FORCE: usize = 3;
    /// Force on the difference of opposite edges, of yarns and hourglass stiffness, per corner [N], three components.
    pub const HOURGLASS: usize = 6;
    /// All forces.
    pub const FORCES: std::ops::Range<usize> = 0..9;
    /// What predicts the next heights: `dh_dstretch` [m] of warp and weft, `force_share` [-] of both; see [`Predictor`](crate::kernels::predictor::Predictor).
    pub const PREDICTOR: usize = 9;
    /// Yarn heights h1, h2 [m].
    pub const HEIGHT: usize = 13;
    /// 1 while the yarn carries load, [`MARKED_FOR_FAILURE`](super::super::MARKED_FOR_FAILURE) when it is about to fail, 0 once it failed or where it is absent;
    /// warp, weft.
    pub const ALIVE: usize = 15;
    /// Number of fields.
    pub const COUNT: usize = 17;
    /// Further fields where yarns have shock viscosity: viscous forces of warp and weft [N].
    pub const VISCOUS: usize = 2;
    /// Further fields, the last ones: strains of warp and weft that failure is judged by [-], 0 where slack, broken ones [`BROKEN`](super::super::BROKEN).
    pub const STRAIN: usize = 2;
}

/// Node rows below and above a row of elements, and the row's own storage.
pub struct ElementRow<'a, S> {
    /// Displacement x, y, z then velocity x, y, z of the row of nodes below.
    pub below: [&'a [S]; 6],
    /// The same above.
    pub above: [&'a [S]; 6],
    /// Element fields; column c is stored at c + 1 so that node c finds its left neighbour at c.
    pub element: [&'a mut [S]; field::COUNT],
    /// Viscous forces of warp and weft [N], stored as the fields are; `None`: the yarns have no shock viscosity.
    pub viscous: Option<[&'a mut [S]; field::VISCOUS]>,
    /// Strains of warp and weft that failure is judged by [-], stored as the fields are.
    pub strain: [&'a mut [S]; field::STRAIN],
    /// Height of the row, over that of a row of the finest elements [-].
    pub height: f64,
    /// Lengths of the elements along X over the finest, and 1 over that [-].
    pub width: &'a [S],
    /// See `width`.
    pub per_width: &'a [S],
    /// What the unit-cell law makes of energy by itself, for the ledger; `None`: nothing.
    pub law_energy: Option<&'a LawEnergy>,
    /// How many numbers further on the next row of elements has its fields, and the next row of nodes those of the one above.
    pub prefetch: [usize; 2],
}

impl<S> ElementRow<'_, S> {
    /// Whether all elements of the ply are alike.
    #[inline(always)]
    pub(super) fn is_even(&self) -> bool {
        self.width.is_empty()
    }
}

/// What of the kernel a step needs.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// The fabric resists trellis shear.
    pub shear: bool,
    /// The energies of the state are asked for.
    pub ledger: bool,
}

/// A field of the nodes at the corners of elements from `column` on, counter-clockwise.
#[inline(always)]
pub(super) fn corners<R: Real>(n: R, row: &ElementRow<'_, R::Scalar>, field: usize, column: usize) -> [R; 4] {
    let (below, above) = (row.below[field], row.above[field]);
    [n.load(below, column), n.load(below, column + 1), n.load(above, column + 1), n.load(above, column)]
}
