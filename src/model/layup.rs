//! From a case to its plies: which are alike, where they lie, at what distance they touch.

use super::Ply;
use crate::case::{Case, Layer};

/// The plies of a pack and the layers they are of.
pub(super) struct Layup {
    /// Layers that differ from each other.
    pub(super) layers: Vec<Layer>,
    /// The plies, the struck one first.
    pub(super) plies: Vec<Ply>,
}

/// The layup of a case.
pub(super) fn layup(case: &Case) -> Layup {
    let mut layers: Vec<Layer> = Vec::new();
    let mut ply_types = Vec::new();
    for layer in case.layers().iter() {
        let alike = |other: &Layer| Layer { plies: other.plies, ..layer.clone() } == *other;
        let ply_type = layers.iter().position(alike).unwrap_or(layers.len());
        if ply_type == layers.len() {
            layers.push(layer.clone());
        }
        ply_types.extend(std::iter::repeat_n(ply_type, layer.plies as usize));
    }
    let thickness = |at: usize| layers[ply_types[at]].fabric.thickness;
    let (mut z, mut depth) = (0.0, 0.0);
    let ply = |(at, ply_type): (usize, &usize)| {
        let mean = if at + 1 < ply_types.len() { 0.5 * (thickness(at) + thickness(at + 1)) } else { 0.0 };
        let spacing = case.pack.spacing.unwrap_or(mean);
        let ply = Ply { ply_type: *ply_type, z, depth, thickness: mean, touching: mean.min(spacing) };
        z += spacing;
        depth += ply.touching;
        ply
    };
    let plies = ply_types.iter().enumerate().map(ply).collect();
    Layup { layers, plies }
}
