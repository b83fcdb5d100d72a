//! Projectile surfaces: gap and outward normal of a point near an analytic body.
//!
//! Every body is a convex profile (ρ, s) around its axis, shrunk by the edge radius and grown again, so that one
//! kernel covers cylinder, sphere, cone and ogive with rounded edges. A bar lying in the fabric's plane is the same with
//! ρ measured across it; a chisel nose is cut from the profile of a cylinder. s runs along the body axis towards the nose, from the centre
//! of mass.

use crate::num::scalar::Real;

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
pub struct Outline {
    /// (ρ, s) of each corner [m]; the first `count` are used.
    pub corner: [[f64; 2]; CORNERS],
    /// Unit outward normal (ρ, s) of the side from corner i to i + 1, where it begins.
    pub normal: [[f64; 2]; CORNERS],
    /// Corners used, at least 1.
    pub count: usize,
    /// Rounding [m].
    pub radius: f64,
    /// Radius of the first side where that is an arc, 0 where it is straight [m].
    pub arc: f64,
    /// True for a bar: ρ is measured along the body's x axis alone.
    pub bar: bool,
    /// The flats that make a chisel of the flat nose.
    pub chisel: Option<Chisel>,
}

/// Gap to a surface and its outward normal in the body's frame.
#[derive(Clone, Copy, Debug)]
pub struct SignedDistance {
    /// Distance to the surface, negative inside [m].
    pub distance: f64,
    /// Outward unit normal at the nearest surface point, body frame.
    pub normal: [f64; 3],
}

/// One side of a profile as a point sees it.
struct Side {
    /// From the nearest point of the side to the point [m].
    away: [f64; 2],
    /// Outward normal there.
    normal: [f64; 2],
    /// Whether that is no end of the side.
    beside: bool,
    /// Height over the side and what it goes on to beyond its ends [m].
    height: f64,
}

/// A straight side: `from` and `edge` run from its beginning to the point and to its end.
fn straight_side(normal: [f64; 2], edge: [f64; 2], from: [f64; 2]) -> Side {
    let length = Real::max(edge[0] * edge[0] + edge[1] * edge[1], TINY);
    let along = Real::min(Real::max((from[0] * edge[0] + from[1] * edge[1]) / length, 0.0), 1.0);
    let away = [from[0] - along * edge[0], from[1] - along * edge[1]];
    let height = from[0] * normal[0] + from[1] * normal[1];
    Side { away, normal, beside: 0.0 < along && along < 1.0, height }
}

/// A side that is an arc of radius `arc` and begins with normal `normal`.
fn arc_side(normal: [f64; 2], arc: f64, edge: [f64; 2], from: [f64; 2]) -> Side {
    // From the arc's centre to the point and to the arc's end.
    let centre = [from[0] + arc * normal[0], from[1] + arc * normal[1]];
    let end = [edge[0] + arc * normal[0], edge[1] + arc * normal[1]];
    let size = Real::max((centre[0] * centre[0] + centre[1] * centre[1]).sqrt(), TINY);
    let out = [centre[0] / size, centre[1] / size];
    // |centre| − arc by its square: an arc is longer than the body, and its radius would drown the gap in rounding.
    let past = 2.0 * arc * (normal[0] * from[0] + normal[1] * from[1]) + from[0] * from[0] + from[1] * from[1];
    let rise = past / (size + arc);
    let begun = normal[0] * centre[1] - normal[1] * centre[0] < 0.0;
    let ended = end[0] * centre[1] - end[1] * centre[0] < 0.0;
    let away = match (begun, ended) {
        (false, _) => from,
        (true, true) => [from[0] - edge[0], from[1] - edge[1]],
        (true, false) => [out[0] * rise, out[1] * rise],
    };
    // Below its centre the arc goes on as the wall that it is tangent to.
    let (normal, height) = if centre[1] < 0.0 { ([1.0, 0.0], from[0] - edge[0]) } else { (out, rise) };
    Side { away, normal, beside: begun && !ended, height }
}

/// Gap of a point given in the body's frame [m]: x, y across the axis, z along it towards the nose.
pub fn gap(profile: &Outline, point: [f64; 3]) -> SignedDistance {
    if let Some(chisel) = &profile.chisel {
        return chisel_gap(profile, chisel, point);
    }
    let [x, y, s] = point;
    let rho = if profile.bar { x * x } else { x * x + y * y }.sqrt();
    // Nearest point over the sides; inside is where no side is crossed.
    let (mut square, mut nearest) = (FAR, Side { away: [0.0; 2], normal: [0.0, 1.0], beside: false, height: 0.0 });
    let (mut deepest, mut deepest_normal) = (-FAR, [0.0, 1.0]);
    for i in 0..profile.count.saturating_sub(1).max(1) {
        let (a, b) = (profile.corner[i], profile.corner[(i + 1).min(profile.count - 1)]);
        let (edge, from, normal) = ([b[0] - a[0], b[1] - a[1]], [rho - a[0], s - a[1]], profile.normal[i]);
        let bent = i == 0 && 0.0 < profile.arc;
        let side = if bent { arc_side(normal, profile.arc, edge, from) } else { straight_side(normal, edge, from) };
        if deepest < side.height {
            (deepest, deepest_normal) = (side.height, side.normal);
        }
        let to_side = side.away[0] * side.away[0] + side.away[1] * side.away[1];
        if to_side < square {
            (square, nearest) = (to_side, side);
        }
    }
    let distance = square.sqrt();
    let (signed, [n_rho, n_s]) = if profile.count > 1 && deepest <= 0.0 {
        (deepest, deepest_normal)
    } else if !nearest.beside && RESOLVED < distance {
        (distance, nearest.away.map(|x| x / distance))
    } else {
        // Near the surface the direction to it is noise: beside a side that side's own normal holds.
        (distance, nearest.normal)
    };
    // On the axis no direction across it is nearer than another: the normal lies along it.
    let on_axis = rho <= TINY;
    let spread = if on_axis { 0.0 } else { n_rho / rho };
    let ahead = if n_s < 0.0 { -1.0 } else { 1.0 };
    let normal = [spread * x, if profile.bar { 0.0 } else { spread * y }, if on_axis { ahead } else { n_s }];
    SignedDistance { distance: signed - profile.radius, normal }
}

/// Depth of the nose behind its foremost plane beside this point, along the axis [m]: 0 but for a chisel.
pub fn recess(profile: &Outline, point: [f64; 3]) -> f64 {
    profile.chisel.as_ref().map_or(0.0, |chisel| chisel.recess(point))
}

/// The gap that contact acts on: [`gap`], except in the rim zone of a flat or chisel nose.
///
/// Elements are straight, so fabric drawn over a sharp rim cuts the corner: a node next to the face hangs behind the
/// rim instead of lying against it. Within `rim_depth` (one element length) behind the rim such a node is held
/// along the axis, as the fabric in front of it is, once it is inside the shadow of the face; its sideways
/// penetration is measured and reported. Measured on the 155 m/s shot this halves the spread over sub-cell hit
/// positions and brings velocities to those of finer contact sampling (docs/decisions/08).
///
/// A chisel nose meets its wall in edges as sharp (55° to 90° of turn at the default angles, where a flat rim has 90°): behind each of
/// its faces a node is held along the normal of that face, as the fabric on it is.
pub(crate) fn contact_distance(profile: &Outline, point: [f64; 3], rim_depth: f64) -> SignedDistance {
    let g = gap(profile, point);
    let below = profile.corner[1][1] - recess(profile, point) - point[2];
    if !(profile.is_flat() && 0.0 < below && below <= rim_depth) {
        return g;
    }
    SignedDistance {
        distance: if g.distance < 0.0 { g.distance } else { FAR },
        normal: profile.chisel.as_ref().map_or([0.0, 0.0, 1.0], |chisel| chisel.face(point)),
    }
}

impl Outline {
    /// Whether the nose is a flat face, chisel noses included.
    pub(crate) fn is_flat(&self) -> bool {
        self.count > 2 && self.arc <= 0.0 && self.normal[0][1] >= 1.0
    }

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

    /// Distance that the ends of a line must move before the rim of a flat face may cross it at or behind the face [m]; not above zero where it
    /// may already. Points in the body's frame [m].
    pub(crate) fn rim_clearance(&self, from: [f64; 3], to: [f64; 3]) -> f64 {
        let radius = self.corner[1][0];
        let over = self.height_over_face(from).min(self.height_over_face(to));
        let inside = radius - from[0].hypot(from[1]).max(to[0].hypot(to[1]));
        let way = [to[0] - from[0], to[1] - from[1]];
        let nearest = -(from[0] * way[0] + from[1] * way[1]) / (way[0] * way[0] + way[1] * way[1]);
        let [x, y] = [0, 1].map(|axis| from[axis] + nearest.clamp(0.0, 1.0) * way[axis]);
        over.max(inside).max(x.hypot(y) - radius)
    }

    /// Height of a point over the plane of a flat face [m].
    pub(crate) fn height_over_face(&self, point: [f64; 3]) -> f64 {
        point[2] - self.corner[1][1] - self.radius
    }
}

/// Newton steps for the nearest point of the ellipse in which a flat meets the wall; four reach double precision.
pub const ELLIPSE_STEPS: usize = 5;

/// Flats that turn the flat nose of a cylinder into a chisel. The strip that is left lies along the body's x axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chisel {
    /// Half the width of the strip, along y [m].
    pub half: f64,
    /// Sine of the angle between strip and flats.
    pub sine: f64,
    /// Cosine of that angle.
    pub cosine: f64,
    /// Tangent of that angle.
    pub slope: f64,
    /// Half the length of the strip's sides, along x [m].
    pub corner: f64,
}

impl Chisel {
    /// Depth of the nose behind the strip beside this point, along the axis [m].
    fn recess(&self, point: [f64; 3]) -> f64 {
        Real::max((point[1].abs() - self.half) * self.slope, 0.0)
    }

    /// Outward normal of the face of the nose beside this point.
    fn face(&self, point: [f64; 3]) -> [f64; 3] {
        let side = if point[1] < 0.0 { -self.sine } else { self.sine };
        if self.half < point[1].abs() { [0.0, side, self.cosine] } else { [0.0, 0.0, 1.0] }
    }

    /// Cosine and sine of the place on the wall that is nearest to a point on the edge between flat and wall.
    ///
    /// On that ellipse, q = (r c, r s, front − (r s − half) slope), the distance is least where c = X/μ and
    /// s = Y/(μ + slope²) with c² + s² = 1. μ ≥ 1 outside of the edge, and 1/|(c, s)| is nearly straight in μ, so
    /// that Newton's iteration from below converges without leaving the side it begins on.
    fn nearest_on_ellipse(&self, radius: f64, point: [f64; 3]) -> [f64; 2] {
        let bend = self.slope * self.slope;
        let size = Real::max(radius, RESOLVED);
        let [x, y] = [point[0] / size, (point[1] - self.slope * (point[2] - self.half * self.slope)) / size];
        let mut mu = Real::max(Real::max((x * x + y * y).sqrt() - bend, x), 1.0);
        for _ in 0..ELLIPSE_STEPS {
            let [c, s] = [x / mu, y / (mu + bend)];
            let square = Real::max(c * c + s * s, TINY);
            let change = Real::max(c * c / mu + s * s / (mu + bend), TINY);
            mu = Real::max(mu + square * (square.sqrt() - 1.0) / change, 1.0);
        }
        let [c, s] = [x / mu, y / (mu + bend)];
        let length = Real::max(c * c + s * s, TINY).sqrt();
        [c / length, s / length]
    }
}

/// Gap of a point given in the body's frame [m].
fn chisel_gap(profile: &Outline, chisel: &Chisel, point: [f64; 3]) -> SignedDistance {
    let [radius, front] = profile.corner[1];
    let back = profile.corner[2][1];
    // z from the strip.
    let [x, y, z] = [point[0].abs(), point[1].abs(), point[2] - front];
    let rho = (x * x + y * y).sqrt();
    let radial = if rho <= TINY { [1.0, y, 0.0] } else { [x / rho, y / rho, 0.0] };
    let flat = [0.0, chisel.sine, chisel.cosine];
    let over_flat = (y - chisel.half) * chisel.sine + z * chisel.cosine;
    let surfaces =
        [(z, [0.0, 0.0, 1.0]), (over_flat, flat), (rho - radius, radial), (back - point[2], [0.0, 0.0, -1.0])];
    // The two largest heights over the surfaces.
    let (mut deepest, mut second, mut normal) = (-FAR, -FAR, [0.0, 0.0, 1.0]);
    for (height, n) in surfaces {
        second = Real::max(second, Real::min(deepest, height));
        if deepest < height {
            (deepest, normal) = (height, n);
        }
    }
    let mut distance = deepest;
    if 0.0 < second {
        let offset = outside(chisel, [radius, back - front], [x, y, z], rho, over_flat);
        distance = (offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2]).sqrt();
        if RESOLVED < distance {
            normal = offset.map(|x| x / distance);
        }
    }
    let signed = |value: f64, of: f64| if of < 0.0 { -value } else { value };
    SignedDistance {
        distance: distance - profile.radius,
        normal: [signed(normal[0], point[0]), signed(normal[1], point[1]), normal[2]],
    }
}

/// From the nearest point of the body to a point that has passed several of its surfaces [m]; z from the strip.
/// `size`: radius, and z of the back.
fn outside(chisel: &Chisel, [radius, back]: [f64; 2], point: [f64; 3], rho: f64, over_flat: f64) -> [f64; 3] {
    let [x, y, z] = point;
    // Inwards to the wall, then along it or across the strip or the back.
    let shrink = if radius < rho { radius / rho } else { 1.0 };
    let at = [x * shrink, y * shrink, z];
    let height = Real::max(Real::min(z, -chisel.recess(at)), back);
    let down = [over_flat * chisel.sine, over_flat * chisel.cosine];
    let foot = y - down[0];
    let on_flat = chisel.half <= foot && x * x + foot * foot <= radius * radius;
    let [c, s] = chisel.nearest_on_ellipse(radius, point);
    let place = [radius * c, radius * s];
    let drop = (place[1] - chisel.half) * chisel.slope;
    let candidates = [
        (true, [x - at[0], y - at[1], z - height]),
        // The edge between strip and flat, with its corner.
        (true, [x - Real::min(x, chisel.corner), y - chisel.half, z]),
        (on_flat, [0.0, down[0], down[1]]),
        // The edge between flat and wall.
        (chisel.half <= place[1], [x - place[0], y - place[1], z + drop]),
    ];
    let (mut least, mut nearest) = (FAR, [0.0, 0.0, 1.0]);
    for (there, from) in candidates {
        let square = from[0] * from[0] + from[1] * from[1] + from[2] * from[2];
        if there && square < least {
            (least, nearest) = (square, from);
        }
    }
    nearest
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

    use super::*;
    use crate::case::{Motion, Projectile, Rotation, Shape};
    use crate::physics::projectile_body::Body;

    /// A projectile of that shape, with nothing else about it.
    pub(crate) fn projectile(shape: Shape, edge_radius: f64) -> Projectile {
        Projectile {
            shape,
            edge_radius,
            mass: 3e-3,
            density: None,
            axial_inertia: None,
            transverse_inertia: None,
            velocity: 155.0,
            offset: [0.0; 2],
            standoff: 0.0,
            obliquity: 0.0,
            azimuth: 0.0,
            yaw: 0.0,
            angular_velocity: [0.0; 3],
            friction: 0.0,
            motion: Motion::Free,
            rotation: Rotation::Free,
        }
    }

    /// Numbers between −8 and 8.
    pub(crate) struct Numbers(pub(crate) u32);

    impl Numbers {
        pub(crate) fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(self.0 >> 8) / f64::from(1 << 24) * 16.0 - 8.0
        }

        /// Between −1 and 1.
        pub(crate) fn unit(&mut self) -> f64 {
            self.next() / 8.0
        }

        pub(crate) fn point(&mut self) -> [f64; 3] {
            [self.next(), self.next(), self.next()]
        }
    }

    #[test]
    fn the_rim_of_a_flat_nose_holds_what_hangs_behind_it() {
        let body = Body::new(&projectile(Shape::Cylinder { diameter: 4.0, length: 10.0 }, 0.0)).unwrap();
        let at = |point: [f64; 3]| contact_distance(&body.profile, point, 1.0);
        let held = at([1.9, 0.0, 4.5]);
        assert_eq!(held.normal, [0.0, 0.0, 1.0]);
        assert!((held.distance + 0.1).abs() < 1e-12, "the true sideways depth: {held:?}");
        assert!(at([2.1, 0.0, 4.5]).distance > 1e29, "outside the shadow nothing holds");
        assert!((at([1.9, 0.0, 3.5]).normal[0] - 1.0).abs() < 1e-15);
        assert_eq!(at([1.0, 0.0, 5.1]).normal, [0.0, 0.0, 1.0]);
        let sphere = Body::new(&projectile(Shape::Sphere { diameter: 2.0 }, 0.0)).unwrap();
        assert_eq!(
            contact_distance(&sphere.profile, [0.9, 0.0, -0.1], 1.0).distance,
            gap(&sphere.profile, [0.9, 0.0, -0.1]).distance
        );
    }

    fn fragment(nose_angle: f64, edge: f64) -> Body {
        let shape = Shape::Fragment { diameter: 6.0, length: 12.0, nose_flat: 2.8, nose_angle, roll: 0.0 };
        Body::new(&projectile(shape, edge)).unwrap()
    }

    #[test]
    fn behind_a_chisel_nose_nodes_are_held_along_the_face_in_front_of_them() {
        let body = fragment(0.611, 0.0);
        let front = body.profile.corner[1][1];
        let (sine, cosine) = 0.611_f64.sin_cos();
        let held = |point: [f64; 3]| contact_distance(&body.profile, point, 1.0);
        assert_eq!(held([2.95, 0.2, front - 0.5]).normal, [0.0, 0.0, 1.0]);
        assert!((held([2.95, 0.0, front - 0.5]).distance + 0.05).abs() < 1e-12, "the true sideways depth");
        let low = front - 1.5 * sine / cosine;
        assert_eq!(held([0.0, -2.9, low - 0.5]).normal, [0.0, -sine, cosine]);
        assert!(held([0.0, -3.1, low - 0.5]).distance > 1e29, "outside the shadow nothing holds");
        assert!((held([0.0, -2.95, low - 1.2]).normal[1] + 1.0).abs() < 1e-12);
    }
}
