//! Plies, edges and initial state, in SI units.

use super::{Fabric, Grading};

/// The pack: plies and the frame that holds them.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Pack {
    /// Number of plies.
    pub plies: u32,
    /// Distance between mid-planes of neighbouring plies [m]; `None`: the mean of their two thicknesses.
    pub spacing: Option<f64>,
    /// Coulomb coefficient between plies [-].
    pub friction: f64,
    /// The plies in groups from the struck side, where they are not all of the case's fabric, laid alike; else empty.
    pub layup: Vec<Layer>,
    /// Elements of the finest size along warp (X); the asked width rounded to whole elements.
    pub columns: usize,
    /// Elements of the finest size along weft (Y).
    pub rows: usize,
    /// Undeformed length along warp of the finest elements [m].
    pub element_length_x: f64,
    /// Undeformed length along weft of the finest elements [m].
    pub element_length_y: f64,
    /// Crossovers along each side of an element of the finest size.
    pub crossovers_per_element: u32,
    /// How elements grow away from the hit; `None`: they are alike.
    pub grading: Option<Grading>,
    /// Elements along each side of one crossover.
    pub elements_per_crossover: u32,
    /// Boundary conditions.
    pub edges: Edges,
    /// Initial membrane force per reference length [N/m] along warp and weft; `None` holds that stretch at 1.
    pub pretension: Option<[Option<f64>; 2]>,
    /// Uniform initial velocity of every free node [m/s].
    pub initial_velocity: [f64; 3],
    /// Initial sine deflection, if any.
    pub initial_deflection: Option<InitialDeflection>,
}

impl Pack {
    /// Crossovers along a side of the finest elements.
    pub(crate) fn crossovers_along_element(&self) -> f64 {
        f64::from(self.crossovers_per_element) / f64::from(self.elements_per_crossover)
    }
}

/// Consecutive plies that are alike.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Layer {
    /// Number of plies.
    pub plies: u32,
    /// Their fabric.
    pub fabric: Fabric,
    /// Angle of the warp to the pack's X axis, towards Y [rad]. The ply's own axes turn with it, its edges too.
    pub orientation: f64,
    /// Boundary conditions, in the ply's own axes.
    pub edges: Edges,
    /// Initial velocity of every free node, in the pack's axes [m/s].
    pub initial_velocity: [f64; 3],
    /// Elements of the finest size along warp.
    pub columns: usize,
    /// Elements of the finest size along weft.
    pub rows: usize,
    /// Undeformed length along warp of the finest elements [m].
    pub element_length_x: f64,
    /// Undeformed length along weft of the finest elements [m].
    pub element_length_y: f64,
    /// How elements grow away from the hit; `None`: they are alike.
    pub grading: Option<Grading>,
}

/// w = amplitude · sin(m π X/width) · sin(n π Y/height); 0 half waves along a direction: constant there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct InitialDeflection {
    /// [m]
    pub amplitude: f64,
    /// m
    pub warp_half_waves: u32,
    /// n
    pub weft_half_waves: u32,
}

/// Boundary condition of each side; X runs left to right along warp, Y bottom to top along weft.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Edges {
    /// X = 0
    pub left: Edge,
    /// X = width
    pub right: Edge,
    /// Y = 0
    pub bottom: Edge,
    /// Y = height
    pub top: Edge,
}

impl Edges {
    /// Whether two opposite sides are clamped, so that the ply spans between them. A roller lets it move along its normal.
    pub fn span(&self) -> bool {
        [[self.left, self.right], [self.bottom, self.top]].contains(&[Edge::Clamped; 2])
    }
}

/// Boundary condition of one side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Edge {
    /// All displacements held.
    Clamped,
    /// Nothing held.
    Free,
    /// Displacement normal to the side held (symmetry plane).
    Roller,
}
