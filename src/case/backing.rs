//! Backing: a block of clay behind the pack.

use std::f64::consts::PI;

use schemars::JsonSchema;
use serde::Deserialize;

use super::keys::choices;
use super::provenance::Provenance;
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
    /// Pressure at its surface on what goes deeper, the same at any speed [Pa].
    ///
    /// Otherwise: assumed: that with which the drop test of NIJ 0101.06, a ball of 63.5 mm and 1043 g, 2 m, leaves a crater of 19 mm.
    #[serde(default)]
    #[schemars(rename = "pressure_mpa", range(min = 1e-3, max = 100))]
    pub pressure: f64,
    /// Depth at which the pressure is twice that, in proportion to the depth; null or absent: it is the same at any [m].
    ///
    /// Left out: assumed: the same pressure at any depth.
    #[schemars(rename = "doubling_depth_mm", range(min = 1, max = 1e5))]
    pub doubling_depth: Option<f64>,
}

/// Ball of the drop test: mass [kg], radius [m]; height of its fall and depth of its crater [m].
const DROP_TEST: [f64; 4] = [1.043, 0.03175, 2.0, 0.019];
/// Standard acceleration of free fall [m/s²].
const GRAVITY: f64 = 9.80665;

impl Backing {
    /// Gain of the pressure with the depth, over that at the surface [1/m].
    pub fn gain(&self) -> f64 {
        self.doubling_depth.map_or(0.0, |depth| 1.0 / depth)
    }

    /// Pressure at the surface with which the drop test leaves its crater: energy of the ball over ∫(1 + gain·z/2) z dA over the cap with
    /// the depths z, to the two digits that its depth has [Pa].
    fn of_drop_test(&self) -> f64 {
        let [mass, radius, fall, depth] = DROP_TEST;
        let volume = PI * depth.powi(2) * (radius - depth / 3.0);
        let moment = PI * (depth.powi(4) / 4.0 + (radius - depth) * depth.powi(3) / 3.0);
        let pressure = mass * GRAVITY * fall / (volume + self.gain() * moment);
        (pressure * 1e-4).round() * 1e4
    }
}

/// Part of the speed at the start that clay may take of a node in a step: below it clay stops the node, and resists what follows only in part.
const TAKEN: f64 = 0.05;

/// Depth down to which the step is short enough for the pressure [m].
const DEEP: f64 = 0.05;

impl Case {
    /// Longest step in which clay takes a small part of the speed at the start [s].
    pub(crate) fn clay_step(&self) -> f64 {
        let layers = self.layers();
        let (Some(clay), Some(last)) = (self.backing, layers.last()) else { return f64::INFINITY };
        let speed = |layer: &Layer| layer.initial_velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        let struck = self.projectile.as_ref().map_or(0.0, |projectile| projectile.velocity);
        let fastest = layers.iter().map(speed).fold(struck, f64::max);
        let deepest = 1.0 + clay.gain() * DEEP;
        let step = TAKEN * fastest * last.fabric.areal_density / (clay.pressure * deepest);
        if step > 0.0 { step } else { f64::INFINITY }
    }

    /// Completes a backing, and refuses one that does not go together with the pack.
    pub(super) fn complete_backing(&mut self, record: &Provenance) -> Result<(), CaseError> {
        if let Some(clay) = &mut self.backing {
            let pressure = clay.of_drop_test();
            record.fill("/backing/pressure_mpa", &mut clay.pressure, pressure, "", true);
        }
        match self.backing.is_some() && self.pack.initial_deflection.is_some() {
            true => Err(CaseError::at("/backing", "nothing behind a pack with an initial deflection", "clay")),
            false => Ok(()),
        }
    }
}
