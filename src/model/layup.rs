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

/// The layup of a case; a pack without one is all of the case's fabric.
pub(super) fn layup(case: &Case) -> Layup {
    let pack = &case.pack;
    let whole = Layer {
        plies: pack.plies,
        fabric: case.fabric.clone(),
        orientation: 0.0,
        edges: pack.edges,
        initial_velocity: pack.initial_velocity,
        columns: pack.columns,
        rows: pack.rows,
        element_length_x: pack.element_length_x,
        element_length_y: pack.element_length_y,
    };
    let given = if pack.layup.is_empty() { std::slice::from_ref(&whole) } else { &pack.layup };
    let mut layers: Vec<Layer> = Vec::new();
    let mut sheets = Vec::new();
    for layer in given {
        let alike = |other: &Layer| Layer { plies: other.plies, ..layer.clone() } == *other;
        let sheet = layers.iter().position(alike).unwrap_or(layers.len());
        if sheet == layers.len() {
            layers.push(layer.clone());
        }
        sheets.extend(std::iter::repeat_n(sheet, layer.plies as usize));
    }
    let mut z = 0.0;
    let ply = |(at, sheet): (usize, &usize)| {
        let thickness = |sheet: usize| layers[sheet].fabric.thickness;
        let mean = |next: &usize| 0.5 * (thickness(*sheet) + thickness(*next));
        let mean = sheets.get(at + 1).map_or(0.0, mean);
        let spacing = pack.spacing.unwrap_or(mean);
        let ply = Ply { sheet: *sheet, z, touching: mean.min(spacing) };
        z += spacing;
        ply
    };
    let plies = sheets.iter().enumerate().map(ply).collect();
    Layup { layers, plies }
}
