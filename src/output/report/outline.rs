//! The surface of a projectile as rings of points, for drawing.

use crate::kernels::projectile_shape::{Body, gap};

/// Points of a ring.
pub(super) const AROUND: usize = 32;
/// Rings from nose to tail.
pub(super) const ALONG: usize = 28;

/// Rings of points in the axes of the body [m], nose first, [`AROUND`] points each.
pub(super) type Outline = Vec<[f32; 3]>;

/// The surface of a body; of a bar so much on either side of its middle [m].
pub(super) fn outline(body: &Body, half_width: f64) -> Outline {
    let (nose, tail) = (body.support([0.0, 0.0, 1.0]), -body.support([0.0, 0.0, -1.0]));
    let mut points = Vec::with_capacity(AROUND * ALONG);
    for ring in 0..ALONG {
        // Dense at both ends, where rims and tips are.
        let share = 0.5 - 0.5 * (std::f64::consts::PI * ring as f64 / (ALONG - 1) as f64).cos();
        let s = nose + (tail - nose) * share;
        for n in 0..AROUND {
            let angle = std::f64::consts::TAU * n as f64 / AROUND as f64;
            points.push(point(body, s, angle, half_width).map(|x| x as f32));
        }
    }
    points
}

fn point(body: &Body, s: f64, angle: f64, half_width: f64) -> [f64; 3] {
    let (sine, cosine) = angle.sin_cos();
    if body.profile.bar {
        // Half of the ring at either end.
        let across = radius(body, s, [1.0, 0.0]);
        return [across * cosine.signum(), half_width * sine.signum(), s];
    }
    let radius = radius(body, s, [cosine, sine]);
    [radius * cosine, radius * sine, s]
}

/// Distance from the axis to the surface at height `s`, in a direction across the axis, by bisection [m].
fn radius(body: &Body, s: f64, [x, y]: [f64; 2]) -> f64 {
    let inside = |radius: f64| gap(&body.profile, [radius * x, radius * y, s]).distance <= 1e-9 * body.reach;
    let (mut low, mut high) = (0.0, body.reach);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if inside(middle) { low = middle } else { high = middle }
    }
    low
}
