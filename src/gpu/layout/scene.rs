//! Constants of the shots of a batch and of one of their ply types.

use super::Block;
use super::projectile::{body_held, nose, projectile};
use crate::gpu::buffers::Sizes;
use crate::kernels::element_force::ElementConstants;
use crate::model::{Model, PlyType};

/// Bytes between the constants of two ply types.
pub(crate) const SCENE_STRIDE: u64 = 512;
/// Bytes between the law tables of two ply types: the table, to the alignment every device grants.
pub(crate) const LAW_STRIDE: u64 = 6656;

/// The constants of the shots of a batch and of one of their ply types, with the room there is in the buffers.
pub fn scene(model: &Model<f32>, ply_type: usize, sizes: &Sizes) -> Block {
    let mut block = Block::default();
    let grid = &model.grid;
    block.count("columns", grid.columns);
    block.count("rows", grid.rows);
    block.count("elements", (sizes.shots * sizes.elements) as usize);
    block.count("nodes", (sizes.shots * sizes.nodes) as usize);
    block.count("shot_elements", sizes.elements as usize);
    block.count("shot_nodes", sizes.nodes as usize);
    block.count("plies", grid.plies);
    block.count("ply_type", ply_type);
    block.double("ply_friction", model.ply_friction);
    let ply_type = &model.ply_types[ply_type];
    element(&mut block, ply_type);
    block.double("dt", model.dt);
    projectile(&mut block, model);
    block.count("points", sizes.points as usize);
    block.count("groups", sizes.groups as usize);
    block.count("body_held", model.projectile.as_ref().map_or(0, body_held));
    block.count("mirror", model.mirror.0.into_iter().enumerate().map(|(axis, plane)| usize::from(plane) << axis).sum());
    block.count("constraints", sizes.constraints as usize);
    // The array begins at a multiple of sixteen bytes.
    while !block.0.len().is_multiple_of(4) {
        let pads = ["pad0", "pad1", "pad2"];
        let at = block.names().filter(|name| pads.contains(name)).count();
        block.count(pads[at], 0);
    }
    let body = model.projectile.as_ref();
    for i in 0..crate::kernels::projectile_shape::CORNERS {
        let [corner, normal] = body.map_or([[0.0; 2]; 2], |b| [b.body.profile.corner[i], b.body.profile.normal[i]]);
        for value in [corner[0], corner[1] - body.map_or(0.0, nose), normal[0], normal[1]] {
            block.double("profile", value);
        }
    }
    block
}

/// Adds the constants of the elements.
fn element(block: &mut Block, ply_type: &PlyType<f32>) {
    let c: ElementConstants<f32> = crate::with_law!(ply_type.law, L => ply_type.constants::<f32, L>());
    let names = [
        ["warp_stiffness", "warp_half_span", "warp_crimp", "warp_failure_strain", "warp_slack"],
        ["weft_stiffness", "weft_half_span", "weft_crimp", "weft_failure_strain", "weft_slack"],
    ];
    for (names, y) in names.into_iter().zip(&c.cell.yarn) {
        let values = [y.stiffness, y.half_span, y.crimp, y.failure_strain, y.slack_slope];
        names.into_iter().zip(values).for_each(|(name, value)| block.number(name, value));
    }
    block.number("height_sum", c.cell.height_sum);
    block.number("compression_a", c.cell.compression[0]);
    block.number("compression_b", c.cell.compression[1]);
    block.number("compression_offset", c.cell.compression[2]);
    block.number("compression_uncompressed", c.cell.uncompressed_limit);
    block.number("compression_per_b", c.cell.per_b);
    block.number("min_stiffness", c.cell.min_stiffness);
    block.number("roundoff_tolerance", c.cell.roundoff_tolerance);
    block.number("tolerance", c.cell.tolerance);
    block.number("shear_g1", c.shear.g1);
    block.number("shear_rise", c.shear.rise);
    block.number("shear_gamma1", c.shear.gamma1);
    block.number("shear_ramp", c.shear.ramp);
    block.number("shear_slope", c.shear.slope);
    block.number("gradient_x", c.gradient[0]);
    block.number("gradient_y", c.gradient[1]);
    block.number("membrane_warp", c.membrane[0]);
    block.number("membrane_weft", c.membrane[1]);
    block.number("half_length_warp", c.half_length[0]);
    block.number("half_length_weft", c.half_length[1]);
    block.number("hourglass_warp", c.hourglass[0]);
    block.number("hourglass_weft", c.hourglass[1]);
    block.number("viscosity_warp", c.viscosity[0]);
    block.number("viscosity_weft", c.viscosity[1]);
    block.number("viscous_length_x", c.viscous_length[0]);
    block.number("viscous_length_y", c.viscous_length[1]);
    block.number("per_steep", c.per_steep);
    block.number("mode_share", c.mode_share);
    let reach = &ply_type.failure_reach;
    block.double("failure_reach_warp", reach.along[0]);
    block.double("failure_reach_weft", reach.along[1]);
    block.number("cells", c.cells);
    block.number("area", c.area);
}

/// What the unit-cell law of a ply type makes of energy by itself, as the shaders see it: first place and places per stretch of warp and
/// weft, then the table.
pub fn law_energy(ply_type: &PlyType<f32>) -> Vec<u32> {
    let mut words = vec![0.0_f32; LAW_STRIDE as usize / 4];
    if let Some(table) = &ply_type.law_energy {
        let head = table.low.iter().chain(&table.per_stretch);
        for (word, value) in words.iter_mut().zip(head.chain(&table.values)) {
            *word = *value as f32;
        }
    }
    words.into_iter().map(f32::to_bits).collect()
}
