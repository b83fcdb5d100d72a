//! A frame as what ParaView knows: two parts, fabric and projectile, each with points, cells and named arrays.
//!
//! Lengths in mm, so that the axes of a view read like a drawing; every array ends in its unit.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::super::surface::SurfaceMesh;
use crate::run::frame::{Frame, Pose, Scene};

/// `VTK_QUAD` and `VTK_TRIANGLE`.
const QUAD: u8 = 9;
const TRIANGLE: u8 = 5;
/// `vtkDataSetAttributes::HIDDENCELL`: not drawn, and left out by filters.
const HIDDEN: u8 = 32;
/// mm per m.
const MM: f64 = 1e3;

/// What of a part does not change.
pub(super) struct PartGrid {
    pub(super) name: &'static str,
    pub(super) points: usize,
    /// Corners of all cells.
    pub(super) corners: Vec<i64>,
    /// Where the corners of each cell end.
    pub(super) ends: Vec<i64>,
    /// VTK's numbers of the kinds of cells.
    pub(super) kinds: Vec<u8>,
    /// Arrays that do not change; of cells.
    pub(super) fixed: Vec<Array>,
}

impl PartGrid {
    fn new(name: &'static str, points: usize, cells: impl Iterator<Item = impl AsRef<[usize]>>) -> Self {
        let mut grid =
            Self { name, points, corners: Vec::new(), ends: Vec::new(), kinds: Vec::new(), fixed: Vec::new() };
        for cell in cells {
            grid.corners.extend(cell.as_ref().iter().map(|corner| *corner as i64));
            grid.ends.push(grid.corners.len() as i64);
            grid.kinds.push(if cell.as_ref().len() == 3 { TRIANGLE } else { QUAD });
        }
        grid
    }

    /// Cells.
    pub(super) fn cells(&self) -> usize {
        self.kinds.len()
    }
}

/// One part at one time.
pub(super) struct PartFrame {
    /// Positions [mm].
    pub(super) points: Array,
    pub(super) of_points: Vec<Array>,
    pub(super) of_cells: Vec<Array>,
}

/// Named numbers of points or cells.
pub(super) struct Array {
    pub(super) name: &'static str,
    /// Numbers per point or cell.
    pub(super) components: usize,
    pub(super) numbers: PartArray,
}

pub(super) enum PartArray {
    Float(Vec<f32>),
    Byte(Vec<u8>),
}

impl PartArray {
    /// As they lie in files.
    pub(super) fn bytes(&self) -> &[u8] {
        match self {
            Self::Float(numbers) => bytemuck::cast_slice(numbers),
            Self::Byte(numbers) => numbers,
        }
    }
}

impl Array {
    fn bytes(name: &'static str, numbers: Vec<u8>) -> Self {
        Self { name, components: 1, numbers: PartArray::Byte(numbers) }
    }

    fn numbers(name: &'static str, numbers: &[f32], unit: f64) -> Self {
        let numbers = numbers.iter().map(|number| (f64::from(*number) * unit) as f32).collect();
        Self { name, components: 1, numbers: PartArray::Float(numbers) }
    }

    fn vectors(name: &'static str, vectors: impl Iterator<Item = [f64; 3]>) -> Self {
        let numbers = vectors.flat_map(|vector| vector.map(|number| number as f32)).collect();
        Self { name, components: 3, numbers: PartArray::Float(numbers) }
    }
}

/// Makes the parts of every frame of a scene.
pub(super) struct Parts {
    surface: Option<SurfaceMesh>,
    start: Option<Pose>,
}

impl Parts {
    /// What does not change of the parts of a scene, as it is in its first frame.
    pub(super) fn new(scene: &Scene, first: &Frame) -> (Self, Vec<PartGrid>) {
        let mut grids = vec![fabric(scene)];
        let surface = scene.projectile.as_ref().map(|body| SurfaceMesh::new(body, scene.reference.iter()));
        if let Some(surface) = &surface {
            grids.push(PartGrid::new("projectile", surface.points.len(), surface.faces.iter()));
        }
        (Self { surface, start: first.projectile }, grids)
    }

    /// The parts of a frame, in the order of the grids.
    pub(super) fn of(&self, scene: &Scene, frame: &Frame) -> Vec<PartFrame> {
        let mut parts = vec![fabric_at(scene, frame)];
        if let (Some(surface), Some(start), Some(pose)) = (&self.surface, &self.start, &frame.projectile) {
            parts.push(projectile_at(surface, start, pose));
        }
        parts
    }
}

fn fabric(scene: &Scene) -> PartGrid {
    let cells = scene.plies.iter().flat_map(|ply| {
        (0..ply.rows).flat_map(move |row| (0..ply.columns).map(move |column| ply.corners(row, column)))
    });
    let mut grid = PartGrid::new("fabric", scene.reference.len(), cells);
    let plies = scene.plies.iter().enumerate().flat_map(|(n, ply)| std::iter::repeat_n(n as u8, ply.elements()));
    grid.fixed.push(Array::bytes("ply", plies.collect()));
    grid
}

/// Whether a viewer leaves out a cell of fabric with these yarns: one without any. A damaged frame may hold any byte.
fn ghost(warp: u8, weft: u8) -> u8 {
    if warp | weft == 0 { HIDDEN } else { 0 }
}

fn fabric_at(scene: &Scene, frame: &Frame) -> PartFrame {
    let moved = scene.reference.iter().zip(&frame.displacement);
    let moved = moved.map(|(x, u)| [0, 1, 2].map(|a| (f64::from(x[a]) + f64::from(u[a])) * MM));
    let [warp_alive, weft_alive] = &frame.alive;
    let hidden = warp_alive.iter().zip(weft_alive).map(|(warp, weft)| ghost(*warp, *weft));
    PartFrame {
        points: Array::vectors("Points", moved),
        of_points: vec![
            Array::vectors("displacement_mm", frame.displacement.iter().map(|u| u.map(|u| f64::from(u) * MM))),
            Array::vectors("velocity_m_s", frame.velocity.iter().map(|v| v.map(f64::from))),
        ],
        of_cells: vec![
            Array::numbers("warp_tension_n", &frame.tension[0], 1.0),
            Array::numbers("weft_tension_n", &frame.tension[1], 1.0),
            Array::numbers("warp_strain", &frame.strain[0], 1.0),
            Array::numbers("weft_strain", &frame.strain[1], 1.0),
            Array::numbers("warp_crimp_height_mm", &frame.height[0], MM),
            Array::numbers("weft_crimp_height_mm", &frame.height[1], MM),
            Array::numbers("shear_angle_rad", &frame.shear_angle, 1.0),
            Array::bytes("warp_alive", warp_alive.clone()),
            Array::bytes("weft_alive", weft_alive.clone()),
            Array::bytes("vtkGhostType", hidden.collect()),
        ],
    }
}

/// A rotation, and where the centre of mass is [m].
fn placed(pose: &Pose) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let [w, x, y, z] = pose.rotation;
    (UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z)), Vector3::from(pose.position))
}

fn projectile_at(surface: &SurfaceMesh, start: &Pose, pose: &Pose) -> PartFrame {
    let ((turn, centre), (turn_before, centre_before)) = (placed(pose), placed(start));
    let arms = || surface.points.iter().map(|point| Vector3::from(*point));
    let [velocity, spin] = [pose.velocity, pose.angular_velocity].map(Vector3::from);
    let at = |arm: Vector3<f64>| centre + turn * arm;
    let moved = |arm: Vector3<f64>| at(arm) - (centre_before + turn_before * arm);
    PartFrame {
        points: Array::vectors("Points", arms().map(|arm| (at(arm) * MM).into())),
        of_points: vec![
            Array::vectors("displacement_mm", arms().map(|arm| (moved(arm) * MM).into())),
            Array::vectors("velocity_m_s", arms().map(|arm| (velocity + spin.cross(&(turn * arm))).into())),
        ],
        of_cells: Vec::new(),
    }
}

#[cfg(test)]
#[path = "parts_tests.rs"]
mod tests;
