//! Uniform solids of simple shape: volume, centre and second moments, put together part by part.

use std::f64::consts::PI;

/// Intervals of Simpson's rule for the integrals over an ogive: relative errors below 1e-10.
const INTERVALS: usize = 1000;

/// Volume of a solid and its moments; heights are along the axis, from its tail.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Solid {
    /// [m³]
    pub(crate) volume: f64,
    /// Height of its centre [m].
    pub(crate) centre: f64,
    /// Means of x², y² and of the squared height over the centre [m²].
    pub(crate) squared: [f64; 3],
}

impl Solid {
    pub(crate) fn sphere(r: f64) -> Self {
        Self { volume: 4.0 / 3.0 * PI * r.powi(3), centre: 0.0, squared: [0.2 * r * r; 3] }
    }

    pub(crate) fn cylinder(r: f64, length: f64) -> Self {
        let across = r * r / 4.0;
        let squared = [across, across, length * length / 12.0];
        Self { volume: PI * r * r * length, centre: 0.5 * length, squared }
    }

    pub(crate) fn cone(r: f64, length: f64) -> Self {
        let across = 3.0 / 20.0 * r * r;
        let squared = [across, across, 3.0 / 80.0 * length * length];
        Self { volume: PI * r * r * length / 3.0, centre: 0.25 * length, squared }
    }

    /// A tangent ogive: slices ρ(s) of a tangent ogive added up by Simpson's rule over s = length · sin ψ, in which they are smooth.
    pub(crate) fn ogive(r: f64, length: f64) -> Self {
        let arc = ogive_arc(r, length);
        let mut sums = [0.0; 4];
        for i in 0..=INTERVALS {
            let (sine, cosine) = (0.5 * PI * i as f64 / INTERVALS as f64).sin_cos();
            let s = length * sine;
            let square = (r - s * s / (arc + (arc * arc - s * s).max(0.0).sqrt())).max(0.0).powi(2);
            let ends = i == 0 || i == INTERVALS;
            let weight = if ends { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 } / (3 * INTERVALS) as f64;
            let area = PI * square * 0.5 * PI * length * cosine * weight;
            for (sum, of) in sums.iter_mut().zip([1.0, s, s * s, 0.25 * square]) {
                *sum += area * of;
            }
        }
        let [volume, first, second, across] = sums;
        Self::from_sums(volume, first, [across, across, second])
    }

    /// A chisel-nosed cylinder: less the two wedges that slanted flats cut from it.
    pub(crate) fn chisel(r: f64, length: f64, half: f64, angle: f64) -> Self {
        let slope = angle.tan();
        let chord = (r * r - half * half).max(0.0).sqrt();
        // k[n] = ∫ yⁿ · chord(y) dy from `half` to r, by parts.
        let mut k = [0.0; 6];
        k[0] = r * r * (chord / r).clamp(0.0, 1.0).asin() - half * chord;
        k[1] = 2.0 / 3.0 * chord.powi(3);
        for n in 2..6 {
            let boundary = 2.0 * half.powi(n as i32 - 1) * chord.powi(3);
            k[n] = (boundary + (n - 1) as f64 * r * r * k[n - 2]) / (n + 2) as f64;
        }
        // Moments of both wedges, of depth (y − half) · slope below the front.
        let volume = 2.0 * slope * (k[1] - half * k[0]);
        let depth = slope * slope * (k[2] - half * (2.0 * k[1] - half * k[0]));
        let depth_squared =
            2.0 / 3.0 * slope.powi(3) * (k[3] - half * (3.0 * k[2] - half * (3.0 * k[1] - half * k[0])));
        let y_squared = 2.0 * slope * (k[3] - half * k[2]);
        // ∫ x² over a chord is its third power over twelve: (r² − y²) chord(y)/3.
        let x_moment = |n: usize| (r * r * k[n] - k[n + 2]) / 3.0;
        let x_squared = 2.0 * slope * (x_moment(1) - half * x_moment(0));
        let whole = PI * r * r * length;
        let across = whole * r * r / 4.0;
        let from_front = Self::from_sums(
            whole - volume,
            whole * 0.5 * length - depth,
            [across - x_squared, across - y_squared, whole * length * length / 3.0 - depth_squared],
        );
        Self { centre: length - from_front.centre, ..from_front }
    }

    /// From the integrals of 1, of the height, and of x², y² and the squared height.
    fn from_sums(volume: f64, first: f64, second: [f64; 3]) -> Self {
        let centre = first / volume;
        let [x, y, height] = second.map(|sum| sum / volume);
        Self { volume, centre, squared: [x, y, height - centre * centre] }
    }

    pub(crate) fn raised(self, by: f64) -> Self {
        Self { centre: self.centre + by, ..self }
    }

    pub(crate) fn with(self, other: Self) -> Self {
        let volume = self.volume + other.volume;
        let [mine, theirs] = [self.volume / volume, other.volume / volume];
        let apart = other.centre - self.centre;
        let mut squared = [0, 1, 2].map(|a| mine * self.squared[a] + theirs * other.squared[a]);
        squared[2] += mine * theirs * apart * apart;
        Self { volume, centre: self.centre + theirs * apart, squared }
    }

    /// Moments of inertia about x, y and z for a mass [kg].
    pub(crate) fn inertia(&self, mass: f64) -> [f64; 3] {
        let [x, y, z] = self.squared;
        [mass * (y + z), mass * (x + z), mass * (x + y)]
    }
}

/// Radius of the arc of a tangent ogive: r less its sagitta over the nose is nothing [m].
pub(crate) fn ogive_arc(r: f64, nose: f64) -> f64 {
    (r * r + nose * nose) / (2.0 * r)
}
