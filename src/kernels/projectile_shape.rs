//! Projectile surfaces: gap and outward normal of a point near an analytic body.
//!
//! Every body is a convex profile (ρ, s) around its axis, shrunk by the edge radius and grown again, so that one
//! kernel covers cylinder, sphere, cone and ogive with rounded edges. A bar lying in the fabric's plane is the same with
//! ρ measured across it; a chisel nose is cut from the profile of a cylinder, see
//! [`projectile_chisel`]. s runs along the body axis towards the nose, from the centre of mass.

pub use super::projectile_body::{Body, EdgeRadiusTooLarge};
use super::projectile_chisel::{self, Chisel};
use crate::num::scalar::Scalar;

/// Most corners a profile has.
pub const CORNERS: usize = 5;
/// Nearer to a corner than this the direction to it is noise, in single precision [m].
pub const RESOLVED: f64 = 1e-9;
/// Farther than any point, also squared: where there is nothing yet [m].
pub(crate) const FAR: f64 = 1e30;
/// Keeps quotients of nothing finite, lengths and their squares [m].
pub(crate) const TINY: f64 = 1e-30;

/// A convex profile; corners run from the nose on the axis to the tail on the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline<R> {
    /// (ρ, s) of each corner [m]; the first `count` are used.
    pub corner: [[R; 2]; CORNERS],
    /// Unit outward normal (ρ, s) of the side from corner i to i + 1, where it begins.
    pub normal: [[R; 2]; CORNERS],
    /// Corners used, at least 1.
    pub count: usize,
    /// Rounding [m].
    pub radius: R,
    /// Radius of the first side where that is an arc, 0 where it is straight [m].
    pub arc: R,
    /// True for a bar: ρ is measured along the body's x axis alone.
    pub bar: bool,
    /// The flats that make a chisel of the flat nose.
    pub chisel: Option<Chisel<R>>,
}

/// Gap to a surface and its outward normal in the body's frame.
#[derive(Clone, Copy, Debug)]
pub struct SignedDistance<R> {
    /// Distance to the surface, negative inside [m].
    pub distance: R,
    /// Outward unit normal at the nearest surface point, body frame.
    pub normal: [R; 3],
}

/// One side of a profile as a point sees it.
struct Side<R: Scalar> {
    /// From the nearest point of the side to the point [m].
    away: [R; 2],
    /// Outward normal there.
    normal: [R; 2],
    /// Whether that is no end of the side.
    beside: R::Mask,
    /// Height over the side and what it goes on to beyond its ends [m].
    height: R,
}

/// A straight side: `from` and `edge` run from its beginning to the point and to its end.
#[inline(always)]
fn straight_side<R: Scalar>(normal: [R; 2], edge: [R; 2], from: [R; 2]) -> Side<R> {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let length = (edge[0].squared() + edge[1].squared()).max(R::splat(TINY));
    let along = ((from[0] * edge[0] + from[1] * edge[1]) / length).max(zero).min(one);
    let away = [from[0] - along * edge[0], from[1] - along * edge[1]];
    let height = from[0] * normal[0] + from[1] * normal[1];
    Side { away, normal, beside: zero.lt(along) & along.lt(one), height }
}

/// A side that is an arc of radius `arc` and begins with normal `normal`.
#[inline(always)]
fn arc_side<R: Scalar>(normal: [R; 2], arc: R, edge: [R; 2], from: [R; 2]) -> Side<R> {
    let (zero, one, two) = (R::splat(0.0), R::splat(1.0), R::splat(2.0));
    // From the arc's centre to the point and to the arc's end.
    let centre = [from[0] + arc * normal[0], from[1] + arc * normal[1]];
    let end = [edge[0] + arc * normal[0], edge[1] + arc * normal[1]];
    let size = (centre[0].squared() + centre[1].squared()).sqrt().max(R::splat(TINY));
    let out = [centre[0] / size, centre[1] / size];
    // |centre| − arc by its square: an arc is longer than the body, and its radius would drown the gap in rounding.
    let past = two * arc * (normal[0] * from[0] + normal[1] * from[1]) + from[0].squared() + from[1].squared();
    let rise = past / (size + arc);
    let begun = (normal[0] * centre[1] - normal[1] * centre[0]).lt(zero);
    let ended = (end[0] * centre[1] - end[1] * centre[0]).lt(zero);
    let away = |a: usize| R::select(begun, R::select(ended, from[a] - edge[a], out[a] * rise), from[a]);
    // Below its centre the arc goes on as the wall that it is tangent to.
    let wall = centre[1].lt(zero);
    Side {
        away: [away(0), away(1)],
        normal: [R::select(wall, one, out[0]), R::select(wall, zero, out[1])],
        beside: begun & !ended,
        height: R::select(wall, from[0] - edge[0], rise),
    }
}

/// Gap of a point given in the body's frame [m]: x, y across the axis, z along it towards the nose.
#[inline(always)]
pub fn gap<R: Scalar>(profile: &Outline<R>, point: [R; 3]) -> SignedDistance<R> {
    if let Some(chisel) = &profile.chisel {
        return projectile_chisel::gap(profile, chisel, point);
    }
    let zero = R::splat(0.0);
    let one = R::splat(1.0);
    let tiny = R::splat(TINY);
    let across = if profile.bar { point[0].squared() } else { point[0].squared() + point[1].squared() };
    let rho = across.sqrt();
    let s = point[2];
    // Nearest point over the sides; inside is where no side is crossed.
    let mut best = R::splat(FAR);
    let mut normal = [zero, one];
    let mut offset = [zero, zero];
    let mut beside = false;
    let mut deepest = R::splat(-FAR);
    let mut deepest_normal = [zero, one];
    let sides = profile.count.saturating_sub(1).max(1);
    for i in 0..sides {
        let a = profile.corner[i];
        let b = profile.corner[(i + 1).min(profile.count - 1)];
        let edge = [b[0] - a[0], b[1] - a[1]];
        let from = [rho - a[0], s - a[1]];
        let n = profile.normal[i];
        let bent = i == 0 && zero.lt(profile.arc);
        let side = if bent { arc_side(n, profile.arc, edge, from) } else { straight_side(n, edge, from) };
        let square = side.away[0].squared() + side.away[1].squared();
        let closer = square.lt(best);
        best = R::select(closer, square, best);
        normal = [R::select(closer, side.normal[0], normal[0]), R::select(closer, side.normal[1], normal[1])];
        offset = [R::select(closer, side.away[0], offset[0]), R::select(closer, side.away[1], offset[1])];
        beside = (closer & side.beside) | (!closer & beside);
        let deeper = deepest.lt(side.height);
        deepest = R::select(deeper, side.height, deepest);
        deepest_normal = [
            R::select(deeper, side.normal[0], deepest_normal[0]),
            R::select(deeper, side.normal[1], deepest_normal[1]),
        ];
    }
    let solid = profile.count > 1;
    let inside = solid & deepest.le(zero);
    let distance = best.sqrt();
    // Near the surface the direction to it is noise: beside a side that side's own normal holds.
    let resolved = !beside & R::splat(RESOLVED).lt(distance);
    let safe = R::select(resolved, distance, one);
    let outside = [R::select(resolved, offset[0] / safe, normal[0]), R::select(resolved, offset[1] / safe, normal[1])];
    let n_rho = R::select(inside, deepest_normal[0], outside[0]);
    let n_s = R::select(inside, deepest_normal[1], outside[1]);
    let signed = R::select(inside, deepest, distance);
    // On the axis no direction across it is nearer than another: the normal lies along it.
    let on_axis = rho.le(tiny);
    let spread = R::select(on_axis, zero, n_rho / R::select(on_axis, one, rho));
    let ahead = R::select(n_s.lt(zero), -one, one);
    let y = if profile.bar { zero } else { spread * point[1] };
    let normal = [spread * point[0], y, R::select(on_axis, ahead, n_s)];
    SignedDistance { distance: signed - profile.radius, normal }
}

/// How far the nose lies behind its foremost plane beside this point, along the axis [m]: 0 but for a chisel.
#[inline(always)]
pub fn recess<R: Scalar>(profile: &Outline<R>, point: [R; 3]) -> R {
    profile.chisel.as_ref().map_or(R::splat(0.0), |chisel| chisel.recess(point))
}

/// The gap that contact acts on: [`gap`], except in the rim zone of a flat or chisel nose.
///
/// Elements are straight, so fabric drawn over a sharp rim cuts the corner: a node next to the face hangs behind the
/// rim instead of lying against it. Within `rim_depth` (one element length) behind the rim such a node is held
/// along the axis, as the fabric in front of it is, once it is inside the shadow of the face; its sideways
/// penetration is measured and reported. Measured on the 155 m/s shot this halves the spread over sub-cell hit
/// positions and brings velocities to those of finer contact sampling (benches/NOTES.md).
///
/// A chisel nose meets its wall in edges as sharp (55° to 90° of turn at the default angles, where a flat rim has 90°): behind each of
/// its faces a node is held along the normal of that face, as the fabric on it is.
#[inline(always)]
pub(crate) fn contact_distance<R: Scalar>(profile: &Outline<R>, point: [R; 3], rim_depth: R) -> SignedDistance<R> {
    let zero = R::splat(0.0);
    let g = gap(profile, point);
    let below = profile.corner[1][1] - recess(profile, point) - point[2];
    let flat = profile.is_flat();
    let zone = flat & zero.lt(below) & below.le(rim_depth);
    let inside = g.distance.lt(zero);
    let face = profile.chisel.as_ref().map_or([zero, zero, R::splat(1.0)], |chisel| chisel.face(point));
    SignedDistance {
        distance: R::select(zone & !inside, R::splat(FAR), g.distance),
        normal: [
            R::select(zone, face[0], g.normal[0]),
            R::select(zone, face[1], g.normal[1]),
            R::select(zone, face[2], g.normal[2]),
        ],
    }
}

impl Outline<f64> {
    /// Whether the nose is a flat face with a circle for a rim.
    pub(crate) fn has_round_rim(&self) -> bool {
        self.is_flat() && self.chisel.is_none() && !self.bar
    }

    /// Where a straight line crosses the cylinder through the rim of a flat face, as fractions of the way, ascending; NaN
    /// where it does not between its ends. Points in the body's frame [m].
    pub(crate) fn rim_crossings(&self, from: [f64; 3], to: [f64; 3]) -> [f64; 2] {
        let radius = self.corner[1][0];
        // Most edges near a rim lie inside, or on one side of it.
        let is_inside = |at: [f64; 3]| at[0] * at[0] + at[1] * at[1] < radius * radius;
        let is_beside = |axis: usize| from[axis].min(to[axis]) > radius || from[axis].max(to[axis]) < -radius;
        if (is_inside(from) && is_inside(to)) || is_beside(0) || is_beside(1) {
            return [f64::NAN; 2];
        }
        let way = [to[0] - from[0], to[1] - from[1]];
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let from = [from[0], from[1]];
        let (square, half) = (dot(way, way), dot(from, way));
        let root = (half * half - square * (dot(from, from) - radius * radius)).sqrt();
        [-half - root, -half + root].map(|at| at / square).map(|at| if 0.0 < at && at < 1.0 { at } else { f64::NAN })
    }

    /// Height of a point over the plane of a flat face [m].
    pub(crate) fn height_over_face(&self, point: [f64; 3]) -> f64 {
        point[2] - self.corner[1][1] - self.radius
    }
}

impl<R: Scalar> Outline<R> {
    /// Whether the nose is a flat face, chisel noses included.
    pub(crate) fn is_flat(&self) -> bool {
        let arc = R::splat(0.0).lt(self.arc);
        self.count > 2 && !arc && !self.normal[0][1].lt(R::splat(1.0))
    }
}

#[cfg(test)]
#[path = "projectile_shape_tests.rs"]
pub(crate) mod tests;
