//! Projectile surfaces: gap and outward normal of a point near an analytic body.
//!
//! Every body is a convex profile (ρ, s) around its axis, shrunk by the edge radius and grown again, so that one
//! kernel covers cylinder, sphere and cone with rounded edges. A bar lying in the fabric's plane is the same with
//! ρ measured across it. s runs along the body axis towards the nose, from the centre of mass.

use crate::case::{Projectile, Shape};
use crate::number::{Mask, Real};

/// Most corners a profile has.
pub const CORNERS: usize = 5;

/// A convex profile; corners run from the nose on the axis to the tail on the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile<R> {
    /// (ρ, s) of each corner [m]; the first `count` are used.
    pub corner: [[R; 2]; CORNERS],
    /// Unit outward normal (ρ, s) of the side from corner i to i + 1.
    pub normal: [[R; 2]; CORNERS],
    /// Corners used, at least 1.
    pub count: usize,
    /// Rounding [m].
    pub radius: R,
    /// True for a bar: ρ is measured along the body's x axis alone.
    pub bar: bool,
}

/// Gap to a surface and its outward normal in the body's frame.
#[derive(Clone, Copy, Debug)]
pub struct Gap<R> {
    /// Distance to the surface, negative inside [m].
    pub distance: R,
    /// Outward unit normal at the nearest surface point, body frame.
    pub normal: [R; 3],
}

/// Gap of a point given in the body's frame [m]: x, y across the axis, z along it towards the nose.
#[inline(always)]
pub fn gap<R: Real>(profile: &Profile<R>, point: [R; 3]) -> Gap<R> {
    let zero = R::zero();
    let one = R::one();
    let tiny = R::splat(1e-30);
    let across = if profile.bar { point[0].squared() } else { point[0].squared() + point[1].squared() };
    let rho = across.sqrt();
    let s = point[2];
    // Nearest point over the sides; inside is where no side is crossed.
    let mut best = R::splat(1e30);
    let mut normal = [zero, one];
    let mut offset = [zero, zero];
    let mut deepest = R::splat(-1e30);
    let mut deepest_normal = [zero, one];
    let sides = profile.count.saturating_sub(1).max(1);
    for i in 0..sides {
        let a = profile.corner[i];
        let b = profile.corner[(i + 1).min(profile.count - 1)];
        let edge = [b[0] - a[0], b[1] - a[1]];
        let from = [rho - a[0], s - a[1]];
        let length = (edge[0].squared() + edge[1].squared()).max(tiny);
        let along = ((from[0] * edge[0] + from[1] * edge[1]) / length).max(zero).min(one);
        let away = [from[0] - along * edge[0], from[1] - along * edge[1]];
        let square = away[0].squared() + away[1].squared();
        let closer = square.lt(best);
        best = R::select(closer, square, best);
        let n = profile.normal[i];
        normal = [R::select(closer, n[0], normal[0]), R::select(closer, n[1], normal[1])];
        offset = [R::select(closer, away[0], offset[0]), R::select(closer, away[1], offset[1])];
        let height = from[0] * n[0] + from[1] * n[1];
        let deeper = deepest.lt(height);
        deepest = R::select(deeper, height, deepest);
        deepest_normal = [R::select(deeper, n[0], deepest_normal[0]), R::select(deeper, n[1], deepest_normal[1])];
    }
    let solid = R::Mask::splat(profile.count > 1);
    let inside = solid & deepest.le(zero);
    let distance = best.sqrt();
    // On the surface itself the direction to it is noise: the side's own normal holds.
    let resolved = R::splat(1e-12).lt(distance);
    let safe = R::select(resolved, distance, one);
    let outside = [R::select(resolved, offset[0] / safe, normal[0]), R::select(resolved, offset[1] / safe, normal[1])];
    let n_rho = R::select(inside, deepest_normal[0], outside[0]);
    let n_s = R::select(inside, deepest_normal[1], outside[1]);
    let signed = R::select(inside, deepest, distance);
    let on_axis = rho.le(tiny);
    let safe_rho = R::select(on_axis, one, rho);
    let spread = R::select(on_axis, zero, n_rho / safe_rho);
    let y = if profile.bar { zero } else { spread * point[1] };
    Gap { distance: signed - profile.radius, normal: [spread * point[0], y, n_s] }
}

/// The gap that contact acts on: [`gap`], except in the rim zone of a flat nose.
///
/// Elements are straight, so fabric drawn over a sharp rim cuts the corner: a node next to the face hangs behind the
/// rim instead of lying against it. Within `rim_depth` (one element length) behind the rim such a node is held
/// along the axis, as the fabric in front of it is, once it is inside the shadow of the face; its sideways
/// penetration is measured and reported. Measured on the 155 m/s shot this halves the spread over sub-cell hit
/// positions and brings velocities to those of finer contact sampling (benches/NOTES.md).
#[inline(always)]
pub fn holding_gap<R: Real>(profile: &Profile<R>, point: [R; 3], rim_depth: R) -> Gap<R> {
    let zero = R::zero();
    let g = gap(profile, point);
    let below = profile.corner[1][1] - point[2];
    let flat = R::Mask::splat(profile.is_flat());
    let zone = flat & zero.lt(below) & below.le(rim_depth);
    let inside = g.distance.lt(zero);
    Gap {
        distance: R::select(zone & !inside, R::splat(1e30), g.distance),
        normal: [
            R::select(zone, zero, g.normal[0]),
            R::select(zone, zero, g.normal[1]),
            R::select(zone, R::one(), g.normal[2]),
        ],
    }
}

impl<R: Real> Profile<R> {
    /// Whether the nose is a flat face.
    pub fn is_flat(&self) -> bool {
        self.count > 2 && !self.normal[0][1].lt(R::one()).any()
    }
}

/// Body geometry and mass properties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Surface.
    pub profile: Profile<f64>,
    /// Moments of inertia about the axis and across it [kg·m²], uniform solid unless given.
    pub inertia: [f64; 2],
    /// Largest radius [m].
    pub radius: f64,
    /// Largest distance of the surface from the centre of mass [m].
    pub reach: f64,
}

/// Why a profile cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the edge radius does not fit into the shape")]
pub struct EdgeRadiusTooLarge;

impl Body {
    /// Surface and mass properties of a projectile.
    ///
    /// # Errors
    /// When the edge radius is larger than the shape allows.
    pub fn new(projectile: &Projectile) -> Result<Self, EdgeRadiusTooLarge> {
        let m = projectile.mass;
        let (outline, radius, uniform) = match projectile.shape {
            Shape::Sphere { diameter } | Shape::Bar { diameter, .. } => {
                let r = 0.5 * diameter;
                (vec![[0.0, 0.0]], r, [0.4 * m * r * r; 2])
            }
            Shape::Cylinder { diameter, length } => {
                let (r, half) = (0.5 * diameter, 0.5 * length);
                let across = m * (r * r / 4.0 + length * length / 12.0);
                let outline = vec![[0.0, half], [r, half], [r, -half], [0.0, -half]];
                (outline, projectile.edge_radius, [0.5 * m * r * r, across])
            }
            Shape::Cone { diameter, length, nose_length } => cone(0.5 * diameter, length, nose_length, m, projectile),
        };
        let profile = profile(&outline, radius, matches!(projectile.shape, Shape::Bar { .. }))?;
        let corners = &profile.corner[..profile.count];
        let widest = corners.iter().map(|c| c[0]).fold(0.0, f64::max) + radius;
        let reach = corners.iter().map(|c| c[0].hypot(c[1])).fold(0.0, f64::max) + radius;
        Ok(Self { profile, inertia: projectile.inertia.unwrap_or(uniform), radius: widest, reach })
    }

    /// Distance from the centre of mass to the supporting plane in a direction at `angle` from the body axis [m].
    pub fn support(&self, angle: f64) -> f64 {
        let corners = self.profile.corner[..self.profile.count].iter();
        let furthest = corners.map(|c| c[1] * angle.cos() + c[0] * angle.sin().abs()).fold(f64::MIN, f64::max);
        furthest + self.profile.radius
    }
}

/// Outline, rounding and inertia of a cone on a cylinder, with s from the centre of mass.
fn cone(r: f64, length: f64, nose: f64, mass: f64, p: &Projectile) -> (Vec<[f64; 2]>, f64, [f64; 2]) {
    let shank = length - nose;
    let (cone_volume, shank_volume) = (nose / 3.0, shank);
    let total = cone_volume + shank_volume;
    // Heights above the tail of each part's centre and of the whole's.
    let (cone_centre, shank_centre) = (shank + nose / 4.0, shank / 2.0);
    let centre = (cone_volume * cone_centre + shank_volume * shank_centre) / total;
    let (cone_mass, shank_mass) = (mass * cone_volume / total, mass * shank_volume / total);
    let axial = 0.3 * cone_mass * r * r + 0.5 * shank_mass * r * r;
    let across = cone_mass * (3.0 / 20.0 * r * r + 3.0 / 80.0 * nose * nose + (cone_centre - centre).powi(2))
        + shank_mass * (r * r / 4.0 + shank * shank / 12.0 + (shank_centre - centre).powi(2));
    let mut outline = vec![[0.0, length - centre], [r, shank - centre], [r, -centre], [0.0, -centre]];
    if shank <= 0.0 {
        outline.remove(2);
    }
    (outline, p.edge_radius, [axial, across])
}

/// The outline shrunk by `radius` so that growing it again rounds every corner by that radius.
fn profile(outline: &[[f64; 2]], radius: f64, bar: bool) -> Result<Profile<f64>, EdgeRadiusTooLarge> {
    let mut corner = [[0.0; 2]; CORNERS];
    let mut normal = [[0.0, 1.0]; CORNERS];
    let count = outline.len();
    if count == 1 {
        corner[0] = outline[0];
        return Ok(Profile { corner, normal, count, radius, bar });
    }
    for (i, pair) in outline.windows(2).enumerate() {
        let edge = [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]];
        let length = edge[0].hypot(edge[1]);
        // Nose to tail keeps the body on the right, the outside on the left… of (ρ, s): rotate by +90°.
        normal[i] = [-edge[1] / length, edge[0] / length];
    }
    // Each corner moves to where its two shifted sides meet; the ends stay on the axis, whose mirror side is the other.
    for (i, point) in outline.iter().enumerate() {
        let after = normal[i.min(count - 2)];
        let before = if i == 0 { [-after[0], after[1]] } else { normal[i - 1] };
        let after = if i == count - 1 { [-before[0], before[1]] } else { after };
        let cosine = before[0] * after[0] + before[1] * after[1];
        let shift = radius / (1.0 + cosine);
        corner[i] = [point[0] - shift * (before[0] + after[0]), point[1] - shift * (before[1] + after[1])];
    }
    for i in 0..count - 1 {
        let old = [outline[i + 1][0] - outline[i][0], outline[i + 1][1] - outline[i][1]];
        let new = [corner[i + 1][0] - corner[i][0], corner[i + 1][1] - corner[i][1]];
        if old[0] * new[0] + old[1] * new[1] < 0.0 {
            return Err(EdgeRadiusTooLarge);
        }
    }
    Ok(Profile { corner, normal, count, radius, bar })
}

#[cfg(test)]
#[path = "projectile_shape_tests.rs"]
mod tests;
