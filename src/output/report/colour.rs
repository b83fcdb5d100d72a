//! The colours of tension: one perceptually even scale for maps, playback and legend.

use std::fmt::Write;

/// Colour of a share of the largest value.
pub(super) fn colour(share: f64) -> [u8; 3] {
    let colorous::Color { r, g, b } = colorous::VIRIDIS.eval_continuous(share.clamp(0.0, 1.0));
    [r, g, b]
}

/// All of them in 256 steps.
pub(super) fn table() -> Vec<u8> {
    (0..256).flat_map(|n| colour(f64::from(n) / 255.0)).collect()
}

/// As a gradient of a style ply type, from left to right.
pub(super) fn gradient() -> String {
    let mut out = "linear-gradient(to right".to_owned();
    for n in 0..=16 {
        let [r, g, b] = colour(f64::from(n) / 16.0);
        // Writing to a string cannot fail.
        let _ = write!(out, ",#{r:02x}{g:02x}{b:02x}");
    }
    out + ")"
}
