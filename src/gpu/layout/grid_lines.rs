//! The grid lines of plies.

use nalgebra::Vector3;

use super::{Block, device_origin};
use crate::model::{Model, PlyType};

/// Numbers of a grid line.
pub const LINE_WORDS: usize = 8;
/// Texels of a grid line.
pub const LINE_TEXELS: usize = 2;
/// Grid lines in a row of their texture.
pub const LINES_ACROSS: usize = 1024;

/// A grid line across the X (0) or Y (1) of a ply of a ply type, with one more behind the last. `from`: where the device counts places from,
/// in the axes of the pack [m].
pub fn line(ply_type: &PlyType<f32>, from: &Vector3<f64>, axis: usize, line: usize) -> Block {
    let mesh = &ply_type.mesh;
    let last = [mesh.columns, mesh.rows][axis];
    let element = line.min(last - 1);
    let from = mesh.to_ply((*from).into())[axis];
    let place = |line: usize| mesh.reference(line * axis, line * (1 - axis))[axis] - from;
    let width = mesh.widths(element * axis, element * (1 - axis))[axis];
    let yarn = ply_type.failure_reach.side_by_side(mesh, axis, element);
    let mut block = Block::default();
    block.double("place", if line > last { place(last) + width * mesh.length[axis] } else { place(line) });
    block.double("width", width);
    block.double("per_width", 1.0 / width);
    block.double("share", if line > last { 0.0 } else { mesh.share(axis, line) });
    block.double("yarn_first", yarn.start as f64);
    block.double("yarn_end", yarn.end as f64);
    let breaking = &ply_type.windows[axis].breaking[element];
    block.double("breaking_first", breaking.start as f64);
    block.double("breaking_end", breaking.end as f64);
    block
}

/// The grid lines as the shaders see them, shape (ply types, axes, room for the longest axis), in whole rows of the texture.
pub fn lines(model: &Model<f32>) -> Vec<u32> {
    let room = model.grid.columns.max(model.grid.rows) + 2;
    let mut out = Vec::new();
    let from = device_origin(model);
    for ply_type in &model.ply_types {
        for (axis, elements) in [ply_type.mesh.columns, ply_type.mesh.rows].into_iter().enumerate() {
            let end = out.len() + room * LINE_WORDS;
            (0..elements + 2).for_each(|at| out.extend(line(ply_type, &from, axis, at).words()));
            out.resize(end, 0);
        }
    }
    out.resize(out.len().next_multiple_of(LINES_ACROSS * LINE_WORDS), 0);
    out
}
