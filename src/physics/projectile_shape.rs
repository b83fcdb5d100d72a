//! Projectile surfaces: gap and outward normal of a point near an analytic body.
//!
//! Every body is a convex profile (ρ, s) around its axis, shrunk by the edge radius and grown again, so that one
//! kernel covers cylinder, sphere, cone and ogive with rounded edges. A bar lying in the fabric's plane is the same with
//! ρ measured across it; a chisel nose is cut from the profile of a cylinder, see
//! [`projectile_chisel`]. s runs along the body axis towards the nose, from the centre of mass.

use crate::num::scalar::Scalar;
pub use crate::physics::projectile_body::{Body, EdgeRadiusTooLarge};

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
        return chisel_gap(profile, chisel, point);
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

/// Depth of the nose behind its foremost plane beside this point, along the axis [m]: 0 but for a chisel.
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
/// positions and brings velocities to those of finer contact sampling (docs/decisions/13).
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

    /// Crossings of a straight line and the cylinder through the rim of a flat face, as fractions of the way, ascending; NaN
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

/// Newton steps for the nearest point of the ellipse in which a flat meets the wall; four reach double precision.
pub const ELLIPSE_STEPS: usize = 5;

/// Flats that turn the flat nose of a cylinder into a chisel. The strip that is left lies along the body's x axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chisel<R> {
    /// Half the width of the strip, along y [m].
    pub half: R,
    /// Sine of the angle between strip and flats.
    pub sine: R,
    /// Cosine of that angle.
    pub cosine: R,
    /// Tangent of that angle.
    pub slope: R,
    /// Half the length of the strip's sides, along x [m].
    pub corner: R,
}

impl<R: Scalar> Chisel<R> {
    /// Depth of the nose behind the strip beside this point, along the axis [m].
    #[inline(always)]
    pub fn recess(&self, point: [R; 3]) -> R {
        ((point[1].abs() - self.half) * self.slope).max(R::splat(0.0))
    }

    /// Outward normal of the face of the nose beside this point.
    #[inline(always)]
    pub fn face(&self, point: [R; 3]) -> [R; 3] {
        let flat = self.half.lt(point[1].abs());
        let zero = R::splat(0.0);
        let side = R::select(point[1].lt(zero), -self.sine, self.sine);
        [zero, R::select(flat, side, zero), R::select(flat, self.cosine, R::splat(1.0))]
    }

    /// Cosine and sine of the place on the wall that is nearest to a point on the edge between flat and wall.
    ///
    /// On that ellipse, q = (r c, r s, front − (r s − half) slope), the distance is least where c = X/μ and
    /// s = Y/(μ + slope²) with c² + s² = 1. μ ≥ 1 outside of the edge, and 1/|(c, s)| is nearly straight in μ, so
    /// that Newton's iteration from below converges without leaving the side it begins on.
    #[inline(always)]
    fn nearest_on_ellipse(&self, radius: R, point: [R; 3]) -> [R; 2] {
        let (one, tiny) = (R::splat(1.0), R::splat(TINY));
        let bend = self.slope.squared();
        let size = radius.max(R::splat(RESOLVED));
        let [x, y] = [point[0] / size, (point[1] - self.slope * (point[2] - self.half * self.slope)) / size];
        let mut mu = ((x.squared() + y.squared()).sqrt() - bend).max(x).max(one);
        for _ in 0..ELLIPSE_STEPS {
            let [c, s] = [x / mu, y / (mu + bend)];
            let square = (c.squared() + s.squared()).max(tiny);
            let change = (c.squared() / mu + s.squared() / (mu + bend)).max(tiny);
            mu = (mu + square * (square.sqrt() - one) / change).max(one);
        }
        let [c, s] = [x / mu, y / (mu + bend)];
        let length = (c.squared() + s.squared()).max(tiny).sqrt();
        [c / length, s / length]
    }
}

/// The nearest candidate so far.
struct Nearest<R> {
    square: R,
    offset: [R; 3],
}

impl<R: Scalar> Nearest<R> {
    /// Takes a candidate into account: `from` runs from it to the point.
    #[inline(always)]
    fn see(&mut self, there: R::Mask, from: [R; 3]) {
        let square = from[0].squared() + from[1].squared() + from[2].squared();
        let closer = there & square.lt(self.square);
        self.square = R::select(closer, square, self.square);
        for a in 0..3 {
            self.offset[a] = R::select(closer, from[a], self.offset[a]);
        }
    }
}

/// Gap of a point given in the body's frame [m].
#[inline(always)]
fn chisel_gap<R: Scalar>(profile: &Outline<R>, chisel: &Chisel<R>, point: [R; 3]) -> SignedDistance<R> {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let [radius, front] = profile.corner[1];
    let back = profile.corner[2][1];
    // z from the strip.
    let [x, y, z] = [point[0].abs(), point[1].abs(), point[2] - front];
    let rho = (x.squared() + y.squared()).sqrt();
    let on_axis = rho.le(R::splat(TINY));
    let safe = R::select(on_axis, one, rho);
    let radial = [R::select(on_axis, one, x / safe), y / safe, zero];
    let flat = [zero, chisel.sine, chisel.cosine];
    let over_flat = (y - chisel.half) * chisel.sine + z * chisel.cosine;
    let surfaces =
        [(z, [zero, zero, one]), (over_flat, flat), (rho - radius, radial), (back - point[2], [zero, zero, -one])];
    // The two largest heights over the surfaces.
    let mut deepest = R::splat(-FAR);
    let mut second = R::splat(-FAR);
    let mut normal = [zero, zero, one];
    for (height, n) in surfaces {
        let deeper = deepest.lt(height);
        second = second.max(deepest.min(height));
        deepest = R::select(deeper, height, deepest);
        for a in 0..3 {
            normal[a] = R::select(deeper, n[a], normal[a]);
        }
    }
    let offset = outside(chisel, [radius, back - front], [x, y, z], rho, over_flat);
    let distance = (offset[0].squared() + offset[1].squared() + offset[2].squared()).sqrt();
    let edge = zero.lt(second);
    let resolved = edge & R::splat(RESOLVED).lt(distance);
    let safe = R::select(resolved, distance, one);
    let n = |a: usize| R::select(resolved, offset[a] / safe, normal[a]);
    let signed = |value: R, of: R| R::select(of.lt(zero), -value, value);
    SignedDistance {
        distance: R::select(edge, distance, deepest) - profile.radius,
        normal: [signed(n(0), point[0]), signed(n(1), point[1]), n(2)],
    }
}

/// From the nearest point of the body to a point that has passed several of its surfaces [m]; z from the strip.
/// `size`: radius, and z of the back.
#[inline(always)]
fn outside<R: Scalar>(chisel: &Chisel<R>, size: [R; 2], point: [R; 3], rho: R, over_flat: R) -> [R; 3] {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let [radius, back] = size;
    let [x, y, z] = point;
    let mut best = Nearest { square: R::splat(FAR), offset: [zero, zero, one] };
    // Inwards to the wall, then along it or across the strip or the back.
    let shrink = R::select(radius.lt(rho), radius / R::select(radius.lt(rho), rho, one), one);
    let at = [x * shrink, y * shrink, z];
    let height = z.min(-chisel.recess(at)).max(back);
    best.see(true, [x - at[0], y - at[1], z - height]);
    // The edge between strip and flat, with its corner.
    best.see(true, [x - x.min(chisel.corner), y - chisel.half, z]);
    // The flat.
    let down = [over_flat * chisel.sine, over_flat * chisel.cosine];
    let foot = y - down[0];
    let on_flat = chisel.half.le(foot) & (x.squared() + foot.squared()).le(radius.squared());
    best.see(on_flat, [zero, down[0], down[1]]);
    // The edge between flat and wall.
    let [c, s] = chisel.nearest_on_ellipse(radius, point);
    let foot = [radius * c, radius * s];
    let drop = (foot[1] - chisel.half) * chisel.slope;
    best.see(chisel.half.le(foot[1]), [x - foot[0], y - foot[1], z + drop]);
    best.offset
}

#[cfg(test)]
#[path = "projectile_shape_tests.rs"]
pub(crate) mod tests;
