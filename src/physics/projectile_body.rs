//! Projectile bodies: from the shape of a case to its surface around the centre of mass, with inertia and extent.

use crate::case::{Projectile, Shape};
use crate::num::solid::ogive_arc;
use crate::physics::projectile_shape::{CORNERS, Chisel, Outline};

/// Body geometry and mass properties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Surface.
    pub profile: Outline,
    /// Moments of inertia about the body's x, y and z axes [kg·m²]: a uniform solid with sharp edges unless given.
    pub inertia: [f64; 3],
    /// Largest radius [m].
    pub radius: f64,
    /// Largest distance of the surface from the centre of mass [m].
    pub bounding_radius: f64,
}

impl Body {
    /// Surface and mass properties of a projectile.
    /// `None`: the edge radius is larger than the shape allows.
    pub fn new(projectile: &Projectile) -> Option<Self> {
        let edge = projectile.edge_radius;
        let solid = projectile.shape.solid();
        let profile = match projectile.shape {
            Shape::Sphere { diameter } | Shape::Bar { diameter, .. } => {
                let bar = matches!(projectile.shape, Shape::Bar { .. });
                Outline { bar, ..polygon(&[[0.0, 0.0]], 0.5 * diameter)? }
            }
            Shape::Cylinder { diameter, length } => {
                polygon(&pointed(0.5 * diameter, length, length, solid.centre), edge)?
            }
            Shape::Cone { diameter, length, nose_length } => {
                polygon(&pointed(0.5 * diameter, length, length - nose_length, solid.centre), edge)?
            }
            Shape::Ogive { diameter, length, nose_length } => {
                ogive([0.5 * diameter, length - nose_length, nose_length], solid.centre, edge)?
            }
            Shape::Fragment { diameter, length, nose_flat, nose_angle, .. } => {
                let profile = polygon(&pointed(0.5 * diameter, length, length, solid.centre), edge)?;
                chisel(profile, 0.5 * nose_flat, nose_angle)?
            }
        };
        let corners = &profile.corner[..profile.count];
        let widest = corners.iter().map(|c| c[0]).fold(0.0, f64::max) + profile.radius;
        let reach = corners.iter().map(|c| c[0].hypot(c[1])).fold(0.0, f64::max) + profile.radius;
        let given = projectile.axial_inertia.zip(projectile.transverse_inertia);
        let given = given.map(|(axial, across)| [across, across, axial]);
        let inertia = given.unwrap_or_else(|| solid.inertia(projectile.mass));
        Some(Self { profile, inertia, radius: widest, bounding_radius: reach })
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
fn chisel_support(profile: &Outline, chisel: &Chisel, [x, y, along]: [f64; 3]) -> f64 {
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

/// Outline of a cone on a cylinder up to `shank`, with s from the centre of mass; without a cone it is a cylinder, without a shank there is one
/// corner less.
fn pointed(r: f64, length: f64, shank: f64, centre: f64) -> Vec<[f64; 2]> {
    let mut outline = vec![[0.0, length - centre], [r, shank - centre], [r, -centre], [0.0, -centre]];
    if shank <= 0.0 {
        outline.remove(2);
    }
    outline
}

/// The outline shrunk by `radius` so that growing it again rounds every corner by that radius.
fn polygon(outline: &[[f64; 2]], radius: f64) -> Option<Outline> {
    let mut corner = [[0.0; 2]; CORNERS];
    let mut normal = [[0.0, 1.0]; CORNERS];
    let count = outline.len();
    let plain = |corner, normal| Outline { corner, normal, count, radius, arc: 0.0, bar: false, chisel: None };
    if count == 1 {
        corner[0] = outline[0];
        return Some(plain(corner, normal));
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
            return None;
        }
    }
    Some(plain(corner, normal))
}

/// Profile of an ogive on a cylinder, shrunk by `radius`: arc and walls move inwards, centre and tangency stay.
fn ogive(size: [f64; 3], centre: f64, radius: f64) -> Option<Outline> {
    let [r, shank, nose] = size;
    let whole = ogive_arc(r, nose);
    let arc = whole - radius;
    // Of the arc's centre: the tip is where the arc meets the axis.
    let [inner, shoulder] = [r - whole, shank - centre];
    let back = radius - centre;
    let height = |rho: f64| ((arc - (rho - inner)) * (arc + (rho - inner))).max(0.0).sqrt();
    let tip = shoulder + height(0.0);
    if radius > r || tip < back {
        return None;
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
    Some(Outline { corner, normal, count, radius, arc, bar: false, chisel: None })
}

/// Cuts the flat nose of a shrunk cylinder to a chisel whose strip, before shrinking, has that half width.
fn chisel(cylinder: Outline, half: f64, angle: f64) -> Option<Outline> {
    let [radius, front] = cylinder.corner[1];
    let (sine, cosine) = angle.sin_cos();
    let slope = sine / cosine;
    // Strip and flat both move in by the rounding, their edge along the line that halves their angle.
    let half = half - cylinder.radius * (0.5 * angle).tan();
    // Beyond the wall the flats cut nothing.
    let kept = half.min(radius);
    if half < 0.0 || front - (radius - kept) * slope < cylinder.corner[2][1] {
        return None;
    }
    let corner = ((radius - kept) * (radius + kept)).sqrt();
    Some(Outline { chisel: Some(Chisel { half: kept, sine, cosine, slope, corner }), ..cylinder })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

    use super::*;
    use crate::physics::projectile_shape::gap;
    use crate::physics::projectile_shape::tests::{Numbers, projectile};
    use crate::physics::rigid_body::RigidBody;

    const SHAPES: [Shape; 5] = [
        Shape::Cylinder { diameter: 6.0, length: 4.0 },
        Shape::Cone { diameter: 6.0, length: 8.0, nose_length: 5.0 },
        Shape::Ogive { diameter: 6.0, length: 8.0, nose_length: 6.0 },
        Shape::Fragment { diameter: 6.0, length: 7.0, nose_flat: 2.8, nose_angle: 0.611, roll: 0.4 },
        Shape::Fragment { diameter: 6.0, length: 7.0, nose_flat: 1.0, nose_angle: 1.0, roll: -2.0 },
    ];

    /// Height of the centre, and second moments of what lies inside, by counting cells in a quarter of the body.
    fn count(body: &Body) -> (f64, [f64; 3]) {
        const CELL: [f64; 3] = [0.08, 0.08, 0.02];
        let (mut cells, mut first, mut second) = (0.0, 0.0, [0.0; 3]);
        for i in 0..38 {
            for j in 0..38 {
                for k in -300..300 {
                    let point = [0, 1, 2].map(|a| (f64::from([i, j, k][a]) + 0.5) * CELL[a]);
                    if gap(&body.profile, point).distance < 0.0 {
                        cells += 1.0;
                        first += point[2];
                        for a in 0..3 {
                            second[a] += point[a] * point[a];
                        }
                    }
                }
            }
        }
        (first / cells, second.map(|x| x / cells))
    }

    #[test]
    fn inertia_is_that_of_the_solid_and_the_origin_its_centre_of_mass() {
        for shape in SHAPES {
            let body = Body::new(&projectile(shape, 0.0)).unwrap();
            let (centre, [x, y, z]) = count(&body);
            assert!(centre.abs() < 1e-2, "{shape:?}: {centre:?}");
            let mass = projectile(shape, 0.0).mass;
            for (got, expected) in body.inertia.into_iter().zip([y + z, x + z, x + y]) {
                assert!((got / (mass * expected) - 1.0).abs() < 4e-3, "{shape:?}: {got} for {}", mass * expected);
            }
        }
    }

    #[test]
    fn reach_and_radius_hold_the_whole_body() {
        for shape in SHAPES {
            for edge in [0.0, 0.3] {
                let body = Body::new(&projectile(shape, edge)).unwrap();
                let mut numbers = Numbers(2);
                let mut furthest = 0.0_f64;
                for _ in 0..5000 {
                    let d = numbers.point();
                    let size = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                    let support = body.support(d.map(|x| x / size));
                    assert!(support <= body.bounding_radius + 1e-12, "{shape:?}");
                    furthest = furthest.max(support);
                }
                assert!(furthest > 0.99 * body.bounding_radius, "{shape:?}: {furthest} of {}", body.bounding_radius);
                let sideways = body.support([0.6, 0.8, 0.0]);
                assert!((sideways - body.radius).abs() < 1e-12 && (body.radius - 3.0).abs() < 1e-12, "{shape:?}");
            }
        }
    }

    /// Least value of a convex function of a number.
    fn least(f: impl Fn(f64) -> f64) -> f64 {
        let (mut low, mut high) = (-40.0, 40.0);
        for _ in 0..90 {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if f(a) < f(b) { high = b } else { low = a }
        }
        f(0.5 * (low + high))
    }

    #[test]
    fn every_shape_starts_at_its_standoff() {
        let mut numbers = Numbers(4);
        for shape in SHAPES {
            for edge in [0.0, 0.3] {
                let mut p = projectile(shape, edge);
                let turn = numbers.next();
                if let Shape::Fragment { roll, .. } = &mut p.shape {
                    *roll = turn;
                }
                p.standoff = 0.7;
                p.obliquity = 0.1 * numbers.next().abs();
                (p.azimuth, p.yaw) = (numbers.next(), 0.3 * numbers.next());
                let body = RigidBody::new(&p, Body::new(&p).unwrap(), 1.0);
                // The gap is convex in the plane of the fabric, and so is its least value along a line of it.
                let over =
                    |x: f64, y: f64| body.gap(&nalgebra::Vector3::new(x + body.position.x, y + body.position.y, 0.0)).0;
                let nearest = least(|x| least(|y| over(x, y)));
                assert!((nearest - 0.7).abs() < 1e-9, "{p:?}: {nearest}");
            }
        }
    }

    #[test]
    fn roll_turns_the_edge_of_a_chisel_from_warp_towards_weft() {
        let shape = Shape::Fragment { diameter: 6.0, length: 7.0, nose_flat: 2.8, nose_angle: 0.611, roll: 0.5 };
        let p = projectile(shape, 0.0);
        let body = RigidBody::new(&p, Body::new(&p).unwrap(), 1.0);
        let top = body.position.z + body.body.profile.corner[1][1];
        let gap = |x: f64, y: f64| body.gap(&nalgebra::Vector3::new(x, y, top)).0;
        let (sine, cosine) = 0.5_f64.sin_cos();
        assert!(gap(2.5 * cosine, 2.5 * sine).abs() < 1e-12, "along the strip the plane touches");
        assert!(gap(-2.5 * sine, 2.5 * cosine) > 0.5, "across it the flats fall off");
    }

    #[test]
    fn only_a_flat_face_has_a_round_rim() {
        let rim = |shape| Body::new(&projectile(shape, 0.0)).unwrap().profile.has_round_rim();
        assert_eq!(SHAPES.map(rim), [true, false, false, false, false]);
        assert!(!rim(Shape::Sphere { diameter: 6.0 }));
        assert!(!rim(Shape::Bar { diameter: 6.0, along: crate::case::Along::Weft }));
    }

    /// A body of revolution or a bar, with every corner rounded by `edge`.
    fn body(shape: Shape, edge: f64) -> Body {
        Body::new(&projectile(shape, edge)).unwrap()
    }

    #[test]
    fn a_plane_through_the_nearest_point_parts_point_and_body() {
        // To rounding: the body lies behind its supporting plane along the normal, and the point that far in front of it.
        let more = [
            (Shape::Sphere { diameter: 6.0 }, 0.0),
            (Shape::Bar { diameter: 6.0, along: crate::case::Along::Warp }, 0.0),
            (Shape::Cone { diameter: 6.0, length: 5.0, nose_length: 5.0 }, 0.0),
            (Shape::Cone { diameter: 6.0, length: 5.0, nose_length: 5.0 }, 0.4),
            (Shape::Ogive { diameter: 6.0, length: 9.0, nose_length: 9.0 }, 0.0),
            (Shape::Ogive { diameter: 6.0, length: 9.0, nose_length: 9.0 }, 0.4),
            (Shape::Ogive { diameter: 6.0, length: 7.0, nose_length: 3.0 }, 0.0),
        ];
        let mut numbers = Numbers(31);
        for (shape, edge) in SHAPES.into_iter().flat_map(|shape| [(shape, 0.0), (shape, 0.3)]).chain(more) {
            let body = body(shape, edge);
            let points = (0..2000).map(|_| numbers.point()).chain([[0.0, 0.0, 7.3], [0.0, 0.0, -7.3]]);
            for point in points.collect::<Vec<_>>() {
                let g = gap(&body.profile, point);
                let along = |d: [f64; 3]| g.normal[0] * d[0] + g.normal[1] * d[1] + g.normal[2] * d[2];
                assert!((along(g.normal) - 1.0).abs() < 1e-12, "{shape:?} {point:?}: {g:?}");
                let apart = along(point) - body.support(g.normal);
                assert!((apart - g.distance).abs() < 1e-11, "{shape:?} {edge} {point:?}: {g:?} for {apart}");
            }
        }
    }

    #[test]
    fn a_line_crosses_the_cylinder_through_the_rim_where_it_is_as_far_from_the_axis() {
        let profile = body(Shape::Cylinder { diameter: 6.0, length: 9.0 }, 0.0).profile;
        let mut numbers = Numbers(33);
        let mut seen = [0; 3];
        for _ in 0..2000 {
            let (from, to) = (numbers.point(), numbers.point());
            let far = |part: f64| {
                let [x, y] = [0, 1].map(|a: usize| from[a] + part * (to[a] - from[a]));
                x.hypot(y) - 3.0
            };
            let found = profile.rim_crossings(from, to);
            let crossings: Vec<f64> = found.into_iter().filter(|at| !at.is_nan()).collect();
            assert!(crossings.iter().all(|at| (0.0..1.0).contains(at) && far(*at).abs() < 1e-9), "{from:?} {to:?}");
            // Inside between two of them, and nowhere else.
            let ends = [[0.0].as_slice(), crossings.as_slice(), &[1.0]].concat();
            for (i, pair) in ends.windows(2).enumerate() {
                assert!(pair[0] <= pair[1], "{found:?}");
                let inside = far(0.5 * (pair[0] + pair[1])) < 0.0;
                let begins_inside = far(0.0) < 0.0;
                assert_eq!(inside, begins_inside == (i % 2 == 0), "{from:?} {to:?}: {found:?}");
            }
            seen[crossings.len()] += 1;
        }
        assert!(seen.iter().all(|count| *count > 100), "{seen:?}");
        for edge in [0.0, 0.3] {
            let body = body(Shape::Cylinder { diameter: 6.0, length: 9.0 }, edge);
            assert!(
                (body.profile.height_over_face([1.0, 2.0, 5.0]) - 0.5).abs() < 1e-14,
                "4.5 from the centre of mass"
            );
        }
    }
}
