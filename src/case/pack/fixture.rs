//! Fixture of a pack: the opening of its frame, and clamps at the corners.

use std::f64::consts::FRAC_PI_2;

use schemars::JsonSchema;
use serde::Deserialize;

use super::{Edge, Edges, LAYUP};
use crate::case::error::short_number_text;
use crate::case::{Case, CaseError, Layer};

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
        let millimetres = |size: f64| short_number_text(size * 1e3);
        let smaller = pack.width.min(pack.height);
        if let Some(Window { diameter }) = pack.window {
            if diameter > smaller * (1.0 + SAME) {
                let expected = format!("at most {} mm, the smaller of width_mm and height_mm", millimetres(smaller));
                return refuse(&format!("{at}/diameter_mm"), expected, &format!("{} mm", millimetres(diameter)));
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
        match pack.layup.first().is_some_and(|layer| layer.standoff > 0.0) {
            true => {
                let expected = "a gap behind a group of plies".to_owned();
                refuse(&format!("{LAYUP}/0/standoff_mm"), expected, "the first group")
            }
            false => Ok(()),
        }
    }
}
