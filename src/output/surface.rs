//! The projectile's surface as a mesh, in the body's own axes.

use std::f64::consts::{FRAC_PI_2, TAU};

use serde::{Deserialize, Serialize};

use crate::physics::projectile_body::Body;
use crate::physics::projectile_shape::Outline;

/// Points around the axis.
const AROUND: usize = 48;
/// Points of an arc of the outline over a quarter turn.
const QUARTER: usize = 16;
/// Rings of points between the axis and the rim of a flat end.
const RINGS: usize = 12;

/// A surface of triangles and quads.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct SurfaceMesh {
    /// In the body's axes [m].
    pub(crate) points: Vec<[f64; 3]>,
    /// Corners of the faces, three or four each.
    pub(crate) faces: Vec<Vec<usize>>,
}

impl SurfaceMesh {
    /// The surface of a body; a bar reaches as far as the nodes of the pack it lies on [m].
    pub(crate) fn new<'a>(body: &Body, pack: impl Iterator<Item = &'a [f32; 3]>) -> Self {
        let profile = &body.profile;
        if profile.bar {
            let (radius, half) =
                (profile.radius, f64::from(pack.map(|at| at[0].abs().max(at[1].abs())).fold(0.0, f32::max)));
            let mut surface = Self::revolved(&[[0.0, half], [radius, half], [radius, -half], [0.0, -half]]);
            // Its axis is y.
            surface.points.iter_mut().for_each(|point| point.rotate_left(1));
            return surface;
        }
        let mut surface = Self::revolved(&outline(profile));
        if let Some(chisel) = &profile.chisel {
            // The flats cut what of the cylinder stands above them; strip and front are those before the rounding.
            let front = profile.corner[1][1] + profile.radius;
            let half = chisel.half + profile.radius * (0.5 * chisel.slope.atan()).tan();
            for [_, y, z] in &mut surface.points {
                *z = z.min(front - (y.abs() - half).max(0.0) * chisel.slope);
            }
        }
        surface
    }

    /// An outline (ρ, s) from the nose on the axis to the tail on the axis, turned about it.
    fn revolved(outline: &[[f64; 2]]) -> Self {
        let mut surface = Self::default();
        let on_axis = |rho: f64| rho < 1e-12;
        let mut rings = Vec::with_capacity(outline.len());
        for [rho, s] in outline {
            rings.push(surface.points.len());
            for n in 0..if on_axis(*rho) { 1 } else { AROUND } {
                let (sine, cosine) = (TAU * n as f64 / AROUND as f64).sin_cos();
                surface.points.push([rho * cosine, rho * sine, *s]);
            }
        }
        for (ring, pair) in rings.windows(2).zip(outline.windows(2)) {
            for n in 0..AROUND {
                let corner = |end: usize, n: usize| ring[end] + if on_axis(pair[end][0]) { 0 } else { n % AROUND };
                let mut face = vec![corner(0, n), corner(1, n), corner(1, n + 1), corner(0, n + 1)];
                face.dedup();
                if face.first() == face.last() {
                    face.pop();
                }
                if face.len() > 2 {
                    surface.faces.push(face);
                }
            }
        }
        surface
    }

    /// Corners of the faces cut into triangles.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [usize; 3]> {
        self.faces.iter().flat_map(|face| face[1..].windows(2).map(|pair| [face[0], pair[0], pair[1]]))
    }
}

/// The outline (ρ, s) with its roundings, from the nose on the axis to the tail on the axis.
fn outline(profile: &Outline) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = Vec::new();
    let mut facing = [0.0, 1.0];
    for i in 0..profile.count {
        let corner = profile.corner[i];
        let last = i + 1 == profile.count;
        let next = if last { [0.0, -1.0] } else { profile.normal[i] };
        turn(&mut points, corner, profile.radius, facing, next);
        facing = next;
        if last {
            break;
        }
        let to = profile.corner[i + 1];
        if i == 0 && profile.arc > 0.0 {
            let centre = [0, 1].map(|a| corner[a] - profile.arc * next[a]);
            let end = [0, 1].map(|a| (to[a] - centre[a]) / profile.arc);
            turn(&mut points, centre, profile.arc + profile.radius, next, end);
            facing = end;
        } else {
            let shift = |at: [f64; 2]| [0, 1].map(|a| at[a] + profile.radius * next[a]);
            divide(&mut points, shift(corner), shift(to), profile.chisel.is_some());
        }
    }
    points.dedup_by(|b, a| (b[0] - a[0]).hypot(b[1] - a[1]) < 1e-9);
    points
}

/// The points of an arc about `centre`, clockwise from one direction to another.
fn turn(points: &mut Vec<[f64; 2]>, centre: [f64; 2], radius: f64, from: [f64; 2], to: [f64; 2]) {
    // From the axis: directions turn from (0, 1) over (1, 0) to (0, −1).
    let [start, end] = [from, to].map(|d| d[0].max(0.0).atan2(d[1]));
    let count = ((end - start).abs() / FRAC_PI_2 * QUARTER as f64).ceil().max(1.0) as usize;
    for n in 0..=if radius > 0.0 { count } else { 0 } {
        let (sine, cosine) = (start + (end - start) * n as f64 / count as f64).sin_cos();
        points.push([(centre[0] + radius * sine).max(0.0), centre[1] + radius * cosine]);
    }
}

/// The points of a straight side; one that runs across the axis of a body with flats is divided, so that they can be cut from it.
fn divide(points: &mut Vec<[f64; 2]>, from: [f64; 2], to: [f64; 2], flats: bool) {
    let count = if flats && from[1] == to[1] { RINGS } else { 1 };
    for n in 0..=count {
        let part = n as f64 / count as f64;
        points.push([0, 1].map(|a| from[a] + part * (to[a] - from[a])));
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::f64::consts::PI;

    use super::*;

    /// Keys of a body 6 mm wide, and half the width of its tip and its tail along y [mm].
    const BODIES: [(&str, [f64; 2]); 6] = [
        (r#""shape": "cylinder", "length_mm": 14"#, [3.0, 3.0]),
        (r#""shape": "sphere""#, [0.0, 0.0]),
        (r#""shape": "cone", "length_mm": 14, "nose_length_mm": 8, "edge_radius_mm": 0"#, [0.0, 3.0]),
        (r#""shape": "ogive", "length_mm": 14, "nose_length_mm": 8, "edge_radius_mm": 0"#, [0.0, 3.0]),
        (r#""shape": "fragment", "length_mm": 14, "nose_flat_mm": 2.8, "nose_angle_deg": 35"#, [1.4, 3.0]),
        (r#""shape": "bar""#, [f64::NAN; 2]),
    ];

    #[test]
    fn a_surface_is_closed_around_the_centre_of_mass_and_as_large_as_the_body() {
        let pack = [[-0.015_f32, 0.0, 0.0], [0.0, 0.0125, 0.0]];
        for (shape, ends) in BODIES {
            let projectile = format!(r#"/projectile={{{shape}, "diameter_mm": 6, "mass_g": 1, "velocity_m_s": 300}}"#);
            let case = crate::case::shipped(&[&projectile, "/expect=[]"]);
            let Some(projectile) = case.projectile.as_ref() else { unreachable!("{shape}") };
            let Some(body) = Body::new(projectile) else { unreachable!("{shape}") };
            let surface = SurfaceMesh::new(&body, pack.iter());
            // A bar lies over the whole pack, 30 mm here.
            let volume = if body.profile.bar { PI * 9.0 * 30.0 } else { 1e9 * projectile.shape.volume() };
            let around =
                |face: &Vec<usize>| (0..face.len()).map(|n| (face[n], face[(n + 1) % face.len()])).collect::<Vec<_>>();
            let edges: Vec<(usize, usize)> = surface.faces.iter().flat_map(around).collect();
            let once: HashSet<(usize, usize)> = edges.iter().copied().collect();
            assert_eq!(once.len(), edges.len(), "{shape}: an edge belongs to two faces in one direction");
            assert!(edges.iter().all(|(a, b)| once.contains(&(*b, *a))), "{shape}: the surface is open");
            assert_eq!(edges.iter().map(|edge| edge.0).collect::<HashSet<_>>().len(), surface.points.len(), "{shape}");
            let (mut found, mut centroid) = (0.0, [0.0; 3]);
            for corners in surface.triangles() {
                let [a, b, c] = corners.map(|corner| surface.points[corner].map(|x| 1e3 * x));
                let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
                let part = (0..3).map(|axis| a[axis] * cross[axis]).sum::<f64>() / 6.0;
                found += part;
                (0..3).for_each(|axis| centroid[axis] += part * (a[axis] + b[axis] + c[axis]) / 4.0);
            }
            // Chords of the surface lie inside of it; faces that look inwards enclose less than nothing.
            assert!((0.985..1.0 + 1e-5).contains(&(found / volume)), "{shape}: {found} mm³, {volume}");
            assert!(centroid.iter().all(|x| (x / found).abs() < 0.03), "{shape}: centroid {centroid:?}");
            for (sign, end) in [1.0, -1.0].into_iter().zip(ends).filter(|(_, end)| !end.is_nan()) {
                let along = |point: &[f64; 3]| 1e3 * sign * point[2];
                let last = surface.points.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
                let there = surface.points.iter().filter(|point| along(point) > last - 1e-4);
                let width = there.map(|point| 1e3 * point[1].abs()).fold(0.0, f64::max);
                assert!((width - end).abs() < 0.1, "{shape}: end {sign} is {width} mm wide, half, expected {end}");
            }
        }
    }
}
