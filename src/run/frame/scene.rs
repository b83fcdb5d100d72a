//! What stays the same from frame to frame.

use crate::case::Case;
use crate::model::{Model, ModelError};
use crate::num::scalar::Scalar;
use crate::physics::projectile_body::Body;

/// What stays the same from frame to frame: the whole pack at rest, and the shape of the projectile.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Scene {
    /// The plies, the struck one first.
    pub plies: Vec<PlyMesh>,
    /// Reference positions of the nodes in the axes of the pack [m].
    pub reference: Vec<[f32; 3]>,
    /// Elements over all plies.
    pub elements: usize,
    /// Surface of the projectile in its own axes, where there is one.
    pub projectile: Option<Body>,
    /// Time step [s].
    pub time_step: f64,
}

/// One ply among the nodes and elements of a scene; element (row, column) lies between the nodes (row, column) and
/// (row + 1, column + 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct PlyMesh {
    /// Elements along the warp.
    pub columns: usize,
    /// Elements along the weft.
    pub rows: usize,
    /// Its first node.
    pub first_node: usize,
    /// Its first element.
    pub first_element: usize,
}

impl PlyMesh {
    /// Nodes of the ply.
    pub fn nodes(&self) -> usize {
        (self.columns + 1) * (self.rows + 1)
    }

    /// Elements of the ply.
    pub fn elements(&self) -> usize {
        self.columns * self.rows
    }

    /// Corners of an element among the nodes of the scene, counter-clockwise.
    pub fn corners(&self, row: usize, column: usize) -> [usize; 4] {
        let below = self.first_node + row * (self.columns + 1) + column;
        let above = below + self.columns + 1;
        [below, below + 1, above + 1, above]
    }
}

impl Scene {
    /// That of a case, whatever part of it is computed.
    ///
    /// # Errors
    /// When the case cannot become a model.
    pub fn of(case: &Case) -> Result<Self, ModelError> {
        Model::<f32>::part(case).map(|model| Self::new(&model))
    }

    /// The whole of what a model computes.
    pub(super) fn new<S: Scalar>(model: &Model<S>) -> Self {
        let mut scene = Self {
            plies: Vec::with_capacity(model.plies.len()),
            reference: Vec::new(),
            elements: 0,
            projectile: model.projectile.as_ref().map(|projectile| projectile.body),
            time_step: model.dt,
        };
        for ply in &model.plies {
            let mesh = model.ply_types[ply.ply_type].mesh.whole();
            let (rows, columns) = (mesh.rows, mesh.columns);
            let own = PlyMesh { columns, rows, first_node: scene.reference.len(), first_element: scene.elements };
            for (row, column) in (0..=rows).flat_map(|row| (0..=columns).map(move |column| (row, column))) {
                let [x, y] = mesh.reference(row, column);
                scene.reference.push(mesh.to_pack([x, y, ply.z]).map(|at| at as f32));
            }
            scene.elements += own.elements();
            scene.plies.push(own);
        }
        scene
    }
}
