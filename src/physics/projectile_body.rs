//! Projectile bodies: from the shape of a case to its surface around the centre of mass, with inertia and extent.

use crate::case::{Projectile, Shape};
use crate::num::solid::ogive_arc;
use crate::physics::projectile_shape::Chisel;
use crate::physics::projectile_shape::{CORNERS, Outline};

/// Body geometry and mass properties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Surface.
    pub profile: Outline<f64>,
    /// Moments of inertia about the body's x, y and z axes [kg·m²]: a uniform solid with sharp edges unless given.
    pub inertia: [f64; 3],
    /// Largest radius [m].
    pub radius: f64,
    /// Largest distance of the surface from the centre of mass [m].
    pub bounding_radius: f64,
}

/// Reason why a profile cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the edge radius does not fit into the shape")]
pub struct EdgeRadiusTooLarge;

impl Body {
    /// Surface and mass properties of a projectile.
    ///
    /// # Errors
    /// When the edge radius is larger than the shape allows.
    pub fn new(projectile: &Projectile) -> Result<Self, EdgeRadiusTooLarge> {
        let edge = projectile.edge_radius;
        let solid = projectile.shape.solid();
        let profile = match projectile.shape {
            Shape::Sphere { diameter } | Shape::Bar { diameter, .. } => {
                let bar = matches!(projectile.shape, Shape::Bar { .. });
                Outline { bar, ..polygon(&[[0.0, 0.0]], 0.5 * diameter)? }
            }
            Shape::Cylinder { diameter, length } => polygon(&flat_ended(0.5 * diameter, length, solid.centre), edge)?,
            Shape::Cone { diameter, length, nose_length } => {
                polygon(&pointed(0.5 * diameter, length, length - nose_length, solid.centre), edge)?
            }
            Shape::Ogive { diameter, length, nose_length } => {
                ogive([0.5 * diameter, length - nose_length, nose_length], solid.centre, edge)?
            }
            Shape::Fragment { diameter, length, nose_flat, nose_angle, .. } => {
                let profile = polygon(&flat_ended(0.5 * diameter, length, solid.centre), edge)?;
                chisel(profile, 0.5 * nose_flat, nose_angle)?
            }
        };
        let corners = &profile.corner[..profile.count];
        let widest = corners.iter().map(|c| c[0]).fold(0.0, f64::max) + profile.radius;
        let reach = corners.iter().map(|c| c[0].hypot(c[1])).fold(0.0, f64::max) + profile.radius;
        let given = projectile.inertia.map(|[axial, across]| [across, across, axial]);
        let inertia = given.unwrap_or_else(|| solid.inertia(projectile.mass));
        Ok(Self { profile, inertia, radius: widest, bounding_radius: reach })
    }

    /// Distance from the centre of mass to the supporting plane in a direction of the body's frame, of length one [m].
    pub fn support(&self, direction: [f64; 3]) -> f64 {
        let p = &self.profile;
        let [x, y, along] = direction;
        let across = if p.bar { x.abs() } else { x.hypot(y) };
        let corners = p.corner[..p.count].iter().enumerate();
        // The front rim of a chisel is not all there.
        let corners = corners.filter(|(i, _)| p.chisel.is_none() || *i != 1);
        let mut furthest = corners.map(|(_, c)| c[1] * along + c[0] * across).fold(f64::MIN, f64::max);
        if p.arc > 0.0 {
            // Where the arc faces that way: between its normals at the tip and at its end.
            let (from, tip) = (p.normal[0], p.corner[0]);
            let centre = [tip[0] - p.arc * from[0], tip[1] - p.arc * from[1]];
            let to = [p.corner[1][0] - centre[0], p.corner[1][1] - centre[1]];
            if from[0] * along <= from[1] * across && to[1] * across <= to[0] * along {
                furthest = furthest.max(centre[0] * across + centre[1] * along + p.arc);
            }
        }
        if let Some(chisel) = &p.chisel {
            furthest = furthest.max(chisel_support(p, chisel, [x.abs(), y.abs(), along]));
        }
        furthest + p.radius
    }
}

/// Furthest point of a chisel's nose in a direction with x, y ≥ 0 [m].
fn chisel_support(profile: &Outline<f64>, chisel: &Chisel<f64>, [x, y, along]: [f64; 3]) -> f64 {
    let [radius, front] = profile.corner[1];
    let mut furthest = x * chisel.corner + y * chisel.half + along * front;
    // On the rim of the strip and on that of the flat, where the direction's part across the axis, which the slope of the
    // flat takes from, lies on that face.
    let steep = y - along * chisel.slope;
    for (y, on_flat, top) in [(y, false, front), (steep, true, front + chisel.half * chisel.slope)] {
        let size = x.hypot(y);
        let at = if size > 0.0 { radius * y / size } else { 0.0 };
        if (at > chisel.half) == on_flat {
            furthest = furthest.max(radius * size + along * top);
        }
    }
    furthest
}

/// Outline of a cylinder, with s from the centre of mass at that height over its end.
fn flat_ended(r: f64, length: f64, centre: f64) -> Vec<[f64; 2]> {
    vec![[0.0, length - centre], [r, length - centre], [r, -centre], [0.0, -centre]]
}

/// Outline of a cone on a cylinder; without a shank there is one corner less.
fn pointed(r: f64, length: f64, shank: f64, centre: f64) -> Vec<[f64; 2]> {
    let mut outline = vec![[0.0, length - centre], [r, shank - centre], [r, -centre], [0.0, -centre]];
    if shank <= 0.0 {
        outline.remove(2);
    }
    outline
}

/// The outline shrunk by `radius` so that growing it again rounds every corner by that radius.
fn polygon(outline: &[[f64; 2]], radius: f64) -> Result<Outline<f64>, EdgeRadiusTooLarge> {
    let mut corner = [[0.0; 2]; CORNERS];
    let mut normal = [[0.0, 1.0]; CORNERS];
    let count = outline.len();
    let plain = |corner, normal| Outline { corner, normal, count, radius, arc: 0.0, bar: false, chisel: None };
    if count == 1 {
        corner[0] = outline[0];
        return Ok(plain(corner, normal));
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
    Ok(plain(corner, normal))
}

/// Profile of an ogive on a cylinder, shrunk by `radius`: arc and walls move inwards, centre and tangency stay.
fn ogive(size: [f64; 3], centre: f64, radius: f64) -> Result<Outline<f64>, EdgeRadiusTooLarge> {
    let [r, shank, nose] = size;
    let whole = ogive_arc(r, nose);
    let arc = whole - radius;
    // Of the arc's centre: the tip is where the arc meets the axis.
    let [inner, shoulder] = [r - whole, shank - centre];
    let back = radius - centre;
    let height = |rho: f64| ((arc - (rho - inner)) * (arc + (rho - inner))).max(0.0).sqrt();
    let tip = shoulder + height(0.0);
    if radius > r || tip < back {
        return Err(EdgeRadiusTooLarge);
    }
    let mut corner = [[0.0, tip], [r - radius, shoulder], [r - radius, back], [0.0, back], [0.0; 2]];
    let steep = if arc > 0.0 { [-inner / arc, (tip - shoulder) / arc] } else { [0.0, 1.0] };
    let mut normal = [steep, [1.0, 0.0], [0.0, -1.0], [0.0, 1.0], [0.0, 1.0]];
    let mut count = 4;
    if shoulder <= back {
        // No wall is left: the arc ends on the back.
        let low = back - shoulder;
        corner[1] = [inner + ((arc - low) * (arc + low)).max(0.0).sqrt(), back];
        corner[2] = corner[3];
        normal[1] = normal[2];
        count = 3;
    }
    Ok(Outline { corner, normal, count, radius, arc, bar: false, chisel: None })
}

/// Cuts the flat nose of a shrunk cylinder to a chisel whose strip, before shrinking, has that half width.
fn chisel(cylinder: Outline<f64>, half: f64, angle: f64) -> Result<Outline<f64>, EdgeRadiusTooLarge> {
    let [radius, front] = cylinder.corner[1];
    let (sine, cosine) = angle.sin_cos();
    let slope = sine / cosine;
    // Strip and flat both move in by the rounding, their edge along the line that halves their angle.
    let half = half - cylinder.radius * (0.5 * angle).tan();
    // Beyond the wall the flats cut nothing.
    let kept = half.min(radius);
    if half < 0.0 || front - (radius - kept) * slope < cylinder.corner[2][1] {
        return Err(EdgeRadiusTooLarge);
    }
    let corner = ((radius - kept) * (radius + kept)).sqrt();
    Ok(Outline { chisel: Some(Chisel { half: kept, sine, cosine, slope, corner }), ..cylinder })
}

#[cfg(test)]
#[path = "projectile_body_tests.rs"]
mod tests;
