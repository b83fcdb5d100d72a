//! The plies of a pack.

use nalgebra::Vector3;

use super::Block;
use crate::case::{Edge, Edges};
use crate::kernels::mirror_planes::Cut;
use crate::model::cover::unbroken_cells;
use crate::model::{Mesh, Model, PlyType};

/// Most plies there are.
pub(crate) const PLIES: usize = 64;
/// Words of a ply.
pub const PLY_WORDS: usize = 24;

/// Where the device counts places from, in the axes of the pack [m]: the middle of the finest elements. Single precision rounds a place by its
/// size: 30 mm from there by 2e-9 m, which contact would close within a step by 0.05 m/s. Shots on the same meshes count from the same place,
/// so that they can be computed together.
pub fn device_origin(model: &Model<f32>) -> Vector3<f64> {
    let mesh = &model.ply_type(0).mesh;
    if !mesh.is_graded() {
        return Vector3::zeros();
    }
    let [x, y] = mesh.middle_of_finest();
    mesh.to_pack([x, y, 0.0]).into()
}

/// Mass of an inner node of the finest elements [kg].
pub(super) fn node_mass(ply_type: &PlyType<f32>) -> f64 {
    ply_type.areal_density * ply_type.mesh.length[0] * ply_type.mesh.length[1]
}

/// The plies as the shaders see them.
pub fn plies(model: &Model<f32>) -> Vec<Block> {
    let mut out = Vec::with_capacity(PLIES);
    let from = device_origin(model);
    for (at, ply) in model.plies.iter().enumerate() {
        let ply_type = &model.ply_types[ply.ply_type];
        let mesh = &ply_type.mesh;
        let mass = node_mass(ply_type);
        let behind = model.plies.get(at + 1);
        // Plies that touch at rest do so exactly, whatever their places round to.
        let apart = behind.map_or(0.0, |next| next.z as f32 - ply.z as f32);
        let touching = (ply.touching as f32).min(apart);
        let present = ply_type.present.map(usize::from);
        let mut block = Block::default();
        block.count("rows", mesh.rows);
        block.count("columns", mesh.columns);
        block.count("ply_type", ply.ply_type);
        block.count("present", present[0] + 2 * present[1]);
        let [x, y, _] = mesh.to_ply(from.into());
        block.double("origin_x", mesh.origin[0] - x);
        block.double("origin_y", mesh.origin[1] - y);
        block.double("length_x", mesh.length[0]);
        block.double("length_y", mesh.length[1]);
        block.double("cosine", mesh.rotation[0]);
        block.double("sine", mesh.rotation[1]);
        block.double("z", ply.z);
        block.double("depth", ply.depth);
        block.number("touching", touching);
        block.double("thickness", ply.thickness);
        block.double("mass", mass);
        block.double("inverse_inner", 1.0 / mass);
        block.double("inverse_edge", 2.0 / mass);
        block.double("inverse_corner", 4.0 / mass);
        block.count("held", constrained(&ply_type.edges) | cut_sides(mesh) << 12);
        block.count("span", model.projectile.as_ref().map_or(0, |body| unbroken_cells(&ply_type.mesh, body)));
        block.double("longest", mesh.longest());
        for pad in ["pad0", "pad1", "pad2"] {
            block.count(pad, 0);
        }
        out.push(block);
    }
    out
}

/// Held directions of the sides, three bits each: left, right, bottom, top.
fn constrained(edges: &Edges) -> usize {
    let side = |edge: Edge, roller: usize| match edge {
        Edge::Clamped => 7,
        Edge::Roller => roller,
        Edge::Free => 0,
    };
    side(edges.left, 1) | side(edges.right, 1) << 3 | side(edges.bottom, 2) << 6 | side(edges.top, 2) << 9
}

/// Sides that mirror planes cut: left, right, bottom, top, a bit each.
fn cut_sides(mesh: &Mesh) -> usize {
    let [x, y] = mesh.cut.map(|cut| match cut {
        Cut::Nowhere => 0,
        Cut::First => 1,
        Cut::Last => 2,
    });
    x | y << 2
}

#[cfg(test)]
#[path = "pack_tests.rs"]
mod tests;
