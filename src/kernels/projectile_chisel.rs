//! Chisel noses: gap and outward normal near a cylinder whose flat front two slanted flats cut down to a strip.
//!
//! Not a body of revolution but the common part of convex ones: the cylinder, the half spaces behind its two ends and
//! those behind the flats. Where a point has passed no more than one of these surfaces, its height over that one is the
//! gap. Where it has passed several, the nearest point lies on an edge or on a face that a move past another one reaches:
//! the nearest of a few candidates, all of them points of the body. By symmetry everything happens where x, y ≥ 0.

use super::projectile_shape::{FAR, Outline, RESOLVED, SignedDistance, TINY};
use crate::num::scalar::Scalar;

/// Newton steps for the nearest point of the ellipse in which a flat meets the wall; four reach double precision.
pub const ELLIPSE_STEPS: usize = 5;

/// What turns the flat nose of a cylinder into a chisel. The strip that is left lies along the body's x axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chisel<R> {
    /// Half the width of the strip, along y [m].
    pub half: R,
    /// Sine of the angle between strip and flats.
    pub sine: R,
    /// Its cosine.
    pub cosine: R,
    /// Its tangent.
    pub slope: R,
    /// Half the length of the strip's sides, along x [m].
    pub corner: R,
}

impl<R: Scalar> Chisel<R> {
    /// How far the nose lies behind the strip beside this point, along the axis [m].
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
pub fn gap<R: Scalar>(profile: &Outline<R>, chisel: &Chisel<R>, point: [R; 3]) -> SignedDistance<R> {
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
#[path = "projectile_chisel_tests.rs"]
mod tests;
