//! What an element shows in a frame: the unit cell solved at the positions of the frame, as the next step would.

use crate::num::scalar::{Scalar, each};
use crate::physics::crossover;
use crate::physics::element_geometry::ElementConstants;
use crate::physics::element_geometry::ElementGeometry;
use crate::physics::kinematics::{differences, kinematics};
use crate::physics::shear;
use crate::physics::yarn_law::LawKernel;

/// One element, rounded to what files hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ElementReading {
    /// [N]
    pub(super) tension: [f32; 2],
    /// [-]
    pub(super) strain: [f32; 2],
    /// [m]
    pub(super) height: [f32; 2],
    /// [rad]
    pub(super) shear_angle: f32,
    pub(super) alive: [bool; 2],
}

/// What an element had at the last step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Before<S> {
    /// Heights of the yarns [m].
    pub(super) height: [S; 2],
    /// Yarns that carry load.
    pub(super) alive: [bool; 2],
}

/// Reads an element, so long and high over the finest, from the displacements of its corners [m], components of corners counter-clockwise.
pub(super) fn read<S: Scalar, L: LawKernel>(
    constants: &ElementConstants<S>,
    [width, height]: [f64; 2],
    corners: &[[S; 4]; 3],
    before: Before<S>,
) -> ElementReading {
    let [was_warp, was_weft] = before.alive;
    if !(was_warp || was_weft) {
        return ElementReading::default();
    }
    let zero = S::splat(0.0);
    let [ux, uy, uz] = each!(a in 3 => differences(&corners[a]));
    let size = ElementGeometry::of_row(constants, height).of_columns(S::splat(width), S::splat(1.0 / width));
    let k = kinematics(&size, [&ux, &uy, &uz]);
    let cell = crossover::solve::<S, L>(&constants.cell, k.extension, before.height, was_warp && was_weft);
    let yarn = &constants.cell.yarn;
    let alive = before.alive;
    let both = alive[0] && alive[1];
    let free = [0, 1].map(|i| yarn[i].straight(k.extension[i]).max(zero));
    let of_living = |i: usize, crossing: S, alone: S| match (alive[i], both) {
        (true, true) => crossing.to_f64() as f32,
        (true, false) => alone.to_f64() as f32,
        _ => 0.0,
    };
    ElementReading {
        tension: [0, 1].map(|i| of_living(i, cell.tension[i], yarn[i].stiffness * free[i])),
        strain: [0, 1].map(|i| of_living(i, cell.strain[i], free[i])),
        height: [0, 1].map(|i| of_living(i, cell.height[i], zero)),
        shear_angle: if both { shear::arc_sine(k.sine).to_f64() as f32 } else { 0.0 },
        alive,
    }
}
