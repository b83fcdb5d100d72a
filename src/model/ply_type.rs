//! A ply type: everything that plies of one fabric, laid and held alike, share.

use std::sync::Arc;

use crate::case::{Case, CaseError, Edge, Edges, Fabric, Layer, Opening, Solver, StretchSampling};
use crate::model::failure_criterion::{StencilRadius, Windows, breadth};
use crate::model::mesh::{Grid, Mesh};
use crate::model::time_step::{FEW, InitialStretch, LET_GO, STEP_OF_FEW, StepBound, let_go, stretch_of_pretension};
use crate::model::unit_cell::LawEnergy;
use crate::model::{layup, unit_cell};
use crate::num::scalar::Scalar;
use crate::physics::crossover::compression_energy;
use crate::physics::kinematics::{ElementConstants, RateConstants};
use crate::physics::membrane::ShearConstants;
use crate::physics::rigid_body::MirrorPlanes;
use crate::physics::unit_cell_parameters::UnitCellParameters;
use crate::physics::yarn_law::Sinusoidal;

/// Constants of alike plies in the number type of the state.
#[derive(Clone, Debug)]
pub struct PlyType<S> {
    /// Mesh and how it lies in the pack.
    pub mesh: Mesh,
    /// Unit cell, double precision.
    pub cell: UnitCellParameters<f64>,
    /// Element constants, double precision.
    pub element: ElementConstants<f64>,
    /// Whether the fabric has trellis shear.
    pub has_shear: bool,
    /// Presence of the yarn directions.
    pub present: [bool; 2],
    /// Critical step and what sets it.
    pub bound: StepBound,
    /// Mass per area [kg/m²].
    pub areal_density: f64,
    /// Edges of the ply.
    pub edges: Edges,
    /// Masses by row of nodes.
    mass: Vec<RowMasses<S>>,
    /// Sizes of the elements of a row.
    pub columns: Columns<S>,
    /// Energy that the unit-cell law makes by itself; `None`: none.
    pub law_energy: Option<Arc<LawEnergy>>,
    /// Yarns have forces that depend on rates: of shock viscosity or of the rate of strain.
    pub viscous: bool,
    /// Elements whose strains break a yarn together, of warp and weft.
    pub windows: [Windows; 2],
    /// Size of the piece of yarn that they make up.
    pub failure_reach: StencilRadius,
    /// Uniform initial stretch.
    pub initial: InitialStretch,
    /// Initial velocity of free nodes in the ply's axes [m/s].
    pub initial_velocity: [f64; 3],
}

/// Masses of a row of nodes, shape (node stride,).
#[derive(Clone, Debug)]
pub struct RowMasses<S> {
    /// 1/mass where free, 0 where held [1/kg]; X, Y, Z of the ply.
    pub inverse: [Vec<S>; 3],
    /// Lumped mass [kg].
    pub mass: Vec<S>,
}

impl<S: Scalar> PlyType<S> {
    /// Derives the constants of a layer cut at these planes.
    pub(super) fn new(case: &Case, layer: &Layer, planes: MirrorPlanes) -> Result<Self, CaseError> {
        let (fabric, pack) = (&layer.fabric, &case.pack);
        let length = layer.mesh.length;
        let mesh = Mesh::of_layer(layer).part(planes);
        let Edges { left, right, bottom, top } = layer.edges;
        let along_axes = mesh.rotation.contains(&0.0);
        if !along_axes && [left, right, bottom, top].contains(&Edge::Roller) {
            let found = format!("rollers on a ply at {:.6}°", layer.orientation.to_degrees());
            return Err(CaseError::at("/pack/layup", "rollers on plies at multiples of 90° alone", found)
                .help("clamp or free the sides of the others"));
        }
        let cell = UnitCellParameters::new(fabric);
        let element = element_constants(fabric, length, &case.solver, &cell);
        // Of a mesh that is cut to the opening, sides are held by the node.
        let free = Edges { left: Edge::Free, right: Edge::Free, bottom: Edge::Free, top: Edge::Free };
        let edges = layup::cut_edges(&mesh, if mesh.frame.opening == Opening::Mesh { layer.edges } else { free });
        let bound = StepBound::new(length, fabric.areal_density, &element, case.solver.shock_viscosity);
        let bound = match element.rate {
            // Such a yarn is stiffer by what the rate may add.
            Some(rate) => bound.shortened((1.0 + 2.0 * rate.most).sqrt().recip(), "rate of strain"),
            None => bound,
        };
        let damped = case.solver.shock_viscosity > 0.0;
        let viscous = damped || element.rate.is_some();
        // Where a ply under tension is torn, it is let go. The paper's scheme keeps its own step.
        let few = damped && pack.pretension.is_some() && mesh.whole_counts().iter().product::<usize>() < FEW;
        let bound = match let_go(pack.pretension, pack.initial_deflection, layer.edges, mesh.whole_size()) {
            Some(set_by) => bound.shortened(LET_GO, set_by),
            None if few => bound.shortened(STEP_OF_FEW, "initial tension in few elements"),
            None => bound,
        };
        let failure_reach = StencilRadius::new(&mesh, case.solver.failure_length, breadth(&mesh, &cell));
        let ply_type = Self {
            bound,
            initial: stretch_of_pretension(pack, &cell)?,
            mass: (0..=mesh.rows)
                .map(|row| row_masses(&mesh, fabric.areal_density, [&edges, &layer.edges], row))
                .collect(),
            law_energy: unit_cell::table_of(&cell),
            columns: Columns::new(&mesh),
            viscous,
            windows: failure_reach.windows(&mesh),
            failure_reach,
            initial_velocity: mesh.to_ply(layer.initial_velocity),
            has_shear: fabric.shear.is_some(),
            present: [fabric.warp.present, fabric.weft.present],
            areal_density: fabric.areal_density,
            edges,
            mesh,
            cell,
            element,
        };
        ply_type.check_fixture()?;
        Ok(ply_type)
    }

    /// Refuses an opening without a free node, and clamps at corners that hold none.
    fn check_fixture(&self) -> Result<(), CaseError> {
        let frame = self.mesh.frame;
        let is_there = |(row, column): &(usize, usize)| self.row_mass(*row).mass[*column].to_f64() > 0.0;
        let held = |held: bool| self.nodes().filter(is_there).any(|(row, column)| self.is_clamped(row, column) == held);
        let (key, expected) = match (frame.is_plain() || held(false), frame.corner == 0.0 || held(true)) {
            (true, true) => return Ok(()),
            (false, _) => ("/pack", "a frame that leaves a node free"),
            (_, false) => ("/pack/corner_clamps_mm", "clamps that hold a node of every ply"),
        };
        Err(CaseError::at(key, expected, "none").help("the mesh is too coarse for the opening or the clamps"))
    }

    /// Rounding of the energy of a ply at rest [J]: one unit in the last place of the stretches, and of the
    /// compression energy's b³/a², and the crossover under the force of a strain of one unit. It is the most where that hardly resists.
    pub(super) fn rounding(&self) -> f64 {
        let [a, b, _] = self.cell.compression;
        let yarns: f64 = self.cell.yarn.iter().map(|y| y.stiffness * y.half_span).sum();
        let pressed = if a > 0.0 { b.powi(3) / a.powi(2) } else { 0.0 };
        let force = S::EPSILON * self.cell.yarn.iter().map(|y| y.stiffness).fold(0.0, f64::max);
        let touched = compression_energy(&self.cell, force).max(0.0);
        let crossovers = self.element.cells * self.mesh.finest_elements();
        crossovers * (S::EPSILON * (yarns * S::EPSILON + pressed) + touched)
    }

    /// Masses of a row of nodes.
    pub fn row_mass(&self, row: usize) -> &RowMasses<S> {
        &self.mass[row]
    }

    /// Whether a clamp holds a node.
    pub fn is_clamped(&self, row: usize, column: usize) -> bool {
        self.row_mass(row).inverse[2][column].to_f64() <= 0.0
    }

    /// Every node of the mesh: row, column.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = (usize, usize)> + use<S> {
        let [rows, columns] = [self.mesh.rows, self.mesh.columns];
        (0..=rows).flat_map(move |row| (0..=columns).map(move |column| (row, column)))
    }

    /// Mass of the fabric that is computed [kg].
    pub(crate) fn fabric_mass(&self) -> f64 {
        let [along, across] = self.mesh.length;
        if self.mesh.frame.opening == Opening::Mesh {
            return self.areal_density * along * across * self.mesh.finest_elements();
        }
        self.nodes().map(|(row, column)| self.row_mass(row).mass[column].to_f64()).sum()
    }

    /// Element constants in the precision of a kernel.
    pub fn constants<T: Scalar>(&self) -> ElementConstants<T> {
        self.element.map(UnitCellParameters::cast::<Sinusoidal>(&self.cell), T::splat)
    }
}

/// Length of an element above which the shock viscosity of smooth waves grows no more [crossovers]. In proportion to the length of coarse
/// elements it takes 5 of 154 J of a shot at four plies; without more than this, fronts ring there and break yarns at the frame. So
/// the viscosity of the whole length comes in with the steepness of the front. In crossovers, so that finer elements around the hit
/// change nothing beyond them (docs/decisions/07).
const VISCOUS_LENGTH: f64 = 1.0;
/// Stretch that a front adds while it crosses an element, and from which the viscosity of the whole length acts [-]: about what breaks an
/// aramid, so that it grows with the square of the rate up to failure. One number for all, for elastic waves know of no failure.
const STEEP_FRONT: f64 = 0.035;

/// Constants of the element kernel.
fn element_constants(
    fabric: &Fabric,
    [lx, ly]: [f64; 2],
    solver: &Solver,
    cell: &UnitCellParameters<f64>,
) -> ElementConstants<f64> {
    let [w1, w2] = [cell.yarn[0].half_span, cell.yarn[1].half_span];
    // Full integration resists the hourglass mode with (4/3) C Ly/Lx and (4/3) C Lx/Ly; the coefficient scales
    // their mean.
    let warp = cell.yarn[0].stiffness / (2.0 * w2) * ly / lx;
    let weft = cell.yarn[1].stiffness / (2.0 * w1) * lx / ly;
    let hourglass = [warp, weft].map(|k| solver.hourglass * (2.0 / 3.0) * k);
    let viscosity = [0, 1].map(|i| {
        let stiffness = cell.yarn[i].stiffness / (2.0 * cell.yarn[1 - i].half_span);
        // Time that a wave of the straight yarn takes over the element.
        let period = if stiffness > 0.0 { [lx, ly][i] * (fabric.areal_density / stiffness).sqrt() } else { 0.0 };
        solver.shock_viscosity * period
    });
    ElementConstants {
        cell: *cell,
        shear: ShearConstants::new(fabric.shear.as_ref(), fabric.thickness),
        gradient: [0.5 / lx, 0.5 / ly],
        membrane: [0.5 * ly / (2.0 * w2), 0.5 * lx / (2.0 * w1)],
        half_length: [0.5 * ly, 0.5 * lx],
        hourglass,
        viscosity,
        rate: fabric.rate.map(|rate| RateConstants { c: rate.c, power: rate.p, most: rate.most() }),
        viscous_length: [VISCOUS_LENGTH * 2.0 * w1 / lx, VISCOUS_LENGTH * 2.0 * w2 / ly].map(|length| length.max(1.0)),
        per_steep: if solver.shock_viscosity > 0.0 { 1.0 / (solver.shock_viscosity * STEEP_FRONT) } else { 0.0 },
        mode_share: match solver.stretch_sampling {
            StretchSampling::Centre => 0.0,
            StretchSampling::Mean => 1.0 / 3.0,
        },
        cells: lx / (2.0 * w1) * (ly / (2.0 * w2)),
        area: lx * ly,
    }
}

/// Masses of a row of nodes. `edges` of the mesh, and of the opening of its frame.
fn row_masses<S: Scalar>(mesh: &Mesh, areal_density: f64, [edges, opening]: [&Edges; 2], row: usize) -> RowMasses<S> {
    let across = mesh.lines[1].share(row);
    let row_edge = match row {
        0 => Some(edges.bottom),
        r if r == mesh.rows => Some(edges.top),
        _ => None,
    };
    let stride = Grid::node_stride(mesh.columns);
    let mut out =
        RowMasses { inverse: std::array::from_fn(|_| vec![S::splat(0.0); stride]), mass: vec![S::splat(0.0); stride] };
    for column in 0..=mesh.columns {
        let along = mesh.lines[0].share(column);
        let finest = areal_density * mesh.length[0] * mesh.length[1];
        let fixture = (!mesh.frame.is_plain()).then(|| fixture(mesh, opening, row, column));
        let mass = fixture.map_or(finest * along * across, |(share, _)| finest * share);
        let column_edge = match column {
            0 => Some(edges.left),
            c if c == mesh.columns => Some(edges.right),
            _ => None,
        };
        let clamped = row_edge == Some(Edge::Clamped) || column_edge == Some(Edge::Clamped);
        let clamped = clamped || fixture.is_some_and(|(_, held)| held);
        let held = [clamped || column_edge == Some(Edge::Roller), clamped || row_edge == Some(Edge::Roller), clamped];
        for a in 0..3 {
            out.inverse[a][column] = S::splat(if held[a] { 0.0 } else { 1.0 / mass });
        }
        out.mass[column] = S::splat(mass);
    }
    out
}

/// A node in a frame that is not plain: quarters of the elements around it that are there, over the finest element [-], and whether the frame
/// holds all its displacements, or no element does. `edges`: of the opening.
fn fixture(mesh: &Mesh, edges: &Edges, row: usize, column: usize) -> (f64, bool) {
    let [x, y] = mesh.reference(row, column);
    let [x, y, _] = mesh.to_pack([x, y, 0.0]);
    let present = |&[row, column]: &[usize; 2]| mesh.is_present(row, column);
    let share: f64 =
        mesh.around(row, column).filter(present).map(|[r, c]| 0.25 * mesh.widths(r, c).iter().product::<f64>()).sum();
    let [cut_x, cut_y] = mesh.cut_across(row, column);
    let is_side = [0, mesh.columns].contains(&column) && !cut_x || [0, mesh.rows].contains(&row) && !cut_y;
    let is_edge = is_side || !mesh.around(row, column).all(|element| present(&element));
    let clamped = mesh.frame.opening != Opening::Mesh && is_edge && mesh.frame.clamps(edges, [x, y]);
    (share, share == 0.0 || clamped || mesh.frame.clamps_corner([x, y]))
}

/// Shapes (node stride,), beyond the last element as of the finest; all but the places are empty for an even mesh.
#[derive(Clone, Debug)]
pub struct Columns<S> {
    /// Reference places of the nodes along X of the ply [m]; zero beyond the last. And rounded to the precision of the state.
    pub place: Vec<f64>,
    /// See `place`.
    pub rounded: Vec<S>,
    /// Lengths of elements along X over the finest [-].
    pub width: Vec<S>,
    /// 1 over that [-].
    pub per_width: Vec<S>,
}

impl<S: Scalar> Columns<S> {
    pub(super) fn new(mesh: &Mesh) -> Self {
        let mut place: Vec<f64> = (0..=mesh.columns).map(|column| mesh.reference(0, column)[0]).collect();
        place.resize(Grid::node_stride(mesh.columns), 0.0);
        let rounded = place.iter().map(|x| S::splat(*x)).collect();
        let mut widths = Vec::new();
        if mesh.is_graded() {
            widths.extend((0..mesh.columns).map(|column| mesh.widths(0, column)[0]));
            widths.resize(place.len(), 1.0);
        }
        let width = widths.iter().map(|x| S::splat(*x)).collect();
        let per_width = widths.iter().map(|x| S::splat(1.0 / x)).collect();
        Self { place, rounded, width, per_width }
    }
}

#[cfg(test)]
mod tests {
    use crate::case;
    use crate::model::Model;

    #[test]
    fn shock_viscosity_grows_up_to_elements_of_one_crossover() {
        let length = |set: &str| {
            let case = case::shipped(&["/expect=[]", set]);
            let model = Model::<f64>::new(&case).unwrap_or_else(|error| unreachable!("{error}"));
            model.ply_type(0).element.viscous_length
        };
        for (set, expected) in [
            ("/pack/elements_per_crossover=4", 4.0),
            ("/pack/elements_per_crossover=8", 8.0),
            ("/pack/crossovers_per_element=2", 1.0),
        ] {
            assert!(length(set).iter().all(|got| (got / expected - 1.0).abs() < 1e-12), "{set}: {:?}", length(set));
        }
    }
}
