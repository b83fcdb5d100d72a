//! The model: everything that stays constant during a run, derived once from the case.
//!
//! The model knows no backend. State arrays that go with it are laid out (shot, ply, row, column).

pub mod grid;
pub mod pretension;
pub mod terms;
pub mod time_step;

use crate::case::{Case, Edge, Edges};
use crate::kernels::crossover::{CellConstants, LawKernel, Variant};
use crate::kernels::element_force::ElementConstants;
use crate::kernels::projectile_shape::Body;
use crate::kernels::rigid_body::RigidBody;
use crate::kernels::shear::ShearConstants;
use crate::number::{Real, Scalar};
pub use grid::Grid;
pub use pretension::InitialStretch;
pub use terms::Terms;
pub use time_step::StepBound;

/// Why a valid case cannot become a model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// The edge radius does not fit.
    #[error("/projectile/edge_radius_mm: the rounding does not fit into the shape")]
    EdgeRadius,
    /// No stretch gives the tension asked for.
    #[error("/pack/pretension: no stretch between 0.5 and 1.5 gives {asked} N/m along {yarn}")]
    Pretension {
        /// Yarn direction.
        yarn: &'static str,
        /// [N/m]
        asked: f64,
    },
    /// The tension asked for would break the yarn before the shot.
    #[error("/pack/pretension: it strains the {yarn} to {strain:.4}, beyond its failure strain {limit}")]
    PretensionBreaks {
        /// Yarn direction.
        yarn: &'static str,
        /// Yarn strain it needs [-].
        strain: f64,
        /// Failure strain [-].
        limit: f64,
    },
    /// The projectile overlaps the pack at the start.
    #[error(
        "/projectile: it starts {depth_mm:.6} mm inside the fabric; raise /projectile/standoff_mm or lower \
         /pack/initial_deflection"
    )]
    InitialPenetration {
        /// [mm]
        depth_mm: f64,
    },
}

/// Constant data of a run in the number type of its state.
#[derive(Clone, Debug)]
pub struct Model<S> {
    /// Mesh and storage layout.
    pub grid: Grid,
    /// Unit cell, double precision.
    pub cell: CellConstants<f64>,
    /// Which unit-cell kernel runs.
    pub law: Variant,
    /// Element constants, double precision.
    pub element: ElementConstants<f64>,
    /// Whether the case has trellis shear.
    pub has_shear: bool,
    /// Which yarn directions are there.
    pub present: [bool; 2],
    /// Critical step and what sets it.
    pub bound: StepBound,
    /// Time step [s].
    pub dt: f64,
    /// Masses by kind of row (first, inner, last), shape (3, node stride).
    pub mass: [RowMasses<S>; 3],
    /// Uniform initial stretch.
    pub initial: InitialStretch,
    /// The projectile before its first step.
    pub projectile: Option<RigidBody>,
    /// Coulomb coefficient of the projectile [-].
    pub friction: f64,
}

/// Masses of one kind of row, shape (node stride,).
#[derive(Clone, Debug)]
pub struct RowMasses<S> {
    /// 1/mass where free, 0 where held [1/kg]; X, Y, Z.
    pub inverse: [Vec<S>; 3],
    /// Lumped mass [kg].
    pub mass: Vec<S>,
}

impl<S: Scalar> Model<S> {
    /// Derives the model from a case.
    ///
    /// # Errors
    /// When a part of the case that only geometry can judge is impossible; see [`ModelError`].
    pub fn new(case: &Case) -> Result<Self, ModelError> {
        let (fabric, pack) = (&case.fabric, &case.pack);
        let grid = Grid::new(pack);
        let cell = CellConstants::new(fabric);
        let element = element_constants(case, &cell);
        let bound = StepBound::new(case, &element);
        let law = Variant::of(&fabric.crossover);
        let initial = crate::with_law!(law, L => pretension::solve::<L>(pack, &cell)?);
        let projectile = match &case.projectile {
            Some(p) => {
                let body = Body::new(p).map_err(|_| ModelError::EdgeRadius)?;
                Some(RigidBody::new(p, body, grid.length[0].max(grid.length[1])))
            }
            None => None,
        };
        let mass = [0, 1, 2].map(|kind| row_masses(&grid, fabric.areal_density, &pack.edges, kind));
        Ok(Self {
            grid,
            law,
            has_shear: fabric.shear.is_some(),
            present: [fabric.warp.present, fabric.weft.present],
            dt: case.solver.courant * bound.critical_step,
            friction: case.projectile.as_ref().map_or(0.0, |p| p.friction),
            cell,
            element,
            bound,
            mass,
            initial,
            projectile,
        })
    }

    /// Terms of the model that the scene has.
    pub fn terms(&self) -> Terms {
        Terms::new(self)
    }

    /// Masses of a row of nodes.
    pub fn row_mass(&self, row: usize) -> &RowMasses<S> {
        let kind = if row == 0 { 0 } else { 1 + usize::from(row == self.grid.rows) };
        &self.mass[kind]
    }

    /// Element constants as the number type of a kernel sees them.
    pub fn constants<R: Real, L: LawKernel>(&self) -> ElementConstants<R> {
        let e = &self.element;
        let s = &e.shear;
        ElementConstants {
            cell: CellConstants::cast::<L>(&self.cell),
            shear: ShearConstants {
                g1: R::splat(s.g1),
                rise: R::splat(s.rise),
                gamma1: R::splat(s.gamma1),
                ramp: R::splat(s.ramp),
                slope: R::splat(s.slope),
                secant: R::splat(s.secant),
            },
            gradient: e.gradient.map(R::splat),
            membrane: e.membrane.map(R::splat),
            half_length: e.half_length.map(R::splat),
            hourglass: e.hourglass.map(R::splat),
            cells: R::splat(e.cells),
            area: R::splat(e.area),
        }
    }
}

/// Constants of the element kernel.
fn element_constants(case: &Case, cell: &CellConstants<f64>) -> ElementConstants<f64> {
    let (fabric, pack) = (&case.fabric, &case.pack);
    let (lx, ly) = (pack.element_length_x, pack.element_length_y);
    let [w1, w2] = [cell.yarn[0].half_span, cell.yarn[1].half_span];
    // Full integration resists the hourglass mode with (4/3) C Ly/Lx and (4/3) C Lx/Ly; the coefficient scales
    // their mean.
    let warp = cell.yarn[0].stiffness / (2.0 * w2) * ly / lx;
    let weft = cell.yarn[1].stiffness / (2.0 * w1) * lx / ly;
    let hourglass = [warp, weft].map(|k| case.solver.hourglass * (2.0 / 3.0) * k);
    let none =
        crate::case::Shear { g1: 0.0, g2: 0.0, gamma1: 0.0, gamma2: 0.0, modulus: crate::case::ShearModulus::Tangent };
    ElementConstants {
        cell: *cell,
        shear: ShearConstants::new(fabric.shear.as_ref().unwrap_or(&none), fabric.thickness),
        gradient: [0.5 / lx, 0.5 / ly],
        membrane: [0.5 * ly / (2.0 * w2), 0.5 * lx / (2.0 * w1)],
        half_length: [0.5 * ly, 0.5 * lx],
        hourglass,
        cells: lx / (2.0 * w1) * (ly / (2.0 * w2)),
        area: lx * ly,
    }
}

/// Masses of the first (0), an inner (1) or the last (2) row of nodes.
fn row_masses<S: Scalar>(grid: &Grid, areal_density: f64, edges: &Edges, kind: usize) -> RowMasses<S> {
    let across = if kind == 1 { 1.0 } else { 0.5 };
    let row_edge = match kind {
        0 => Some(edges.bottom),
        2 => Some(edges.top),
        _ => None,
    };
    let mut out = RowMasses {
        inverse: std::array::from_fn(|_| vec![S::splat(0.0); grid.node_stride]),
        mass: vec![S::splat(0.0); grid.node_stride],
    };
    for column in 0..=grid.columns {
        let along = if column == 0 || column == grid.columns { 0.5 } else { 1.0 };
        let mass = areal_density * grid.length[0] * grid.length[1] * along * across;
        let column_edge = match column {
            0 => Some(edges.left),
            c if c == grid.columns => Some(edges.right),
            _ => None,
        };
        let clamped = row_edge == Some(Edge::Clamped) || column_edge == Some(Edge::Clamped);
        let held = [clamped || column_edge == Some(Edge::Roller), clamped || row_edge == Some(Edge::Roller), clamped];
        for a in 0..3 {
            out.inverse[a][column] = S::splat(if held[a] { 0.0 } else { 1.0 / mass });
        }
        out.mass[column] = S::splat(mass);
    }
    out
}
