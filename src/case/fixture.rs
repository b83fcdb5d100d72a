//! Fixture of a pack: the opening of its frame, clamps at the corners, and a block of clay behind it.

use std::f64::consts::{FRAC_PI_2, PI};

use schemars::JsonSchema;
use serde::Deserialize;

use super::error::millimetres;
use super::keys::choices;
use super::pack::LAYUP;
use super::provenance::Provenance;
use super::{Case, CaseError, Edge, Edges, Layer};

/// Keys of a circular opening.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[non_exhaustive]
pub struct Window {
    /// Diameter of the opening, at most width_mm and height_mm [m].
    #[schemars(rename = "diameter_mm", range(min = 1e-3, max = 1e5))]
    pub diameter: f64,
}

/// Frame that holds a ply. Sizes are along the axes of the pack.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frame {
    /// Shape of the opening.
    pub opening: Opening,
    /// Half of the opening along X and Y [m].
    pub half: [f64; 2],
    /// Side of the clamps at its corners [m]; 0: none.
    pub corner: f64,
}

/// Shape of the opening of a frame. What of a mesh lies outside is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Opening {
    /// The mesh itself.
    #[default]
    Mesh,
    /// Rectangle, to which a turned ply is cut.
    Rectangle,
    /// Circle.
    Round,
}

/// Places closer than this are one place, over the size of the opening [-].
const SAME: f64 = 1e-9;

/// Whether a warp at this angle lies along an axis of the pack. Degrees become radians with a rounding error.
fn lies_along_axes(orientation: f64) -> bool {
    let quarters = orientation / FRAC_PI_2;
    (quarters - quarters.round()).abs() < 1e-9
}

/// Whether a warp at this angle lies along the pack's Y axis: then the ply's own width is the pack's height.
pub(super) fn lies_across(orientation: f64) -> bool {
    lies_along_axes(orientation) && (orientation / FRAC_PI_2).round().rem_euclid(2.0) == 1.0
}

impl Opening {
    /// Shape of the opening for a ply at this angle.
    pub(super) fn of(round: bool, orientation: f64) -> Self {
        match round {
            true => Self::Round,
            false if lies_along_axes(orientation) => Self::Mesh,
            false => Self::Rectangle,
        }
    }

    /// Sizes of a mesh around the opening, along the yarns of a ply at this angle: whole crossovers [m].
    /// `crossover`: their lengths [m].
    pub(super) fn bounds(self, opening: [f64; 2], orientation: f64, crossover: [f64; 2]) -> [f64; 2] {
        let (s, c) = orientation.sin_cos();
        let turned = |c: f64, s: f64| opening[0] * c.abs() + opening[1] * s.abs();
        let around = if self == Self::Round { opening } else { [turned(c, s), turned(s, c)] };
        [0, 1].map(|axis| {
            // Even numbers have mirror planes. A turned ply that has an odd one where others have puts no node on the middle of their cells.
            let straight = (opening[axis] / crossover[axis]).round().max(1.0);
            let odd = if self == Self::Round { 0.0 } else { straight.rem_euclid(2.0) };
            crossover[axis] * (2.0 * (0.5 * (around[axis] / crossover[axis] - odd) - 1e-6).ceil() + odd)
        })
    }
}

impl Frame {
    /// Whether there is nothing but the sides of the mesh.
    pub fn is_plain(&self) -> bool {
        self.opening == Opening::Mesh && self.corner == 0.0
    }

    /// Distances of a place from the sides of the opening, left, right, bottom, top, less than nothing beyond them [m]; a circle has one
    /// side.
    pub fn inwards(&self, [x, y]: [f64; 2]) -> [f64; 4] {
        let [a, b] = self.half;
        if self.opening == Opening::Round { [a - x.hypot(y); 4] } else { [a + x, a - x, b + y, b - y] }
    }

    /// Whether a place lies in the opening or on its edge.
    pub fn contains(&self, place: [f64; 2]) -> bool {
        self.inwards(place).into_iter().all(|from| from >= -SAME * self.half[0])
    }

    /// Whether a place at the edge of the opening is clamped: a side nearest to it is.
    pub fn clamps(&self, edges: &Edges, place: [f64; 2]) -> bool {
        let from = self.inwards(place);
        let nearest = from.into_iter().fold(f64::INFINITY, f64::min) + SAME * self.half[0];
        let sides = [edges.left, edges.right, edges.bottom, edges.top];
        from.into_iter().zip(sides).any(|(from, edge)| from <= nearest && edge == Edge::Clamped)
    }

    /// Whether a place lies under a clamp at a corner.
    pub fn clamps_corner(&self, place: [f64; 2]) -> bool {
        let from = self.inwards(place);
        let reach = self.corner + SAME * self.half[0];
        self.corner > 0.0 && from[0].min(from[1]) <= reach && from[2].min(from[3]) <= reach
    }
}

impl Case {
    /// Refuses a window, clamps and gaps that do not go together with the rest of the pack.
    pub(super) fn check_fixture(&self) -> Result<(), CaseError> {
        let (pack, layers) = (&self.pack, self.layers());
        let refuse = |key: &str, expected: String, found: &str| Err(CaseError::at(key, expected, found));
        let are_all = |edge| layers.iter().all(|layer| layer.edges.are_all(edge));
        let (at, corners) = ("/pack/window", "/pack/corner_clamps_mm");
        let smaller = pack.width.min(pack.height);
        if let Some(Window { diameter }) = pack.window {
            if diameter > smaller * (1.0 + SAME) {
                let expected = format!("at most {}, the smaller of width_mm and height_mm", millimetres(smaller));
                return refuse(&format!("{at}/diameter_mm"), expected, &millimetres(diameter));
            }
            if !are_all(Edge::Clamped) {
                let expected = "clamped edges of every ply, for a window clamps all around".to_owned();
                return refuse(at, expected, "edges that are not clamped");
            }
        }
        if pack.corner_clamps > 0.0 {
            if pack.window.is_some() {
                return refuse(corners, "no clamps at corners: a window clamps all around".to_owned(), "both");
            }
            if are_all(Edge::Clamped) {
                let error = CaseError::at(corners, "sides that are not clamped all along", "clamped edges alone");
                return Err(error.help("set /pack/edges to \"free\""));
            }
        }
        let is_cut = |layer: &Layer| layer.mesh.frame.opening != Opening::Mesh;
        if pack.initial_deflection.is_some() && layers.iter().any(is_cut) {
            let expected = "a flat start of plies in a window or turned by no multiple of 90°".to_owned();
            return refuse("/pack/initial_deflection", expected, "a deflection over their width and height");
        }
        if pack.layup.first().is_some_and(|layer| layer.standoff > 0.0) {
            let expected = "a gap behind a group of plies".to_owned();
            return refuse(&format!("{LAYUP}/0/standoff_mm"), expected, "the first group");
        }
        Ok(())
    }
}

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
