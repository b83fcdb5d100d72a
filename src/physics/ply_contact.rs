//! Contact between plies: where a node stands over a cell of the neighbouring ply, and the impulses between them.
//!
//! Node to surface, both ways, kinematic and inelastic with Coulomb friction like the projectile's. All contacts of a
//! step are solved at once: each node's mass is shared out among the contacts it takes part in (Tonge, Benevolenski &
//! Voroshilov 2012 call it mass splitting), each contact is then an impact of its own, and the impulses add up. Momentum
//! is conserved pair by pair, energy never grows, no order matters, and two plies that meet at uniform velocities share it
//! at once. What closes slower than it should (a stack under load) shows as penetration, which is driven out
//! by a fraction per step.

use nalgebra::Vector3;

use crate::num::scalar::{Real, each};
use crate::physics::rigid_body::Cut;

/// Most of a penetration that is driven out in a step [-]. Plies pressed on each other for long are driven apart in every step, each
/// of which stretches yarns by ½ k x² without account: a fifth made 1.6 % of the energy of a corner hit.
pub const POSITION_CORRECTION: f64 = 0.05;
/// Time in which a penetration is driven out, were it left alone [s]. Yarns of plies held close to the hit pull nodes back at once, and each
/// step's work against them is lost in contact: with short steps and no such time a corner hit gained 6.6 % of its energy (docs/decisions/11).
pub const RECOVERY_TIME: f64 = 3.5e-6;
/// Fraction of what is deeper than [`DEEP`] that is driven out besides: a node so deep must not get to the other side.
pub const DEEP_RECOVERY: f64 = 0.15;
/// See [`DEEP_RECOVERY`]; over the thickness.
pub const DEEP: f64 = 0.5;
/// Largest speed at which a node is driven out [m/s]. Moving it strains the yarns beyond the work of their forces, by the square of
/// this speed.
pub const RECOVERY_SPEED: f64 = 30.0;
/// Multiple of that speed more for every thickness beyond [`NEAR_MIDDLE`].
pub const DEEP_SPEED: f64 = 30.0;
/// A node is about to pass the mid-plane here; over the thickness.
pub const NEAR_MIDDLE: f64 = 0.8;
/// A node has passed the mid-plane here, over the thickness: torn, crumpled fabric hooks over its neighbour.
pub const PASSED: f64 = 1.2;
/// Largest speed at which such a node is driven back [m/s]: yarns hold it where it is, and a faster one pumps energy into them.
pub const PASSED_SPEED: f64 = 6.0;
/// No node is driven out faster [m/s].
pub const FASTEST: f64 = RECOVERY_SPEED * (1.0 + DEEP_SPEED * (PASSED - NEAR_MIDDLE));
/// Depth that is left, over the thickness [-]: rounding of places is no penetration.
pub const SLOP: f64 = 1e-4;
/// Steps over neighbouring cells a node may take in one time step.
pub const WALK: usize = 4;
/// Beyond the edge of a cell at which a node walks on to the next, over the cell's length [-].
pub const EDGE: f64 = 1e-6;
/// Beyond the edge of a ply up to which its outermost cells carry a node, over the cell's length [-]: a node on the rim
/// stands for half a cell.
pub const SEGMENT_EXTENSION: f64 = 0.25;
/// Depth up to which a node that was outside a step ago may be found inside, over the thickness: what appears deeper has come
/// through a hole, past an edge or round a fold, and not through the cell.
pub const MAX_INITIAL_PENETRATION: f64 = 0.25;
/// Least area of a cell, over its area at rest: a folded cell is no surface.
pub const MIN_AREA_RATIO: f64 = 0.05;

/// Beyond the edge of a cell up to which a node that is apart from it need not walk on, over the cell's length [-].
pub const EDGE_TOLERANCE: f64 = 0.05;

/// Most that the corners of a cell may differ along z for the same, over its length at rest [-]: on a slope the foot is
/// elsewhere than z shows.
pub const FLATNESS_TOLERANCE: f64 = 0.05;

/// In the axes of the pack.
pub type PackVector<R> = [R; 3];

#[inline(always)]
fn dot<R: Real>(a: &PackVector<R>, b: &PackVector<R>) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<R: Real>(a: &PackVector<R>, b: &PackVector<R>) -> PackVector<R> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Place of a point over a cell.
#[derive(Clone, Copy, Debug)]
pub struct ClosestPoint {
    /// Coordinates within the cell, ±½ at its edges.
    pub at: [f64; 2],
    /// Unit normal of the cell, towards the rear of the pack.
    pub normal: Vector3<f64>,
    /// Height of the point over the cell along the normal [m].
    pub height: f64,
}

/// Whether a point above a cell, as seen along z, is further from it than `touching` [m], and the cell is almost flat: a cheap test
/// that spares most nodes the search for their foot. `sign`: 1 for a point behind the cell, −1 for one in front.
#[inline]
pub fn is_apart(corner: &[Vector3<f64>; 4], point: &Vector3<f64>, sign: f64, touching: f64, area: f64) -> bool {
    let height = corner.map(|c| sign * c.z);
    let [low, high] = [f64::min, f64::max].map(|pick| pick(pick(height[0], height[1]), pick(height[2], height[3])));
    if sign * point.z - high - touching < high - low
        || (high - low).powi(2) > FLATNESS_TOLERANCE * FLATNESS_TOLERANCE * area
    {
        return false;
    }
    let within = |i: usize| {
        let (a, b) = (&corner[i], &corner[(i + 1) % 4]);
        (b.x - a.x) * (point.y - a.y) - (b.y - a.y) * (point.x - a.x) >= -EDGE_TOLERANCE * area
    };
    within(0) && within(1) && within(2) && within(3)
}

/// Part of the bounds of [`is_apart`] within which a point is certainly apart [-].
const CERTAIN: f64 = 0.9;
/// Roundings that may add up in a gap.
const ROUNDINGS: f64 = 8.0;

/// Bounds of [`is_certainly_apart`], for all points of a ply and a neighbour.
#[derive(Clone, Copy, Debug)]
pub struct Clearance<R> {
    /// 1 for points behind the neighbour, −1 for those in front.
    pub sign: R,
    /// From the mid-plane of the neighbour to that of the points' ply at rest, along `sign` [m].
    pub distance: R,
    /// Least gap of a point over a level cell [m].
    room: R,
    /// Rounding factors of a difference of gaps, and of a gap [-].
    more: R,
    less: R,
    /// Over the area of a cell: of the square of a difference of gaps; of twice the triangle of a point and an edge.
    flat: R,
    beside: R,
}

impl<R: Real> Clearance<R> {
    /// In numbers like `n`; `z`: of the points and of the neighbour at rest, `touching` as for [`is_apart`] [m].
    #[inline(always)]
    pub fn new(n: R, sign: f64, z: [f64; 2], touching: f64) -> Self {
        let distance = sign * (z[0] - z[1]);
        let rounding = ROUNDINGS * R::EPSILON;
        Self {
            sign: n.splat_like(sign),
            distance: n.splat_like(distance),
            room: n.splat_like(touching + rounding * (touching.abs() + distance.abs())),
            more: n.splat_like(1.0 + 2.0 * rounding),
            less: n.splat_like(1.0 - rounding),
            flat: n.splat_like(CERTAIN * FLATNESS_TOLERANCE * FLATNESS_TOLERANCE),
            beside: n.splat_like(-CERTAIN * EDGE_TOLERANCE),
        }
    }
}

/// Whether [`is_apart`] is sure to hold, whatever rounding does: for many points at once, in the precision of the state.
/// `arm`: from the point to the corners of the cell in the plane [m]; `gap`: how far the point is behind the neighbour's corners (in
/// front of them) [m].
#[inline(always)]
pub fn is_certainly_apart<R: Real>(clearance: &Clearance<R>, arm: &[[R; 2]; 4], gap: [R; 4], area: R) -> R::Mask {
    let low = gap[0].min(gap[1]).min(gap[2].min(gap[3]));
    let spread = gap[0].max(gap[1]).max(gap[2].max(gap[3])) - low;
    let [a, b, c, d] = *arm;
    let beside = clearance.beside * area;
    (clearance.room + clearance.more * spread).le(clearance.less * low)
        & spread.squared().le(clearance.flat * area)
        & beside.le(across(a, b))
        & beside.le(across(b, c))
        & beside.le(across(c, d))
        & beside.le(across(d, a))
}

/// Twice the triangle between two arms.
#[inline(always)]
fn across<R: Real>(a: [R; 2], b: [R; 2]) -> R {
    a[0] * b[1] - a[1] * b[0]
}

/// A bilinear cell, by its corners (counter-clockwise). Its arithmetic is that of one number for every lane of a register.
struct Surface<R> {
    centre: PackVector<R>,
    along: PackVector<R>,
    across: PackVector<R>,
    twist: PackVector<R>,
    /// Across the cell at its centre, as long as its area; and that squared.
    normal: PackVector<R>,
    square: R,
}

impl<R: Real> Surface<R> {
    #[inline(always)]
    fn new([a, b, c, d]: &[PackVector<R>; 4]) -> Self {
        let (half, quarter) = (a[0].splat_like(0.5), a[0].splat_like(0.25));
        let along = each!(i in 3 => ((b[i] - a[i]) + (c[i] - d[i])) * half);
        let across = each!(i in 3 => ((d[i] - a[i]) + (c[i] - b[i])) * half);
        let centre = each!(i in 3 => ((a[i] + c[i]) + (b[i] + d[i])) * quarter);
        let twist = each!(i in 3 => (a[i] - b[i]) + (c[i] - d[i]));
        let normal = cross(&along, &across);
        Self { centre, along, across, twist, normal, square: dot(&normal, &normal) }
    }

    /// Coordinates within the cell, were it flat, of what lies `arm` [m] from its centre.
    #[inline(always)]
    fn at(&self, arm: &PackVector<R>) -> [R; 2] {
        self.scaled_at(arm).map(|scaled| scaled / self.square)
    }

    /// [`Self::at`] times the square of the normal.
    #[inline(always)]
    fn scaled_at(&self, arm: &PackVector<R>) -> [R; 2] {
        let Self { along, across, .. } = self;
        let [aa, ac, cc] = [dot(along, along), dot(along, across), dot(across, across)];
        let [p, q] = [dot(arm, along), dot(arm, across)];
        [cc * p - ac * q, aa * q - ac * p]
    }

    /// Arm from the centre, as seen by a flat cell. The twist of the cell is small: one correction. `by`: product of the coordinates.
    #[inline(always)]
    fn untwisted(&self, arm: &PackVector<R>, by: R) -> PackVector<R> {
        each!(i in 3 => arm[i] - self.twist[i] * by)
    }

    /// See [`closest_point`].
    #[inline(always)]
    fn foot(&self, point: &PackVector<R>, area: R, planes: Planes) -> ClosestPoints<R> {
        if planes == NO_PLANES { self.foot_anywhere(point, area) } else { self.foot_on(planes, point, area) }
    }

    #[inline(always)]
    fn foot_anywhere(&self, point: &PackVector<R>, area: R) -> ClosestPoints<R> {
        let arm = each!(i in 3 => point[i] - self.centre[i]);
        let [x, y] = self.at(&arm);
        let arm = self.untwisted(&arm, x * y);
        let size = self.square.sqrt();
        let normal = each!(i in 3 => self.normal[i] / size);
        ClosestPoints { at: self.at(&arm), normal, height: dot(&arm, &normal), sound: self.is_sound(area) }
    }

    #[inline(always)]
    fn foot_on(&self, planes: Planes, point: &PackVector<R>, area: R) -> ClosestPoints<R> {
        let mut across = self.normal;
        for axis in planes.into_iter().flatten() {
            across[axis] = area.zero();
        }
        let size = dot(&across, &across).sqrt();
        let normal = each!(i in 3 => across[i] / size);
        let arm = each!(i in 3 => point[i] - self.centre[i]);
        let ([x, y], _) = self.at_along(&arm, &normal, planes);
        let (at, height) = self.at_along(&self.untwisted(&arm, x * y), &normal, planes);
        let sound = self.is_sound(area) & (area.splat_like(MIN_AREA_RATIO) * area).le(size);
        ClosestPoints { at, normal, height, sound }
    }

    /// Coordinates, on the edges that lie on planes, and height along a direction of what lies `arm` from the centre of a flat cell.
    #[inline(always)]
    fn at_along(&self, arm: &PackVector<R>, direction: &PackVector<R>, planes: Planes) -> ([R; 2], R) {
        let height = dot(arm, &self.normal) / dot(direction, &self.normal);
        let at = self.at(&each!(i in 3 => arm[i] - direction[i] * height));
        let half = height.splat_like(0.5);
        let on_edge = each!(i in 2 => R::select(at[i].lt(height.zero()), -half, half));
        (each!(i in 2 => if planes[i].is_some() { on_edge[i] } else { at[i] }), height)
    }

    /// Whether the cell is not folded.
    #[inline(always)]
    fn is_sound(&self, area: R) -> R::Mask {
        (area.splat_like(MIN_AREA_RATIO) * area).squared().le(self.square)
    }
}

/// The feet of points, where their cells are sound.
struct ClosestPoints<R: Real> {
    at: [R; 2],
    normal: PackVector<R>,
    height: R,
    sound: R::Mask,
}

/// Mirror planes that a point lies on: by coordinate of the cell, one of whose edges lies on the plane then, the axis across it.
pub type Planes = [Option<usize>; 2];

/// Most points lie on none.
pub const NO_PLANES: Planes = [None; 2];

/// The foot of a point on the bilinear cell with these corners (counter-clockwise) [m]; `None` on a folded cell. Of a point on
/// mirror planes it lies on them: along the normal less what of it points across them. `area`: of the cell at rest [m²].
#[inline]
pub fn closest_point(
    corner: &[Vector3<f64>; 4],
    point: &Vector3<f64>,
    area: f64,
    planes: Planes,
) -> Option<ClosestPoint> {
    let cell = Surface::new(&corner.map(Into::into));
    let ClosestPoints { at, normal, height, sound } = cell.foot(&(*point).into(), area, planes);
    sound.then(|| ClosestPoint { at, normal: normal.into(), height })
}

/// Part of the room at an edge, and of the depth still clear, that points which certainly stand clear may use [-]: far from one by more
/// than rounding, and near enough to let few others through.
const CERTAINLY_CLEAR: f64 = 0.999;

/// Whether points, all of them on these planes, certainly stand over their cells, and there no deeper than `slop` [m] in touch, as
/// [`closest_point`] and [`is_over`] see each of them: for many at once. `sign`, `touching` as in [`is_apart`].
#[inline(always)]
pub(crate) fn stands_clear<R: Real>(
    corner: &[PackVector<R>; 4],
    point: &PackVector<R>,
    [sign, touching, slop]: [f64; 3],
    area: R,
    planes: Planes,
) -> R::Mask {
    let cell = Surface::new(corner);
    let (sign, least) = (area.splat_like(sign), area.splat_like(touching - CERTAINLY_CLEAR * slop));
    if planes == NO_PLANES {
        // Everything over the square of the normal, but for the place in the first guess: divisions are dear.
        let room = area.splat_like(0.5 + CERTAINLY_CLEAR * EDGE) * cell.square;
        let arm = each!(i in 3 => point[i] - cell.centre[i]);
        let [x, y] = cell.scaled_at(&arm);
        let part = area.splat_like(1.0) / cell.square;
        let arm = cell.untwisted(&arm, (x * part) * (y * part));
        let [x, y] = cell.scaled_at(&arm);
        let height = sign * dot(&arm, &cell.normal);
        let over = (-room).le(x) & x.le(room) & (-room).le(y) & y.le(room);
        return cell.is_sound(area) & over & (least * cell.square.sqrt()).le(height);
    }
    let ClosestPoints { at: [x, y], height, sound, .. } = cell.foot_on(planes, point, area);
    let room = x.splat_like(0.5 + CERTAINLY_CLEAR * EDGE);
    sound & (-room).le(x) & x.le(room) & (-room).le(y) & y.le(room) & least.le(sign * height)
}

/// Weights of the corners at a place in a cell; they add up to 1.
#[inline]
pub fn weights([x, y]: [f64; 2]) -> [f64; 4] {
    let [x, y] = [x.clamp(-0.5, 0.5), y.clamp(-0.5, 0.5)];
    [(0.5 - x) * (0.5 - y), (0.5 + x) * (0.5 - y), (0.5 + x) * (0.5 + y), (0.5 - x) * (0.5 + y)]
}

/// The neighbouring cell a foot lies towards; itself where it is over the cell or beyond the ply's edge.
#[inline]
pub fn next_cell([row, column]: [usize; 2], at: [f64; 2], rows: usize, columns: usize) -> [usize; 2] {
    let step = |index: usize, x: f64, count: usize| {
        if x > 0.5 + EDGE {
            (index + 1).min(count - 1)
        } else if x < -0.5 - EDGE {
            index.saturating_sub(1)
        } else {
            index
        }
    };
    [step(row, at[1], rows), step(column, at[0], columns)]
}

/// Whether a cell of a ply of `rows` and `columns` carries a node with this foot. An outermost cell carries it a little
/// beyond the ply's edge, but not where mirror planes `cut` X, Y: there the ply goes on.
#[inline]
pub fn is_over(at: [f64; 2], [row, column]: [usize; 2], rows: usize, columns: usize, cut: [Cut; 2]) -> bool {
    let room = |outermost: bool| 0.5 + if outermost { SEGMENT_EXTENSION } else { EDGE };
    let within = |x: f64, index: usize, count: usize, cut: Cut| {
        -room(index == 0 && cut != Cut::First) <= x && x <= room(index + 1 == count && cut != Cut::Last)
    };
    within(at[0], column, columns, cut[0]) && within(at[1], row, rows, cut[1])
}

/// The place on the edges of a cell that is nearest to a point beyond them: from there to the point [m], and its coordinates
/// within the cell. `at`: foot of the point.
#[inline]
pub fn on_edge(corner: &[Vector3<f64>; 4], point: &Vector3<f64>, at: [f64; 2]) -> (Vector3<f64>, [f64; 2]) {
    let [a, b, c, d] = corner;
    let edge = |axis: usize| {
        let fixed = at[axis].clamp(-0.5, 0.5);
        let between = |p: &Vector3<f64>, q: &Vector3<f64>| p + (q - p) * (fixed + 0.5);
        let [first, last] = if axis == 0 { [between(a, b), between(d, c)] } else { [between(a, d), between(b, c)] };
        let along = last - first;
        let part = ((point - first).dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        let place = if axis == 0 { [fixed, part - 0.5] } else { [part - 0.5, fixed] };
        (point - (first + along * part), place)
    };
    match at.map(|x| x.abs() > 0.5) {
        [true, true] => {
            let [first, second] = [edge(0), edge(1)];
            if second.0.norm_squared() < first.0.norm_squared() { second } else { first }
        }
        [false, true] => edge(1),
        _ => edge(0),
    }
}

/// Least velocity along the push with which a node may leave the step, from its gap [m] to the surface [m/s].
#[inline]
pub fn closing_limit(gap: f64, dt: f64) -> f64 {
    -gap.max(0.0) / dt
}

/// Speed at which a node is moved out of a surface, beyond what its own velocity `along` the push does [m/s]. It moves the
/// node but is no part of its velocity, so that driving a penetration out gives nothing back of what the impact lost.
/// `thickness` of the fabric [m].
#[inline]
pub fn recovery(gap: f64, thickness: f64, along: f64, dt: f64) -> f64 {
    let depth = -gap - SLOP * thickness;
    let deep = (depth - DEEP * thickness).max(0.0);
    let fastest = if depth < PASSED * thickness {
        RECOVERY_SPEED * (1.0 + DEEP_SPEED * (depth / thickness - NEAR_MIDDLE).max(0.0))
    } else {
        PASSED_SPEED
    };
    ((depth * (POSITION_CORRECTION / dt).min(1.0 / RECOVERY_TIME) + DEEP_RECOVERY * deep / dt).min(fastest)
        - along.max(0.0))
    .max(0.0)
}

/// Impulse of one contact on its node [N·s]: along the push and across it.
///
/// `velocity` of the node relative to the surface [m/s], `push` the unit vector along which the node is driven out,
/// `limit` the least velocity along it, `effective_mass` the inertia the contact meets [kg].
#[inline]
pub fn impulse(
    velocity: &Vector3<f64>,
    push: &Vector3<f64>,
    limit: f64,
    effective_mass: f64,
    friction: f64,
) -> (f64, Vector3<f64>) {
    let along = velocity.dot(push);
    let normal = (effective_mass * (limit - along)).max(0.0);
    let slide = velocity - push * along;
    let stick = slide * -effective_mass;
    let most = friction * normal;
    let size = stick.norm();
    (normal, if size > most { stick * (most / size) } else { stick })
}
