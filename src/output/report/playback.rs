//! The animation as the page carries it: a description in JSON, and numbers that were rounded, written as differences in time,
//! deflated and put into base64.
//!
//! Bytes, before deflating: reference positions of all nodes (x, y, z, each all low bytes, then all high bytes); still by
//! still the change of the displacements since the last one in the same way; still by still the change of the tensions
//! of all cells, warp, then weft, one byte each, 255 where the yarn is broken.

use std::io::Write;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde_json::{Value, json};

use super::super::surface::SurfaceMesh;
use super::animated_ply::AnimatedPly;
use super::animation::{Animation, Keyframe};
use super::colour;
use crate::case::{Case, Layer};

/// Characters of the base64 text at most.
const BUDGET: usize = 3_600_000;
/// Steps that the largest displacement is rounded to.
const STEPS: f64 = 8000.0;
/// Byte of a broken yarn; tensions go from 0 to the one below.
const BROKEN: u8 = 255;

/// What the page carries.
pub(super) struct Playback {
    /// Everything but the numbers.
    pub(super) description: Value,
    /// The numbers.
    pub(super) base64: String,
}

/// Packs a animation, with fewer pictures where it would be too large. `None` where there is nothing to show.
pub(super) fn pack(case: &Case, animation: &Animation) -> Option<Playback> {
    let mut animation = animation.clone();
    loop {
        if animation.keyframes.len() < 2 {
            return None;
        }
        let steps = Rounding::of(&animation);
        let base64 = BASE64_STANDARD.encode(deflated(&bytes(&animation, &steps)));
        if base64.len() <= BUDGET {
            return Some(Playback { description: describe(case, &animation, &steps), base64 });
        }
        animation = animation.with(animation.keyframes.len() * 3 / 4);
    }
}

/// What one step of a rounded number is worth.
struct Rounding {
    /// [m]
    reference: f64,
    /// [m]
    displacement: f64,
    /// [N]
    tension: f64,
}

impl Rounding {
    fn of(animation: &Animation) -> Self {
        let largest = |vectors: &mut dyn Iterator<Item = &[f32; 3]>| {
            let sizes = vectors.flatten().map(|x| f64::from(x.abs())).filter(|x| x.is_finite());
            sizes.fold(1e-9, f64::max)
        };
        let reference = largest(&mut animation.strips.iter().flat_map(|strip| &strip.reference));
        let displacement = largest(&mut animation.keyframes.iter().flat_map(|keyframe| &keyframe.displacement));
        Self {
            reference: reference / 32_000.0,
            displacement: displacement / STEPS,
            tension: f64::from(animation.peak_tension().max(1e-9)) / f64::from(BROKEN - 1),
        }
    }
}

fn bytes(animation: &Animation, steps: &Rounding) -> Vec<u8> {
    let mut out = Vec::new();
    let reference: Vec<[f32; 3]> = animation.strips.iter().flat_map(|strip| strip.reference.iter().copied()).collect();
    let whole = |x: f32, step: f64| (f64::from(x) / step).round().clamp(-32_767.0, 32_767.0) as i16;
    for axis in 0..3 {
        put_words(&mut out, reference.iter().map(|at| whole(at[axis], steps.reference)));
    }
    let mut last = vec![[0_i16; 3]; reference.len()];
    for keyframe in &animation.keyframes {
        let now: Vec<[i16; 3]> =
            keyframe.displacement.iter().map(|u| u.map(|x| whole(x, steps.displacement))).collect();
        for axis in 0..3 {
            put_words(&mut out, now.iter().zip(&last).map(|(now, last)| now[axis].wrapping_sub(last[axis])));
        }
        last = now;
    }
    let byte = |tension: Option<f32>| match tension {
        Some(tension) => (f64::from(tension) / steps.tension).round().clamp(0.0, f64::from(BROKEN - 1)) as u8,
        None => BROKEN,
    };
    let mut last = vec![[0_u8; 2]; animation.keyframes.first().map_or(0, |keyframe: &Keyframe| keyframe.tension.len())];
    for keyframe in &animation.keyframes {
        let now: Vec<[u8; 2]> = keyframe.tension.iter().map(|cell| cell.map(byte)).collect();
        for yarn in 0..2 {
            out.extend(now.iter().zip(&last).map(|(now, last)| now[yarn].wrapping_sub(last[yarn])));
        }
        last = now;
    }
    out
}

/// All low bytes, then all high ones.
fn put_words(out: &mut Vec<u8>, words: impl Iterator<Item = i16>) {
    let words: Vec<[u8; 2]> = words.map(i16::to_le_bytes).collect();
    for half in 0..2 {
        out.extend(words.iter().map(|word| word[half]));
    }
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(6));
    // Writing to memory cannot fail.
    encoder.write_all(bytes).and_then(|()| encoder.finish()).unwrap_or_default()
}

/// The projectile: points in whole steps [m], and corners of triangles.
fn body(surface: &SurfaceMesh) -> Value {
    let largest = surface.points.iter().flatten().fold(1e-9, |largest: f64, x| largest.max(x.abs()));
    let step = largest / 32_000.0;
    json!({
        "step": step,
        "points": surface.points.iter().flatten().map(|x| (x / step).round() as i64).collect::<Vec<_>>(),
        "triangles": surface.triangles().flatten().collect::<Vec<_>>(),
    })
}

fn describe(case: &Case, animation: &Animation, steps: &Rounding) -> Value {
    let layers = case.layers();
    let plies: Vec<&Layer> = layers.iter().flat_map(|layer| vec![layer; layer.plies as usize]).collect();
    let side = case.pack.crossovers_along_element();
    // Lines of nodes, counted in yarns: on a graded mesh they do not lie evenly.
    let yarns = |strip: &AnimatedPly, own: usize| -> Vec<f64> {
        let places = plies.get(strip.ply).map(|layer| layer.node_lines()[own].clone()).unwrap_or_default();
        strip.lines[own].iter().map(|line| places.get(*line).map_or(0.0, |place| place * side)).collect()
    };
    let strip = |strip: &AnimatedPly| {
        json!({
            "ply": strip.ply,
            "columns": yarns(strip, 0),
            "rows": yarns(strip, 1),
        })
    };
    json!({
        "times": animation.keyframes.iter().map(|keyframe| keyframe.time * 1e6).collect::<Vec<_>>(),
        "opening": animation.opening(),
        "deepest": 1e3 * animation.deflection(),
        "strips": animation.strips.iter().map(strip).collect::<Vec<_>>(),
        "mirror": animation.planes.0,
        "step": { "reference": steps.reference, "displacement": steps.displacement, "tension": steps.tension },
        "poses": animation.keyframes.iter().map(|keyframe| keyframe.pose).collect::<Option<Vec<_>>>(),
        "body": animation.body.as_ref().map(body),
        "colours": BASE64_STANDARD.encode(colour::table()),
    })
}

#[cfg(test)]
#[path = "playback_tests.rs"]
mod tests;
