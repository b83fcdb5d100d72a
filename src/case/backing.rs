//! Backing: a block of clay behind the pack.

use schemars::JsonSchema;
use serde::Deserialize;

use super::keys::choices;
use super::{Case, CaseError, Layer};

choices! {
    /// Material behind the pack.
    pub enum BackingMaterial {
        /// Modelling clay, as body armour is tested on.
        Clay = "clay",
    }
}

/// Block behind the last ply, deeper and wider than any crater. It resists fabric that goes deeper than any did before it there, and does not
/// spring back. It has no mass and no rate, and resists fabric alone: a projectile that is through the pack does not meet it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
pub struct Backing {
    /// Material of the block.
    ///
    /// Default: the only one there is.
    #[schemars(extend("default" = "clay"))]
    pub material: BackingMaterial,
    /// Gap between the last ply and the block [m].
    ///
    /// Default: the pack lies against it.
    #[schemars(rename = "gap_mm", range(min = 0, max = 1000), extend("default" = 0))]
    pub gap: f64,
    /// Pressure on what goes deeper into it, the same at any depth and speed [Pa].
    ///
    /// Default: assumed: energy over volume of the crater in the drop test of NIJ 0101.06, a ball of 63.5 mm and 1043 g, 2 m, 19 mm.
    #[schemars(rename = "pressure_mpa", range(min = 1e-3, max = 100), extend("default" = 0.71))]
    pub pressure: f64,
}

/// Part of the speed at the start that clay may take of a node in a step: below it clay stops the node, and resists what follows only in part.
const TAKEN: f64 = 0.05;

impl Case {
    /// Longest step in which clay takes a small part of the speed at the start [s].
    pub(crate) fn clay_step(&self) -> f64 {
        let layers = self.layers();
        let (Some(clay), Some(last)) = (self.backing, layers.last()) else { return f64::INFINITY };
        let speed = |layer: &Layer| layer.initial_velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        let struck = self.projectile.as_ref().map_or(0.0, |projectile| projectile.velocity);
        let fastest = layers.iter().map(speed).fold(struck, f64::max);
        let step = TAKEN * fastest * last.fabric.areal_density / clay.pressure;
        if step > 0.0 { step } else { f64::INFINITY }
    }

    /// Refuses a backing that does not go together with the pack.
    pub(super) fn check_backing(&self) -> Result<(), CaseError> {
        match self.backing.is_some() && self.pack.initial_deflection.is_some() {
            true => Err(CaseError::at("/backing", "nothing behind a pack with an initial deflection", "clay")),
            false => Ok(()),
        }
    }
}
