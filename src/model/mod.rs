//! The model: everything that stays constant during a run, derived once from the case.
//!
//! The model knows no backend. State arrays are laid out (shot, ply, row, column).

pub mod failure_criterion;
pub mod grid_lines;
pub mod layup;
pub mod mesh;
pub mod ply_type;
pub mod time_step;
pub mod unit_cell;

use crate::case::{Backing, Case, CaseError, ContactSampling, Law, Symmetry};
use crate::num::scalar::Scalar;
use crate::physics::projectile_body::Body;
use crate::physics::rigid_body::{MirrorPlanes, RigidBody};
use crate::physics::yarn_law::MAX_TERMS;
use failure_criterion::Strength;
use mesh::Grid;
use ply_type::PlyType;
use time_step::StepBound;

/// Constant data of a run in the number type of its state.
#[derive(Clone, Debug)]
pub struct Model<S> {
    /// Storage layout.
    pub grid: Grid,
    /// Ply types: constants that alike plies share; the first is that of the struck ply.
    pub ply_types: Vec<PlyType<S>>,
    /// The plies, the struck one first.
    pub plies: Vec<Ply>,
    /// Failure strains of the elements over the fabric's; `None`: they are the fabric's.
    pub strength: Option<Strength>,
    /// Critical step and what sets it.
    pub bound: StepBound,
    /// Time step [s].
    pub dt: f64,
    /// The projectile before its first step.
    pub projectile: Option<RigidBody>,
    /// Coulomb coefficient of the projectile [-].
    pub friction: f64,
    /// Whether the rim of a flat face is sampled where it crosses the edges of elements.
    pub edges: bool,
    /// Coulomb coefficient between plies [-].
    pub ply_friction: f64,
    /// Block behind the last ply.
    pub backing: Option<Backing>,
    /// Whether everything is at rest until the projectile touches it.
    pub at_rest: bool,
    /// Mirror planes that the scene is cut at: all of the above is the part at x ≥ 0, y ≥ 0.
    pub planes: MirrorPlanes,
    /// Mirror planes that the scene has, cut or not.
    pub mirror: MirrorPlanes,
}

/// A ply in the pack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ply {
    /// Place among the model's ply types.
    pub ply_type: usize,
    /// Reference position of its mid-plane behind that of the struck ply [m].
    pub z: f64,
    /// Thickness of the fabric in front of it, where none is missing [m].
    pub depth: f64,
    /// Mean thickness of it and of the ply behind it [m]; 0 for the last.
    pub thickness: f64,
    /// Distance of mid-planes at which it touches the ply behind it [m]; 0 for the last.
    pub touching: f64,
}

impl<S: Scalar> Model<S> {
    /// Derives the model of the whole scene from a case.
    ///
    /// # Errors
    /// When a part of the case that only geometry can judge is impossible.
    pub fn new(case: &Case) -> Result<Self, CaseError> {
        Self::cut(case, false)
    }

    /// Derives the model of the part of a scene that its mirror planes leave; of the whole where it has none, or where the
    /// case asks for it.
    ///
    /// # Errors
    /// As [`Model::new`].
    pub fn part(case: &Case) -> Result<Self, CaseError> {
        Self::cut(case, case.solver.symmetry == Symmetry::Auto)
    }

    fn cut(case: &Case, cut: bool) -> Result<Self, CaseError> {
        let (layers, plies) = layup::layup(case);
        let cell = layers.iter().map(|layer| layer.mesh.length[0].max(layer.mesh.length[1])).fold(0.0, f64::max);
        let unfit =
            || CaseError::at("/projectile/edge_radius_mm", "a rounding that fits into the shape", "a larger one");
        let projectile = match &case.projectile {
            Some(p) => Some(RigidBody::new(p, Body::new(p).ok_or_else(unfit)?, cell)),
            None => None,
        };
        let mirror = layup::planes_of(case, projectile.as_ref());
        let planes = if cut { mirror } else { MirrorPlanes::NONE };
        let ply_type = |layer| PlyType::new(case, layer, planes);
        let ply_types = layers.iter().map(ply_type).collect::<Result<Vec<_>, _>>()?;
        let bounds = ply_types.iter().map(|ply_type| ply_type.bound);
        let clay = StepBound { critical_step: case.clay_step(), set_by: "clay behind the pack" };
        let bound = bounds.fold(clay, |a, b| if b.critical_step < a.critical_step { b } else { a });
        let still = layers.iter().all(|layer| layer.initial_velocity == [0.0; 3]);
        let grid = Grid::new(plies.len(), ply_types.iter().map(|ply_type| &ply_type.mesh));
        Ok(Self {
            grid,
            strength: Strength::new(case, &ply_types, &plies, grid.rows, grid.columns),
            dt: case.solver.courant * bound.critical_step,
            friction: case.projectile.as_ref().map_or(0.0, |p| p.friction),
            edges: case.solver.contact_sampling == ContactSampling::Edges
                && projectile.as_ref().is_some_and(|body| body.body.profile.has_round_rim()),
            ply_friction: case.pack.friction,
            backing: case.backing,
            at_rest: still && case.pack.initial_deflection.is_none() && case.pack.pretension.is_none(),
            ply_types,
            plies,
            bound,
            projectile: projectile.map(|body| body.part(planes)),
            planes,
            mirror,
        })
    }

    /// Places for nodes in every ply.
    pub fn nodes_per_ply(&self) -> usize {
        (self.grid.rows + 1) * (self.grid.columns + 1)
    }

    /// Features of the scene.
    pub fn features(&self) -> Features {
        Features::new(self, &self.ply_types)
    }

    /// Every node: ply, row, column.
    pub fn node_places(&self) -> impl Iterator<Item = [usize; 3]> {
        self.places(1)
    }

    /// Every element: ply, row, column.
    pub fn element_places(&self) -> impl Iterator<Item = [usize; 3]> {
        self.places(0)
    }

    fn places(&self, more: usize) -> impl Iterator<Item = [usize; 3]> {
        (0..self.plies.len()).flat_map(move |ply| {
            let [rows, columns] = [self.ply_type(ply).mesh.rows + more, self.ply_type(ply).mesh.columns + more];
            (0..rows).flat_map(move |row| (0..columns).map(move |column| [ply, row, column]))
        })
    }

    /// The ply type of a ply.
    pub fn ply_type(&self, ply: usize) -> &PlyType<S> {
        &self.ply_types[self.plies[ply].ply_type]
    }

    /// Gap [m] to the clay behind a ply, the last one, its pressure over the areal density of the ply [m/s²], and what that gains with the
    /// depth, over it [1/m].
    pub fn clay(&self, ply: usize) -> Option<[f64; 3]> {
        let backing = self.backing.filter(|_| ply + 1 == self.plies.len());
        backing.map(|clay| [clay.gap, clay.pressure / self.ply_type(ply).areal_density, clay.gain()])
    }

    /// Rounding of the energy of a pack at rest [J].
    pub fn rounding(&self) -> f64 {
        self.plies.iter().map(|ply| self.ply_types[ply.ply_type].rounding()).sum()
    }

    /// Mass of the fabric that is computed [kg].
    pub(crate) fn fabric_mass(&self) -> f64 {
        self.plies.iter().map(|ply| self.ply_types[ply.ply_type].fabric_mass()).sum()
    }

    /// Elements over all plies.
    pub fn elements(&self) -> usize {
        self.plies.iter().map(|ply| self.ply_types[ply.ply_type].mesh.elements()).sum()
    }

    /// Elements of the whole scene, over all plies.
    pub fn whole_elements(&self) -> usize {
        self.elements() * self.planes.copies() as usize
    }

    /// Ply, row and column in the whole scene of a node or element.
    pub(crate) fn place_in_whole(&self, [ply, row, column]: [usize; 3]) -> [usize; 3] {
        let [right, up] = self.ply_type(ply).mesh.first_in_whole();
        [ply, row + up, column + right]
    }

    /// Reference position of a node in the pack's axes [m].
    pub fn reference(&self, ply: usize, row: usize, column: usize) -> [f64; 3] {
        let mesh = &self.ply_type(ply).mesh;
        let [x, y] = mesh.reference(row, column);
        mesh.to_pack([x, y, self.plies[ply].z])
    }
}

/// Features of a scene: terms of the model that it has. A device leaves the others out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Features {
    /// Forces of the yarns.
    pub law: Law,
    /// The yarn whose height is the unknown of the unit cell: 0 warp, 1 weft.
    pub pivot: usize,
    /// Terms of the arc length series.
    pub series: usize,
    /// Yarns flatten where they cross.
    pub compression: bool,
    /// Ramps of the curves of yarns that are not linear.
    pub curve: usize,
    /// Trellis shear.
    pub shear: bool,
    /// Yarns have forces that depend on rates: of shock viscosity or of the rate of strain.
    pub viscous: bool,
    /// Stress of the yarns depends on the rate of strain.
    pub rate: bool,
    /// Pieces of yarn differ in strength.
    pub strength: bool,
    /// There is a projectile.
    pub projectile: bool,
    /// The rim of its face is sampled too.
    pub edges: bool,
    /// There are plies that may touch each other.
    pub plies: bool,
    /// Elements of a ply differ in size.
    pub graded: bool,
    /// A frame cuts or holds a ply elsewhere than at the sides of its mesh.
    pub frame: bool,
    /// Clay stands behind the last ply.
    pub backing: bool,
}

impl Features {
    /// Features of these ply types in a model.
    pub fn new<S>(model: &Model<S>, ply_types: &[PlyType<S>]) -> Self {
        let any = |has: &dyn Fn(&PlyType<S>) -> bool| ply_types.iter().any(has);
        let (first, projectile) = (&ply_types[0], model.projectile.as_ref());
        Self {
            law: first.cell.yarn[0].law,
            pivot: first.cell.pivot,
            series: first.cell.yarn.iter().map(|yarn| yarn.terms).max().unwrap_or(MAX_TERMS),
            compression: any(&|t| t.cell.compression[0] > 0.0),
            curve: ply_types.iter().flat_map(|t| t.cell.yarn.map(|yarn| yarn.curve.count)).max().unwrap_or(0),
            shear: any(&|t| t.has_shear),
            viscous: any(&|t| t.viscous),
            rate: any(&|t| t.element.rate.is_some()),
            strength: model.strength.is_some(),
            projectile: projectile.is_some(),
            edges: model.edges,
            plies: model.plies.len() > 1,
            graded: any(&|t| t.mesh.is_graded()),
            // Of the whole pack: supports are numbered by it.
            frame: model.ply_types.iter().any(|t| !t.mesh.frame.is_plain()),
            backing: model.backing.is_some(),
        }
    }
}
