use std::collections::HashSet;
use std::f64::consts::PI;

use super::*;

/// Keys of a body 6 mm wide and 14 mm long, its volume [mm³], and half the width of its tip and its tail along y [mm].
fn bodies() -> Vec<(&'static str, f64, [f64; 2])> {
    let (r, long, nose) = (3.0_f64, 14.0, 8.0_f64);
    let disc = PI * r * r;
    // What a rounding of radius e takes from a square rim: its area, at its centroid's distance from the rim (Pappus).
    let e = 0.8;
    let rim = 2.0 * PI * (r - e * (10.0 - 3.0 * PI) / (12.0 - 3.0 * PI)) * (1.0 - PI / 4.0) * e * e;
    // A tangent ogive: an arc of radius a about a point so far off the axis.
    let a = (r * r + nose * nose) / (2.0 * r);
    let off = a - r;
    let bow = nose * (a * a - nose * nose).sqrt() + a * a * (nose / a).asin();
    let ogive = PI * (a * a * nose - nose.powi(3) / 3.0 + off * off * nose - off * bow);
    // What two flats of slope m take from a cylinder beside a strip of half-width h.
    let (h, m) = (1.4_f64, 35.0_f64.to_radians().tan());
    let segment = r * r * (h / r).acos() - h * (r * r - h * h).sqrt();
    let flats = 2.0 * m * (2.0 / 3.0 * (r * r - h * h).powf(1.5) - h * segment);
    vec![
        (r#""shape": "cylinder", "length_mm": 14"#, disc * long, [r, r]),
        (r#""shape": "cylinder", "length_mm": 14, "edge_radius_mm": 0.8"#, disc * long - 2.0 * rim, [r - e; 2]),
        (r#""shape": "sphere""#, 4.0 / 3.0 * disc * r, [0.0, 0.0]),
        (
            r#""shape": "cone", "length_mm": 14, "nose_length_mm": 8, "edge_radius_mm": 0"#,
            disc * (nose / 3.0 + 6.0),
            [0.0, r],
        ),
        (
            r#""shape": "ogive", "length_mm": 14, "nose_length_mm": 8, "edge_radius_mm": 0"#,
            ogive + disc * 6.0,
            [0.0, r],
        ),
        (r#""shape": "fsp", "length_mm": 14, "nose_flat_mm": 2.8, "nose_angle_deg": 35"#, disc * long - flats, [h, r]),
        // A bar lies over the whole pack, 30 mm here.
        (r#""shape": "bar""#, disc * 30.0, [f64::NAN; 2]),
    ]
}

#[test]
fn a_surface_is_closed_around_the_centre_of_mass_and_as_large_as_the_body() {
    let pack = [[-0.015_f32, 0.0, 0.0], [0.0, 0.0125, 0.0]];
    for (shape, volume, ends) in bodies() {
        let projectile = format!(r#"/projectile={{{shape}, "diameter_mm": 6, "mass_g": 1, "velocity_m_s": 300}}"#);
        let case = crate::case::shipped(&[&projectile, "/expect=[]"]);
        let body = case.projectile.as_ref().and_then(Body::new);
        let surface = SurfaceMesh::new(&body.unwrap_or_else(|| unreachable!("{shape}")), pack.iter());
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
