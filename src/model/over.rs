//! Which element of a neighbouring ply a node at rest lies over.

use super::{MirrorPlanes, Model};

/// In front, behind: the two neighbours of a ply.
pub const SIDES: usize = 2;

/// Set beside the element where the node is inside it, closer than the two plies touch.
pub const PENETRATING: u32 = 1 << 31;

/// The element a node is over.
#[inline]
pub fn element(over: u32) -> usize {
    (over & !PENETRATING) as usize
}

/// A little nearer to the centre than it is [-].
const INWARD: f64 = 1.0 - 1e-9;

/// Element (row·columns + column) of the ply in front, then of the ply behind, nearest to each node at rest; shape
/// (plies, 2, (rows + 1)·(columns + 1)) of the storage grid. Empty for a single ply.
pub(crate) fn over_at_rest<S>(model: &Model<S>) -> Vec<u32> {
    let plies = model.plies.len();
    if plies < 2 {
        return Vec::new();
    }
    let per_side = model.nodes_per_ply();
    // Of cells that are as near, the one towards the centre, so that mirror images are over mirror images.
    let inward = if model.mirror == MirrorPlanes::NONE { 1.0 } else { INWARD };
    let mut over = vec![0; plies * SIDES * per_side];
    for (at, part) in over.chunks_mut(per_side).enumerate() {
        let (ply, side) = (at / SIDES, at % SIDES);
        let Some(other) = neighbour(ply, side, plies) else { continue };
        let (mesh, theirs) =
            (&model.ply_types[model.plies[ply].ply_type].mesh, &model.ply_types[model.plies[other].ply_type].mesh);
        for row in 0..=mesh.rows {
            for column in 0..=mesh.columns {
                let [x, y] = mesh.reference(row, column);
                let [x, y, _] = theirs.to_ply(mesh.to_pack([x, y, 0.0]));
                let [row_over, column_over] = theirs.element_at([x, y].map(|at| at * inward));
                part[row * (model.grid.columns + 1) + column] = (row_over * theirs.columns + column_over) as u32;
            }
        }
    }
    over
}

/// The ply in front (0) or behind (1).
pub fn neighbour(ply: usize, side: usize, plies: usize) -> Option<usize> {
    if side == 0 { ply.checked_sub(1) } else { Some(ply + 1).filter(|next| *next < plies) }
}
